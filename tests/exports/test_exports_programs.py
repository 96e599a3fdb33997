"""C by gcc and Python in a clean namespace, against NumPy and `linkages.simulate`."""

import csv
import ctypes
import json
import os
import re
import shutil
import subprocess
import sys
from runpy import run_path
from xml.etree import ElementTree

import numpy as np
import pytest
from exported_states import (
    CHANGES,
    NAMES,
    PARALLELOGRAM,
    PASSING,
    SCENES,
    STIFF,
    STUCK,
    SWITCHED,
    assert_near,
    cases,
    changes,
    compared_parameters,
    followed_rows,
    kernel,
    switched,
    system,
)

import linkages
from linkages.exports import Subject, files_of
from linkages.exports.writers.source_code import c_files, javascript_module, python_module
from linkages.exports.writers.traced_loops import PARTS
from linkages.kernel.system import System

STRICT = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic"]
SOME = ["andrews", "class-three", "five-bar", "ninebar", "slider-crank-contact", *SCENES]
"""Several coordinates, iterated groups, infinite outputs, welds, clearances, modes."""

needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc on the PATH")
Doubles = ctypes.POINTER(ctypes.c_double)


def in_c(name, stem):
    return c_files(system(name), stem, system(name).mechanism.simulation)


def in_python(of):
    return python_module(of, of.mechanism.simulation)


def groups(name):
    return [quantity.variable for quantity in kernel(name).quantities]


def write(files, folder):
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(NAMES) - set(SOME)))
def test_c_is_strict_c99(name, tmp_path):
    write(in_c(name, name), tmp_path)
    subprocess.run([*STRICT, "-fsyntax-only", f"{name}.c"], cwd=tmp_path, check=True)


