import pytest
from component_reading import complaints, mechanism

from linkages.components.actuators import Drive
from linkages.components.external_loads import SliderForce
from linkages.components.joint_clearances import Clearance
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.rigid_bodies import Bar, GroundJoint, Plate, Slider
from linkages.components.scene import AssemblyHint, UniformGravity
from linkages.errors import InputError

BARS = """joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3}
  coupler: {joints: [A, B], length: 0.9}
  rocker: {joints: [C, B], length: 0.7}
"""
PISTON = "sliders:\n  piston: {joint: B, through: O}\n"


def test_nothing_to_complain_about():
    assert mechanism(BARS + PISTON).components


@pytest.mark.parametrize(
    ("rest", "found"),
    [
        (
            "drives:\n  krank: {angle: 0, speed: 1}\n",
            "line 7, column 3, drives.krank: unknown bar 'krank'; did you mean 'crank'?",
        ),
        (
            "drives:\n  xyz: {angle: 0, speed: 1}\n",
            "line 7, column 3, drives.xyz: unknown bar 'xyz'; "
            "expected one of: coupler, crank, rocker",
        ),
        (
            "free:\n  Rocker: {angle: 0}\n",
            "line 7, column 3, free.Rocker: unknown bar 'Rocker'; did you mean 'rocker'?",
        ),
        (
            "free:\n  piston: {position: 0}\n",
            "line 7, column 3, free.piston: unknown slider 'piston'; expected one of: none",
        ),
        (
            "assembly:\n  E: left\n",
            "line 7, column 3, assembly.E: unknown joint 'E'; expected one of: A, B, C, O",
        ),
        (
            "clearances:\n  r1: {joint: B, bar: roker, size: 1e-4}\n",
            "line 7, column 18, clearances.r1.bar: unknown bar 'roker'; did you mean 'rocker'?",
        ),
        (
            "sliders:\n  piston: {joint: F, through: O}\n",
            "line 7, column 12, sliders.piston.joint: unknown joint 'F'; "
            "expected one of: A, B, C, O",
        ),
        (
            "sliders:\n  piston: {joint: B, through: Q}\n",
            "line 7, column 22, sliders.piston.through: unknown ground joint 'Q'; "
            "expected one of: C, O",
        ),
        (
            "loads:\n- {slider: crank, force: 1}\n",
            "line 7, column 4, loads[0].slider: unknown slider 'crank'; expected one of: none",
        ),
    ],
)
def test_unknown_names(rest, found):
    assert complaints(BARS + rest) == [found]


def test_unknown_joint_of_a_clearance_is_also_missing_from_its_bar():
    rest = "clearances:\n  r1: {joint: E, bar: rocker, size: 1e-4}\n"
    assert complaints(BARS + rest) == [
        "line 7, column 8, clearances.r1.joint: unknown joint 'E'; expected one of: A, B, C, O",
        "line 7, column 8, clearances.r1.joint: bar 'rocker' has no joint 'E'; it has C, B",
    ]


def test_clearance_at_a_joint_that_its_bar_lacks():
    rest = "clearances:\n  r1: {joint: A, bar: rocker, size: 1e-4}\n"
    assert complaints(BARS + rest) == [
        "line 7, column 8, clearances.r1.joint: bar 'rocker' has no joint 'A'; it has C, B"
    ]


def test_two_clearances_at_one_place():
    rest = (
        "clearances:\n  r1: {joint: B, bar: rocker, size: 1e-4}\n"
        "  r2: {joint: B, bar: rocker, size: 2e-4}\n"
    )
    assert complaints(BARS + rest) == [
        "line 8, column 3, clearances.r2: clearance 'r1' is between the same joint and bar"
    ]


def test_clearance_where_only_one_body_is():
    text = BARS.replace("C: [1, 0]}", "}").replace("rocker: {joints: [C,", "rocker: {joints: [O,")
    text = text.replace("coupler: {joints: [A, B]", "coupler: {joints: [A, E]")
    assert complaints(text + "clearances:\n  r1: {joint: E, bar: coupler, size: 1e-4}\n") == [
        "line 7, column 3, clearances.r1: nothing but bar 'coupler' is at joint 'E'"
    ]


@pytest.mark.parametrize("joint", ["O", "A", "B"])
def test_clearances_at_the_ground_between_bars_and_at_a_slider(joint):
    bar = {"O": "crank", "A": "crank", "B": "rod"}[joint]
    text = """joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3}, rod: {joints: [A, B], length: 0.9}}
sliders: {piston: {joint: B, through: O}}
"""
    rest = f"clearances: {{r1: {{joint: {joint}, bar: {bar}, size: 1e-4}}}}\n"
    assert f"{joint}.r1" in mechanism(text + rest).bodies[bar].points


def test_names_of_bodies_are_taken_once():
    rest = (
        "sliders:\n  crank: {joint: B, through: O}\n"
        "clearances:\n  rocker: {joint: B, bar: coupler, size: 1e-4}\n"
    )
    assert complaints(BARS + rest) == [
        "line 7, column 3, sliders.crank: the name 'crank' is taken already; expected a new one",
        "line 9, column 3, clearances.rocker: the name 'rocker' is taken already; "
        "expected a new one",
    ]


def test_joints_and_bodies_may_share_a_name():
    assert mechanism(BARS.replace("crank:", "A:")).bodies["A"]


def test_ground_is_the_frame():
    assert complaints(BARS.replace("rocker:", "ground:")) == [
        "line 5, column 3, bars.ground: the name 'ground' stands for the frame; "
        "expected another one"
    ]


def test_driven_and_free():
    rest = "drives:\n  crank: {angle: 0, speed: 1}\nfree:\n  crank: {angle: 0}\n"
    message = "the coordinate of 'crank' is both driven and free; expected one of the two"
    assert complaints(BARS + rest) == [
        f"line 7, column 3, drives.crank: {message}",
        f"line 9, column 3, free.crank: {message}",
    ]


