"""Dry friction under a constant load: Coulomb's oscillator, Stribeck's curve, creep."""

import numpy as np
import pytest
from component_reading import complaints, component

import linkages
from linkages.chaos.volume_contraction import Volumes
from linkages.components.dry_friction import (
    DryFrictionBetweenJoints,
    DryGuideFriction,
    DryJointFriction,
)
from linkages.kernel.system import System

BLOCK = """
joints: {O: [0, 0], W: [-3, 0]}
sliders: {block: {joint: B, through: O, mass: 2}}
free: {block: {position: POSITION, speed: SPEED}}
springs: [{slider: block, stiffness: 50}]
friction:
"""
WHEEL = """
joints: {O: [0, 0]}
bars: {wheel: {points: {O: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}}
free: {wheel: {angle: 0, speed: 10}}
friction:
"""
OUTPUTS = ["slider_position", "slider_velocity", "spring_force", "energy_residual"]


def block(position, speed):
    return BLOCK.replace("POSITION", str(position)).replace("SPEED", str(speed))


def test_same_from_yaml_and_python():
    made = DryGuideFriction(index=0, slider="block", force=4, slip_speed=1e-3)
    entry = "- {slider: block, force: 4 N, slip_speed: 1 mm/s}\n"
    assert component(block(0, 0) + entry, "friction", 0) == made
    made = DryJointFriction(index=0, joint="O", torque=0.1, static=0.2, stribeck_speed=3)
    entry = "- {joint: O, torque: 0.1, static: 20 N*cm, stribeck_speed: 3}\n"
    assert component(WHEEL + entry, "friction", 0) == made


@pytest.mark.parametrize("place", ["slider: block", "between: [W, B]"])
def test_coulombs_oscillator_loses_the_same_way_every_half_cycle(place):
    """Half waves about ±F/k, each shorter by 2·F/k than the one before."""
    mechanism = linkages.loads(block(1.0, 0.0) + f"- {{{place}, force: 4}}\n")
    half = np.pi / 5
    data = linkages.simulate(mechanism, end=5 * half, samples=101, outputs=OUTPUTS).data
    time = data.time.to_numpy()
    number = np.minimum(np.floor(time / half + 1e-9), 4)
    centre = 0.08 * (-1.0) ** number
    amplitude = (1.0 - 0.16 * number) - 0.08
    expected = centre + amplitude * (-1.0) ** number * np.cos(5 * (time - number * half))
    # rtol 1e-10; a turning point is located to 1e-8 s or so, its place to round-off
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-8)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8


def test_a_clutch_brings_two_wheels_to_one_speed():
    """Momentum is kept: I1·ω/(I1 + I2), at constant torques until then."""
    text = """
    joints: {O: [0, 0], C: [5, 0]}
    bars:
      one: {points: {O: [0, 0], P: [0.1, 0]}, mass: 1, center: [0, 0], inertia: 0.02}
      other: {points: {C: [0, 0], Q: [0.1, 0]}, mass: 1, center: [0, 0], inertia: 0.06}
    free: {one: {angle: 0, speed: 10}, other: {angle: 0}}
    friction: [{between_bars: [one, other], torque: 0.3}]
    """
    solution = linkages.simulate(linkages.loads(text), end=1.0, samples=101)
    time, speed = solution.time, solution.data.bar_speed.sel(bar=["one", "other"]).to_numpy()
    slips = np.minimum(time, 0.5)  # (10 rad/s) / (0.3/0.02 + 0.3/0.06)
    expected = np.stack([10.0 - 15.0 * slips, 5.0 * slips], axis=1)
    assert speed == pytest.approx(expected, abs=1e-9)


def test_new_places_of_friction_are_read_with_their_names():
    entry = "- {between: [W, B], force: 4 N}\n"
    made = DryFrictionBetweenJoints(index=0, between=("W", "B"), force=4)
    assert component(block(0, 0) + entry, "friction", 0) == made
    found = str(complaints(block(0, 0) + "- {between: [W, W], force: 4}\n"))
    assert "friction[0].between: expected two different joints, found 'W' twice" in found
    found = str(complaints(WHEEL + "- {between_bars: [wheel, ground], torque: 4}\n"))
    assert "expected a bar or plate; the ground can stand first only" in found


