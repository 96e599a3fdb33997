"""Integrals over time against exact ones: of speeds, accelerations and powers that may jump.

Means do not depend on how many samples were asked for. Tolerances of 1e-9 are relative to the
largest magnitude of what is integrated: steps are that accurate at most, quadratures more so.
"""

import math

import numpy as np
import pytest

import linkages
from linkages.reading.document import shipped
from linkages.solution.quadrature import PRECISION, integrals

SAMPLES = 3, 11, 101, 1001

LONG = {"ninebar": 50, "ninebar-rotating": 50, "n-four-bar": 10, "slider-crank-contact": 4}
"""Mechanisms whose motions take long to compute, and the part of them that is enough."""

BALL = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {ball: {joint: P, through: O, angle: 90 deg, mass: 0.3}}
stops: [{slider: ball, lower: 0, restitution: %g}]
free: {ball: {position: 1, speed: 0}}
"""
PUSHED = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
loads: [{slider: m, force: "where(sin(3*t)>0.2, 2, -1)"}]
free: {m: {position: 0, speed: 0}}
"""
SHAPER = """
gravity: [0, -9.81]
joints: {O: [0, 0], P: [0, 300 mm]}
bars:
  crank: {joints: [P, A], length: 120 mm, mass: 8}
  arm: {joints: [O, B], length: 640 mm, mass: 12}
  rod: {joints: [B, C], length: 200 mm, mass: 4}
sliders:
  block: {joint: A, on: arm, through: O, mass: 1}
  ram: {joint: C, through: [0, 600 mm], mass: 60}
assembly: {B: [100 mm, 620 mm], C: [300 mm, 600 mm]}
drives: {crank: {angle: 90 deg, speed: 60 rpm}}
loads:
  - slider: ram
    force: where(ram.velocity < 0 m/s and -150 mm < ram.position - 200 mm < 150 mm, 2 kN, 0 N)
simulate: {end: 1}
"""
CLEARANCE = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [130 mm, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.3}
  coupler: {joints: [A, B], length: 120 mm, mass: 0.25}
  rocker: {joints: [D, B], length: 90 mm, mass: 0.4}
clearances: {gap: {joint: B, bar: coupler, size: 0.2 mm, contact: restitution, restitution: 0.6}}
drives: {crank: {angle: 0, speed: 600 rpm}}
assembly: {B: left}
simulate: {end: 0.1}
"""
SLIDER_CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
drives: {crank: {law: "%s"}}
assembly: {B: [0.18, 0]}
"""


def bounces(restitution, end):
    """Mean of the speed of the ball and root of the mean of its square, flight by flight."""
    gravity = 9.81
    time = math.sqrt(2 / gravity)
    speed, square, place = gravity * time, gravity**2 * time**3 / 3, 0.0
    while time < end and speed > 1e-12:
        speed *= restitution
        lasting = min(2 * speed / gravity, end - time)
        square += (speed**3 - (speed - gravity * lasting) ** 3) / (3 * gravity)
        place = speed * lasting - 0.5 * gravity * lasting**2
        time += lasting
    return (place - 1) / end, math.sqrt(square / end)


def measured(mechanism, measures, **options):
    """Measures of a motion by itself, and of one in a sweep."""
    solution = linkages.simulate(mechanism, **options)
    alone = [linkages.measure(solution, each) for each in measures]
    data = linkages.sweep(mechanism, {"gravity[1]": [-9.81, -9.8]}, measures, **options)
    names = [each.replace("/", "÷") for each in measures]
    assert [data[name].to_numpy()[0] for name in names] == alone
    return alone


def off(solution, rate, place):
    """Error of the mean of a rate, beside the largest magnitude of the rate."""
    ends = [
        linkages.measure(solution, f"at({time!r} s, {place})")
        for time in (float(solution.data.time[0]), float(solution.data.time[-1]))
    ]
    span = float(solution.data.time[-1] - solution.data.time[0])
    mean = linkages.measure(solution, f"mean({rate})")
    largest = linkages.measure(solution, f"max(abs({rate}))")
    return abs(mean - (ends[1] - ends[0]) / span), largest


