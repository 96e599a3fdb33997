"""Cams given by their lifts, against harmonic and cycloidal motion in closed form."""

import numpy as np
import pytest
from component_reading import complaints

import linkages
from linkages.components.transmissions import Cam
from linkages.kernel.varying import Varying

TURN = np.linspace(0.0, 2 * np.pi, 181)
HEIGHT, SPEED = 0.01, 30.0
ENTRY = "slider: valve, bar: cam"


def harmonic(angle):
    """Lift and two derivatives of a rise and return in one turn."""
    return (HEIGHT * (1 - np.cos(angle)), HEIGHT * np.sin(angle), HEIGHT * np.cos(angle))


def cycloidal(angle):
    """A cycloidal rise of 2·HEIGHT over half a turn, and the return."""
    u = np.mod(angle, 2 * np.pi) / np.pi
    back = u > 1
    share = np.where(back, 2 - u, u)
    sign = np.where(back, -1.0, 1.0)
    lift = share - np.sin(2 * np.pi * share) / (2 * np.pi)
    slope = sign * (1 - np.cos(2 * np.pi * share)) / np.pi
    bend = 2 * np.sin(2 * np.pi * share) / np.pi
    return 2 * HEIGHT * lift, 2 * HEIGHT * slope, 2 * HEIGHT * bend


def valve(lift, known, more="", angles=TURN):
    table = ", ".join(f"{angle:.17g}" for angle in angles)
    lifts = ", ".join(f"{value:.17g}" for value in lift(angles)[0])
    return f"""
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{cam: {{points: {{O: [0, 0], P: [0.02, 0]}}, mass: 1, center: [0, 0], inertia: 1e-3}}}}
sliders: {{valve: {{joint: V, through: O, angle: 90 deg, mass: 0.5}}}}
cams:
  - {{{ENTRY}, angles: [{table}], lifts: [{lifts}], offset: 0.05{more}}}
springs: [{{slider: valve, stiffness: 3000, position: 0.03}}]
{known}
"""


def moved(text, end, outputs, samples=41):
    return linkages.simulate(linkages.loads(text), end=end, samples=samples, outputs=outputs).data


DRIVEN = f"drives: {{cam: {{angle: 0.3, speed: {SPEED}}}}}"
FREE = f"free: {{cam: {{angle: 0.3, speed: {SPEED}}}}}"


@pytest.mark.parametrize("lift", [harmonic, cycloidal])
def test_driven_cam_moves_its_follower_and_feels_it(lift):
    """A spline through a lift every 2° errs by h⁴ of its fourth derivative, its bend by h²."""
    outputs = ["slider_position", "slider_velocity", "slider_acceleration", "drive_effort"]
    data = moved(valve(lift, DRIVEN), 0.5, outputs)
    exact = lift(0.3 + SPEED * data.time.to_numpy())
    found = [data[name].to_numpy()[:, 0] for name in outputs]
    step = TURN[1]
    assert found[0] - 0.05 == pytest.approx(exact[0], abs=HEIGHT * step**4)
    assert found[1] == pytest.approx(SPEED * exact[1], abs=SPEED * HEIGHT * 2 * step**3)
    bend = SPEED**2 * exact[2]
    assert found[2] == pytest.approx(bend, abs=SPEED**2 * HEIGHT * 8 * step**2)
    force = 0.5 * (found[2] + 9.81) + 3000 * (found[0] - 0.03)
    # power of the drive is power into follower, spring and weight
    assert found[3] * SPEED == pytest.approx(force * found[1], abs=1e-9 * abs(force).max())


def test_free_cam_keeps_its_energy_over_many_turns():
    text = valve(harmonic, FREE).replace("speed: 30", "speed: 100")
    data = moved(text, 3.0, ["bar_angle", "slider_position", "energy_residual"])
    assert np.ptp(data.bar_angle.to_numpy()) > 8 * np.pi
    expected = 0.05 + harmonic(data.bar_angle.to_numpy()[:, 0])[0]
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-8)
    # a spline's third derivative jumps at its knots, which steps of order 8 feel
    assert abs(data.energy_residual.to_numpy()).max() < 1e-5


