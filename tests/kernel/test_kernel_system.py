"""Initial states, and the choice of free coordinates that a file does not name."""

from itertools import pairwise

import numpy as np
import pytest
from kernel_motion import places_at
from linkage_models import NAMES, refusal, system, system_of, values

PENDULUM = """
joints: {O: [0.1, 0.2]}
bars: {rod: {joints: [O, P], length: 0.5, mass: 2}}
"""
FOUR_BAR = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  coupler: {joints: [A, B], length: 0.9, mass: 1}
  rocker: {joints: [C, B], length: 0.7, mass: 1}
"""


@pytest.mark.parametrize("direction", [0.0, 1.0, -2.5, 3.0])
def test_a_pendulum_starts_where_its_end_is(direction):
    x, y = 0.1 + 3 * np.cos(direction), 0.2 + 3 * np.sin(direction)
    of = system_of(PENDULUM + f"assembly: {{P: [{x}, {y}]}}")
    assert of.chosen == ("rod",)
    assert of.state == pytest.approx([direction, 0.0], abs=4e-15)  # an arctangent of differences
    place = [0.1 + 0.5 * np.cos(direction), 0.2 + 0.5 * np.sin(direction)]
    assert of.places()["P"] == pytest.approx(place, abs=1e-15)


def test_the_angle_of_a_plate_is_that_of_its_frame():
    of = system_of("""
joints: {O: [0, 0]}
bars: {plate: {points: {O: [0.1, 0.1], P: [0.1, 0.6]}, mass: 1, center: [0, 0], inertia: 1}}
assembly: {P: [1, 0]}
""")
    assert of.state == pytest.approx([-np.pi / 2, 0], abs=1e-15)
    assert of.places()["P"] == pytest.approx([0.5, 0], abs=1e-15)


def test_what_is_named_is_not_chosen():
    of = system_of(PENDULUM + "free: {rod: {angle: 2, speed: 3}}\nassembly: {P: [1, 0]}")
    assert of.chosen == ()
    assert of.state.tolist() == [2, 3]


TRAPEZOID = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  FIRST
  SECOND
  top: {joints: [A, B], length: 0.6, mass: 1}
assembly: {A: [0.2, 0.98], B: [0.8, 0.98]}
"""
LEFT = "left: {joints: [O, A], length: 1, mass: 1}"
RIGHT = "right: {joints: [C, B], length: 1, mass: 1}"


@pytest.mark.parametrize(("first", "second"), [(LEFT, RIGHT), (RIGHT, LEFT)])
def test_of_bars_that_are_as_good_the_first_is_chosen(first, second):
    """Conditions of mirror images differ by round-off, which must not choose."""
    of = system_of(TRAPEZOID.replace("FIRST", first).replace("SECOND", second))
    assert of.chosen == (first.split(":")[0],)


def test_a_driven_bar_is_not_chosen_although_its_place_is_known():
    of = system_of("""
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.4, mass: 1}
  one: {joints: [A, B], length: 0.6, mass: 1}
  two: {joints: [B, D], length: 0.6, mass: 1}
  rocker: {joints: [C, D], length: 0.4, mass: 1}
drives: {crank: {angle: 1.6, speed: 0}}
assembly: {A: [0, 0.4], D: [1, 0.4], B: left}
""")
    assert of.chosen == ("rocker",)


def test_the_best_conditioned_bar_is_chosen():
    """Coupler and rocker in line make the rocker's angle a bad coordinate, and vice versa."""
    crank, folded = 0.3 * np.exp(0.6j), 1 + 0.7 * np.exp(2.9j)
    hints = "assembly: {{A: [{}, {}], B: [{}, {}]}}"

    def chosen(text):
        return system_of(text).chosen

    # A at 0.6 rad: links meet at about 40°; consistent places of both joints
    of = system_of(FOUR_BAR + "drives: {crank: {angle: 0.6, speed: 0}}\nassembly: {B: left}")
    a, b = of.places()["A"], of.places()["B"]
    of = system_of(FOUR_BAR + hints.format(*a, *b))
    conditions = {}
    for bar, place, pin in (("crank", a, [0, 0]), ("rocker", b, [1, 0])):
        angle = np.arctan2(*(place - pin)[::-1])
        free = f"free: {{{bar}: {{angle: {angle}}}}}\n"
        conditions[bar] = max(system_of(FOUR_BAR + free + hints.format(*a, *b)).conditions)
    assert of.chosen == (min(conditions, key=conditions.get),)
    assert of.conditions == [min(conditions.values())]
    assert of.places()["B"] == pytest.approx(b, abs=1e-14)
    assert chosen(FOUR_BAR + hints.format(crank.real, crank.imag, folded.real, folded.imag))


def test_only_bars_with_a_known_place_can_be_chosen():
    of = system_of(FOUR_BAR + "assembly: {A: [0.1, 0.3], B: left}")
    assert of.chosen == ("crank",)


def test_nothing_to_choose_from():
    assert refusal(FOUR_BAR + "assembly: {B: left}") == (
        "line 1, column 1: mobility is 1, but 0 coordinates are driven and 0 free; expected as "
        "many as the mobility: add a drive, or name a bar under 'free' with its initial angle"
    )


def test_a_choice_that_cannot_be_assembled_says_why():
    assert "joint B can be in two places" in refusal(FOUR_BAR + "assembly: {A: [0.1, 0.3]}")


@pytest.mark.parametrize("bar", ["crank", "coupler"])
def test_clearances_are_always_free(bar):
    of = system_of(
        FOUR_BAR + f"clearances: {{r1: {{joint: A, bar: {bar}, size: 1 mm, angle: 1, speed: 2}}}}\n"
        "assembly: {A: [0.1, 0.3], B: left}"
    )
    assert of.topology.free == ("crank", "r1")
    assert of.chosen == ("crank",)
    assert of.state == pytest.approx([np.arctan2(0.3, 0.1), 1, 0, 2], abs=1e-15)


def test_initial_state_in_the_order_of_the_bodies():
    of = system("clearance")
    assert of.topology.free == ("crank", "gap")
    assert of.state.tolist() == [1, 0.4, 2, -0.3]


@pytest.mark.parametrize("name", NAMES)
def test_every_linkage_closes(name):
    of = system(name)
    times = np.linspace(0, 0.5, 11)
    residual = values(of, "closure_residual", times)
    # a handful of roundings of lengths around 1 m, through cosines of arctangents
    assert np.abs(residual).max(initial=0) < 2e-15


@pytest.mark.parametrize("name", NAMES)
def test_lengths_stay_what_they_are(name):
    of = system(name)
    for time in (0.0, 0.2):
        places = places_at(of, time)
        for body in of.mechanism.bodies.values():
            points = [*body.points.items()]
            for (joint, frame), (other, reference) in pairwise(points):
                expected = np.hypot(
                    *(a.value - b.value for a, b in zip(frame, reference, strict=True))
                )
                found = np.linalg.norm(places[joint] - places[other])
                assert found == pytest.approx(expected, abs=5e-15)  # roundings of places


def test_evaluating_many_states_at_once():
    of = system("clearance")
    random = np.random.default_rng(0)
    states = of.state[:, None] + 0.1 * random.normal(size=(4, 6))
    nodes = of.model.free_accelerations
    together = of.evaluate(nodes, np.zeros(6), states)
    assert together.shape == (2, 6)
    one_by_one = np.array([of.evaluate(nodes, 0.0, s[:, None])[:, 0] for s in states.T]).T
    # NumPy's vectorised sines may differ from its scalar ones in the last digit
    assert np.allclose(together, one_by_one, rtol=1e-11, atol=0)
