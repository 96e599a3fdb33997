import hashlib
import os
import re
import subprocess
import sys

import pytest
from linkage_models import FOLDER, NAMES, program, system, system_of, text_of

from linkages.kernel.code.program import GENERATOR_VERSION, write_program
from linkages.kernel.model import Model
from linkages.kernel.scalars import Level, reachable

FREE_FOUR_BAR = """
gravity: [0, -9.81]
joints: {O: [0.1, 0.2], C: [1, 0.3]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  plate: {points: {A: [0, 0], B: [0.9, 0.1], E: [0.4, 0.5]}, mass: 1, center: [0.4, 0.2],
    inertia: 0.1}
  rocker: {joints: [C, B], length: 0.7, mass: 1, center: 0.3}
free: {crank: {angle: 1, speed: 1}}
assembly: {B: left}
"""


def text(definition):
    return program(system_of(definition)).text


def statements(text):
    return sum(" = " in line for line in text.splitlines())


def function(text, name):
    """The body of one of the three functions."""
    return text.split(f"def {name}(")[1].split("\n\n\ndef ")[0]


# --- the same topology is the same text ---------------------------------------------------------


def test_other_names_same_text():
    renamed = FREE_FOUR_BAR
    names = {"crank": "Kurbel-Ä 1", "plate": "mass", "rocker": "points", "E": "length"}
    for old, new in names.items():
        renamed = re.sub(rf"\b{old}\b(?=:)", new, renamed)
    assert renamed != FREE_FOUR_BAR
    assert text(renamed) == text(FREE_FOUR_BAR)


@pytest.mark.parametrize("name", ["inertia", "center", "size", "angle", "force", "through", "side"])
def test_names_that_read_like_keys_do_not_matter(name):
    assert text(FREE_FOUR_BAR.replace("plate:", f"{name}:")) == text(FREE_FOUR_BAR)


def test_nothing_of_the_file_is_in_the_text():
    odd = ["Kürbel", "bent-coupler", "the rocker", "Ωmega", "joint 7"]
    renamed = FREE_FOUR_BAR
    for old, new in zip(["crank", "plate", "rocker", "B", "E"], odd, strict=True):
        renamed = re.sub(rf"\b{old}\b", new, renamed)
    found = text(f"name: '{odd[0]}'\n{renamed}")
    assert not [name for name in odd if name in found]
    assert found.isascii()
    assert found == text(FREE_FOUR_BAR)


def test_other_numbers_same_text():
    changed = re.sub(r"0\.9\b", "0.95", FREE_FOUR_BAR.replace("length: 0.3", "length: 0.31"))
    changed = changed.replace("speed: 1", "speed: -4").replace("-9.81", "-1.62")
    assert changed.replace("B: left", "B: right") != FREE_FOUR_BAR
    assert text(changed) == text(FREE_FOUR_BAR)


def test_other_order_of_ground_joints_and_sections_same_text():
    lines = FREE_FOUR_BAR.replace("O: [0.1, 0.2], C: [1, 0.3]", "C: [1, 0.3], O: [0.1, 0.2]")
    assert text(lines) == text(FREE_FOUR_BAR)
    gravity, joints, *rest = FREE_FOUR_BAR.strip().splitlines()
    assert text("\n".join([*rest, joints, gravity])) == text(FREE_FOUR_BAR)


@pytest.mark.parametrize(
    ("name", "numbers"),
    [
        ("ninebar", {"clearances.r1.size": 1e-4, "drives.crank1.speed": -5, "bars.link2.mass": 9}),
        (
            "ninebar",
            {"clearances.r1.angle": 2, "clearances.r1.speed": -3, "drives.crank4.angle": 0},
        ),
        ("ninebar", {"drives.crank1.speed": 0}),
        ("doublependulum", {"bars.upper.length": 2, "free.lower.angle": 3, "bars.lower.mass": 7}),
        ("clearance", {"free.crank.speed": 0, "bars.coupler.inertia": 0.4}),
    ],
)
def test_a_sweep_does_not_change_the_text(name, numbers):
    assert program(system(name, **numbers)).text == program(system(name)).text


SCRIPT = """
import hashlib, sys
from pathlib import Path
from linkages.components.mechanisms.definition import load
from linkages.kernel.model import Model
from linkages.kernel.code.program import write_program
from linkages.kernel.system import System
for file in sorted(Path(sys.argv[1]).glob("*.yaml")):
    model = Model(System(load(file)).topology)
    text = write_program(model, model.free_accelerations).text
    print(file.stem, hashlib.sha256(text.encode()).hexdigest())
"""


