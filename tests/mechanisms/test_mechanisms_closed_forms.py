"""Driven mechanisms of the library whose motion has a closed form."""

import numpy as np
import pytest
from library_runs import TURN, column, meeting, place, results, unit, whole_run

G = 9.81


def test_slider_crank():
    """x = r cos θ + √(l² − r² sin² θ) and its derivatives."""
    data = whole_run("slider-crank").data
    r, rod, speed = 0.04, 0.14, 1500 / 60 * TURN
    angle = speed * data.time.to_numpy()
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(rod**2 - (r * s) ** 2)
    first = -(r**2) * s * c * speed / root
    second = (-(r**2) * (c**2 - s**2) * speed**2 - first**2) / root
    # 0.2 m, 10 m/s and 1e3 m/s²; the angle, up to 13 rad, is off by some 1e-15
    assert column(data, "slider_position", "piston") == pytest.approx(r * c + root, abs=1e-15)
    velocity = -r * s * speed + first
    assert column(data, "slider_velocity", "piston") == pytest.approx(velocity, abs=1e-13)
    acceleration = -r * c * speed**2 + second
    assert column(data, "slider_acceleration", "piston") == pytest.approx(acceleration, abs=1e-11)


def test_crank_rocker():
    """Freudenstein's equation, and the coupler curve from both ends of the coupler.

    F. Freudenstein, Trans. ASME 76, 853 (1954): K₁ cos θ₄ − K₂ cos θ₂ + K₃ = cos(θ₂ − θ₄).
    """
    data = whole_run("four-bar").data
    a, b, c, d = 0.04, 0.12, 0.08, 0.1
    crank, coupler, rocker = (column(data, "bar_angle", n) for n in ("crank", "coupler", "rocker"))
    k1, k2, k3 = d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)
    off = k1 * np.cos(rocker) - k2 * np.cos(crank) + k3 - np.cos(crank - rocker)
    assert np.abs(off).max() < 1e-14  # terms up to 2.5
    assert np.all(np.sin(coupler - rocker) < 0)  # never in line, always open
    across = np.array([-np.sin(coupler), np.cos(coupler)])
    point = a * unit(crank) + 0.05 * unit(coupler) + 0.045 * across
    assert place(data, "P") == pytest.approx(point, abs=1e-15)


def test_five_bar():
    """The arms' circles about both crank pins meet in B."""
    data = whole_run("five-bar").data
    first = 0.2 * unit(TURN / 4 + TURN * data.time.to_numpy())
    second = 0.2 * unit(TURN / 4 - 2 * TURN * data.time.to_numpy()) + [[0.6], [0]]
    # the square root loses digits where the arms are nearly in line: 1/0.3
    assert place(data, "B") == pytest.approx(meeting(first, second, 0.6, 0.6, 1), abs=5e-15)


def test_scotch_yoke_is_a_pure_sine():
    data = whole_run("scotch-yoke").data
    r, speed = 0.05, 2 * TURN
    angle = speed * data.time.to_numpy()
    s, c = np.sin(angle), np.cos(angle)
    assert column(data, "slider_position", "yoke") == pytest.approx(r * c, abs=1e-15)
    assert column(data, "slider_position", "pin") == pytest.approx(r * s, abs=1e-15)
    assert column(data, "slider_velocity", "yoke") == pytest.approx(-r * speed * s, abs=1e-14)
    assert column(data, "slider_acceleration", "yoke") == pytest.approx(
        -r * speed**2 * c, abs=1e-13
    )
    # only the yoke gains and loses energy; crank (centre at r/2) and pin are lifted
    effort = 1.5 * r**2 * speed**2 * s * c + (0.3 / 2 + 0.05) * G * r * c
    assert column(data, "drive_effort", "crank") == pytest.approx(effort, abs=1e-13)


def test_peaucellier_draws_a_straight_line():
    """Q is the inverse of P: OP = 2 r cos(φ/2) in the direction φ/2, and OP·OQ = l² − s²."""
    data = whole_run("peaucellier").data
    angle = 1.2 * np.sin(TURN * data.time.to_numpy())
    x, y = place(data, "Q")
    # two dyads, whose angles are 30° at least
    assert np.abs(x - 0.5).max() < 1e-14
    assert y == pytest.approx(0.5 * np.tan(angle / 2), abs=1e-14)
    velocity = data.joint_velocity.sel(joint="Q", axis="x")
    assert np.abs(velocity).max() < 1e-13  # of up to 7 m/s along y


