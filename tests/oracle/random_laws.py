"""Laws of time drawn at random."""

from typing import Any

from growing_mechanisms import Draw, Growing
from scipy.interpolate import CubicSpline


def motion(draw: Draw, start: float) -> dict[str, Any]:
    """Keys of a drive that starts at a place: constant speed, a formula or a table."""
    speed, swing = draw.number(-3.0, 3.0), draw.number(0.1, 0.5)
    kind = draw.choice(["speed", "formula", "table"])
    if kind == "formula":
        rate = draw.number(1.0, 4.0)
        return {"law": f"{start!r} + {speed!r}*t + {swing!r}*sin({rate!r}*t)"}
    if kind == "table":
        return {"law": {"table": _table(start, swing, draw.choice([False, True]))}}
    return {"angle": start, "speed": speed}


def _table(start: float, swing: float, periodic: bool) -> dict[str, Any]:
    """A spline that has a given value at t = 0, which is between two of its times."""
    times, values = [-0.6, 0.4, 1.1, 1.5], [0.0, swing, -0.2, 0.0 if periodic else 0.1]
    ends = "periodic" if periodic else "natural"
    shift = start - float(CubicSpline(times, values, bc_type=ends)(0.0))
    return {"times": times, "values": [value + shift for value in values], "periodic": periodic}


def strength(g: Growing, most: float) -> float | str:
    """A constant, or a function of time."""
    size = g.draw.number(-most, most)
    if g.chance(0.5):
        return size
    return f"{size!r}*cos({g.draw.number(0.5, 5.0)!r}*t + 0.25) - abs(t - 0.2)/3"
