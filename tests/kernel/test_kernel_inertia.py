"""Masses at pins against the energy of the body itself."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkage_models import NAMES, system, system_of, values

from linkages.components.rigid_bodies import Bar, Plate

NUMBERS = st.floats(-2, 2).map(lambda x: round(x, 3))
POSITIVE = st.floats(0.05, 5).map(lambda x: round(x, 3))


def energies_of_bodies(of, time, state):
    """½ m v_c² + ½ J ω² and −m g·x_c of every body, from places and velocities of its points."""
    model = of.model
    kinetic = potential = 0.0
    gravity = np.array([of.mechanism.gravity.x.value, of.mechanism.gravity.y.value])
    for component in of.mechanism.components:
        body = of.mechanism.bodies.get(getattr(component, "name", ""))
        if body is None or component.section not in ("bars", "sliders"):
            continue
        joint = next(iter(body.points))
        nodes = [
            getattr(vectors[joint], axis)
            for vectors in (model.positions.joints, model.velocities.joints)
            for axis in "xy"
        ]
        x, y, vx, vy = of.evaluate(nodes, time, state)[:, 0]
        place, velocity = x + 1j * y, vx + 1j * vy
        mass, inertia, rate = body.mass.value, 0.0, 0.0
        if isinstance(component, Bar | Plate):
            unit = of.model.positions.unit(body.name)
            c, s = of.evaluate([unit.x, unit.y], time, state)[:, 0]
            (rate,) = of.evaluate([model.velocities.bodies[body.name]], time, state)[:, 0]
            offset = complex(*(p.value for p in body.centre))
            offset -= complex(*(p.value for p in body.points[joint]))
            arm = (c + 1j * s) * offset
            place, velocity = place + arm, velocity + 1j * rate * arm
            inertia = body.inertia.value
        kinetic += 0.5 * mass * abs(velocity) ** 2 + 0.5 * inertia * rate**2
        potential -= mass * (gravity @ [place.real, place.imag])
    return kinetic, potential


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("time", [0.0, 0.11])
def test_energies_of_mechanisms(name, time):
    of = system(name)
    state = of.state[:, None] + 0.1
    kinetic, potential = energies_of_bodies(of, time, state)
    # sums of a dozen terms; masses at pins have both signs and cancel to a digit or so
    found = values(of, "kinetic_energy", time, state)[0, 0]
    assert found == pytest.approx(kinetic, rel=1e-13)
    found = values(of, "potential_energy", time, state)[0, 0]
    assert found == pytest.approx(potential, rel=1e-13, abs=1e-13)


@settings(max_examples=60)
@given(
    points=st.lists(st.tuples(NUMBERS, NUMBERS), min_size=1, max_size=4, unique=True),
    centre=st.tuples(NUMBERS, NUMBERS),
    mass=POSITIVE,
    inertia=POSITIVE,
    angle=NUMBERS,
    speed=NUMBERS,
)
def test_random_plates_on_a_pin(points, centre, mass, inertia, angle, speed):
    """Centres off the line through two pins, at a pin, beyond both of them."""
    pins = ", ".join(f"J{i}: [{x}, {y}]" for i, (x, y) in enumerate(points))
    heavy = f"mass: {mass}, inertia: {inertia}, center: [{centre[0]}, {centre[1]}]"
    of = system_of(f"""
gravity: [1.3, -9.81]
joints: {{J0: [0.2, -0.4]}}
bars:
  plate: {{points: {{{pins}}}, {heavy}}}
free: {{plate: {{angle: {angle}, speed: {speed}}}}}
""")
    arm = np.exp(1j * angle) * (complex(*centre) - complex(*points[0]))
    about_pin = inertia + mass * abs(arm) ** 2
    # pins 1e-3 apart make masses of m·|centre|/1e-3 that cancel, twice in the moment of inertia
    magnitude = (1 + abs(complex(*centre)) + 6) ** 2
    apart = 1.0 if len(points) == 1 else abs(complex(*points[1]) - complex(*points[0]))
    noise = 1e-14 * mass * magnitude * max(1, 1 / apart)
    kinetic = values(of, "kinetic_energy")[0, 0]
    assert kinetic == pytest.approx(0.5 * about_pin * speed**2, rel=1e-12, abs=noise * speed**2)
    place = 0.2 - 0.4j + arm
    potential = -mass * (1.3 * place.real - 9.81 * place.imag)
    assert values(of, "potential_energy")[0, 0] == pytest.approx(potential, abs=20 * noise)
    # J θ̈ = m g × r
    torque = mass * (arm.real * -9.81 - arm.imag * 1.3)
    (found,) = of.evaluate(of.model.free_accelerations)[:, 0]
    scale = (10 * mass + mass * speed**2) * magnitude * max(1, 1 / apart) / about_pin
    assert found == pytest.approx(torque / about_pin, abs=1e-13 * scale * (1 + scale))


@pytest.mark.parametrize("name", ["clearance", "ninebar", "doublependulum"])
def test_inertia_terms_are_the_hessian_of_the_kinetic_energy(name):
    """T is quadratic in the free rates: its second differences are exact, J_ij of Eq. 5."""
    of = system(name)
    count = len(of.topology.free)

    def kinetic(rates):
        state = np.concatenate([of.state[:count], rates])
        return values(of, "kinetic_energy", 0.0, state[:, None])[0, 0]

    unit = np.eye(count)
    matrix = of.model.mass_matrix
    for i in range(count):
        for j in range(i + 1):
            second = (
                kinetic(unit[i] + unit[j]) - kinetic(unit[i] - unit[j])
                - kinetic(unit[j] - unit[i]) + kinetic(-unit[i] - unit[j])
            ) / 4  # fmt: skip
            (found,) = of.evaluate([matrix[i][j]])[:, 0]
            # the cranks' energy of about 1 J drops out of the differences
            assert found == pytest.approx(second, rel=1e-12, abs=1e-15)
