"""Every wrong input ends with exit code 2, one report on standard error, and nothing written."""

import os
import re
import subprocess
import sys
from dataclasses import dataclass

import pytest

FOUR_BAR = """\
name: Four-bar
joints:
  O2: [0, 0]
  O4: [0.1, 0]
bars:
  crank: {joints: [O2, A], length: 0.04, mass: 0.15}
  coupler: {joints: [A, B], length: 0.12, mass: 0.45}
  rocker: {joints: [O4, B], length: 0.08, mass: 0.3}
drives:
  crank: {angle: 0.7, speed: 6}
assembly:
  B: left
simulate: {end: 0.2, samples: 11}
"""
SLIDER_CRANK = """\
joints:
  O: [0, 0]
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders:
  piston: {joint: B, through: O, mass: 0.4}
drives:
  crank: {angle: 0.3, speed: 6}
assembly:
  B: [0.18, 0]
loads:
  - {slider: piston, force: -200}
simulate: {end: 0.2, samples: 11}
"""


@dataclass(frozen=True)
class Case:
    """A file (None: there is none), arguments after it, and what the report must contain.

    `line` is the line that it names; 0 where what is wrong has no place in the file.
    """

    text: str | bytes | None
    expected: tuple[str, ...]
    line: int = 0
    arguments: tuple[str, ...] = ()
    verb: str = "simulate"
    file: str = "m.yaml"
    source: str | None = None


def four(old, new, line, *expected):
    assert old in FOUR_BAR
    return Case(FOUR_BAR.replace(old, new, 1), expected, line)


def crank(old, new, line, *expected):
    assert old in SLIDER_CRANK
    return Case(SLIDER_CRANK.replace(old, new, 1), expected, line)


def args(*arguments, expected, text=FOUR_BAR, **others):
    return Case(text, expected, arguments=arguments, **others)


def clearance(entry, line, *expected):
    return four("drives:", f"clearances:\n  r: {entry}\ndrives:", line, *expected)


BOMB = "a0: &a0 [x]\n" + "".join(
    f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12)
)
# O2A at 0.7 rad: halfway between A and O4 both places of B are equally near.
HALFWAY = "B: [0.5*(0.1 + 0.04*0.7648421872844885), 0.5*0.04*0.6442176872376911]"
LONG = "y" * 500
BAD_NAME = "expected a name"

