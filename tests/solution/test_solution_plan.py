"""Plans: one for all mechanisms of a structure, with numbers bound to it."""

import os
import pickle
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import linkages
from linkages.errors import InputError
from linkages.kernel.inputs import structure_key
from linkages.kernel.layout import Layout
from linkages.kernel.system import System
from linkages.solution.plan import Plan, kernel_source
from linkages.solvers.integration import integrate
from linkages.solvers.trajectory import Event

WINDER = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  coupler: {joints: [A, B], length: 0.9, mass: 0.5}
  rocker: {joints: [C, B], length: 0.8, mass: 1}
  wheel: {joints: [C, W], length: 0.1, mass: 0.2}
free: {crank: {angle: 1, speed: 3}}
assembly: {B: left}
gears: [{bars: [rocker, wheel], ratio: -2}]
springs: [{bar: wheel, stiffness: 0.3, angle: 1, damping: 0.1}]
dampers: [{joint: O, damping: 0.05}]
"""
"""An angle that is carried along, whole turns, damping."""

SLIDER = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3, mass: 1}, rod: {joints: [A, B], length: 0.8, mass: 1}}
sliders: {piston: {joint: B, through: O, angle: 20 deg, mass: 1}}
free: {crank: {angle: 1, speed: 3}}
"""


def mechanism(text=WINDER, **values):
    found = linkages.loads(text)
    return found.with_values({path.replace("__", "."): v for path, v in values.items()})


def final(system, plan, end=0.3):
    """Motion at the end, in all bits."""
    vector = plan.layout.packed(system.state)
    return integrate(plan.bind(system), vector, [0.0, end], rtol=1e-9).final_state


# --- one plan for a structure -------------------------------------------------------------------


@pytest.mark.parametrize(
    "options", [{}, {"work": True}, {"tangents": 2}, {"counting": True, "tangents": 1}], ids=str
)
def test_mechanisms_of_one_structure_have_one_plan(options):
    plan = Plan.of(mechanism(), **options)
    other = Plan.of(mechanism(bars__rocker__length=0.82, gravity=[0, -1.6]), **options)
    assert other is plan
    assert plan == pickle.loads(pickle.dumps(plan))
    assert hash(plan) == hash(pickle.loads(pickle.dumps(plan)))
    assert len({plan, other, Plan.of(mechanism())}) == (1 if not options else 2)


def test_another_structure_has_another_plan():
    plans = {
        Plan.of(mechanism()),
        Plan.of(mechanism(gravity=[0, 0])),
        Plan.of(mechanism(bars__coupler__mass=0)),
        Plan.of(mechanism(WINDER.replace("ratio: -2", "ratio: 1"))),
        Plan.of(mechanism(WINDER.replace("damping: 0.05", "damping: 0"))),
        Plan.of(mechanism(WINDER.replace("crank", "handle"))),
        Plan.of(mechanism(WINDER.replace("[O, A]", "[A, O]"))),
        Plan.of(mechanism(SLIDER)),
        Plan.of(mechanism(SLIDER.replace("20 deg", "90 deg"))),
        Plan.of(mechanism(SLIDER.replace("20 deg", "180 deg"))),
    }
    assert len(plans) == 10
    assert len({plan.key for plan in plans}) == 10


def test_the_key_of_a_structure_holds_no_number():
    """Lengths and masses that happen to be 1, 0.5 or a right angle are no structure."""
    plain, odd = mechanism(), mechanism(bars__crank__length=0.29, bars__rocker__mass=np.pi / 2)
    assert structure_key(plain.terms) == structure_key(odd.terms)
    numbers = Plan.of(plain).numbers(odd)
    assert dict(zip(Plan.of(plain).layout.parameters, numbers, strict=True))[
        "bars", "rocker", "mass"
    ] == pytest.approx(np.pi / 2, rel=0)


def test_a_kernel_is_never_bound_to_another_structure():
    plan, other = Plan.of(mechanism()), System(mechanism(gravity=[0, 0]))
    with pytest.raises(ValueError, match="another structure"):
        plan.bind(other)


