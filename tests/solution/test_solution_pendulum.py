"""Motions with free coordinates against elliptic functions and textbook equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk
from solution_mechanisms import GRAVITY, double_pendulum, mechanism, pendulum

import linkages

LENGTH = 0.7


def swing(amplitude, time):
    """Angle from the vertical of a pendulum released at rest (Whittaker, section 44)."""
    modulus = np.sin(amplitude / 2) ** 2
    sn, *_ = ellipj(ellipk(modulus) - np.sqrt(GRAVITY / LENGTH) * time, modulus)
    return 2 * np.arcsin(np.sin(amplitude / 2) * sn)


# Errors of 1e-11 per step add up to some tens. Released 0.04 rad from the top, errors grow by
# 2/0.04 on every way up and down again: measured 1.5e-8.
@pytest.mark.parametrize(("amplitude", "limit"), [(0.1, 2e-10), (2.0, 2e-10), (3.1, 5e-8)])
def test_pendulum_against_elliptic_functions(amplitude, limit):
    data = linkages.simulate(pendulum(amplitude), end=5.0, samples=501, rtol=1e-11).data
    angle = data.bar_angle[:, 0] + np.pi / 2
    assert np.abs(angle - swing(amplitude, data.time)).max() < limit
    tip = data.joint_position.sel(joint="P")
    assert np.allclose(tip.sel(axis="x"), LENGTH * np.sin(angle), rtol=0, atol=1e-15)


@pytest.mark.parametrize("amplitude", [2.0])
def test_rk4_observed_order(amplitude):
    steps = np.array([4e-3, 2e-3, 1e-3])
    errors = []
    for step in steps:
        data = linkages.simulate(
            pendulum(amplitude), end=2.0, samples=21, method="rk4", step=step, outputs=["bar_angle"]
        ).data
        errors.append(np.abs(data.bar_angle[:, 0] + np.pi / 2 - swing(amplitude, data.time)).max())
    slope, _ = np.polyfit(np.log(steps), np.log(errors), 1)
    assert slope == pytest.approx(4.0, abs=0.1)


def test_pendulum_turning_over_counts_its_turns():
    """Started fast enough it never turns back: the angle grows without a jump."""
    rod = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 0.7, mass: 1, center: 0.7, inertia: 0}}\n"
        "free: {rod: {angle: -90 deg, speed: 15}}\n"
    )
    solution = linkages.simulate(rod, end=10.0, samples=1001, rtol=1e-11)
    angle = solution.data.bar_angle[:, 0].to_numpy()
    speed = solution.data.bar_speed[:, 0].to_numpy()
    assert angle[-1] > 100
    assert np.abs(np.diff(angle)).max() < 0.16
    # ½ L θ̇² − g cos φ is constant; the tolerance adds up over some 25 turns.
    energy = 0.5 * LENGTH * speed**2 + GRAVITY * np.sin(angle)
    assert np.ptp(energy) < 1e-8 * np.abs(energy).max()
    # Kept within one turn, so that large angles cost no digits.
    assert np.abs(solution.motion.state[0]).max() <= 2 * np.pi


def test_compound_pendulum_has_its_textbook_period():
    """T = 2π √(I_O/(m g d)) (1 + φ²/16 + …): a uniform bar, I_O = m L²/3, d = L/2."""
    bar = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\nbars: {bar: {joints: [O, P], length: 1.2, "
        "mass: 2}}\nfree: {bar: {angle: -89 deg}}\n"
    )
    period = 2 * np.pi * np.sqrt(2 * 1.2 / (3 * GRAVITY)) * (1 + np.radians(1.0) ** 2 / 16)
    data = linkages.simulate(bar, end=period, samples=2, rtol=1e-11).data
    # The next term of the series is 11/3072·φ⁴ = 3e-10 of the period, and near the turning point
    # an error of the time enters the angle squared.
    assert float(data.bar_angle[-1, 0]) == pytest.approx(np.radians(-89), abs=1e-11)
    assert float(data.bar_speed[-1, 0]) == pytest.approx(0, abs=1e-8)


def textbook(_, y):
    """Double pendulum, unit masses and lengths, angles from the vertical (any textbook)."""
    a, b, u, v = y
    c, s = np.cos(a - b), np.sin(a - b)
    first = -v * v * s - 2 * GRAVITY * np.sin(a)
    second = u * u * s - GRAVITY * np.sin(b)
    det = 2 - c * c
    return [u, v, (first - c * second) / det, (2 * second - c * first) / det]


def test_double_pendulum_against_its_textbook_equations():
    start = (1.5, 2.5)
    data = linkages.simulate(double_pendulum(*start), end=2.0, samples=201, rtol=1e-12).data
    wanted = solve_ivp(
        textbook, (0, 2), [*start, 0, 0], "DOP853", t_eval=data.time, rtol=1e-12, atol=1e-13
    ).y
    # Two integrations at 1e-12; the motion is chaotic with a rate near 3 1/s: e^(2·3) = 400.
    assert np.abs(data.bar_angle.to_numpy().T + np.pi / 2 - wanted[:2]).max() < 1e-9


def test_double_pendulum_keeps_its_energy():
    data = linkages.simulate(
        double_pendulum(2.0, 2.5), end=5.0, samples=501, rtol=1e-11,
        outputs=["kinetic_energy", "potential_energy", "energy_residual"],
    ).data  # fmt: skip
    total = data.kinetic_energy + data.potential_energy
    # about 2000 steps of relative error 1e-11 on 50 J
    assert float(np.ptp(total.to_numpy())) < 1e-7
    assert np.allclose(data.energy_residual, total - total[0], rtol=0, atol=1e-12)


def test_there_and_back():
    """End a swing, start from its end backwards: the start comes back."""
    forth = linkages.simulate(double_pendulum(1.5, 2.5), end=2.0, samples=3, rtol=1e-12)
    sections = ["upper", "lower"]
    end = forth.data.isel(time=-1)
    back = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\nbars:\n"
        "  upper: {joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}\n"
        "  lower: {joints: [P, Q], length: 1, mass: 1, center: 1, inertia: 0}\n"
        "free:\n"
        + "".join(
            f"  {bar}: {{angle: {float(end.bar_angle.sel(bar=bar))!r}, "
            f"speed: {float(end.bar_speed.sel(bar=bar))!r}}}\n"
            for bar in sections
        )
    )
    data = linkages.simulate(back, end=-2.0, samples=3, rtol=1e-12).data
    assert data.time.to_numpy().tolist() == [0.0, -1.0, -2.0]
    start = forth.data.bar_angle[0].to_numpy()
    # As above: two integrations at 1e-12 and a growth of some hundreds.
    assert np.abs(data.bar_angle[-1].to_numpy() - start).max() < 1e-9
    assert np.abs(data.bar_speed[-1]).max() < 1e-8
    middle = forth.data.bar_angle[1].to_numpy()
    assert np.abs(data.bar_angle[1].to_numpy() - middle).max() < 1e-9


def test_nine_bar_there_and_back():
    forth = linkages.simulate(linkages.load("ninebar"), end=0.2, samples=3, rtol=1e-12)
    end = forth.data.isel(time=-1)
    back = linkages.load(
        "ninebar",
        set={
            "clearances.r1.angle": float(end.clearance_angle[0]),
            "clearances.r1.speed": float(end.clearance_speed[0]),
            **{
                f"drives.{name}.angle": float(end.bar_angle.sel(bar=name))
                for name in forth.mechanism.prescribed
            },
        },
    )
    data = linkages.simulate(back, end=-0.2, samples=3, rtol=1e-12).data
    start = forth.data.isel(time=0)
    # Twice 2000 steps of 1e-12, some tens of swings per second of sensitivity.
    assert float(data.clearance_angle[-1, 0]) == pytest.approx(
        float(start.clearance_angle[0]), abs=1e-9
    )
    assert float(data.clearance_speed[-1, 0]) == pytest.approx(0, abs=1e-6)
    assert np.allclose(data.joint_position[-1], start.joint_position, rtol=0, atol=1e-12)


def test_free_coordinate_chosen_by_default_is_reported():
    rod = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 0.7, mass: 1, center: 0.7, inertia: 0}}\n"
        "assembly: {P: [0.7*0.1, -0.7]}\n"
    )
    solution = linkages.simulate(rod, end=1.0, samples=11)
    assert solution.data.attrs["free"] == "rod"
    assert solution.mechanism.initial["rod"].speed == 0.0
    assert [note for note in solution.notes if note.startswith("rod was chosen as a free")]
    named = linkages.simulate(pendulum(np.arctan(0.1)), end=1.0, samples=11)
    assert named.notes == ()
    assert np.allclose(solution.data.bar_angle, named.data.bar_angle, rtol=0, atol=1e-9)
