"""Textbook mechanisms: positions, velocities and accelerations in closed form, and cited values."""

import json

import numpy as np
import pytest
from linkage_models import DATA, system_of, values

from linkages.kernel.velocities import Accelerations

REFERENCE = json.loads((DATA / "kinematics.json").read_text(encoding="utf-8"))
TIMES = np.linspace(0, 1.1, 23)


def slider_crank(r, rod, e, speed, angle=0.0, side="[5, 0]"):
    return system_of(f"""
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: {r}}}
  rod: {{joints: [A, B], length: {rod}}}
sliders: {{piston: {{joint: B, through: [0, {e}]}}}}
drives: {{crank: {{angle: {angle}, speed: {speed}}}}}
assembly: {{B: {side}}}
""")


@pytest.mark.parametrize("e", [0.0, 0.1, -0.25])
@pytest.mark.parametrize("sign", [1, -1])
def test_slider_crank(e, sign):
    """x = r cos θ ± √(l² − (r sin θ − e)²) and its derivatives."""
    r, rod, w = 0.3, 0.9, 4.0
    of = slider_crank(r, rod, e, w, angle=0.2, side=f"[{sign * 5}, 0]")
    th = 0.2 + w * TIMES
    s, c = np.sin(th), np.cos(th)
    d = r * s - e
    root = sign * np.sqrt(rod**2 - d**2)
    x = r * c + root
    root1 = -d * r * c * w / root  # derivatives of the root
    root2 = (-((r * c * w) ** 2) + d * r * s * w**2 - root1**2) / root
    # numbers up to 1 m, 2 m/s, 10 m/s²; root ≥ 0.7, so nothing is lost
    assert values(of, "slider_position", TIMES)[0] == pytest.approx(x, abs=4e-15)
    assert values(of, "slider_velocity", TIMES)[0] == pytest.approx(-r * s * w + root1, abs=1e-14)
    acceleration = values(of, "slider_acceleration", TIMES)[0]
    assert acceleration == pytest.approx(-r * c * w**2 + root2, abs=1e-13)


def test_inline_slider_crank_of_equal_lengths_is_a_double_harmonic():
    """r = l: the slider moves as 2 r cos θ (as long as cos θ > 0)."""
    of = slider_crank(0.5, 0.5, 0, 1.0)
    times = np.linspace(-1.2, 1.2, 9)
    # the root of l² − r² sin² loses digits as cos θ → 0: 1e-16/cos²(1.2)
    assert values(of, "slider_position", times)[0] == pytest.approx(np.cos(times), abs=5e-15)
    assert values(of, "slider_acceleration", times)[0] == pytest.approx(-np.cos(times), abs=1e-13)


def four_bar(a, b, c, d, speed, angle, side):
    return system_of(f"""
joints: {{O: [0, 0], C: [{d}, 0]}}
bars:
  crank: {{joints: [O, A], length: {a}}}
  coupler: {{joints: [A, B], length: {b}}}
  rocker: {{joints: [C, B], length: {c}}}
drives: {{crank: {{angle: {angle}, speed: {speed}}}}}
assembly: {{B: {side}}}
""")


@pytest.mark.parametrize("side", ["left", "right"])
def test_freudenstein(side):
    """K₁ cos θ₄ − K₂ cos θ₂ + K₃ = cos(θ₂ − θ₄), and its first two derivatives.

    F. Freudenstein, Trans. ASME 76, 853 (1954), with K₁ = d/a, K₂ = d/c,
    K₃ = (a² − b² + c² + d²)/(2ac).
    """
    a, b, c, d, w = 0.3, 0.9, 0.7, 1.0, 5.0
    of = four_bar(a, b, c, d, w, 0.4, side)
    two = 0.4 + w * TIMES
    four = values(of, "bar_angle", TIMES)[2]
    speed = values(of, "bar_speed", TIMES)[2]
    acceleration = values(of, "bar_acceleration", TIMES)[2]
    k1, k2, k3 = d / a, d / c, (a * a - b * b + c * c + d * d) / (2 * a * c)
    s, co = np.sin, np.cos
    position = k1 * co(four) - k2 * co(two) + k3 - co(two - four)
    velocity = -k1 * s(four) * speed + k2 * s(two) * w + s(two - four) * (w - speed)
    second = (
        -k1 * (co(four) * speed**2 + s(four) * acceleration)
        + k2 * co(two) * w**2
        + co(two - four) * (w - speed) ** 2
        - s(two - four) * acceleration
    )
    # terms up to 4, 4·5 and 4·25; links stay 25° from being in line
    assert position == pytest.approx(np.zeros_like(TIMES), abs=1e-14)
    assert velocity == pytest.approx(np.zeros_like(TIMES), abs=1e-13)
    assert second == pytest.approx(np.zeros_like(TIMES), abs=2e-12)


def number(text):
    return float(text)


CLOSE = {"rel": 1e-12}
"""Double precision against 40 digits: an angle in degrees, dozens of operations."""


