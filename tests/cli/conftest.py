"""Running the command line in this process, in an empty folder."""

import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from linkages.cli.main import main


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


@pytest.fixture
def cli(tmp_path, monkeypatch, capsys):
    """Run `python -m linkages ARGUMENTS` with `tmp_path` as the working directory."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Result:
        monkeypatch.setattr(sys, "argv", ["linkages", *arguments])
        capsys.readouterr()
        with pytest.raises(SystemExit) as caught:
            main()
        captured = capsys.readouterr()
        code = caught.value.code or 0
        return Result(code, captured.out, captured.err, files_below(tmp_path))

    return run
