"""Run the examples of README.md and of the pages here, and put their real output into the text.

    python docs/make/examples.py                 # rewrites every output that is out of date

Conventions, checked by tests/docs/test_docs_examples.py:

* A ``yaml`` block whose first line is ``# NAME.yaml`` is a whole definition: it is written to a
  file of that name, loaded and assembled. Any other ``yaml`` block is a fragment and is parsed.
* A ``console`` block holds commands after ``$ `` and their output. A command must succeed, unless
  the next one is ``$ echo $?``, which shows its exit code.
* A ``python`` block is executed; a ``text`` block right after it is what it prints.
* A line ``...`` in an output stands for any number of lines.

All blocks of a page share one folder and one Python namespace. ``sh`` blocks are not run.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1]
ROOT = DOCS.parent
_FENCE = re.compile(r"^```(yaml|console|python|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_FILE = re.compile(r"# ([\w-]+\.yaml)\b")
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:e[-+]?\d+)?")
# Round-off and numbers of steps differ between machines; elsewhere 2 % is a different result.
_LOOSE = ("residual", "closure error", "evaluations", " runs", "optimality")
_RELATIVE = 0.02


@dataclass(frozen=True)
class Output:
    """An output as the page shows it, and as it is."""

    example: str
    shown: str
    found: str

    @property
    def agrees(self) -> bool:
        """Whether both are the same up to round-off and to what was left out."""
        shown, found = self.shown.splitlines(), _abridged(self.found, self.shown).splitlines()
        return len(shown) == len(found) and all(map(_same, shown, found))


def pages() -> list[Path]:
    """README.md, CONTRIBUTING.md and all pages."""
    built = DOCS / "_build"
    found = [page for page in sorted(DOCS.rglob("*.md")) if built not in page.parents]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *found]


def run(page: Path, folder: Path) -> tuple[str, list[Output]]:
    """Run a page in a folder; returns its text with real outputs, and all outputs."""
    text = page.read_text(encoding="utf-8")
    outputs: list[Output] = []
    namespace: dict[str, object] = {"__name__": "example"}
    parts, done, printed, code_end = [], 0, None, 0
    before = Path.cwd()
    os.chdir(folder)
    try:
        for match in _FENCE.finditer(text):
            kind, content = match.groups()
            if kind == "yaml":
                _read(content, folder)
            elif kind == "console":
                found = list(_console(content))
                outputs += found
                new = "".join(f"$ {o.example}\n{_abridged(o.found, o.shown)}" for o in found)
                parts += [text[done : match.start(2)], new]
                done = match.end(2)
            elif kind == "python":
                printed, code_end = _executed(content, namespace), match.end()
            elif printed is not None and not text[code_end : match.start()].strip():
                outputs.append(Output("python", content, printed))
                parts += [text[done : match.start(2)], _abridged(printed, content)]
                done, printed = match.end(2), None
    finally:
        os.chdir(before)
    return "".join([*parts, text[done:]]), outputs


def _read(content: str, folder: Path) -> None:
    from linkages import load
    from linkages.kernel.system import System
    from linkages.reading.document import parse

    name = _FILE.match(content)
    if name is None:
        parse(content, "fragment")
        return
    file = folder / name[1]
    file.write_text(content, encoding="utf-8")
    System(load(file))


def _console(content: str) -> Iterator[Output]:
    code = 0
    commands = [part for part in re.split(r"^\$ ", content, flags=re.MULTILINE) if part]
    for index, command in enumerate(commands):
        line, _, shown = command.partition("\n")
        following = commands[index + 1].strip() if index + 1 < len(commands) else ""
        if line == "echo $?":
            found = f"{code}\n"
        else:
            found, code = _command(shlex.split(line))
            if code != 0 and not following.startswith("echo $?"):
                raise AssertionError(f"'{line}' ended with exit code {code}:\n{found}")
        yield Output(line, shown, found)


def _command(words: list[str]) -> tuple[str, int]:
    if words[0] == "ls":
        shown = sorted(name for name in os.listdir(words[1]) if not name.startswith("."))
        return "".join(f"{name}\n" for name in shown), 0
    if words[:3] != ["python", "-m", "linkages"]:
        raise AssertionError(f"do not know how to run {words[0]!r}")
    from linkages.cli.main import main

    stream, errors, arguments = io.StringIO(), io.StringIO(), sys.argv
    sys.argv = ["linkages", *words[3:]]
    try:
        with contextlib.redirect_stdout(stream), contextlib.redirect_stderr(errors):
            main()
        code: object = 0
    except SystemExit as end:
        code = end.code or 0
    finally:
        sys.argv = arguments
    # messages follow results; a progress bar, shown by slow runs only, leaves blank lines
    messages = [line for line in errors.getvalue().splitlines() if line.strip()]
    return _tidy(stream.getvalue()) + _tidy("\n".join(messages)), int(str(code))


def _executed(content: str, namespace: dict[str, object]) -> str:
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(content, "<example>", "exec", dont_inherit=True), namespace)
    return _tidy(stream.getvalue())


def _tidy(text: str) -> str:
    lines = [line.rstrip() for line in text.splitlines()]
    while lines and not lines[-1]:
        lines.pop()
    return "".join(f"{line}\n" for line in lines)


def _abridged(found: str, shown: str) -> str:
    """What was found, with the same number of lines left out as what is shown."""
    lines, wanted = found.splitlines(), shown.splitlines()
    if "..." not in wanted:
        return found
    head = wanted.index("...")
    tail = len(wanted) - head - 1
    kept = [*lines[:head], "...", *(lines[-tail:] if tail else [])]
    return "".join(f"{line}\n" for line in kept)


def _same(shown: str, found: str) -> bool:
    if _NUMBER.sub("#", " ".join(shown.split())) != _NUMBER.sub("#", " ".join(found.split())):
        return False
    if any(word in shown for word in _LOOSE):
        return True
    pairs = zip(_NUMBER.findall(shown), _NUMBER.findall(found), strict=True)
    return all(abs(float(a) - float(b)) <= max(1e-12, _RELATIVE * abs(float(a))) for a, b in pairs)


def main() -> None:
    """Rewrite the pages whose outputs are out of date."""
    wanted = [Path(name).resolve() for name in sys.argv[1:]] or pages()
    for page in wanted:
        with tempfile.TemporaryDirectory() as folder:
            text, outputs = run(page, Path(folder))
        stale = [output.example for output in outputs if not output.agrees]
        if stale:
            page.write_text(text, encoding="utf-8")
        print(f"{page.relative_to(ROOT)}: {len(outputs)} outputs, {len(stale)} rewritten")


if __name__ == "__main__":
    main()
