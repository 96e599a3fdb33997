"""Numbers whose unit was most likely forgotten: degrees read as radians, millimetres as metres."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from statistics import median_low
from typing import Any

from linkages.components.contributed.terms import Body, Path
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.document import Document
from linkages.reading.paths import dotted
from linkages.spec.arithmetic import NumberError, leading_number
from linkages.spec.tolerance_zones import nominal_text

TURN = 2 * math.pi
"""Larger angles count whole turns, or degrees."""

OTHER_SIZE = 100.0
"""How many times longer, or shorter, than most of a machine a length looks odd."""

ROUND, FROM, FASTEST = 50.0, 300.0, 3000.0
"""Round speeds from 300 rad/s look like revolutions per minute; so do all above 3000 rad/s."""

NEAR = 30.0
"""Times the median length within which another unit would make sense."""

_SECTIONS = ("joints", "bars", "sliders", "clearances", "welds", "drives", "free", "springs")
_LAW = ("to", "from", "amplitude", "mean", "values")
_UNITS = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254}


@dataclass(frozen=True)
class _Written:
    """A number without a unit, and where it stands."""

    path: Path
    value: float

    def note(self, unit: str, sentence: str) -> str:
        """A note that begins with the number."""
        return f"{dotted(self.path)} is {self.value:g} {unit}{sentence}"


def forgotten_units(mechanism: Mechanism) -> list[str]:
    """A sentence for each entry of a definition file with a number that looks like another unit.

    Numbers with a unit are never doubted, nor angles written with pi. Of an entry the largest
    number of each kind is named.
    """
    if mechanism.document is None:
        return []  # who writes Python knows that it is SI
    machine = _Machine(mechanism)
    worst: dict[tuple[Path, str], tuple[float, str]] = {}
    for written in _numbers(mechanism.document):
        kind = _kind(written.path, mechanism)
        sentence = machine.doubt(kind, written)
        key = (written.path[:2], kind)
        if sentence and abs(written.value) > worst.get(key, (-1.0, ""))[0]:
            worst[key] = (abs(written.value), sentence)
    return [sentence for _, sentence in worst.values()]


def _numbers(document: Document) -> Iterator[_Written]:
    def walk(content: Any, path: Path) -> Iterator[_Written]:
        if isinstance(content, dict | list):
            entries = content.items() if isinstance(content, dict) else enumerate(content)
            for key, inner in entries:
                yield from walk(inner, (*path, key))
        elif (number := _plain(content)) is not None:
            yield _Written(path, number)

    for section in _SECTIONS:
        yield from walk(document.content.get(section), (section,))


def _plain(raw: Any) -> float | None:
    """A number without a unit; None for everything else, and for angles in terms of pi."""
    if isinstance(raw, int | float) and not isinstance(raw, bool):
        return float(raw)
    if not isinstance(raw, str) or "pi" in raw or "π" in raw:
        return None
    try:
        number, unit = leading_number(nominal_text(raw).replace("−", "-").strip())
    except (NumberError, OverflowError):
        return None
    return None if unit else number


def _kind(path: Path, mechanism: Mechanism) -> str:
    """What a number measures: an angle, a length, a place, a stroke, a speed; or ``""``."""
    section, key = path[0], path[-1]
    named = [step for step in path[1:] if isinstance(step, str)]
    if section in ("drives", "free"):
        body = mechanism.bodies.get(named[0]) if named else None
        turning = body is not None and body.rotates
        if key == "speed":
            return "speed" if turning else ""
        if key in ("angle", "position") or any(step in _LAW for step in named[1:]):
            return "angle" if turning else "stroke"
        return ""
    if key == "angle":
        return "" if section == "springs" else "angle"  # springs are wound by whole turns
    if key == "length":
        return "length"
    placed = section == "joints" or any(step in ("points", "through", "center") for step in named)
    return "place" if placed and isinstance(key, int) else ""


class _Machine:
    """Sizes of a mechanism, and what is odd beside them."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._bodies = [b for b in mechanism.bodies.values() if b.kind in ("bar", "plate")]
        self._ground = [(x.value, y.value) for x, y in mechanism.ground.values()]

    @cached_property
    def _sizes(self) -> list[float]:
        spans = [math.dist(one, other) for one, other in combinations(self._ground, 2)]
        return [size for size in (*map(longest, self._bodies), *spans) if size > 0]

    def doubt(self, kind: str, written: _Written) -> str:
        """What is odd about a number of some kind; empty if nothing is."""
        size = abs(written.value)
        if kind == "angle" and size > TURN:
            meant = f"; did you mean {written.value:g} deg? Numbers without a unit are radians"
            return written.note("rad", meant)
        if kind == "speed" and (size > FASTEST or (size >= FROM and size % ROUND == 0)):
            rpm = f" ({written.value * 30 / math.pi:.0f} rpm)"
            meant = f"{rpm}; did you mean {written.value:g} rpm? Numbers without a unit are rad/s"
            return written.note("rad/s", meant)
        if kind in ("length", "place", "stroke") and size > 0 and self._sizes:
            return self._odd_length(kind, written)
        return ""

    def _odd_length(self, kind: str, written: _Written) -> str:
        size, usual = abs(written.value), median_low(self._sizes)
        if kind == "stroke":
            reach = sum(self._sizes)
            odd = size > reach
            beside = f", longer than the whole machine ({reach:.3g} m)"
        else:
            odd = size > OTHER_SIZE * usual or (kind == "length" and size * OTHER_SIZE < usual)
            beside = f", where the median length is {usual:.3g} m"
        if not odd:
            return ""
        units = (u for u, scale in _UNITS.items() if 1 / NEAR < size * scale / usual < NEAR)
        unit = next(units, None)
        meant = "" if unit is None else f"; did you mean {written.value:g} {unit}?"
        stop = "; numbers" if unit is None else " Numbers"
        return written.note("m", f"{beside}{meant}{stop} without a unit are metres")


def longest(body: Body) -> float:
    """The largest distance between two joints of a body."""
    places = [(x.value, y.value) for x, y in body.points.values()]
    return max((math.dist(one, other) for one, other in combinations(places, 2)), default=0.0)
