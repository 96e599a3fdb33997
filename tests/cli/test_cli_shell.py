"""In a shell: completion, quiet and verbose, lines that nothing breaks."""

import os
import subprocess
import sys

import pytest

from linkages.cli.terminal import be_quiet, console, table
from linkages.cli.verb import complete_file
from linkages.reading.document import shipped
from linkages.reports.report import Table

SHORT = ("--no-figures", "--set", "simulate.end=0.02", "--set", "simulate.samples=21")


@pytest.fixture(autouse=True)
def _loud_again():
    yield
    be_quiet(False)


def shell(folder, *arguments, **environment):
    """The program as a shell starts it; returns the finished process."""
    return subprocess.run(
        [sys.executable, "-m", "linkages", *arguments],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        encoding="utf-8",
        check=False,
    )


# completion


def test_files_and_mechanisms_are_completed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("nice.yaml", "nicer.yml", "notes.txt", ".nobody.yaml"):
        (tmp_path / name).write_text("")
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / "inner.yaml").write_text("")
    own = [f"new{os.sep}", "nice.yaml", "nicer.yml"]
    assert complete_file("n") == [*own, *(name for name in shipped() if name.startswith("n"))]
    assert complete_file(f"new{os.sep}") == [os.path.join("new", "inner.yaml")]
    assert complete_file(".n") == [".nobody.yaml"]
    assert complete_file("nowhere/x") == []
    assert set(shipped()) <= set(complete_file(""))


@pytest.mark.slow
def test_shell_gets_completions(tmp_path):
    """As bash asks for them: the line so far, and which word of it."""
    # the module has another name for shells; the installed program has this one
    script = "import sys; sys.argv = ['linkages']; from linkages.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path,
        env={
            **os.environ,
            "_LINKAGES_COMPLETE": "complete_bash",
            "COMP_WORDS": "linkages check nine",
            "COMP_CWORD": "2",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout.split() == [name for name in shipped() if name.startswith("nine")]


@pytest.mark.slow
def test_completion_is_installed_for_the_program(tmp_path):
    """`python -m linkages --install-completion bash` completes `linkages`."""
    done = shell(
        tmp_path, "--install-completion", "bash",
        HOME=str(tmp_path), _TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION="1",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    script = tmp_path / ".bash_completions" / "linkages.sh"
    assert "_LINKAGES_COMPLETE=complete_bash" in script.read_text(encoding="utf-8")
    assert str(script) in (tmp_path / ".bashrc").read_text(encoding="utf-8")


# how much is said


def test_quiet_says_nothing_and_writes_everything(cli):
    result = cli("--quiet", "simulate", "slider-crank", *SHORT)
    assert (result.code, result.out, result.err) == (0, "", "")
    assert os.path.join("results", "slider-crank", "simulate.nc") in result.files
    # the next run in the same process is not quiet
    assert cli("list").out


def test_quiet_still_reports_errors_and_prints_json(cli):
    result = cli("-q", "check", "nine-bar")
    assert (result.code, result.out) == (2, "")
    assert "did you mean" in result.err
    assert cli("-q", "check", "four-bar", "--json").out.startswith("{")
    assert cli("-q", "equations", "four-bar").out


def test_verbose_says_what_is_read_and_written_on_standard_error(cli):
    loud = cli("-v", "simulate", "slider-crank", *SHORT)
    plain = cli("simulate", "slider-crank", *SHORT)
    assert loud.out == plain.out
    assert plain.err == ""
    lines = loud.err.splitlines()
    assert lines[0].split("  ")[-1].startswith("linkages ")
    assert any(f"reading {shipped()['slider-crank']}" in line for line in lines)
    assert sum("wrote " in line for line in lines) == 2


@pytest.mark.slow
def test_verbose_names_kernels_and_integrations(tmp_path):
    """In a process of its own: this one may have loaded the kernel before."""
    err = shell(tmp_path, "-v", "simulate", "ninebar", "--no-verify", *SHORT).stderr
    assert "kernel " in err
    assert "dop853 from t = 0 s to 0.02 s: " in err


def test_quiet_and_verbose_exclude_each_other(cli):
    result = cli("-q", "-v", "list")
    assert (result.code, result.out) == (2, "")
    assert "--quiet and --verbose" in result.err


# lines


def test_no_line_of_a_file_is_wrapped_or_filled_up(capsys):
    """A pipe has no width: tables are as wide as they are, and end where their text ends."""
    heads = [f"a rather long head {index}" for index in range(40)]
    console().print(table(Table("Wide", heads, [["0.123456"] * 40, ["x"] * 40])))
    title, head, numbers, letters = capsys.readouterr().out.splitlines()
    assert title == "Wide"
    assert all(name in head for name in heads)
    assert numbers.count("0.123456") == 40
    assert not any(line.endswith(" ") for line in (title, head, numbers, letters))


def test_numbers_are_not_broken_on_a_narrow_terminal():
    rows = [["a name of many words that needs room " * 2, "-0.000104353", "1.387780e-17"]]
    narrow = console()
    narrow.width = 60
    with narrow.capture() as capture:
        narrow.print(table(Table("T", ["quantity", "value", "residual"], rows)))
    assert "-0.000104353" in capture.get()
    assert "1.387780e-17" in capture.get()