def test_a_drive_works_against_friction_that_holds():
    """A wheel on a driven arm is carried along: the drive makes half of I ω²."""
    text = """
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, A], length: 0.1}
  wheel: {points: {A: [0, 0], P: [0.1, 0]}, mass: 4, center: [0, 0], inertia: 0.02}
drives: {arm: {law: 0.5*sin(2*pi*t)}}
free: {wheel: {angle: 0, speed: 3.141592653589793}}
friction: [{joint: A, torque: 2}]
"""
    data = linkages.simulate(linkages.loads(text), end=0.5, samples=51, outputs="all").data
    angle = 0.5 * np.sin(2 * np.pi * data.time.to_numpy())
    # friction holds up to 2 N m; 0.02 kg m² need at most 0.4 N m
    assert data.bar_angle.sel(bar="wheel").to_numpy() == pytest.approx(angle, abs=1e-9)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-9 * float(data.kinetic_energy.max())


def test_it_comes_to_rest_and_breaks_away():
    """It rests at v²·m/(2·F), holds what pulls at it, and slides where that is more than F."""
    text = block(0, 3).replace("stiffness: 50", "stiffness: 0")
    text += "- {slider: block, force: 4}\n"
    text += "loads: [{slider: block, force: '3*max(t - 2, 0)'}]\n"
    data = linkages.simulate(linkages.loads(text), end=4.0, samples=81, outputs=OUTPUTS).data
    time, start = data.time.to_numpy(), 2 + 4 / 3
    since = np.maximum(time - start, 0)
    slid = np.minimum(time, 1.5)
    speed = 3 - 2 * slid + 0.75 * since**2
    place = 3 * slid - slid**2 + 0.25 * since**3
    assert data.slider_velocity.to_numpy()[:, 0] == pytest.approx(speed, abs=1e-12)
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(place, abs=1e-12)
    held = (time > 1.5) & (time < start)
    friction = data.spring_force.sel(spring="friction[0]").to_numpy()
    assert friction[held] == pytest.approx(-3 * np.maximum(time[held] - 2, 0), abs=1e-12)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-11


def test_it_breaks_away_at_the_static_friction():
    text = block(0, 0).replace("stiffness: 50", "stiffness: 0")
    text += "- {slider: block, force: 4, static: 7, stribeck_speed: 0.05}\n"
    text += "loads: [{slider: block, force: '3*t'}]\n"
    data = linkages.simulate(linkages.loads(text), end=3.0, samples=181, outputs=OUTPUTS).data
    moving = abs(data.slider_velocity.to_numpy()[:, 0]) > 1e-9
    first = data.time.to_numpy()[moving][0]
    assert 7 / 3 < first <= 7 / 3 + 2 * 3.0 / 180


def test_a_joint_holds_a_pendulum():
    text = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 0.5, mass: 1.2}}
free: {rod: {angle: -60 deg, speed: 0}}
friction: [{joint: O, torque: TORQUE}]
"""
    weight = 1.2 * 9.81 * 0.25 * 0.5  # its torque about the pin
    outputs = ["bar_angle", "torsional_spring_torque"]
    for share, rests in ((1.01, True), (0.99, False)):
        mechanism = linkages.loads(text.replace("TORQUE", str(share * weight)))
        data = linkages.simulate(mechanism, end=1.0, samples=5, outputs=outputs).data
        assert (np.ptp(data.bar_angle.to_numpy()) < 1e-12) == rests
        if rests:
            held = data.torsional_spring_torque.to_numpy()[:, 0]
            assert held == pytest.approx(np.full(5, weight))


def test_a_joint_brakes_its_wheel():
    data = linkages.simulate(
        linkages.loads(WHEEL + "- {joint: O, torque: 0.1}\n"),
        end=1.5, samples=11, outputs=["bar_speed", "torsional_spring_torque"],
    ).data  # fmt: skip
    expected = 10 - 5 * data.time.to_numpy()
    assert data.bar_speed.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-11)
    torque = data.torsional_spring_torque.to_numpy()[:, 0]
    assert torque == pytest.approx(np.full(11, -0.1))


@pytest.mark.parametrize("speed", [-2.0, -0.05, 0.01, 0.3])
def test_stribecks_curve(speed):
    text = f"""
