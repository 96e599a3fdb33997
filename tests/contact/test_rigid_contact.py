"""Rigid contact: impacts, closing to the massless link, and opening by the force."""

import math

import numpy as np
import pytest
from shared_definitions import loaded_engine

import linkages
from linkages.errors import InputError

RIGID = "contact: restitution, restitution: 0.8"


def engine(gap, speed="600 rpm"):
    return linkages.loads(
        loaded_engine(f"""\
clearances: {{gap: {{joint: A, bar: rod, size: 0.1 mm, {gap}}}}}
drives: {{crank: {{angle: 0, speed: {speed}}}}}
""")
    )


def test_closed_contact_is_the_massless_link():
    """A quarter of a swing: two models with other coordinates and other equations."""
    link = linkages.simulate(engine("angle: 170 deg", "60 rpm"), end=0.02, outputs="all").data
    start = [1e-4 * math.cos(math.radians(170)), 1e-4 * math.sin(math.radians(170))]
    closed = linkages.simulate(
        engine(f"{RIGID}, offset: {start}", "60 rpm"), end=0.02, outputs="all"
    ).data
    # errors of both at the default tolerance of 1e-10, of 0.18 m and of 200 N
    np.testing.assert_allclose(closed.slider_position, link.slider_position, rtol=0, atol=1e-13)
    np.testing.assert_allclose(closed.clearance_force, link.clearance_force, rtol=1e-7)
    np.testing.assert_allclose(closed.drive_effort, link.drive_effort, rtol=0, atol=1e-8)
    assert (closed.clearance_state == 2).all()


def test_impacts_lose_what_the_formula_says_and_the_energy_is_balanced():
    """(1 − e²) M d'²/2 less what the drive supplies by its impulse; the rest is in balance."""
    solution = linkages.simulate(engine(RIGID), end=0.2, outputs="all")
    data, touches = solution.data, solution.motion.changes["gap: touch"]
    energy = float(abs(data.kinetic_energy + data.potential_energy).max())
    assert float(abs(data.energy_residual).max()) < 1e-10 * energy  # twenty impacts, 5000 steps
    assert touches.rises.sum() > 10
    assert float(data.clearance_force.min()) == 0.0
    # nothing lies deeper in the wall than errors of steps put it
    assert float(data.clearance_indentation.max()) < 1e-8 * 1e-4


def test_the_force_opens_a_closed_contact():
    solution = linkages.simulate(engine(RIGID), end=0.2, samples=2001)
    opened = ~solution.motion.changes["gap: touch"].rises
    pulled = solution.motion.changes["gap: press"]
    assert opened.any()
    assert len(pulled.time) == opened.sum()
    # opened where the force was gone, and not before
    (piece,) = pulled.pieces
    nodes = piece.system.model.contacts[0]
    force = piece.system.evaluate([nodes.force], piece.time, piece.state, held=np.abs(piece.held))
    largest = float(solution.data.clearance_force.max())
    assert np.abs(force).max() < 1e-9 * largest


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_one_impact_of_a_free_pin(restitution):
    text = f"""
joints: {{O: [0, 0]}}
bars: {{pin: {{joints: [O, P], length: 0.1, mass: 0.25, inertia: 1e-4, center: 0}}}}
clearances: {{gap: {{joint: O, bar: pin, size: 0.1 mm, contact: restitution,
              restitution: {restitution}, rate: [0.1, 0.1]}}}}
free: {{pin: {{angle: 0, speed: 0}}}}
"""
    found = linkages.simulate(linkages.loads(text), end=0.001, samples=3, outputs="all").data
    rate = found.clearance_offset_rate.sel(clearance="gap").isel(time=-1)
    # free flight is exact, the impact linear: round-off of 0.1 m/s
    np.testing.assert_allclose(rate, [-0.1 * restitution] * 2, rtol=1e-12)
    lost = 0.5 * 0.25 * 0.02 * (1 - restitution**2)
    kinetic = found.kinetic_energy.to_numpy()
    assert kinetic[0] - kinetic[-1] == pytest.approx(lost, rel=1e-12, abs=1e-17)


@pytest.mark.parametrize(
    ("gap", "expected"),
    [
        (f"{RIGID}, friction: 0.1, pin_radius: 8 mm, slip: 1 mm/s", "coulomb has no 'slip'"),
        (f"{RIGID}, stiffness: 1e9", "restitution has no 'stiffness'"),
        ("contact: restitution", "missing key 'restitution', which restitution needs"),
    ],
)
def test_bad_entries(gap, expected):
    with pytest.raises(InputError, match=expected):
        engine(gap)


def test_impacts_have_no_equations_in_closed_form():
    from linkages.equations import derive
    from linkages.topology.topology import build_topology

    with pytest.raises(InputError, match="impacts change rates at once, by no force"):
        derive(build_topology(engine(RIGID)))


def test_a_crank_at_full_speed_chatters_to_rest_again_and_again():
    """Bounces of 0.1 nm between impacts at 3 m/s: all end, and none is lost in round-off."""
    text = """
gravity: [0, 0]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.30, center: 0.025, inertia: 1.0e-5}
  rod: {joints: [A, B], length: 0.12, mass: 0.21, center: 0.06, inertia: 0.00025}
sliders: {piston: {joint: B, through: O, mass: 0.14}}
clearances: {gap: {joint: B, bar: rod, size: 0.2 mm, contact: restitution, restitution: 0.5}}
drives: {crank: {angle: 0, speed: 5000 rpm}}
assembly: {B: [0.17, 0]}
"""
    solution = linkages.simulate(linkages.loads(text), end=0.12, samples=121, outputs="all")
    data = solution.data
    assert solution.motion.changes["gap: touch"].rises.sum() > 50
    energy = float(abs(data.kinetic_energy).max())
    assert float(abs(data.energy_residual).max()) < 1e-9 * energy
    assert float(data.clearance_indentation.max()) < 1e-6 * 2e-4
