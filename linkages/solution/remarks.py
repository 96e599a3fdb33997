"""Notes on a definition: assumptions, doubtful values, missing units, ranges of laws."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from statistics import median_low
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import TIME, Function, Measured, Table, extremes
from linkages.components.contributed.load_measures import Turn
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import Body
from linkages.components.laws import WHOLE
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.assembly import placed_joints
from linkages.kernel.inputs import law_values
from linkages.kernel.system import System
from linkages.reading.document import Document
from linkages.reading.paths import KeyPath, dotted
from linkages.spec.conversion import nominal_text
from linkages.spec.grammar import NumberError, leading_number
from linkages.topology.assur_groups import Block
from linkages.topology.decomposition import bodies_at, single_joints


def assumptions(system: System) -> list[str]:
    """A sentence for each free coordinate, assembly branch and number of turns that was chosen."""
    result = [
        f"{name} was chosen as a free coordinate, at rest where 'assembly' puts it"
        for name in system.chosen
    ]
    blocks = system.topology.solved_blocks
    result += [_assumed(system, blocks[index]) for index in system.assembly.assumed]
    return [*result, *_wound(system)]


def _wound(system: System) -> Iterator[str]:
    """Torsional springs that start more than half a turn from where the file has no torque."""
    for load in system.model.loads:
        if load.index not in system.assembly.turns:
            continue
        deflection = load.value(load.load.deflection)
        turns = system.evaluate([deflection])[0, 0] / (2 * np.pi)
        if abs(turns) > 0.5:
            yield (
                f"{dotted(load.load.path)} starts wound by {turns:.3g} turns: angles that are not "
                "given start within half a turn"
            )


def _assumed(system: System, block: Block) -> str:
    link, slider = block.unknowns
    joints = placed_joints(system.model, block)
    if block.kind == "RPR":
        text = f"{slider} is assumed to lie on {link} in the direction of its axis"
    else:
        text = f"{link} is assumed to point forward along the axis of {slider}"
    if not joints:
        return text
    return f"{text}; give joint {joints[0]} a place under 'assembly' to say otherwise"


TURN = 2 * math.pi
"""Larger angles count whole turns, or degrees."""

OTHER_SIZE = 100.0
"""How many times longer, or shorter, than most of a machine a length looks odd."""

MOST_SPANNED = 200
"""Joints of the ground or of a body among which all distances are looked at; of more, this many."""

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

    path: KeyPath
    value: float

    def note(self, unit: str, sentence: str) -> str:
        """A note that begins with the number."""
        return f"{dotted(self.path)} is {self.value:g} {unit}{sentence}"


def forgotten_units(mechanism: Mechanism) -> list[str]:
    """A sentence for each entry of a definition file with a number that looks like another unit.

    Numbers with a unit or with pi are never reported; of an entry the largest of each kind is
    named.
    """
    if mechanism.document is None:
        return []  # who writes Python knows that it is SI
    machine = _Machine(mechanism)
    worst: dict[tuple[KeyPath, str], tuple[float, str]] = {}
    for written in _numbers(mechanism.document):
        kind = _kind(written.path, mechanism)
        sentence = machine.doubt(kind, written)
        key = (written.path[:2], kind)
        if sentence and abs(written.value) > worst.get(key, (-1.0, ""))[0]:
            worst[key] = (abs(written.value), sentence)
    return [sentence for _, sentence in worst.values()]


def _numbers(document: Document) -> Iterator[_Written]:
    def walk(content: Any, path: KeyPath) -> Iterator[_Written]:
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


def _kind(path: KeyPath, mechanism: Mechanism) -> str:
    """What a number measures: an angle, a length, a place, a stroke, a speed; or ``""``."""
    section, key = path[0], path[-1]
    named = [step for step in path[1:] if isinstance(step, str)]
    if section in ("drives", "free"):
        body = mechanism.bodies.get(named[0]) if named else None
        turning = body is not None and body.rotates
        if "progress" in named:
            return ""
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
        self._flies = bool(mechanism.walls)  # what walls catch may be far from it

    @cached_property
    def _sizes(self) -> list[float]:
        some = self._ground[:: 1 + len(self._ground) // MOST_SPANNED]
        spans = [math.dist(one, other) for one, other in combinations(some, 2)]
        return [size for size in (*map(longest, self._bodies), *spans) if size > 0]

    @cached_property
    def _usual(self) -> float:
        return median_low(self._sizes)

    @cached_property
    def _reach(self) -> float:
        return sum(self._sizes)

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
        size, usual = abs(written.value), self._usual
        if kind == "stroke":
            odd = size > self._reach and not self._flies
            beside = f", longer than the whole machine ({self._reach:.3g} m)"
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
    """The largest distance between two joints of a body; of very many, to a thousandth."""
    places = [(x.value, y.value) for x, y in body.points.values()]
    if len(places) > MOST_SPANNED:  # those that are farthest out in some direction
        turns = 2.0 * np.pi * np.arange(MOST_SPANNED) / MOST_SPANNED
        directions = np.array([np.cos(turns), np.sin(turns)])
        outer = set(np.argmax(np.array(places) @ directions, axis=0).tolist())
        places = [places[index] for index in sorted(outer)]
    return max((math.dist(one, other) for one, other in combinations(places, 2)), default=0.0)


SAMPLES = 4001
"""Times at which the extremes of a formula are looked for."""

ROUNDS, FINER = 4, 41
"""How often they are looked for again around the best time, and at how many times."""

OVERSHOOT = 1e-3
"""Part of the range of values that a spline may leave it by without a note.