@pytest.mark.parametrize(
    ("text", "path", "values"),
    [
        (WINDER, "dampers[0].damping", [0.1, 0.0, 0.2, 0.0]),
        (WINDER, "gears[0].ratio", [-2.0, 1.0, 0.5, 1.0]),
        (WINDER, "bars.coupler.mass", [0.4, 0.0, 1.0]),
        (SLIDER, "sliders.piston.angle", [0.2, 0.0, np.pi / 2, 0.3]),
        (SLIDER, "gravity", [[0, 1], [0, 0], [1, 0], [0, 2]]),
    ],
    ids=["damping", "ratio", "mass", "angle", "gravity"],
)
def test_structural_values_come_and_go(text, path, values):
    """Each flow is that of a mechanism which was defined so, to the last bit."""
    for value in values:
        system = System(mechanism(text).with_values({path: value}))
        source = kernel_source(system.topology)
        plan = Plan.of(system)
        assert plan.program.assembly == source.program.assembly
        assert plan.layout.parameters == tuple(source.model.inputs.parameters)
        flow = plan.bind(system)
        assert (flow.parameters[: len(system.parameters)] == system.parameters).all()


def test_layout_and_numbers():
    system = System(mechanism())
    plan = Plan.of(system, work=True, tangents=2)
    expected = Layout.of(system.topology, work=True, tangents=2)
    assert (plan.layout.free, plan.layout.carried) == (("crank",), ("rocker",))
    assert plan.layout.size == expected.size == plan.bind(system).coordinates == 5
    named = dict(zip(plan.layout.parameters, plan.numbers(system.mechanism), strict=True))
    assert named["bars", "rocker", "inertia"] == pytest.approx(0.8**2 / 12, rel=1e-15)
    assert named["gears", 0, "ratio"] == -2.0
    assert plan.layout.parameters == Plan.of(system).layout.parameters


def test_numbers_along_a_path():
    base = mechanism()
    plan, lengths = Plan.of(base), np.linspace(0.78, 0.84, 7)
    found = plan.numbers_along(base, {"bars.rocker.length": lengths})
    assert found.shape == (7, len(plan.layout.parameters))
    for row, length in zip(found, lengths, strict=True):
        assert (row == System(mechanism(bars__rocker__length=length)).parameters).all()
    with pytest.raises(ValueError, match="another structure"):
        plan.numbers_along(base, {"dampers[0].damping": [0.1, 0.0]})
    with pytest.raises(InputError, match="cannot meet"):
        plan.numbers_along(base, {"bars.rocker.length": [0.8, 3.0]})


# --- processes ----------------------------------------------------------------------------------


def _moved(plan, length):
    """What another process computes with a plan that it was sent."""
    system = System(mechanism(bars__rocker__length=length))
    return plan, plan == Plan.of(system), final(system, plan)


@pytest.mark.slow
def test_plans_can_be_sent_to_other_processes():
    plan = Plan.of(mechanism())
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        returned, equal, state = pool.submit(_moved, plan, 0.81).result()
    assert equal
    assert returned == plan
    assert (state == final(System(mechanism(bars__rocker__length=0.81)), plan)).all()


SCRIPT = """
import pickle, sys
from linkages.kernel.system import System
import linkages
plan = pickle.load(sys.stdin.buffer)
plan.bind(System(linkages.loads(sys.argv[1])))
"""


@pytest.mark.slow
def test_a_plan_finds_its_kernel_in_the_cache(tmp_path):
    """Another process writes no file: text and name are the same."""
    plan = pickle.dumps(Plan.of(mechanism()))
    kept = []
    for _ in range(2):
        subprocess.run(
            [sys.executable, "-c", SCRIPT, WINDER],
            input=plan,
            env=os.environ | {"LINKAGES_CACHE_DIR": str(tmp_path)},
            check=True,
            timeout=300,
        )
        kept.append(sorted((path, path.stat().st_mtime_ns) for path in tmp_path.rglob("*.o")))
    assert len(kept[0]) == 1
    assert kept[1] == kept[0]


