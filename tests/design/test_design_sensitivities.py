"""Exact derivatives of motions against differences: all shipped mechanisms, events, exchanges."""

from __future__ import annotations

import numpy as np
import pytest
from design_differences import TWO_JUMPS, compared

import linkages
from linkages.design.differentiated import Differentiated
from linkages.errors import ComputationError, InputError
from linkages.kernel.number_effects import written
from linkages.reading.document import shipped
from linkages.solution.series import system_series

SERIES = (".effort", ".angle", ".position", ".acceleration", ".speed")
TIMES = np.array([0.37, 0.83])
ENDS = {"n-four-bar": 0.5, "slider-crank-contact": 0.0015, "andrews": 0.003, "class-three": 0.05}
"""Seconds of a motion where it is not a tenth of one that is integrated, or all of another one."""

# noise of 1e-13 in motions, divided by steps of 1e-3 to 1e-5 of a number
ROUND_OFF = 2e-9
TOUCHED = 2e-7
"""A touch makes errors of a motion a hundred times as large."""

NUMBERS = 3

SWITCHED = """
name: bell-crank
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.5, 0]}
bars:
  a: {joints: [O, A], length: 0.2, mass: 1}
  b: {joints: [A, B], length: 0.45, mass: 1}
  c: {joints: [C, B], length: 0.4, mass: 1}
free:
  c: {angle: 100 deg, speed: 3}
assembly: {A: [0.1, 0.17], B: [0.49, 0.4]}
"""

JUMPING = """
name: pendulum with a load that jumps
gravity: [0, -9.81]
joints: {O: [0, 0]}
parameters: {limit: 0.6, push: 2.0}
bars: {rod: {joints: [O, A], length: 0.5, mass: 1.5}}
free: {rod: {angle: -150 deg, speed: 0}}
loads: [{bar: rod, torque: "where(rod.angle > -limit, -push, push)"}]
"""


def _prepared(name: str) -> tuple[Differentiated, list[str], float]:
    mechanism = linkages.load(name)
    moves = bool(mechanism.initial)
    end = mechanism.simulation.end * (0.1 if moves else 1.0)
    run = {"end": ENDS.get(name, end), "samples": 201}
    if moves:
        run["rtol"] = 1e-13
    paths = Differentiated(mechanism, [], ["*"], run=run).paths
    chosen = np.linspace(0, len(paths) - 1, NUMBERS).astype(int)
    found = Differentiated(mechanism, [], [paths[place] for place in chosen], run=run)
    known = [one for one in system_series(found.system) if "." in one]
    series = [own[-1] for end_ in SERIES if (own := [n for n in known if n.endswith(end_)])][:3]
    return found, series, run["end"]


@pytest.mark.slow
def test_derivatives_of_all_shipped_mechanisms_are_those_of_differences():
    """Over 200 triples of mechanism, output and number; what differences can tell is estimated."""
    triples, worst = 0, {}
    for name in shipped():
        found, series, end = _prepared(name)
        places = list(range(len(found.paths)))
        part = 1e-5 if "contact" in name else 2e-3
        missed, attainable = compared(found, series, TIMES * end, places, part)
        noise = TOUCHED if "contact" in name else ROUND_OFF
        assert (missed <= noise + 10 * attainable).all(), (name, missed.max())
        clear = attainable < 1e-9
        triples += int(clear.all(axis=2).sum())
        worst[name] = float(missed[clear].max(initial=0.0))
    assert triples >= 200
    assert np.median([*worst.values()]) < 1e-9


@pytest.mark.slow
def test_derivatives_go_through_an_exchange_of_free_coordinates():
    mechanism = linkages.loads(SWITCHED)
    found = Differentiated(
        mechanism, [], ["bars.*.length", "free.*"], run={"end": 1.0, "samples": 401, "rtol": 1e-12}
    )
    notes = linkages.simulate(mechanism, end=1.0, rtol=1e-12).notes
    assert any("was exchanged for" in note for note in notes)
    numbers = list(range(len(found.paths)))
    missed, attainable = compared(
        found, ["a.angle", "b.speed"], np.array([0.5, 1.0]), numbers, 1e-3
    )
    # the accuracy of the motion, which swings within a second, and what is left of differences
    assert (missed <= 2e-9 + 10 * attainable).all()


@pytest.mark.slow
def test_derivatives_go_through_a_jump_whose_time_depends_on_numbers():
    """The torque jumps at an angle that is a number, so its time moves."""
    found = Differentiated(
        linkages.loads(JUMPING), [], ["parameters.*", "bars.rod.length", "free.rod.angle"],
        run={"end": 1.5, "samples": 301, "rtol": 1e-12},
    )  # fmt: skip
    numbers = list(range(len(found.paths)))
    missed, attainable = compared(found, ["rod.angle", "rod.speed"], np.array([1.2]), numbers, 1e-3)
    assert (missed <= 2e-9 + 10 * attainable).all()
    at_jump = found.along(found.values, ["rod.angle"], np.array([1.2]))
    assert at_jump.derivatives is not None
    assert abs(at_jump.derivatives[0, found.paths.index("parameters.limit"), 0]) > 0.01


