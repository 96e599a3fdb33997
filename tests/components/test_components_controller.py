"""PID controllers: linear responses by the exponential of a matrix, limits, units, messages."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import linkages
from linkages.components.controllers import Constant, TorqueController
from linkages.spec.formulas import formula

WHEEL = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
free: {wheel: {angle: 0.5, speed: 1}}
controllers:
  c: {bar: wheel, ENTRY}
"""
PI = "of: wheel.speed, setpoint: 20 rad/s, proportional: 0.1 N m s/rad, integral: 0.5 N m/rad"
PID = "of: wheel.angle, setpoint: 2, proportional: 3, integral: 4, derivative: 0.2"
OUTPUTS = ["bar_angle", "bar_speed", "internal_state", "load_torque", "energy_residual"]


def run(entry, **options):
    mechanism = linkages.loads(WHEEL.replace("ENTRY", entry))
    given = {"end": 2.0, "samples": 41, "outputs": OUTPUTS, **options}
    return linkages.simulate(mechanism, **given).data


def test_same_from_yaml_and_python():
    made = TorqueController(
        name="c", bar="wheel", of=formula("wheel.speed"), setpoint=formula("20 rad/s"),
        proportional=Constant(0.1), integral=Constant(0.5),
    )  # fmt: skip
    plain = PI.replace("0.1 N m s/rad", "0.1").replace("0.5 N m/rad", "0.5")
    assert component(WHEEL.replace("ENTRY", plain), "controllers", "c") == made
    text = linkages.loads(WHEEL.replace("ENTRY", PI))
    assert linkages.loads(text.to_yaml()) == text


def test_response_of_a_loop():
    """J dω/dt = P (20 - ω) + z, dz/dt = I (20 - ω)."""
    data = run(PI)
    matrix = np.array([[-0.1 / 0.02, 1 / 0.02], [-0.5, 0.0]])
    expected = [expm(matrix * t) @ [1 - 20, 0.0] + [20, 0] for t in data.time.to_numpy()]
    found = np.array([data.bar_speed.to_numpy()[:, 0], data.internal_state.to_numpy()[:, 0]]).T
    assert found == pytest.approx(np.array(expected), abs=1e-8)  # rtol 1e-10 of 20 rad/s
    assert data.internal_state.attrs["units"] == "N m"
    assert data.internal.to_numpy().tolist() == ["controllers.c.integral"]
    torque = 0.1 * (20 - found[:, 0]) + found[:, 1]
    assert data.load_torque.sel(torque="controllers.c").to_numpy() == pytest.approx(torque)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8  # of 4 J


@pytest.mark.slow_except("*dop853*")
@pytest.mark.parametrize("method", [("radau", None), ("gauss8", 0.01), ("dop853", None)], ids=str)
def test_response_with_a_derivative(method):
    data = run(PID, method=method[0], step=method[1])
    matrix = np.array([[0, 1, 0], [-3 / 0.02, -0.2 / 0.02, 1 / 0.02], [-4, 0, 0]])
    start, rest = np.array([0.5 - 2, 1, 0]), np.array([2, 0, 0])
    expected = np.array([expm(matrix * t) @ start + rest for t in data.time.to_numpy()])
    names = ("bar_angle", "bar_speed", "internal_state")
    found = np.array([data[name].to_numpy()[:, 0] for name in names]).T
    assert found == pytest.approx(expected, abs=2e-8)


@pytest.mark.slow_except(",*")
@pytest.mark.parametrize(("tracking", "time"), [("", 0.2), (", tracking: 0.05 s", 0.05)])
def test_limits_and_windup(tracking, time):
    """Against SciPy; without tracking the integral winds up and overshoots."""
    entry = f"{PI}, limits: [-0.4 N m, 0.3 N m]{tracking}"
    data = run(entry, end=4.0)

    def loop(_, y):
        error = 20 - y[0]
        wanted = 0.1 * error + y[1]
        effort = np.clip(wanted, -0.4, 0.3)
        return [effort / 0.02, 0.5 * error + (effort - wanted) / time]

    own = solve_ivp(loop, (0, 4), [1, 0], t_eval=data.time, rtol=1e-11, atol=1e-12, max_step=1e-3)
    assert data.bar_speed.to_numpy()[:, 0] == pytest.approx(own.y[0], abs=1e-7)
    assert data.internal_state.to_numpy()[:, 0] == pytest.approx(own.y[1], abs=1e-7)
    torque = data.load_torque.to_numpy()[:, 0]
    assert torque.max() == pytest.approx(0.3, abs=1e-15)
    slow = run(f"{PI}, limits: [-0.4 N m, 0.3 N m], tracking: 1000 s", end=4.0)
    assert slow.bar_speed.max() > data.bar_speed.max() + 2


def test_along_guides_and_between_joints():
    text = """
joints: {O: [0, 0], P: [-1, 0]}
bars: {dummy: {joints: [P, Q], length: 0.1}}
sliders: {block: {joint: B, through: O, angle: 0, mass: 2}}
drives: {dummy: {angle: 0, speed: 0}}
free: {block: {position: 0.5, speed: 0.3}}
controllers:
  c: {PLACE, of: block.position, setpoint: "0.1*sin(2*t)", proportional: 30, derivative: 4}
"""
    for place in ("slider: block", "between: [P, B]"):
        data = linkages.simulate(
            linkages.loads(text.replace("PLACE", place)), end=3, samples=4
        ).data
        assert "internal_state" not in data

        def motion(t, y):
            return [y[1], (30 * (0.1 * np.sin(2 * t) - y[0]) - 4 * y[1]) / 2]

        own = solve_ivp(motion, (0, 3), [0.5, 0.3], rtol=1e-11, atol=1e-12)
        assert data.slider_position.to_numpy()[-1, 0] == pytest.approx(own.y[0, -1], abs=1e-8)


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("of: wheel.speed, setpoint: 1", "expected a gain"),
        (PI.replace("0.1 N m s/rad", "3 N m"), "expected a torsional damping (N m s/rad), found"),
        (PI.replace("20 rad/s", "20 m"), "expected an angular speed (rad/s), as 'wheel.speed' is"),
        (f"{PI}, derivative: 1", "expected a position, an angle or a distance for 'derivative'"),
        (f"{PI}, limits: [1, -1]", "expected the least effort first"),
        (f"{PI}, tracking: 1 s", "found without 'limits' and 'integral'"),
        ("of: wheel.angle, setpoint: 1, integral: 2, limits: [-1, 1]", "missing key 'tracking'"),
        (PI.replace("wheel.speed", "wheel.velocity"), "has no 'velocity'"),
        (PI.replace("wheel.speed", "wheel.acceleration"), "follows from accelerations"),
        (f"{PI}, against: wheel", "expected another body than 'wheel'"),
    ],
)
def test_wrong_entries(entry, found):
    assert found in complaints(WHEEL.replace("ENTRY", entry))[0]
