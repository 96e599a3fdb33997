"""Verdicts on mechanisms: transients, rest, one run, and its confirmation."""

from dataclasses import replace

import numpy as np
import pytest
from shared_definitions import DRIVEN_PENDULUM

import linkages
from linkages.chaos.evidence import alike
from linkages.chaos.findings import verdict
from linkages.chaos.judge import judge
from linkages.components.mechanisms.definition import from_document
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.reading.document import parse
from linkages.reading.overrides import apply
from linkages.solvers.integration import LEAST_RTOL

# the pendulum of docs/chaos.md (Baker and Gollub, Chaotic Dynamics, with their g = 1.15)
PENDULUM = DRIVEN_PENDULUM + "simulate: {end: 10, rtol: 1e-8}\n"

FIVE_BAR = """\
name: Five-bar
gravity: [0, -9.81]
joints: {O1: [0, 0], O2: [0.5, 0]}
bars:
  a: {joints: [O1, A], length: 0.2, mass: 1}
  b: {joints: [A, C], length: 0.5, mass: 1}
  c: {joints: [B, C], length: 0.5, mass: 1}
  d: {joints: [O2, B], length: 0.2, mass: 1}
dampers: [{joint: O1, damping: 0.2}, {joint: O2, damping: 0.2}]
loads: [{bar: a, torque: "AMPLITUDE*cos(2*pi*t)"}]
free: {a: {angle: -90 deg}, d: {angle: -80 deg}}
assembly: {C: [0.25, -0.5]}
simulate: {end: 1, rtol: 1e-8}
"""

DOUBLE_PENDULUM = """\
name: Driven damped double pendulum
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 1, mass: 1}, lower: {joints: [A, B], length: 1, mass: 1}}
gravity: [0, -9.81]
free: {upper: {angle: -80 deg}, lower: {angle: -85 deg}}
dampers: [{joint: O, damping: 1}, {joint: A, damping: 1}]
loads: [{bar: upper, torque: "AMPLITUDE*cos(2*pi*t)"}]
simulate: {end: 1, rtol: 1e-8}
"""


def mechanism(text: str, amplitude: float = 1.0, **changes: object) -> linkages.Mechanism:
    document = parse(text.replace("AMPLITUDE", repr(amplitude)), "m.yaml")
    return from_document(apply(document, changes))


def pendulum(damping: float, **changes: object) -> linkages.Mechanism:
    return mechanism(PENDULUM, **{"dampers[0].damping": damping, **changes})


DAMPED = {
    "driven 0.8": lambda: pendulum(0.8),
    "driven 2": lambda: pendulum(2.0),
    "overdamped": lambda: pendulum(4.0),
    "double pendulum 0.3": lambda: mechanism(DOUBLE_PENDULUM, 0.3),
    "double pendulum 1": lambda: mechanism(DOUBLE_PENDULUM, 1.0),
    "five-bar 0.5": lambda: mechanism(FIVE_BAR, 0.5),
    "five-bar 1.2": lambda: mechanism(FIVE_BAR, 1.2),
}
"""Small oscillations about a stable equilibrium, forced and damped: they repeat every period."""


@pytest.mark.parametrize("skip", [None, 0])
@pytest.mark.parametrize(
    "case",
    ["driven 0.8", *(pytest.param(c, marks=pytest.mark.slow) for c in DAMPED if c != "driven 0.8")],
)
def test_damped_motions_are_periodic(case, skip):
    report = verdict(DAMPED[case](), periods=200, skip=skip)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    assert report.tighter["verdict"] == "periodic"
    assert report.run["skip"] == (100 if skip is None else 0)


@pytest.mark.parametrize("skip", [None, 0])
def test_a_pendulum_that_nothing_drives_comes_to_rest(skip):
    damped = {"dampers": "[{joint: O, damping: 0.1}]"}
    report = verdict(linkages.load("pendulum", set=damped), periods=200, skip=skip)
    assert report.verdict == "at rest", report.reasons
    if skip is None:
        assert report.run["skip"] >= 100
        assert report.rotation[next(iter(report.rotation))].kind == "resting"


