"""Journals in bearings that are not round: where they touch, and how they move."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from tangent_differences import check

import linkages
from linkages.equations.generalised import require_forces_of_the_state
from linkages.errors import InputError
from linkages.kernel.system import System

SIZE, RADIUS, STIFFNESS = 1e-3, 9e-3, 1e8
MASS, ARM, INERTIA = 0.25, 0.03, 1e-4

TEXT = """
gravity: [0, -9.81]
joints: {{O: [{ox!r}, {oy!r}]}}
bars: {{arm: {{joints: [O, P], length: 0.1, mass: 0.25, center: 0.03, inertia: 1e-4}}}}
free: {{arm: {{angle: 0.3, speed: {speed}}}}}
clearances:
  gap: {{joint: O, bar: arm, size: 1 mm, pin_radius: 9 mm, carries: {carries}, rate: [0.05, 0.02],
        offset: [{x!r}, {y!r}], contact: {law}, {more}}}
"""
HERTZ = "hertz, stiffness: 1e8"
ROUGH = (
    "hunt-crossley-constant, stiffness: 1e8, dissipation: 1, friction: 0.2, friction_law: coulomb"
)
OVAL = ([0.0, 1.5e-4, 0.0, 1e-5], [1e-4, 0.0, 2e-5, 1e-5])
"""An ellipse, shifted, with three and four waves."""


def arm(profile=None, law=HERTZ, carries="hole", centre=(0.0, 0.0), offset=(0.0, 0.0), speed=2.0):
    more = "" if profile is None else f"profile: {{cos: {profile[0]}, sin: {profile[1]}}}"
    (ox, oy), (x, y) = centre, offset
    places = {"ox": ox, "oy": oy, "x": x, "y": y}
    return linkages.loads(text_of(law, carries, more, speed, **places))


def text_of(law, carries, more, speed, **places):
    return TEXT.format(law=law, carries=carries, more=more, speed=speed, **places)


def depth(profile, angle):
    """c + h."""
    order = np.arange(1, len(profile[0]) + 1)
    phase = np.multiply.outer(angle, order)
    return SIZE + np.cos(phase) @ profile[0] + np.sin(phase) @ profile[1]


def touched(profile, centre):
    """Gap and angle by dense minimisation."""

    def gap(angle):
        return depth(profile, angle) - centre @ np.array([np.cos(angle), np.sin(angle)])

    angles = np.linspace(0, 2 * np.pi, 721)
    best = angles[np.argmin(gap(angles))]
    ends = best - 0.01, best + 0.01
    found = minimize_scalar(
        lambda x: 1e3 * gap(x), bounds=ends, method="bounded", options={"xatol": 1e-12}
    )
    return found.fun / 1e3, found.x


@pytest.mark.parametrize("carries", ["hole", "pin"])
@pytest.mark.parametrize("profile", [OVAL, ([0.0, 2e-4, 0.0], [0.0, 0.0, 3e-5])], ids=["oval", "e"])
def test_the_gap_is_the_least_of_all_angles(profile, carries):
    system = System(arm(profile, carries=carries))
    (nodes,) = system.model.contacts
    random = np.random.default_rng(3)
    names = list(system.topology.free)
    places = [names.index(name) for name in ("gap.x", "gap.y", "arm")]
    for _ in range(100):
        turn, towards = random.uniform(-np.pi, np.pi, 2)
        offset = random.uniform(0.85, 1.4) * SIZE * np.array([np.cos(towards), np.sin(towards)])
        state = np.zeros((6, 1))
        state[places, 0] = *offset, turn
        values = [nodes.gap.indentation, nodes.gap.contact_angle]
        found, angle = system.evaluate(values, 0.0, state)[:, 0]
        sign, turned = (-1, turn) if carries == "hole" else (1, 0.0)
        cos, sin = np.cos(turned), np.sin(turned)
        gap, where = touched(profile, sign * np.array([[cos, sin], [-sin, cos]]) @ offset)
        if gap < 0.1 * SIZE:
            # a minimum is told to the square of its place
            assert found == pytest.approx(-gap, abs=1e-10 * SIZE)
            assert np.cos(angle - where) == pytest.approx(1.0, abs=1e-10)
        else:
            assert found == pytest.approx(-gap, abs=1e-3 * SIZE)
            assert found < 0.0


OUTPUTS = ["clearance_offset", "bar_angle", "clearance_indentation", "clearance_slip", "touches"]


def moved(mechanism, end=0.1, **how):
    how = {"samples": 11, "rtol": 1e-12, "outputs": [*OUTPUTS, "energy_residual"]} | how
    return linkages.simulate(mechanism, end=end, **how).data


@pytest.mark.parametrize("law", [HERTZ, ROUGH], ids=["elastic", "rough"])
def test_no_depth_is_a_round_bearing(law):
    one, other = moved(arm(law=law)), moved(arm(([0.0], [0.0]), law))
    assert one.touches[-1].item() > 1
    # errors of 1e-12 of steps, amplified by some impacts
    for name in OUTPUTS[:2]:
        np.testing.assert_allclose(other[name], one[name], rtol=0, atol=1e-9 * abs(one[name]).max())


@pytest.mark.parametrize("law", [HERTZ, ROUGH], ids=["elastic", "rough"])
def test_the_first_harmonic_is_a_shift_of_the_bearing(law):
    """c + a cos θ + b sin θ: the hole of the ground has its centre at (a, b)."""
    shift = 3e-4, -2e-4
    worn = moved(arm(([shift[0]], [shift[1]]), law, "pin"))
    round_one = moved(arm(None, law, "pin", shift, (-shift[0], -shift[1])))
    own = worn.clearance_offset[:, 0] - round_one.clearance_offset[:, 0]
    assert worn.touches[-1].item() > 1
    np.testing.assert_allclose(own, np.tile(shift, (len(own), 1)), rtol=0, atol=1e-9 * SIZE)
    np.testing.assert_allclose(worn.bar_angle, round_one.bar_angle, rtol=0, atol=1e-9)
    touching = worn.clearance_indentation > 0.0
    slips = [each.clearance_slip.where(touching, 0.0) for each in (worn, round_one)]
    np.testing.assert_allclose(*slips, rtol=0, atol=1e-9)


@pytest.mark.parametrize("carries", ["hole", "pin"])
def test_energy_is_conserved(carries):
    data = moved(arm(OVAL, carries=carries), 0.5, samples=101)
    assert data.touches[-1].item() > 5
    assert float(abs(data.energy_residual).max()) < 1e-10


def absolute(profile, times, carries, speed=2.0):
    """An elastic bounce in coordinates of the centre of mass, the gap by dense minimisation."""

    def forces(_, y):
        turn = y[2]
        lever = ARM * np.array([np.cos(turn), np.sin(turn)])
        offset = y[:2] - lever
        sign, turned = (-1, turn) if carries == "hole" else (1, 0.0)
        frame = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
        gap, angle = touched(profile, sign * frame.T @ offset)
        force = STIFFNESS * max(-gap, 0.0) ** 1.5
        push = -sign * force * (frame @ np.array([np.cos(angle), np.sin(angle)]))
        # on the displaced body at the middle of the journal, where all contact forces pass
        at = np.zeros(2) if carries == "hole" else offset
        arm_of = at - y[:2]
        torque = arm_of[0] * push[1] - arm_of[1] * push[0]
        return [*y[3:], *(push / MASS + [0.0, -9.81]), torque / INERTIA]

    turn = 0.3
    lever = ARM * np.array([np.cos(turn), np.sin(turn)])
    start = [*lever, turn, 0.05 - speed * lever[1], 0.02 + speed * lever[0], speed]
    found = solve_ivp(
        forces, (0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-15, max_step=1e-4
    )
    return found.y


@pytest.mark.parametrize("carries", ["hole", pytest.param("pin", marks=pytest.mark.slow)])
def test_a_motion_in_absolute_coordinates(carries):
    times = np.linspace(0.0, 0.03, 4)
    data = linkages.simulate(
        arm(OVAL, carries=carries), times=times, rtol=1e-12, outputs=OUTPUTS
    ).data
    own = absolute(OVAL, times, carries)
    assert data.touches[-1].item() > 0
    turn = data.bar_angle.to_numpy()[:, 0]
    np.testing.assert_allclose(turn, own[2], rtol=0, atol=1e-8)
    offset = own[:2] - ARM * np.array([np.cos(own[2]), np.sin(own[2])])
    np.testing.assert_allclose(data.clearance_offset[:, 0], offset.T, rtol=0, atol=1e-8 * SIZE)


def test_tangents_against_differences_of_motions():
    """Through several impacts, with friction, of a bearing that turns."""
    more = f"profile: {{cos: {OVAL[0]}, sin: {OVAL[1]}}}"
    smooth = ROUGH.replace("coulomb", "tanh, slip: 0.05")
    check(text_of(smooth, "hole", more, 2.0, ox=0, oy=0, x=0, y=0), 0.03, SIZE)


def test_sensitivity_to_an_amplitude():
    """By the kernel's tangents, against motions with other amplitudes."""
    path = "clearances.gap.profile.sin[1]"
    mechanism = arm(([0.0, 1e-4], [1e-4, 5e-5]))
    how = {"end": 0.03, "samples": 4, "rtol": 1e-12}
    found = linkages.sensitivities(mechanism, "arm.angle", path, **how)["arm.angle"].squeeze()
    ends = [mechanism.with_values({path: 5e-5 + step}) for step in (1e-8, -1e-8)]
    up, down = (linkages.simulate(m, **how, outputs=["bar_angle"]).data.bar_angle for m in ends)
    expected = ((up - down) / 2e-8).to_numpy()[:, 0]
    # differences over 1e-5 of the clearance, through impacts
    assert abs(expected[-1]) > 1.0
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-6)


