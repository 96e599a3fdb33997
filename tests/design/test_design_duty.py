"""Duties of drives: closed forms, and a shaft that its flywheel evens out as it should."""

import math

import numpy as np
import pytest

import linkages

OMEGA = 20.0
SHAFT = f"""
joints: {{O: [0, 0]}}
bars: {{crank: {{points: {{O: [0, 0], A: [0.1, 0]}}, mass: 1, center: [0, 0], inertia: 0.01}}}}
loads: [{{bar: crank, torque: "-(5 + 3*sin(crank.angle))"}}]
drives: {{crank: {{angle: 0, speed: {OMEGA}}}}}
simulate: {{end: 2}}
"""


def of_crank(data, *names):
    return [float(data[name].sel(drive="crank")) for name in names]


def test_numbers_of_a_sine():
    """The drive gives 5 + 3 sin θ: integrals of sines by hand."""
    data = linkages.duty(linkages.loads(SHAFT), fluctuation=0.02)
    assert data.attrs["cycle"] == pytest.approx(2 * math.pi / OMEGA, rel=1e-14)
    found = of_crank(data, "effort_peak", "effort_rms", "effort_mean", "power_peak", "power_mean")
    expected = [8.0, math.sqrt(25 + 4.5), 5.0, 8.0 * OMEGA, 5.0 * OMEGA]
    # the peak lies between two of 4096 samples, (π/4096)²/2 of the amplitude off at most
    assert found == pytest.approx(expected, rel=1e-6)
    assert found[1:3] == pytest.approx(expected[1:3], rel=1e-13)
    given, returned = of_crank(data, "energy_given", "energy_returned")
    assert (given, returned) == (pytest.approx(5.0 * 2 * math.pi, rel=1e-13), 0.0)
    fluctuation, flywheel = of_crank(data, "energy_fluctuation", "flywheel")
    assert fluctuation == pytest.approx(6.0, rel=1e-6)  # of −3 cos θ
    assert flywheel == pytest.approx(6.0 / (0.02 * OMEGA**2), rel=1e-6)
    assert data.attrs["warning"] == ""


@pytest.mark.parametrize("wanted", [0.02, 0.1])
def test_a_shaft_with_its_flywheel_fluctuates_as_wanted(wanted):
    """The drive is let go: a constant torque turns the shaft, and its speed is integrated."""
    data = linkages.duty(linkages.loads(SHAFT), fluctuation=wanted)
    flywheel, mean = of_crank(data, "flywheel", "effort_mean")
    loose = SHAFT.replace("inertia: 0.01", f"inertia: {flywheel!r}").replace(
        "loads: [", f"loads: [{{bar: crank, torque: {mean!r}}}, "
    )  # the inertia of the shaft turns at constant speed: the flywheel has all of it
    # it is fastest at θ = 0, and ω²_max − ω²_min = 2 ΔE/J is exact with the mean of both speeds
    start = OMEGA * (1.0 + 0.5 * wanted)
    loose = loose.replace("drives:", "free:").replace(f"speed: {OMEGA}", f"speed: {start!r}")
    speed = linkages.simulate(linkages.loads(loose), end=1.0, samples=20001).data.bar_speed
    low, high = float(speed.min()), float(speed.max())
    # samples miss the least speed by (20 rad/s · 0.05 ms/2)²/2 of the fluctuation at most
    assert (high - low) / (0.5 * (high + low)) == pytest.approx(wanted, rel=2e-6)


def test_a_motor_beside_what_is_needed():
    """At 20 rad/s a motor of 30 N m and 60 rad/s has 20 N m left, for 8 N m at most."""
    data = linkages.duty(linkages.loads(SHAFT), motors={"crank": linkages.MotorLine(30.0, 60.0)})
    margin, time = of_crank(data, "margin", "margin_time")
    assert margin == pytest.approx(20.0 / 8.0, rel=1e-6)
    assert math.sin(OMEGA * time) == pytest.approx(1.0, abs=1e-6)
    # behind a gear: three times the effort, at a third of the speed
    geared = linkages.duty(linkages.loads(SHAFT), motors=["crank=10 N m, 180 rad/s, 3"])
    assert of_crank(geared, "margin")[0] == pytest.approx(margin, rel=1e-12)