def check_rates(solution, most=3, accelerations=True):
    """Means of speeds and accelerations of some bodies against what they change."""
    bodies = {n: b for n, b in solution.mechanism.bodies.items() if n in moving(solution)}
    found = []
    for name, body in [*bodies.items()][-most:]:
        place, rate = ("angle", "speed") if body.rotates else ("position", "velocity")
        found.append(off(solution, f"{name}.{rate}", f"{name}.{place}"))
        if accelerations:
            found.append(off(solution, f"{name}.acceleration", f"{name}.{rate}"))
    for kind in (found[::2], found[1::2]) if accelerations else (found,):
        size = max(largest for _, largest in kind)  # bodies that only translate do not turn
        assert max(error for error, _ in kind) <= 1e-9 * size


def moving(solution):
    """Bodies that turn or slide themselves, without those that stand for clearances."""
    dims = solution.data.drop_vars("time").coords
    return {str(n) for d in ("bar", "slider") if d in dims for n in dims[d].to_numpy()}


@pytest.mark.parametrize("samples", SAMPLES)
@pytest.mark.parametrize("restitution", [1.0, 0.7])
def test_the_mean_speed_of_a_ball_that_bounces(restitution, samples):
    measures = ["mean(ball.velocity)", "rms(ball.velocity)"]
    found = measured(linkages.loads(BALL % restitution), measures, end=2.0, samples=samples)
    assert found == pytest.approx(bounces(restitution, 2.0), rel=1e-9)


@pytest.mark.parametrize("samples", [3, 40])
def test_a_motion_backward_in_time(samples):
    times = np.linspace(0, -5, samples)
    check_rates(linkages.simulate(linkages.loads(PUSHED), times=times))


@pytest.mark.parametrize("samples", SAMPLES)
def test_the_mean_acceleration_under_a_force_that_jumps(samples):
    solution = linkages.simulate(linkages.loads(PUSHED), end=5.0, samples=samples)
    edges = np.array([np.arcsin(0.2), np.pi - np.arcsin(0.2)])
    turns = 2 * np.pi * np.arange(3)
    high = np.clip((edges[None] + turns[:, None]) / 3, 0.0, 5.0)
    exact = -1 + 3 * float((high[:, 1] - high[:, 0]).sum()) / 5
    assert linkages.measure(solution, "mean(m.acceleration)") == pytest.approx(exact, rel=1e-12)


@pytest.mark.slow_except("3")
@pytest.mark.parametrize("samples", [3, 26, 1001])
def test_the_mean_torque_of_a_shaper_is_the_work_of_its_cut(samples):
    """Nothing is integrated, and where the cut begins follows from the position of the ram."""
    found = measured(linkages.loads(SHAPER), ["mean(crank.effort)"], samples=samples)
    assert found == pytest.approx([2000 * 0.3 / (2 * np.pi)], rel=1e-9)


