"""What acts on a mechanism and what ties angles together, in words: rows of `check`."""

from __future__ import annotations

import math

from linkages.cli.terminal import number
from linkages.components.functions import Function, Number
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


def loads(mechanism: Mechanism) -> list[Row]:
    """Forces, torques, springs, dampers, masses at joints: ``kind, path, on, value``.

    Those that are exactly zero are left out, as they are of the equations.
    """
    found = [row for load in mechanism.loads if (row := _load(load)) is not None]
    masses = [
        _row("mass", m.path, f"joint {m.joint}", f"{number(m.mass.value)} kg")
        for m in mechanism.point_masses
        if not m.mass.absent
    ]
    return [*found, *masses]


def _load(load: Load) -> Row | None:
    match load:
        case AxialForce(body, force, path):
            return _row("force", path, f"{body}, along its axis", _law(force, "N"))
        case PointForce(joint, force, path):
            parts = ", ".join(_law(part, "N") for part in force)
            return _row("force", path, f"joint {joint}", f"[{parts}]")
        case Torque(body, reference, torque, path):
            return _row("torque", path, _against(body, reference), _law(torque, "N m"))
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
    raise TypeError(f"no load: {load!r}")


def _row(kind: str, path: Path, on: str, value: str) -> Row:
    return {"kind": kind, "path": dotted(path), "on": on, "value": value}


def _against(body: str, reference: str | None) -> str:
    return body if reference is None else f"{body} against {reference}"


def _numbers(*entries: tuple[Parameter, str, str]) -> str:
    """Those that are not zero, with their units."""
    shown = [(p.value, units, before) for p, units, before in entries if not p.absent]
    return ", ".join(f"{before}{number(value)} {units}" for value, units, before in shown)


def _law(function: Function, units: str) -> str:
    if isinstance(function, Number):
        return f"{number(function.parameter.value)} {units}"
    return f"a law of time ({units})"
