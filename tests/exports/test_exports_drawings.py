"""SVG and DXF of links and paths, read back with other programs: millimetres, 1:1."""

import io
import re
import xml.etree.ElementTree as Tree

import numpy as np
import pytest

import linkages
from linkages.errors import InputError
from linkages.exports import Subject, exports, files_of
from linkages.exports.drawings import NARROW, paths_of, rounded
from linkages.plots.mechanism.roles import clearance_ends, convex_hull
from linkages.plots.mechanism.traces import moving_joints

ezdxf = pytest.importorskip("ezdxf")

DIGITS = 1e-5
"""Millimetres: SVG has nine significant digits of lengths below ten metres."""


@pytest.fixture(scope="module")
def solution():
    return linkages.simulate(linkages.load("four-bar"), samples=101)


def svg_of(solution, **options):
    (text,) = files_of(Subject(solution.mechanism, "m", solution), "svg", options).values()
    return Tree.fromstring(text)


def dxf_of(solution, **options):
    (data,) = files_of(Subject(solution.mechanism, "m", solution), "dxf", options).values()
    return ezdxf.read(io.StringIO(data.decode()))


def named(root, name):
    return next(element for element in root.iter() if element.get("id") == name)


def positions(solution, joint):
    """Places of a joint in millimetres."""
    return 1e3 * solution.data["joint_position"].sel(joint=joint).to_numpy()


def numbers(text):
    return np.array(re.findall(r"-?[\d.]+(?:e-?\d+)?", text), dtype=float)


def test_svg_is_as_large_as_the_mechanism(solution):
    """User units are millimetres: width and height of the page are those of its view box."""
    root = svg_of(solution)
    box = numbers(root.get("viewBox"))
    assert root.get("width") == f"{box[2]:.9g}mm"
    assert root.get("height") == f"{box[3]:.9g}mm"
    places = np.vstack([positions(solution, joint) for joint in ("O2", "A", "B", "P")])
    assert (box[2:] >= np.ptp(places, axis=0)).all()


@pytest.mark.parametrize("joint", ["A", "B", "P"])
def test_paths_are_samples_in_both_formats(solution, joint):
    """No vertex is anything else, nothing is scaled, and every sample is on the path."""
    samples = positions(solution, joint)
    (line,) = dxf_of(solution).modelspace().query(f'LWPOLYLINE[layer=="path {joint}"]')
    expected = np.array(line.get_points("xy"))
    drawn = numbers(named(svg_of(solution), f"path-{joint}").get("d")).reshape(-1, 2)
    assert drawn * (1, -1) == pytest.approx(expected, abs=DIGITS)
    taken = {tuple(np.round(place, 9)) for place in samples}
    assert {tuple(np.round(place, 9)) for place in expected} <= taken
    size = np.ptp(positions(solution, "P"), axis=0).max()  # of one path; all are larger
    assert from_line(samples, expected).max() <= NARROW * 2.0 * size
    assert len(expected) > 0.85 * len(samples)  # a hundred are few for this motion


def from_line(places, line):
    """Least distances of places from a polyline."""
    start, way = line[:-1], np.diff(line, axis=0)
    share = ((places[:, None] - start) * way).sum(axis=2) / (way**2).sum(axis=1)
    feet = start + np.clip(share, 0.0, 1.0)[:, :, None] * way
    return np.hypot(*np.moveaxis(places[:, None] - feet, 2, 0)).min(axis=1)


def test_many_samples_leave_as_many_vertices_as_a_path_needs():
    """A circle of radius r and an error e take about pi/sqrt(2e/r) of them; fewer is impossible.

    Between vertices at samples the error is at most e; so there may be up to twice as many.
    """
    solution = linkages.simulate(linkages.load("four-bar"), samples=20001)
    line = paths_of(Subject(solution.mechanism, "m", solution))["A"]
    angles = np.unwrap(np.arctan2(line[:, 1], line[:, 0]))
    size = max(np.ptp(positions(solution, j), axis=0).max() for j in "ABP")
    needed = np.ptp(angles) / (2.0 * np.sqrt(2.0 * NARROW * size / 40.0))
    assert needed <= 1.5 * len(line)
    assert len(line) <= 2.1 * needed
    assert from_line(positions(solution, "A")[::50], line).max() <= 1.5 * NARROW * size


def test_paths_are_those_of_moving_joints(solution):
    layers = {layer.dxf.name for layer in dxf_of(solution).layers}
    moving = moving_joints(solution.data, solution.mechanism)
    assert {name for name in layers if name.startswith("path")} == {f"path {j}" for j in moving}


