"""What holds for all tests: none depends on how busy the machine is, or on what ran before it."""

import os
import signal
import sys
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# A stall of the machine is no property of an example; the same examples are drawn in every run.
settings.register_profile(
    "any machine",
    deadline=None,
    derandomize=True,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("any machine")

# What shells and services say of a terminal that tests do not have: rich and typer believe it.
TERMINAL = ("FORCE_COLOR", "NO_COLOR", "PY_COLORS", "COLUMNS", "TTY_COMPATIBLE", "GITHUB_ACTIONS")


def pytest_configure(config: pytest.Config) -> None:
    """Forget the terminal, let Ctrl-C be heard, and matplotlib find its fonts before workers start.

    A shell has its background jobs ignore Ctrl-C: tests that press it would run for ever.

    Fonts are looked for once for each user. Where that takes longer than five seconds matplotlib
    says so on standard error, where programs that tests start must have nothing to say.
    """
    for name in TERMINAL:
        os.environ.pop(name, None)
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if not hasattr(config, "workerinput"):
        import matplotlib.font_manager  # noqa: F401


@pytest.hookimpl(tryfirst=True)  # before tests are selected by their marks
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what the closest `slow_except` does not name as slow, and find names of nothing."""
    given, used = set(), set()
    for item in items:
        if mark := item.get_closest_marker("slow_except"):
            parameters = item.callspec.id if hasattr(item, "callspec") else ""
            found = {name for name in mark.args if fnmatchcase(parameters, name)}
            test = item.nodeid.partition("[")[0]
            given.update((test, name) for name in mark.args)
            used.update((test, name) for name in found)
            if not found:
                item.add_marker(pytest.mark.slow)
    # a test that is asked for by its name may leave others of the same function out
    if given - used and not any("::" in argument for argument in config.args):
        raise pytest.UsageError(f"slow_except names no parameters: {sorted(given - used)}")


@dataclass(frozen=True)
class Result:
    """What a command left behind: `files` are all paths below the folder it ran in, but records."""

    code: int
    out: str
    err: str
    files: frozenset[str]


def files_below(folder: Path) -> frozenset[str]:
    paths = (path.relative_to(folder) for path in folder.rglob("*"))
    return frozenset(str(path) for path in paths if ".linkages" not in path.parts)


class CommandLine:
    """`python -m linkages ARGUMENTS` in this process, with an empty folder as the working one."""

    def __init__(self, folder, monkeypatch, capsys) -> None:
        monkeypatch.chdir(folder)
        self.folder, self.monkeypatch, self.capsys = folder, monkeypatch, capsys

    def __call__(self, *arguments: str) -> Result:
        from linkages.cli.main import main

        self.monkeypatch.setattr(sys, "argv", ["linkages", *arguments])
        self.capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main()
        captured = self.capsys.readouterr()
        code = caught.value.code or 0
        return Result(code, captured.out, captured.err, files_below(self.folder))

    def refused(self, *arguments: str, says: str, files: set[str] | None = None) -> str:
        """The message about input that is wrong, which `says` is in, and which files are left."""
        result = self(*arguments)
        assert (result.code, result.out) == (2, "")
        assert says in result.err
        assert files is None or result.files == files
        return result.err


@pytest.fixture
def cli(tmp_path, monkeypatch, capsys):
    return CommandLine(tmp_path, monkeypatch, capsys)