GEAR = "gears:\n- {bars: [crank, rocker], ratio: -2}\n"


@pytest.mark.parametrize(
    ("rest", "found"),
    [
        (
            GEAR + "drives:\n  rocker: {angle: 0, speed: 1}\n",
            "gears[0]: the angle of 'rocker' follows from this relation and is driven; "
            "expected one of the two",
        ),
        (
            GEAR + "free:\n  rocker: {angle: 0}\n",
            "gears[0]: the angle of 'rocker' follows from this relation and is free; "
            "expected one of the two",
        ),
        (
            GEAR + "welds:\n  B: {bars: [coupler, rocker], angle: 0}\n",
            "gears[0]: the angle of 'rocker' follows from this relation and from another one; "
            "expected one: turn the relation round, with the inverse ratio",
        ),
        (
            GEAR + "- {bars: [coupler, crank], ratio: 2}\n- {bars: [rocker, coupler], ratio: 2}\n",
            "gears[0]: coordinates follow from each other: rocker → crank → coupler → rocker",
        ),
        (
            "clearances:\n  r1: {joint: B, bar: rocker, size: 1e-4}\n"
            "welds:\n  B: {bars: [coupler, rocker], angle: 0}\n",
            "clearances.r1: bar 'rocker' is welded at joint 'B'",
        ),
    ],
)
def test_coordinates_with_two_laws(rest, found):
    (problem,) = complaints(BARS + rest)
    assert problem.endswith(found)


def test_relations_one_after_another_are_no_cycle():
    rest = "- {bars: [rocker, coupler], ratio: 2, carrier: crank}\n"
    assert len(mechanism(BARS + GEAR + rest).relations) == 2


def test_a_bar_and_a_slider_of_one_name():
    rest = "sliders:\n  crank: {joint: B, through: O}\ndrives:\n  crank: {angle: 0, speed: 1}\n"
    assert complaints(BARS + rest) == [
        "line 7, column 3, sliders.crank: the name 'crank' is taken already; expected a new one"
    ]


def test_everything_at_once_in_the_order_of_the_file():
    text = """joints: {O: [0, 0], C: [1, zero]}
bars:
  crank: {joints: [O, A], lenght: 0.3}
  coupler: {joints: [A, B], length: -0.9}
  rocker: {joints: [C, B], length: 0.7}
drives:
  crenk: {angle: 0, speed: 1}
assembly:
  B: lefd
  X: left
colour: red
"""
    lines = [int(c.split(",")[0].removeprefix("line ")) for c in complaints(text)]
    # line 3 has two: what the misspelt key is, and that the length is missing
    assert lines == [1, 3, 3, 4, 7, 9, 10, 11]


FAULTY = {
    "a joint": BARS.replace("O: [0, 0]", "O: [0]"),
    "a bar": BARS.replace("length: 0.3", "length: -0.3"),
    "a plate": BARS.replace("{joints: [O, A], length: 0.3}", "{points: {O: [0, 0], A: [1]}}"),
    "a section": BARS.replace("\n  crank", " [1]\n#").replace("\n  coupler", "\n#").replace(
        "\n  rocker", "\n#"
    ),
    "a misspelt section": BARS.replace("bars:", "bras:"),
}  # fmt: skip


@pytest.mark.parametrize("text", FAULTY.values(), ids=FAULTY.keys())
def test_faulty_entries_still_declare_their_names(text):
    """One mistake is one complaint, although everything else uses what it declares."""
    rest = PISTON.replace("piston: {", "piston: {angle: 0, ") + (
        "clearances:\n  r1: {joint: A, bar: coupler, size: 1e-4}\n"
        "drives:\n  crank: {angle: 0, speed: 1}\n"
        "free:\n  piston: {position: 0}\n"
        "assembly:\n  A: [1, 1]\n  B: left\n"
        "loads:\n- {slider: piston, force: 1}\n"
    )
    assert mechanism(BARS + rest)
    assert len(complaints(text + rest)) == 1


def test_faulty_sliders_and_clearances_still_declare_their_names():
    rest = (
        "sliders:\n  piston: {joint: B, through: O, mass: -1}\n"
        "clearances:\n  r1: {joint: B, bar: rocker, size: 0}\n"
        "free:\n  piston: {position: 0}\nloads:\n- {slider: piston, force: 1}\n"
    )
    found = complaints(BARS + rest)
    assert [c.split(": ")[0].split(", ")[-1] for c in found] == [
        "sliders.piston.mass",
        "clearances.r1.size",
    ]


PIN = GroundJoint(name="O", position=(0, 0))
CRANK = Bar(name="crank", joints=("O", "A"), length=1)
ROD = Bar(name="rod", joints=("A", "B"), length=2)
PISTON_AT_B = Slider(name="piston", joint="B", through="O")


@pytest.mark.parametrize(
    "twice",
    [
        GroundJoint(name="O", position=(1, 0)),
        CRANK,
        Plate(name="crank", points={"A": (0, 0)}),
        PISTON_AT_B,
        Clearance(name="r1", joint="A", bar="rod", size=1e-3),
        Drive(name="crank", angle=0, speed=1),
        AssemblyHint(name="B", where="left"),
        SliderForce(index=0, slider="piston", force=1),
        UniformGravity(acceleration=(0, -9.81)),
    ],
    ids=lambda c: type(c).__name__,
)
def test_repeated_in_python(twice):
    """A definition file cannot repeat a key; a list of components can."""
    with pytest.raises(InputError):
        Mechanism(components=(PIN, CRANK, ROD, PISTON_AT_B, twice, twice))