def test_a_motor_that_brakes_gives_no_more_than_at_rest():
    braked = SHAFT.replace("-(5", "(5")
    data = linkages.duty(linkages.loads(braked), motors=["crank=30 N m, 60 rad/s"])
    assert of_crank(data, "margin")[0] == pytest.approx(30.0 / 8.0, rel=1e-6)


def test_actuators_have_duties_and_efforts_of_their_own():
    made = linkages.loads("""
joints: {O: [0, 0]}
gravity: [0, -9.81]
bars: {upper: {joints: [O, A], length: 0.4, mass: 2}, fore: {joints: [A, P], length: 0.3, mass: 1}}
drives: {P: {x: 0.4 + 0.1*cos(2*pi*t), y: 0.2 + 0.1*sin(2*pi*t)}}
actuators: {shoulder: {bar: upper}, elbow: {bars: [upper, fore]}}
assembly: {A: left}
""")
    data = linkages.duty(made, fluctuation=0.05, motors=["elbow=4 N m, 60 rpm"])
    run = linkages.simulate(made, samples=2001).data
    assert data.attrs["cycle"] == 1.0
    for name in ("shoulder", "elbow"):
        own = run.drive_effort.sel(drive=name).values
        turned = run.rotary_actuator_speed.sel(rotary_actuator=name).values
        found = data.sel(drive=name)
        # 2000 and 4096 samples of the same smooth motion
        assert float(found.effort_peak) == pytest.approx(np.abs(own).max(), rel=1e-5)
        assert float(found.effort_rms) == pytest.approx(np.sqrt(np.mean(own[1:] ** 2)), rel=1e-10)
        assert float(found.power_mean) == pytest.approx(np.mean((own * turned)[1:]), abs=1e-9)
        assert np.isnan(found.flywheel)  # neither turns steadily
    assert np.isfinite(data.margin.sel(drive="elbow"))
    assert np.isnan(data.margin.sel(drive="shoulder"))


def test_what_is_less_certain_is_said():
    jumping = SHAFT.replace("3*sin(crank.angle)", "3*sign(sin(crank.angle) - 0.3)")
    warning = linkages.duty(linkages.loads(jumping), fluctuation=0.02).attrs["warning"]
    assert "of crank: jumps or peaks in the cycle, good to about 0.0" in warning
    rising = (
        SHAFT.replace(f"speed: {OMEGA}", "speed: 1")
        .replace("angle: 0", "angle: 0")
        .replace("{angle: 0, speed: 1}", "{law: {run-up: {speed: 20, duration: 1}}}")
    )
    data = linkages.duty(linkages.loads(rising))
    assert data.attrs["cycle"] == 2.0
    assert data.attrs["warning"].startswith("the cycle is the whole run of 2 s: the law of drive")


@pytest.mark.parametrize(
    ("options", "found"),
    [
        ({"fluctuation": 0.0}, "fluctuation must be between 0 and 1, found 0"),
        ({"motors": ["crnk=1 N m, 10 rpm"]}, "unknown drive 'crnk'"),
        ({"motors": ["crank=1 N m"]}, "expected a motor such as 'crank=30 N m, 1500 rpm'"),
        ({"motors": ["crank=1 N, 10 rpm"]}, "motors: crank: expected a torque"),
        ({"motors": ["crank=-1 N m, 10 rpm"]}, "motors: crank: expected a torque > 0"),
        ({"motors": {"crank": linkages.MotorLine(1.0, 0.0)}}, "expected numbers > 0"),
    ],
)
def test_bad_requests(options, found):
    with pytest.raises(ValueError, match=found):
        linkages.duty(linkages.loads(SHAFT), **options)


def test_what_nothing_drives_has_no_duty():
    with pytest.raises(ValueError, match="nothing is driven"):
        linkages.duty(linkages.load("double-pendulum"))
