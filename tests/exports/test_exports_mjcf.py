"""Models of MuJoCo against this package: mobility, closed loops, and the motion."""

import numpy as np
import pytest
from exported_states import SHIPPED, system

import linkages
from linkages.errors import InputError
from linkages.exports.writers.mujoco import massless, mjcf_text
from linkages.kernel.system import System

mujoco = pytest.importorskip("mujoco", reason="needs the package mujoco")

REFUSED = {
    "beam-pump": r"loads\[0\]: only springs",
    "double-rocker": "drives.jib: MuJoCo follows drives with polynomials",
    "slider-crank-contact": "clearances that open",
    "contact-slider-crank": "clearances that open",
    "idling-engine": "clearances that open",
    "impact-oscillator": r"stops\[0\]: ends at which bodies bounce",
}
EXPRESSED = sorted(set(SHIPPED) - set(REFUSED))

LOADED = """
gravity: [0, -9.81]
joints: {O: [0, 0], S: [0.3, 0.5], Q: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.5, mass: 1}
  b: {joints: [A, B], length: 0.4, mass: 0.7}
sliders:
  block: {joint: C, through: Q, angle: 30 deg, mass: 2}
masses: {B: 0.2}
springs:
  - {between: [S, B], stiffness: 120, length: 0.3, damping: 0.4}
  - {between_bars: [a, b], stiffness: 3, angle: -100 deg, damping: 0.01}
  - {slider: block, stiffness: 40, position: 0.3}
dampers:
  - {between: [A, S], damping: 0.1}
loads:
  - {joint: B, force: [2, -3]}
  - {bar: a, torque: 0.5}
  - {slider: block, force: 5}
free:
  a: {angle: 20 deg, speed: 1}
  b: {angle: -40 deg, speed: -2}
  block: {position: 0.1, speed: 0.3}
"""

GEARED = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.3, 0], D: [0.6, 0.2]}
bars:
  wheel: {joints: [O, P], length: 0.1, mass: 1}
  pinion: {joints: [C, Q], length: 0.05, mass: 0.3}
  arm: {joints: [Q, R], length: 0.2, mass: 0.2}
  lever: {joints: [D, S], length: 0.3, mass: 0.4}
gears:
  - {bars: [wheel, pinion], ratio: -2}
welds:
  Q: {bars: [pinion, arm], angle: 30 deg}
drives:
  wheel: {angle: 10 deg, speed: 3}
free:
  lever: {angle: 80 deg, speed: 1}
"""


CUBIC = """
joints: {O: [0, 0]}
bars: {b: {joints: [O, P], length: 0.3, mass: 1}}
drives: {b: {law: "0.2 + 2*t - 3*t**2 + 40*t**3 - 100*t**4"}}
"""
LIGHT = """
joints: {O: [0, 0], C: [0.4, 0]}
bars:
  crank: {joints: [O, A], length: 0.1}
  rod: {joints: [A, B], length: 0.35}
  rocker: {joints: [C, B], length: 0.25, mass: 1}
