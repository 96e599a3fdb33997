"""Loads that have no value at the start or later, springs whose ends meet, and corners."""

import numpy as np
import pytest
from solution_mechanisms import mechanism

import linkages
from linkages import IncompleteError, InputError

BAR = "joints: {O: [0, 0], C: [1, 0]}\nbars: {a: {joints: [O, A], length: 1, mass: 1}}\n"
FREE = "free: {a: {angle: 0, speed: 1}}"
DRIVEN = "drives: {a: {angle: 0, speed: 1}}"


@pytest.mark.parametrize("how", [FREE, DRIVEN])
@pytest.mark.parametrize("law", ["log(t)", "1/t", "log(t-t)", "sqrt(t - 1)"])
def test_at_the_start(how, law):
    """The remedy was a smaller step, or an adaptive method."""
    text = f"loads: [{{bar: a, torque: 1}}, {{joint: A, force: [1, '{law}']}}]"
    with pytest.raises(InputError, match=r"line 4, column \d+, loads\[1\]: cannot act at t = 0 s"):
        linkages.simulate(mechanism(BAR, how, text))


@pytest.mark.parametrize(("law", "time"), [("1/(t - 0.5)", 0.5), ("sqrt(0.7 - t)", 0.7)])
@pytest.mark.parametrize("how", [FREE, DRIVEN])
def test_on_the_way(how, law, time):
    made = mechanism(BAR, how, f"loads: [{{bar: a, torque: 1}}, {{bar: a, torque: '{law}'}}]")
    with pytest.raises(IncompleteError, match=r"loads\[1\]") as caught:
        linkages.simulate(made, end=1.0, samples=1001)
    assert caught.value.time == pytest.approx(time, abs=1.1e-3)  # the samples of a driven motion
    assert "loads[0]" not in str(caught.value)
    assert "smaller step" not in str(caught.value)
    data = caught.value.solution.data
    assert all(np.isfinite(values).all() for values in data.data_vars.values())


@pytest.mark.parametrize("root", ["sqrt({})", "sqrt(abs({}))"])
def test_beyond_its_condition_a_branch_needs_a_value(root):
    """Steps look a little beyond x = 0, where the mode changes; the reason was divergence."""
    slider = "joints: {O: [0, 0]}\nsliders: {m: {joint: P, through: O, mass: 1}}\n"
    law = f"where(m.position > 0, -m.position*{root.format('m.position')}, 0)"
    how = f"free: {{m: {{position: 0.5, speed: -1}}}}\nloads: [{{slider: m, force: '{law}'}}]"
    made = mechanism(slider, how, "")
    if "abs" in root:
        solution = linkages.simulate(made, end=2.0, samples=21)
        # ½ v² + ⅖ x^(5/2) is kept, and nothing acts behind x = 0
        speed = solution.data["slider_velocity"].to_numpy()[-1, 0]
        assert speed == pytest.approx(-((1.0 + 0.8 * 0.5**2.5) ** 0.5), rel=1e-7)
        return
    with pytest.raises(
        IncompleteError, match=r"loads\[0\] \(its active branch is undefined .* sqrt\(abs\(x\)\)"
    ):
        linkages.simulate(made, end=2.0)


# -- springs whose ends meet ------------------------------------------------------------------

MEETING = "springs: [{between: [C, A], stiffness: K, length: L, damping: D}]"


def swinging(stiffness, length, damping, angle=0.0, speed=1.0, samples=401):
    numbers = {"K": stiffness, "L": length, "D": damping}
    text = MEETING
    for letter, value in numbers.items():
        text = text.replace(f": {letter}", f": {value}")
    start = f"free: {{a: {{angle: {angle}, speed: {speed}}}}}"
    made = mechanism(BAR, start, text)
    return linkages.simulate(made, end=4.0, samples=samples, rtol=1e-10, outputs="all").data


def expected(stiffness, damping, angle, speed):
    """The end of a bar (J = 1/3) on a circle: D = 2|sin(θ/2)|, Ḋ² = θ̇² cos²(θ/2); by SciPy."""
    from scipy.integrate import solve_ivp

    def rates(_, y):
        elastic = -stiffness * np.sin(y[0])
        return [y[1], 3 * (elastic - damping * y[1] * np.cos(y[0] / 2) ** 2)]

    found = solve_ivp(rates, (0, 4), [angle, speed], rtol=1e-12, atol=1e-13, method="DOP853")
    return found.y[0, -1]


