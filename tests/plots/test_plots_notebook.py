"""What notebooks show of mechanisms, solutions and reports."""

import re
from xml.etree import ElementTree

import pytest

import linkages
from linkages.kernel.system import System


@pytest.mark.slow_except("slider-crank")
@pytest.mark.parametrize("name", ["ninebar", "slider-crank", "andrews", "peaucellier"])
def test_a_mechanism_is_a_drawing_with_its_mobility_and_components(name):
    mechanism = linkages.load(name)
    text = mechanism._repr_html_()
    root = ElementTree.fromstring(f"<div>{closed(text)}</div>")  # well-formed
    (drawing,) = [node for node in root if node.tag.endswith("svg")]
    assert len(list(drawing.iter())) > 20
    assert root.find("h4").text == mechanism.name
    rows = [[cell.text for cell in row] for row in root.find("table")]
    sections = [component.section for component in mechanism.components]
    assert {row[0]: int(row[1]) for row in rows[1:]} == {s: sections.count(s) for s in sections}
    assert re.search(r"mobility \d+: (driven|free) ", root.find("p").text)


def closed(text: str) -> str:
    return text.replace(" class=n", "")


def test_a_mechanism_that_cannot_be_assembled_says_why():
    mechanism = linkages.load(
        "slider-crank", set={"bars.rod.length": "10 mm", "drives.crank.angle": 1}
    )
    text = mechanism._repr_html_()
    assert "<svg" not in text
    assert "cannot be assembled" in text
    assert "<td>bars</td>" in text


@pytest.mark.slow
def test_a_solution_is_a_table_of_largest_values():
    solution = linkages.simulate(linkages.load("ninebar"), end=0.1, samples=11)
    root = ElementTree.fromstring(f"<div>{closed(solution._repr_html_())}</div>")
    rows = {row[0].text: row[1].text for row in root.find("table")}
    force = max((r for r in solution.maxima if r["variable"] == "clearance_force"), key=size)
    assert rows["clearance force r1"] == f"{force['value']:.6g}"
    assert len(rows) == 1 + len({row["variable"] for row in solution.maxima})
    assert repr(solution) == (
        "Solution('Nine-bar press mechanism', 11 samples from t = 0 s to 0.1 s, 18 outputs)"
    )
    assert repr(solution.motion) == "Motion(11 samples in 1 pieces)"


def size(row):
    return abs(row["value"])


def test_a_topology_is_its_blocks_in_their_order():
    topology = System(linkages.load("ninebar")).topology
    root = ElementTree.fromstring(f"<div>{closed(topology._repr_html_())}</div>")
    assert root.find("p").text.startswith("mobility 3: driven crank1, crank4; free r1; 6 dependent")
    rows = [[cell.text for cell in row][1:] for row in root.find("table")][1:]
    assert rows == [
        ["RRR dyad", "link2, link3"],
        ["RRR dyad", "rocker6, link7"],
        ["RRP dyad", "link8, slider9"],
    ]


def test_a_pendulum_has_no_blocks_to_list():
    text = System(linkages.load("pendulum")).topology._repr_html_()
    assert "mobility 1: free" in text
    assert "<table>" not in text


def test_what_comes_from_a_file_is_escaped():
    mechanism = linkages.load("pendulum", set={"name": "<b>&"})
    solution = linkages.simulate(mechanism, end=0.1, samples=3)
    for text in (mechanism._repr_html_(), solution._repr_html_()):
        assert "<b>" not in text
        assert "&lt;b&gt;&amp;" in text


def test_a_stopped_motion_says_so():
    solution = linkages.simulate(linkages.load("pendulum"), end=1.0, max_steps=2, throw=False)
    assert "stopped at t = " in repr(solution)
    assert "<li>stopped at t = " in solution._repr_html_()