def test_quick_return():
    """The arm points from O to the crank pin; the rod reaches from its end to the ram's axis."""
    data = whole_run("quick-return").data
    c, r, arm, rod, height, speed = 0.1, 0.05, 0.25, 0.1, 0.235, TURN
    crank = speed * data.time.to_numpy()
    pin = r * unit(crank) + [[0], [c]]
    distance = np.hypot(*pin)
    angle = np.arctan2(pin[1], pin[0])
    assert column(data, "bar_angle", "arm") == pytest.approx(angle, abs=2e-15)
    assert column(data, "slider_position", "block") == pytest.approx(distance, abs=1e-15)
    rate = speed * r * (r + c * np.sin(crank)) / distance**2
    assert column(data, "bar_speed", "arm") == pytest.approx(rate, abs=1e-13)
    sliding = speed * r * c * np.cos(crank) / distance
    assert column(data, "slider_velocity", "block") == pytest.approx(sliding, abs=1e-14)
    rise = height - arm * np.sin(angle)
    ram = arm * np.cos(angle) + np.sqrt(rod**2 - rise**2)
    assert column(data, "slider_position", "ram") == pytest.approx(ram, abs=1e-15)
    assert np.degrees([angle.min(), angle.max()]) == pytest.approx([60, 120], abs=1e-3)


def test_quick_return_takes_twice_as_long_one_way():
    """The arm is at its extremes where the crank is square to it: at −30° and 210°."""
    extremes = {"drives.crank.angle": "-30 deg"}
    data = results("quick-return", extremes, end=1.0, samples=4, outputs=["bar_speed"])
    at_rest = column(data, "bar_speed", "arm")[[0, 2, 3]]
    assert at_rest == pytest.approx(np.zeros(3), abs=1e-13)


def test_dwell_of_the_six_bar():
    """G from circles alone; the arm rests within 0.4° of 26.8° while the crank turns by 110°."""
    data = whole_run("stephenson-six-bar").data
    crank_pin = 0.04 * unit(TURN / 2 + TURN * data.time.to_numpy())
    ground = np.array([[0.08], [0.0]])
    apex = meeting(crank_pin, ground, 0.1, 0.1, 1)
    along = (apex - crank_pin) / 0.1
    across = np.array([-along[1], along[0]])
    point = crank_pin + 0.180902 * along - 0.058779 * across
    pivot = np.array([[0.291], [0.184]])
    # left of the line from P to D; the two links never come nearer to a line than 48°
    expected = meeting(point, pivot, 0.1296, 0.144, 1)
    assert place(data, "G") == pytest.approx(expected, abs=1e-14)
    arm = np.degrees(column(data, "bar_angle", "arm"))
    dwell = np.abs(np.degrees(TURN * data.time)) <= 55
    assert np.ptp(arm) == pytest.approx(26.8, abs=0.1)
    assert np.ptp(arm[dwell.to_numpy()]) < 0.4


def test_toggle_press():
    """The ram is twice the height of the toggle's middle below its upper end."""
    data = whole_run("toggle-press").data
    assert column(data, "slider_position", "ram") == pytest.approx(
        -2 * place(data, "B")[1], abs=1e-15
    )
    reach = np.hypot(*(place(data, "B") - [[-0.33], [-0.19]]))
    # crank and rod in line, once per turn between two samples: 0.03 m (2π/500)²/8
    assert reach.max() == pytest.approx(0.29 + 0.03, abs=1e-6)
    upper = np.degrees(column(data, "bar_angle", "upper"))
    assert (upper + 90).max() == pytest.approx(-2.9, abs=0.05)


def test_crane_head_stays_level():
    data = whole_run("double-rocker").data
    x, y = place(data, "P")
    assert np.ptp(x) > 0.6
    assert np.ptp(y) < 3e-3
    jib = column(data, "bar_angle", "jib")
    part = np.clip((data.time.to_numpy() - 0.5) / 3, 0, 1)
    cycloid = part - np.sin(TURN * part) / TURN
    assert np.degrees(jib) == pytest.approx(80 - 40 * cycloid, abs=1e-13)
