"""The absolute formulation against textbook formulas; nothing here runs the kernel."""

import math

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from definition_terms import mechanism_of

G = 9.81
CLOSE = {"rel": 1e-12, "abs": 1e-12}  # a few dozen roundings of numbers of order 1


def solved(definition, angles, places=None):
    """Outputs at t = 0; joints that are not on the ground default to the origin."""
    model = AbsoluteModel(mechanism_of(definition))
    places = {joint: np.zeros(2) for joint in model.layout.points} | (places or {})
    rates = {name: start.speed for name, start in model.mechanism.initial.items()}
    state = model.state(0.0, model.configuration(places, angles), rates)
    return outputs(model, model.solve(state))


def test_compound_pendulum():
    bar = {"joints": ["O", "P"], "length": 1.0, "mass": 2.0, "center": 0.3, "inertia": 0.05}
    definition = {"gravity": (0, -G), "joints": {"O": (0, 0)}, "bars": {"bar": bar}}
    found = solved({**definition, "free": {"bar": {"angle": 0.4, "speed": 1.5}}}, {"bar": 0.4})
    expected = -2.0 * G * 0.3 * math.cos(0.4) / (0.05 + 2.0 * 0.09)
    assert found["bar_acceleration"]["bar"] == pytest.approx(expected, **CLOSE)


def test_bar_that_hangs_pulls_with_its_weight_and_its_load():
    bar = {"joints": ["O", "P"], "length": 1.0, "mass": 2.0}
    found = solved(
        {
            "gravity": (0, -G), "joints": {"O": (0, 0), "W": (0, -1.5)}, "bars": {"bar": bar},
            "free": {"bar": {"angle": -math.pi / 2}}, "masses": {"P": 0.5},
            "loads": [{"joint": "P", "force": [0, -7.0]}],
            "springs": [{"between": ["W", "P"], "stiffness": 10, "length": 0.4}],
        },
        {"bar": -math.pi / 2},
    )  # fmt: skip
    assert found["bar_acceleration"]["bar"] == pytest.approx(0.0, abs=1e-14)
    expected = 2.5 * G + 7.0 + 10 * 0.1
    assert found["joint_reaction"]["O"] == pytest.approx([0.0, expected], **CLOSE)
    assert found["joint_reaction"]["P"] == pytest.approx([0.0, 0.0])


def test_double_pendulum():
    m1, m2, l1, c1, c2, j1, j2 = 1.3, 0.8, 0.9, 0.4, 0.5, 0.07, 0.03
    a, b, u, v = 0.3, -1.1, 2.0, -1.4
    upper = {"joints": ["O", "P"], "length": l1, "mass": m1, "center": c1, "inertia": j1}
    lower = {"joints": ["P", "Q"], "length": 1.0, "mass": m2, "center": c2, "inertia": j2}
    definition = {
        "gravity": (0, -G), "joints": {"O": (0, 0)}, "bars": {"upper": upper, "lower": lower},
        "free": {"upper": {"angle": a, "speed": u}, "lower": {"angle": b, "speed": v}},
    }  # fmt: skip
    found = solved(definition, {"upper": a, "lower": b})
    coupling = m2 * l1 * c2
    matrix = np.array(
        [
            [j1 + m1 * c1**2 + m2 * l1**2, coupling * math.cos(a - b)],
            [coupling * math.cos(a - b), j2 + m2 * c2**2],
        ]
    )
    right = [
        -coupling * math.sin(a - b) * v**2 - (m1 * c1 + m2 * l1) * G * math.cos(a),
        coupling * math.sin(a - b) * u**2 - m2 * c2 * G * math.cos(b),
    ]
    expected = np.linalg.solve(matrix, right)
    assert list(found["bar_acceleration"].values()) == pytest.approx(list(expected), **CLOSE)


