"""Definitions with any number of bodies, in every arrangement by which cost could grow.

All have gravity and masses, and are assembled far from singular positions. A name of `ARRANGEMENTS`
gives the function that writes the text for about so many bodies.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import yaml

Definition = dict[str, object]


def _text(**sections: object) -> str:
    return yaml.dump({"gravity": [0, -9.81], **sections}, Dumper=_DUMPER, sort_keys=False)


_DUMPER = getattr(yaml, "CSafeDumper", yaml.SafeDumper)


def _bar(*joints: str, length: float = 1.0) -> Definition:
    return {"joints": list(joints), "length": length, "mass": 1.0}


def free_chain(count: int) -> str:
    """Bars that hang from one another, all of them free."""
    bars = {f"b{i}": _bar(f"J{i}", f"J{i + 1}", length=1 / count) for i in range(count)}
    free = {f"b{i}": {"angle": -1.2 + 0.1 * math.sin(i), "speed": 0} for i in range(count)}
    return _text(joints={"J0": [0, 0]}, bars=bars, free=free)


def driven_chain(count: int) -> str:
    """The same bars, all of them driven."""
    bars = {f"b{i}": _bar(f"J{i}", f"J{i + 1}", length=1 / count) for i in range(count)}
    drives = {f"b{i}": {"angle": math.sin(i), "speed": 1 + i / count} for i in range(count)}
    return _text(joints={"J0": [0, 0]}, bars=bars, drives=drives)


def free_tree(count: int) -> str:
    """A binary tree of free bars."""
    bars = {f"b{i}": _bar(f"J{(i + 1) // 2}", f"J{i + 1}") for i in range(count)}
    free = {f"b{i}": {"angle": -1.2 + 0.1 * math.sin(i), "speed": 0} for i in range(count)}
    return _text(joints={"J0": [0, 0]}, bars=bars, free=free)


def dyads(count: int) -> str:
    """Dyads in a row: the first post is driven, each further one stands on a pin of its own."""
    heads = [(i + 0.1 * math.sin(2 * i), -1 + 0.1 * math.sin(3 * i)) for i in range(count // 2 + 1)]
    joints = {f"G{i}": [i, 0] for i in range(len(heads))}
    bars = {"post0": _bar("G0", "P0", length=math.dist((0, 0), heads[0]))}
    for i in range(1, len(heads)):
        link = math.dist(heads[i - 1], heads[i])
        bars[f"link{i}"] = _bar(f"P{i - 1}", f"P{i}", length=link)
        bars[f"post{i}"] = _bar(f"G{i}", f"P{i}", length=math.dist((i, 0), heads[i]))
    drives = {"post0": {"angle": math.atan2(heads[0][1], heads[0][0]), "speed": 0.01}}
    assembly = {f"P{i}": list(head) for i, head in enumerate(heads) if i}
    return _text(joints=joints, bars=bars, drives=drives, assembly=assembly)


def four_bars(count: int) -> str:
    """Four-bar linkages side by side, each with a drive of its own."""
    joints: Definition = {}
    bars: Definition = {}
    drives: Definition = {}
    assembly: Definition = {}
    for i in range(count // 3):
        joints |= {f"O{i}": [0, i], f"Q{i}": [0.1, i]}
        bars[f"crank{i}"] = _bar(f"O{i}", f"A{i}", length=0.04)
        bars[f"coupler{i}"] = _bar(f"A{i}", f"B{i}", length=0.12)
        bars[f"rocker{i}"] = _bar(f"Q{i}", f"B{i}", length=0.08)
        drives[f"crank{i}"] = {"angle": i, "speed": 1}
        assembly[f"B{i}"] = "left"
    return _text(joints=joints, bars=bars, drives=drives, assembly=assembly)


def slotted_bars(count: int) -> str:
    """Driven bars, with a free block on each."""
    bars = {f"b{i}": _bar(f"O{i}", f"A{i}") for i in range(count // 2)}
    sliders = {f"s{i}": {"joint": f"S{i}", "on": f"b{i}", "mass": 1} for i in range(count // 2)}
    free = {f"s{i}": {"position": 0.5, "speed": 0} for i in range(count // 2)}
    drives = {f"b{i}": {"angle": i, "speed": 1} for i in range(count // 2)}
    joints = {f"O{i}": [2 * i, 0] for i in range(count // 2)}
    return _text(joints=joints, bars=bars, sliders=sliders, free=free, drives=drives)


def quick_returns(count: int) -> str:
    """Cranks side by side, each with a pin that slides along a rocker."""
    joints: Definition = {}
    bars: Definition = {}
    sliders: Definition = {}
    drives: Definition = {}
    assembly: Definition = {}
    for i in range(count // 3):
        joints |= {f"O{i}": [3 * i, 0], f"Q{i}": [3 * i, -1]}
        bars[f"crank{i}"] = _bar(f"O{i}", f"A{i}", length=0.4)
        bars[f"rocker{i}"] = _bar(f"Q{i}", f"B{i}", length=2.0)
        sliders[f"block{i}"] = {"joint": f"A{i}", "on": f"rocker{i}", "mass": 1}
        drives[f"crank{i}"] = {"angle": 0.3, "speed": 1}
        assembly[f"block{i}"] = 1.1
    return _text(joints=joints, bars=bars, sliders=sliders, drives=drives)


def ladder(count: int) -> str:
    """Parallelograms on top of one another: rungs stay level, uprights are driven."""
    joints: Definition = {"L0": [0, 0], "R0": [1, 0]}
    bars: Definition = {}
    drives: Definition = {}
    assembly: Definition = {}
    x = y = 0.0
    for i in range(count // 3):
        angle = 1.5 + 0.3 * math.sin(i)
        x, y = x + math.cos(angle), y + math.sin(angle)
        bars[f"left{i}"] = _bar(f"L{i}", f"L{i + 1}")
        bars[f"right{i}"] = _bar(f"R{i}", f"R{i + 1}")
        bars[f"rung{i}"] = _bar(f"L{i + 1}", f"R{i + 1}")
        drives[f"left{i}"] = {"angle": angle, "speed": 0.001}
        assembly[f"R{i + 1}"] = [x + 1, y]
    return _text(joints=joints, bars=bars, drives=drives, assembly=assembly)


def fans(count: int) -> str:
    """Driven plates with 50 points each, from all of which bars hang freely."""
    joints: Definition = {}
    bars: Definition = {}
    drives: Definition = {}
    free: Definition = {}
    for i in range(max(1, count // 51)):
        joints[f"O{i}"] = [10 * i, 0]
        rim = {f"P{i}_{k}": [math.cos(k / 8), math.sin(k / 8)] for k in range(50)}
        bars[f"wheel{i}"] = {
            "points": {f"O{i}": [0, 0], **rim}, "mass": 1, "center": [0, 0], "inertia": 1,
        }  # fmt: skip
        drives[f"wheel{i}"] = {"angle": 0, "speed": 1}
        for name in rim:
            bars[f"b{name}"] = _bar(name, f"E{name}", length=0.1)
            free[f"b{name}"] = {"angle": -1.5, "speed": 0}
    return _text(joints=joints, bars=bars, drives=drives, free=free)


def wide_plate(count: int) -> str:
    """One driven plate with as many points."""
    points = {"O": [0, 0], **{f"P{k}": [math.cos(k), math.sin(k)] for k in range(count)}}
    wheel = {"points": points, "mass": 1, "center": [0, 0], "inertia": 1}
    drives = {"wheel": {"angle": 0, "speed": 1}}
    return _text(joints={"O": [0, 0]}, bars={"wheel": wheel}, drives=drives)


def hub(count: int) -> str:
    """One pin from which all bars hang, half of them free and half driven."""
    bars = {f"b{i}": _bar("O", f"A{i}") for i in range(count)}
    free = {f"b{i}": {"angle": i, "speed": 0} for i in range(0, count, 2)}
    drives = {f"b{i}": {"angle": i, "speed": 1} for i in range(1, count, 2)}
    return _text(joints={"O": [0, 0]}, bars=bars, free=free, drives=drives)


def sprung_chain(count: int) -> str:
    """Free bars that hang from one another, with a damped spring at every joint."""
    bars = {f"b{i}": _bar(f"J{i}", f"J{i + 1}", length=1 / count) for i in range(count)}
    free = {f"b{i}": {"angle": -1.2 + 0.1 * math.sin(i), "speed": 0} for i in range(count)}
    pairs = [[f"b{i}", f"b{i + 1}"] for i in range(count - 1)]
    springs = [{"between_bars": pair, "stiffness": 2, "angle": 0, "damping": 0.1} for pair in pairs]
    return _text(joints={"J0": [0, 0]}, bars=bars, free=free, springs=springs)


ARRANGEMENTS: dict[str, Callable[[int], str]] = {
    function.__name__.replace("_", "-"): function
    for function in (
        free_chain, driven_chain, free_tree, dyads, four_bars, slotted_bars, quick_returns, ladder,
        fans, wide_plate, hub, sprung_chain,
    )
}  # fmt: skip