CASES = {
    "decimal-comma": four(
        "length: 0.04", "length: 30,5 mm", 6, "unknown key '5 mm'; decimals are written with a p",
    ),
    "unit-unknown-power": four("length: 0.04", "length: 4 mm5", 6, "unknown unit 'mm5'"),
    "unit-misspelt": four("speed: 6", "speed: 10 rpn", 10, "'rpn'; did you mean 'rpm'?"),
    # misspelt keys, at every level
    "key-top": four("drives:", "drive:", 9, "unknown key 'drive'; did you mean 'drives'?"),
    "key-bar": four("length: 0.04", "lenght: 0.04", 6, "missing key 'length'", "did you mean"),
    "key-slider": crank("through:", "thruogh:", 7, "did you mean 'through'?"),
    "key-drive": four("speed: 6", "sped: 6", 10, "did you mean 'speed'?"),
    "key-load": crank("force:", "forec:", 13, "loads[0].forec", "did you mean 'force'?"),
    "key-simulate": four("samples", "sampels", 13, "did you mean 'samples'?"),
    "key-clearance": clearance("{joint: A, bar: crank, sze: 1e-4}", 10, "did you mean 'size'?"),
    "key-free": four("drives:\n  crank: {angle", "free:\n  crank: {angel", 10, "mean 'angle'?"),
    "key-capitals": four("bars:", "Bars:", 5, "did you mean 'bars'?"),
    "side-misspelt": four("B: left", "B: lft", 12, "did you mean 'left'?"),
    # numbers
    "length-missing": four(", length: 0.04", "", 6, "missing key 'length'", "a length > 0"),
    "length-negative": four("0.04", "-0.04", 6, "a length > 0", "'-0.04'"),
    "length-zero": four("0.04", "0", 6, "a length > 0"),
    "length-unit": four("0.04", "4 kg", 6, "kg is a mass, not a length"),
    "length-nan": four("0.04", "nan", 6, "a length > 0", "'nan'"),
    "length-inf": four("0.04", ".inf", 6, "a length > 0", "'.inf'"),
    "length-1e400": four("0.04", "1e400", 6, "too large for a number"),
    "length-code": four("0.04", "__import__('os')", 6, "expected a number"),
    "mass-negative": four("mass: 0.15", "mass: -1", 6, "a mass >= 0"),
    "speed-hertz": four("speed: 6", "speed: 6 Hz", 10, "write rad/s or rpm"),
    "point-of-three": four("[0.1, 0]", "[0.1, 0, 0]", 4, "a list of two numbers"),
    "gravity-scalar": four("joints:", "gravity: 9.81\njoints:", 2, "a list of two numbers"),
    # geometry
    "dyad-open": four(
        "0.12", "0.001", 7, "cannot be assembled", "coupler and rocker", "cannot meet at B",
        "expected between 0.079 m and 0.081 m",
    ),
    "dyad-open-slider": crank("0.14", "0.001", 5, "cannot be assembled", "axis of piston"),
    "loop-open": four("[0.1, 0]", "[10, 0]", 7, "cannot be assembled", "apart at t = 0"),
    "side-missing": four(
        "assembly:\n  B: left\n", "", 1, "joint B can be in two places", "'B: left'", "'B: right'"
    ),
    "hint-halfway": four("B: left", HALFWAY, 12, "as near to one possible place"),
    "side-of-slider-pin": crank("B: [0.18, 0]", "B: left", 11, "moves along an axis"),
    "side-of-crank-pin": four("B: left", "A: left", 12, "one possible place only"),
    # mobility
    "two-drives": four(
        "assembly:\n  B: left", "  rocker: {angle: 1, speed: 1}", 11,
        "mobility is 1, but 2 coordinates are driven (crank, rocker) and 0 free; remove 1 of them",
        "the constraints at B contradict each other",
    ),
    "no-drive": four(
        "drives:\n  crank: {angle: 0.7, speed: 6}\n", "", 1, "mobility is 1", "add a drive"
    ),
    "driven-and-free": four(
        "assembly:", "free:\n  crank: {angle: 0}\nassembly:", 10, "both driven and free"
    ),
    "over-constrained": four(
        "drives:", "  strut: {joints: [O4, A], length: 0.09}\ndrives:", 9,
        "the constraints at A contradict each other",
    ),
    "unreachable": four(
        "drives:", "  loose: {joints: [X, Y], length: 1}\ndrives:", 9, "not connected to the ground"
    ),
    "nothing-moves": Case("name: x\njoints: {O: [0, 0]}\n", ("expected bars",), 1),
    # names that do not exist, or twice
    "joint-twice": four("[O2, A]", "[A, A]", 6, "two different joints", "'A' twice"),
    "joint-of-slider": crank("joint: B,", "joint: Bb,", 7, "unknown joint 'Bb'; did you mean 'B'"),
    "joint-of-axis": crank("through: O,", "through: B,", 7, "unknown ground joint 'B'", ": O"),
    "joint-of-clearance": clearance("{joint: Z, bar: crank, size: 1e-4}", 10, "joint 'Z'"),
    "joint-of-assembly": four("  B: left", "  C: left", 12, "unknown joint 'C'"),
    "bar-of-drive": four("  crank: {ang", "  cank: {ang", 10, "did you mean 'crank'?"),
    "bar-of-clearance": clearance(
        "{joint: A, bar: cuopler, size: 1e-4}", 10, "did you mean 'coupler'?"
    ),
    "slider-of-load": crank("slider: piston", "slider: pistn", 13, "did you mean 'piston'?"),
    "load-on-bar": crank("slider: piston,", "bar: rod,", 13, "loads[0]", "missing key 'torque'"),
    "clearance-elsewhere": clearance(
        "{joint: O2, bar: coupler, size: 1e-4}", 10, "has no joint 'O2'; it has A, B"
    ),
    "clearance-size-zero": clearance("{joint: A, bar: crank, size: 0}", 10, "a length > 0"),
    "name-taken": crank("piston:", "rod:", 7, "the name 'rod' is taken"),
    "name-ground": four("crank: {joints", "ground: {joints", 6, "stands for the frame"),
    # names made to break out of what is generated from them
    "name-code": four("crank: {joints", "'x]; import os': {joints", 6, BAD_NAME),
    "name-import": four("crank: {joints", "\"__import__('os')\": {joints", 6, BAD_NAME),
    "name-newline": four("crank: {joints", '"a\\nb": {joints', 6, BAD_NAME, "'a\\nb'"),
    "name-dots": four("crank: {joints", "../../x: {joints", 6, BAD_NAME),
    "name-long": four("crank: {joints", f"{LONG}: {{joints", 6, BAD_NAME, "(500 characters)"),
    "name-joint": four("O2: [0", "'O[2': [0", 3, BAD_NAME),
    "title-newline": four("name: Four-bar", 'name: "a\\nb"', 1, "one line of text"),
    "title-list": four("name: Four-bar", "name: [a]", 1, "one line of text"),
    # the simulate section
    "method-unknown": four("end: 0.2", "method: rk5, end: 0.2", 13, "'rk5'", "one of: dop853"),
    "rk4-without-step": four("end: 0.2", "method: rk4, end: 0.2", 13, "needs a step"),
    "rk4-tiny-step": four(
        "end: 0.2", "method: rk4, step: 1e-300, end: 0.2", 13, "step 1e-300 s needs more than"
    ),
    "free-without-mass": Case(
        "joints: {O: [0, 0]}\nbars:\n  rod: {joints: [O, P], length: 1}\n"
        "free:\n  rod: {angle: 1}\n",
        ("no mass moves with rod",),
        5,
    ),
    "end-astronomic": Case(
        FOUR_BAR.replace("end: 0.2", "end: 1e300"), (
            "places are looked at on the way; expected a slower drive, a shorter time",
        )
    ),
    "samples-1": four("samples: 11", "samples: 1", 13, "at least 2", "found 1"),
    "samples-0": four("samples: 11", "samples: 0", 13, "a whole number > 0"),
    "samples-negative": four("samples: 11", "samples: -3", 13, "a whole number > 0"),
    "samples-fraction": four("samples: 11", "samples: 2.5", 13, "a whole number > 0"),
    "samples-huge": four("samples: 11", "samples: 1e15", 13, "at most", "found 1e+15"),
    "samples-text": four("samples: 11", f"samples: {'9' * 5000}", 13, "(5000 characters)"),
    "end-0": four("end: 0.2", "end: 0", 13, "a time > 0"),
    "end-negative": four("end: 0.2", "end: -1", 13, "a time > 0"),
    "end-nan": four("end: 0.2", "end: nan", 13, "a time > 0"),
    "rtol-tiny": four("end: 0.2", "end: 0.2, rtol: 1e-30", 13, "rtol", "found 1e-30"),
    # text that is no definition
    "duplicate-key": four(
        "  crank: {angle", "  crank: {angle: 0, speed: 1}\n  crank: {angle", 11,
        "duplicate key 'crank', first given in line 10",
    ),
    "empty": Case("", ("the file is empty",)),
    "comments-only": Case("# nothing\n# here\n", ("the file is empty",)),
    "list": Case("- a\n- b\n", ("expected a mapping", "a list of 2"), 1),
    "scalar": Case("mechanism\n", ("expected a mapping", "'mechanism'"), 1),
    "section-is-list": four("drives:\n", "drives: [1]\nx:\n", 9, "expected a mapping such as"),
    "section-is-mapping": crank("  - {slider", "    {slider", 12, "expected a list such as [{"),
    "tab": Case("joints:\n\tO: [0, 0]\n", ("not valid YAML",), 2),
    "bracket": four("O2: [0, 0]", "O2: [0, 0", 4, "not valid YAML", "starts in line 3"),
    "anchor-bomb": Case(BOMB, ("aliases expand to more than",), 1),
    "nested": Case("a: " + "[" * 5000, ("nested more than",), 1),
    "python-tag": Case("a: !!python/object/apply:os.system ['touch x']\n", ("not allowed",), 1),
    "two-documents": Case(FOUR_BAR + "---\n" + FOUR_BAR, ("a second document",), 14),
    "binary": Case(bytes(range(256)), ("is not text",), 3),
    "latin-1": Case(FOUR_BAR.replace("Four", "Fünf").encode("latin-1"), ("0xfc", "UTF-8"), 1),
    # files
    "missing-file": Case(None, ("did you mean 'ninebar'?",), file="nineber.yaml"),
    "directory": Case(None, ("is a directory",), file="."),
    # arguments
    "set-malformed": args("--set", "x", expected=("expected path=value",), source="--set"),
    "set-path": args("--set", "bars..x=1", expected=("expected path=value",), source="--set"),
    "set-unknown-key": args(
        "--set", "simulate.edn=1", expected=("did you mean 'end'?", "(from set simulate.edn=1)")
    ),
    "set-unknown-bar": args("--set", "drives.cank.angle=1", expected=("did you mean 'crank'?",)),
    "set-value": args(
        "--set", "bars.crank.length=-1", expected=("a length > 0", "from set bars.crank.length=-1")
    ),
    "set-index": args(
        "--set", "loads[3].force=1", text=SLIDER_CRANK, expected=("loads has 1 entry",)
    ),
    "set-tag": args("--set", "gravity=!!python/name:os.system x", expected=("not allowed",)),
    "format": args("--format", "texx", verb="equations", expected=("'text'",), source="--format"),
    "output-unknown": args("--outputs", "bar_angel", expected=("did you mean 'bar_angle'?",)),
    "output-absent": args("--outputs", "slider_position", expected=("has no slider_position",)),
    "out-is-file": args("--out", "m.yaml", expected=("expected a folder", "found a file")),
    "out-below-file": args("--out", "m.yaml/x", expected=("expected a folder", "found a file")),
    "change-points-unknown": args(
        "--change-points", "go", expected=("pass", "stop"), source="change-points"
    ),
    "modes-out-is-file": args(
        "--out", "m.yaml", verb="check", expected=("expected a folder", "found a file")
    ),
    "option-unknown": args("--nope", expected=("No such option",), source="simulate"),
    "verb-unknown": args(verb="simulat", expected=("'simulate'",), source="linkages"),
}  # fmt: skip


