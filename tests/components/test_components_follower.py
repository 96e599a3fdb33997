"""Forces that turn with a body, and forces between joints.

References
----------
.. [1] H. Ziegler, "Die Stabilitätskriterien der Elastomechanik", Ing.-Arch. 20 (1952) 49-56.
"""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.chaos.volume_contraction import Volumes
from linkages.components.external_loads import FollowerForce, ForceBetweenJoints
from linkages.kernel.system import System

ROCKET = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 0.5, mass: 1.2}}
free: {arm: {angle: 0.3, speed: 0}}
loads:
"""


def test_same_from_yaml_and_python():
    made = FollowerForce(index=0, joint="P", on="arm", force=(3, 40))
    entry = "- {joint: P, on: arm, force: [3, 0.04 kN]}\n"
    assert component(ROCKET + entry, "loads", 0) == made
    between = ForceBetweenJoints(index=0, between=("O", "P"), force=5)
    assert component(ROCKET + "- {between: [O, P], force: 5}\n", "loads", 0) == between


def test_a_jet_across_an_arm_turns_it_evenly():
    mechanism = linkages.loads(ROCKET + "- {joint: P, on: arm, force: [7, 4]}\n")
    outputs = ["bar_angle", "load_force", "load_power", "energy_residual", "joint_reaction"]
    data = linkages.simulate(mechanism, end=3.0, samples=31, outputs=outputs).data
    time = data.time.to_numpy()
    turning = 4 * 0.5 / (1.2 * 0.25 / 3)  # torque over inertia, wherever the arm points
    angle = 0.3 + 0.5 * turning * time**2
    # polynomials in time, followed to round-off of 90 rad
    assert data.bar_angle.sel(bar="arm").to_numpy() == pytest.approx(angle, abs=1e-11)
    assert data.load_power.to_numpy() == pytest.approx(2 * turning * time, abs=1e-10)
    assert list(data.force.to_numpy()) == ["loads[0].x", "loads[0].y"]
    assert abs(data.energy_residual.to_numpy()).max() < 1e-10
    # of the ground on the arm's pin: what moves the centre of mass, less the jet
    along = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-along[1], along[0]])
    inertia = 1.2 * 0.25 * (turning * across - (turning * time) ** 2 * along)
    needed = inertia - 7 * along - 4 * across
    found = data.joint_reaction.sel(joint="O").to_numpy().T
    assert found == pytest.approx(needed, abs=1e-9 * abs(needed).max())


def test_force_between_joints_pushes_both_apart():
    text = """
joints: {O: [0, 0]}
sliders:
  left: {joint: L, through: O, mass: 2}
  right: {joint: R, through: O, mass: 3}
free: {left: {position: -0.1, speed: 0}, right: {position: 0.1, speed: 0}}
loads: [{between: [L, R], force: "12*t"}]
"""
    outputs = ["slider_position", "load_force"]
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=11, outputs=outputs).data
    time = data.time.to_numpy()
    expected = np.array([-0.1 - time**3, 0.1 + 2 / 3 * time**3]).T
    assert data.slider_position.to_numpy() == pytest.approx(expected, abs=1e-12)
    assert data.load_force.to_numpy()[:, 0] == pytest.approx(12 * time)  # positive, as it is given


ZIEGLER = """
joints: {O: [0, 0]}
bars:
  first: {joints: [O, A], length: 0.5, mass: 0}
  second: {joints: [A, B], length: 0.5, mass: 0}
masses: {A: 2, B: 1}
free: {first: {angle: 0, speed: 0}, second: {angle: 0, speed: 0}}
springs:
  - {bar: first, stiffness: 3}
  - {between_bars: [first, second], stiffness: 3}
loads:
  - {joint: B, on: ON, force: FORCE}
"""


@pytest.mark.parametrize(("share", "unstable"), [(0.999, False), (1.001, True)])
def test_flutter_load_of_zieglers_column(share, unstable):
    """The straight column flutters from (7/2 − √2) k/l on [1]_; it never buckles."""
    load = share * (3.5 - np.sqrt(2)) * 3 / 0.5
    text = ZIEGLER.replace("ON", "second").replace("FORCE", f"[{-load}, 0]")
    rates = np.linalg.eigvals(linkages.compile(linkages.loads(text)).jacobian(0.0, np.zeros(4)))
    # eigenvalues near a double pair: round-off 1e-16 grows to its root
    assert (rates.real.max() > 1e-6) == unstable
    assert abs(rates.imag).min() > 1.0


@pytest.mark.parametrize(("load", "potential"), [("[-5, 0]", False), ("[0, 0]", True)])
def test_no_energy_says_what_a_follower_force_does(load, potential):
    """So exponents need not come in pairs, and energy is not conserved; volumes are."""
    text = ZIEGLER.replace("ON", "second").replace("FORCE", load)
    found = Volumes(System(linkages.loads(text)))
    assert found.conservative
    assert found.potential == potential


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{joint: O, on: arm, force: [1, 0]}", "joint 'O' is fixed to the ground"),
        ("{joint: P, on: amr, force: [1, 0]}", "unknown bar 'amr'; did you mean 'arm'?"),
        ("{joint: P, on: arm, force: 3}", "expected a list of two numbers"),
        ("{between: [P, P], force: 3}", "expected two different joints"),
        ("{between: [O, P], force: [1, 2]}", "expected a force"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(ROCKET + f"- {entry}\n")
    assert found in problem