def test_derivatives_go_through_touches():
    """A journal touches its bearing; touches make errors of motions larger by their number."""
    found = Differentiated(
        linkages.load("slider-crank-contact"), [], ["clearances.gap.size", "bars.rod.length"],
        run={"end": 0.004, "samples": 401, "rtol": 1e-12},
    )  # fmt: skip
    missed, _ = compared(found, ["crank.effort"], np.array([0.004]), [0, 1], 1e-5)
    assert missed.max() < 1e-6


def test_datasets_have_outputs_over_time_and_measures():
    mechanism = linkages.load("pendulum")
    found = linkages.sensitivities(
        mechanism, ["bar_angle", "rod.speed", "final(rod.angle)"], "bars.rod.*", end=1.0, samples=11
    )
    assert found["bar_angle"].dims == ("time", "bar", "parameter")
    assert found["rod.speed"].dims == ("time", "parameter")
    assert found["bar_angle"].attrs["units"] == "rad / parameter_units"
    assert found["parameter_units"].values.tolist() == ["m", "kg"]
    # the same motion; a bob's mass does not matter, but for round-off
    ends = found["bar_angle"][-1, 0], found["final(rod.angle)"]
    np.testing.assert_allclose(*ends, rtol=1e-12, atol=1e-12)
    assert abs(ends[1].sel(parameter="bars.rod.mass")) < 1e-9


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("bar_angel", "did you mean 'bar_angle'"),
        ("rocker.angel", "did you mean 'rocker.angle'"),
        ("max(rocker.angel)", "did you mean 'rocker.angle'"),
        ("closure_residual", "no derivative is known"),
        ([], "no outputs are asked for"),
    ],
)
def test_unknown_outputs_are_refused_with_the_nearest_one(output, message):
    with pytest.raises(ValueError, match=message):
        linkages.sensitivities(linkages.load("four-bar"), output, "bars.*")


def test_free_coordinates_must_be_named():
    """One that is chosen starts where hints put it, which moves with what the hints are near to."""
    text = SWITCHED.replace("free:\n  c: {angle: 100 deg, speed: 3}\n", "")
    with pytest.raises(InputError, match="name them in 'free'"):
        linkages.sensitivities(linkages.loads(text), "bar_angle", "bars.*.length")


def test_numbers_without_an_effect_and_formulas_are_refused():
    with pytest.raises(InputError, match="give its number a name in 'parameters'"):
        linkages.sensitivities(linkages.loads(JUMPING), "bar_angle", "loads[0].torque")
    with pytest.raises(InputError, match="follows from others"):
        linkages.sensitivities(linkages.load("pendulum"), "bar_angle", "bars.rod.inertia")


@pytest.mark.slow
def test_derivatives_that_grow_without_bound_are_refused():
    """Bars of different lengths have no change point, which the motion goes through."""
    with pytest.raises(ComputationError, match="grow without bound"):
        linkages.sensitivities(
            linkages.load("n-four-bar"), "final(post0.angle)", "*.length", end=2.0, rtol=1e-12
        )


def test_friction_that_holds_a_motion_changes_with_numbers():
    """It sticks from about t = 3 s on: what holds it then is −m g cos θ L/2, which moves with θ."""
    mechanism = linkages.loads(
        """
        gravity: [0, -9.81]
        joints: {O: [0, 0]}
        parameters: {mu: 0.6}
        bars: {rod: {joints: [O, A], length: 0.5, mass: 1}}
        free: {rod: {angle: 10 deg, speed: 0}}
        loads: [{bar: rod, torque: "-mu*sign(rod.speed)"}]
        """
    )
    paths = ["parameters.mu", "bars.rod.length", "free.rod.angle"]
    found = Differentiated(mechanism, [], paths, run={"end": 4.0, "samples": 401, "rtol": 1e-12})
    missed, attainable = compared(
        found, ["rod.angle", "loads[0].torque"], np.array([0.5, 4.0]), [0, 1, 2], 1e-3
    )
    assert (missed <= 2e-9 + 10 * attainable).all()
    held = found.along(found.values, ["rod.speed"], np.array([4.0]))
    assert abs(held.values[0, 0]) < 1e-12  # round-off, while it slides at about 1 rad/s


@pytest.mark.slow_except("four-bar-*")
@pytest.mark.parametrize(
    ("name", "end", "part"),
    [
        ("four-bar", None, 1e-3),
        ("beam-pump", None, 1e-3),
        ("double-pendulum", 1.0, 1e-3),
        ("slider-crank-contact", 0.001, 1e-6),
        ("ninebar", 0.05, 1e-3),
    ],
)
def test_joint_reactions_have_the_derivatives_of_differences(name, end, part):
    """By masses, lengths, speeds, weights and clearances: first and last reaction, five numbers.

    The contact is stiff: differences of a millionth tell seven digits.
    """
    mechanism = linkages.load(name)
    numbers = [number.path for number in written(mechanism)]
    run = {"samples": 101, "rtol": 1e-12} | ({} if end is None else {"end": end})
    found = Differentiated(mechanism, [], numbers, run=run)
    # of joints, then of bodies that share a pin
    pins = ("joint_reaction", "pin_reaction")
    reactions = [k for k, s in system_series(found.system).items() if s.variable in pins]
    last = float(found.system.mechanism.simulation.end if end is None else end)
    chosen = np.linspace(0, len(numbers) - 1, 5).astype(int).tolist()
    missed, attainable = compared(
        found, [reactions[0], reactions[-1]], np.array([0.3, 0.8]) * last, chosen, part
    )
    assert (missed <= 5e-8 + 10 * attainable).all()
    assert np.isfinite(attainable).all()
    assert attainable.min() < 1e-6


