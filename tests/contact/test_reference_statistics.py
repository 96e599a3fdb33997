"""What chaos does not spoil: exponents, touches, and shares of the states of contact."""

import numpy as np
import pytest
from contact_references import Reference, content

import linkages

FILE = content("9-statistics")
ROWS = FILE["rows"]
PERIOD, TRANSIENT, REVOLUTIONS = 0.012, 40, 300
# The reference has 8 · 720 revolutions in its shares and 3 · 1500 in its exponents.
SHARES, EXPONENTS = 8 * 720, 3 * 1500


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


def combined(row, key, revolutions, behind):
    """Three standard errors of the difference: theirs, and ours as theirs tells it."""
    value, error = row[key]
    return value, 3 * error * np.sqrt(1 + behind / revolutions)


@pytest.mark.long
@pytest.mark.parametrize("row", ROWS, ids=identity)
def test_shares_and_touches(row):
    """Sampled 400 times a revolution; at a tolerance of 1e-8, which shares do not feel."""
    samples = 400 * REVOLUTIONS
    times = np.linspace(TRANSIENT * PERIOD, (TRANSIENT + REVOLUTIONS) * PERIOD, samples + 1)
    solution = linkages.simulate(
        mechanism_of(row), times=np.concatenate([[0.0], times]), rtol=1e-8,
        outputs=["clearance_indentation", "clearance_indentation_rate", "clearance_force"],
        events={"gap.indentation=0": "up"},
    )  # fmt: skip
    data = solution.data.isel(time=slice(1, None))
    depth, force = (data[f"clearance_{key}"][:, 0].to_numpy() for key in ("indentation", "force"))
    touched = solution.events["gap.indentation=0"]
    touched = touched.isel(time=touched.time.to_numpy() > TRANSIENT * PERIOD)
    found = {
        "touches_per_revolution": len(touched.time) / REVOLUTIONS,
        "share_free": np.mean(depth < 0),
        "share_contact": np.mean(force > 0),
        "share_slack": np.mean((depth >= 0) & (force == 0)),
    }
    if len(touched.time):
        found["mean_touch_rate_m_per_s"] = float(touched.clearance_indentation_rate.mean())
    for key, value in found.items():
        wanted, allowed = combined(row, key, REVOLUTIONS, SHARES)
        assert abs(value - wanted) <= allowed + 1e-3, (key, value, wanted, allowed)


@pytest.mark.long
@pytest.mark.parametrize("row", ROWS, ids=identity)
def test_largest_exponent(row):
    found = linkages.lyapunov(mechanism_of(row), periods=REVOLUTIONS, skip=TRANSIENT, count=1)
    exponent = float(found.exponent.max()) * PERIOD
    wanted, allowed = combined(row, "largest_exponent_per_revolution", REVOLUTIONS, EXPONENTS)
    within = 0.01 * abs(wanted) if "period_in_revolutions" in row else allowed + 0.03
    assert abs(exponent - wanted) <= within, (exponent, wanted)