@pytest.mark.parametrize(
    ("profile", "law", "message"),
    [
        ("{}", HERTZ, "expected amplitudes of harmonics as 'cos' or 'sin', found none"),
        ("{cos: [0, 0.4 mm]}", HERTZ, "cannot touch the bearing at 0 deg"),
        ("{cos: [0, 2 kg]}", HERTZ, "kg is a mass"),
        ("{tan: [0]}", HERTZ, "unknown key 'tan'"),
        ("{cos: [1e-5]}", "restitution, restitution: 0.5", "restitution takes a round bearing"),
        (f"{{cos: {[0] * 65}}}", HERTZ, "at most 64 harmonics"),
    ],
)
def test_faulty_profiles(profile, law, message):
    with pytest.raises(InputError, match=r"clearances\.gap\.profile") as error:
        linkages.loads(text_of(law, "hole", f"profile: {profile}", 2.0, ox=0, oy=0, x=0, y=0))
    assert message in str(error.value)


def test_what_takes_round_bearings_says_so():
    mechanism = arm(OVAL)
    with pytest.raises(InputError, match="found by iteration: there are no equations"):
        require_forces_of_the_state(mechanism)
    with pytest.raises(InputError, match="a journal held in a bearing that is not round"):
        linkages.tolerance(
            mechanism.with_values({"clearances.gap.size": "1 ± 0.1 mm"}), "max(arm.angle)", end=0.01
        )


@pytest.mark.parametrize("path", ["clearances.gap.profile.cos[1]", "clearances.gap.size"])
def test_a_sweep_has_the_numbers_of_single_motions(path):
    """To the round-off of the peak that is looked for."""
    mechanism = arm(([0.0, 1e-4], [1e-4, 5e-5]))
    values = np.linspace(1e-3, 2e-3, 4) if path.endswith("size") else np.linspace(0.0, 2e-4, 4)
    found = linkages.sweep(mechanism, {path: values}, ["max(gap.force)"], end=0.03)
    for value, force in zip(values, found["max(gap.force)"].to_numpy(), strict=True):
        one = linkages.simulate(mechanism.with_values({path: value}), end=0.03)
        assert force > 0.0
        assert linkages.measure(one, "max(gap.force)") == pytest.approx(force, rel=1e-9)
