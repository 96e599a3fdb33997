"""A periodic motion in following contact: it attracts, and how fast, to the digits stated."""

import numpy as np
import pytest
from contact_references import content

import linkages

FILE = content("8-periodic-following-contact")
PERIOD = 0.012
LIMIT = np.array([float(value) for value in FILE["limit_point"]])
OUTPUTS = ["clearance_offset", "clearance_offset_rate", "clearance_force"]


def mechanism(**values):
    found = linkages.loads(FILE["definition_in_words_of_a_file"])
    return found.with_values({f"clearances.gap.{key}": value for key, value in values.items()})


def section(found, revolutions, rtol=1e-11):
    """Offset, rate and force at crank angle 0, shape (revolutions, 5)."""
    times = PERIOD * np.arange(revolutions + 1)
    data = linkages.simulate(found, times=times, rtol=rtol, outputs=OUTPUTS).data
    parts = [data[name].to_numpy().reshape(len(times), -1) for name in OUTPUTS]
    return np.concatenate(parts, axis=1)[1:]


def check(points, expected, relative):
    size = np.abs(np.repeat([expected[:2], expected[2:4]], 2, axis=0)).max(axis=1)
    scale = np.array([*size[[0, 0]], *size[[2, 2]], abs(expected[4])])
    off = np.abs(points - expected) / scale
    assert (off < relative).all(), off


def test_points_on_the_way_to_the_limit():
    """From the ideal position with impacts on the way, 15 digits in the reference."""
    rows = FILE["section_points"]["after_revolution"].values()
    found = section(mechanism(), 9)
    for point, row in zip(found, rows, strict=True):
        check(point, np.array([float(value) for value in row]), 1e-9)


@pytest.mark.parametrize("share", [-0.9, 0.5, 0.99])
def test_every_start_ends_there(share):
    found = section(mechanism(offset=[share * 5e-5, 0.0]), 12)
    check(found[-1], LIMIT, 1e-10)


def test_multipliers_of_the_period():
    """Eigenvalues of the tangents over a revolution from the limit point, 12 digits stated."""
    rhs = linkages.compile(mechanism())
    names = ("gap.x.position", "gap.y.position", "gap.x.velocity", "gap.y.velocity")
    assert rhs.names == names
    found = rhs.flow(tangents=4, rtol=1e-12).advance(LIMIT[:4], 0.0, PERIOD, np.eye(4))
    sizes = np.sort(np.abs(np.linalg.eigvals(np.asarray(found.tangents))))[::-1]
    expected = [float(value) for value in FILE["multipliers_of_the_period"]]
    assert sizes[:2] == pytest.approx(expected, rel=1e-6)


def test_exponent():
    """By tangents over thirty revolutions; neighbouring motions miss it by 2 to 20 %."""
    found = linkages.lyapunov(mechanism(), periods=40, skip=10)
    exponent = float(found.exponent.max()) * PERIOD
    assert exponent == pytest.approx(float(FILE["exponent_per_revolution"]), abs=1e-5)
