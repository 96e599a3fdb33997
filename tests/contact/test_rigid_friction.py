"""Coulomb's friction of rigid contact: impacts, slip and stick while closed, and where it jams."""

import numpy as np
import pytest
from rough_body import RoughBody
from shared_definitions import loaded_engine
from tangent_differences import check

import linkages
from linkages.errors import InputError
from linkages.kernel.system import System
from linkages.solution.solution import IncompleteError

BODY = """
gravity: [0, -{gravity}]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 0.1, mass: {mass}, center: {arm}, inertia: {inertia}}}}}
free: {{arm: {{angle: {angle!r}, speed: {speed!r}}}}}
clearances:
  gap: {{joint: O, bar: arm, size: {size}, contact: restitution, restitution: {restitution},
        pin_radius: {pin}, friction: {friction}, impact: {impact}, offset: [{x!r}, {y!r}],
        rate: [{vx!r}, {vy!r}]}}
"""


def mechanism(body, angle=0.0, speed=0.0, offset=(0.0, 0.0), rate=(0.0, 0.0), text=BODY):
    start = dict(zip(("x", "y", "vx", "vy"), map(float, (*offset, *rate)), strict=True))
    impact = "poisson" if body.poisson else "newton"
    return linkages.loads(
        text.format(**vars(body) | start, impact=impact, angle=float(angle), speed=float(speed))
    )


def absolute(body, angle, speed, offset, rate):
    """The same state in coordinates of the centre of mass."""
    arm = body.arm * np.array([np.cos(angle), np.sin(angle)])
    velocity = np.array(rate) + speed * np.array([-arm[1], arm[0]])
    return np.array([*(np.array(offset) + arm), angle, *velocity, speed])


@pytest.mark.parametrize(
    ("speed", "slips"), [(-1.0, False), (-5.0, True)], ids=["grips", "slips through"]
)
def test_a_ball_with_spin_hits_a_wall(speed, slips):
    """A ring about its centre: it grips, or leaves with μ (1 + e) v along the wall."""
    ball = RoughBody(0.25, 1e-4, 0.0, 9e-3, 1e-3, 0.2, 0.5)
    data = linkages.simulate(
        mechanism(ball, speed=speed, rate=(0.1, 0.0)), end=0.0101, samples=3, outputs="all"
    ).data.isel(time=-1)
    radius, slip = 0.01, -speed * 0.01
    along = 0.2 * 1.5 * 0.1 if slips else slip / (1 + 0.25 * radius**2 / 1e-4)
    # impacts are linear, and the flight before is straight: round-off
    assert data.clearance_offset_rate.to_numpy().ravel() == pytest.approx([-0.05, -along])
    spin = speed + 0.25 * radius * along / 1e-4
    assert data.bar_speed.item() == pytest.approx(spin, rel=1e-12)
    lost = 0.5 * 0.25 * (0.1**2 - 0.05**2 - along**2) + 0.5e-4 * (speed**2 - spin**2)
    assert data.impact_loss.item() == pytest.approx(lost, rel=1e-12)


ROD = RoughBody(0.5, 1e-4, 0.05, 9e-3, 1e-3, 1.2, 0.6)
KINDS = {"hold", "slip", "stopped", "jammed", "limited"}


@pytest.mark.slow_except("*friction*0.3*", "*'arm'*")
@pytest.mark.parametrize(
    "changed",
    [
        {}, {"poisson": True}, {"restitution": 1.0}, {"friction": 0.3},
        {"poisson": True, "restitution": 1.0}, {"friction": 0.2, "arm": 0.1, "poisson": True},
    ],
    ids=str,
)  # fmt: skip
def test_impacts_of_random_rods_against_the_path_of_impulses(changed):
    """Slip that goes on, ends, or turns round; walls that jam; energy that may not grow."""
    body = RoughBody(**vars(ROD) | changed)
    random, seen = np.random.default_rng(1), set()
    system = System(mechanism(body))
    (contact,) = system.model.walls.contacts
    names = list(system.model.topology.free)
    order = [names.index(name) for name in ("gap.x", "gap.y", "arm")]
    for _ in range(100):
        angle, at = random.uniform(-np.pi, np.pi, 2)
        offset, speed = body.size * np.array([np.cos(at), np.sin(at)]), random.uniform(-30, 30)
        rate = random.uniform(-1, 1, 2)
        if offset @ rate < 0:
            rate = -rate
        state = np.zeros(6)
        state[order], state[np.array(order) + 3] = (*offset, angle), (*rate, speed)
        found = system.evaluate(contact.rates_behind, 0.0, state[:, None])[order, 0]
        (rubbed,) = system.evaluate(contact.rubbed, 0.0, state[:, None])[:, 0]
        before = absolute(body, angle, speed, offset, rate)
        behind, kinds = body.impact(before)
        seen |= kinds
        arm = body.arm * np.array([np.cos(angle), np.sin(angle)])
        spin = behind[5]
        expected = [*(behind[3:5] - spin * np.array([-arm[1], arm[0]])), spin]
        # round-off of 1e-16 through the condition of the inertia and of the limit of the energy
        np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-9)
        inertia = np.array([body.mass, body.mass, body.inertia])
        energies = [inertia @ y[3:] ** 2 for y in (before, behind)]
        assert energies[1] <= energies[0] * (1 + 1e-12)
        assert rubbed == pytest.approx(body.rubbed(before), rel=1e-8, abs=1e-9 * energies[0])
    assert seen >= {"slip", "stopped"}
    if changed == {}:
        assert seen >= {"hold", "jammed"}
    if changed == {"restitution": 1.0}:
        assert "limited" in seen


