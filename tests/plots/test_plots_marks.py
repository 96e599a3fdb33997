"""Marks at equal times on paths, against the angle of a crank that turns evenly."""

import numpy as np
import pytest

import linkages
from linkages.plots.mechanism.traces import HALF, WIDTH, figure, mark_times

CRANK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.1}}
drives: {crank: {angle: 30 deg, speed: SPEED}}
simulate: {end: END, samples: 801}
"""
FREE = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, A], length: 0.1, mass: 1}}
free: {arm: {angle: 1}}
simulate: {end: 2, samples: 201}
"""


def crank(speed, end):
    return linkages.simulate(linkages.loads(CRANK.replace("SPEED", speed).replace("END", str(end))))


@pytest.mark.parametrize(
    ("speed", "end", "step", "count"),
    [
        ("60 rpm", 4, 0.05, 20),  # a turn takes 1 s
        ("60 rpm", 0.5, 0.02, 25),  # half a turn: the whole motion
        ("-300 rpm", 4, 0.01, 20),
        ("100 rpm", 4, 0.05, 12),
    ],
)
def test_marks_are_at_even_times_of_the_first_turn(speed, end, step, count):
    solution = crank(speed, end)
    times = mark_times(solution.data, solution.mechanism)
    np.testing.assert_allclose(times, step * np.arange(1, count + 1), rtol=1e-12)


def test_a_motion_without_a_drive_is_marked_all_along():
    solution = linkages.simulate(linkages.loads(FREE))
    times = mark_times(solution.data, solution.mechanism)
    np.testing.assert_allclose(times, 0.1 * np.arange(1, 21), rtol=1e-12)


def test_marks_are_where_the_joint_is_across_its_path_and_their_distance_is_written():
    solution = crank("60 rpm", 4)
    (ax,) = figure(solution.data, solution.mechanism).axes
    (line,) = (line for line in ax.lines if line.get_linewidth() == WIDTH)
    ends = line.get_xydata().reshape(-1, 3, 2)[:, :2]
    angles = np.radians(30) + 2 * np.pi * 0.05 * np.arange(1, 21)
    along = np.column_stack((np.cos(angles), np.sin(angles)))
    # chords of 1/200 turn are 100 mm · (1 − cos 0.9°) inside the circle at most
    np.testing.assert_allclose(ends.mean(axis=1), 100 * along, atol=100 * (1 - np.cos(0.0158)))
    across = ends[:, 1] - ends[:, 0]
    width = ax.get_window_extent().width / np.ptp(ax.get_xlim()) / ax.figure.dpi * 72
    np.testing.assert_allclose(np.hypot(*across.T) * width, 2 * HALF, rtol=1e-9)
    turned = np.abs((across * along).sum(axis=1)) / np.hypot(*across.T)
    assert turned.min() > np.cos(0.0158)  # radial, but for the direction of a chord
    (note,) = (text for text in ax.texts if text.get_gid() == "marks")
    assert note.get_text() == "marks every 50 ms"
