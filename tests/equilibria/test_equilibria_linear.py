"""Linear equations about equilibria and motions against the kernel, and what is refused."""

import numpy as np
import pytest
from resting_mechanisms import FRICTION, SERIES, TRUSS
from scipy import signal

import linkages
from linkages import equilibrium, state_space

CRANE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  jib: {joints: [O, A], length: 1.2, mass: 3}
  rope: {joints: [A, B], length: 0.8, mass: 1}
masses: {B: 2}
dampers: [{joint: A, damping: 0.3}]
drives: {jib: {law: LAW}}
free: {rope: {angle: -1.4, speed: 0}}
"""
"""A pendulum on a driven bar."""


def crane(law):
    return linkages.loads(CRANE.replace("LAW", f'"{law}"'))


def listed(data, k=1):
    return [name for name in data["state_name"].sel(equilibrium=k).to_numpy() if name]


CASES = {
    "double-pendulum": {"dampers": [{"joint": "P", "damping": 0.3}]},
    "andrews": {},
    "idling-engine": {"drives.crank.speed": 0.0},
    "ninebar": {"drives.crank1.speed": 0.0, "drives.crank4.speed": 0.0},
}


@pytest.mark.parametrize("name", CASES)
def test_linear_equations_are_the_jacobian_of_the_kernel(name):
    """The kernel divides by the inertia before it differentiates, the linear equations after."""
    mechanism = linkages.load(name, set=CASES[name])
    data, rhs = equilibrium(mechanism), linkages.compile(mechanism)
    for k in data["equilibrium"].to_numpy().tolist():
        state = rhs.state.copy()
        names = data["coordinate"].to_numpy().tolist()
        rows = [rhs.names.index(each) for each in names]
        state[rows] = data["state"].sel(equilibrium=k)
        if rhs.system.topology.carried:
            continue  # iterations start elsewhere there
        assert np.abs(rhs(0.0, state)[rows]).max() < 1e-5 * np.abs(rhs(0.0, rhs.state)).max() + 1e-9
        own = [listed(data, k).index(each) for each in names]
        jacobian = rhs.jacobian(0.0, state)[np.ix_(rows, rows)]
        a = state_space(data, k)[0][np.ix_(own, own)]
        assert a == pytest.approx(jacobian, rel=1e-12, abs=1e-12 * np.abs(jacobian).max())


def test_linear_equations_about_a_motion_have_frozen_coefficients():
    mechanism = linkages.load("idling-engine")
    data, rhs = equilibrium(mechanism, time=0.013, moving=True), linkages.compile(mechanism)
    state = linkages.simulate(mechanism, times=[0.0, 0.013], outputs=["clearance_offset"])
    offset = state.data["clearance_offset"].to_numpy()[-1].ravel()
    assert data["state"][0, :2].to_numpy() == pytest.approx(offset, rel=1e-7)
    jacobian = rhs.jacobian(0.013, data["state"].to_numpy()[0])
    own = [listed(data).index(name) for name in rhs.names]
    a = state_space(data)[0][np.ix_(own, own)]
    assert a == pytest.approx(jacobian, rel=1e-12, abs=1e-12 * np.abs(jacobian).max())
    assert data["reason"][0] == "frozen coefficients, no statement on stability"
    assert not data["stable"][0]
    assert any("gyroscopic" in kind for kind in data["mode_kind"].to_numpy().ravel())


def test_accelerations_of_drives_are_inputs_and_their_efforts_outputs():
    """Against the kernel of the same mechanism with another law of the drive."""
    still = crane("0.5")
    asked = {
        "inputs": ["jib.acceleration", "B.x force"],
        "observed": ["rope.acceleration", "jib.effort"],
    }
    data = equilibrium(still, **asked)
    one = data.sel(equilibrium=1)
    a, b, c, d = state_space(data)
    moved = crane("0.5 + 0.5*0.2*t**2")
    rhs = linkages.compile(moved)
    state = one["state"].to_numpy()
    assert state[0] == pytest.approx(-np.pi / 2, abs=1e-14)
    row = listed(data).index("rope.speed")
    assert b[row, -1] * 0.2 == pytest.approx(rhs(0.0, state)[1], rel=1e-13)
    assert d[0, -1] * 0.2 == pytest.approx(rhs(0.0, state)[1], rel=1e-13)

    def effort_of(mechanism):
        rhs = linkages.compile(mechanism)
        return rhs.outputs(["drive_effort"], 0.0, state).drive_effort.item()

    effort = [effort_of(each) for each in (still, moved)]
    assert one["drive_effort"].item() == pytest.approx(effort[0], rel=1e-13)
    assert d[1, -1] * 0.2 == pytest.approx(effort[1] - effort[0], rel=1e-12)
    pushed = still.with_values({"loads": [{"joint": "B", "force": [0.1, 0]}]})
    force = data["input"].to_numpy().tolist().index("B.x force")
    assert d[1, force] * 0.1 == pytest.approx(effort_of(pushed) - effort[0], rel=1e-12)
    # a held drive elsewhere: columns of its angle and speed
    column = listed(data).index("jib.angle")
    other = crane("0.5 + 1e-5")
    changed = linkages.compile(other)(0.0, state)[1] - linkages.compile(still)(0.0, state)[1]
    assert a[row, column] == pytest.approx(changed / 1e-5, abs=1e-4)
    assert c[0] == pytest.approx(a[row])


def test_inputs_and_outputs_of_all_kinds_against_the_kernel():
    """Outputs C and D by differences of the kernel's own outputs; a force at a joint as a load."""
    base = linkages.load("double-pendulum")
    names = ["upper.angle", "Q.x position", "Q.y acceleration", "P.x reaction", "kinetic_energy"]
    data = equilibrium(base, inputs=["Q.x force", "lower.torque"], observed=names)
    k = 3  # the upper bar up, the lower one down
    one, (_a, b, c, d) = data.sel(equilibrium=k), state_space(data, k)
    state = one["state"].to_numpy()

    def outputs(state, loads=()):
        mechanism = base.with_values({"loads": list(loads)}) if loads else base
        rhs = linkages.compile(mechanism)
        wanted = ["bar_angle", "joint_position", "joint_acceleration", "joint_reaction",
                  "kinetic_energy"]  # fmt: skip
        found = rhs.outputs(wanted, 0.0, state).isel(time=0)
        values = [
            found.bar_angle.sel(bar="upper"),
            found.joint_position.sel(joint="Q", axis="x"),
            found.joint_acceleration.sel(joint="Q", axis="y"),
            found.joint_reaction.sel(joint="P", axis="x"),
            found.kinetic_energy,
        ]
        return np.array([float(each) for each in values]), rhs(0.0, state)

    order = listed(data, k)
    for place, name in enumerate(data["coordinate"].to_numpy()):
        step = np.zeros(4)
        step[place] = 1e-5
        slope = (outputs(state + step)[0] - outputs(state - step)[0]) / 2e-5
        assert c[:, order.index(name)] == pytest.approx(slope, abs=1e-8)  # h² of differences
    still, rates = outputs(state)
    loads = {0: {"joint": "Q", "force": [0.1, 0]}, 1: {"bar": "lower", "torque": 0.1}}
    for column, load in loads.items():
        pushed, moved = outputs(state, [load])
        assert 0.1 * d[:, column] == pytest.approx(pushed - still, abs=1e-13)
        rows = [order.index(name) for name in data["coordinate"].to_numpy()]
        assert 0.1 * b[rows, column] == pytest.approx(moved - rates, abs=1e-13)


