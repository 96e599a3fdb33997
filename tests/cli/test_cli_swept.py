"""What verbs say of points that failed, and of clearances that lose contact."""

import io
import json
import re

import pytest
from rich.console import Console
from shared_definitions import worn_engine

from linkages.cli import terminal
from linkages.cli.swept import counted

ENGINE = worn_engine("""\
name: Slider-crank with a worn crank pin
clearances: {gap: {joint: A, bar: rod, size: 0.1 mm, angle: 180 deg}}
drives: {crank: {angle: 0, speed: SPEED rpm}}
simulate: {end: 1, samples: 1001, rtol: 1e-8}
""")
SIZE = "clearances.gap.size"
VERBS = {
    "poincare": ["--periods", "4"],
    "lyapunov": ["--periods", "4"],
    "bifurcation": ["--vary", f"{SIZE}=0.1mm:0.12mm:2", "--periods", "4", "--skip", "0"],
    "map": ["--x", f"{SIZE}=0.1mm:0.12mm:2", "--y", "gravity[0]=0:1:2", "--periods", "4"],
}  # fmt: skip


@pytest.fixture
def engine(cli, tmp_path):
    def run(verb, speed, *arguments, given=None):
        (tmp_path / "m.yaml").write_text(ENGINE.replace("SPEED", str(speed)))
        return cli(
            verb, "m.yaml", *(VERBS[verb] if given is None else given), "--no-figures", *arguments
        )

    return run


@pytest.mark.slow_except("poincare", "map")
@pytest.mark.parametrize("verb", VERBS)
def test_lost_contact_is_said(engine, verb):
    lost, kept = engine(verb, 1000), engine(verb, 300)
    assert (lost.code, kept.code) == (0, 0), lost.err + kept.err
    assert "note: The force in gap has the wrong sign" in lost.out
    assert "wrong sign" not in kept.out
    if verb in ("poincare", "lyapunov"):  # they follow its oscillations
        words = [
            "stay in contact: least force 156.8 N in gap at t = 0.",
            ", looked at every 0.000391",
        ]
    else:
        words = [
            "looked at every 0.00156 s after what is skipped, least force ",
            " N in gap; the mo",
        ]
    assert all(each in kept.out for each in words)


@pytest.mark.slow_except("poincare")
@pytest.mark.parametrize("verb", VERBS)
def test_lost_contact_stands_in_json(engine, verb):
    (found,) = json.loads(engine(verb, 1000, "--json").out)["contact"]
    points = {"bifurcation": 2, "map": 4}.get(verb, 1)
    assert (found["clearance"], found["points"], found["lost"]) == ("gap", points, points)
    assert 0.1 < found["share_lost"] < 0.5
    assert found["least_force"] < -100


def test_tables_of_sweeps_say_it_for_every_point(engine, tmp_path):
    for verb, table in (("bifurcation", "bifurcation_values.csv"), ("map", "map.csv")):
        engine(verb, 1000)
        head = (tmp_path / "results/m" / table).read_text(encoding="utf-8").splitlines()[0]
        assert "contact lost in gap (share),least force in gap (N)" in head


def test_reasons_that_differ_in_numbers_are_one():
    texts = ["joint F7: expected > 0, found -0.1", "joint F7: expected > 0, found -2e-3", "other"]
    assert counted(texts) == {texts[0]: 2, "other": 1}
    assert len(counted(["joint F7 is lost", "joint F8 is lost"])) == 2


def test_each_kind_of_failure_is_noted_once(engine):
    given = ["--x", "bars.rod.mass=-0.2:0.2:5", "--y", f"{SIZE}=0.1mm:0.12mm:2", "--periods", "4"]
    result = engine("map", 300, given=given)
    assert result.code == 0
    (note,) = [line for line in result.out.splitlines() if "bars.rod.mass: expected" in line]
    assert note.startswith("note: 4 points: bars.rod.mass: expected a mass")


def test_a_budget_of_steps(engine):
    result = engine("bifurcation", 300, "--skip", "1", "--max-steps", "50")
    assert result.code == 1
    assert "no value could be computed: The allowed number of steps was used up" in result.err
    assert "2 values: The allowed number of steps was used up" in result.out


def test_a_bar_and_the_time_left_fit_into_80_columns(monkeypatch):
    screen = io.StringIO()
    wide = Console(file=screen, force_terminal=True, width=80, color_system=None)
    monkeypatch.setattr(terminal, "PATIENCE", -1.0)
    monkeypatch.setattr(terminal, "console", lambda **_: wide)
    label = "diagram of Slider-crank with a journal [ball] in a clearance"
    with terminal.progress(label, shown=True, what="of values") as update:
        update(0.5, "3 of 136, 2.2 per second")
    shown = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", screen.getvalue())
    lines = {line.strip() for line in re.split(r"[\r\n]", shown) if "of values" in line}
    assert lines
    for line in lines:
        assert re.match(r"━+ +50% of values, remaining [\d:-]+ 3 of 136, 2.2 per second", line)
        assert len(line) <= 80
        assert line.endswith("…")