@pytest.mark.slow_except("key-*", "side-*", "*-missing", "unit-*")
@pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())
def test_report_exit_code_and_nothing_written(case, cli, tmp_path):
    if case.text is not None:
        data = case.text if isinstance(case.text, bytes) else case.text.encode()
        (tmp_path / case.file).write_bytes(data)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    result = cli(case.verb, case.file, *case.arguments)
    assert result.code == 2
    assert result.out == ""
    for fragment in (case.source or case.file, *case.expected):
        assert fragment in result.err
    lines = [int(line) for line in re.findall(r"^  line (\d+), column \d+", result.err, re.M)]
    assert lines == sorted(lines)
    assert (case.line in lines) if case.line else not lines
    assert "Traceback" not in result.err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize("case", ["name-newline", "name-long", "samples-text", "title-newline"])
def test_what_was_found_is_shown_on_one_short_line(case, cli, tmp_path):
    (tmp_path / "m.yaml").write_text(CASES[case].text)
    head, *problems = cli("check", "m.yaml").err.splitlines() or ["m.yaml"]
    assert head.startswith("m.yaml")
    assert all(line.startswith("  line ") and len(line) < 400 for line in problems)


MANY = """\
name: [Four-bar]
joints:
  O2: [0, zero]
  O4: [100 mm, 0]
bars:
  crank:   {joints: [O2, A], length: -40 mm, mass: 0.15}
  coupler: {joints: [A, B], lenght: 0.12}
  rocker:  {joints: [O4, B], length: 3 kg}
drives:
  cranc: {angle: 40 deg, speed: 60 rpm}
assembly:
  B: lft
simulate: {end: -1, samples: 2.5}
"""


