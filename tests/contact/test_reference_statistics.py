"""What chaos does not spoil: exponents, touches, and shares of the states of contact."""

import numpy as np
import pytest
from contact_references import Reference, content
from scipy.stats import t as student

import linkages

FILE = content("9-statistics")
ROWS = FILE["rows"]
PERIOD, TRANSIENT, REVOLUTIONS = 0.012, 80, 400
STARTS = tuple(np.linspace(-0.5, 0.6, 12).tolist())
"""Offsets at the start in sizes: the spread of what they give is our standard error."""
CERTAIN = float(student.ppf(0.99865, len(STARTS) - 1))
"""What three standard errors are where the error is estimated from so few."""
# The reference has three starts of 1500 revolutions each in its exponents.
LONG, BEHIND = 720, 3 * 1500


def mechanism_of(row):
    found = linkages.loads(Reference("4-slider-crank-5000rpm").definition)
    values = {"clearances.gap.size": row["clearance_mm"] * 1e-3}
    if "a d'" in row["law"]:
        gap = found.definition.content["clearances"]["gap"]
        kept = {key: gap[key] for key in ("joint", "bar", "stiffness")}
        law = {"contact": "hunt-crossley-constant", "dissipation": "0.5 s/m"}
        values = {"clearances.gap": {**kept, **law, "size": row["clearance_mm"] * 1e-3}}
    return found.with_values(values)


def identity(row):
    return f"{row['clearance_mm']} mm, {row['law'].split('=')[1].strip()}"


def shares_of(mechanism, start):
    """Means over the revolutions behind the transient, sampled 400 times in each."""
    size = mechanism.definition.content["clearances"]["gap"]["size"]
    found = mechanism.with_values({"clearances.gap.offset": [start * float(size), 0.0]})
    samples = np.linspace(TRANSIENT, TRANSIENT + REVOLUTIONS, 400 * REVOLUTIONS + 1) * PERIOD
    solution = linkages.simulate(
        found, times=np.concatenate([[0.0], samples]), rtol=1e-9,
        outputs=["clearance_indentation", "clearance_indentation_rate", "clearance_force"],
        events={"gap.indentation=0": "up"},
    )  # fmt: skip
    data = solution.data.isel(time=slice(1, None))
    depth, force = (data[f"clearance_{key}"][:, 0].to_numpy() for key in ("indentation", "force"))
    touched = solution.events["gap.indentation=0"]
    rates = touched.clearance_indentation_rate[touched.time > TRANSIENT * PERIOD]
    return {
        "touches_per_revolution": len(rates) / REVOLUTIONS,
        "share_free": np.mean(depth < 0),
        "share_contact": np.mean(force > 0),
        "share_slack": np.mean((depth >= 0) & (force == 0)),
        "mean_touch_rate_m_per_s": float(rates.mean()) if len(rates) else np.nan,
    }


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=identity)
def test_shares_and_touches(row):
    """Within what three standard errors of the difference are; shares are counted to 1e-3."""
    found = [shares_of(mechanism_of(row), start) for start in STARTS]
    for key in found[0]:
        values, (wanted, error) = [each[key] for each in found], row[key]
        if wanted is None:
            assert np.isnan(values).all()
            continue
        own = np.std(values, ddof=1) / np.sqrt(len(values))
        off = abs(np.mean(values) - wanted)
        assert off <= CERTAIN * np.hypot(own, error) + 1e-3, (key, values, wanted)


@pytest.mark.slow
@pytest.mark.parametrize("row", ROWS, ids=identity)
def test_largest_exponent(row):
    """Our standard error is theirs, for a shorter time."""
    found = linkages.lyapunov(mechanism_of(row), periods=LONG, skip=TRANSIENT, count=1)
    exponent = float(found.exponent.max()) * PERIOD
    wanted, error = row["largest_exponent_per_revolution"]
    allowed = 3 * error * np.sqrt(1 + BEHIND / LONG) + 0.03
    within = 0.01 * abs(wanted) if "period_in_revolutions" in row else allowed
    assert abs(exponent - wanted) <= within, (exponent, wanted)
