"""Coulomb's friction between pin and hole that sticks: rolling without slip, and break-away."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from shared_definitions import loaded_engine

import linkages

MASS, INERTIA, ARM = 0.5, 4e-4, 0.05  # of the pendulum, about its centre of mass, at 50 mm
PIN, SIZE, GRAVITY = 9e-3, 1e-3, 9.81
STIFFNESS, DAMPING = 1e6, 200.0
PENDULUM = """
gravity: [0, -{gravity}]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 0.1, mass: {mass}, center: {arm}, inertia: {inertia}}}}}
free: {{arm: {{angle: {angle}}}}}
clearances:
  gap: {{joint: O, bar: arm, size: {size}, contact: kelvin-voigt, stiffness: {stiffness},
        damping: {damping}, pin_radius: {pin}, friction_law: coulomb, {friction},
        offset: [{offset[0]!r}, {offset[1]!r}]}}
"""


def pendulum(angle, direction, friction):
    """Hung up at rest, the pin pressed in by the weight; angles count from hanging down."""
    distance = SIZE + MASS * GRAVITY / STIFFNESS
    offset = distance * np.sin(direction), -distance * np.cos(direction)
    text = PENDULUM.format(
        gravity=GRAVITY, mass=MASS, arm=ARM, inertia=INERTIA, angle=float(angle - np.pi / 2),
        size=SIZE, stiffness=STIFFNESS, damping=DAMPING, pin=PIN, friction=friction,
        offset=[float(part) for part in offset],
    )  # fmt: skip
    return linkages.loads(text), distance


def test_a_pendulum_that_rolls_has_its_closed_period():
    """Small oscillations: (J + m (R + a)²) θ″ = −m g (a + R²/ρ) θ, for ρ φ = R θ rolls.

    Here R is the radius of the pin and the distance ρ of the centres together.
    """
    _, distance = pendulum(0, 0, "friction: 0.5")
    radius = PIN + distance
    swing = 0.01 * distance / radius  # the centres turn by 0.01
    mechanism, _ = pendulum(swing, 0.01, "friction: 0.5")
    spring = MASS * GRAVITY * (ARM + radius**2 / distance)
    period = 2 * np.pi * np.sqrt((INERTIA + MASS * (radius + ARM) ** 2) / spring)
    data = linkages.simulate(mechanism, end=3 * period, samples=61, outputs="all").data
    angle = data.bar_angle.sel(bar="arm").to_numpy() + np.pi / 2
    expected = swing * np.cos(2 * np.pi * data.time.to_numpy() / period)
    # of second order in the 0.01 that the direction turns by, over three periods
    np.testing.assert_allclose(angle, expected, atol=2e-4 * swing)
    slip = data.clearance_slip.sel(clearance="gap").to_numpy()
    assert np.abs(slip).max() < 1e-12  # round-off of velocities of 1e-2 m/s
    rubbed = (data.clearance_friction / data.clearance_force).sel(clearance="gap")
    # on an incline of 0.01 the friction is what rolling asks for, far below 0.5
    assert 1e-3 < float(abs(rubbed).max()) < 0.02


class Pendulum:
    """A body with a hole on a fixed pin, in coordinates of its centre of mass (x, y, θ).

    Nothing of it knows of offsets as coordinates: forces act on the body where it touches.
    """

    def __init__(self, sliding, static, speed):
        self.sliding, self.static, self.speed = sliding, static, speed

    def touching(self, y):
        """Normal force, slip, and what accelerations by a force along the wall need."""
        turned, (vx, vy, spin) = y[2], y[3:]
        arm = ARM * np.array([-np.sin(turned), np.cos(turned)])  # from the centre to the hole
        hole, moved = y[:2] + arm, np.array([vx, vy]) + spin * np.array([-arm[1], arm[0]])
        distance = np.hypot(*hole)
        normal = hole / distance
        along = np.array([-normal[1], normal[0]])
        lever = arm - (PIN + distance) * normal  # to where it touches
        force = STIFFNESS * (distance - SIZE) + DAMPING * (normal @ moved)
        slip = moved @ along - spin * (PIN + distance)
        return force, slip, (arm, distance, normal, along, lever, moved)

    def rates(self, y, rubbing):
        """Rates of the state, and of the slip, under a force along the wall."""
        force, _, (arm, distance, normal, along, lever, moved) = self.touching(y)
        spin, on_body = y[5], rubbing * along - force * normal
        ax, ay = on_body / MASS - [0.0, GRAVITY]
        turning = (lever[0] * on_body[1] - lever[1] * on_body[0]) / INERTIA
        pushed = np.array([ax, ay]) + turning * np.array([-arm[1], arm[0]]) - spin**2 * arm
        across = (moved @ along) / distance
        slipping = pushed @ along - across * (moved @ normal)
        slipping -= turning * (PIN + distance) + spin * (normal @ moved)
        return np.array([*y[3:], ax, ay, turning]), slipping

    def holding(self, y):
        """The force along the wall that keeps the slip as it is."""
        (_, none), (_, one) = self.rates(y, 0.0), self.rates(y, 1.0)
        return none / (none - one)

    def rubbing(self, y, sense):
        """Friction: with a sense of slip, or (0) as it sticks."""
        if sense == 0:
            return self.holding(y)
        force, slip, _ = self.touching(y)
        more = (self.static - self.sliding) * np.exp(-((slip / self.speed) ** 2))
        return -sense * force * (self.sliding + more)

    def sense(self, y):
        """Of the slip that begins at rest; 0 if friction holds."""
        held = self.holding(y)
        return 0 if abs(held) < self.static * self.touching(y)[0] else int(-np.sign(held))

    def left(self, y, sense):
        """Positive as long as it goes on like that."""
        force, slip, _ = self.touching(y)
        return sense * slip if sense else (self.static * force) ** 2 - self.holding(y) ** 2


def by_scipy(model, times, angle, direction, distance):
    """Angles at some times, and the times at which it breaks away or comes to rest."""
    hole = distance * np.array([np.sin(direction), -np.cos(direction)])
    centre = hole + ARM * np.array([np.sin(angle), -np.cos(angle)])
    y, t = np.array([*centre, angle, 0, 0, 0]), 0.0
    sense = model.sense(y)
    angles, changes = [angle], []
    for end in times[1:]:
        while t < end:

            def gone(_, y, sense=sense):
                return model.left(y, sense)

            gone.terminal, gone.direction = True, -1
            leg = solve_ivp(
                lambda _, y, sense=sense: model.rates(y, model.rubbing(y, sense))[0], (t, end), y,
                "DOP853", rtol=1e-11, atol=1e-14, events=gone, first_step=1e-7,
            )  # fmt: skip
            t, y = leg.t[-1], leg.y[:, -1]
            if leg.status == 1:
                changes.append(t)
                broken = model.sense(y)
                sense = broken if broken or sense else int(-np.sign(model.holding(y)))
        angles.append(y[2])
    return np.array(angles), changes


@pytest.mark.slow
@pytest.mark.parametrize("falling", [False, True], ids=["coulomb", "stribeck"])
def test_break_away_and_rest_against_scipy(falling):
    """A wide swing slips, rolls, slips where more friction is needed, and rolls again."""
    keys = "friction: 0.15, static: 0.2, stribeck_speed: 5e-3" if falling else "friction: 0.2"
    angle, direction = 0.03, 0.3
    mechanism, distance = pendulum(angle, direction, keys)
    model = Pendulum(0.15 if falling else 0.2, 0.2, 5e-3)
    times = np.linspace(0.0, 0.2, 5)
    own, changes = by_scipy(model, times, angle, direction, distance)
    solution = linkages.simulate(mechanism, times=times, rtol=1e-11, outputs="all")
    data = solution.data
    found = data.bar_angle.sel(bar="arm").to_numpy() + np.pi / 2
    # SciPy locates changes on interpolants, to some 1e-9 s
    np.testing.assert_allclose(found, own, atol=1e-8 * np.abs(own).max())
    noted = solution.motion.changes["gap: slip"]
    assert len(changes) == 3  # to rest, away, to rest
    for time in changes:
        assert np.abs(noted.time - time).min() < 1e-7
    energy = data.kinetic_energy + data.potential_energy
    assert float(abs(data.energy_residual).max()) < 1e-9 * float(abs(energy).max())


ENGINE = loaded_engine("""\
clearances:
  gap: {joint: A, bar: rod, size: 0.1 mm, contact: kelvin-voigt, stiffness: 2e7, damping: 1000,
        pin_radius: 8 mm, friction_law: coulomb, friction: 0.05}
  end: {joint: B, bar: rod, size: 0.05 mm, contact: flores, stiffness: 1e9, restitution: 0.5,
        carries: pin, pin_radius: 6 mm, friction_law: coulomb, friction: 0.1, static: 0.15,
        stribeck_speed: 10 mm/s, offset: [10 um, 0]}