@pytest.fixture(scope="module", params=SOME)
def library(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    write(in_c(request.param, "model"), folder)
    options = ["-O0", "-ffp-contract=off", "-DMODEL_WITHOUT_MAIN", "-shared", "-fPIC"]
    command = [*STRICT, *options, "model.c", "-o", "model.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return request.param, ctypes.CDLL(str(folder / "model.so"))


def called(function, *arguments):
    """The status of a function of C; numbers go by value, arrays by address."""
    given = [
        ctypes.c_double(a) if isinstance(a, float) else a.ctypes.data_as(Doubles) for a in arguments
    ]
    return function(*given)


@pytest.mark.slow_except("bounce", "ninebar")
@needs_gcc
def test_c_equals_numpy(library):
    name, code = library
    p, y = np.zeros(len(kernel(name).p) + 1), np.zeros(len(kernel(name).state) + 1)
    numbers = np.array([number.value for number in kernel(name).feed.numbers])
    assert called(code.model_start, numbers, p, y) == 0
    for case in cases(name):
        own = np.array([*case.state, 0.0])
        rates, outputs = np.zeros(len(own)), np.zeros(len(case.outputs))
        assert called(code.model_settle, case.time, own, p) == 0
        assert called(code.model_rates, case.time, own, p, rates) == 0
        assert called(code.model_outputs, case.time, own, p, outputs) == 0
        assert_near(rates[:-1], case.rates)
        assert_near(outputs, case.outputs, groups(name))


@pytest.mark.slow_except("bounce", "ninebar")
@needs_gcc
def test_c_follows_numbers_of_the_file(library):
    name, code = library
    rows = compared_parameters(name)
    for numbers, parameters, state in changes(name):
        p, y = np.zeros(len(kernel(name).p) + 1), np.zeros(len(state) + 1)
        assert called(code.model_start, np.array(numbers), p, y) == 0
        np.testing.assert_allclose(p[rows], parameters[rows], rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(y[:-1], state, rtol=1e-12, atol=1e-14)


PRINTED = ("joint_position", "bar_angle", "bar_speed", "drive_effort")


def simulated(name, end, samples, **values):
    """Columns of `PRINTED` by name, of a motion by this package."""
    mechanism = system(name).mechanism.with_values(values)
    data = linkages.simulate(
        mechanism, end=end, samples=samples, rtol=1e-12, outputs=PRINTED
    ).data  # fmt: skip
    columns = np.hstack([data[v].values.reshape(samples, -1) for v in PRINTED])
    variables = [q.name for v in PRINTED for q in kernel(name).quantities if q.variable == v]
    return dict(zip(variables, columns.T, strict=True))


def assert_printed(text, expected):
    """Columns of a table are those of a motion; whole turns of dependent angles are not counted."""
    heading, *rows = csv.reader(text.splitlines())
    table = dict(zip(heading, np.array(rows, dtype=float).T, strict=True))
    for name, values in expected.items():
        difference = table[name] - values
        if name.endswith(".angle"):
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        assert np.abs(difference).max() < 1e-9 * max(1.0, np.abs(values).max()), name


@pytest.fixture(scope="module")
def program(tmp_path_factory):
    """Compiles a mechanism as a user would, and runs it."""
    folder = tmp_path_factory.mktemp("programs")

    def run(name, *arguments):
        if not (folder / name).exists():
            write(in_c(name, name), folder)
            subprocess.run([*STRICT, "-O1", f"{name}.c", "-o", name, "-lm"], cwd=folder, check=True)
        command = [folder / name, *arguments]
        return subprocess.run(command, capture_output=True, text=True, encoding="utf-8")

    return run


@pytest.mark.slow_except("rk4")
@needs_gcc
@pytest.mark.parametrize(
    ("end", "method"),
    [(2.0, ("--rtol", "1e-12", "--atol", "1e-14")), (0.5, ("--method", "rk4", "--step", "5e-6"))],
    ids=["dop853", "rk4"],
)
def test_a_program_in_c_prints_the_motion_of_simulate(end, method, program):
    """Steps of rk4 are so short that its error is a few per cent of what is allowed."""
    done = program("ninebar", "--end", str(end), "--samples", "21", *method)
    assert done.returncode == 0, done.stderr
    expected = simulated("ninebar", end, 21)
    del expected["crank1.effort"], expected["crank4.effort"]  # 1e4 times as sensitive
    assert_printed(done.stdout, expected)


@pytest.mark.slow_except("four-bar")
@needs_gcc
@pytest.mark.parametrize("name", ["four-bar", "class-three"])
def test_a_driven_mechanism_in_c_prints_positions_speeds_and_efforts(name, program):
    done = program(name, "--end", "1", "--samples", "11")
    assert_printed(done.stdout, simulated(name, 1.0, 11))


@needs_gcc
def test_a_program_in_c_takes_numbers_and_says_what_is_wrong(program):
    done = program("four-bar", "--samples", "5", "bars.crank.length=0.045")
    expected = simulated("four-bar", 1.0, 5, **{"bars.crank.length": 0.045})
    assert_printed(done.stdout, expected)
    far = program("four-bar", "bars.crank.length=3")
    assert far.returncode == 1
    assert "cannot be assembled: joint B" in far.stderr
    wrong = program("four-bar", "bars.crank.lenght=3")
    assert wrong.returncode == 2
    assert "bars.crank.length=" in wrong.stderr


@pytest.mark.slow_except("bounce", "stick")
@needs_gcc
@pytest.mark.parametrize("name", [*SWITCHED, *PASSING])
def test_contacts_and_friction_in_c_are_those_of_simulate(name, program):
    times, expected = switched(name)
    options = [
        "--end",
        str(times[-1]),
        "--samples",
        "31",
        "--rtol",
        "1e-12",
        "--atol",
        "1e-14",
    ]
    done = program(name, *options)
    assert done.returncode == 0, done.stderr
    table = np.array([*csv.reader(done.stdout.splitlines())][1:], dtype=float)[:, 1:]
    np.testing.assert_allclose(table[:, followed_rows(name)], expected, rtol=0, atol=1e-9)


# --- Python ---


def run_module(text, folder):
    """The names of a module in a namespace of its own."""
    (folder / "alone.py").write_text(text, encoding="utf-8")
    return run_path(str(folder / "alone.py"))


@pytest.fixture(scope="module")
def module(tmp_path_factory):
    """A module in a namespace of its own."""
    folder = tmp_path_factory.mktemp("modules")
    known = {}

    def load(name):
        if name not in known:
            write(
                {f"{name}.py": in_python(system(name))},
                folder,
            )
            known[name] = folder / f"{name}.py", run_path(str(folder / f"{name}.py"))
        return known[name]

    return load


@needs_gcc
def test_a_stick_falls_on_two_stiff_points_until_it_rests(tmp_path):
    """As in `simulate` until its impacts have made 1e-10 of 1e-14; then its energy falls, to
    -3/5 Σ N (N/k)^(2/3) where both points carry it; 1e-8 J of it are left by then."""
    mechanism = linkages.loads(STIFF)
    write(c_files(System(mechanism), "stick", mechanism.simulation), tmp_path)
    subprocess.run([*STRICT, "-O1", "stick.c", "-o", "stick", "-lm"], cwd=tmp_path, check=True)
    command = ["./stick", "--end", "3", "--samples", "61", "--rtol", "1e-12", "--atol", "1e-14"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    names, *rows = csv.reader(done.stdout.splitlines())
    found = dict(zip(names, np.array(rows, dtype=float).T, strict=True))
    outputs = ["slider_position", "bar_angle"]
    early = found["time"][found["time"] < 0.72]
    data = linkages.simulate(mechanism, times=early, rtol=1e-12, outputs=outputs).data
    for name, expected in (
        ("y.position", data.slider_position.sel(slider="y")),
        ("stick.angle", data.bar_angle.sel(bar="stick")),
    ):
        np.testing.assert_allclose(found[name][: len(early)], expected, rtol=0, atol=1e-9)
    energy = found["kinetic_energy"] + found["potential_energy"]
    assert (np.diff(energy) <= 1e-9).all()
    pressing = 2 * 9.81 * np.array([0.75, 0.25])
    assert energy[-1] == pytest.approx(-0.6e-6 * (pressing ** (5 / 3)).sum(), abs=1e-8)


@pytest.mark.slow_except("five-bar", "four-bar", "bounce", "rub", "tables", "slider-crank-contact")
@pytest.mark.parametrize("name", NAMES)
def test_python_equals_numpy(name, module):
    _, found = module(name)
    p, _ = found["start"]()
    for case in cases(name):
        state = found["settled"](case.time, case.state, p)
        assert_near(state, case.state)
        assert_near(found["rates"](case.time, state, p), case.rates)
        assert_near(found["outputs"](case.time, state, p), case.outputs, groups(name))


@pytest.mark.parametrize("name", ["class-three", "ninebar"])
def test_python_follows_numbers_of_the_file(name, module):
    _, found = module(name)
    rows = compared_parameters(name)
    for numbers, parameters, state in changes(name):
        p, y = found["start"](**dict(zip(found["NUMBERS"], numbers, strict=True)))
        np.testing.assert_allclose(p[rows], parameters[rows], rtol=1e-14, atol=1e-15)
        np.testing.assert_allclose(y, state, rtol=1e-12, atol=1e-14)


def test_a_python_module_runs_without_this_package(module):
    """With no path to this package, in another process."""
    file, _ = module("four-bar")
    alone = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    command = [sys.executable, "-c", BARE, str(file), "--end", "1", "--samples", "5"]
    done = subprocess.run(command, env=alone, cwd=file.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert_printed(done.stdout, simulated("four-bar", 1.0, 5))


BARE = """
import runpy, sys
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
assert not any(name.split(".")[0] == "linkages" for name in sys.modules)
"""


@pytest.mark.slow_except("bounce", "rub", "free", "driven")
@pytest.mark.parametrize("name", [*SWITCHED, *PASSING])
def test_contacts_and_friction_in_python_are_those_of_simulate(name, module):
    _, found = module(name)
    times, expected = switched(name)
    rows, values = followed_rows(name), []
    p, y = found["start"]()
    found["integrate"](
        times, p, y, 1e-12, 1e-14,
        visit=lambda t, state: values.append(found["outputs"](t, state, p)[rows]),
    )  # fmt: skip
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-9)


def test_programs_have_the_step_loop_of_this_package(module):
    """All of its parts, in each language; loops, conditions and inner functions of one of them: of
    (0.3 - x)(2 - x)(x + 1), and of a cubic with the rate 3 (x - 0.4)(x + 1)."""
    _, found = module("rub")
    texts = [in_c("rub", "rub")["rub.c"], javascript_module(system("rub"))]
    for name in " ".join(names for _, names in PARTS).split():
        assert callable(found[name])
        assert all(f"{name}(" in text for text in texts)
    assert found["first_zero"](0.6, -1.7, -1.4, -1.3) == pytest.approx(0.3, abs=2**-49)
    assert found["least_place"](0.0, -1.2, 0.7, 3.6) == pytest.approx(0.4, abs=2**-29)
    assert found["meeting"](1.0, -4.0, 2.0, 4.0) == -0.5
    assert found["passes_zero"](1.0, -2.0, 1.0, 2.0)
    assert not found["passes_zero"](1.0, -0.5, 1.0, 0.5)


def test_programs_show_the_force_that_holds_where_friction_sticks(module):
    """At rest it is what the spring of 50 N/m pulls with."""
    _, found = module("rub")
    p, y = found["start"]()
    (state,) = found["integrate"]([0.0, 3.0], p, y)[1:]
    known = dict(zip(found["NAMES"], found["outputs"](3.0, state, p), strict=True))
    assert known["block.velocity"] == pytest.approx(0.0, abs=1e-9)
    assert abs(known["block.position"]) > 0.001
    assert known["loads[0].force"] == pytest.approx(50 * known["block.position"], rel=1e-12)


def test_python_integrates_the_double_pendulum(module):
    """Both by the adaptive method and by equal steps of order 4: 0.1 ms⁴ is far below 1e-9."""
    _, found = module("double-pendulum")
    times = np.linspace(0.0, 0.5, 6)
    p, y = found["start"]()
    states = found["integrate"](times, p, y, rtol=1e-12, atol=1e-12)
    steps = found["integrate"](times, p, y, method="rk4", step=1e-4)
    data = linkages.simulate(
        system("double-pendulum").mechanism, times=times, rtol=1e-12, outputs=["bar_angle"]
    ).data
    np.testing.assert_allclose(states[:, :2], data.bar_angle.values, rtol=0, atol=1e-9)
    np.testing.assert_allclose(steps, states, rtol=0, atol=1e-9)


STRANGE = r"""
name: 'A */ </script> "\"" \ ??/ %s "Ärm" of 5 µm'
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {"große Stange": {joints: [O, "P ü"], length: 1, mass: 1}}
free: {"große Stange": {angle: 0.3, speed: 0}}
"""


@pytest.mark.parametrize("to", ["c", "python", "javascript", "mjcf"])
def test_files_say_where_they_come_from_whatever_names_are(to, tmp_path):
    """Names hold ends of comments of all languages; each file is a definition file, too."""
    mechanism = linkages.loads(STRANGE.replace("µm'", "µm --> */ --'"))
    for file in linkages.export(mechanism, to, tmp_path, name="strange"):
        again = linkages.load(file)
        assert again.name == mechanism.name
        assert System(again).parameters.tolist() == System(mechanism).parameters.tolist()
        if to == "python":
            run_path(str(file))
        if to == "mjcf":
            ElementTree.parse(file)
    assert linkages.export(mechanism, to, tmp_path, name="strange")  # its own may be replaced
    file.write_text("mine", encoding="utf-8")
    with pytest.raises(FileExistsError, match="strange"):
        linkages.export(mechanism, to, tmp_path, name="strange")
    assert file.read_text(encoding="utf-8") == "mine"
    if to == "c" and shutil.which("gcc") is not None:
        own = tmp_path / "own"
        linkages.export(mechanism, to, own, name="strange")
        subprocess.run([*STRICT, "-fsyntax-only", "strange.c"], cwd=own, check=True)


def test_names_of_a_definition_cannot_disturb_programs(tmp_path):
    """Comments, texts and formats of a language may stand in names; they come out as they are."""
    of = System(linkages.loads(STRANGE))
    found = run_module(in_python(of), tmp_path)
    assert found["COORDINATES"] == ["große Stange"]
    text = javascript_module(of)
    assert "</script>" not in text
    assert json.dumps(of.mechanism.name).replace("<", "\\u003c") in text
    if shutil.which("gcc") is None:
        return
    write(c_files(of, "5 odd-names", of.mechanism.simulation), tmp_path)
    compiled = [*STRICT, "5 odd-names.c", "-o", "odd", "-lm"]
    subprocess.run(compiled, cwd=tmp_path, check=True)
    command = [tmp_path / "odd", "--samples", "2"]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=True)
    assert done.stdout.startswith("time,große Stange.angle,")


def test_formats_are_found_and_take_the_options_of_the_motion(tmp_path):
    mechanism = linkages.load("four-bar")
    names = {
        to: [file.name for file in linkages.export(mechanism, to, tmp_path, name="bar")]
        for to in ("c", "python", "javascript", "mjcf")
    }
    assert names == {
        "c": ["bar.h", "bar.c"], "python": ["bar.py"], "javascript": ["bar.js"],
        "mjcf": ["bar.xml"],
    }  # fmt: skip
    subject = Subject(mechanism, "bar", None, {"end": 0.25, "samples": 7})
    (text,) = files_of(subject, "python", {}).values()
    assert "END, SAMPLES = 0.25, 7" in text


@pytest.mark.slow
def test_programs_end_at_change_points(tmp_path):
    """Between two samples, with the joint; where the margin is 1e-5 its time is known to 1e-5."""
    of = System(linkages.loads(PARALLELOGRAM))
    found = run_module(in_python(of), tmp_path)
    with pytest.raises(ArithmeticError, match=r"joint B.*singular") as refusal:
        found["integrate"](np.linspace(0.0, 0.4, 4), *found["start"]())
    (time,) = re.findall(r"t = ([\d.]+) s", str(refusal.value))
    assert float(time) == pytest.approx(CHANGES, abs=1e-5)
    if shutil.which("gcc") is None:
        return
    write(c_files(of, "p", of.mechanism.simulation), tmp_path)
    subprocess.run([*STRICT, "p.c", "-o", "p", "-lm"], cwd=tmp_path, check=True)
    done = subprocess.run([tmp_path / "p"], capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 1
    assert "singular" in done.stderr
    (time,) = re.findall(r"t = ([\d.]+) s", done.stderr)
    assert float(time) == pytest.approx(CHANGES, abs=1e-5)
    assert len(done.stdout.splitlines()) == 3  # the heading, and two times before


@pytest.mark.slow
def test_programs_name_the_joint_of_a_dead_centre(tmp_path):
    """`simulate` exchanges coordinates there; a program keeps to its own, and says so."""
    of = System(linkages.loads(STUCK))
    found = run_module(in_python(of), tmp_path)
    with pytest.raises(ArithmeticError, match=r"joint A, block 0 .*programs keep to theirs"):
        found["integrate"]([0.0, 1.0], *found["start"](), 1e-6, 1e-6)


@pytest.mark.slow_except("rub")
@needs_gcc
@pytest.mark.parametrize("name", ["bounce", "rub"])
def test_equal_steps_in_c_follow_contacts(name, program):
    """Changes are located on cubics, which are of order 4, as the steps are."""
    times, expected = switched(name)
    options = ["--end", str(times[-1]), "--samples", "31", "--method", "rk4", "--step", "1e-3"]
    done = program(name, *options)
    assert done.returncode == 0, done.stderr
    table = np.array([*csv.reader(done.stdout.splitlines())][1:], dtype=float)[:, 1:]
    np.testing.assert_allclose(table[:, followed_rows(name)], expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("samples", [3, 1001])
def test_drives_lead_through_change_points_however_close_samples_are(samples, module):
    """Near them positions are closed forms of angles in line: half of the digits are left."""
    _, found = module("driven")
    times = np.linspace(0.0, 0.8, samples)
    p, y = found["start"]()
    rows = [found["NAMES"].index(f"B.{axis} position") for axis in "xy"]
    values = []
    found["integrate"](
        times, p, y, visit=lambda t, state: values.append(found["outputs"](t, state, p)[rows])
    )
    angle = np.pi / 3 - 6 * times  # bars a and c stay parallel
    expected = np.stack([1 + 0.5 * np.cos(angle), 0.5 * np.sin(angle)], axis=1)
    np.testing.assert_allclose(values, expected, rtol=0, atol=1e-8)


@pytest.mark.slow
def test_driven_iterated_groups_end_as_simulate_does(tmp_path):
    """With the same sentence: time, joint, group. Both bisect on the time, to 1e-9 and better."""
    mechanism = system("class-three").mechanism.with_values({"bars.crank.length": 0.16})
    found = run_module(in_python(System(mechanism)), tmp_path)
    with pytest.raises(linkages.ComputationError) as expected:
        linkages.simulate(mechanism, end=0.1, samples=11)
    with pytest.raises(ArithmeticError) as refusal:
        found["integrate"](np.linspace(0.0, 0.1, 11), *found["start"](), 1e-8, 1e-8)
    here, there = (re.split(r"at t = ([\d.]+) s, ", str(e.value)) for e in (refusal, expected))
    assert float(here[1]) == pytest.approx(float(there[1]), abs=1e-8)
    assert here[2] == there[2]
