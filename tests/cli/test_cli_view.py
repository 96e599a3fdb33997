"""``view``: what it writes and prints, and how it ends when something is wrong."""

import json
from pathlib import Path

import pytest
from shared_definitions import STUCK


def content_of(path):
    text = Path(path).read_text(encoding="utf-8")
    begin = text.index('id="content">') + len('id="content">')
    return json.loads(text[begin : text.index("</script>", begin)])


def test_a_page_is_written_and_its_place_printed(cli):
    result = cli("view", "slider-crank", "--samples", "101")
    assert (result.code, result.err) == (0, "")
    assert result.out.splitlines()[-1] == ("results/slider-crank/view.html: open it in a browser")
    assert result.files == {
        "results", "results/slider-crank", "results/slider-crank/view.html"
    }  # fmt: skip


def test_json_options_and_values_that_were_set(cli):
    options = ("--set", "bars.rod.length=0.2", "--out", "page", "--end", "0.01", "--json")
    result = cli("view", "slider-crank", "--outputs", "drive_effort", *options)
    assert (result.code, result.err) == (0, "")
    found = json.loads(result.out)
    assert found.pop("bytes") == Path("page/view.html").stat().st_size
    assert found == found | {
        "mechanism": "Slider-crank",
        "completed": True,
        "stopped": None,
        "notes": [],
        "files": ["page/view.html"],
    }
    content = content_of("page/view.html")
    assert "length: 0.2" in content["origin"]["definition"]
    assert {"drive_effort", "joint_position"} <= {
        one["variable"] for one in content["series"].values()
    }
    assert "bar_speed" not in {one["variable"] for one in content["series"].values()}


def test_a_motion_that_cannot_go_on_is_shown_up_to_there(cli):
    Path("stuck.yaml").write_text(STUCK, encoding="utf-8")
    result = cli("view", "stuck.yaml")
    assert result.code == 1
    assert result.err.startswith("stopped at t = 0.169569377 s")
    assert content_of("results/stuck/view.html")["stopped"].startswith("at t = 0.169569377 s")


def test_a_wrong_output_is_refused_and_nothing_written(cli):
    says = "did you mean 'drive_effort'?"
    cli.refused("view", "slider-crank", "--outputs", "drive_efort", says=says, files=set())


def test_it_opens_the_page_if_that_is_asked_for(cli, monkeypatch):
    seen = []
    monkeypatch.setattr("webbrowser.open", seen.append)
    assert cli("view", "four-bar", "--open").code == 0
    assert seen == [Path("results/four-bar/view.html").absolute().as_uri()]


@pytest.mark.slow_except("five-bar-free")
@pytest.mark.parametrize("name", ["five-bar-free", "peaucellier"])
def test_every_kind_of_mechanism_has_a_page(cli, name):
    assert cli("view", name, "--end", "0.1").code == 0