def test_side_thrust_has_the_derivatives_of_differences():
    mechanism = linkages.load("slider-crank")
    numbers = [number.path for number in written(mechanism)]
    found = Differentiated(mechanism, [], numbers, run={"samples": 101, "rtol": 1e-12})
    times = np.array([0.3, 0.8]) * mechanism.simulation.end
    every = list(range(len(numbers)))
    missed, attainable = compared(found, ["piston.guide reaction"], times, every, 1e-3)
    assert (missed <= 1e-10 + 10 * attainable).all()
    assert attainable.max() < 1e-9


@pytest.mark.slow
def test_reactions_of_redundant_constraints_have_no_derivative():
    """Three parallel cranks carry a coupler that two would carry as well."""
    mechanism = linkages.loads(
        """
        joints: {O: [0, 0], P: [1, 0], Q: [2, 0]}
        bars:
          coupler: {points: {A: [0, 0], B: [1, 0], C: [2, 0]}, mass: 1, center: [1, 0], inertia: 1}
          first: {joints: [O, A], length: 0.5}
          second: {joints: [P, B], length: 0.5}
          third: {joints: [Q, C], length: 0.5}
        drives: {first: {angle: 40 deg, speed: 1}}
        """
    )
    with pytest.raises(ValueError, match="constraints are redundant"):
        linkages.sensitivities(mechanism, "max(A.x reaction)", "bars.coupler.mass", end=0.1)


@pytest.mark.parametrize(
    ("name", "end", "part"), [("ninebar", 0.05, 1e-3), ("slider-crank-contact", 0.001, 1e-6)]
)
def test_deviations_from_the_ideal_mechanism_have_derivatives(name, end, part):
    """Of the clearance they are of, which the ideal one has not, and of a length that both have."""
    mechanism = linkages.load(name)
    numbers = [number.path for number in written(mechanism)]
    sizes = [path for path in numbers if path.startswith("clearances") and path.endswith("size")]
    lengths = [path for path in numbers if path.endswith("length")]
    found = Differentiated(
        mechanism, [], [sizes[0], lengths[0]], run={"end": end, "samples": 101, "rtol": 1e-12}
    )
    errors = [k for k, s in system_series(found.system).items() if s.variable.endswith("error")]
    errors = [each for each in errors if "residual" not in each][:2]
    assert errors
    missed, attainable = compared(found, errors, np.array([0.3, 0.8]) * end, [0, 1], part)
    assert (missed <= 1e-7 + 10 * attainable).all()
    assert attainable.max() < 1e-5  # errors are small differences of positions


def test_a_measure_without_a_derivative_costs_its_own_alone():
    """The speed of the crank is the same always; the motion ends after 0.08 s."""
    mechanism = linkages.load("slider-crank")
    effort, plateau, late = "max(crank.effort)", "time_of_max(crank.speed)", "at(3 s, crank.effort)"
    bent = "sqrt(max(crank.angle) - max(crank.angle))"
    asked = [effort, plateau, late, bent]
    found = linkages.sensitivities(mechanism, asked, "bars.*.length", samples=201)
    alone = linkages.sensitivities(mechanism, effort, "bars.*.length", samples=201)
    assert found[effort].identical(alone[effort])
    for text, value, reason in (
        (plateau, 0.0, "no derivative is known of its time"),
        (late, np.nan, "t = 3 s is outside of the motion"),
        (bent, 0.0, "no finite derivative"),
    ):
        assert np.isnan(found[text]).all()
        assert found[text].attrs["value"] == pytest.approx(value, nan_ok=True)
        assert reason in found[text].attrs["reason"]


def test_a_number_without_a_derivative_costs_its_own_alone():
    """Two jumps at one time are parted by the numbers of both, and by no other."""
    more = "dampers: [{joint: O, damping: 0.5}]\nsimulate: {end: 0.8, samples: 81}\n"
    mechanism = linkages.loads(TWO_JUMPS.replace("speed: 1", "speed: 2") + more)
    paths = ["parameters.one", "parameters.other", "dampers[0].damping"]
    found = linkages.sensitivities(mechanism, "mean(arm.effort)", paths)["mean(arm.effort)"]
    assert np.isnan(found[:2]).all()
    assert found[2] == pytest.approx(2.0, rel=1e-12)  # the speed
    assert "no finite derivative" in found.attrs["reason"]