SWING = RoughBody(0.5, 4e-4, 0.05, 9e-3, 1e-3, 0.2, 0.5, gravity=9.81)


@pytest.mark.slow
@pytest.mark.parametrize("poisson", [False, True], ids=["newton", "poisson"])
def test_a_pin_flies_bounces_slips_and_rolls_as_in_absolute_coordinates(poisson):
    body = RoughBody(**vars(SWING) | {"poisson": poisson})
    start = {"angle": -1.2, "speed": 1.0, "offset": (2e-4, -3e-4), "rate": (0.02, 0.05)}
    times = np.linspace(0.0, 0.8, 9)
    own, log = body.motion(absolute(body, **start), times[1:])
    solution = linkages.simulate(mechanism(body, **start), times=times, rtol=1e-12, outputs="all")
    data, changes = solution.data.isel(time=slice(1, None)), solution.motion.changes
    # impacts and slip lose what they differ by: errors of SciPy's times of changes, 1e-12 s
    np.testing.assert_allclose(data.bar_angle[:, 0], own[:, 2], rtol=0, atol=1e-9)
    slips = [body.touching(y)[4][1] for y in own]
    np.testing.assert_allclose(data.clearance_slip[:, 0], slips, rtol=0, atol=1e-8)
    touches = [time for time, mode in log if mode == "free"]
    np.testing.assert_allclose(changes["gap: touch"].time, touches, atol=1e-9)
    others = [time for time, mode in log if mode != "free"]
    assert len(touches) > 5
    assert len(others) > 3
    assert {0, 1, -1} <= {mode for _, mode in log}
    for time in others:
        assert np.abs(changes["gap: slip"].time - time).min() < 1e-8
    energy = float(abs(data.kinetic_energy + data.potential_energy).max())
    assert float(abs(solution.data.energy_residual).max()) < 1e-11 * energy


def test_a_pin_that_holds_rolls_with_the_period_of_the_closed_form():
    """(J + m (R + a)²) θ″ = −m g (a + R²/ρ) θ, with ρ φ = R θ, for small swings."""
    body, radius = RoughBody(**vars(SWING) | {"friction": 0.5}), SWING.pin + SWING.size
    swing = 0.01 * body.size / radius
    offset = body.size * np.array([np.sin(0.01), -np.cos(0.01)])
    spring = body.mass * body.gravity * (body.arm + radius**2 / body.size)
    pace = np.sqrt(spring / (body.inertia + body.mass * (radius + body.arm) ** 2))
    data = linkages.simulate(
        mechanism(body, swing - np.pi / 2, offset=offset), end=6 * np.pi / pace, samples=61,
        outputs="all",
    ).data  # fmt: skip
    expected = swing * np.cos(pace * data.time.to_numpy())
    # of second order in the 0.01 that the direction turns by, over three periods
    np.testing.assert_allclose(data.bar_angle[:, 0] + np.pi / 2, expected, atol=2e-4 * swing)
    assert float(abs(data.clearance_slip).max()) < 1e-12  # round-off of velocities of 1e-2 m/s
    assert float(abs(data.clearance_friction / data.clearance_force).max()) < 0.02


ENGINE = loaded_engine("""\
clearances:
  gap: {joint: B, bar: rod, size: 0.1 mm, contact: restitution, restitution: 0.3,
        least_rate: 10 mm/s, FRICTION}
drives: {crank: {angle: 0, speed: 1000 rpm}}
""")


def engine(friction, **options):
    text = ENGINE.replace("FRICTION", friction)
    return linkages.simulate(linkages.loads(text), samples=301, outputs="all", **options)


@pytest.mark.slow_except("newton")
@pytest.mark.parametrize("impact", ["newton", "poisson"])
def test_energy_of_an_engine_whose_gudgeon_pin_rubs(impact):
    solution = engine(f"pin_radius: 8 mm, friction: 0.2, impact: {impact}", end=0.15)
    data, changes = solution.data, solution.motion.changes
    assert changes["gap: touch"].rises.sum() >= 3
    assert changes["gap: slip"].count > 20
    energy = float(abs(data.kinetic_energy).max())
    # a few thousand steps at 1e-10
    assert float(abs(data.energy_residual).max()) < 1e-9 * energy
    assert (np.diff(data.impact_loss, axis=0) >= -1e-13 * energy).all()
    rubbed = abs(data.clearance_friction) - 0.2 * data.clearance_force
    assert float(rubbed.max()) < 1e-9 * float(data.clearance_force.max())
    assert float(data.clearance_indentation.max()) < 1e-7 * 1e-4