def test_points_and_exponents_are_of_one_run(monkeypatch):
    """Of the driven pendulum where it is chaotic: every other run soon goes elsewhere."""
    seen = judgements(monkeypatch)
    report = verdict(pendulum(0.5), periods=200)
    evidence = seen[0].evidence
    states, times = evidence.exponents.states, evidence.exponents.times
    parts = (len(times) - 1) // 200
    period = 3 * np.pi
    assert times[0] == pytest.approx(100 * period, rel=1e-12)
    assert (evidence.points == states[:-1:parts]).all()
    assert report.section.time.to_numpy() == pytest.approx(times[:-1:parts])
    # wrapped once more, to round-off
    turned = report.section.bar_angle[:, 0].to_numpy() - evidence.points[:, 0]
    assert np.abs(np.sin(0.5 * turned)).max() < 1e-14
    assert (report.section.bar_speed[:, 0] == evidence.points[:, 1]).all()
    # the motion over time starts from there, too
    assert seen[0].start.here.time == times[0]
    assert (seen[0].start.state == states[0]).all()


def test_the_confirming_run_gathers_all_evidence_anew(monkeypatch):
    seen = judgements(monkeypatch)
    verdict(pendulum(0.5), periods=200)
    one, other = seen[0].evidence, seen[0].again
    assert (one.points[0] == other.points[0]).all()
    # errors of 1e-8 grow by e^(0.14 · 9.4) in a period: after 20 periods nothing is alike
    assert np.abs(one.points[1] - other.points[1]).max() < 1e-5
    assert np.abs(one.points[40:] - other.points[40:]).max() > 1
    assert one.tests != other.tests
    assert one.steady != other.steady
    assert other.exponents.growth.shape == one.exponents.growth.shape


def test_a_verdict_that_changes_with_the_tolerance_is_none(monkeypatch):
    judgements(monkeypatch, verdict_again="chaotic")
    report = verdict(pendulum(0.8), periods=200)
    assert report.verdict == "undecided"
    assert report.tighter["verdict"] == "chaotic"
    assert any("it changes with the step size" in reason for reason in report.reasons)


def test_a_verdict_that_nothing_can_confirm_is_none():
    report = verdict(pendulum(0.8), periods=200, rtol=LEAST_RTOL)
    assert report.verdict == "undecided"
    assert any("nothing confirms this" in reason for reason in report.reasons)


def test_longer_transients_are_skipped_by_default():
    """Small oscillations decay like exp(-0.01 t): to a ten-thousandth in 98 periods of 9.4 s."""
    slow = pendulum(0.02, loads=[{"bar": "arm", "torque": "0.01*cos(2*t/3)"}])
    report = verdict(slow, periods=200)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    assert report.run["skip"] == 300
    assert "settled from there on" in report.run["skipped"]
    short = verdict(slow, periods=200, skip=0)
    assert short.run["skip"] == 0
    assert short.verdict in ("periodic", "undecided")
    assert any("transient" in reason or "from its point" in reason for reason in short.reasons)


def test_nothing_is_skipped_where_nothing_dissipates():
    report = verdict(linkages.load("pendulum"), periods=200)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    assert (report.run["skip"], report.run["skipped"]) == (0, "nothing dissipates")
    assert report.section.time[0] == pytest.approx(0, abs=report.run["period"])


def test_what_counts_as_no_difference():
    """A ten-thousandth of the range, of an angle at most of a radian, or errors of integration."""
    tolerance = alike(System(pendulum(0.8)), 2.0, RunOptions(rtol=1e-8))
    small, large = (np.array([[0.0, -5.0], [end, 5.0], [0.0, -5.0]]) for end in (0.1, 6.0))
    assert tolerance(small, None) == pytest.approx([1e-5, 1e-3])
    assert tolerance(large, None) == pytest.approx([1e-4, 1e-3], rel=1e-1)
    assert tolerance(np.zeros((2, 2)), None) == pytest.approx([1e-6, 1e-6])
    least = np.array([[0.0, 1.0], [1e-7, 1.0 + 1e-7], [0.0, 1.0]])
    assert tolerance(least, None) == pytest.approx([1e-6, 2e-6])
    assert tolerance(least, np.array([1e-13, 1e-7])) == pytest.approx([1e-11, 2e-6])
    assert tolerance(least, np.array([5e-12, 5e-10])) == pytest.approx([5e-11, 1e-11])
    creeping = least[:2]
    assert tolerance(creeping, np.array([1e-13, 1e-13])) == pytest.approx([1e-6, 2e-6])


