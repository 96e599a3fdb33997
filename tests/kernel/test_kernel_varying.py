"""Numbers bound to a structure, against mechanisms that are read and assembled from the start."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.components.contributed.terms import Hint
from linkages.errors import InputError
from linkages.kernel.batch_assembly import BatchAssembler
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.reading.document import Document
from linkages.spec.units import UnitError, unit

NAMES = sorted(file.stem for file in (Path(__file__).parents[2] / "mechanisms").glob("*.yaml"))
FREE = """
gravity: [0, -9.81]
joints: {O: [0.1, 0.2], C: [1, 0.3]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  plate: {points: {A: [0, 0], B: [0.9, 0.1], E: [0.4, 0.5]}, mass: 1, center: [0.4, 0.2],
    inertia: 0.1}
  rocker: {joints: [C, B], length: 0.7, mass: 1, center: 0.3}
free: {crank: {angle: 1, speed: 1}}
assembly: {B: [0.9, 0.9]}
springs:
  - {between: [A, C], stiffness: 30, length: 0.2, damping: 0.1}
  - {bar: rocker, stiffness: 2, angle: 7, damping: 0.3}
loads: [{joint: E, force: [{harmonic: {amplitude: 2 N, frequency: 3 Hz}}, 1]}]
"""
"""Places of joints, whole turns of a spring, numbers that follow from others, a formula."""


def paths_of(mechanism):
    """Dotted paths of numbers of a definition, with values near theirs."""
    definition, found = mechanism.definition, {}

    def walk(path, node):
        if isinstance(node, dict):
            for key, value in node.items():
                walk(f"{path}.{key}" if path else str(key), value)
        elif isinstance(node, list):
            for index, value in enumerate(node):
                walk(f"{path}[{index}]", value)
        elif path.split(".")[0] not in ("name", "simulate"):
            found[path] = node

    assert isinstance(definition, Document)
    walk("", definition.content)
    return found


def same(one, other):
    """Whether two systems are equal in all bits."""
    assert one.mechanism == other.mechanism
    assert one.assembly == other.assembly
    assert one.time == other.time
    assert one.structure is other.structure
    for name in ("parameters", "state", "margin_scale"):
        assert (getattr(one, name) == getattr(other, name)).all(), name
    assert one.places().keys() == other.places().keys()
    assert all((one.places()[point] == place).all() for point, place in other.places().items())
    return True


def built(mechanism, overrides):
    return System(mechanism.with_values(overrides))


def outcome(make):
    """A system, or the words with which it is refused."""
    try:
        return make()
    except InputError as error:
        return [(problem.path, problem.message) for problem in error.problems]


def agree(found, expected):
    return found == expected if isinstance(expected, list) else same(found, expected)


@pytest.mark.slow_except("four-bar", "five-bar", "ninebar", "slider-crank-contact", "scotch-yoke")
@pytest.mark.parametrize("name", NAMES)
def test_every_number_of_a_definition_can_be_bound(name):
    """One at a time, each moved a little: by 2 %, or away from zero."""
    mechanism = linkages.load(name)
    varying = Varying(mechanism)
    varying.at({})
    tried = 0
    for path, written in paths_of(mechanism).items():
        try:
            value = 1.02 * float(str(written).split()[0])
        except ValueError:
            continue
        unit = str(written).partition(" ")[2]
        overrides = {path: f"{value!r} {unit}" if unit else value}
        expected = outcome(lambda given=overrides: built(mechanism, given))
        assert agree(outcome(lambda given=overrides: varying.at(given)), expected), path
        tried += 1
    assert tried > 3


TOGETHER = {
    "slider-crank": 11,
    "four-bar": 14,
    "ninebar": 28,
    "slider-crank-contact": 11,
    "andrews": 42,
}
"""Mechanism → numbers whose values are read together, at least."""


@pytest.mark.slow_except("four-bar", "ninebar", "slider-crank-contact")
@pytest.mark.parametrize("name", NAMES)
def test_numbers_that_are_read_together_are_those_read_one_by_one(name):
    """In all bits, whatever follows from them."""
    mechanism = linkages.load(name)
    varying = Varying(mechanism)
    varying.at({})
    if varying.base is None:
        pytest.skip("solved by iteration, or redundant: assembled one by one")
    together = 0
    for path, written in paths_of(mechanism).items():
        number, _, measured = str(written).partition(" ")
        try:
            value = unit(measured).convert(float(number)) if measured else float(number)
        except (ValueError, UnitError):
            continue
        points = [{path: 1e-3 * (k - 1) + (1.0 + 0.003 * k) * value} for k in range(9)]
        found = varying.along(points)
        together += varying._together(points, 3) is not None
        if found.settled is None:
            continue
        for index, column in enumerate(found.columns):
            if column is None or index % 3:
                continue
            alone = varying.along(points[index : index + 1])
            for array in ("parameters", "state", "margin_scale"):
                own = getattr(found.settled, array)[:, column]
                assert own.tobytes() == getattr(alone.settled, array)[:, 0].tobytes(), path
    assert together >= TOGETHER.get(name, 1)


@pytest.mark.parametrize("name", NAMES)
def test_decisions_of_many_at_once_are_those_of_one(name):
    """Assembling side by side against block by block, with its hints."""
    system = System(linkages.load(name))
    if not BatchAssembler.serves(system.model):
        pytest.skip("solved by iteration, or redundant: assembled one by one")
    assembler = BatchAssembler(system.model, system.mechanism.hints)
    hints = {t.joint: t for t in system.mechanism.terms if isinstance(t, Hint) and t.position}
    count = 5
    settled = assembler(
        np.repeat(system.numbers[:, None], count, axis=1),
        np.repeat(np.zeros_like(system.state)[:, None], count, axis=1)
        if not system.topology.free
        else np.repeat(given(system)[:, None], count, axis=1),
        0.0,
        {joint: np.array(hint.position) for joint, hint in hints.items()},
    )
    assert settled.sound.all()
    for column in range(count):
        assert assembler.assembly(settled, column) == system.assembly
        assert (settled.state[:, column] == system.state).all()
        assert (settled.parameters[:, column] == system.parameters).all()


def given(system):
    """Free coordinates and rates, zero for what is carried along."""
    state, carried = system.state.copy(), system.layout.carried_rows
    state[carried] = 0.0
    return state


def mechanism_of(text):
    return linkages.loads(text)


def test_numbers_that_follow_from_others_follow_them():
    mechanism = mechanism_of(FREE)
    varying = Varying(mechanism)
    along = varying.along([{"bars.crank.length": value} for value in np.linspace(0.28, 0.32, 9)])
    inertia = along.system(0).model.inputs.parameters["bars", "crank", "inertia"]
    found = [along.system(i).parameters[inertia] for i in range(9)]
    assert found == pytest.approx(np.linspace(0.28, 0.32, 9) ** 2 / 12, rel=1e-15)
    assert along.settled is not None
    assert along.columns == list(range(9))
    for i in range(9):
        assert same(along.system(i), built(mechanism, along.points[i]))


OVERRIDES = [
    {"bars.rocker.mass": 3.0, "bars.rocker.length": "71 cm"},
    {"assembly.B": [0.9, -0.3]},
    {"springs[1].angle": -9.5},
    {"springs.0.stiffness": 33},
    {"free.crank.angle": 1.2, "free.crank.speed": -2.0, "gravity[1]": -1.6},
    {"loads[0].force[0]": {"harmonic": {"amplitude": 3.0, "frequency": "4 Hz"}}},
    {"joints.C": [1.01, 0.28]},
    {"bars.plate.points.B[1]": 0.12},
    {"simulate.rtol": 1e-5},
    {"name": "another"},
    # other structures
    {"bars.rocker.mass": 0.0},
    {"springs[1].damping": 0.0},
    {"gravity": [0, 0]},
    {"bars.plate.points.B[1]": 0.0},
    {"assembly.B": "right"},
    {"loads[0].force[0]": "2*sin(3*t)"},
    {"loads": []},
    {"drives": {"crank": {"angle": 0.0, "speed": 1.0}}, "free": {}},
    # refused
    {"bars.rocker.length": 2.5},
    {"bars.rocker.length": -1.0},
    {"bars.rocker.lenght": 1.0},
    {"bars.rocker.joints": ["C", "C"]},
    {"springs[7].stiffness": 1.0},
    {"springs[0].length": 0.7, "joints.C": [0.26, 0.45]},
    {"assembly.B": [0.1, 0.2]},
]


@pytest.mark.parametrize("overrides", OVERRIDES, ids=str)
def test_any_override_gives_the_system_that_is_built_from_it(overrides):
    """With the same structure, another one, or the same words of refusal."""
    mechanism = mechanism_of(FREE)
    varying = Varying(mechanism)
    varying.at({})
    expected = outcome(lambda: built(mechanism, overrides))
    assert agree(outcome(lambda: varying.at(overrides)), expected)
    many = varying.along([{}, overrides, {"bars.crank.length": 0.31}, overrides])
    assert same(many.system(0), System(mechanism))
    for index in (1, 3):
        assert agree(outcome(lambda place=index: many.system(place)), expected)


def test_a_structure_that_changes_and_changes_back():
    mechanism = mechanism_of(FREE)
    varying = Varying(mechanism)
    values = [0.3, 0.0, 0.2, 0.0, 0.3]
    found = [varying.at({"springs[1].damping": value}) for value in values]
    assert [s.structure is found[0].structure for s in found] == [True, False, True, False, True]
    for value, system in zip(values, found, strict=True):
        assert same(system, built(mechanism, {"springs[1].damping": value}))


def test_what_is_varied_need_not_be_possible_itself():
    """A crank that cannot be assembled, unless the rod is longer."""
    mechanism = mechanism_of(FREE.replace("length: 0.7,", "length: 2.7,"))
    varying = Varying(mechanism)
    points = [{"bars.rocker.length": value} for value in (2.6, 0.7, 0.72, 2.5, 0.71)]
    along = varying.along(points)
    for index, point in enumerate(points):
        expected = outcome(lambda given=point: built(mechanism, given))
        assert agree(outcome(lambda place=index: along.system(place)), expected)
    assert [column is None for column in along.columns] == [True, False, False, True, False]


def test_numbers_do_not_depend_on_what_was_asked_before_or_by_whom():
    mechanism = mechanism_of(FREE)
    points = [{"bars.crank.length": v, "springs[0].length": 0.1 + v} for v in (0.28, 0.3, 0.32)]
    alone = [Varying(mechanism).at(point) for point in points]
    varying = Varying(mechanism)
    with ThreadPoolExecutor(4) as pool:
        shared = list(pool.map(varying.at, points * 8))
    for index, system in enumerate(shared):
        assert same(system, alone[index % 3])
    again = pickle.loads(pickle.dumps(varying))
    assert same(again.at(points[1]), alone[1])


def test_mechanisms_made_in_python_can_be_varied():
    read = mechanism_of(FREE)
    made = linkages.Mechanism(components=read.components, name=read.name)
    varying = Varying(made.with_state({"crank": (1.1, 2.0)}))
    for overrides in ({"bars.crank.length": 0.31}, {"springs[1].stiffness": 3.0}, {}):
        assert same(varying.at(overrides), built(varying.mechanism, overrides))


def test_free_coordinates_that_are_chosen_are_chosen_anew():
    """Which one is best conditioned depends on the numbers."""
    text = FREE.replace("free: {crank: {angle: 1, speed: 1}}\n", "").replace(
        "assembly: {B: [0.9, 0.9]}", "assembly: {A: [0.26, 0.45], B: [0.9, 0.9]}"
    )
    mechanism = mechanism_of(text)
    varying = Varying(mechanism)
    for value in (0.3, 0.69):
        overrides = {"bars.rocker.length": value}
        expected = outcome(lambda given=overrides: built(mechanism, given))
        assert agree(outcome(lambda given=overrides: varying.at(given)), expected)


TWO_BLOCKS = """
joints: {O: [0, 0]}
sliders:
  block: {joint: B, through: O, angle: 0, mass: 1 kg}
  other: {joint: C, on: block, mass: 0.5}
springs: [{slider: block, stiffness: 1 N/m, position: 0, damping: 0.1}]
stops:
  - {slider: block, lower: 0, upper: 1 m, restitution: 0.8}
  - {slider: other, lower: -0.1, upper: 0.2, restitution: 0.3}
friction: [{slider: block, force: 0.2 N}]
free: {block: {position: POSITION, speed: SPEED}, other: {position: -0.1, speed: OTHER}}
loads: [{slider: block, force: 0.3*cos(2*t)}]
"""


@pytest.mark.parametrize("position", ["0", "0.5", "1"])
@pytest.mark.parametrize("speed", ["-1", "0", "1"])
@pytest.mark.parametrize("other", ["-1", "0", "0.5"])
def test_modes_that_are_found_together_are_those_found_one_by_one(position, speed, other):
    """Also where functions are zero at the start: on a stop, or at rest with friction."""
    text = TWO_BLOCKS.replace("POSITION", position).replace("SPEED", speed)
    mechanism = linkages.loads(text.replace("OTHER", other))
    for path, values in {
        "sliders.block.mass": (0.5, 1.0, 2.0),
        "free.block.speed": (-1.0, 0.0, 2.0),
    }.items():
        points = [{path: value} for value in values]
        along = Varying(mechanism).along(points)
        for index, point in enumerate(points):
            alone = System(mechanism.with_values(point)).starting_held()
            np.testing.assert_array_equal(along.system(index).starting_held(), alone)


SHARED = """
joints: {O: [0, 0]}
sliders: {cart: {joint: P, through: O, mass: 20}}
parameters: {goal: 0.2}
controllers: {hold: {slider: cart, of: cart.position, setpoint: goal*cos(t), proportional: 30}}
free: {cart: {position: 0.05, speed: 0}}
"""


@pytest.mark.parametrize("order", [1, -1])
def test_a_shared_number_is_changed_beside_what_uses_it(order):
    """In whatever order both are given."""
    mechanism = linkages.loads(SHARED)
    values = {"parameters.goal": 0.3, "controllers.hold.proportional": 40.0}
    values = dict([*values.items()][::order])
    varying = Varying(mechanism)
    varying.at({})
    found = varying.at(values).parameters
    assert found.tolist() == System(mechanism.with_values(values)).parameters.tolist()
