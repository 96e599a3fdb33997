"""What acts on a mechanism and what ties angles together, in words: rows of `check`."""

from __future__ import annotations

import math
from typing import assert_never

from linkages.cli.terminal import number
from linkages.components.functions import Function, Number, Operation, Time
from linkages.components.gear import Gear
from linkages.components.mechanism import Mechanism
from linkages.components.revolute import GROUND
from linkages.components.terms import (
    AxialDamper,
    AxialForce,
    Load,
    Parameter,
    Path,
    PointForce,
    Spring,
    Torque,
    TorsionSpring,
)
from linkages.components.weld import Weld
from linkages.reading.paths import dotted
from linkages.solution.law_ranges import law_range

Row = dict[str, str]


def relations(mechanism: Mechanism) -> list[Row]:
    """Welds and gears: ``kind, path, on, value``."""
    found: list[Row] = []
    for part in mechanism.components:
        if isinstance(part, Weld):
            value = f"at {part.name}, {number(math.degrees(part.angle))}°"
            found.append(_row("weld", part.path, " and ".join(part.bars), value))
        elif isinstance(part, Gear):
            value = f"{part.bars[1]} turns {number(part.ratio)} times as fast as {part.bars[0]}"
            if part.carrier not in (None, GROUND):
                value += f", seen from {part.carrier}"
            found.append(_row("gear", part.path, " and ".join(part.bars), value))
    return found


def drives(mechanism: Mechanism) -> list[Row]:
    """Drives: ``kind, path, on, value``, with the range of what they prescribe."""
    found = []
    for name, drive in mechanism.prescribed.items():
        unit = "rad" if mechanism.bodies[name].rotates else "m"
        match drive.law:
            case Operation("add", (Number(start), Operation("mul", (Number(speed), Time())))):
                value = f"{number(start.value)} {unit} at t = 0, {number(speed.value)} {unit}/s"
            case _:
                value = _law(drive.law, unit, mechanism)
        found.append(_row("drive", drive.path, name, value))
    return found


def loads(mechanism: Mechanism) -> list[Row]:
    """Forces, torques, springs, dampers, masses at joints: ``kind, path, on, value``.

    Those that are exactly zero are left out, as they are of the equations. Laws of time are shown
    with their range.
    """
    found = [row for load in mechanism.loads if (row := _load(load, mechanism)) is not None]
    masses = [
        _row("mass", m.path, f"joint {m.joint}", f"{number(m.mass.value)} kg")
        for m in mechanism.point_masses
        if not m.mass.absent
    ]
    return [*found, *masses]


def _load(load: Load, mechanism: Mechanism) -> Row | None:
    match load:
        case AxialForce(body, force, path):
            value = _law(force, load.unit, mechanism)
            return _row("force", path, f"{body}, along its axis", value)
        case PointForce(joint, force, path):
            parts = ", ".join(_law(part, load.unit, mechanism) for part in force)
            return _row("force", path, f"joint {joint}", f"[{parts}]")
        case Torque(body, reference, torque, path):
            value = _law(torque, load.unit, mechanism)
            return _row("torque", path, _against(body, reference), value)
        case AxialDamper(body, damping, path):
            value = _numbers((damping, "N s/m", ""))
            return _row("damper", path, f"{body} in its guide", value) if value else None
        case Spring(first, second, stiffness, length, damping, path):
            value = _numbers(
                (stiffness, "N/m", ""),
                (length, "m", "length "),
                (damping, "N s/m", "damping "),
            )
            kind = "damper" if stiffness.absent else "spring"
            return _row(kind, path, f"joints {first} and {second}", value) if value else None
        case TorsionSpring(body, reference, stiffness, angle, damping, path):
            value = _numbers(
                (stiffness, "N m/rad", ""),
                (angle, "rad", "angle "),
                (damping, "N m s/rad", "damping "),
            )
            kind = "torsional damper" if stiffness.absent else "torsional spring"
            on = _against(body, reference)
            return _row(kind, path, on, value) if value else None
        case _:
            assert_never(load)


def _row(kind: str, path: Path, on: str, value: str) -> Row:
    return {"kind": kind, "path": dotted(path), "on": on, "value": value}


def _against(body: str, reference: str | None) -> str:
    return body if reference is None else f"{body} against {reference}"


def _numbers(*entries: tuple[Parameter, str, str]) -> str:
    """Those that are not zero, with their units."""
    shown = [(p.value, units, before) for p, units, before in entries if not p.absent]
    return ", ".join(f"{before}{number(value)} {units}" for value, units, before in shown)


def _law(function: Function, unit: str, mechanism: Mechanism) -> str:
    if isinstance(function, Number):
        return f"{number(function.parameter.value)} {unit}"
    end = mechanism.simulation.end
    found = law_range(function, end)
    over = f"until t = {number(end)} s"
    if found.period is not None:
        over = f"in each period of {number(found.period)} s"
    return f"{number(found.low)} to {number(found.high)} {unit} {over}"