@pytest.mark.parametrize(("mode", "side"), [("open", "left"), ("crossed", "right")])
def test_four_bar_of_norton(mode, side):
    data = REFERENCE["fourbar"]
    a, b, c, d = (data[key] * 1e-3 for key in "abcd")
    w, alpha = data["crank_speed"], data["crank_acceleration"]
    of = four_bar(a, b, c, d, w, f"{data['crank_deg']} deg", side)
    expected = {key: number(value) for key, value in data[mode].items()}
    angles = np.degrees(values(of, "bar_angle")[:, 0])
    assert angles[1] == pytest.approx(expected["th3_deg"], **CLOSE)
    assert angles[2] == pytest.approx(expected["th4_deg"], **CLOSE)
    speeds = values(of, "bar_speed")[:, 0]
    assert speeds[1] == pytest.approx(expected["w3"], **CLOSE)
    assert speeds[2] == pytest.approx(expected["w4"], **CLOSE)
    # drives have constant speed; the crank of the book also accelerates
    model = of.model
    known = {"crank": model.graph.number(alpha)}
    motion = Accelerations(model.positions, model.velocities, known, "x")
    found = of.evaluate([motion.bodies["coupler"], motion.bodies["rocker"]])[:, 0]
    assert found[0] == pytest.approx(expected["al3"], **CLOSE)
    assert found[1] == pytest.approx(expected["al4"], **CLOSE)


@pytest.mark.parametrize(("mode", "where"), [("open", "[5, 0]"), ("crossed", "[-5, 0]")])
def test_offset_slider_crank_of_norton(mode, where):
    data = REFERENCE["slidercrank"]
    a, b, e = (data[key] * 1e-3 for key in ("a", "b", "offset"))
    of = slider_crank(a, b, e, 1.0, f"{data['theta2_deg']} deg", where)
    (position,) = values(of, "slider_position")[:, 0]
    assert position * 1e3 == pytest.approx(number(data[f"d_{mode}"]), **CLOSE)
    rod = np.degrees(values(of, "bar_angle")[1, 0])
    # the book counts the rod's angle at the slider, from there to the crank
    assert (rod + 180) % 360 == pytest.approx(number(data[f"theta3_{mode}_deg"]), **CLOSE)


def test_the_trammel_draws_an_ellipse():
    of = system_of("""
joints: {O: [0, 0]}
bars: {link: {points: {X: [0, 0], Y: [0.5, 0], P: [0.7, 0]}}}
sliders:
  across: {joint: X, through: O, angle: 0}
  upright: {joint: Y, through: O, angle: 90 deg}
drives: {link: {angle: 0.3, speed: 2}}
""")
    places = values(of, "joint_position", TIMES).reshape(-1, 2, len(TIMES))
    index = of.topology.joints.index("P")
    x, y = places[index]
    # P is 0.7 from X and 0.2 from Y: semi-axes
    assert (x / 0.2) ** 2 + (y / 0.7) ** 2 == pytest.approx(np.ones_like(TIMES), abs=1e-14)
    th = 0.3 + 2 * TIMES
    assert values(of, "slider_position", TIMES)[0] == pytest.approx(-0.5 * np.cos(th), abs=1e-15)
    assert values(of, "slider_acceleration", TIMES)[1] == pytest.approx(
        -2.0 * np.sin(th), abs=1e-14
    )


def test_a_bar_pendulum_swings_like_a_point_at_two_thirds():
    """θ̈ = −(3 g/2 L) cos θ for a uniform bar, θ counted from +x and gravity along −y."""
    of = system_of("""
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.8, mass: 3}}
free: {rod: {angle: 0.7, speed: 2}}
""")
    (found,) = of.evaluate(of.model.free_accelerations)[:, 0]
    assert found == pytest.approx(-1.5 * 9.81 / 0.8 * np.cos(0.7), rel=1e-14)


@pytest.mark.parametrize("speeds", [(0, 0), (1, -2)])
def test_double_pendulum_of_points(speeds):
    """Plumb-line formulas: (m₁+m₂)l₁θ̈₁ + m₂l₂θ̈₂ cos δ + m₂l₂θ̇₂² sin δ + (m₁+m₂)g sin θ₁ = 0."""
    m1, m2, l1, l2, g = 1.3, 0.7, 0.6, 0.9, 9.81
    th1, th2, w1, w2 = 0.5, 1.4, *speeds
    of = system_of(f"""
gravity: [{g}, 0]
joints: {{O: [0, 0]}}
bars:
  one: {{joints: [O, P], length: {l1}, mass: {m1}, inertia: 0, center: {l1}}}
  two: {{joints: [P, Q], length: {l2}, mass: {m2}, inertia: 0, center: {l2}}}
free:
  one: {{angle: {th1}, speed: {w1}}}
  two: {{angle: {th2}, speed: {w2}}}
""")
    delta = th1 - th2
    matrix = [
        [(m1 + m2) * l1**2, m2 * l1 * l2 * np.cos(delta)],
        [m2 * l1 * l2 * np.cos(delta), m2 * l2**2],
    ]
    right = [
        -m2 * l1 * l2 * w2**2 * np.sin(delta) - (m1 + m2) * g * l1 * np.sin(th1),
        m2 * l1 * l2 * w1**2 * np.sin(delta) - m2 * g * l2 * np.sin(th2),
    ]
    found = of.evaluate(of.model.free_accelerations)[:, 0]
    assert found == pytest.approx(np.linalg.solve(matrix, right), rel=1e-13)  # condition 5
