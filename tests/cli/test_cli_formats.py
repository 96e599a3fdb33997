"""``--format``: figures as pixels or vectors, by every verb that draws."""

import re

import pytest
from shared_definitions import DRIVEN_ROD

BEGINNINGS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}
RUNS = {
    "simulate": (),
    "check": ("--out", "results"),
    "poincare": ("--periods", "5"),
    "lyapunov": ("--periods", "5"),
    "bifurcation": (
        "--vary", "gravity[1]=-9:-10:2", "--periods", "2", "--skip", "1", "--cores", "1"
    ),
    "map": (
        "--x", "free.rod.angle=0.1:0.2:2", "--y", "free.rod.speed=0:1:2",
        "--periods", "4", "--cores", "1", "--indicator", "fli",
    ),
}  # fmt: skip


@pytest.mark.slow_except("check-pdf", "poincare-svg")
@pytest.mark.parametrize(("verb", "kind"), list(zip(RUNS, ["svg", "pdf"] * 3, strict=True)))
def test_vectors(cli, tmp_path, verb, kind):
    (tmp_path / "pendulum.yaml").write_text(DRIVEN_ROD)
    result = cli(verb, "pendulum.yaml", *RUNS[verb], "--format", kind)
    assert result.code == 0
    drawn = [tmp_path / name for name in result.files if name.endswith(("png", "svg", "pdf"))]
    assert drawn
    assert all(path.suffix == f".{kind}" for path in drawn)
    assert all(path.read_bytes().startswith(BEGINNINGS[kind]) for path in drawn)


@pytest.mark.parametrize("verb", [*RUNS, "chaos", "bench"])
def test_an_unknown_format_is_refused_before_anything_is_done(cli, verb):
    result = cli(verb, "pendulum", *RUNS.get(verb, ()), "--format", "bmp")
    assert result.code == 2
    text = " ".join(re.sub("\x1b\\[[0-9;]*m|│", "", result.err).split())
    assert "'bmp' is not one of 'png', 'svg', 'pdf'" in text
    assert "Value error" not in text
    assert result.files == set()