def judgements(monkeypatch, **changes):
    """What `judge` returns, as it goes on, with some of it changed."""
    seen = []

    def watched(*arguments, **given):
        seen.append(replace(judge(*arguments, **given), **changes))
        return seen[-1]

    monkeypatch.setattr("linkages.chaos.findings.judge", watched)
    return seen


SLIDERS = """\
name: Two sliders
joints: {O: [0, 0], Q: [0, 1]}
sliders: {a: {joint: P, through: O, mass: 1}, b: {joint: R, through: Q, mass: 1}}
loads: [{slider: a, force: "FIRST"}, {slider: b, force: "SECOND"}]
free: {a: {position: 0.5}, b: {position: STARTS}}
simulate: {end: 1}
"""
LINEAR = "-a.position-0.3*a.velocity+cos(1.2*t)"


def duffing(force: float, *, slider: str = "b", size: float = 1.0, origin: float = 0.0) -> str:
    """Of Jordan and Smith, of a size in metres, about an origin: period 2, 5, chaos at 0.28, 0.37,
    0.5."""
    x = f"({slider}.position-{origin!r})"
    return f"{x}-{x}**3/{size!r}**2-0.3*{slider}.velocity+{force * size!r}*cos(1.2*t)"


def sliders(first: str, second: str, start: float) -> linkages.Mechanism:
    text = SLIDERS.replace("FIRST", first).replace("SECOND", second)
    return linkages.loads(text.replace("STARTS", repr(start)))


@pytest.mark.slow_except("*-1e-08")
@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-6, 1e-8, 1e-9])
@pytest.mark.parametrize("atol", [None, 1e-15])
def test_a_small_coordinate_beside_a_large_one_is_judged_by_its_own_extent(size, atol):
    """Two sliders without any connection, of which one moves by a metre."""
    system = sliders(LINEAR, duffing(0.28, size=size), size)
    report = verdict(system, periods=200, rtol=1e-10, atol=atol)
    assert (report.verdict, report.period) == ("periodic", 2), report.reasons


def test_chaos_below_errors_of_integration_asks_for_a_smaller_tolerance():
    """Ten nanometres beside a metre, whose errors at rtol 1e-7 may be some micrometres."""
    system = sliders(LINEAR, duffing(0.5, size=1e-8), 1e-8)
    blurred = verdict(system, periods=300, rtol=1e-7)
    assert blurred.verdict == "undecided"
    assert any("Take a smaller rtol and atol" in reason for reason in blurred.reasons)
    assert not any("run more periods" in reason for reason in blurred.reasons)
    assert verdict(system, periods=300, rtol=1e-9, atol=1e-14).verdict == "chaotic"


def test_an_odd_number_of_points_repeats_after_two():
    report = verdict(sliders(LINEAR, duffing(0.28), 1.0), periods=201)
    assert (report.verdict, report.period) == ("periodic", 2), report.reasons
    assert "The Poincaré section repeats after 2 points." in report.reasons


def test_a_verdict_does_not_depend_on_the_origin():
    report = verdict(sliders(LINEAR, duffing(0.5, origin=2e6), 2e6 + 1), periods=200)
    assert report.verdict == "chaotic", report.reasons
    assert report.zero_one["b"][0] > 0.6


@pytest.mark.slow
def test_weak_chaos_on_a_cycle_of_five_is_seen_by_the_zero_one_test():
    """A cycle of five that feels a thousandth of a chaotic motion."""
    cycle = duffing(0.37, slider="a") + "+0.001*b.position"
    report = verdict(sliders(cycle, duffing(0.5), 1.0), periods=300)
    assert report.verdict == "chaotic", report.reasons
    assert report.zero_one["a"][0] > 0.6


OSCILLATOR = """\
name: Oscillator
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
loads: [{slider: m, force: "FORCE"}]
free: {m: {position: POSITION, speed: VELOCITY}}
simulate: {end: 6.3}
"""


