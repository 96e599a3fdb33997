"""Sliders with room in their guides: a block of its own, and what it moves along."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace

from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Guide,
    Parameter,
    Play,
    Relation,
)

_ONE = Parameter((), 1.0)
_ACROSS = Parameter((), math.pi / 2)


def foot(play: Play, joint: str) -> str:
    """What the point of the axis is called that the joint of a slider would be at without play."""
    return f"{joint}.{play.name}"


def loosened(bodies: Mapping[str, Body], plays: Iterable[Play]) -> dict[str, Body]:
    """Bodies of which some sliders are places on their axes, with blocks behind them.

    A block has all that its slider had: joints, mass, moment of inertia, and what slides on it.
    """
    found, blocks = dict(bodies), {play.slider: play for play in plays}
    for name, body in bodies.items():
        guide = body.guide
        if guide is not None and guide.body in blocks:
            found[name] = replace(body, guide=replace(guide, body=blocks[guide.body].block))
    ordered: dict[str, Body] = {}
    for name, body in found.items():
        play = blocks.get(name)
        if play is None:
            ordered[name] = body
            continue
        place = {foot(play, next(iter(body.points))): (ZERO, ZERO)}
        ordered[name] = replace(body, points=place, mass=ZERO, inertia=ZERO)
        ordered[play.block] = replace(body, name=play.block, kind="block", guide=None)
    return ordered


def ways(bodies: Mapping[str, Body], play: Play) -> tuple[Body, Body]:
    """What leads from the axis to the middle of a block, and what the block is turned by.

    Parameters
    ----------
    bodies
        From `loosened`.
    play
        One of those.
    """
    joint = next(iter(bodies[play.block].points))
    here = {joint: (ZERO, ZERO)}
    across = Guide(foot(play, joint), _ACROSS, play.slider)
    return (
        Body(name=play.offset, kind="offset", path=play.path, points=here, guide=across),
        Body(name=play.tilt, kind="tilt", path=play.path, points=here),
    )


def turned(bodies: Mapping[str, Body], play: Play) -> Relation:
    """The angle of a block: that of its guide, and what it is turned in it."""
    angles, name = [], play.slider
    while name in bodies and (guide := bodies[name].guide) is not None:
        angles.append(guide.angle)
        if guide.body is None:
            return Relation(play.block, ((play.tilt, _ONE),), _sum(play, angles), play.path)
        name = guide.body
    parts = ((name, _ONE), (play.tilt, _ONE))
    return Relation(play.block, parts, _sum(play, angles), play.path)


def _sum(play: Play, angles: list[Parameter]) -> Parameter:
    """The angle of a guide on others."""
    if len(angles) == 1:
        return angles[0]
    kept = any(angle.kept for angle in angles)
    total = sum(angle.value for angle in angles)
    return Parameter((*play.path, "axis"), total, structural=True, kept=kept)
