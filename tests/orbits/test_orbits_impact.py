"""Orbits of the impact oscillator: multipliers, folds, doublings and grazing in closed form."""

import json

import numpy as np
import pytest
from orbit_mechanisms import REFERENCE, impact_oscillator, points

from linkages.orbits.follow import follow
from linkages.orbits.orbit import orbit

CASES = {row["omega_over_sqrt_k"]: row for row in REFERENCE["impact_oscillator"]}

RANGES = {
    "0.7": (0.4, 0.6),
    "0.8": (0.3, 0.6),
    "1.0": (0.05, 0.3),
    "1.2": (0.1, 17.0),
    "1.5": (0.3, 1.5),
    "1.8": (1.0, 2.5),
    "2.2": (3.0, 4.5),
    "2.5": (5.0, 5.5),
    "3.1": (8.0, 9.0),
}
"""Amplitudes between which the branch through the grazing orbit is followed."""


def test_multipliers_of_an_impacting_orbit():
    """Trace and determinant with 17 digits; the goal is 1e-9."""
    known = REFERENCE["orbit"]
    data = orbit(impact_oscillator())
    values = data["multiplier"].sel(part="real").to_numpy()
    values = values + 1j * data["multiplier"].sel(part="imaginary").to_numpy()
    assert values.sum().real == pytest.approx(float(known["trace"]), rel=1e-11)
    assert values.prod().real == pytest.approx(float(known["determinant"]), rel=1e-11)
    assert data.attrs["contacts"] == 1
    assert data.attrs["stable"] == 1
    assert data.attrs["period"] == pytest.approx(2 * np.pi, rel=1e-15)
    assert data.attrs["state_change"] < 1e-10


@pytest.mark.slow_except("1.0", "0.8")
@pytest.mark.parametrize("ratio", RANGES)
def test_branches_through_grazing(ratio):
    """Locations within 1e-11: closed form of the orbit, and of the response that just touches."""
    known = CASES[ratio]
    low, high = RANGES[ratio]
    mechanism = impact_oscillator(amplitude=0.8 * low + 0.2 * high, frequency=float(ratio))
    data = follow(mechanism, {"parameters.A": (low, high)}, periods=1)
    (grazing,) = points(data, "grazing")
    assert grazing == pytest.approx(float(known["grazing_A"]), rel=1e-11)
    for kind in ("fold", "period doubling"):
        expected = [float(row["A"]) for row in known.get(kind, ()) if low < float(row["A"]) < high]
        assert points(data, kind) == pytest.approx(expected, rel=1e-11)


def test_doubling_of_an_orbit_far_from_grazing():
    """At ω = 2.5 it does not belong to the branch that grazes."""
    mechanism = impact_oscillator(amplitude=16.0, frequency=2.5)
    data = follow(mechanism, {"parameters.A": (12.0, 20.0)}, periods=1)
    (known,) = CASES["2.5"]["period doubling"]
    assert points(data, "period doubling") == pytest.approx([float(known["A"])], rel=1e-11)


def test_orbits_beside_grazing_impact_once():
    """On one side of the grazing orbit nothing touches, on the other once a period."""
    data = follow(impact_oscillator(), {"parameters.A": (0.05, 0.3)})
    place = int(np.flatnonzero(data.kind == "grazing")[0])
    assert (data.contacts[:place] == 0).all()
    assert (data.contacts[place + 1 :] == 1).all()


def test_random_starts_on_a_branch_that_is_followed():
    """The silent and the knocking motion are on one branch, which joins them by grazing."""
    data = follow(impact_oscillator(0.3, 1.2), {"parameters.A": (0.1, 0.6)}, starts=12)
    assert len(json.loads(data.attrs["branches"])) == 1
    at = np.abs(data["value"].to_numpy()[:, 0] - 0.3)
    contacts, stable = data["contacts"].to_numpy(), data["stable"].to_numpy()
    assert {(int(contacts[k]), int(stable[k])) for k in np.argsort(at)[:6]} >= {(0, 1), (1, 1)}


def test_grazing_curve():
    """|d| √((k − ω²)² + (c ω)²): the amplitude at which the response touches."""
    mechanism = impact_oscillator(frequency=0.8)
    data = follow(
        mechanism,
        {"parameters.A": (0.2, 1.0)},
        locus="G1",
        other={"parameters.w": (0.75, 0.85)},
        points=80,
    )
    amplitude, frequency = data["value"].to_numpy().T
    exact = np.hypot(1.0 - frequency**2, 0.1 * frequency)
    assert len(amplitude) > 5
    assert np.ptp(frequency) == pytest.approx(0.1, abs=1e-5)
    np.testing.assert_allclose(amplitude, exact, rtol=1e-10)


def test_fold_curve_meets_the_fold_of_another_frequency():
    """The locus from ω = 1.2 passes the reference at ω = 1.5."""
    data = follow(
        impact_oscillator(frequency=1.2),
        {"parameters.A": (0.1, 1.0)},
        locus="F1",
        other={"parameters.w": (1.2, 1.5)},
        points=60,
    )
    last = data["value"].to_numpy()[np.argmax(data["value"].to_numpy()[:, 1])]
    assert last[1] == pytest.approx(1.5, abs=1e-12)
    assert last[0] == pytest.approx(float(CASES["1.5"]["fold"][0]["A"]), rel=1e-9)