def test_all_problems_at_once_in_the_order_of_the_file(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(MANY)
    length = "expected a length > 0 (metres, or with a unit)"
    places = "a list of two numbers (metres, or with units), such as [0.3, 0.4]"
    assert cli("simulate", "m.yaml").err.splitlines() == [
        "m.yaml: 10 problems",
        "  line 1, column 1, name: expected one line of text",
        "  line 3, column 11, joints.O2[1]: expected a length (metres, or with a unit), "
        "found 'zero': expected a number before 'zero'",
        f"  line 6, column 30, bars.crank.length: {length}, found '-40 mm'",
        f"  line 7, column 3, bars.coupler: missing key 'length': {length}",
        "  line 7, column 29, bars.coupler.lenght: unknown key 'lenght'; did you mean 'length'?",
        f"  line 8, column 30, bars.rocker.length: {length}, "
        "found '3 kg': kg is a mass, not a length",
        "  line 10, column 3, drives.cranc: unknown bar 'cranc'; did you mean 'crank'?",
        "  line 12, column 3, assembly.B: expected 'left' or 'right' or "
        f"{places}, found 'lft'; did you mean 'left'?",
        "  line 13, column 12, simulate.end: expected a time > 0 (seconds, or with a unit), "
        "found '-1'",
        "  line 13, column 21, simulate.samples: expected a whole number > 0, found '2.5'",
    ]


@pytest.mark.parametrize("verb", ["check", "equations"])
def test_other_verbs_report_the_same(verb, cli, tmp_path):
    (tmp_path / "m.yaml").write_text(MANY)
    result = cli(verb, "m.yaml")
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("m.yaml: 10 problems\n")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_folder_that_cannot_be_written(cli, tmp_path):
    (tmp_path / "m.yaml").write_text(FOUR_BAR)
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    cli.refused("simulate", "m.yaml", "--out", "locked/x", says="cannot be written")


@pytest.mark.slow
@pytest.mark.parametrize("case", ["python-tag", "name-code", "missing-file"])
def test_as_a_process_of_its_own(case, tmp_path):
    found = CASES[case]
    if found.text is not None:
        (tmp_path / found.file).write_text(found.text)
    before = sorted(os.listdir(tmp_path))
    done = subprocess.run(
        [sys.executable, "-m", "linkages", found.verb, found.file],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert all(fragment in done.stderr for fragment in (found.file, *found.expected))
    assert "Traceback" not in done.stderr
    assert sorted(os.listdir(tmp_path)) == before