def test_slider_crank():
    """x = r cos θ + √(l² − r² sin² θ); a massless rod carries P/cos φ with P = m ẍ − F."""
    r, rod, m, load, speed, angle = 0.4, 1.4, 0.7, -20.0, 3.0, 0.6
    lean = math.asin(-r * math.sin(angle) / rod)
    found = solved(
        {
            "joints": {"O": (0, 0)},
            "bars": {
                "crank": {"joints": ["O", "A"], "length": r},
                "rod": {"joints": ["A", "B"], "length": rod},
            },
            "sliders": {"piston": {"joint": "B", "through": "O", "mass": m}},
            "drives": {"crank": {"angle": angle, "speed": speed}},
            "loads": [{"slider": "piston", "force": load}],
        },
        {"crank": angle, "rod": lean},
    )
    along = rod * math.cos(lean)
    change = -(r**2) * math.sin(angle) * math.cos(angle) / along
    second = -r * math.cos(angle) - (r**2 * math.cos(2 * angle) + change**2) / along
    acceleration = speed**2 * second
    assert found["slider_acceleration"]["piston"] == pytest.approx(acceleration, **CLOSE)
    push = m * acceleration - load
    tangent = math.tan(lean)
    for joint in "OAB":
        expected = [push, push * tangent]
        assert found["joint_reaction"][joint] == pytest.approx(expected, **CLOSE)
    effort = r * push * (math.cos(angle) * tangent - math.sin(angle))
    assert found["drive_effort"]["crank"] == pytest.approx(effort, **CLOSE)


def test_bead_on_a_turning_bar():
    """s̈ = ω² s, and the bar is driven with the moment 2 m ω s ṡ of the Coriolis force."""
    spin, s, rate, m = 1.7, 0.8, -0.6, 0.9
    found = solved(
        {
            "joints": {"O": (0, 0)},
            "bars": {
                "bar": {"joints": ["O", "P"], "length": 1.0},
                "handle": {"joints": ["B", "H"], "length": 0.2},
            },
            "sliders": {"bead": {"joint": "B", "through": (0, 0), "on": "bar", "mass": m}},
            "drives": {"bar": {"angle": 0.5, "speed": spin}, "handle": {"angle": 0, "speed": 0}},
            "free": {"bead": {"position": s, "speed": rate}},
        },
        {"bar": 0.5, "handle": 0.0},
        {"B": s * np.array([math.cos(0.5), math.sin(0.5)])},
    )
    assert found["slider_acceleration"]["bead"] == pytest.approx(spin**2 * s, **CLOSE)
    assert found["drive_effort"]["bar"] == pytest.approx(2 * m * spin * s * rate, **CLOSE)


def test_geared_flywheels():
    """(J₁ + n² J₂) α = M − n·n·c·ω for a damper at the second."""

    def wheel(tip, inertia):
        return {"joints": ["O", tip], "length": 1.0, "mass": 1.0, "center": 0, "inertia": inertia}

    damper = {"bars": ["ground", "b"], "damping": 0.2}
    found = solved(
        {
            "joints": {"O": (0, 0)}, "bars": {"a": wheel("P", 0.3), "b": wheel("Q", 0.4)},
            "gears": [{"bars": ["a", "b"], "ratio": -2.5, "angle": 0.1}],
            "free": {"a": {"angle": 0.2, "speed": 3.0}},
            "loads": [{"bar": "a", "torque": 5.0}], "dampers": [damper],
        },
        {"a": 0.2, "b": 0.1 - 0.5},
    )  # fmt: skip
    expected = (5.0 - 2.5**2 * 0.2 * 3.0) / (0.3 + 2.5**2 * 0.4)
    assert found["bar_acceleration"]["a"] == pytest.approx(expected, **CLOSE)
    assert found["bar_acceleration"]["b"] == pytest.approx(-2.5 * expected, **CLOSE)


def test_clearance_of_a_bar_that_hangs_at_rest():
    """The link stands below its pin and carries the weight."""
    bar = {"joints": ["O", "P"], "length": 1.0, "mass": 2.0}
    down = -math.pi / 2
    definition = {
        "gravity": (0, -G), "joints": {"O": (0, 0)}, "bars": {"bar": bar},
        "clearances": {"r": {"joint": "O", "bar": "bar", "size": 1e-3, "angle": down}},
        "free": {"bar": {"angle": down}},
    }  # fmt: skip
    found = solved(definition, {"bar": down, "r": down}, {"O.r": np.array([0.0, -1e-3])})
    assert found["clearance_force"]["r"] == pytest.approx(2.0 * G, **CLOSE)
    assert found["clearance_acceleration"]["r"] == pytest.approx(0.0, abs=1e-9)  # over 1 mm