def test_frequency_responses_are_those_of_scipy():
    data = equilibrium(crane("0.5"), frequencies=[0.1, 0.5, 2.0], observed=["B.x acceleration"])
    a, b, c, d = state_space(data)
    for index in range(b.shape[1]):
        system = signal.StateSpace(a, b[:, [index]], c, d[:, [index]])
        _, expected = signal.freqresp(system, 2 * np.pi * np.array([0.1, 0.5, 2.0]))
        own = data["response"].isel(equilibrium=0, input=index, output=0).to_numpy() @ [1, 1j]
        assert own == pytest.approx(expected, rel=1e-9)
    assert data["input"].to_numpy().tolist() == ["rope.torque", "jib.acceleration"]
    assert data["input_unit"].to_numpy().tolist() == ["N m", "rad/s^2"]


def test_drives_stand_still_at_a_time():
    law = "0.5 + 0.3*sin(2*t)"
    data = equilibrium(crane(law), time=0.7, observed=["jib.angle"], inputs=["rope.torque"])
    place = data["joint_position"].sel(joint="A")[0].to_numpy()
    angle = 0.5 + 0.3 * np.sin(1.4)
    assert place == pytest.approx(1.2 * np.array([np.cos(angle), np.sin(angle)]), abs=1e-14)
    # a uniform jib of 3 kg, and 3 kg that hang at its end
    effort = 9.81 * 1.2 * np.cos(angle) * (1.5 + 3.0)
    assert data["drive_effort"].to_numpy().ravel() == pytest.approx([effort] * 2, rel=1e-13)