drives: {crank: {angle: 0, speed: 600 rpm}}
""")


def test_a_drive_works_against_friction_that_holds():
    """Two contacts, one of them with memory and slack, in a driven mechanism."""
    solution = linkages.simulate(linkages.loads(ENGINE), end=0.05, samples=201, outputs="all")
    changes = {name: found.count for name, found in solution.motion.changes.items()}
    assert changes["end: slip"] >= 10
    assert changes["gap: press"] >= 2
    data = solution.data
    # errors of a thousand steps at a tolerance of 1e-10
    balance = abs(data.energy_residual).max() / abs(data.kinetic_energy).max()
    assert float(balance) < 1e-11


GUDGEON = loaded_engine("""\
clearances:
  end: {joint: B, bar: rod, size: 0.05 mm, contact: hunt-crossley-constant, stiffness: 1e9,
        dissipation: 1.5, pin_radius: 6 mm, friction_law: coulomb, friction: 0.2, static: 0.3,
        stribeck_speed: 5 mm/s}
drives: {crank: {angle: 0, speed: 600 rpm}}
""")


def test_hundreds_of_releases():
    """Among so many there are some at which round-off decides whether friction still holds."""
    solution = linkages.simulate(linkages.loads(GUDGEON), end=2.0, samples=2001, outputs="all")
    assert solution.motion.changes["end: slip"].count > 1000
