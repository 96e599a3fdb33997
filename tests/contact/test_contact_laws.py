"""Laws of contact: what one impact of a free body reaches, in closed form."""

import math
from pathlib import Path

import pytest

from linkages.components.contributed.contact_laws import contact_laws
from linkages.components.contributed.friction_laws import friction_laws
from linkages.components.contributed.normal_forces import (
    factor_for,
    restitution_reached,
    stiffness_of_cylinders,
    stiffness_of_spheres,
)

# χ over the wanted restitution, and what one impact reaches with it (Lambert's W, 14 digits).
# Of one impact of 0.25 kg at 0.1 m/s against K = 1e9 N/m^1.5; computed in quadruple precision.
REACHED = [
    ("hunt-crossley", 0.9, 0.15, 0.9090157413492023),
    ("hunt-crossley", 0.7, 0.45, 0.7679997890784757),
    ("lankarani-nikravesh", 0.9, 0.1425, 0.913176677805581),
    ("lankarani-nikravesh", 0.5, 0.5625, 0.7252411140101973),
    ("gonthier", 0.7, 0.72857142857142857, 0.6695813197483053),
    ("flores", 0.9, 0.17777777777777778, 0.8939206926633782),
    ("flores", 0.5, 1.6, 0.4704447793267395),
    ("hu-guo", 0.7, 0.64285714285714286, 0.6972969680608594),
]

# Restitutions reached where 0.9, 0.7, 0.5 and 0.3 are asked for, to three digits.
TABLE = {
    "hunt-crossley": (0.909, 0.768, 0.663, 0.581),
    "herbert-mcwhannell": (0.901, 0.723, 0.594, 0.520),
    "lee-wang": (0.952, 0.869, 0.799, 0.739),
    "lankarani-nikravesh": (0.913, 0.796, 0.725, 0.684),
    "gonthier": (0.876, 0.670, 0.488, 0.304),
    "zhiying-qishao": (0.896, 0.680, 0.483, 0.327),
    "flores": (0.894, 0.683, 0.470, 0.256),
    "hu-guo": (0.900, 0.697, 0.488, 0.271),
    "safaeifar-farshidianfar": (0.915, 0.735, 0.536, 0.314),
    "exact": (0.9, 0.7, 0.5, 0.3),
}


# laws whose force is not that of one impact with a restitution
OTHERS = {
    "carvalho-martins", "hertz", "hunt-crossley-constant", "kelvin-voigt", "lubricated",
    "lubricated-full", "restitution",
}  # fmt: skip
PAGE = Path(__file__).parents[2] / "docs/components/contact-clearance.md"


def test_all_laws_are_tested():
    assert {*TABLE, *OTHERS} == set(contact_laws())


@pytest.mark.parametrize("law", [*contact_laws().values(), *friction_laws().values()])
def test_every_law_has_a_source_and_stands_on_its_page(law):
    assert law.source
    assert f"`{law.name}`" in PAGE.read_text(encoding="utf-8")


def factor(law, restitution):
    return contact_laws()[law].restitution(restitution)


@pytest.mark.parametrize(("law", "restitution", "damping", "reached"), REACHED)
def test_factors_and_what_they_reach(law, restitution, damping, reached):
    found = factor(law, restitution)
    assert found == pytest.approx(damping, rel=1e-15)
    # the logarithms of the equation cancel to second order in a factor of a tenth: 1e-16 / 0.1²
    assert restitution_reached(found) == pytest.approx(reached, abs=2e-14)


@pytest.mark.parametrize("law", TABLE)
def test_every_law_reaches_what_its_table_says(law):
    wanted = (0.9, 0.7, 0.5, 0.3)
    reached = [restitution_reached(factor(law, one)) for one in wanted]
    assert reached == pytest.approx(TABLE[law], abs=5e-4)  # the table has three digits


def test_carvalho_and_martins_are_within_a_thousandth_in_its_range():
    for wanted in (0.42, 0.5, 0.7, 0.9):
        assert restitution_reached(factor("carvalho-martins", wanted)) == pytest.approx(
            wanted, abs=1e-3
        )


def test_the_exact_factor_is_the_limit_of_small_losses():
    """Of restitutions close to one χ tends to ¾(1 − e²)."""
    for loss in (1e-2, 1e-3):
        wanted = 1.0 - loss
        assert factor_for(wanted) == pytest.approx(0.75 * (1 - wanted**2), rel=2 * loss)
    assert factor_for(1.0) == 0.0
    assert restitution_reached(0.0) == 1.0


def test_stiffness_of_a_steel_pin_of_the_literature():
    """207 GPa, 0.3, radii of 10 and 9.5 mm: 6.61e10 N/m^1.5 in papers, 6.6102e10 by hand."""
    assert stiffness_of_spheres(207e9, 0.3, 0.01, 0.0095) == pytest.approx(6.6102e10, rel=1e-5)


def test_stiffness_of_a_cylinder_in_a_hole():
    """By hand of the same steel, 0.5 mm and 20 mm wide: 857 N at 1 µm, 27 891 N at 20 µm."""
    stiffness, exponent = stiffness_of_cylinders(207e9, 0.3, 5e-4, 0.02)
    assert stiffness * 1e-6**exponent == pytest.approx(857, rel=1e-3)
    assert stiffness * 20e-6**exponent == pytest.approx(27891, rel=1e-3)
    # below 0.35 mm: n = 1.51 ln(100)^−0.151 · 0.1^−0.005
    _, narrow = stiffness_of_cylinders(207e9, 0.3, 1e-4, 0.02)
    assert narrow == pytest.approx(1.51 * math.log(100) ** -0.151 * 0.1**-0.005, rel=1e-14)


def test_lambert_s_function_solves_the_same_equation():
    scipy = pytest.importorskip("scipy.special")
    for damping in (0.05, 0.5, 1.5, 3.0):
        argument = -(1 + damping) * math.exp(-1 - damping)
        expected = (1 + scipy.lambertw(argument).real) / damping
        # close to −1/e the function itself is known to the root of round-off
        assert restitution_reached(damping) == pytest.approx(expected, abs=1e-12)
