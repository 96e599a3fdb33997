"""``animate``: what it writes and prints, and how it ends when something is wrong."""

import json
from pathlib import Path

import pytest
from PIL import Image
from shared_definitions import STUCK

FEW = ("--fps", "4", "--dpi", "40")


def test_a_gif_of_the_whole_motion(cli):
    result = cli("animate", "slider-crank", *FEW)
    assert (result.code, result.err) == (0, "")
    assert result.out == (
        "Slider-crank: 16 frames from t = 0 s to 0.075 s, 4 per second, slowed down 50×\n"
        "results/slider-crank/animation.gif, 4 s\n"
    )
    with Image.open("results/slider-crank/animation.gif") as image:
        assert image.n_frames == 16
    assert result.files == {
        "results", "results/slider-crank", "results/slider-crank/animation.gif"
    }  # fmt: skip


def test_json_and_options(cli):
    options = ("--start", "20 ms", "--duration", "10 ms", "--slow", "100", "--out", "film")
    options += ("--size", "400x300", "--set", "bars.rod.length=0.2", "--json")
    result = cli("animate", "slider-crank", *FEW, *options)
    assert (result.code, result.err) == (0, "")
    content = json.loads(result.out)
    assert content.pop("bytes") == Path("film/animation.gif").stat().st_size
    assert content == {
        "mechanism": "Slider-crank",
        "completed": True,
        "stopped": None,
        "start": 0.02,
        "last": pytest.approx(0.0275),
        "frames": 4,
        "fps": 4.0,
        "slow": pytest.approx(100.0),
        "slow_clearances": pytest.approx(100.0),
        "swings": {},
        "seconds": 1.0,
        "notes": [],
        "changes": ["bars.rod.length=0.2"],
        "files": ["film/animation.gif"],
    }
    with Image.open("film/animation.gif") as image:
        assert image.size == (400, 300)


@pytest.mark.slow
def test_a_film_may_be_longer_than_the_file_says(cli):
    result = cli("animate", "slider-crank", *FEW, "--duration", "0.2", "--json")
    assert json.loads(result.out)["last"] > 0.08


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--start", "1"), "start must be a time from 0 to before 0.08 s, found 1"),
        (("--duration", "-1"), "duration must be > 0 s, found -1"),
        (("--fps", "0"), "fps must be at least 0.01, found 0"),
        (("--fps", "100"), "a GIF shows at most 50 frames per second, found 100"),
        (("--slow", "-2"), "slow must be > 0, found -2"),
        (("--size", "big"), "--size must be WIDTHxHEIGHT in pixels, such as 800x600, found 'big'"),
        (("--size", "20x20"), "too small for this picture"),
        (("--format", "avi"), "'avi' is not one of"),
    ],
)
def test_wrong_options_write_nothing(cli, options, message):
    result = cli("animate", "slider-crank", *FEW, *options)
    assert result.code == 2
    assert message in " ".join(result.err.split())
    assert result.files == set()


def test_mp4_without_ffmpeg(cli, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    says = "MP4 needs the program ffmpeg, which was not found"
    cli.refused("animate", "slider-crank", "--format", "mp4", says=says, files=set())


@pytest.mark.slow
def test_a_motion_that_stops_is_shown_up_to_there(cli, tmp_path):
    (tmp_path / "stuck.yaml").write_text(STUCK)
    result = cli("animate", "stuck.yaml", *FEW, "--json")
    assert result.code == 1
    content = json.loads(result.out)
    assert not content["completed"]
    assert content["last"] < content["stopped"]["time"] == pytest.approx(0.1695694)
    with Image.open(content["files"][0]) as image:
        assert image.n_frames == content["frames"] == 34


def test_a_motion_that_stops_before_the_film_begins(cli, tmp_path):
    (tmp_path / "stuck.yaml").write_text(STUCK)
    result = cli("animate", "stuck.yaml", *FEW, "--start", "0.5")
    assert result.code == 1
    assert "nothing to animate: at t = 0.169569377 s" in result.err
    assert result.files == {"stuck.yaml"}


def test_ctrl_c_leaves_nothing(cli, monkeypatch):
    from linkages.plots.films.stage import Stage

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(Stage, "picture", interrupt)
    result = cli("animate", "slider-crank", *FEW)
    assert (result.code, result.err.strip()) == (130, "interrupted")
    assert not [name for name in result.files if "animation" in name]
