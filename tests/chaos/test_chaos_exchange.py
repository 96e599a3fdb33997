"""Sections and exponents through exchanges of coordinates and change points, and their ends."""

import math

import numpy as np
import pytest
from solution_mechanisms import FREE_CRANK

import linkages
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.errors import ComputationError
from linkages.kernel.system import System
from linkages.options.run import RunOptions

THROWN = """\
name: Thrown four-bar
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.06, mass: 0.5}
  coupler: {joints: [A, B], length: 0.07, mass: 0.5}
  rocker: {joints: [D, B], length: 0.05, mass: 0.5}
assembly: {A: [0.04, 0.04], B: [0.1, 0.05]}
free: {crank: {angle: 50 deg, speed: 6}}
simulate: {end: 0.5, samples: 11, rtol: 1e-12}
"""

PARALLELOGRAM = """\
name: Parallelogram
joints: {O: [0, 0], D: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.5}
  coupler: {joints: [A, B], length: 0.1, mass: 0.5}
  rocker: {joints: [D, B], length: 0.04, mass: 0.5}
assembly: {A: [0.02, 0.034], B: [0.12, 0.034]}
free: {crank: {angle: 60 deg, speed: 6}}
simulate: {end: 2, rtol: 1e-10}
"""


def swinging(text, free):
    return linkages.loads(
        text.split("free:")[0] + f"free: {free}\nsimulate: {{end: 0.5, rtol: 1e-11}}\n"
    )


SLIDER_CRANK = FREE_CRANK + "dampers: [{slider: piston, damping: 0.8}]\n"
SLIDER_CRANK += 'loads: [{bar: crank, torque: "0.4 + 0.3*sin(20*t)"}]\n'
START, SPEED = math.pi / 3, 40.0
ALONG = math.sqrt(0.14**2 - (0.04 * math.sin(START)) ** 2)
BY_CRANK = f"{{crank: {{angle: {START!r}, speed: {SPEED}}}}}"
# the same state, said of the piston: x = r cos θ + √(l² − r² sin² θ)
RATE = -0.04 * math.sin(START) * (1 + 0.04 * math.cos(START) / ALONG) * SPEED
BY_PISTON = f"{{piston: {{position: {0.04 * math.cos(START) + ALONG!r}, speed: {RATE!r}}}}}"


def test_sections_go_on_over_an_exchange():
    """The crank turns back where coupler and rocker are in line; the coupler takes over.

    Crossings are those of a simulation between whose samples the section is met, 5e-5 s apart; and
    the times between them repeat, for energy is conserved and there is one free coordinate.
    """
    mechanism = linkages.loads(THROWN)
    found = linkages.poincare(mechanism, periods=7, section="coupler.speed=7", end=3)
    times = found.time.to_numpy()
    solution = linkages.simulate(mechanism, end=1.0, samples=20001, outputs=["bar_speed"])
    assert any("exchanged for coupler" in note for note in solution.notes)
    speed = solution.data.bar_speed.sel(bar="coupler").to_numpy()
    met = np.flatnonzero((speed[:-1] <= 7) & (speed[1:] > 7))
    assert times[: len(met)] == pytest.approx(solution.data.time.to_numpy()[met] + 2.5e-5, abs=3e-5)
    assert len(met) == 3
    assert times[3:] - times[:-3] == pytest.approx(times[3] - times[0], abs=1e-8)


def test_sections_do_not_depend_on_what_is_free():
    """The piston cannot stay free for a turn; the crank could for all time."""
    by_crank, by_piston = (
        linkages.poincare(swinging(SLIDER_CRANK, free), periods=40, section="rod.angle=0", end=9)
        for free in (BY_CRANK, BY_PISTON)
    )
    assert by_piston.time.to_numpy() == pytest.approx(by_crank.time.to_numpy(), abs=1e-8)
    # rod and guide are in line, the rod's angle grows: the piston is nearest
    assert by_piston.slider_position.to_numpy() == pytest.approx(0.14 - 0.04, abs=1e-9)


def test_tangents_go_along_in_an_exchange():
    """Against differences of motions that start beside each other, in the crank's coordinates."""
    system = System(swinging(SLIDER_CRANK, BY_PISTON))
    run = RunOptions(rtol=1e-12)
    tangents, step = LinkageTangents(system, 2, run), 1e-7
    tangents.advance(0.2)
    assert tangents.here.topology.free == ("crank",)
    for column in range(2):
        ends = []
        for side in (step, -step):
            beside = system.at(0.0, system.state + side * np.eye(2)[column])
            moved = LinkageTangents(beside, 2, run)
            moved.advance(0.2)
            ends.append(moved.here.state)
        expected = (ends[0] - ends[1]) / (2 * step)
        # 1e-6 of their own length is what tangents are integrated to, step by step
        assert tangents.tangents[:, column] == pytest.approx(expected, rel=1e-4, abs=1e-3)


