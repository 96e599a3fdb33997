"""One impact of a free pin by every law: restitution, largest depth, duration by closed forms."""

import numpy as np
import pytest
from contact_laws import (
    DAMPING_FACTORS,
    duration,
    halves,
    largest_indentation,
    reached,
    undamped_duration,
)
from contact_references import content

import linkages

FILE = content("1-one-impact")
MASS, SPEED, STIFFNESS, SIZE = 0.25, 0.1, 1e9, 1e-4
LIMIT = 1e-9
"""At a tolerance of 1e-12, as measured at the touch and the leave that are located."""
CROSSED = "gap.indentation=0"


def impact(law, chi, restitution=None, **values):
    """Restitution, largest indentation and duration of the first impact.

    The indentation is that at the time at which its rate ought to be zero, and is.
    """
    text = FILE["definition_in_words_of_a_file"].replace("<law>", law)
    if restitution is None:
        text = text.replace("restitution: <restitution>, ", "")
    for key, value in values.items():
        text = text.replace("exponent: 1.5", f"exponent: 1.5, {key}: {value}")
    mechanism = linkages.loads(text.replace("<restitution>", str(restitution)))
    still = SIZE / SPEED + halves(chi, MASS, SPEED, STIFFNESS)[0]
    found = linkages.simulate(
        mechanism, times=[0.0, still, 0.0025], rtol=1e-12, events={CROSSED: "both"},
        outputs=["clearance_indentation", "clearance_indentation_rate"],
    )  # fmt: skip
    crossed = found.events[CROSSED]
    touch, leave = crossed.time.to_numpy()
    before, after = crossed.clearance_indentation_rate.to_numpy()[:, 0]
    deepest = float(found.data.clearance_indentation[1, 0])
    assert abs(float(found.data.clearance_indentation_rate[1, 0])) < LIMIT * SPEED
    assert touch == pytest.approx(SIZE / SPEED, rel=1e-12)
    return -after / before, deepest, leave - touch


@pytest.mark.parametrize("row", FILE["rows"], ids=lambda row: f"{row['law']}-{row['restitution']}")
def test_tabulated_impacts(row):
    law = row["law"]
    found = impact(
        law, float(row["damping_factor"]), None if law == "hertz" else row["restitution"]
    )
    names = ("restitution_reached", "largest_indentation", "duration")
    assert found == pytest.approx([float(row[name]) for name in names], rel=LIMIT)


@pytest.mark.parametrize("restitution", [0.9, 0.5])
@pytest.mark.parametrize("law", DAMPING_FACTORS)
def test_every_law_with_restitution(law, restitution):
    chi = DAMPING_FACTORS[law](restitution)
    about = chi, MASS, SPEED, STIFFNESS
    expected = reached(chi), largest_indentation(*about), duration(*about)
    assert impact(law, chi, restitution) == pytest.approx(expected, rel=LIMIT)


def test_exact_law_bounces_as_it_is_told():
    chi = DAMPING_FACTORS["exact"](0.5)
    assert impact("exact", chi, 0.5)[0] == pytest.approx(0.5, rel=LIMIT)


@pytest.mark.parametrize("dissipation", [0.5, 1.5])
def test_constant_dissipation(dissipation):
    """χ = a v."""
    chi = dissipation * SPEED
    about = chi, MASS, SPEED, STIFFNESS
    expected = reached(chi), largest_indentation(*about), duration(*about)
    found = impact("hunt-crossley-constant", chi, dissipation=dissipation)
    assert found == pytest.approx(expected, rel=LIMIT)


@pytest.mark.parametrize("exponent", [1.2, 2.0])
def test_elastic_impact_of_another_exponent(exponent):
    text = FILE["definition_in_words_of_a_file"].replace("<law>", "hertz")
    text = text.replace("restitution: <restitution>, ", "").replace(
        "exponent: 1.5", f"exponent: {exponent}"
    )
    text = text.replace("1e9 N/m^1.5", "1e8")
    found = linkages.simulate(
        linkages.loads(text), end=0.02, samples=2, rtol=1e-12, events={CROSSED: "both"},
        outputs=["clearance_indentation_rate"],
    ).events[CROSSED]  # fmt: skip
    touch, leave = found.time.to_numpy()[:2]
    assert leave - touch == pytest.approx(undamped_duration(MASS, SPEED, 1e8, exponent), rel=LIMIT)
    rates = found.clearance_indentation_rate.to_numpy()[:2, 0]
    assert -rates[1] / rates[0] == pytest.approx(1.0, rel=LIMIT)


def test_kelvin_voigt():
    """A damped oscillator for half a period, until the force would pull: then nothing acts.

    With d = (v/ω) e^(−δt) sin ωt the force K d + D d′ vanishes where tan ωt = −2 δ ω/(ω² − δ²) in
    the second quadrant; from there on the pin flies with the rate that it has.
    """
    stiffness, damping = 1e6, 300.0
    decay = damping / (2 * MASS)
    omega = np.sqrt(stiffness / MASS - decay**2)
    time = np.arctan2(2 * decay * omega, decay**2 - omega**2) / omega
    rate = (
        SPEED
        * np.exp(-decay * time)
        * (np.cos(omega * time) - decay / omega * np.sin(omega * time))
    )
    depth = SPEED / omega * np.exp(-decay * time) * np.sin(omega * time)
    text = FILE["definition_in_words_of_a_file"].replace("<law>", "kelvin-voigt")
    text = text.replace("restitution: <restitution>", f"damping: {damping}")
    text = text.replace(", exponent: 1.5", "").replace("1e9 N/m^1.5", f"{stiffness:g}")
    found = linkages.simulate(
        linkages.loads(text), end=0.004, samples=2, rtol=1e-12, events={CROSSED: "both"},
        outputs=["clearance_indentation_rate"],
    ).events[CROSSED]  # fmt: skip
    touch, leave = found.time.to_numpy()[:2]
    assert found.clearance_indentation_rate.to_numpy()[1, 0] == pytest.approx(rate, rel=LIMIT)
    assert leave - touch == pytest.approx(time - depth / rate, rel=LIMIT)
