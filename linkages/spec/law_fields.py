"""Field types for laws, and tables of laws in CSV files.

A table ``{file: gas.csv, columns: [time, force], units: [ms, kN]}`` is replaced in the document by
the times (or places, of a table over another quantity) and values that it names, so that a
mechanism needs the file only while it is loaded. Messages do not repeat what a file contains: it
need not be a table.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf, isfinite
from pathlib import Path as FilePath
from typing import Any, ClassVar, get_origin

from pydantic import TypeAdapter

from linkages.errors import InputError, Problem
from linkages.reading.document import MAX_BYTES, Document, csv_rows, decode
from linkages.reading.overrides import Column
from linkages.reading.paths import KeyPath
from linkages.reading.wording import listed, nearest, shown
from linkages.spec.conversion import (
    QuantityError,
    has_tolerance,
    nominal_text,
    zone_of,
)
from linkages.spec.formulas import Constant, Formula, formula
from linkages.spec.grammar import NumberError
from linkages.spec.quantities import ARITHMETIC, LIMITS, FieldType, Quantity
from linkages.spec.units import Bound, Dimension, UnitError, unit

# A text with the time, a call or a quantity in it is a formula, whatever else is wrong with it.
_FORMULA = re.compile(r"\bt\b|[^\W\d]\w*[ \t]*\(|[^\W\d]\w*[ \t]*\.[ \t]*[^\W\d]|['\"]")
# A formula begins as arithmetic does, or with t, the name of a function or of the mechanism.
_BEGINNING = r"^[-+−(\s]*(\.?[0-9]|['\"A-Za-z]|[^\x00-\x7f])"


@dataclass(frozen=True)
class LawRule(FieldType):
    """A quantity of a dimension, a formula, or a named law."""

    dimension: Dimension  # what the law gives
    named: tuple[tuple[str, Any], ...] = ()  # pairs of the key that tells a named law and its model
    # Why the law may not depend on quantities of the mechanism; empty where it may
    refused: str = ""
    bound: Bound = Bound.NONE  # limit of a number that is no law

    @property
    def models(self) -> tuple[Any, ...]:
        """The models of the named laws."""
        return tuple(model for _, model in self.named)

    def read(self, value: Any) -> Any:
        """Return a number in SI, a `Formula`, or a named law.

        A law that has been read is returned as it is.
        """
        known = tuple(get_origin(model) or model for model in self.models)
        if isinstance(value, (Formula, *known)):
            return value
        if isinstance(value, dict):
            return self._named(value)
        try:
            return Quantity(self.dimension, self.bound).read(value)
        except QuantityError as fault:
            result = fault.found
        if not isinstance(value, str):
            raise QuantityError(self.expected(), result)
        if has_tolerance(value):
            raise QuantityError(self.expected(), result)
        try:
            read = formula(value, self.refused)
        except NumberError as why:
            if _FORMULA.search(value):
                result = f"{shown(value)}: {why}"
            raise QuantityError(self.expected(), result) from None
        if isinstance(read.tree, Constant) and not _FORMULA.search(value):
            raise QuantityError(self.expected(), result)
        return read

    def _named(self, value: dict[str, Any]) -> Any:
        models = dict(self.named)
        keys = [key for key in value if key in models]
        if len(keys) == 1:
            # A ValidationError from here keeps its places: pydantic adds where this field is.
            return TypeAdapter(models[keys[0]]).validate_python(value)
        if keys:
            result = f"a mapping with {listed(map(repr, keys), 'and')}"
            raise QuantityError(self.expected(), f"{result}; expected one of them")
        near = [(key, word) for key in value if (word := nearest(str(key), models))]
        hint = f" with {near[0][0]!r}; did you mean {near[0][1]!r}?" if near else " of other keys"
        raise QuantityError(self.expected(), f"a mapping{hint}")

    def expected(self) -> str:
        """Return for example ``"a force (…), a formula of t, or a law (harmonic, rise)"``."""
        quantity = self.dimension.expected(self.bound)
        laws = f", or a law ({listed(dict(self.named))})" if self.named else ""
        state = "" if self.refused else ", crank.angle and the like"
        return f"{quantity}, a formula of t{state}{laws}"

    def json_schema(self) -> dict[str, Any]:
        """Return a number, text that begins with arithmetic or a formula, or a mapping."""
        kinds = ["number", "string", *(["object"] if self.named else [])]
        return {"type": kinds, **LIMITS[self.bound], "pattern": _BEGINNING}


@dataclass(frozen=True)
class ArgumentRule(FieldType):
    """What a table is a function of: a quantity of the mechanism, or a formula of some."""

    constant: bool = False  # whether it may be a number as well

    def read(self, value: Any) -> Any:
        """Return a `Formula`; one that has been read is returned as it is."""
        if isinstance(value, Formula):
            return value
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and self.constant and isfinite(value):
            return Formula(repr(value), Constant(float(value)))
        if not isinstance(value, str):
            raise QuantityError(self.expected(), shown(value))
        try:
            read = formula(value)
        except NumberError as why:
            raise QuantityError(self.expected(), f"{shown(value)}: {why}") from None
        if isinstance(read.tree, Constant) and not self.constant:
            raise QuantityError(self.expected(), shown(value))
        return read

    def expected(self) -> str:
        """Return what messages expect."""
        number = "a number, " if self.constant else ""
        return f"{number}a quantity such as crank.angle or piston.position, or a formula of some"

    def json_schema(self) -> dict[str, Any]:
        """Return text, and a number where there may be one."""
        kinds = ["number", "string"] if self.constant else "string"
        return {"type": kinds, "pattern": _BEGINNING}


@dataclass(frozen=True)
class PlaceRule(FieldType):
    """A place on the axis of such a quantity, with a unit of it or in SI."""

    words: ClassVar[str] = "a number (in SI, or with a unit)"
    schema: ClassVar[Mapping[str, Any]] = {"type": ["number", "string"], "pattern": ARITHMETIC}

    def read(self, value: Any) -> Any:
        """Return a `Constant`; one that has been read is returned as it is."""
        if isinstance(value, Constant):
            return value
        if isinstance(value, Column) and abs(value) < inf:
            return Constant(value)  # type: ignore[arg-type]  # a number in each of many mechanisms
        if isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value):
            return Constant(float(value))
        try:
            read = formula(nominal_text(value)).tree if isinstance(value, str) else None
            zone_of(str(value))
        except (NumberError, UnitError) as why:
            raise QuantityError(self.expected(), f"{shown(value)}: {why}") from None
        if not isinstance(read, Constant):
            raise QuantityError(self.expected(), shown(value))
        return read


MAX_ROWS = 10_000
"""More points are more than a law needs, and each is an argument of the kernel."""

_SECTIONS = ("drives", "loads", "springs", "dampers")
_TARGETS = "targets"
_OWN = ("file", "columns", "units")
_NUMBER = re.compile(r"[-+−]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?")
_DECIMAL_COMMA = re.compile(r"[-+−]?\d+,\d+")

Row = tuple[int, list[str]]


class _RefusedError(Exception):
    """Why a table cannot be read; the place is a key of its mapping, if there is one."""

    def __init__(self, message: str, *place: str | int) -> None:
        super().__init__(message)
        self.place = place


def with_tables(document: Document) -> tuple[Document, list[Problem]]:
    """Return the document with the tables of files in it, and what is wrong with them.

    A table that cannot be read is replaced by one without a fault, so that it is reported once.
    """
    problems: list[Problem] = []

    def columns(
        table: Mapping[str, Any], place: KeyPath, first: str, instead: int, increasing: bool = True
    ) -> tuple[dict[str, Any], Sequence[Any], Sequence[Any]]:
        """Further keys, and both columns; so many points without a fault in their stead."""
        kept = {key: value for key, value in table.items() if key not in _OWN}
        try:
            return kept, *_read(table, document, first, increasing)
        except _RefusedError as reason:
            problems.append(document.problem((*place, *reason.place), str(reason)))
            return kept, [str(k) for k in range(instead)], ["0"] * instead

    def filled(node: Any, path: KeyPath) -> Any:
        if isinstance(node, list):
            return [filled(entry, (*path, index)) for index, entry in enumerate(node)]
        if not isinstance(node, dict):
            return node
        result = {key: filled(value, (*path, key)) for key, value in node.items()}
        table = result.get("table")
        if isinstance(table, dict) and "file" in table:
            first = "at" if "over" in table else "times"
            kept, times, values = columns(table, (*path, "table"), first, 3)
            result["table"] = {**kept, first: times, "values": values}
        return result

    def located(node: Any, path: KeyPath) -> Any:
        """An entry of `targets` with the points of a file in it."""
        if not isinstance(node, dict) or "file" not in node:
            return node
        kept, x, y = columns(node, path, "points", 1, increasing=False)
        return {**kept, "points": [[*pair] for pair in zip(x, y, strict=True)]}

    content = {
        key: filled(value, (key,)) if key in _SECTIONS else value
        for key, value in document.content.items()
    }
    targets = content.get(_TARGETS)
    if isinstance(targets, dict):
        content[_TARGETS] = {n: located(entry, (_TARGETS, n)) for n, entry in targets.items()}
    return replace(document, content=content), problems


def _read(
    table: Mapping[str, Any], document: Document, first: str, increasing: bool = True
) -> tuple[list[Any], list[Any]]:
    """Times (or places) and values in SI; the first of each as text with its unit.

    Units are checked where the table is read. `first` is the key of the times, which are
    `increasing`, or that of points.
    """
    keys = (first, "values") if increasing else (first,)
    doubled = [key for key in keys if key in table]
    if doubled:
        raise _RefusedError(f"'file' and {doubled[0]!r} are both given; expected one of them")
    if document.folder is None:
        raise _RefusedError(
            "the definition is no file itself, so there is no folder to look for this one in; "
            f"expected {listed(map(repr, keys), 'and')}",
            "file",
        )
    name = table["file"]
    if not isinstance(name, str):
        raise _RefusedError(f"expected the name of a CSV file, found {shown(name)}", "file")
    rows = _rows(name, _text(name, _below(name, document.folder, document.tables)))
    names = [cell.strip() for cell in rows[0][1]]
    header = names if not any(map(_is_number, names)) else None
    both = "of times and of values" if increasing else "of x and of y"
    places = [
        _column(name, header, len(names), key, index)
        for index, key in enumerate(_pair(table, "columns", ("1", "2"), both))
    ]
    lines = rows if header is None else rows[1:]
    times, values = ([_number(name, line, cells[k]) for line, cells in lines] for k in places)
    if not times:
        raise _RefusedError(f"{name} has one line of names and no numbers", "file")
    for (before, after), (line, _) in zip(pairwise(times), lines[1:], strict=True):
        if increasing and after <= before:
            what = "times" if first == "times" else "places"
            raise _RefusedError(f"{name}, line {line}: expected increasing {what}", "file")
    units = _pair(table, "units", (None, None), both)
    return _in_units(times, units[0], 0), _in_units(values, units[1], 1)


def _below(name: str, folder: FilePath, tables: FilePath | None) -> FilePath:
    """The file of that name, with links followed: below one of the two folders, if at all.

    A definition may come from anywhere, and must not read whatever its user can read.
    """
    try:
        path = (folder / name).resolve()
        allowed = [place.resolve() for place in (folder, tables) if place is not None]
    except (OSError, ValueError, RuntimeError):  # no name of a file, or links that lead in a circle
        raise _RefusedError(f"no such file: {name}", "file") from None
    if not any(path.is_relative_to(place) for place in allowed):
        raise _RefusedError(
            f"{name} is outside of the folder of the definition; allow its folder with "
            "--tables-from, or tables_from in Python",
            "file",
        )
    return path


def _text(name: str, path: FilePath) -> str:
    try:
        if not path.is_file():
            raise _RefusedError(f"no such file: {name}", "file")
        with open(path, "rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise _RefusedError(f"{name} cannot be read: {error.strerror or error}", "file") from None
    if len(data) > MAX_BYTES:
        raise _RefusedError(f"{name} is larger than {MAX_BYTES // 10**6} MB", "file")
    try:
        return decode(data, name)
    except InputError as error:
        message = str(error.problems[0]).replace("a YAML file", "a CSV file")
        raise _RefusedError(f"{name}, {message}", "file") from None


def _rows(name: str, text: str) -> list[Row]:
    """Line numbers, from 1, and cells; empty lines and those that begin with # are left out."""
    try:
        rows = csv_rows(text, name)
    except InputError as error:
        (problem,) = error.problems
        raise _RefusedError(f"{name}, line {problem.line}: {problem.message}", "file") from None
    if not rows:
        raise _RefusedError(f"{name} is empty; expected lines with a time and a value", "file")
    if len(rows) > MAX_ROWS:
        message = f"{name} has {len(rows)} lines; expected at most {MAX_ROWS}: fewer points"
        raise _RefusedError(message, "file")
    for number, cells in rows:
        if len(cells) != len(rows[0][1]):
            raise _RefusedError(
                f"{name}, line {number}: expected {len(rows[0][1])} cells as in line "
                f"{rows[0][0]}, found {len(cells)}; cells are separated by commas, semicolons or "
                "tabs, and decimals written with a point",
                "file",
            )
    return rows