def oscillator(force: str, position: float = 1.0, velocity: float = 0.0) -> linkages.Mechanism:
    text = OSCILLATOR.replace("FORCE", force).replace("POSITION", repr(position))
    return linkages.loads(text.replace("VELOCITY", repr(velocity)))


def test_either_run_is_judged_by_its_own_evidence():
    """A step h of RK4 shrinks a swing cos t by (1 - h⁶/144): e⁻²⁶ in 200 of them, and e⁻².

    So the first run comes to rest, and the one with 0.56 of its step does not.
    """
    report = verdict(oscillator("-m.position"), periods=200, method="rk4", step=1.3)
    assert "The motion comes to rest." in report.reasons
    assert report.tighter["verdict"] == report.verdict == "undecided"


def test_a_multiplier_near_minus_one_does_not_double_the_period():
    """0.99 of a deviation is left, on the other side: 2 points repeat sooner than 1 does."""
    force = "-(0.25+0.1985*cos(t))*m.position-0.2*m.velocity+cos(t)"
    point = linkages.poincare(oscillator(force), periods=1, skip=2500)
    x, v = float(point.slider_position[0, 0]), float(point.slider_velocity[0, 0])
    extent = 2.354
    report = verdict(oscillator(force, x + 4e-4 * extent, v), periods=200, skip=0)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons


APART = "Drives and loads have no common period"


def cranks(first: float, second: float) -> linkages.Mechanism:
    """A damped slider between springs to two cranks, with speeds in rpm."""
    return linkages.loads(f"""\
name: Two cranks
joints: {{A: [0, 0], B: [3, 0], O: [0, 1]}}
bars: {{one: {{joints: [A, P], length: 0.1}}, two: {{joints: [B, Q], length: 0.1}}}}
sliders: {{m: {{joint: S, through: O, mass: 1}}}}
drives: {{one: {{angle: 0, speed: {first} rpm}}, two: {{angle: 0, speed: {second} rpm}}}}
springs:
  - {{between: [P, S], stiffness: 20, length: 0.5}}
  - {{between: [Q, S], stiffness: 20, length: 0.5}}
dampers: [{{slider: m, damping: 0.5}}]
free: {{m: {{position: 1}}}}
simulate: {{end: 1}}
""")


def two_torques(amplitude: float) -> linkages.Mechanism:
    """F. J. Romeiras, E. Ott, Phys. Rev. A 35 (1987) 4404, with p = 3 and K = 1.33."""
    torque = f"3*(1.33+{amplitude!r}*(cos((sqrt(5)-1)/2*t)+cos(t))+cos(arm.angle)-arm.speed)"
    return linkages.loads(f"""\
name: Romeiras and Ott
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 1}}}}
masses: {{P: 1 kg}}
loads: [{{bar: arm, torque: "{torque}"}}]
free: {{arm: {{angle: 0.1}}}}
simulate: {{end: 1}}
""")


def test_two_forces_without_a_common_period_drag_a_torus():
    """Of a damped linear oscillator: its motion is that of both forces, in closed form."""
    report = verdict(oscillator("-m.position-0.2*m.velocity+cos(t)+cos(sqrt(2)*t)"))
    assert report.verdict == report.tighter["verdict"] == "quasi-periodic", report.reasons
    assert report.run["period"] == pytest.approx(2 * np.pi)
    assert report.to_dict()["run"]["other_periods"] == pytest.approx([np.pi * 2**0.5])
    times = report.section.time.to_numpy()
    known = sum((np.exp(1j * w * times) / (1 - w**2 + 0.2j * w)).real for w in (1.0, 2**0.5))
    assert report.section.slider_position[:, 0].to_numpy() == pytest.approx(known, abs=1e-4)
    assert any(reason.startswith(APART) for reason in report.reasons)


def test_cranks_without_a_common_period():
    report = verdict(cranks(60, 97.0820393), periods=200)
    assert report.verdict == "quasi-periodic", report.reasons


def test_phases_that_hardly_move_against_each_other_need_a_longer_run():
    """At 60 and 60.01 rpm all positions come again after 6000 s, in which they beat once."""
    report = verdict(cranks(60, 60.01), periods=300)
    assert report.verdict == "undecided"
    assert any("of a turn against each other: run about 60" in text for text in report.reasons)


