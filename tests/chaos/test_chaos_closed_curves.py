"""Closed curves of quasi-periodic motions, and what is none."""

import numpy as np
import pytest
from chaos_systems import henon, orbit
from make.verdicts.own_systems import Map

from linkages.chaos.tori import closed_curves

GOLDEN = (np.sqrt(5) - 1) / 2


def standard_map(strength, angle, momentum, count):
    """Chirikov's map, which has everything: points (angle, momentum)."""
    points = np.empty((count, 2))
    for n in range(count):
        momentum = momentum + strength * np.sin(angle)
        angle = (angle + momentum + np.pi) % (2 * np.pi) - np.pi
        points[n] = angle, momentum
    return points


@pytest.mark.parametrize("winding", [GOLDEN, np.sqrt(2) - 1, 1 / np.pi])
def test_ellipse(winding):
    phase = 2 * np.pi * winding * np.arange(600)
    points = np.column_stack([0.001 * np.cos(phase), 50 * np.sin(phase) + 10 * np.cos(2 * phase)])
    found = closed_curves(points)
    assert found.count == 1, found.reason


def test_curve_around_an_angle():
    found = closed_curves(standard_map(0.5, 0.0, 2 * np.pi * GOLDEN, 800), angles=[True, False])
    assert found.count == 1, found.reason


def test_islands_are_counted():
    """Around the period-two orbit (0, π), (π, π) of the standard map."""
    points = standard_map(1.3, 0.0, np.pi + 0.15, 1200)
    found = closed_curves(np.mod(points, 2 * np.pi), angles=[True, True])
    assert found.count == 2, found.reason


def test_order_of_neighbours_matters():
    """A doubled circle is closed too, but its motion is chaos: x → 2x."""
    circle = Map(lambda x: 2 * x + 1e-9, lambda _: [[2.0]], [0.2], angles=[True])
    found = closed_curves(orbit(circle, 800, 1), angles=[True])
    assert found.count == 0
    assert "order" in found.reason


@pytest.mark.parametrize("seed", range(3))
def test_scatter_is_no_curve(seed):
    points = np.random.default_rng(seed).normal(size=(800, 2))
    assert "branch" in closed_curves(points).reason


def test_chaotic_sea_is_no_curve():
    points = standard_map(5.0, 0.3, 0.2, 1000)
    assert closed_curves(np.mod(points, 2 * np.pi), angles=[True, True]).count == 0


@pytest.mark.slow
def test_henon_attractor_is_no_curve():
    assert closed_curves(orbit(henon(), 1500, 1, 100)).count == 0


def test_arc_is_not_closed():
    phase = np.pi * np.random.default_rng(0).uniform(size=400)
    found = closed_curves(np.column_stack([np.cos(phase), np.sin(phase)]))
    assert found.count == 0
    assert "ends" in found.reason


def test_periodic_points():
    assert "periodic" in closed_curves(np.tile([1.0, 2.0, 4.0], 100)).reason
    with pytest.raises(ValueError, match="at least 60"):
        closed_curves(np.zeros(59))
