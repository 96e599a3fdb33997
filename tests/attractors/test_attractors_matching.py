"""Matching of attractors by distance, and their numbers."""

import numpy as np
import pytest
from scipy.spatial.distance import directed_hausdorff

from linkages.attractors.matching import clustered, farthest, linked, ordered, ranges
from linkages.attractors.settling import Kind

NO = np.zeros(2, dtype=bool)


def answers(ends, kind=Kind.PERIODIC):
    """Answers of starts from the points where they end, a list of (k, 2)."""
    most = max(map(len, ends))
    points = np.full((len(ends), most, 2), np.nan)
    for row, end in zip(points, ends, strict=True):
        row[: len(end)] = end
    count = len(ends)
    return {
        "outcome": np.zeros(count, dtype=np.int8),
        "kind": np.full(count, kind, dtype=np.int8),
        "count": np.array([*map(len, ends)]),
        "section": np.full(count, -1),
        "period": np.array([float(len(end)) for end in ends]),
        "points": points,
        "turns": np.zeros((count, 1)),
        "touches": np.zeros((count, 0)),
        "reach": np.ones((count, 2)),
        "left": np.random.default_rng(0).uniform(0, 1, count),
    }


def test_the_distance_of_sets_is_hausdorffs():
    rng = np.random.default_rng(3)
    one, others = rng.uniform(size=(4, 2)), rng.uniform(size=(20, 5, 2))
    expected = [
        # with the largest difference of any entry, which SciPy has for one entry
        max(
            directed_hausdorff(a, b)[0] for a, b in ((one[:, :1], o[:, :1]), (o[:, :1], one[:, :1]))
        )
        for o in others
    ]
    result = farthest(one[:, :1], others[:, :, :1], NO[:1], np.ones(1))
    assert result == pytest.approx(np.array(expected), abs=1e-15)


def test_angles_are_compared_modulo_turns():
    mask = np.array([True, False])
    one, other = np.array([[np.pi - 1e-4, 1.0]]), np.array([[[-np.pi + 1e-4, 1.0]]])
    assert farthest(one, other, mask, np.ones(2)) == pytest.approx([2e-4])


def scattered():
    """Ends on three cycles, two of them with points in any order, and errors of a unit."""
    rng = np.random.default_rng(5)
    cycles = [rng.uniform(-1, 1, (k, 2)) for k in (1, 3, 3)]
    which = rng.integers(3, size=60)
    ends = [
        np.roll(cycles[n], rng.integers(3), axis=0) + rng.uniform(-1e-5, 1e-5, 2) for n in which
    ]
    return which, answers(ends)


def test_ends_are_matched_whatever_the_order_of_points_and_starts():
    which, found = scattered()
    result = clustered(found, np.zeros(60, dtype=np.int64), NO, 1e-5)
    assert len(result.attractors) == 3
    for number in range(3):
        assert len(np.unique(result.labels[which == number])) == 1
    order = np.random.default_rng(9).permutation(60)
    shuffled = clustered({k: v[order] for k, v in found.items()}, np.zeros(60, dtype=int), NO, 1e-5)
    scale = ranges(found, NO)
    numbers, again = (np.argsort(ordered(r.attractors, scale)) for r in (result, shuffled))
    assert (numbers[result.labels][order] == again[shuffled.labels]).all()
    assert [len(result.attractors[n].points) for n in ordered(result.attractors, scale)] == [
        1,
        3,
        3,
    ]


def test_many_states_at_rest_are_one_family():
    """As with dry friction: a block stays wherever it stops."""
    found = answers([np.array([[x, 0.0]]) for x in np.linspace(0, 1, 50)], Kind.FIXED_POINT)
    (only,) = clustered(found, np.zeros(50, dtype=np.int64), NO, 1e-5).attractors
    assert only.family


def test_attractors_are_followed_over_a_parameter_by_distance():
    """Two that cross the order of their coordinates: never by number."""
    slopes = np.linspace(0, 1, 11)
    ends = [np.array([[s, 0.0]]) for s in slopes] + [np.array([[1 - s, 0.4]]) for s in slopes]
    found = answers(ends)
    nodes = np.tile(np.arange(11), 2)
    result = clustered(found, nodes, NO, 1e-5)
    pairs = [(n, n + 1) for n in range(10)]
    families = linked(result.attractors, pairs, NO, np.ones(2))
    labels = families[result.labels]
    assert len(set(labels[:11])) == len(set(labels[11:])) == 1
    assert labels[0] != labels[-1]


def test_sets_that_do_not_repeat_are_matched_by_their_neighbours():
    """Points of the Hénon map from two starts are one attractor; the same moved away is another."""
    ends = []
    for start in (0.1, 0.3, 0.2):
        x, y, points = start, 0.0, []
        for _ in range(200):
            x, y = 1 - 1.4 * x * x + y, 0.3 * x
            points.append((x, y))
        ends.append(np.array(points[-32:]))
    ends[2] = ends[2] + [5.0, 0.0]
    found = answers(ends, Kind.CHAOTIC)
    labels = clustered(found, np.zeros(3, dtype=np.int64), NO, 1e-5).labels
    assert labels[0] == labels[1] != labels[2]