def test_a_third_drive_without_a_common_period():
    forces = "cos(t)+cos(sqrt(2)*t)+cos(sqrt(3)*t)"
    report = verdict(oscillator(f"-m.position-0.2*m.velocity+{forces}"), periods=200)
    assert report.verdict == "undecided"
    assert any("3 drives or loads have no common period" in text for text in report.reasons)


@pytest.mark.slow_except("0.2*")
@pytest.mark.parametrize(
    ("amplitude", "expected", "exponent"),
    [
        (0.2, "quasi-periodic", None),
        (0.55, "undecided", -0.162),
        (1.0, "quasi-periodic", None),
    ],
)
def test_two_torques_on_a_pendulum(amplitude, expected, exponent):
    """Strange and nonchaotic at 0.55, which a finite number of points cannot prove."""
    report = verdict(two_torques(amplitude))
    assert report.verdict == expected, report.reasons
    assert any("strange nonchaotic" in text for text in report.reasons) is (expected == "undecided")
    if exponent is not None:
        assert float(report.exponents.exponent[0]) == pytest.approx(exponent, abs=0.016)


@pytest.mark.slow_except("0.28*")
@pytest.mark.parametrize(("force", "expected"), [(0.28, "quasi-periodic"), (0.5, "chaotic")])
def test_a_weak_force_without_a_common_period(force, expected):
    """A cycle of two becomes a torus of two branches, and chaos remains."""
    report = verdict(oscillator(duffing(force, slider="m") + "+0.001*cos(sqrt(2)*t)"))
    assert report.verdict == expected, report.reasons


KAPITZA = """\
name: Kapitza's pendulum
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {pivot: {joint: P, through: O, angle: 90 deg, mass: 1}}
bars: {rod: {joints: [P, Q], length: 1}}
masses: {Q: 1 kg}
drives: {pivot: {law: "0.1*cos(80*t)"}}
dampers: [{bars: [ground, rod], damping: 0.3}]
free: {rod: {angle: 90 deg}}
simulate: {end: 1}
"""


def test_what_stands_on_a_vibrating_pivot_is_not_at_rest():
    """Upright, with a pivot that is fast enough: P. L. Kapitza (1951)."""
    report = verdict(linkages.loads(KAPITZA), periods=400)
    assert (report.verdict, report.period) == ("periodic", 1), report.reasons
    still = KAPITZA.replace('{law: "0.1*cos(80*t)"}', "{position: 0, speed: 0}").replace(
        "90 deg}}", "-90 deg}}"
    )
    report = verdict(linkages.loads(still), periods=200)
    assert (report.verdict, report.reasons[1]) == ("at rest", "Nothing moves.")


@pytest.mark.parametrize(("force", "expected"), [(0.28, ("periodic", 2)), (0.5, ("chaotic", None))])
def test_a_small_coordinate_on_a_large_crank_is_not_at_rest(force, expected):
    """Micrometres along a crank of a metre, less the centrifugal force."""
    text = f"""\
name: Slider on a crank
joints: {{O: [0, 0]}}
bars: {{crank: {{joints: [O, A], length: 1, mass: 1}}}}
sliders: {{b: {{joint: B, on: crank, through: O, mass: 1}}}}
loads: [{{slider: b, force: "{duffing(force, size=1e-6)}-1.44*b.position"}}]
drives: {{crank: {{angle: 0, speed: 1.2}}}}
free: {{b: {{position: 1e-6}}}}
simulate: {{end: 1}}
"""
    report = verdict(linkages.loads(text), periods=200)
    assert (report.verdict, report.period) == expected, report.reasons


@pytest.mark.slow
def test_lengths_have_rates_in_metres_per_second_and_no_libration():
    report = verdict(sliders(LINEAR, duffing(0.28), 1.0), periods=200)
    assert report.rotation == {}
    rates = report.to_dict()["mean_rates"]
    assert {name: rate["units"] for name, rate in rates.items()} == {"a": "m/s", "b": "m/s"}
    assert abs(rates["a"]["value"]) < 1e-6
    turning = verdict(pendulum(0.5), periods=200).to_dict()
    assert turning["mean_rates"]["arm"]["units"] == "rad/s"
    assert turning["mean_rates"]["arm"]["value"] == turning["rotation"]["arm"]["rate"]