drives: {crank: {angle: 0.5, speed: 4}}
assembly: {B: left}
"""


YOKE = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0, 150 mm]}
bars:
  crank: {joints: [O, A], length: 50 mm}
  pinion: {joints: [C, P], length: 30 mm, mass: 0.4, inertia: 4e-4}
sliders:
  yoke: {joint: Y, through: O, angle: 0, mass: 1.5}
  pin:  {joint: A, on: yoke, through: Y, angle: 90 deg}
racks: [{slider: yoke, bar: pinion, radius: 30 mm}]
drives: {crank: {angle: 0, speed: 120 rpm}}
assembly: {A: [50 mm, 0]}
"""
HANGING = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {a: {joints: [O, A], length: 0.5}, b: {joints: [A, B], length: 0.4}}
masses: {A: 1, B: 0.5}
free: {a: {angle: 0.3, speed: 0}, b: {angle: 0.5, speed: 0}}
"""
MOVED = (
    "pendulum", "double-pendulum", "four-bar", "slider-crank", "ninebar", "scotch-yoke",
    "chebyshev", "peaucellier",
)  # fmt: skip


@pytest.fixture(autouse=True)
def _log_beside_no_code(tmp_path, monkeypatch):
    """MuJoCo writes its log into the current directory where a simulation is unstable."""
    monkeypatch.chdir(tmp_path)


def started(of):
    """The model and its state at the start."""
    model = mujoco.MjModel.from_xml_string(mjcf_text(of))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return model, data


def constraints(model, data):
    """Derivatives of all constraints by speeds."""
    found = np.zeros((data.nefc, model.nv))
    if data.nefc and mujoco.mj_isSparse(model):
        mujoco.mju_sparse2dense(
            found, data.efc_J, data.efc_J_rownnz, data.efc_J_rowadr, data.efc_J_colind
        )
    elif data.nefc:
        found[:] = data.efc_J.reshape(found.shape)
    return found


@pytest.mark.parametrize("name", EXPRESSED)
def test_loops_are_closed_and_the_mobility_is_the_same(name):
    """Beside the clock, what is left of all speeds are those of the free coordinates."""
    of = system(name)
    model, data = started(of)
    jacobian = constraints(model, data)
    rank = np.linalg.matrix_rank(jacobian, 1e-9) if len(jacobian) else 0
    clock = bool(of.topology.driven)  # wheels of harmonic drives follow it
    assert model.nv - rank == len(of.topology.free) + clock
    np.testing.assert_allclose(data.efc_pos, 0.0, atol=1e-14)
    speed = np.abs(data.qvel[clock:]).max()
    np.testing.assert_allclose(jacobian @ data.qvel, 0.0, atol=1e-14 * max(1.0, speed))


def moved(of, end):
    """Largest distance of joints from where `linkages.simulate` has them, and the largest gap."""
    model, data = started(of)
    gap = 0.0
    for _ in range(round(end / model.opt.timestep)):
        mujoco.mj_step(model, data)
        gap = max(gap, np.abs(data.efc_pos).max(initial=0.0))
    mujoco.mj_kinematics(model, data)
    known = linkages.simulate(
        of.mechanism, times=[0.0, data.time], rtol=1e-11, outputs=["joint_position"]
    ).data.joint_position
    error = 0.0
    for name, body in of.mechanism.bodies.items():
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
        for joint, point in body.points.items() if number >= 0 else ():
            local = np.array([point[0].value, point[1].value, 0.0])
            place = data.xpos[number] + data.xmat[number].reshape(3, 3) @ local
            error = max(error, np.abs(place[:2] - known.sel(joint=joint).values[-1]).max())
    return error, gap


@pytest.mark.parametrize(
    "of",
    [
        *(pytest.param(system(name), id=name) for name in MOVED),
        pytest.param(System(linkages.loads(LOADED)), id="springs and forces"),
        pytest.param(System(linkages.loads(GEARED)), id="gears and welds"),
        pytest.param(System(linkages.loads(CUBIC)), id="a drive of degree 4"),
        pytest.param(System(linkages.loads(LIGHT)), id="bars without mass"),
    ],
)  # fmt: skip
def test_the_motion_is_the_same_within_the_error_of_constraints(of):
    """Without constraints that of MuJoCo's steps; gaps of loops are led on by clearances and arms.

    Steps of 0.1 ms of order 4 err by less than 1e-9; a gap turns links by itself over their length.
    """
    error, gap = moved(of, 0.05)
    assert gap < 1e-6
    assert error < 1e-9 + 10 * gap


@pytest.mark.parametrize("name", REFUSED)
def test_what_mujoco_cannot_express_is_refused_by_name(name):
    with pytest.raises(InputError, match=REFUSED[name]):
        mjcf_text(system(name))


def test_all_is_refused_at_once():
    text = GEARED.replace("angle: 10 deg, speed: 3", "law: sin(t**2)")
    text += "stops: [{bars: [ground, lever], lower: -30 deg, upper: 100 deg, restitution: 0.5}]\n"
    with pytest.raises(InputError) as refusal:
        mjcf_text(System(linkages.loads(text)))
    assert "stops[0]" in str(refusal.value)
    assert "drives.wheel" in str(refusal.value)


@pytest.mark.parametrize(
    ("text", "end", "within", "note"),
    [
        # a crank and a pin without mass between the drive and 1.5 kg
        (YOKE, 0.2, 5e-8, "for crank and pin: 0.001 of the largest mass each; drives determine"),
        # four errors of 1e-9 of the steps, and a part of 1e-12 of the masses
        (HANGING, 0.5, 1e-9, "for a and b: 1e-12 of the largest mass each"),
        # free, with loops: less mass would open them further, more would change the motion
        (LIGHT.replace("drives", "free"), 0.01, 1e-5,
         "for crank and rod: 1e-06 of the largest mass each; where they carry loads"),
    ],
    ids=["drive", "tree", "loop"],
)  # fmt: skip
def test_masses_that_mujoco_needs_change_little_and_are_told(text, end, within, note):
    """Constraints are soft, and the softer the lighter the bodies are that they hold."""
    of = System(linkages.loads(text))
    assert note in massless(of)
    assert note in mjcf_text(of)
    error, gap = moved(of, end)
    assert gap < within
    assert error < 1e-9 + 10 * within
