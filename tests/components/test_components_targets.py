"""Targets: points in the file or in a CSV file beside it, in units, and what is refused."""

import pytest

import linkages
from linkages import InputError
from linkages.components.scene import MAX_POINTS, Target

DEFINITION = """\
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 1}}
drives: {crank: {angle: 0, speed: 1}}
targets:
  wanted: {TARGET}
"""
CSV = "# measured\nx;y\n20;5\n\n10;-5\n10;0\n"


@pytest.fixture
def points(tmp_path):
    """Loads a definition with a target and a CSV file, gives the points."""

    def loaded(target, csv=CSV):
        (tmp_path / "points.csv").write_text(csv)
        file = tmp_path / "path.yaml"
        file.write_text(DEFINITION.replace("TARGET", target))
        (found,) = (c for c in linkages.load(file).components if isinstance(c, Target))
        return found.points

    return loaded


@pytest.mark.parametrize(
    "target",
    [
        "file: points.csv, units: [mm, mm]",
        "file: points.csv, columns: [x, y], units: [mm, mm]",
        "points: [[20 mm, 5 mm], [10 mm, -5 mm], [0.01, 0]]",
    ],
)
def test_points(points, target):
    found = points(target)
    assert [*map(list, found)] == [
        pytest.approx(pair, abs=1e-17) for pair in ([0.02, 0.005], [0.01, -0.005], [0.01, 0.0])
    ]


@pytest.mark.parametrize(
    ("target", "message"),
    [
        ("file: nowhere.csv", "line 5, column 12, targets.wanted.file: no such file: nowhere.csv"),
        ("file: ../points.csv", "outside of the folder of the definition"),
        ("file: points.csv, points: [[0, 0]]", "'file' and 'points' are both given"),
        (
            "file: points.csv, columns: [x, z]",
            "targets.wanted.columns[1]: points.csv has no column",
        ),
        ("file: points.csv, columns: [x]", "expected two names or numbers, of x and of y"),
        ("file: points.csv, units: [mm, s]", "points[0][1]: expected a length"),
        ("points: []", "expected 1 to 1000 points, found 0"),
        ("points: [[0, 1, 2]]", "targets.wanted.points[0]"),
        ("point: [[0, 1]]", "unknown key 'point'; did you mean 'points'?"),
    ],
)
def test_what_is_no_target(points, target, message):
    with pytest.raises(InputError) as caught:
        points(target)
    assert message in str(caught.value)


def test_a_bad_line_of_the_file_is_named(points):
    with pytest.raises(InputError, match=r"points\.csv, line 2: expected a number; decimals are"):
        points("file: points.csv", "x;y\n1,5;2\n")


def test_names_and_numbers_of_points_have_limits():
    with pytest.raises(InputError, match="expected a word of letters, digits and _, found 'a b'"):
        linkages.loads(DEFINITION.replace("wanted: {TARGET}", "a b: {points: [[0, 1]]}"))
    many = ", ".join(["[0, 1]"] * (MAX_POINTS + 1))
    with pytest.raises(InputError, match="expected 1 to 1000 points, found 1001"):
        linkages.loads(DEFINITION.replace("TARGET", f"points: [{many}]"))


def test_targets_stay_with_the_mechanism(tmp_path):
    """In a saved file, with other numbers, and while sweeps vary others."""
    mechanism = linkages.loads(DEFINITION.replace("TARGET", "points: [[2, 0], [0, 3]]"))
    mechanism.save(tmp_path / "saved.yaml")
    data = linkages.sweep(
        linkages.load(tmp_path / "saved.yaml"), {"bars.crank.length": [1.0, 2.0]},
        {"away": "max_distance(A, wanted)"}, end=6.3, samples=64,
    )  # fmt: skip
    assert data.away.to_numpy() == pytest.approx([2.0, 1.0], rel=1e-12)
    with pytest.raises(ValueError, match="motions are compared with the targets of the file alone"):
        linkages.sweep(
            mechanism, {"targets.wanted.points[0][0]": [1.0, 2.0]},
            {"away": "max_distance(A, wanted)"},
        )  # fmt: skip
