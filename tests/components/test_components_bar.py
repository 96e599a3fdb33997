import pytest
from component_reading import complaints, component, mechanism

from linkages.components.contributed.terms import ZERO, Parameter
from linkages.components.rigid_bodies import Bar

BARE = Bar(name="crank", joints=("O", "A"), length=0.3)


@pytest.mark.parametrize(
    ("entry", "bar"),
    [
        ("{joints: [O, A], length: 0.3}", BARE),
        (
            "{joints: [O, A], length: 30 cm, mass: 500 g, inertia: 8.39e-3, center: 10 cm}",
            Bar(name="crank", joints=("O", "A"), length=0.3, mass=0.5, inertia=8.39e-3, center=0.1),
        ),
        (
            "{joints: [O, A], length: 0.3, mass: 1, center: [0.1, -2 cm]}",
            Bar(name="crank", joints=("O", "A"), length=0.3, mass=1, center=(0.1, -0.02)),
        ),
    ],
)
def test_same_from_yaml_and_python(entry, bar):
    text = f"joints: {{O: [0, 0]}}\nbars:\n  crank: {entry}\n"
    assert component(text, "bars", "crank") == bar


def test_uniform_bar_unless_told_otherwise():
    bar = Bar(name="rod", joints=("A", "B"), length=0.6, mass=2)
    assert bar.centre == (0.3, 0.0)
    assert bar.central_inertia == 2 * 0.6**2 / 12  # m·L²/12, the same operations
    assert Bar(name="rod", joints=("A", "B"), length=0.6, mass=2, inertia=0).central_inertia == 0
    assert BARE.mass == BARE.central_inertia == 0


def test_centre_along_or_as_a_point():
    bars = [Bar(name="r", joints=("A", "B"), length=1, center=c) for c in (0.2, (0.2, 0.0))]
    assert bars[0].centre == bars[1].centre == (0.2, 0.0)


def test_terms():
    bar = Bar(name="rod", joints=("A", "B"), length=0.6, mass=2, center=(0.2, 0.05))
    (body,) = bar.terms()
    assert (body.name, body.kind, body.path, body.rotates) == ("rod", "bar", ("bars", "rod"), True)
    length = Parameter(("bars", "rod", "length"), 0.6)
    assert dict(body.points) == {"A": (ZERO, ZERO), "B": (length, ZERO)}
    assert [body.mass.value, body.inertia.value] == [2.0, bar.central_inertia]
    assert [c.value for c in body.centre] == [0.2, 0.05]


def test_what_is_zero_is_structure_except_the_length():
    (body,) = BARE.terms()
    assert body.mass.absent
    assert body.inertia.absent
    assert body.centre[1].absent
    assert body.points["O"] == (ZERO, ZERO)
    assert not body.points["A"][0].structural


def test_two_different_joints():
    text = "joints: {O: [0, 0]}\nbars:\n  crank: {length: 0.3, joints: [O, O]}\n"
    assert complaints(text) == [
        "line 3, column 24, bars.crank.joints: expected two different joints, found 'O' twice"
    ]


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("{joints: [O, A], length: 0}", "bars.crank.length: expected a length > 0"),
        ("{joints: [O, A], length: 1, mass: -1}", "bars.crank.mass: expected a mass >= 0"),
        ("{joints: [O, A], length: 1, inertia: nan}", "bars.crank.inertia: "),
        ("{joints: [O, A]}", "bars.crank: missing key 'length'"),
        ("{joints: [O, A], length: 1, centre: 0.5}", "did you mean 'center'?"),
        ("{joints: [O], length: 1}", "expected a list of two names"),
    ],
)
def test_wrong_entries(entry, found):
    (problem,) = complaints(f"joints: {{O: [0, 0]}}\nbars:\n  crank: {entry}\n")
    assert problem.startswith("line 3, column ")
    assert found in problem


def test_angle_runs_from_the_first_to_the_second_joint():
    text = "joints: {O: [0, 0]}\nbars: {crank: {joints: [A, O], length: 1}}\n"
    assert [*mechanism(text).bodies["crank"].points] == ["A", "O"]
