"""Closed forms of one impact, against tables, and against the motion of one free mass."""

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
from scipy.integrate import solve_ivp

MASS, SPEED, STIFFNESS = 0.25, 0.1, 1e9
ROWS = content("1-one-impact")["rows"]
# Lankarani & Nikravesh's own law at 0.5 bounces with 0.73, and so on: three digits as tabulated.
REACHED = {
    "hunt-crossley": (0.909, 0.768, 0.663, 0.581),
    "herbert-mcwhannell": (0.901, 0.723, 0.594, 0.520),
    "lee-wang": (0.952, 0.869, 0.799, 0.739),
    "lankarani-nikravesh": (0.913, 0.796, 0.725, 0.684),
    "gonthier": (0.876, 0.670, 0.488, 0.304),
    "zhiying-qishao": (0.896, 0.680, 0.483, 0.327),
    "flores": (0.894, 0.683, 0.470, 0.256),
    "hu-guo": (0.900, 0.697, 0.488, 0.271),
    "carvalho-martins": (0.900, 0.700, 0.500, 0.304),
    "safaeifar-farshidianfar": (0.915, 0.735, 0.536, 0.314),
    "exact": (0.900, 0.700, 0.500, 0.300),
}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"{row['law']}-{row['restitution']}")
def test_tabulated_impacts(row):
    """14 digits in the table; quadrature and bisection keep 13 of double precision."""
    law, wanted = row["law"], float(row["restitution"])
    chi = 0.0 if law == "hertz" else DAMPING_FACTORS[law](wanted)
    assert chi == pytest.approx(float(row["damping_factor"]), rel=1e-14)
    assert reached(chi) == pytest.approx(float(row["restitution_reached"]), rel=2e-14)
    about = chi, MASS, SPEED, STIFFNESS
    assert largest_indentation(*about) == pytest.approx(
        float(row["largest_indentation"]), rel=1e-14
    )
    assert duration(*about) == pytest.approx(float(row["duration"]), rel=1e-13)
    assert halves(*about)[0] == pytest.approx(float(row["compression_time"]), rel=1e-13)


@pytest.mark.parametrize("law", DAMPING_FACTORS)
def test_restitution_of_every_law(law):
    found = [reached(DAMPING_FACTORS[law](wanted)) for wanted in (0.9, 0.7, 0.5, 0.3)]
    assert found == pytest.approx(REACHED[law], abs=5.1e-4)


def test_undamped_impacts():
    """Two forms of the same: the beta function, and the quadrature that damped impacts take."""
    for exponent in (1.0, 1.5, 2.2):
        about = MASS, SPEED, STIFFNESS, exponent
        assert duration(0.0, *about) == pytest.approx(undamped_duration(*about), rel=1e-13)
    # A linear spring: half a period of the oscillator.
    half = np.pi * np.sqrt(MASS / STIFFNESS)
    assert undamped_duration(MASS, SPEED, STIFFNESS, 1.0) == pytest.approx(half, rel=1e-14)


@pytest.mark.slow_except("*-1.5")
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
@pytest.mark.parametrize("chi", [0.0, 0.1425, 1.6, 8.0])
def test_motion_of_a_free_mass(chi, exponent):
    """m d″ = −K dᵖ (1 + χ d′/v) in the units in which m, K and v are 1.

    DOP853 at 1e-13; the event is found on an interpolant of order 7.
    """

    def rates(_, state):
        depth, rate = max(state[0], 0.0), state[1]
        return rate, -(depth**exponent) * (1 + chi * rate)

    def gone(_, state):
        return state[0]

    gone.direction, gone.terminal = -1, True
    found = solve_ivp(
        rates, (0, 100), [0.0, 1.0], "DOP853", rtol=1e-13, atol=1e-15, first_step=1e-6,
        max_step=0.01, events=[gone, lambda _, state: state[1]],
    )  # fmt: skip
    about = chi, 1.0, 1.0, 1.0, exponent
    assert -found.y[1, -1] == pytest.approx(reached(chi), rel=1e-10)
    assert found.t[-1] == pytest.approx(duration(*about), rel=1e-10)
    assert found.y_events[1][0][0] == pytest.approx(largest_indentation(*about), rel=1e-11)
