"""Points over a phase that is known: smooth curves, their branches, and what is none."""

import numpy as np
import pytest

from linkages.chaos.tori import phase_curve

GOLDEN = (5**0.5 - 1) / 2
TURNS = GOLDEN * np.arange(300)


def shape(turns: np.ndarray) -> np.ndarray:
    phase = 2 * np.pi * turns
    return np.column_stack([np.cos(phase) + 0.3 * np.sin(3 * phase), np.sin(phase - 1)])


def test_a_curve_over_the_phase():
    found = phase_curve(shape(TURNS), TURNS)
    assert (found.points, found.turns) == (1, 1)
    assert found.whole
    # sixth order: (2π · 3/300 · 3)⁶/6! times a binomial coefficient
    assert found.error < 1e-4


@pytest.mark.parametrize(("points", "turns"), [(2, 1), (1, 2), (3, 1), (1, 4)])
def test_branches(points, turns):
    """The sign changes from point to point, or the curve closes after so many turns."""
    branch = (np.arange(300) % points)[:, None]
    found = phase_curve(shape(TURNS / turns) + branch, TURNS)
    assert (found.points, found.turns) == (points, turns)


def test_phases_that_come_back():
    """After 100 points, to round-off."""
    turns = np.arange(300) * 0.37
    assert phase_curve(shape(turns), turns).smooth
    different = shape(turns) + (np.arange(300) > 150)[:, None]
    assert not phase_curve(different, turns).smooth


def test_few_phases_show_no_curve():
    found = phase_curve(shape(1e-4 * np.arange(300)), 1e-4 * np.arange(300))
    assert not found.smooth
    assert found.covered == pytest.approx(0.03, abs=0.001)


def test_a_strange_nonchaotic_attractor_is_no_curve():
    """x → 3 tanh x cos 2πθ: C. Grebogi, E. Ott, S. Pelikan, J. A. Yorke, Physica D 13 (1984) 261.

    The exponent is negative, and every neighbourhood of a phase has points of the whole range.
    """
    x, points = 0.5, []
    for turn in GOLDEN * np.arange(3000):
        points.append(x)
        x = 3 * np.tanh(x) * np.cos(2 * np.pi * turn)
    for count in (300, 2000):
        found = phase_curve(points[-count:], GOLDEN * np.arange(3000)[-count:])
        assert not found.smooth
        assert found.error > 0.1
