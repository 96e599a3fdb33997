"""Tangents of a motion against differences of motions of their own."""

import numpy as np

import linkages
from linkages.kernel.system import System

STEP = 3e-5
LIMIT = 1e-6
"""In parts of the largest entry, coordinates in sizes of the clearance: differences are taken over
3e-5 of a size, extrapolated, of motions that are right to 1e-11 of one."""


def differences(text, end, size):
    """Tangents and slopes of motions, all in sizes and hundreds of them per second."""
    mechanism = linkages.loads(text)
    rhs = linkages.compile(mechanism)
    count, start = len(rhs.names), np.asarray(System(mechanism).state)
    scale = np.repeat([size, 100 * size], count // 2)
    found = rhs.flow(tangents=count, rtol=1e-12).advance(start, 0.0, end, np.eye(count))
    flow = rhs.flow(rtol=1e-13)

    def slope(column, step):
        there = [
            flow.advance(start + sign * step * scale[column] * np.eye(count)[column], 0.0, end).y
            for sign in (1, -1)
        ]
        return (np.asarray(there[0]) - there[1]) / (2 * step)

    slopes = [(4 * slope(k, STEP / 2) - slope(k, STEP)) / 3 for k in range(count)]
    expected = np.array(slopes).T / scale[:, None]
    tangents = np.asarray(found.tangents) * scale / scale[:, None]
    return tangents, expected


def check(text, end, size):
    tangents, expected = differences(text, end, size)
    assert np.abs(tangents - expected).max() < LIMIT * np.abs(expected).max()