joints: {{O: [0, 0]}}
sliders: {{block: {{joint: B, through: O}}}}
drives: {{block: {{position: 0, speed: {speed}}}}}
friction:
  - {{slider: block, force: 4, static: 7, stribeck_speed: 0.1, slip_speed: 5 mm/s}}
"""
    data = linkages.simulate(linkages.loads(text), end=0.1, samples=2, outputs=OUTPUTS[2:3]).data
    size = 4 + 3 * np.exp(-((speed / 0.1) ** 2))
    expected = -size * np.tanh(speed / 5e-3)
    assert data.spring_force.to_numpy()[0, 0] == pytest.approx(expected, rel=1e-12)


def test_what_is_held_creeps_at_the_speed_of_slip():
    """A force below friction moves the block at v_slip·atanh(F/F_friction)."""
    text = block(0, 0).replace("stiffness: 50", "stiffness: 0")
    text += "- {slider: block, force: 4, slip_speed: 1e-3}\nloads: [{slider: block, force: 3}]\n"
    data = linkages.simulate(linkages.loads(text), end=0.5, samples=3, outputs=OUTPUTS).data
    speed = data.slider_velocity.to_numpy()[1:, 0]
    # reached within 10 ms; an explicit method at its limit of stability errs by some tolerances
    assert speed == pytest.approx(np.full(2, 1e-3 * np.arctanh(0.75)), abs=1e-8)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-10


@pytest.mark.parametrize("more", ["", ", slip_speed: 1e-2"])
def test_no_certificate_takes_it_for_conservative(more):
    text = block(1, 0) + f"- {{slider: block, force: 4{more}}}\n"
    assert not Volumes(System(linkages.loads(text))).conservative


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{slider: block, force: -4}", "expected a force >= 0"),
        ("{slider: block, force: 4, static: 5}", "missing key 'stribeck_speed'"),
        ("{slider: block, force: 4, stribeck_speed: 5}", "missing key 'static'"),
        (
            "{slider: block, force: 4, static: 3, stribeck_speed: 1}",
            "friction[0].static: expected at least 4, what 'force' is, found 3",
        ),
        ("{slider: block, force: 4, slip_speed: 0}", "expected a speed > 0"),
        ("{slider: blok, force: 4}", "did you mean 'block'?"),
        ("{joint: O, torque: 4}", "nothing turns at joint 'O'"),
        ("{slider: block, torque: 4}", "unknown key 'torque'"),
    ],
)
def test_wrong_entries(entry, found):
    assert any(found in problem for problem in complaints(block(0, 0) + f"- {entry}\n"))


@pytest.mark.slow_except("*stribeck*")
@pytest.mark.parametrize("kind", ["force: {}", "force: {}, static: {}, stribeck_speed: 0.1"])
def test_a_mass_that_is_let_go_does_not_chatter(kind):
    """Whatever the error of its speed while it sticks, which says nothing on where it goes.

    Rates are round-off there, too: two of these forces used to end as if a ball came to rest.
    """
    text = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
springs: [{slider: m, stiffness: 1}]
loads: [{slider: m, force: "2*cos(0.25*t)"}]
free: {m: {position: 0.1}}
friction:
"""
    for force in (0.7, 0.75, 0.8, 1.0):
        mechanism = linkages.loads(text + f"- {{slider: m, {kind.format(force, 1.2 * force)}}}\n")
        ends = []
        for method in ("dop853", "vern9", "tsit5"):
            for rtol in (1e-8, 1e-9, 1e-10, 1e-11):
                run = {"method": method, "rtol": rtol, "end": 60.0, "samples": 2}
                data = linkages.simulate(mechanism, **run).data
                ends.append(float(data.slider_position[-1, 0]))
        assert ends == pytest.approx([ends[-1]] * len(ends), abs=1e-6)
