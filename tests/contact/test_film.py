"""Films of oil between pin and hole: against quadrature of the pressure, and Ocvirk's bearing."""

import numpy as np
import pytest
from scipy.integrate import quad

import linkages
from linkages.chaos.contact_log import contact_of
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System

VISCOSITY, WIDTH, PIN, SIZE = 0.04, 12e-3, 15e-3, 1e-4
ROTOR = """
gravity: [0, {gravity}]
joints: {{O: [0, 0]}}
bars: {{rotor: {{points: {{O: [0, 0], P: [0.1, 0]}}, mass: 2, center: [0, 0], inertia: 1e-3}}}}
drives: {{rotor: {{angle: 0.4, speed: {speed}}}}}
clearances:
  gap: {{joint: O, bar: rotor, size: {size}, contact: {law}, viscosity: {viscosity}, width: {width},
        pin_radius: {pin}, carries: {carries}, offset: {offset}, rate: {rate}}}
"""
LAWS = {"lubricated": False, "lubricated-full": True}


def rotor(law, offset, rate=(0, 0), *, speed=120.0, carries="pin", gravity=0.0):
    return linkages.loads(
        ROTOR.format(
            law=law, offset=list(map(float, offset)), rate=list(map(float, rate)), speed=speed,
            carries=carries, gravity=gravity, size=SIZE, viscosity=VISCOSITY, width=WIDTH, pin=PIN,
        )
    )  # fmt: skip


def at_start(mechanism):
    """Force towards the middle, force along the wall, and effort of the drive at t = 0."""
    system = System(mechanism)
    accelerations = system.evaluate(system.model.free_accelerations)
    names = ("clearance_force", "clearance_friction", "drive_effort")
    nodes = [VARIABLES[name].evaluated(system.model)[0] for name in names]
    return system.evaluate(nodes, acceleration=accelerations)[:, 0]


class Bearing:
    """Pressure at an angle, summed up over the width; offset and rate are those of the journal."""

    def __init__(self, offset, rate, speed, *, whole):
        self.offset, self.rate = np.array(offset), np.array(rate)
        self.speed, self.whole = speed, whole  # of the journal; the hole stands still

    def thickness(self, angle):
        return SIZE - self.offset @ [np.cos(angle), np.sin(angle)]

    def pressure(self, angle):
        """Reynolds: ∂(h³/(12 η) ∂p/∂z)/∂z = U/(2 R) ∂h/∂angle + ∂h/∂t, a parabola over z.

        The integral of (L²/4 − z²) over the width is L³/6.
        """
        n, t = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        wedge = -self.speed / 2 * (self.offset @ t)
        squeeze = -(self.rate @ n)
        found = -6 * VISCOSITY / self.thickness(angle) ** 3 * (wedge + squeeze) * WIDTH**3 / 6
        return found if self.whole else max(found, 0.0)

    def integral(self, value):
        """Over the film, between the angles at which the pressure is zero."""
        velocity = self.rate - self.speed / 2 * np.array([-self.offset[1], self.offset[0]])
        first = np.arctan2(velocity[1], velocity[0]) - np.pi / 2
        reach = 2 * np.pi if self.whole else np.pi
        return quad(value, first, first + reach, epsabs=0, epsrel=1e-12, limit=400)[0]

    def force(self):
        """On the journal."""
        return -PIN * np.array(
            [
                self.integral(lambda angle: self.pressure(angle) * np.cos(angle)),
                self.integral(lambda angle: self.pressure(angle) * np.sin(angle)),
            ]
        )

    def torque(self):
        """Of the shear on the surface of the journal, ∫∫ (η ΔU/h − h/2 ∂p/∂x) R² over it."""
        step = 1e-5

        def stress(angle):
            slope = self.pressure(angle + step) - self.pressure(angle - step)
            sheared = -VISCOSITY * PIN * self.speed * WIDTH / self.thickness(angle)
            return PIN**2 * (sheared - self.thickness(angle) / 2 * slope / (2 * step) / PIN)

        return self.integral(stress)


def states(count=6):
    """Offsets, rates and angular speeds, some of which turn the film back."""
    random = np.random.default_rng(7)
    for _ in range(count):
        angle, ratio = random.uniform(0, 2 * np.pi), random.uniform(0.05, 0.9)
        offset = ratio * SIZE * np.array([np.cos(angle), np.sin(angle)])
        yield offset, random.normal(0, 120 * SIZE / 2, 2), random.uniform(-200, 200)


@pytest.mark.parametrize("law", LAWS)
def test_forces_are_integrals_of_the_pressure(law):
    for offset, rate, speed in states():
        expected = Bearing(offset, rate, speed, whole=LAWS[law]).force()
        force, friction, _ = at_start(rotor(law, offset, rate, speed=speed))
        normal = offset / np.linalg.norm(offset)
        across = np.array([-normal[1], normal[0]])
        # quadrature to 1e-12, of what changes a hundredfold within the film
        np.testing.assert_allclose(
            friction * across - force * normal, expected, atol=1e-9 * np.linalg.norm(expected)
        )


@pytest.mark.parametrize("law", LAWS)
def test_the_drive_turns_against_the_shear(law):
    for offset, rate, speed in states(3):
        expected = Bearing(offset, rate, speed, whole=LAWS[law]).torque()
        *_, effort = at_start(rotor(law, offset, rate, speed=speed))
        # a derivative of the pressure by differences of 1e-5
        assert effort == pytest.approx(-expected, rel=1e-5)