def test_text_is_the_same_in_every_process():
    """Sets of texts are walked in an order that the interpreter draws anew each time."""
    outputs = {
        subprocess.run(
            [sys.executable, "-c", SCRIPT, str(FOLDER)],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for seed in ("1", "2", "77")
    }
    here = [hashlib.sha256(program(system(n)).text.encode()).hexdigest() for n in NAMES]
    expected = "".join(f"{n} {digest}\n" for n, digest in zip(NAMES, here, strict=True))
    assert outputs == {expected}


# --- structure is folded away -------------------------------------------------------------------


@pytest.mark.parametrize(
    "old_and_new",
    [
        ("gravity: [0, -9.81]", "gravity: [0, 0]"),
        ("mass: 1, center: 0.3", "mass: 0, center: 0.3"),
        ("B: [0.9, 0.1]", "B: [0.9, 0]"),
        ("center: [0.4, 0.2]", "center: [0, 0]"),
        ("O: [0.1, 0.2]", "O: [0, 0]"),
    ],
    ids=["gravity", "mass", "pin on the frame's axis", "centre", "ground at the origin"],
)
def test_a_structural_zero_makes_the_kernel_smaller(old_and_new):
    smaller, full = text(FREE_FOUR_BAR.replace(*old_and_new)), text(FREE_FOUR_BAR)
    assert smaller != full
    operations = [
        len(re.findall(r" [-+*/] ", t.split("\n\n\ndef ", 1)[1])) for t in (smaller, full)
    ]
    assert operations[0] < operations[1]


def test_no_gravity_section_is_the_same_as_zero_gravity():
    without = FREE_FOUR_BAR.replace("gravity: [0, -9.81]\n", "")
    assert text(without) == text(FREE_FOUR_BAR.replace("-9.81", "0"))


def test_a_massless_bar_leaves_its_inertia_to_be_given():
    """Zero mass and no inertia given: both are structure."""
    found = text(FREE_FOUR_BAR.replace("mass: 1, center: 0.3", "mass: 0"))
    assert "bars.#2.length" in found
    assert "bars.#2.mass" not in found
    assert "bars.#2.inertia" not in found


@pytest.mark.parametrize("angle", [0, 90, 180, 270, -90])
def test_axes_along_x_and_y_are_structure(angle):
    definition = text_of("slidercrank").replace("angle: 20 deg", f"angle: {angle} deg")
    definition = definition.replace("drives:", "free:")
    right = text(definition)
    assert "sliders.#0.angle" not in right
    assert "sliders.#0.angle" in text(definition.replace(f"angle: {angle} deg", "angle: 0.3"))


# --- parameters, time and state -----------------------------------------------------------------


def test_time_holds_all_of_the_cranks():
    """Nine-bar: the angles of both cranks are driven, so their sines belong to the clock."""
    written = program(system("ninebar"))
    clock, rates = (function(written.text, name) for name in ("clock", "rates"))
    assert len(re.findall(r"\b(?:sin|cos)\(", clock)) == 4
    assert len(re.findall(r"\b(?:sin|cos)\(", rates)) == 2  # of the clearance
    assert not re.search(r"\bt\b", rates)
    for name in ("joint2_x", "joint2_y", "joint2_vy", "joint5_x", "joint5_y", "joint5_vy"):
        assert f"    {name} = " in clock  # places and velocities of A and C, the cranks' ends
        assert f"    {name} = " not in rates


def test_parameters_are_prepared_once():
    written = program(system("ninebar"))
    assert not re.search(r"\b(t|y|timed)\b", function(written.text, "prepare").split('"""')[2])
    # squares of lengths and masses at joints are not computed for every state
    squares = re.findall(r"p\[(\d+)\] \* p\[\1\]", function(written.text, "rates"))
    assert not squares
    assert written.parameters[1] > 0


@pytest.mark.parametrize("name", NAMES)
def test_every_operation_is_done_once(name):
    written = program(system(name))
    groups = [{n.index for n in written.groups[level]} for level in Level]
    assert sum(map(len, groups)) == len(set().union(*groups))
    for level in Level:
        for node in written.groups[level]:
            assert node.level == level == max(o.level for o in node.operands)


@pytest.mark.parametrize("name", ["ninebar", "clearance", "doublependulum"])
def test_nothing_is_computed_that_is_not_needed(name):
    model = Model(system(name).topology)
    written = write_program(model, model.free_accelerations)
    wanted = [*model.free_accelerations, *model.margins, *model.margin_rates]
    wanted += [reach.radicand for reach in model.reaches]
    needed = {n.index for n in reachable(wanted) if n.operands}
    assert {n.index for level in Level for n in written.groups[level]} == needed


def test_version_of_the_generator_is_part_of_the_text():
    """A changed generator must never meet an old file in the cache."""
    assert f"(generator {GENERATOR_VERSION})" in program(system("pendulum")).text.splitlines()[0]


@pytest.mark.parametrize("name", NAMES)
def test_sizes(name):
    of = system(name)
    written = program(of)
    count, derived = written.parameters
    assert count == len(of.model.inputs.parameters)
    n, blocks = len(of.topology.free), len(of.topology.solved_blocks)
    sizes = {name: size for routine in written.routines for name, size in routine.arguments.items()}
    assert (sizes["p"], sizes["out"]) == (count + derived, n + 2 * blocks)
    assert function(written.text, "rates").count("out[") == n + 2 * blocks
    compile(written.text, name, "exec")


def test_a_label_stands_for_every_parameter():
    of = system("ninebar")
    head, *functions = program(of).text.split("\n\n\ndef ")
    described = of.model.inputs.describe()
    used = {int(index) for index in re.findall(r"\bp\[(\d+)\]", "".join(functions))}
    for index, line in enumerate(described):
        assert (f"    p[{index}] {line}\n" in head) == (index in used)
    assert len(set(described)) == len(described)
    assert "clearances.#0.size" in described


def test_statements_are_coarse():
    """People read programs: what belongs together is one statement."""
    assert statements(program(system("ninebar")).text) < 400