def _pair(table: Mapping[str, Any], key: str, usual: tuple[Any, Any], both: str) -> Sequence[Any]:
    result = table.get(key)
    if result is None:
        return usual
    if not isinstance(result, list) or len(result) != 2:
        what = "names or numbers" if key == "columns" else "units"
        message = f"expected two {what}, {both}, found {shown(result)}"
        raise _RefusedError(message, key)
    return result


def _column(name: str, header: list[str] | None, count: int, key: Any, index: int) -> int:
    """The place of a column, by its name or by its number from 1."""
    text = str(key).strip()
    if header is not None and text in header:
        if header.count(text) > 1:
            message = f"{name} has {header.count(text)} columns {text!r}; expected their number"
            raise _RefusedError(message, "columns", index)
        return header.index(text)
    if text.isascii() and text.isdigit() and 1 <= int(text[:9]) <= count:
        return int(text) - 1
    if header is None:
        expected = f"its first line has no names; expected a number from 1 to {count}"
    else:
        expected = f"expected a name in its first line, or a number from 1 to {count}"
    raise _RefusedError(f"{name} has no column {shown(key)}; {expected}", "columns", index)


def _is_number(cell: str) -> bool:
    return bool(_NUMBER.fullmatch(cell.strip()) or _DECIMAL_COMMA.fullmatch(cell.strip()))


def _number(name: str, line: int, cell: str) -> float:
    text = cell.strip()
    if _NUMBER.fullmatch(text):
        value = float(text.replace("−", "-"))
        if math.isfinite(value):
            return value
    hint = "; decimals are written with a point" if _DECIMAL_COMMA.fullmatch(text) else ""
    message = f"{name}, line {line}: expected a number{hint}"
    raise _RefusedError(message, "file")


def _in_units(numbers: list[float], text: str | None, index: int) -> list[Any]:
    if text is None:
        return list(numbers)
    try:
        result = unit(str(text))
    except UnitError as error:
        raise _RefusedError(
            f"expected a unit, found {shown(text)}: {error}", "units", index
        ) from None
    first = [f"{number!r} {text}" for number in numbers[:1]]
    return [*first, *(result.convert(number) for number in numbers[1:])]
