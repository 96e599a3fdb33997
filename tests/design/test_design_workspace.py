"""Workspaces of arms and five-bars, whose singular curves are circles and a coupler curve."""

import numpy as np
import pytest

import linkages
from linkages.errors import InputError

ARM = """
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 0.4}, fore: {joints: [A, P], length: 0.3}}
DRIVES
"""
FORWARDS = ARM.replace(
    "DRIVES", "drives: {upper: {angle: 0.1, speed: 1}, fore: {angle: 1.2, speed: 2}}"
)
BACKWARDS = ARM.replace(
    "DRIVES",
    "drives: {P: {x: 0.5, y: 0.2}}\n"
    "actuators: {shoulder: {bar: upper}, elbow: {bars: [upper, fore]}}\nassembly: {A: left}",
)
SHORT = {"bars.arm1.length": 0.45, "bars.arm2.length": 0.45}
"""Of the shipped five-bar: arms that the cranks can stretch."""


POINT = """
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  crank1: {joints: [O, A], length: 0.2}
  arm1: {joints: [A, B], length: 0.45}
  arm2: {joints: [C, B], length: 0.45}
  crank2: {joints: [D, C], length: 0.2}
drives: {B: {x: 0.3, y: 0.4}}
actuators: {left: {bar: crank1}, right: {bar: crank2}}
assembly: {A: left, C: right}
"""
"""The same, moved at the point where the arms meet."""


def curves(data, kind):
    """Places of all curves of a kind, and driven coordinates, (points, 2) each."""
    chosen = data.isel(node=np.flatnonzero(data.kind.values == kind))
    return np.stack([chosen.curve_x, chosen.curve_y], axis=1), chosen.curve_drive.values


def radius(places, centre=(0.0, 0.0)):
    return np.hypot(*(places - centre).T)


@pytest.mark.parametrize("text", [FORWARDS, BACKWARDS], ids=["bars", "point"])
def test_an_arm_ends_at_circles_of_the_sum_and_the_difference(text):
    data = linkages.workspace(linkages.loads(text), samples=61)
    assert data.attrs["point"] == "P"
    assert {*data.kind.values} == {"inverse"}
    places, _ = curves(data, "inverse")
    far = radius(places) > 0.4
    assert far.any()
    assert not far.all()
    # bisected to round-off
    assert np.abs(radius(places)[far] - 0.7).max() < 1e-15
    assert np.abs(radius(places)[~far] - 0.1).max() < 1e-15
    # all around
    angles = np.sort(np.arctan2(places[far, 1], places[far, 0]))
    assert np.diff(angles).max() < 0.2
    reached = np.hypot(data.x, data.y).values
    assert np.nanmin(reached) >= 0.1 - 1e-15
    assert np.nanmax(reached) <= 0.7 + 1e-15


def test_a_five_bar_ends_where_a_leg_is_straight():
    """Circles of the sum and the difference about the pivot of each leg: inverse singularities."""
    data = linkages.workspace(linkages.load("five-bar"), "B", samples=61)
    assert {*data.kind.values} == {"inverse"}  # its arms are too long to be stretched
    places, _ = curves(data, "inverse")
    radii = [radius(places), radius(places, (0.6, 0.0))]
    apart = np.abs([r - end for r in radii for end in (0.4, 0.8)])
    assert apart.min(axis=0).max() < 1e-15
    assert {*np.argmin(apart, axis=0)} == {0, 1, 2, 3}


@pytest.mark.parametrize("point", [False, True], ids=["cranks", "point"])
def test_a_five_bar_cannot_be_held_where_its_arms_are_in_line(point):
    """Then A, B and C are those of a four-bar with a coupler of 0.9 m, and B is its middle.

    It is drawn by the driven cranks, or found from the place of B and the angles of the cranks.
    """
    made = linkages.loads(POINT) if point else linkages.load("five-bar", set=SHORT)
    data = linkages.workspace(made, "B", samples=121)
    places, drives = curves(data, "forward")
    assert len(places) > 100
    if not point:
        ends = [
            np.array([o + 0.2 * np.cos(q), 0.2 * np.sin(q)]).T
            for o, q in zip((0.0, 0.6), drives.T, strict=True)
        ]
        assert np.abs(np.hypot(*(ends[0] - ends[1]).T) - 0.9).max() < 1e-15
        # branches meet like ±√x: their mean at x = 1e-9 of a cell
        assert np.abs(places - 0.5 * (ends[0] + ends[1])).max() < 1e-9
    # the coupler curve of the four-bar: B in the middle of a rod of 0.9 m from circle to circle
    distance = np.hypot(places[:, 0], places[:, 1])
    for k, (x, y) in enumerate(places):
        # A at 0.2 m from O and 0.45 m from B, two places; C is as far on the other side of B
        cosine = np.clip((0.2**2 + distance[k] ** 2 - 0.45**2) / (0.4 * distance[k]), -1.0, 1.0)
        turns = np.arctan2(y, x) + np.arccos(cosine) * np.array([1.0, -1.0])
        far = 2 * np.array([[x], [y]]) - 0.2 * np.array([np.cos(turns), np.sin(turns)])
        missed = np.abs(np.hypot(far[0] - 0.6, far[1]) - 0.2)
        # near a fold of the angle an error of 1e-12 is one of 1e-6
        assert missed.min() < 3e-6