# --- sensitivities ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "path", "parameter"),
    [
        (WINDER.replace("damping: 0.05", "damping: 0"), "dampers[0].damping", None),
        (WINDER.replace("stiffness: 0.3", "stiffness: 0"), "springs[0].stiffness", None),
        (WINDER.replace("ratio: -2", "ratio: 1"), "gears[0].ratio", None),
        (WINDER.replace("[0, -9.81]", "[0, 0]"), "gravity[0]", ("gravity", 0)),
        (WINDER.replace("length: 0.9, mass: 0.5", "length: 0.9"), "bars.coupler.mass", None),
        (SLIDER.replace("20 deg", "0"), "sliders.piston.angle", None),
        (SLIDER.replace("20 deg", "90 deg"), "sliders.piston.angle", None),
    ],
    ids=["damping", "stiffness", "ratio of one", "gravity", "mass", "angle of zero", "right angle"],
)
def test_numbers_that_sensitivities_are_asked_for_stay(text, path, parameter):
    """An argument of the kernel, whose values agree with those of the folded one to round-off."""
    folded = System(mechanism(text))
    kept = System(mechanism(text).keeping([path]))
    plan = Plan.of(mechanism(text), sensitive=[path])
    assert plan == Plan.of(kept)
    assert plan != Plan.of(folded)
    assert Plan.of(folded) is Plan.of(mechanism(text))
    section, *rest = path.replace("[", ".").replace("]", "").split(".")
    steps = (section, *(int(step) if step.isdigit() else step for step in rest))
    place = plan.layout.parameters.index(parameter or steps)
    entry = f"ptr %p, i64 {place}" if place else "load double, ptr %p"
    assert f"{entry}\n" in plan.program.assembly
    # values of order 10: both round in another order
    mine, exact = (of.evaluate(of.model.free_accelerations) for of in (kept, folded))
    assert mine == pytest.approx(exact, rel=1e-11, abs=1e-11)


def test_what_follows_from_a_number_stays_with_it():
    """Without its mass a bar has no moment of inertia either; both would grow with the mass."""
    text = WINDER.replace("length: 0.9, mass: 0.5", "length: 0.9")
    plan = Plan.of(mechanism(text), sensitive=["bars.coupler.mass"])
    assert ("bars", "coupler", "inertia") in plan.layout.parameters
    given = text.replace("length: 0.9}", "length: 0.9, inertia: 0}")
    fixed = Plan.of(mechanism(given), sensitive=["bars.coupler.mass"])
    assert ("bars", "coupler", "mass") in fixed.layout.parameters
    assert ("bars", "coupler", "inertia") not in fixed.layout.parameters


@pytest.mark.parametrize(
    "path", ["dampers[1].damping", "bars.crank.lenght", "bars", "nothing.at.all"]
)
def test_sensitivities_to_nothing_are_refused(path):
    with pytest.raises(InputError, match="found no number there"):
        Plan.of(mechanism(), sensitive=[path])


def test_functions_are_watched_wherever_the_vector_has_them():
    """The crank passes 1.5 rad, with or without work and tangents beside it in the vector."""
    system = System(mechanism())

    def nodes(model):
        return model.inputs.coordinate(0) - 1.5, model.inputs.rate(0)

    found = []
    for options in ({}, {"work": True}, {"tangents": 2}):
        plan = Plan.of(system, **options)
        event = Event(function=plan.watch(system, nodes, "crank at 1.5"), direction=1)
        start = plan.layout.packed(system.state)
        moved = integrate(plan.bind(system), start, [0.0, 1.0], rtol=1e-10, events=[event])
        found.append(moved.crossings[0].time[0])
    # three integrations with their own steps, each within its tolerance
    assert found == pytest.approx([found[0]] * 3, abs=1e-9)
    assert 0.0 < found[0] < 1.0
