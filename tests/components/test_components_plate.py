import pytest
from component_reading import complaints, component

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.rigid_bodies import Plate
from linkages.errors import InputError

POINTS = {"A": (0.0, 0.0), "B": (0.4, 0.0), "E": (0.2, 0.1)}
HEAVY = Plate(name="rocker", points=POINTS, mass=2, center=(0.2, 0.03), inertia=0.01)
YAML = """
bars:
  rocker: {points: {A: [0, 0], B: [40 cm, 0], E: [0.2, 0.1]}, mass: 2, center: [0.2, 0.03],
    inertia: 0.01}
joints: {A: [0, 0]}
"""


def test_same_from_yaml_and_python():
    assert component(YAML, "bars", "rocker") == HEAVY


def test_massless_plate_needs_neither_centre_nor_inertia():
    text = "joints: {A: [0, 0]}\nbars: {rocker: {points: {A: [0, 0], B: [0.4, 0]}}}\n"
    plate = component(text, "bars", "rocker")
    assert plate == Plate(name="rocker", points={"A": (0, 0), "B": (0.4, 0)})
    assert plate.mass == 0


def test_terms():
    (body,) = HEAVY.terms()
    assert (body.name, body.kind, body.path) == ("rocker", "plate", ("bars", "rocker"))
    assert body.rotates
    assert {j: (x.value, y.value) for j, (x, y) in body.points.items()} == POINTS
    assert body.points["E"][1].path == ("bars", "rocker", "points", "E", 1)
    assert body.points["A"][0].absent
    assert (body.mass.value, body.inertia.value) == (2, 0.01)
    assert [c.value for c in body.centre] == [0.2, 0.03]


def test_one_pin_gets_the_centre_as_a_second_point():
    """Two points carry the mass of a body; a plate may hang on a single pin."""
    (body,) = Plate(
        name="disc", points={"O": (0, 0)}, mass=1, center=(0.1, 0.2), inertia=0.1
    ).terms()
    assert [*body.points] == ["O", "disc.center"]
    assert body.points["disc.center"] == body.centre


def test_one_pin_at_the_centre_stays_one_point():
    (body,) = Plate(name="disc", points={"O": (0, 0)}, mass=1, center=(0, 0), inertia=0.1).terms()
    assert [*body.points] == ["O"]


def test_nothing_is_assumed_about_a_mass():
    text = """
joints: {A: [0, 0]}
bars:
  rocker: {points: {A: [0, 0], B: [0.4, 0]}, mass: 2}
"""
    assert complaints(text) == [
        f"line 4, column 3, bars.rocker: missing key '{key}': a plate with a mass needs it, "
        "nothing can be assumed"
        for key in ("center", "inertia")
    ]


def test_pins_apart():
    text = """
joints: {A: [0, 0]}
bars:
  rocker:
    points:
      A: [1 cm, 0]
      B: [0.4, 0]
      E: [0.01, 0]
"""
    assert complaints(text) == [
        "line 8, column 7, bars.rocker.points.E: 'E' lies on 'A'; expected two places"
    ]


def test_no_pin_at_all():
    (problem,) = complaints("joints: {A: [0, 0]}\nbars:\n  rocker: {points: {}}\n")
    assert problem == (
        "line 3, column 12, bars.rocker.points: expected at least one point, found none"
    )


def test_problems_without_a_file_name_their_place():
    with pytest.raises(InputError) as caught:
        Mechanism(components=(Plate(name="p", points={}),), source="script")
    assert str(caught.value) == (
        "script: 1 problem\n  bars.p.points: expected at least one point, found none"
    )
