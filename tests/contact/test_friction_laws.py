"""Laws of friction in a gap: values, corners as modes, and motions in absolute coordinates."""

import numpy as np
import pytest
from absolute_contact import AbsoluteContact
from absolute_legs import motion
from friction_formulas import FORMULAS
from time_functions import jet

import linkages
from linkages.components.contributed.friction_laws import (
    FRICTION_KEYS,
    friction_coefficient,
    friction_laws,
    friction_problems,
)

NUMBERS = {
    "friction": 0.1,
    "static": 0.16,
    "slip": 6e-3,
    "least_slip": 2e-3,
    "stribeck_speed": 9e-3,
}
CORNERS = {"tanh": 0, "ambrosio": 4, "threlfall": 2, "bengisu-akay": 2, "brown-mcphee": 0}
"""Zeros at which a law has a corner; the slip beyond a velocity, of both signs, counts once."""

PENDULUM = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 0.3, mass: 0.5}}}}
free: {{arm: {{angle: -0.9, speed: 0.9}}}}
clearances:
  gap: {{joint: O, bar: arm, size: 0.2 mm, contact: hunt-crossley-constant, stiffness: 1e9,
        dissipation: 1, carries: {carries}, pin_radius: 10 mm, {friction}, offset: [1e-5, 1e-4]}}
"""


def keys_of(law):
    found = friction_laws()[law]
    return {key: NUMBERS[key] for key in ("friction", *found.needs, *found.takes)}


def pendulum(law, carries="hole"):
    pairs = ", ".join(f"{key}: {value}" for key, value in keys_of(law).items())
    return PENDULUM.format(carries=carries, friction=f"friction_law: {law}, {pairs}")


@pytest.mark.parametrize("law", FORMULAS)
def test_values_are_those_of_the_publications(law):
    found = friction_coefficient(law, keys_of(law), ("clearances", "gap"))
    for slip in np.linspace(-0.05, 0.05, 100):  # of both signs; none is a corner
        value = jet(found, 0.0, lambda _, slip=slip: slip)[0]
        assert value == pytest.approx(-FORMULAS[law](slip, keys_of(law)), rel=1e-13, abs=1e-16)


def test_all_laws_are_tested():
    assert set(FORMULAS) == set(friction_laws()) == {*CORNERS, "coulomb"}


@pytest.mark.slow_except("brown-mcphee")
@pytest.mark.parametrize("law", [law for law in CORNERS if law != "tanh"])
def test_motion_against_absolute_coordinates(law):
    """Both integrate at 1e-12; the other one does not stop at corners, and touches amplify."""
    text = pendulum(law, "pin" if law == "threlfall" else "hole")
    times = np.linspace(0.0, 0.04, 401)
    model = AbsoluteContact(text)
    own = motion(model, times[100::100], rtol=1e-12)
    solution = linkages.simulate(linkages.loads(text), times=times, rtol=1e-12, outputs="all")
    slip = solution.data.clearance_slip.sel(clearance="gap").to_numpy()[100::100]
    expected = np.array([model.wall(y, 0).slip for y in own.states])
    np.testing.assert_allclose(slip, expected, atol=1e-8 * np.abs(expected).max())
    assert len(corners(solution)) == CORNERS[law]
    if CORNERS[law]:  # it went through some of them
        assert sum(solution.motion.changes[name].count for name in corners(solution)) >= 2
    balanced(solution.data)


def balanced(data):
    assert float(data.clearance_friction_loss.max()) > 1e-3  # W, of 0.5 N at some mm/s
    # what sticks slips by round-off of velocities of 1 m/s, under some newtons
    assert float(data.clearance_friction_loss.min()) >= -1e-12
    energy = data.kinetic_energy + data.potential_energy
    # errors of some hundred steps at a tolerance of 1e-10 and below
    assert float(abs(data.energy_residual).max()) < 1e-8 * float(abs(energy).max())


def test_slip_in_free_flight_is_none_of_a_law():
    """Beside a velocity of 10 µm/s that of a free pin is so large that exponentials overflow."""
    text = pendulum("threlfall").replace("slip: 0.006", "slip: 1e-5")
    data = linkages.simulate(linkages.loads(text), end=0.012, outputs="all").data
    assert float(abs(data.clearance_slip).max()) > 700 / 3 * 1e-5  # exp(700) is about the largest
    assert float(data.clearance_force.max()) > 0.0
    assert np.isfinite(data.clearance_friction).all()


def corners(solution):
    names = [switch.name for switch in solution.system.model.switches.switches]
    return [name for name in names if "slip" in name]


def test_impacts_with_friction_that_sticks():
    """Touches set the sense of the slip anew, and sticking ends with the contact at the latest."""
    solution = linkages.simulate(linkages.loads(pendulum("coulomb")), end=0.05, outputs="all")
    balanced(solution.data)
    touches, slips = (solution.motion.changes[f"gap: {mode}"] for mode in ("touch", "slip"))
    assert touches.rises.sum() >= 3
    assert slips.count >= 3


@pytest.mark.parametrize("law", FORMULAS)
def test_every_law_says_what_it_lacks(law):
    lacking = dict.fromkeys(FRICTION_KEYS) | {"friction": 0.1}
    told = [text for _, text in friction_problems(law, lacking)]
    needs = friction_laws()[law].needs
    assert [text.split(":")[0] for text in told] == [f"missing key {key!r}" for key in needs]
    assert not list(friction_problems(law, dict.fromkeys(FRICTION_KEYS)))  # there is no friction


@pytest.mark.parametrize(
    ("law", "changed", "expected"),
    [
        ("bengisu-akay", {"static": 0.05}, "expected at least 0.1, what 'friction' is, found 0.05"),
        ("ambrosio", {"least_slip": 7e-3}, "expected less than 'slip', 0.006, found 0.007"),
        ("coulomb", {"stribeck_speed": None}, "missing key 'stribeck_speed': it goes with"),
        ("coulomb", {"static": None}, "missing key 'static': it goes with 'stribeck_speed'"),
        ("tanh", {"static": 0.2}, "tanh has no 'static'; it takes friction, slip"),
    ],
)
def test_numbers_that_do_not_fit(law, changed, expected):
    given = dict.fromkeys(FRICTION_KEYS) | keys_of(law) | changed
    (problem,) = friction_problems(law, given)
    assert expected in problem[1]
