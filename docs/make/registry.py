"""What is made for the pages: outputs with the functions that make them, and how they are kept.

A function that `makes` outputs returns one for each of their names. A name with a suffix is a file
in docs/_static, any other one a table on pages:

* a Matplotlib figure, written as SVG, or as PNG with a palette of its own;
* a picture of Pillow, such as one that a command drew;
* text, which goes between the marks of a table on all pages that have them;
* a dictionary of measured numbers, kept as JSON with machine and date;
* the path of a file that the function has written itself.
"""

from __future__ import annotations

import datetime
import importlib
import json
import math
import os
import platform
import re
import resource
import sys
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from multiprocessing import Lock
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import linkages
from linkages.components.mechanisms.definition import from_document
from linkages.plots.figures import write_figure
from linkages.plots.style import style, styled
from linkages.reading.document import parse

SCRIPTS = Path(__file__).resolve().parent
DOCS = SCRIPTS.parent
ROOT = DOCS.parent
STATIC = DOCS / "_static"
# programs that other figures are compared with
sys.path += [str(ROOT / "tests" / folder) for folder in ("", "oracle", "benchmarks")]
PIXELS = 1408
"""Width of dense figures: twice the text of a page."""

COLOURS = 64
DIGITS = 4
"""Of numbers that are kept."""


@dataclass(frozen=True)
class Maker:
    """A function, the outputs that it returns, and the file of numbers that it draws.

    `colours`: of the palette of a PNG; None for a picture in full colour.
    """

    outputs: tuple[str, ...]
    function: Callable[..., object]
    numbers: str | None
    colours: int | None

    @property
    def script(self) -> str:
        """Its file, from docs/make on."""
        function = getattr(self.function, "func", self.function)  # of a partial one
        return f"{function.__module__.removeprefix('make.').replace('.', '/')}.py"

    @property
    def measures(self) -> bool:
        """Whether it only keeps numbers, which is asked for by their name alone."""
        return all(name.endswith(".json") for name in self.outputs)

    @property
    def stage(self) -> int:
        """Numbers come before figures and tables, and last those that are made of numbers."""
        return 0 if self.measures else 1 if self.numbers is None else 2

    def make(self) -> float:
        """Make all outputs and keep them; returns the processor time in seconds."""
        before = _spent()
        given = () if self.numbers is None else (kept(self.numbers),)
        made = styled(self.function)(*given)
        parts = made if isinstance(made, tuple) else (made,)
        for name, one in zip(self.outputs, parts, strict=True):
            keep(name, one, self.colours)
        return _spent() - before


MAKERS: list[Maker] = []
PAGES = Lock()
"""Held while a page or kept numbers change: several processes may make what is on one page."""


def _spent() -> float:
    """Processor time of this process and of those that it waited for."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def makes(
    *outputs: str, numbers: str | None = None, colours: int | None = COLOURS
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register a function, which is run in the style of figures, as what makes outputs.

    `numbers`: the file in docs/_static whose content the function takes.
    """

    def registered(function: Callable[..., Any]) -> Callable[..., Any]:
        MAKERS.append(Maker(outputs, function, numbers, colours))
        return function

    return registered