@pytest.mark.parametrize("law", LAWS)
def test_who_carries_the_hole_does_not_matter(law):
    offset, rate, speed = next(states())
    pin, hole = (
        at_start(rotor(law, offset, rate, speed=speed, carries=carries))
        for carries in ("pin", "hole")
    )
    np.testing.assert_allclose(pin, hole, rtol=1e-14)


def load_and_attitude(ratio, speed):
    """Ocvirk's short bearing: η ω R L³/(4 c²) ε/(1 − ε²)² √(16 ε² + π² (1 − ε²)), and its angle."""
    root = np.sqrt(1 - ratio**2)
    load = VISCOSITY * speed * PIN * WIDTH**3 / (4 * SIZE**2) * ratio / root**4
    load *= np.sqrt(16 * ratio**2 + np.pi**2 * root**2)
    return load, np.arctan2(np.pi * root, 4 * ratio)


@pytest.mark.parametrize("ratio", [1e-6, 0.1, 0.5, 0.9, 0.99])
def test_load_and_attitude_of_ocvirk_s_bearing(ratio):
    force, friction, _ = at_start(rotor("lubricated", (0, -ratio * SIZE)))
    load, attitude = load_and_attitude(ratio, 120.0)
    # 1 − ε² has two digits less at 0.99
    assert np.hypot(force, friction) == pytest.approx(load, rel=1e-12)
    assert np.arctan2(friction, force) == pytest.approx(attitude, rel=1e-12)


def test_a_rotor_comes_to_its_equilibrium():
    """The load of Ocvirk's bearing is the weight, and its attitude the angle with that."""
    mechanism = rotor("lubricated", (0, 0), gravity=-9.81, speed=60.0)
    solution = linkages.simulate(mechanism, end=0.6, samples=61, outputs="all", rtol=1e-10)
    offset = solution.data.clearance_offset.sel(clearance="gap").to_numpy()[-1]
    ratio = float(np.hypot(*offset)) / SIZE
    load, attitude = load_and_attitude(ratio, 60.0)
    # by then it still moves by some 1e-6 of the size
    assert load == pytest.approx(2 * 9.81, rel=1e-4)
    assert np.arctan2(offset[0], -offset[1]) == pytest.approx(attitude, abs=1e-4)
    data = solution.data
    assert float(data.clearance_normal_loss.min()) >= 0.0
    assert float(data.clearance_friction_loss.min()) > 0.0
    assert (data.clearance_state == 0).all()
    work = float(abs(data.drive_power).max()) * 0.6
    assert float(abs(data.energy_residual).max()) < 1e-9 * work
    thinnest = -float(data.clearance_indentation.max())
    assert any(f"{thinnest / SIZE:.1%} of the size" in note for note in solution.notes)


CRANK = "crank: {joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}"
ROD = "rod: {joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}"
ENGINE = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  {first}
  {second}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
clearances:
  oil: {{joint: A, bar: rod, size: 0.1 mm, contact: lubricated, viscosity: 0.1 Pa*s, width: 15 mm,
        pin_radius: 8 mm}}
  dry: {{joint: B, bar: rod, size: 0.05 mm, contact: hunt-crossley-constant, stiffness: 1e9,
        dissipation: 1.5, pin_radius: 6 mm, friction_law: coulomb, friction: 0.3}}
drives: {{crank: {{angle: 0, speed: 600 rpm}}}}
loads: [{{slider: piston, force: -200 N}}]
assembly: {{B: [0.18, 0]}}
"""


@pytest.mark.slow
def test_oil_at_one_end_of_a_rod_and_dry_friction_at_the_other():
    """Energy is balanced, and bars in another order move alike."""
    found = [
        linkages.simulate(
            linkages.loads(ENGINE.format(first=first, second=second)),
            end=0.03, samples=61, outputs="all",
        )
        for first, second in ((CRANK, ROD), (ROD, CRANK))
    ]  # fmt: skip
    data, other = (solution.data for solution in found)
    assert found[0].motion.changes["dry: slip"].count >= 10
    assert not contact_of(found[0])  # a film that pulls keeps its pin
    # errors of some thousand steps at a tolerance of 1e-10
    balance = abs(data.energy_residual).max() / abs(data.kinetic_energy).max()
    assert float(balance) < 1e-10
    apart = abs(data.slider_position - other.slider_position).max()
    assert float(apart) < 1e-11


def test_thin_films_are_for_implicit_steps():
    """A journal under load, which an explicit method follows in steps of the film's stability."""
    loaded = rotor("lubricated", (0.0, -0.045e-3), speed=2.0, gravity=-9.81)
    found = {
        name: linkages.simulate(loaded, end=0.5, samples=101, method=name, rtol=1e-8)
        for name in ("dop853", "auto")
    }
    offsets = [motion.data.clearance_offset.to_numpy() for motion in found.values()]
    assert np.abs(offsets[0] - offsets[1]).max() < 1e-7 * SIZE
    explicit, chosen = (motion.motion for motion in found.values())
    assert chosen.method == "radau"
    assert "oil film" in chosen.reason
    assert chosen.cost["steps"] < explicit.cost["steps"] / 20
    (note,) = [note for note in found["dop853"].notes if "--method radau" in note]
    assert f"dop853 took {explicit.cost['steps']:,} steps" in note
    assert not any("--method radau" in note for note in found["auto"].notes)
