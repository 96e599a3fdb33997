"""A mechanism as a page carries it: what can be gripped, enlarged, and drawn as an arrow."""

from __future__ import annotations

from itertools import combinations
from math import dist
from typing import Any, TypeAlias, assert_never

from linkages.components.cam import Cam
from linkages.components.contributed.measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.terms import PLAYING, Body, Parameter
from linkages.components.gear import Gear
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.rack import Rack
from linkages.kernel.outputs import coordinate_of
from linkages.kernel.system import System
from linkages.plots.mechanism.bodies import clearance_ends
from linkages.solution.values.series import system_series

ACTING = {"force": "load_force", "torque": "load_torque", "spring": "spring_force",
          "torsional_spring": "torsional_spring_torque"}  # fmt: skip
"""Kind of a load → the output that says how much it exerts."""


def described(system: System) -> dict[str, Any]:
    """What a page must know of a mechanism besides its motion."""
    mechanism, topology = system.mechanism, system.topology
    return {
        "name": mechanism.name,
        "mobility": topology.mobility,
        "driven": [_coordinate(system, name) for name in topology.driven],
        "free": [_coordinate(system, name) for name in topology.free],
        "ground": sorted(mechanism.ground),
        "bodies": _bodies(mechanism),
        "clearances": _clearances(mechanism),
        "loads": _loads(system),
        "outlines": _outlines(mechanism),
    }


def _outlines(mechanism: Mechanism) -> list[str]:
    """Shapes that stay those of the file, whatever numbers are changed."""
    kinds = {"pitch circles": (Gear, Rack), "outlines of cams": (Cam,)}
    return [
        name
        for name, kind in kinds.items()
        if any(isinstance(part, kind) for part in mechanism.components)
    ]


def _coordinate(system: System, body: str) -> str:
    """The name of the series that is the coordinate of a body."""
    variable = coordinate_of(system.mechanism.bodies[body].kind)
    return _series(system)[(variable, body)]


def _series(system: System) -> dict[tuple[str, str], str]:
    """Output and element → name of the series, of outputs with one value for each element."""
    found = {}
    for series in system_series(system).values():
        if len(series.place) == 1:
            (element,) = series.place.values()
            found[(series.variable, element)] = series.name
    return found


Given: TypeAlias = tuple[float, str]
"""A number and the path of the parameter that it is, by which a page knows it when it changes."""


def _given(number: Parameter) -> Given:
    return number.value, ".".join(map(str, number.path))


def _bodies(mechanism: Mechanism) -> list[dict[str, Any]]:
    """Bodies with the joints by which they are gripped, and how it is told how they are turned."""
    return [
        {
            "name": name,
            "joints": [] if body.kind in PLAYING else list(body.points),
            "guide": _guide(mechanism, body),
            "pair": _pair(body),
            "follows": _follows(mechanism, name),
        }
        for name, body in mechanism.bodies.items()
    ]


def _guide(mechanism: Mechanism, body: Body) -> dict[str, Any] | None:
    """The axis of a slider: its direction and where it begins, from a joint of what carries it."""
    if body.guide is None:
        return None
    guide, carrier = body.guide, mechanism.bodies.get(body.guide.body or "")
    joint, own = next(iter(carrier.points.items()), (None, None)) if carrier else (None, None)
    origin = None if isinstance(guide.origin, str) else [_given(number) for number in guide.origin]
    return {
        "body": guide.body,
        "angle": _given(guide.angle),
        "origin": origin,
        "joint": joint,
        "own": own and [_given(number) for number in own],
    }


def _pair(body: Body) -> dict[str, Any] | None:
    """The two joints of a body that are farthest apart, and where they are in its own frame."""
    own = {name: (x.value, y.value) for name, (x, y) in body.points.items()}
    pairs = [(dist(own[a], own[b]), a, b) for a, b in combinations(own, 2)]
    far, first, second = max(pairs, default=(0.0, "", ""))
    if body.guide is not None or not far:
        return None
    places = [[_given(number) for number in body.points[joint]] for joint in (first, second)]
    return {"joints": [first, second], "places": places}


def _follows(mechanism: Mechanism, name: str) -> dict[str, Any] | None:
    """The weld or gear that says how a body follows others."""
    for relation in mechanism.relations:
        if relation.body == name and mechanism.bodies[name].rotates:
            parts = [(other, _given(ratio)) for other, ratio in relation.parts]
            return {"offset": _given(relation.offset), "parts": parts}
    return None


def _clearances(mechanism: Mechanism) -> list[dict[str, Any]]:
    """Journals and bearings: the joint, the centre of the bearing, the radial clearance."""
    found = []
    for hole, joint in clearance_ends(mechanism).items():
        name = hole.removeprefix(f"{joint}.")
        own = next(own for own in mechanism.clearances if own.name == name)
        found.append({"name": name, "joint": joint, "bearing": hole, "size": own.size,
                      "force": f"{name}.force"})  # fmt: skip
    return found


def _loads(system: System) -> list[dict[str, Any]]:
    """Loads with what they act along, and the series that says how much."""
    known, model = _series(system), system.model
    found = []
    for load in model.loads:
        series = known.get((ACTING[load.dimension], load.label))
        where = _acting(system.mechanism, load.load.measure)
        if series is not None and where is not None:
            found.append({"series": series, **where})
    return found


def _acting(mechanism: Mechanism, measure: Measure) -> dict[str, Any] | None:
    """Where a load acts and which way; None where the joints of a body do not tell."""
    match measure:
        case Distance(first, second):
            return {"kind": "between", "joints": [first, second]}
        case Coordinate(joint, axis):
            return {"kind": "fixed", "joint": joint, "axis": axis}
        case BodyAxis(joint, body, axis):
            return {"kind": "turning", "joint": joint, "body": body, "axis": axis}
        case Slide(body):
            guide, points = mechanism.bodies[body].guide, mechanism.bodies[body].points
            if guide is None or not points:
                return None
            return {"kind": "along", "joint": next(iter(points)), "body": body}
        case Turn(body):
            points = mechanism.bodies[body].points
            pivots = [joint for joint in points if joint in mechanism.ground] or [*points]
            return {"kind": "about", "joint": pivots[0]} if pivots else None
        case _:
            assert_never(measure)