@pytest.mark.parametrize(("stiffness", "damping"), [(10, 2), (0, 2), (10, 0)])
@pytest.mark.parametrize(("angle", "speed"), [(0.0, 1.0), (0.0, 0.0), (0.3, -1.0)])
def test_a_spring_relaxed_where_its_ends_meet(stiffness, damping, angle, speed):
    """Damped, it ended at t = 0 with the advice to take an adaptive method."""
    data = swinging(stiffness, 0, damping, angle, speed)
    assert float(data.bar_angle[-1, 0]) == pytest.approx(
        expected(stiffness, damping, angle, speed), abs=1e-8
    )
    assert float(np.abs(data.energy_residual).max()) < 1e-8  # of energies of order 1
    if angle == 0.0:
        # along the velocity at which the ends part, as the limit of (r·v)r/|r|²
        assert float(data.bar_acceleration[0, 0]) == pytest.approx(-3 * damping * speed, abs=1e-12)


@pytest.mark.parametrize("tilt", [0.0, 0.7, 2.9])
def test_no_direction_from_round_off(tilt):
    """The ends meet up to round-off only: the damper still acts along the velocity."""
    c, s = float(np.cos(tilt)), float(np.sin(tilt))
    joints = f"joints: {{O: [0.1, -0.2], C: [{0.1 + c!r}, {-0.2 + s!r}]}}\n"
    bars = "bars: {a: {joints: [O, A], length: 1, mass: 1}}\n"
    start = f"free: {{a: {{angle: {tilt!r}, speed: 1}}}}"
    damper = "dampers: [{between: [C, A], damping: 2}]"
    data = linkages.simulate(mechanism(joints, bars, start, damper), end=0.1, samples=3).data
    assert float(data.bar_acceleration[0, 0]) == pytest.approx(-6.0, abs=1e-9)


@pytest.mark.parametrize("how", [FREE, DRIVEN])
@pytest.mark.parametrize("damping", [0, 2])
def test_any_other_spring_has_no_direction_there(how, damping):
    text = f"springs: [{{between: [C, A], stiffness: 3, length: 0.1, damping: {damping}}}]"
    message = (
        r"line 4, column \d+, springs\[0\]: cannot act at t = 0 s: its ends C and A meet, so its "
        r"force has no direction; expected ends that are apart, or .*'length: 0'"
    )
    with pytest.raises(InputError, match=message):
        linkages.simulate(mechanism(BAR, how, text))


def test_a_driven_motion_stops_where_they_meet():
    text = "springs: [{between: [C, A], stiffness: 3, length: 0.1}]"
    made = mechanism(BAR, "drives: {a: {angle: -1, speed: 1}}", text)
    with pytest.raises(IncompleteError, match=r"at t = 1 s, springs\[0\]: its ends C and A meet"):
        linkages.simulate(made, end=2.0, samples=21)


# -- corners of tables ------------------------------------------------------------------------

TIMES, VALUES = (0.0, 0.3, 0.4, 1.1, 1.2, 2.0), (0.0, 0.0, 5.0, 5.0, -3.0, 0.0)


@pytest.mark.parametrize("interpolation", ["linear", "pchip"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10])
def test_steps_in_front_of_corners_keep_the_tolerance(interpolation, rtol):
    """J θ̈ = M(t): the polynomials of the table, integrated twice, are the exact motion."""
    from scipy.interpolate import PchipInterpolator, PPoly

    table = f"times: {list(TIMES)}, values: {list(VALUES)}, interpolation: {interpolation}"
    bar = "joints: {O: [0, 0]}\nbars: {a: {joints: [O, A], length: 1, mass: 1, inertia: 2, "
    load = f"loads: [{{bar: a, torque: {{table: {{{table}}}}}}}]"
    made = mechanism(bar + "center: 0}}\n", "free: {a: {angle: 0, speed: 0}}", load)
    data = linkages.simulate(made, end=2.0, samples=41, rtol=rtol).data
    found = data.bar_angle[:, 0].to_numpy()
    slopes = np.diff(VALUES) / np.diff(TIMES)
    torque = PPoly(np.array([slopes, VALUES[:-1]]), np.array(TIMES))
    if interpolation == "pchip":
        torque = PchipInterpolator(TIMES, VALUES)
    exact = torque.antiderivative(2)(np.linspace(0, 2, 41)) / 2.0
    # A step across a corner is rejected until its error is tolerable. What the five corners leave
    # in the speed moves the angle on to the end: at most 57 times the tolerance here.
    assert np.abs(found - exact).max() < 200 * rtol