def makes_each(
    cases: Mapping[tuple[str, ...], tuple[Any, ...]], *, colours: int | None = COLOURS
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Register a function as what makes outputs with arguments of their own."""

    def registered(function: Callable[..., Any]) -> Callable[..., Any]:
        for outputs, arguments in cases.items():
            makes(*outputs, colours=colours)(partial(function, *arguments))
        return function

    return registered


def discovered() -> list[Maker]:
    """All makers in the order in which they run; imports every script."""
    for file in sorted(SCRIPTS.rglob("*.py")):
        if not file.stem.startswith("__"):
            module = ".".join(file.relative_to(DOCS).with_suffix("").parts)
            importlib.import_module(module)
    return sorted(MAKERS, key=lambda maker: (maker.stage, maker.script))


def pages() -> list[Path]:
    """README.md and the pages."""
    built = DOCS / "_build"
    found = [page for page in sorted(DOCS.rglob("*.md")) if built not in page.parents]
    return [ROOT / "README.md", *found]


def shown() -> dict[str, list[str]]:
    """Output → the pages that show it, as pictures or as tables."""
    found: dict[str, list[str]] = {}
    for page in pages():
        text = page.read_text(encoding="utf-8")
        names = re.findall(r"_static/([\w./-]+\.\w+)[)\s]", text)
        names += (f"../notebooks/{name}" for name in re.findall(r"\]\(([\w-]+\.ipynb)\)", text))
        names += re.findall(r"^<!-- table: ([\w-]+) -->$", text, re.MULTILINE)
        for name in dict.fromkeys(names):
            # the first page is README.md
            where = "index.md" if page.parent == ROOT else page.relative_to(DOCS).as_posix()
            found.setdefault(name, []).append(where)
    return found


FOLDERS = re.compile(r"^(\./)?docs/(_static/|make/)?")
"""What may stand before names, as a shell completes them."""


def selected(names: Iterable[str], makers: list[Maker]) -> list[Maker]:
    """The makers of outputs, scripts and pages with these names, or patterns of names.

    Raises ValueError for names of nothing.
    """
    places, chosen, unknown = shown(), set(), []
    for name in names:
        found = {maker for maker in makers if _named(maker, FOLDERS.sub("", name), places)}
        chosen |= found
        unknown += [] if found else [name]
    if unknown:
        raise ValueError(f"{', '.join(unknown)}: no output, script or page of the table")
    return [maker for maker in makers if maker in chosen]


def _named(maker: Maker, wanted: str, places: dict[str, list[str]]) -> bool:
    own = [*maker.outputs]
    if not maker.measures:
        own += [maker.script, *(page for name in maker.outputs for page in places.get(name, []))]
        own += [Path(name).stem for name in own]
    return any(fnmatchcase(name, wanted) for each in own for name in (each, Path(each).name))


# -- the table of all outputs -----------------------------------------------------------------

LIST = DOCS / "figures.md"
ROW = re.compile(r"^\| (`.*?`) \|.*\| (\S+) \|$", re.MULTILINE)


def listed(maker: Maker) -> str:
    """Its outputs as the table names them."""
    return ", ".join(f"`{name}`" for name in maker.outputs)


def rows(makers: list[Maker], taken: dict[str, str]) -> str:
    """The table: outputs, script, pages and seconds."""
    places, lines = shown(), []
    for maker in sorted(makers, key=lambda maker: (maker.script, maker.outputs)):
        # numbers stand on the pages of what is drawn from them
        drawn = [name for one in MAKERS if one.numbers in maker.outputs for name in one.outputs]
        found = sorted({page for name in (*maker.outputs, *drawn) for page in places.get(name, [])})
        links = ", ".join(f"[{Path(page).stem}]({page})" for page in found)
        outputs = listed(maker)
        lines.append((outputs, f"`{maker.script}`", links, taken.get(outputs, "–")))
    return table(("output", "script", "page", "seconds"), lines, 3)


def known() -> dict[str, str]:
    """Seconds of each row of the page as it is."""
    return dict(ROW.findall(LIST.read_text(encoding="utf-8")))


# -- how each kind of output is kept ----------------------------------------------------------


def keep(name: str, made: object, colours: int | None = COLOURS) -> None:
    """Write an output where it belongs."""
    path = (STATIC / name).resolve()
    match made:
        case Figure() if path.suffix == ".svg":
            write_figure(made, path)
        case Figure():
            _write_small(made, path, colours)
        case Image.Image():
            made.convert("RGB").quantize(colours or 256).save(path, optimize=True)
        case str() if not path.suffix:
            write_table(name, made)
        case dict() if path.suffix == ".json":
            head = {"machine": machine(), "date": f"{datetime.date.today():%Y-%m-%d}"}
            keep_numbers(name, head | made)
        case Path() if made == path and path.is_file():
            pass
        case _:
            raise TypeError(f"{name} cannot be made of {type(made).__name__}")


def _write_small(figure: Figure, path: Path, colours: int | None) -> None:
    """Write a dense figure, sharp on any screen; with a palette of its own it stays small."""
    with style():
        dpi = PIXELS / figure.get_figwidth()
        figure.savefig(path, dpi=dpi, metadata={"Software": None})
    if colours is None:
        return
    with Image.open(path) as image:
        whole = image.convert("RGB")
        # rare colours are marks, and keep their own
        whole.quantize(colours, Image.Quantize.MAXCOVERAGE).save(path, optimize=True)


def write_table(name: str, text: str) -> None:
    """Put a table between its marks into all pages that have them, README.md among them."""
    begin, end = f"<!-- table: {name} -->", "<!-- end of table -->"
    marked = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", re.DOTALL)
    block = f"{begin}\n\n{text.strip()}\n\n{end}"
    known = False
    with PAGES:
        for page in pages():
            found = page.read_text(encoding="utf-8")
            if begin in found:
                known = True
                page.write_text(marked.sub(lambda _: block, found), encoding="utf-8")
    if not known:
        raise ValueError(f"no page has a place for the table {name!r}")


def kept(name: str) -> dict[str, Any]:
    """Numbers that were measured before."""
    return json.loads((STATIC / name).read_text(encoding="utf-8"))


def keep_numbers(name: str, content: dict[str, Any]) -> None:
    """Write numbers with a few digits; lists of measurements have one a line."""
    parts = []
    for key, value in rounded(content).items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = (json.dumps(row, ensure_ascii=False) for row in value)
            text = "[\n  " + ",\n  ".join(rows) + "\n ]"
        else:
            text = json.dumps(value, indent=1, ensure_ascii=False).replace("\n", "\n ")
        parts.append(f" {json.dumps(key)}: {text}")
    (STATIC / name).write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")


def rounded(value: Any) -> Any:
    """The same with `DIGITS` significant digits throughout."""
    if isinstance(value, dict):
        return {key: rounded(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(part) for part in value]
    if isinstance(value, float) and value and math.isfinite(value):
        return float(f"{value:.{DIGITS}g}")
    return value


def table(heads: Iterable[str], rows: Iterable[Iterable[object]], texts: int = 1) -> str:
    """A table in Markdown whose first columns are text and the others numbers."""
    heads = list(heads)
    rule = ["---"] * texts + ["--:"] * (len(heads) - texts)
    lines = [f"| {' | '.join(map(str, row))} |" for row in (heads, *rows)]
    lines.insert(1, f"|{'|'.join(rule)}|")
    return "\n".join(lines) + "\n"


def measured_on(content: dict[str, Any]) -> str:
    """When and where numbers were measured."""
    return f"Measured on {content['date']}: {content['machine']}."


def machine() -> str:
    """Processor, operating system and versions, without the name of the host."""
    import llvmlite

    processor = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [x for x in info.read_text().splitlines() if x.startswith("model name")]
        processor = models[0].split(":", 1)[1].strip() if models else processor
    return (
        f"{processor} ({os.cpu_count()} threads), {platform.system()} {platform.machine()}, "
        f"Python {platform.python_version()}, llvmlite {llvmlite.__version__}, "
        f"NumPy {np.__version__}"
    )


# -- examples of pages ------------------------------------------------------------------------


def definition_text(page: str, file: str) -> str:
    """The definition that a page shows under a name of a file; page as a path in docs."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = re.search(rf"^```yaml\n(# {re.escape(file)}\b.*?)^```$", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise ValueError(f"{page} has no definition {file}")
    return found[1]


def definition(page: str, file: str) -> linkages.Mechanism:
    """The mechanism of it."""
    return from_document(parse(definition_text(page, file), file))
