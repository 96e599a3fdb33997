"""What commands and functions report, apart from how it is presented."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def headed(name: object, unit: object) -> str:
    """A heading with its unit, if it has one."""
    return f"{name} ({unit})" if unit else str(name)


def shown(value: Any, form: str = ".6g") -> str:
    """A cell as text: nothing for None and False, ``yes`` for True, commas between several."""
    if value is None or isinstance(value, bool):
        return "yes" if value else ""
    if isinstance(value, list | tuple):
        return ", ".join(shown(item, form) for item in value)
    return format(value, form) if isinstance(value, float) else str(value)


def number(value: float) -> str:
    """Six significant digits."""
    return f"{value:.6g}"


def rounded(value: float) -> str:
    """Four significant digits, zeros among them, so that columns are even."""
    return f"{value:#.4g}".rstrip(".") if value else "0"


@dataclass(frozen=True)
class Column:
    """A heading with its unit, the key of rows that are mappings, and the format of numbers."""

    heading: str
    key: str = ""
    unit: str = ""
    form: str = ".6g"


@dataclass(frozen=True)
class Table:
    """Rows under headings, the last `numbers` aligned right; a newline begins an empty line."""

    heading: str
    columns: Sequence[str | Column]
    rows: Sequence[Any]
    numbers: int = 0

    @classmethod
    def of(
        cls, heading: str, rows: Sequence[Any], *columns: str | Column, numbers: int = 0
    ) -> Table:
        """A table of mappings, as JSON has them; ``"key: heading"``, or both in one word."""
        parts = [each if isinstance(each, Column) else each.partition(": ") for each in columns]
        keyed = [p if isinstance(p, Column) else Column(p[2] or p[0], p[0]) for p in parts]
        return cls(heading, keyed, rows, numbers)

    @property
    def headings(self) -> list[str]:
        """Of the columns, with units."""
        return [headed(column.heading, column.unit) for column in self._columns]

    @property
    def cells(self) -> list[list[str]]:
        """Texts of the rows."""
        columns = self._columns
        places = [column.key or place for place, column in enumerate(columns)]
        forms = [column.form for column in columns]
        return [
            [shown(row[place], form) for place, form in zip(places, forms, strict=True)]
            for row in self.rows
        ]

    @property
    def _columns(self) -> list[Column]:
        return [Column(each) if isinstance(each, str) else each for each in self.columns]


class Unbroken(str):
    """A line that is never broken, so that paths in it can be copied."""


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    texts: Sequence[str]


@dataclass(frozen=True)
class Notes:
    """What else must be known: assumptions, warnings, what failed."""

    texts: Sequence[str]


@dataclass(frozen=True)
class Picture:
    """A figure over its caption; terminals have none."""

    figure: Figure
    caption: str = ""


@dataclass(frozen=True)
class Definition:
    """The text of a definition file, folded; terminals leave it out."""

    text: str


@dataclass(frozen=True)
class Section:
    """Parts under a heading; terminals leave it out, and pages do if it is empty."""

    heading: str
    parts: Sequence[Part]


Part: TypeAlias = "str | Table | Items | Notes | Picture | Definition | Section"


@dataclass(frozen=True, kw_only=True)
class Report:
    """Results for terminals, JSON and pages; the summary is coloured."""

    name: str = ""
    summary: str = ""
    parts: Sequence[Part] = ()
    data: Mapping[str, Any] = field(default_factory=dict)
    colours: tuple[str, str] = ("none", "none")