@pytest.mark.parametrize(
    ("text", "ranges"),
    [
        (FORWARDS, {"upper": (0.0, np.pi / 2), "fore": (-1.0, 0.5)}),
        (BACKWARDS, ["shoulder=0:90 deg", "elbow=-120 deg:-0.5"]),
    ],
    ids=["bars", "actuators"],
)
def test_ranges_end_it(text, ranges):
    data = linkages.workspace(linkages.loads(text), ranges=ranges, samples=81, own=True)
    places, _ = curves(data, "limit")
    assert len(places) > 100
    x, y = places.T
    if text is BACKWARDS:
        cosine = (x * x + y * y - 0.25) / 0.24
        elbow = -np.arccos(cosine)
        shoulder = np.arctan2(y, x) - np.arctan2(0.3 * np.sin(elbow), 0.4 + 0.3 * np.cos(elbow))
        ends = [shoulder, shoulder - np.pi / 2, elbow + np.radians(120), elbow + 0.5]
        assert np.abs(ends).min(axis=0).max() < 1e-13
        assert data.x.notnull().any()
        inside = (shoulder > -1e-12) & (shoulder < np.pi / 2 + 1e-12)
        assert inside.all()
        assert ((elbow > -np.radians(120) - 1e-12) & (elbow < -0.5 + 1e-12)).all()
    else:
        arms = [(x - 0.4 * c) ** 2 + (y - 0.4 * s) ** 2 for c, s in ((1.0, 0.0), (0.0, 1.0))]
        shifted = [(x - 0.3 * np.cos(q)) ** 2 + (y - 0.3 * np.sin(q)) ** 2 for q in (-1.0, 0.5)]
        off = [
            *(np.abs(np.sqrt(a) - 0.3) for a in arms),
            *(np.abs(np.sqrt(a) - 0.4) for a in shifted),
        ]
        assert np.min(off, axis=0).max() < 1e-15


def test_two_of_three_drives_move():
    """The hand stands still: the arm's circles, shifted by it."""
    hand = "W], length: 0.3}, hand: {joints: [W, P], length: 0.1}"
    text = FORWARDS.replace("P], length: 0.3}", hand)
    made = linkages.loads(text.replace("speed: 2}", "speed: 2}, hand: {angle: 90 deg, speed: 3}"))
    with pytest.raises(ValueError, match="expected ranges of the two that move"):
        linkages.workspace(made)
    turns = {"upper": (-np.pi, np.pi), "fore": (-np.pi, np.pi)}
    places, _ = curves(linkages.workspace(made, ranges=turns, samples=61), "inverse")
    radii = radius(places, (0.0, 0.1))
    assert np.minimum(np.abs(radii - 0.7), np.abs(radii - 0.1)).max() < 1e-15


@pytest.mark.parametrize(
    ("name", "options", "found"),
    [
        ("five-bar", {}, "expected a point, one of A, B or C"),
        ("five-bar", {"point": "X"}, "unknown point 'X'"),
        ("five-bar", {"point": "B", "samples": 3}, "samples must be at least 5, found 3"),
        (
            "five-bar",
            {"point": "B", "ranges": ["crank3=0:1"]},
            "unknown drive or actuator 'crank3'",
        ),
        ("five-bar", {"point": "B", "ranges": ["crank1=1"]}, "expected a range such as"),
        ("five-bar", {"point": "B", "ranges": ["crank1=1:0"]}, "expected increasing ends"),
        ("five-bar", {"point": "B", "ranges": ["crank1=0:1 m"]}, "expected an angle"),
    ],
)
def test_bad_requests(name, options, found):
    with pytest.raises(ValueError, match=found):
        linkages.workspace(linkages.load(name), **options)


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("slider-crank", "found that nothing is free and crank is driven"),
        ("double-pendulum", "is free and nothing is driven"),
    ],
)
def test_mechanisms_without_two_drives_are_refused(name, found):
    with pytest.raises(InputError, match="workspace is that of two drives"):
        linkages.workspace(linkages.load(name), "B")
    assert found


CART = """
joints: {O: [0, 0]}
sliders: {cart: {joint: S, through: O}}
bars: {arm: {joints: [S, P], length: 0.3}}
drives: {P: {x: 0.1, y: 0.2}}
actuators: {rail: {slider: cart}, swing: {bar: arm}}
assembly: {S: [-0.1, 0]}
"""


def test_sliders_go_anywhere_within_ranges():
    """An arm on a cart reaches a strip as high as the arm is long, and no farther than asked."""
    made = linkages.loads(CART)
    with pytest.raises(ValueError, match=r"expected ranges of P\.x and P\.y"):
        linkages.workspace(made)
    asked = {"P.x": (-0.5, 0.7), "P.y": (-1.0, 1.0)}
    data = linkages.workspace(made, ranges=asked, samples=61)
    strip, _ = curves(data, "inverse")
    assert np.abs(np.abs(strip[:, 1]) - 0.3).max() < 1e-15
    ends, _ = curves(data, "limit")
    assert {*np.unique(np.round(ends[:, 0], 12))} == {-0.5, 0.7}
    assert np.abs(ends[:, 1]).max() <= 0.3
    short = linkages.workspace(made, ranges={**asked, "rail": (0.0, 0.2)}, samples=61, own=True)
    x, y = curves(short, "limit")[0].T
    cart = x - np.sqrt(np.clip(0.09 - y * y, 0.0, None))
    assert np.minimum(np.abs(cart), np.abs(cart - 0.2)).max() < 1e-12


def test_a_range_of_what_does_not_move_is_refused():
    text = FORWARDS.replace("drives:", "actuators: {a: {bar: upper}, b: {bar: fore}}\ndrives:")
    with pytest.raises(ValueError, match="a has a range, and does not move P here"):
        linkages.workspace(linkages.loads(text), ranges=["a=0:1"])