@pytest.mark.slow
def test_exponents_do_not_depend_on_what_is_free():
    """And their sum is that of inertia and loads, whatever was exchanged."""
    by_crank, by_piston = (
        linkages.lyapunov(swinging(SLIDER_CRANK, free), periods=120, skip=40)
        for free in (BY_CRANK, BY_PISTON)
    )
    apart = np.abs(by_crank.exponent - by_piston.exponent)
    assert (apart <= 4 * (by_crank.error + by_piston.error)).all()
    for found in (by_crank, by_piston):
        assert found.attrs["warning"] == ""
        apart = abs(float(found.found[0] - found.expected[0]))
        assert apart <= float(found.tolerance[0]) < 0.05 * abs(float(found.expected[0]))


@pytest.mark.slow
def test_an_exchange_is_no_growth():
    """The ratio of lengths in the old and new coordinate, 25 or so, is no part of exponents.

    Nothing dissipates, so the sum is zero, as that of volumes of coordinates and momenta. The four
    bars exchange to and fro, in intervals and between them.
    """
    for mechanism in (swinging(FREE_CRANK, BY_PISTON), linkages.loads(THROWN)):
        found, one = (
            linkages.lyapunov(mechanism, periods=40, interval=0.5, count=count) for count in (2, 1)
        )
        assert abs(found.attrs["sum"]) < 1e-8
        assert "sum of all" not in found.attrs["warning"]
        # whatever the direction it begins in, within ln 10 over 20 s
        assert one.exponent.to_numpy() == pytest.approx(found.exponent.to_numpy()[:1], abs=0.1)


def test_no_exchange_no_other_metric():
    """Lengths are those in the coordinates themselves: sums are known from det J at both ends."""
    found = linkages.lyapunov(swinging(FREE_CRANK, BY_CRANK), periods=40, interval=0.5)
    assert float(found.found[0]) == pytest.approx(float(found.expected[0]), abs=1e-9)
    assert abs(float(found.found[0])) > 1e-3


@pytest.mark.slow
def test_a_parallelogram_is_a_pendulum_in_section_and_exponents():
    """Through its change points, for ever: without gravity it turns at its speed of 6 rad/s.

    A tangent along the motion keeps its length and the other one grows like time, so that both
    exponents fall like log(t)/t; the tangents span a parallelogram of constant area.
    """
    mechanism = linkages.loads(PARALLELOGRAM)
    found = linkages.poincare(mechanism, periods=10, section="crank.angle=10 deg", end=20)
    turns = (np.radians(310) + 2 * np.pi * np.arange(10)) / 6
    assert found.time.to_numpy() == pytest.approx(turns, abs=1e-9)
    exponents = linkages.lyapunov(mechanism, periods=100, interval=0.5)
    assert float(exponents.attrs["sum"]) == pytest.approx(0.0, abs=1e-9)
    history = exponents.history.to_numpy()[:, 0] * exponents.time.to_numpy()
    later = exponents.time.to_numpy() > 10
    rise = np.polyfit(np.log(exponents.time.to_numpy()[later]), history[later], 1)[0]
    assert rise == pytest.approx(1.0, abs=0.05)


def test_a_change_point_ends_what_may_not_pass():
    mechanism = linkages.loads(PARALLELOGRAM.replace("{end: 2,", "{end: 2, change_points: stop,"))
    for analysis in (
        lambda: linkages.poincare(mechanism, periods=10, section="crank.speed=7"),
        lambda: linkages.lyapunov(mechanism, periods=40, interval=0.5),
    ):
        with pytest.raises(ComputationError, match="can go on in two ways"):
            analysis()


@pytest.mark.parametrize("budget", [40, 2000])
def test_the_allowed_steps_end_a_run(budget):
    """The second budget lasts for some hundred intervals, so that all of them share one."""
    arm = linkages.load("double-pendulum")
    name = next(iter(arm.bodies))
    for analysis in (
        lambda: linkages.poincare(arm, periods=999, section=f"{name}.speed=0", max_steps=budget),
        lambda: linkages.lyapunov(arm, periods=999, interval=1.0, max_steps=budget),
    ):
        with pytest.raises(ComputationError, match="Raise max_steps"):
            analysis()


def test_steps_must_be_allowed():
    for analysis in (linkages.poincare, linkages.lyapunov):
        with pytest.raises(ValueError, match="max_steps must be a whole number > 0"):
            analysis(linkages.load("ninebar"), max_steps=0)