def test_holes_are_at_joints(solution):
    """The distance of the holes of a link is its length."""
    document = dxf_of(solution, hole=0.006)
    holes = list(document.modelspace().query('CIRCLE[layer=="link crank"]'))
    assert [hole.dxf.radius for hole in holes] == [3.0, 3.0]
    length = 1e3 * solution.mechanism.bodies["crank"].points["A"][0].value
    ends = [np.array(hole.dxf.center)[:2] for hole in holes]
    assert np.hypot(*(ends[1] - ends[0])) == pytest.approx(length, rel=1e-12)
    root = svg_of(solution, hole=0.006)
    circle = named(root, "coupler-P")
    assert float(circle.get("r")) == 3.0
    place = [float(circle.get("cx")), -float(circle.get("cy"))]
    assert place == pytest.approx(positions(solution, "P")[0], abs=DIGITS)


def test_a_bar_is_a_stadium(solution):
    """Its area, from chords and bulges of the lines that were read back."""
    document = dxf_of(solution, hole=0.006, width=0.016)
    (edge,) = document.modelspace().query('LWPOLYLINE[layer=="link crank"]')
    assert edge.closed
    points = np.array(edge.get_points("xyb"))
    length = 1e3 * solution.mechanism.bodies["crank"].points["A"][0].value
    assert area(points) == pytest.approx(length * 16 + np.pi * 64, rel=1e-12)
    assert document.header["$INSUNITS"] == ezdxf.units.MM


def area(points):
    """Of a closed line of sides and arcs: the polygon, and the segment beyond every side."""
    x, y, bulge = points.T
    polygon = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
    chord = np.hypot(np.roll(x, -1) - x, np.roll(y, -1) - y)
    turn = 4 * np.arctan(bulge)
    radius = np.divide(chord, 2 * np.sin(turn / 2), where=turn != 0, out=np.zeros_like(chord))
    return polygon + np.sum(0.5 * radius**2 * (turn - np.sin(turn)))


def test_a_plate_has_the_area_of_its_hull_and_a_margin():
    """Steiner's formula: area + perimeter × radius + π radius²."""
    places = np.array([[0.0, 0.0], [9.0, 1.0], [5.0, 7.0], [4.0, 2.0], [1.0, 6.0]])
    hull = convex_hull(places)
    sides = np.roll(hull, -1, axis=0) - hull
    own = 0.5 * np.sum(hull[:, 0] * sides[:, 1] - hull[:, 1] * sides[:, 0])
    outline = rounded(places, 1.5)
    expected = own + 1.5 * np.hypot(*sides.T).sum() + np.pi * 1.5**2
    found = area(np.column_stack((outline.corners, outline.bulges)))
    assert found == pytest.approx(expected, rel=1e-13)


def test_arcs_of_svg_are_those_of_dxf(solution):
    """Half circles at both ends of a bar: radius half of its width."""
    edge = named(svg_of(solution, width=0.016), "link-crank")[0].get("d")
    assert re.findall(r"A (\S+) (\S+) 0 0 0", edge) == [("8", "8"), ("8", "8")]


@pytest.mark.parametrize("name", ["four-bar", "scotch-yoke", "ninebar"])
def test_dxf_has_nothing_that_other_programs_would_mend(name):
    solution = linkages.simulate(linkages.load(name), end=0.1, samples=11)
    audit = dxf_of(solution).audit()
    assert not audit.errors
    assert not audit.fixes


def test_links_or_paths_alone(solution):
    only = {layer.dxf.name for layer in dxf_of(solution, links=False).layers}
    assert not any(name.startswith("link") for name in only)
    ids = [element.get("id") or "" for element in svg_of(solution, paths=False).iter()]
    assert not any(name.startswith("path") for name in ids)