def test_little_friction_is_none():
    """The limit μ → 0 is of first order in μ; a friction of 0 is no friction at all."""
    without, none, little = (
        engine(f"pin_radius: 8 mm{key}", end=0.02).data
        for key in ("", ", friction: 0", ", friction: 1e-9")
    )
    np.testing.assert_array_equal(none.joint_position, without.joint_position)
    np.testing.assert_allclose(little.joint_position, none.joint_position, rtol=0, atol=1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("end", [0.02, 0.1, 0.3], ids=["impacts", "closed", "stuck"])
def test_tangents_of_a_pin(end):
    check(
        BODY.format(**vars(SWING), impact="newton", angle=-1.2, speed=1.0, x=2e-4, y=-3e-4,
                    vx=0.02, vy=0.05), end, 1e-3,
    )  # fmt: skip


JAMMED = RoughBody(1.0, 2e-4, 0.06, 3e-2, 1e-3, 1.2, 0.5, gravity=9.81)


def test_a_jammed_contact_ends_the_motion():
    """A slender body under steep friction: W_nn = μ |W_nt| is where the sentence says."""
    swinging = mechanism(JAMMED, 0.5, -5.0, (0.0, -1e-3))
    with pytest.raises(IncompleteError, match=r"at t = .* gap: friction jams .*Painlevé") as raised:
        linkages.simulate(swinging, end=1.0)
    solution = raised.value.solution
    assert solution.data.time[-1] > 0.01


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("friction: 0.2", "friction: 0.2, friction_law: tanh, slip: 1e-3",
         "takes Coulomb's friction alone; expected no 'friction_law'"),
        ("friction: 0.2", "friction: 0.2, static: 0.3, stribeck_speed: 0.1",
         "expected no 'static'"),
        ("pin_radius: 0.009, ", "", "missing key 'pin_radius'"),
        ("contact: restitution", "contact: exact, stiffness: 1e9, slip: 1e-3", "has no 'impact'"),
    ],
)  # fmt: skip
def test_what_is_refused(old, new, expected):
    text = BODY.format(**vars(SWING), impact="poisson", angle=0, speed=0, x=0, y=0, vx=0, vy=0)
    with pytest.raises(InputError, match=expected):
        linkages.compile(linkages.loads(text.replace(old, new)))


FREE = ENGINE.replace("FRICTION", "pin_radius: 8 mm, friction: 0.2").replace(
    "drives: {crank: {angle: 0, speed: 1000 rpm}}", "free: {crank: {angle: 0.3, speed: 5}}"
)
FREE = FREE.replace("loads: [{slider: piston, force: -200 N}]\n", "")


@pytest.mark.slow
def test_a_slider_that_sticks_beside_a_pin_that_sticks():
    """Forces of both follow from one system; smooth friction tends to it with its width."""
    dry, smooth, smoother = (
        linkages.simulate(
            linkages.loads(f"{FREE}{key}: [{{slider: piston, {law}}}]\n"), end=0.5, samples=501,
            outputs="all",
        )
        for key, law in (
            ("friction", "force: 1 N"),
            ("loads", "force: -1 N*tanh(piston.speed/(2 mm/s))"),
            ("loads", "force: -1 N*tanh(piston.speed/(0.5 mm/s))"),
        )
    )  # fmt: skip
    data, changes = dry.data, dry.motion.changes
    assert {name for name in changes if changes[name].count} >= {"gap: touch", "gap: slip"}
    energy = float(abs(data.kinetic_energy + data.potential_energy).max())
    assert float(abs(data.energy_residual).max()) < 1e-10 * energy
    still = np.abs(data.slider_velocity[:, 0]) < 1e-12
    held = abs(data.clearance_slip[:, 0]) < 1e-12
    assert still.any()
    assert held.any()
    rubbed = abs(data.clearance_friction) - 0.2 * data.clearance_force
    assert float(rubbed.max()) < 1e-12
    off = [float(abs(d.data.bar_angle - data.bar_angle).max()) for d in (smooth, smoother)]
    assert off[1] < 0.4 * off[0] < 0.01


def test_exponents_of_a_pin_that_sticks_again_and_again():
    """What the contact keeps of its touch has no tangents, beside which others vanish."""
    mechanism = linkages.loads(ENGINE.replace("FRICTION", "pin_radius: 8 mm, friction: 0.2"))
    short, long = (linkages.lyapunov(mechanism, periods=n, skip=2, count=1) for n in (1, 16))
    # the motion repeats, and so does the growth in every period
    np.testing.assert_allclose(long.exponent, short.exponent, rtol=1e-3)