@pytest.mark.parametrize("width", ["5e-5", "1e-6"])
def test_a_short_push_in_a_driven_motion_is_found(width):
    """Its condition is followed along the motion, and heads for zero on both sides."""
    push = f"loads: [{{bar: crank, torque: 'where(abs(t - 0.40009) < {width}, -5, 0)'}}]"
    bare, pushed = (
        linkages.simulate(linkages.loads(SLIDER_CRANK % "0.3 + t" + more), end=0.8, samples=3)
        for more in ("", push)
    )
    found = [linkages.measure(each, "mean(crank.effort)") for each in (bare, pushed)]
    assert found[1] - found[0] == pytest.approx(5 * 2 * float(width) / 0.8, rel=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("samples", [3, 101])
def test_rates_in_a_rigid_clearance(samples):
    solution = linkages.simulate(linkages.loads(CLEARANCE), samples=samples)
    check_rates(solution, accelerations=False)  # impulses are none of the accelerations
    data = linkages.sweep(
        solution.mechanism, {"gravity[1]": [-9.81, -9.8]}, "mean(rocker.speed)", samples=samples
    )
    alone = linkages.measure(solution, "mean(rocker.speed)")
    assert data["mean(rocker.speed)"].to_numpy()[0] == alone


@pytest.mark.slow_except("four-bar", "five-bar", "ninebar")
@pytest.mark.parametrize("name", sorted(shipped()))
def test_rates_of_shipped_mechanisms(name):
    mechanism = linkages.load(name)
    end = mechanism.simulation.end / LONG.get(name, 1)
    for samples in (3, 101):
        solution = linkages.simulate(mechanism, end=end, samples=samples)
        # rates jump at impacts, by no acceleration
        check_rates(solution, accelerations=name != "impact-oscillator")


@pytest.mark.parametrize("samples", [3, 26])
def test_work_of_a_drive_whose_law_jumps(samples):
    """Its acceleration jumps, and with it the power that the parts take."""
    law = "where(t < 37.7 ms, 900*t**2, 900*(37.7 ms)**2 + 1800*37.7 ms*(t - 37.7 ms))"
    mechanism = linkages.loads(SLIDER_CRANK % law.replace("37.7 ms", "0.0377"))
    outputs = ["energy_residual", "kinetic_energy"]
    data = linkages.simulate(mechanism, end=0.1, samples=samples, outputs=outputs).data
    scale = float(data.kinetic_energy.max())
    assert float(abs(data.energy_residual).max()) < 1e-10 * scale
    solution = linkages.simulate(mechanism, end=0.1, samples=samples)
    gained = linkages.measure(solution, "final(kinetic_energy) - at(0 s, kinetic_energy)")
    power = linkages.measure(solution, "mean(crank.effort*crank.speed)")
    assert power == pytest.approx(gained / 0.1, rel=1e-9)


@pytest.mark.parametrize("samples", [3, 50])
def test_formulas_of_measures_bend_and_jump(samples):
    solution = linkages.simulate(linkages.loads(SLIDER_CRANK % "t"), end=5.0, samples=samples)
    found = linkages.measure(solution, "mean(abs(sin(3*crank.angle)))")
    bent = (4 * 2 + 1 - math.cos(15 - 4 * math.pi)) / 3 / 5
    assert found == pytest.approx(bent, rel=1e-10)
    found = linkages.measure(solution, "rms(where(crank.angle > 1, 2, 0))")
    assert found == pytest.approx(math.sqrt(4 * 4 / 5), rel=1e-9)


def test_a_mean_over_a_pole_is_none():
    solution = linkages.simulate(linkages.loads(SLIDER_CRANK % "t"), end=2.0, samples=30)
    with pytest.raises(linkages.ComputationError, match="no finite value"):
        linkages.measure(solution, "mean(1/(crank.angle - 0.7))")


@pytest.mark.slow_except("1")
@pytest.mark.parametrize("seed", range(4))
def test_rates_of_a_random_chain_between_stops_under_loads_that_jump(seed):
    """Speeds that impacts change, and accelerations that forces change, each over a second."""
    draw = np.random.default_rng(seed)
    restitution, level, rate, speed = draw.uniform([0.2, 0.1, 2, -2], [0.9, 0.6, 9, 2])
    mechanism = linkages.loads(f"""
        gravity: [0, -9.81]
        joints: {{O: [0, 0]}}
        bars:
          upper: {{joints: [O, A], length: 0.4, mass: 1}}
          lower: {{joints: [A, B], length: 0.3, mass: 0.7}}
        free: {{upper: {{angle: -1.2, speed: {speed}}}, lower: {{angle: -1.9, speed: 0.5}}}}
        stops:
          - {{bars: [ground, upper], lower: -2.2, upper: -0.9, restitution: {restitution}}}
        loads:
          - {{bar: lower, torque: "where(sin({rate}*t) > {level}, 2, -1)"}}
          - {{bar: lower, torque: "where(lower.angle > -1.5, -1, 1)"}}
    """)
    for samples in (3, 101):
        solution = linkages.simulate(mechanism, end=1.5, samples=samples)
        assert sum(each.count for each in solution.motion.changes.values()) > 4
        check_rates(solution, accelerations=False)
        # impulses are none of it, so that there is no change to compare it with
        mean = "mean(lower.acceleration)"
        assert linkages.measure(solution, mean) == pytest.approx(
            linkages.measure(linkages.simulate(mechanism, end=1.5, samples=37), mean), rel=1e-9
        )


def test_a_mean_over_impacts_that_are_not_recorded_is_refused():
    """Some 14,000 impacts; whoever asks for the end as well gets it."""
    low = BALL.replace("position: 1,", "position: 0.001,") % 1.0
    mechanism, mean = linkages.loads(low), "mean(ball.velocity)"
    reason = r"'stops\[0\].lower: touch' changes 14\d\d\d times, of which 10000 are recorded"
    with pytest.raises(linkages.ComputationError, match=reason):
        linkages.measure(linkages.simulate(mechanism, end=400, samples=3), mean)
    vary = {"sliders.ball.mass": [0.3, 0.4]}
    data = linkages.sweep(mechanism, vary, [mean, "final(t)"], end=400, samples=3)
    assert np.isnan(data[mean]).all()
    assert data["final(t)"].to_numpy().tolist() == [400.0, 400.0]
    assert "expected a shorter motion" in str(data["reason"].to_numpy()[0])


@pytest.mark.parametrize("samples", [3, 101])
def test_the_mean_number_of_touches(samples):
    """It rises by one at every impact: the mean is that of the times left behind each."""
    mechanism = linkages.loads(CLEARANCE)
    solution = linkages.simulate(mechanism, samples=samples, outputs=["touches"])
    changes = solution.motion.changes["gap: touch"]
    times = changes.time[changes.rises]
    assert len(times) > 10
    mean = linkages.measure(solution, "mean(gap.touches)")
    assert mean == pytest.approx(np.sum(0.1 - times) / 0.1, rel=1e-9)


def quadrature(function, intervals=16):
    edges = np.linspace(0.0, 1.0, intervals + 1)
    group = np.zeros(intervals, dtype=int)
    return integrals(lambda _which, times: function(times), edges[:-1], edges[1:], group).sum()


@pytest.mark.parametrize("place", [0.0, 1e-15, 0.0004, 0.062499, 0.0625, 0.3, 1 / 3, 0.99999])
def test_a_jump_is_found_wherever_it_is(place):
    """Also beside the end of an interval, where rules without ends have no place."""
    found = quadrature(lambda times: np.where(times < place, 1.0, 5.0))
    assert found == pytest.approx(5.0 - 4.0 * place, rel=PRECISION)


def test_noise_and_oscillations():
    noise = np.random.default_rng(1)
    looked = []

    def noisy(times):
        looked.append(len(times))
        return noise.standard_normal(len(times))

    assert abs(quadrature(noisy)) < 0.1
    assert sum(looked) <= 31 * looked[0]  # it is given up after four halvings
    assert quadrature(lambda t: np.sin(300 * t) + 1) == pytest.approx(
        1 + (1 - math.cos(300)) / 300, rel=1e-10
    )
    assert quadrature(lambda t: np.sqrt(np.abs(t - 0.3))) == pytest.approx(
        (0.3**1.5 + 0.7**1.5) / 1.5, rel=1e-9
    )


@pytest.fixture(scope="module", params=SAMPLES)
def flown(request):
    """A shipped mechanism whose pin bounces in its hole, at some number of samples."""
    outputs = ["clearance_normal_dissipation", "slider_position_error", "slider_velocity_error",
               "slider_acceleration_error"]  # fmt: skip
    mechanism = linkages.load("slider-crank-contact")
    run = {"end": 0.004, "samples": request.param, "rtol": 1e-11}
    return linkages.simulate(mechanism, outputs=outputs, **run)


@pytest.mark.slow_except("11", "101")
def test_the_mean_deviation_from_the_ideal_mechanism(flown):
    """Means of rates are what the deviation and its rate change by, over the time."""
    assert len(flown.motion.changes) > 0
    for rate, of in (("velocity", "position"), ("acceleration", "velocity")):
        mean, end, start, largest = (
            linkages.measure(flown, f"{form} piston.{name}_error)")
            for form, name in (("mean(", rate), ("final(", of), ("at(0 s,", of), ("max(", rate))
        )
        # what is dissipated is integrated for some measures alone: steps and motions differ a bit
        assert mean == pytest.approx((end - start) / 0.004, abs=1e-6 * largest)


def test_the_mean_of_what_has_been_dissipated(flown):
    """By parts: a power counts as long as what follows it lasts."""
    mean, parts = (
        linkages.measure(flown, f"mean({text})")
        for text in ("gap.normal_dissipation", "(0.004 s - t)*gap.normal_loss")
    )
    # between the samples of a touch, at least 40, it is a straight line
    assert mean == pytest.approx(parts, rel=1e-5)


def test_a_sweep_has_the_mean_of_one_motion(flown):
    text = "mean(abs(piston.velocity_error))"
    samples = flown.data.sizes["time"]
    found = linkages.sweep(
        flown.mechanism, {"sliders.piston.mass": [0.14, 0.15]}, text,
        end=0.004, samples=samples, rtol=1e-11,
    )  # fmt: skip
    assert found[text].to_numpy()[0] == pytest.approx(linkages.measure(flown, text), rel=1e-6)