@pytest.mark.parametrize("name", ["scotch-yoke", "quick-return", "ninebar", "slider-crank"])
def test_sliders_slots_and_clearances(name):
    """A body that carries a slot has it as a second edge; clearances are no parts."""
    solution = linkages.simulate(linkages.load(name), end=1.0, samples=401)
    document = dxf_of(solution)
    layers = {layer.dxf.name for layer in document.layers}
    bodies = solution.mechanism.bodies
    solid = {name for name, body in bodies.items() if body.kind not in ("clearance", "offset")}
    assert {f"link {name}" for name in solid} == {n for n in layers if n.startswith("link")}
    carrier, travel = {"scotch-yoke": ("yoke", 100.0), "quick-return": ("arm", 100.0)}.get(
        name, (None, 0.0)
    )
    if carrier is not None:
        lines = document.modelspace().query(f'LWPOLYLINE[layer=="link {carrier}"]')
        edge, slot = (np.array(line.get_points("xyb")) for line in lines)
        radius = document.modelspace().query("CIRCLE")[0].dxf.radius
        # a stadium as wide as a hole, as long as the pin goes: twice the crank's 50 mm
        expected = travel * 2 * radius + np.pi * radius**2
        assert area(slot) == pytest.approx(expected, rel=1e-4)  # samples miss the ends of the way
        assert area(edge) > area(slot)


@pytest.mark.parametrize(
    ("to", "options", "expected"),
    [
        ("svgg", {}, "svg"),
        ("svg", {"holes": 1}, "has no option 'holes'"),
        ("svg", {"hole": 0.0}, "hole must be > 0"),
        ("dxf", {"hole": 0.01, "width": 0.01}, "width must be larger than the holes"),
        ("svg", {"paths": False, "links": False}, "nothing to export"),
    ],
)
def test_what_makes_no_sense_is_refused_before_anything_is_written(
    solution, tmp_path, to, options, expected
):
    with pytest.raises(ValueError, match=expected):
        linkages.export(solution, to, tmp_path / "new", **options)
    assert not (tmp_path / "new").exists()


def test_from_python_and_from_the_command_line(solution, tmp_path):
    from linkages.cli.requests import Request
    from linkages.cli.verbs.export_commands import run_export as run

    (file,) = linkages.export(solution, "svg", tmp_path)
    assert file.name == "four-bar-linkage-crank-rocker.svg"
    request = Request(verb="export", file="four-bar", out=tmp_path, given={"samples": 101})
    for to in ("svg", "dxf"):
        assert run(request, to, hole=None) == 0
    # both say in the file what was computed, and how
    said = re.compile(rb'<metadata id="linkages-origin">.*?</metadata>\n?', re.DOTALL)
    one, other = ((tmp_path / "four-bar.svg").read_bytes(), file.read_bytes())
    assert said.sub(b"", one) == said.sub(b"", other) != other
    assert (tmp_path / "four-bar.dxf").exists()  # one format leaves the other's files alone
    with pytest.raises(InputError, match=r"--to: .*\s.*'svgg'; did you mean 'svg'"):
        run(request, "svgg")


def test_without_ezdxf_dxf_says_what_to_install(solution, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ezdxf", None)
    with pytest.raises(ValueError, match=r"linkages\[dxf\]"):
        files_of(Subject(solution.mechanism, "m", solution), "dxf", {})


@pytest.mark.parametrize("name", ["four-bar", "quick-return", "ninebar", "andrews"])
def test_symbols_stand_where_their_joints_are(name):
    """Every pin of the drawing, in millimetres; symbols are as large as printed points are."""
    solution = linkages.simulate(linkages.load(name), end=0.01, samples=3)
    root = svg_of(solution, symbols=True)
    drawing = named(root, "drawing")
    pins = {}
    for element in drawing:
        if element.tag.endswith("circle") and element.get("data-name"):
            pins[element.get("data-name")] = element
    box = numbers(root.get("viewBox"))
    hidden = clearance_ends(solution.mechanism)
    for joint in solution.data["joint"].values:
        if joint in hidden:
            continue
        x, y = positions(solution, joint)[0]
        circle = pins[joint]
        place = [float(circle.get("cx")), -float(circle.get("cy"))]
        assert place == pytest.approx([x, y], abs=DIGITS)
        assert float(circle.get("r")) * 72 / 25.4 < 7.0
        assert box[0] < x < box[0] + box[2]
        assert box[1] < -y < box[1] + box[3]


def test_formats_are_found_by_name():
    assert {"svg", "dxf"} <= set(exports())


@pytest.mark.parametrize("hole", [None, 0.01])
@pytest.mark.parametrize("form", ["svg", "dxf"])
def test_a_mechanism_beyond_the_range_of_millimetres_is_refused(form, hole, tmp_path):
    text = """
joints: {O: [1e308, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: 1}}
simulate: {end: 0.1, samples: 3}
"""
    with pytest.raises(InputError, match="too large to draw in millimetres"):
        linkages.export(linkages.loads(text), form, tmp_path, hole=hole)