def test_jacobian_of_a_free_cam():
    equations = linkages.compile(linkages.loads(valve(harmonic, FREE)))
    state, size = np.array([0.51, 12.0]), 1e-5
    columns = [
        (equations(0.0, state + shift) - equations(0.0, state - shift)) / (2 * size)
        for shift in size * np.eye(2)
    ]
    # central differences err by size² of third derivatives
    expected = np.transpose(columns)
    assert equations.jacobian(0.0, state) == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_pressure_angle():
    more = ", base_radius: 40 mm, roller_radius: 10 mm, eccentricity: 3 mm"
    mechanism = linkages.loads(valve(harmonic, DRIVEN, more))
    options = {"end": 0.2, "samples": 41, "outputs": ["pressure_angle"]}
    found = linkages.simulate(mechanism, **options).data.pressure_angle
    assert found.dims == ("time", "cam")
    assert list(found["cam"].to_numpy()) == ["valve"]
    lift, slope, _ = harmonic(0.3 + SPEED * found.time.to_numpy())
    expected = np.arctan((slope - 0.003) / (lift + np.sqrt(0.05**2 - 0.003**2)))
    assert found.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-6)
    larger = Varying(mechanism)
    larger.at({})
    system = larger.at({"cams[0].base_radius": "60 mm"})
    with_values = linkages.simulate(system.mechanism, **options).data.pressure_angle
    expected = np.arctan((slope - 0.003) / (lift + np.sqrt(0.07**2 - 0.003**2)))
    assert with_values.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-6)


def test_a_cam_of_less_than_a_turn_goes_on_straight():
    angles = np.linspace(0.0, 1.0, 21)
    text = valve(lambda a: (0.01 * a,), "drives: {cam: {angle: -1, speed: 1}}", angles=angles)
    data = moved(text, 3.0, ["slider_position", "slider_acceleration"], samples=7)
    expected = 0.05 + 0.01 * (data.time.to_numpy() - 1)
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected)
    assert abs(data.slider_acceleration.to_numpy()).max() < 1e-12


def test_same_from_yaml_and_python():
    made = Cam(index=0, slider="valve", bar="cam", angles=(0, 1, 2), lifts=(0, 0.01, 0.02))
    assert made.terms()[0].profile.places == (0, 1, 2)


SHORT = valve(harmonic, DRIVEN, angles=np.linspace(0, 2 * np.pi, 5))


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: valve, bar: cam, angles: [0, 1], lifts: [0, 0]}", "at least three angles"),
        ("{slider: valve, bar: cam, angles: [0, 1, 2], lifts: [0, 0]}", "3 angles and 2 lifts"),
        ("{slider: valve, bar: cam, angles: [0, 2, 1], lifts: [0, 0, 0]}", "found 1 after 2"),
        (
            "{slider: valve, bar: cam, angles: [0, 1, 360 deg], lifts: [0, 0, 1 mm]}",
            "expected equal lifts a whole turn apart, found 0 and 0.001",
        ),
        (
            "{slider: valve, bar: cam, angles: [0, 1, 2], lifts: [0, 0, 0], base_radius: 1 cm,"
            " eccentricity: 2 cm}",
            "expected less than base and roller radius together, 0.01 m",
        ),
        ("{slider: cam, bar: cam, angles: [0, 1, 2], lifts: [0, 0, 0]}", "unknown slider 'cam'"),
        ("{slider: valve, bar: valve, angles: [0, 1, 2], lifts: [0, 0, 0]}", "unknown bar 'valve'"),
    ],
)
def test_wrong_entries(entry, found):
    start, end = SHORT.index("  - {slider"), SHORT.index("springs:")
    text = f"{SHORT[:start]}  - {entry}\n{SHORT[end:]}"
    assert any(found in problem for problem in complaints(text))


def test_nothing_more_is_tied_to_a_follower():
    text = SHORT.replace("bars: {", "bars: {wheel: {joints: [O, Q], length: 1}, ")
    text += "racks: [{slider: valve, bar: wheel, radius: 0.1}]\n"
    assert any("follow" in problem for problem in complaints(text))
