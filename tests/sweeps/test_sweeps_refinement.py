"""Grids that are computed where neighbours differ, against the whole grid."""

import numpy as np
import pytest

from linkages.sweeps.refinement import refined


def regions(shape):
    """A disc, a small one beside it, and a half-plane."""
    y, x = np.mgrid[: shape[0], : shape[1]]
    disc = (np.hypot(x - 40, y - 50) < 30) + 2 * (np.hypot(x - 60, y - 30) < 9)
    return (disc + 4 * (x + y > 150)).astype(int)


def computed(truth, step):
    seen = []

    def labels(places):
        seen.append(places)
        return truth.ravel()[places].tolist()

    return refined(truth.shape, step, labels), np.concatenate(seen)


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (50, 1), (2, 2), (100, 100), (97, 61)])
@pytest.mark.parametrize("step", [1, 2, 8, 16])
def test_every_point_has_its_label(shape, step):
    truth = regions(shape)
    source, seen = computed(truth, step)
    assert (truth.ravel()[source] == truth.ravel()).all()
    assert len(seen) == len(set(seen.tolist()))  # none is computed twice
    assert set(seen.tolist()) == set(source.tolist())
    assert (source[seen] == seen).all()
    assert step > 1 or len(seen) == truth.size


def test_only_borders_are_computed():
    """A line across the grid: its neighbours on either side, and the coarse grid."""
    truth = (np.add.outer(np.arange(257), np.arange(257)) > 250).astype(int)
    source, seen = computed(truth, 16)
    assert (truth.ravel()[source] == truth.ravel()).all()
    assert len(seen) < 0.08 * truth.size


def test_borders_are_followed_through_coarse_cells():
    """A peninsula that lies between coarse points, but for its root."""
    truth = np.zeros((65, 65), dtype=int)
    truth[20:23, 5:] = 1
    truth[:, 60:] = 1
    source, _ = computed(truth, 16)
    assert (truth.ravel()[source] == truth.ravel()).all()


def test_what_touches_no_corner_is_missed():
    """As the docstring says: the price of a coarse grid."""
    truth = np.zeros((65, 65), dtype=int)
    truth[20:23, 20:23] = 1
    source, seen = computed(truth, 16)
    assert (truth.ravel()[source] == 0).all()
    assert len(seen) == 25
