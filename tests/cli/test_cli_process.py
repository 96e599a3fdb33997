"""The command line as a process: what is imported, pipes, encodings, colours."""

import json
import os
import subprocess
import sys

import pytest

from linkages.reading.document import shipped

pytestmark = pytest.mark.slow_except()

WATCHED = ("numpy", "llvmlite", "xarray", "sympy", "matplotlib", "matplotlib.pyplot", "scipy")
IMPORTS = f"""
import json, sys
from linkages.cli.main import main
try:
    main()
except SystemExit as done:
    assert not done.code, done.code
print(json.dumps([name for name in {WATCHED!r} if name in sys.modules]), file=sys.stderr)
"""


def start(*arguments, folder, code=None, **environment):
    command = ["-c", code] if code else ["-m", "linkages"]
    return subprocess.run(
        [sys.executable, *command, *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        check=False,
    )


@pytest.mark.slow_except("--help*", "list*")
@pytest.mark.parametrize(
    ("arguments", "unwanted"),
    [
        ("--help", set(WATCHED)),
        ("simulate --help", set(WATCHED)),
        ("list", set(WATCHED)),
        ("simulate four-bar --no-figures", {"llvmlite", "sympy", "matplotlib"}),
        ("simulate four-bar", {"llvmlite", "sympy", "matplotlib.pyplot"}),
        ("simulate ninebar --no-figures --set simulate.end=0.01", {"sympy", "matplotlib"}),
        ("check ninebar", {"llvmlite", "sympy", "matplotlib", "xarray"}),
    ],
)
def test_what_is_not_needed_is_not_imported(arguments, unwanted, tmp_path):
    done = start(*arguments.split(), folder=tmp_path, code=IMPORTS)
    imported = set(json.loads(done.stderr.splitlines()[-1]))
    assert not imported & unwanted


MODULES = """
import sys
from linkages.cli.main import main
try:
    main()
except SystemExit as done:
    assert not done.code, done.code
print(sum(name.partition(".")[0] == "linkages" for name in sys.modules), file=sys.stderr)
"""


@pytest.mark.slow_except("simulate")
@pytest.mark.parametrize(
    ("arguments", "most"),
    [("simulate ninebar --no-figures --set simulate.end=0.01", 154)],
    ids=["simulate"],
)
def test_modules_that_a_scene_does_not_need_are_not_imported(arguments, most, tmp_path):
    """A new one is needed by all motions, or it is imported where it is used."""
    done = start(*arguments.split(), folder=tmp_path, code=MODULES)
    assert int(done.stderr.splitlines()[-1]) <= most


@pytest.mark.slow_except("list")
@pytest.mark.parametrize("arguments", ["check ninebar --json", "list", "equations four-bar"])
def test_reader_that_leaves_early(arguments, tmp_path):
    """`python -m linkages ... | head -c 1`: the reader is gone before anything is written."""
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "wb") as pipe:
        done = subprocess.run(
            [sys.executable, "-m", "linkages", *arguments.split()],
            cwd=tmp_path,
            stdout=pipe,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert (done.returncode, done.stderr) == (1, b"")


def test_head(tmp_path):
    command = f"'{sys.executable}' -m linkages check ninebar | head -n 1"
    done = subprocess.run(command, shell=True, cwd=tmp_path, capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"Nine-bar press mechanism\n", b"")


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")
def test_full_disk_is_said_in_one_line(tmp_path):
    with open("/dev/full", "wb") as full:
        done = subprocess.run(
            [sys.executable, "-m", "linkages", "check", "four-bar"],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            check=False,
        )
    assert done.returncode == 1
    assert done.stderr.startswith(b"cannot be written: ")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.parametrize("colour", [{"NO_COLOR": "1"}, {}], ids=["no-color", "pipe"])
def test_no_escape_codes_where_nobody_wants_them(colour, tmp_path):
    done = start("check", "four-bar", folder=tmp_path, **colour)
    assert done.returncode == 0
    assert b"\x1b" not in done.stdout + done.stderr


def test_no_color_is_kept_on_a_terminal(tmp_path):
    """FORCE_COLOR makes rich believe in a terminal; bold may stay, colours may not."""
    done = start("check", "four-bar", folder=tmp_path, FORCE_COLOR="1", NO_COLOR="1")
    assert b"\x1b[3" not in done.stdout.replace(b"\x1b[3m", b"")  # italic is no colour


def test_terminal_without_unicode(tmp_path):
    done = start("check", "ninebar", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, b"")
    (tmp_path / "m.yaml").write_text(
        shipped()["four-bar"].read_text().replace("name: Four", "name: Fünf"), encoding="utf-8"
    )
    done = start("check", "m.yaml", "--json", folder=tmp_path, PYTHONIOENCODING="ascii")
    assert json.loads(done.stdout)["mechanism"].startswith("Fünf")


def test_works_from_anywhere_by_name_and_by_path(tmp_path):
    outputs = [
        start("check", file, "--json", folder=tmp_path).stdout
        for file in ("ninebar", "ninebar.yaml", str(shipped()["ninebar"]))
    ]
    assert json.loads(outputs[0])["mechanism"] == "Nine-bar press mechanism"
    assert outputs[0] == outputs[1] == outputs[2]