A cosine leaves the range of its values by less if there are 50 of them in a period.
"""


@dataclass(frozen=True)
class LawRange:
    """Least and largest finite value of a law, in SI units; nan if there is none."""

    low: float
    high: float
    period: float | None = None  # seconds, of a table that repeats; None for all others


def law_range(function: Function, end: float) -> LawRange:
    """The range of a law from t = 0 to `end`; of a table that repeats, over its period."""
    begin, last = sorted((0.0, end))
    if isinstance(function, Table) and function.over == TIME:
        period = function.places[-1] - function.places[0] if function.periodic else None
        return LawRange(*extremes(function, begin, last), period)
    times = np.linspace(begin, last, SAMPLES)
    return LawRange(0.0 - _largest(function, times, -1.0), 0.0 + _largest(function, times, 1.0))


def _largest(function: Function, times: NDArray[np.float64], sign: float) -> float:
    best = -np.inf
    for _ in range(1 + ROUNDS):
        values = sign * law_values(function, times)
        values = np.where(np.isfinite(values), values, -np.inf)
        place = int(np.argmax(values))
        best = max(best, float(values[place]))
        times = np.linspace(times[max(place - 1, 0)], times[min(place + 1, len(times) - 1)], FINER)
    return best if np.isfinite(best) else np.nan


def law_notes(mechanism: Mechanism) -> list[str]:
    """Notes on tables that are left, jump as drives, or have degrees read as radians."""
    result = []
    for path, law, unit in _tables(mechanism):
        if law.interpolation == "spline":
            result += _outside(law, unit)
        if path[0] == "drives" and law.interpolation == "pchip":
            result.append(
                f"{dotted(path)}: the acceleration of a table with 'pchip' jumps at its times, and "
                "with it driving efforts and joint forces; 'spline' keeps it continuous"
            )
    return [*result, *_odd_turns(mechanism)]


def _tables(mechanism: Mechanism) -> Iterator[tuple[KeyPath, Table, str]]:
    """All tables of drives and loads: path, table, and SI unit (none of a factor)."""
    for name, drive in mechanism.prescribed.items():
        unit = "rad" if mechanism.bodies[name].rotates else "m"
        tables = (t for t in leaves(drive.law) if isinstance(t, Table) and t.over == TIME)
        yield from ((drive.path, table, unit) for table in tables)  # a curve may leave its points
    for load in mechanism.loads:
        unit = load.unit if isinstance(load.law, Table) else ""
        yield from ((load.path, t, unit) for t in leaves(load.law) if isinstance(t, Table))


def _odd_turns(mechanism: Mechanism) -> Iterator[str]:
    """Tables that repeat over an angle alone, but not as a turn does."""
    for load in mechanism.loads:
        for table in (t for t in leaves(load.law) if isinstance(t, Table) and t.periodic):
            over, period = table.over, table.places[-1] - table.places[0]
            if not isinstance(over, Measured) or over.order:
                continue
            turns = period / (2 * np.pi)
            whole = any(abs(part - round(part)) < WHOLE for part in (turns, 1 / turns))
            if isinstance(over.measure or load.measure, Turn) and not whole:
                yield (
                    f"{dotted(table.path)} repeats every {period:g} rad, which is no whole number "
                    "of turns, nor a part of one; numbers without a unit are radians, not degrees"
                )


def _outside(table: Table, unit: str) -> list[str]:
    least, most = min(table.values), max(table.values)
    unit = unit and f" {unit}"
    low, high = extremes(table, table.places[0], table.places[-1])
    excess = max(least - low, high - most)
    if excess <= OVERSHOOT * (most - least):
        return []
    return [
        f"{dotted(table.path)}: the spline leaves the range of its values by {excess:.2g}{unit}, "
        f"{100 * excess / (most - least):.3g} % of this range; 'interpolation: pchip' never leaves "
        "it, and more times beside a step bend a spline less"
    ]


LARGEST_PLAY = 0.05
"""Of the length of a bar; a larger clearance is less like play in a joint than like a link."""


def doubts(mechanism: Mechanism) -> list[str]:
    """A sentence for each clearance, number, name and law that hardly is what was meant."""
    return [
        *_large_clearances(mechanism),
        *_pressed_starts(mechanism),
        *forgotten_units(mechanism),
        *_capitals(mechanism),
        *law_notes(mechanism),
    ]


def _large_clearances(mechanism: Mechanism) -> list[str]:
    """Clearances that are large beside the bar whose end they displace."""
    result = []
    for clearance in mechanism.clearances:
        bar = mechanism.bodies[clearance.bar]
        size, length = clearance.size, longest(bar)
        if size > LARGEST_PLAY * length:
            result.append(
                f"clearance {clearance.name} of {size:g} m is large beside {bar.name} of "
                f"{length:g} m; numbers without a unit are metres"
            )
    return result


def _pressed_starts(mechanism: Mechanism) -> list[str]:
    """Pins and corners of blocks that start within a wall."""
    return [
        f"clearance {own.name} starts pressed in by {own.deepest:.3g} m: more than its size of "
        f"{own.size:g} m lets it"
        for own in mechanism.opening
        if own.deepest > 0.0
    ]


def _capitals(mechanism: Mechanism) -> list[str]:
    """Joints on one body only that are called like another one but for capitals."""
    alike: dict[str, list[str]] = {}
    for joint in bodies_at(mechanism):
        alike.setdefault(joint.casefold(), []).append(joint)
    result = []
    for joint, body in reversed(single_joints(mechanism).items()):
        joints = alike[joint.casefold()]
        near = [j for j in joints if j != joint]
        if near and near[0] not in mechanism.bodies[body].points:
            result.append(f"joint {joint} is on one body only, {body}; did you mean {near[0]!r}?")
            joints.remove(joint)
    return result
