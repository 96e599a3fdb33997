"""`check --modes`: all ways to put a mechanism together, which is selected, what is not known."""

import itertools
import json

import numpy as np
import pytest

from linkages.kernel.assembly_branches import MOST_BRANCHES


def modes_of(cli, *arguments):
    result = cli("check", *arguments, "--modes", "--json")
    assert (result.code, result.err) == (0, "")
    return json.loads(result.out)["modes"]


def test_four_bar_has_two_mirrored_in_the_line_between_the_neighbours(cli):
    found = modes_of(cli, "four-bar")
    assert (found["count"], found["complete"], found["notes"]) == (2, True, [])
    sides = {mode["blocks"][0]["side"]: mode for mode in found["modes"]}
    assert [side for side, mode in sides.items() if mode["selected"]] == ["left"]
    joints = {j["joint"]: j["position"] for j in json.loads(cli("check", "four-bar", "--json").out)[
        "joints"
    ]}  # fmt: skip
    assert sides["left"]["positions"]["B"] == joints["B"]
    assert "A" not in sides["left"]["positions"]  # the crank's end is where it is
    line = np.subtract(joints["O4"], joints["A"])
    way = np.subtract(sides["left"]["positions"]["B"], joints["A"])
    mirrored = 2 * (way @ line) / (line @ line) * line - way + joints["A"]
    # a few roundings of positions of order 0.1
    assert sides["right"]["positions"]["B"] == pytest.approx(list(mirrored), abs=1e-15)


def test_blocks_are_called_by_joints_of_the_file(cli):
    """The dyad of the slotted arm closes at the axis of its block, which has no name there."""
    assert [b["apex"] for b in modes_of(cli, "quick-return")["modes"][0]["blocks"]] == ["A", "C"]
    assert ".axis" not in cli("check", "quick-return", "--modes").out


def test_selected_follows_the_definition(cli):
    found = modes_of(cli, "four-bar", "--set", "assembly.B=right")
    assert [m["blocks"][0]["side"] for m in found["modes"] if m["selected"]] == ["right"]


def test_every_combination_of_sides(cli):
    found = modes_of(cli, "jansen")
    combinations = {tuple(b["side"] for b in mode["blocks"]) for mode in found["modes"]}
    assert combinations == set(itertools.product(("left", "right"), repeat=3))
    assert sum(mode["selected"] for mode in found["modes"]) == 1


@pytest.mark.slow
def test_modes_of_an_iterated_group_close_and_are_said_to_be_found_by_search(cli):
    found = modes_of(cli, "class-three")
    assert not found["complete"]
    assert any("found by search" in note and "not certain" in note for note in found["notes"])
    assert sum(mode["selected"] for mode in found["modes"]) == 1
    assert found["count"] >= 2
    for mode in found["modes"]:
        place = mode["positions"]
        sides = {
            ("E", "F"): 0.2,
            ("F", "G"): np.hypot(0.11, 0.16),
            ("E", "G"): np.hypot(0.09, 0.16),
        }
        for (first, second), length in sides.items():
            apart = np.hypot(*np.subtract(place[first], place[second]))
            assert apart == pytest.approx(length, abs=1e-12)
        for joint, foot, length in (
            ("E", (0.05, 0), 0.23), ("F", (0.33, -0.07), 0.15), ("G", (0.25, 0.39), 0.21),
        ):  # fmt: skip
            assert np.hypot(*np.subtract(place[joint], foot)) == pytest.approx(length, abs=1e-12)


def test_table_names_the_selected_mode(cli):
    lines = cli("check", "four-bar", "--modes").out.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("Assembly modes"))
    assert lines[start + 1].split()[:6] == ["mode", "block", "0", "at", "B", "B"]
    assert lines[start + 2].split()[:3] == ["1", "selected", "left"]
    assert lines[start + 3].split()[:2] == ["2", "right"]


CHAIN = 10
"""So many slider-crank dyads: 2 to this power modes."""


@pytest.mark.slow
def test_more_than_the_most_are_cut_and_said_to_be(cli, tmp_path):
    bars = "".join(f"  rod{i}: {{joints: [A, B{i}], length: 0.{i + 2}}}\n" for i in range(CHAIN))
    sliders = "".join(f"  s{i}: {{joint: B{i}, through: O}}\n" for i in range(CHAIN))
    (tmp_path / "m.yaml").write_text(
        f"joints: {{O: [0, 0]}}\nbars:\n  crank: {{joints: [O, A], length: 0.05}}\n{bars}"
        f"sliders:\n{sliders}drives: {{crank: {{angle: 0.5, speed: 1}}}}\n"
    )
    found = modes_of(cli, "m.yaml")
    assert found["count"] == MOST_BRANCHES
    assert not found["complete"]
    assert any(f"only the first {MOST_BRANCHES}" in note for note in found["notes"])
    assert "more modes; --json lists all" in cli("check", "m.yaml", "--modes").out


@pytest.mark.slow
def test_out_draws_them(cli, tmp_path):
    result = cli("check", "four-bar", "--out", "there")
    assert (result.code, result.err) == (0, "")
    assert "drawn in there/modes.png" in result.out
    assert (tmp_path / "there/modes.png").read_bytes().startswith(b"\x89PNG")
    assert result.files == {"there", "there/modes.png"}