def test_an_output_of_a_massless_block_may_follow_the_rate_of_an_input():
    text = SERIES.replace("DAMPING", "0")
    data = equilibrium(linkages.loads(text), inputs=["b.force"], observed=["b.position"])
    assert state_space(data)[3] == pytest.approx(np.array([[1 / 100]]), rel=1e-13)
    with pytest.raises(linkages.ComputationError, match=r"b.velocity follows the rate of input"):
        equilibrium(linkages.loads(text), inputs=["b.force"], observed=["b.velocity"])


def test_what_nothing_determines_is_said_and_positions_are_kept():
    text = SERIES.partition("springs:")[0] + SERIES[SERIES.index("free:") :]
    with pytest.raises(linkages.LinkagesError, match="neither mass, damping nor stiffness") as said:
        equilibrium(linkages.loads(text))
    data = said.value.kept["equilibrium"]
    assert data["state"].to_numpy().tolist() == [[0.6, 1.2, 0.0, 0.0]]
    assert "how b moves here" in str(data["reason"][0].item())
    assert data.sizes["mode"] == 0


def test_friction_that_slides_in_a_motion_holds_nothing():
    text = FRICTION.replace("angle: -70 deg, speed: 0", "angle: -70 deg, speed: 3")
    mechanism = linkages.loads(text)
    data, rhs = equilibrium(mechanism, time=0.1, moving=True), linkages.compile(mechanism)
    expected = rhs.jacobian(0.1, data["state"].to_numpy()[0])
    assert state_space(data)[0] == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        ({"state": {"rod.angel": 1.0}}, "found no coordinate 'rod.angel'"),
        ({"state": {"rod.speed": 1.0}}, "found no coordinate 'rod.speed'"),
        ({"solve": ["bars.rod.mass"]}, "found 1 number and 0 coordinates"),
        ({"inputs": ["rod.force"]}, "found no input 'rod.force'"),
        ({"observed": ["rod.angel"]}, "rod has no 'angel'"),
        ({"frequencies": "1:2"}, "expected FROM:TO:COUNT"),
        ({"frequencies": [-1.0]}, "expected frequencies"),
        ({"moving": True, "state": {"rod.angle": 1.0}}, "neither a state"),
        ({"starts": 0}, "starts must be"),
    ],
    ids=str,
)
def test_what_makes_no_sense_is_refused(options, expected):
    with pytest.raises(ValueError, match=expected):
        equilibrium(linkages.load("pendulum"), **options)


def test_a_driven_mechanism_has_no_equilibrium():
    with pytest.raises(linkages.InputError, match="nothing is free"):
        equilibrium(linkages.load("four-bar"))


def test_numbers_without_a_solution_are_said():
    state, paths = {"apex.position": 0.0}, ["springs[0].stiffness"]
    with pytest.raises(linkages.ComputationError, match=r"no value of springs.* was found"):
        equilibrium(linkages.loads(TRUSS), solve=paths, state=state)


def test_what_sticks_at_an_instant_of_a_motion_is_refused():
    with pytest.raises(linkages.ComputationError, match="holds at t = 5 s"):
        equilibrium(linkages.loads(FRICTION), time=5.0, moving=True)
