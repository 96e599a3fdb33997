"""The assembly branch at the start, chosen from the hints of the definition file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.load_measures import GROUND
from linkages.components.contributed.terms import Body, point_words
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.scene import FreeAngle
from linkages.errors import InputError
from linkages.kernel.assembly_branches import Assembly, Choice, GrowingPlace, Place
from linkages.kernel.dyads import LinkAndSlider, LinkInGuide, TwoLinks
from linkages.kernel.inputs import wound_angles
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar, components
from linkages.reading.wording import TOO_LARGE
from linkages.topology.assur_groups import ITERATED, Block
from linkages.topology.decomposition import gruebler_mobility, topology_graph, unreachable_bodies
from linkages.topology.topology import explained

_POSITION = "expected its approximate position, such as [0.5, 0]"


class SeveralPlacesError(InputError):
    """A mechanism fits together in several ways, and the definition does not say in which."""


def assemble(place: Place, near: Mapping[str, NDArray[np.float64]] | None = None) -> Assembly:
    """Choose among the modes of each block: those nearest to `near`, or by the hints of the file.

    Without a hint a slider lies forward of its link along the axis.
    """
    model = place.model
    place = growing = GrowingPlace(place)
    _check_laws(place)
    if near is None and not model.topology.redundant:
        _check_hints(place)
    result = Assembly()
    assumed: list[int] = []
    for block in model.topology.solved_blocks:
        _check_reach(place, block, result)
        choices = place.choices(block, result)
        if not choices:
            raise _no_solution(place, block)
        if near is None:
            choice = _hinted(place, block, result, choices)
        else:
            choice = _nearest(place, block, result, choices, near)
        if choice is None:
            if len(choices) > 1 and block.kind not in ("RRP", "RPR"):
                raise _missing_hint(place, block, result, choices)
            choice = choices[0]
            if len(choices) > 1:
                assumed.append(block.index)
        result = result.with_choice(block, choice)
        growing.settle(block, choice)
    # whole turns in the angles from which torsional springs are deflected: of angles that the
    # definition does not give only the direction is known, so that they start within half a turn
    angles = turning(model)
    differences = place.values(list(angles.values()), result)
    turns = (float(2 * np.pi * np.round(value / (2 * np.pi))) for value in differences)
    turned = dict(zip(angles, turns, strict=True))
    return Assembly(result.sides, result.values, turned, tuple(assumed))


def _check_laws(place: Place) -> None:
    mechanism, laws = place.mechanism, place.model.positions.laws
    nodes = [node for law in laws.values() for node in (law.value, law.rate, law.acceleration)]
    found = np.array(place.values(nodes, Assembly())).reshape(-1, 3)
    for name, values in zip(laws, found, strict=True):
        if not np.isfinite(values).all():
            drive = mechanism.prescribed[name]
            message = f"expected a law with finite derivatives at t = {place.time:g} s, found "
            raise mechanism.error(
                [(drive.path, message + ", ".join(f"{value:g}" for value in values))]
            )


def turning(model: Model) -> dict[int, Scalar]:
    """Angles that laws feel with their whole turns, where only their direction is known."""
    topology = model.topology
    given = {*topology.driven, *topology.free}
    nodes = [*model.loads, *model.sensed.values(), *(end.along for end in model.ends)]
    result: dict[int, Scalar] = {}
    for place, angle in wound_angles(model.mechanism).items():
        owners = (m for body in angle.bodies for m in topology.orientations[body].masters)
        masters = {m for m in owners if topology.mechanism.bodies[m].rotates}
        if not masters <= given:
            result[place] = nodes[place].displacement
    return result


def placed_joints(model: Model, block: Block) -> list[str]:
    """Joints that a block places, in the order of the mechanism."""
    bodies = {body for body, _, _ in block.placements}
    placed = model.topology.placed
    points = (point for body in bodies for point in placed.get(body, ()))
    number = model.positions.numbers
    return sorted((point for point in points if point in number), key=number.__getitem__)


def place_nodes(model: Model, joints: Iterable[str]) -> list[Scalar]:
    """Where joints are: x and y of one after the other."""
    return components(model.positions.joints[joint] for joint in joints)


def _check_reach(place: Place, block: Block, assembly: Assembly) -> None:
    dyad = place.model.positions.dyads[block.index]
    if not isinstance(dyad, TwoLinks | LinkAndSlider | LinkInGuide):
        return
    assert dyad.radicand is not None
    (radicand,) = place.values([dyad.radicand], assembly)
    if radicand >= 0.0:
        return
    mechanism, loop = place.mechanism, block.loops[0]
    one, other = block.unknowns
    apex, start, end = (point_words(p, "") for p in (loop.apex, loop.start, loop.end))
    if np.isinf(place.values([dyad.margin_scale], assembly)[0]):
        message = f"{one} and {other} are too long for double precision. {TOO_LARGE}"
    elif isinstance(dyad, TwoLinks):
        nodes = [dyad.gap_square, dyad.first_square, dyad.second_square]
        bridge, first, second = (value**0.5 for value in place.values(nodes, assembly))
        expected = f"expected between {abs(first - second):.6g} m and {first + second:.6g} m"
        if bridge == 0:
            expected = "expected two places, since a direction follows from two"
        message = (
            f"{one} and {other} ({first:.6g} m and {second:.6g} m) cannot meet at {apex}: "
            f"their other ends {start} and {end} are {bridge:.6g} m apart at t = 0; "
            f"{expected}"
        )
    elif isinstance(dyad, LinkAndSlider):
        across, length = place.values([dyad.across, dyad.margin_scale], assembly)
        message = (
            f"{one} ({length:.6g} m) cannot reach the axis of {other}: {start} is "
            f"{abs(across):.6g} m away from it at t = 0; expected at most {length:.6g} m"
        )
    else:
        square, across = place.values([dyad.gap.square, dyad.across], assembly)
        message = (
            f"the axis of {other} on {one} cannot reach its pin: {start} and {end} are "
            f"{square**0.5:.6g} m apart at t = 0; expected at least {abs(across):.6g} m"
        )
    path = mechanism.bodies[one].path
    raise mechanism.error([(path, f"cannot be assembled: {message}")])


def _no_solution(place: Place, block: Block) -> InputError:
    mechanism, topology = place.mechanism, place.model.topology
    bodies = ", ".join(block.unknowns)
    path = mechanism.bodies[block.unknowns[0]].path
    message = f"cannot be assembled: no position of {bodies} closes the {block.label} at t = 0"
    if block.surplus:
        message += (
            f"; the constraints at {topology.redundant_places} contradict each other: expected "
            "dimensions that fit, or fewer driven and free coordinates (the mobility is "
            f"{topology.mobility})"
        )
    return mechanism.error([(path, message)])


def _nearest(
    place: Place,
    block: Block,
    assembly: Assembly,
    choices: list[Choice],
    near: Mapping[str, NDArray[np.float64]],
) -> Choice:
    """The choice that puts the points of a block closest to given places."""
    bodies = {body for body, _, _ in block.placements}
    points = [point for point, body in place.model.topology.placing.items() if body in bodies]
    nodes = place_nodes(place.model, points)
    wanted = np.array([near[point] for point in points]).ravel()

    def distance(choice: Choice) -> float:
        result = place.values(nodes, assembly.with_choice(block, choice))
        return float(np.linalg.norm(np.array(result) - wanted))

    return min(choices, key=distance)


def _hinted(place: Place, block: Block, assembly: Assembly, choices: list[Choice]) -> Choice | None:
    """The choice that hints ask for; None if there are none for this block."""
    model, mechanism = place.model, place.mechanism
    joints = [joint for joint in placed_joints(model, block) if joint in mechanism.hints]
    if len(joints) > 1:
        joints = [joint for joint in mechanism.hints if joint in joints]
    hints = [mechanism.hints[joint] for joint in joints]
    sides = [hint.side for hint in hints if hint.side is not None]
    if sides:
        return sides[0]
    if not hints or len(choices) == 1:
        return None
    nodes = place_nodes(model, [hint.joint for hint in hints])
    wanted = np.array([hint.position for hint in hints], dtype=float).ravel()
    places = np.array([place.values(nodes, assembly.with_choice(block, c)) for c in choices])
    distances = np.linalg.norm(places - wanted, axis=1)
    order = np.argsort(distances, kind="stable")
    best, second = order[0], order[1]
    size = float(np.linalg.norm(places[best] - places[second]))
    if distances[second] - distances[best] <= 1e-6 * size:
        message = "lies as near to one possible place as to the other; expected nearer to one"
        raise mechanism.error([(hints[0].path, message)])
    return choices[best]


def _check_hints(place: Place) -> None:
    """A side makes sense only where two links meet."""
    model, mechanism = place.model, place.mechanism
    apexes = {j: b for b in model.topology.solved_blocks for j in placed_joints(model, b)}
    result = []
    for joint, hint in mechanism.hints.items():
        block = apexes.get(joint)
        meets = block is not None and block.kind == "RRR" and joint in _between(block)
        if hint.side is not None and not meets:
            result.append((hint.path, _no_sides(model, joint, block)))
    if result:
        raise explained(mechanism, mechanism.error(result))


def _between(block: Block) -> list[str]:
    """Joints between the unknown links of a block."""
    return [step.end for step in block.loops[0].steps[:-1]]


def _meeting_joint(model: Model, block: Block) -> str:
    """The joint between unknown links, by a name that stands in definition files."""
    apex = block.loops[0].apex
    displaced = {term.renamed for term in model.mechanism.displacements}
    named = [joint for joint in model.topology.joints if joint not in displaced]
    return next((joint for joint in (apex, *_between(block)) if joint in named), apex)


def _no_sides(model: Model, joint: str, block: Block | None) -> str:
    if block is None:
        return f"joint {joint} has one possible place only; expected no side"
    if block.kind == ITERATED:
        return f"joint {joint} is in a {block.title}; {_POSITION}"
    if block.kind == "RRR":
        meeting = _meeting_joint(model, block)
        return f"left and right belong to joint {meeting}, where the two links meet"
    return f"joint {joint} moves along an axis; {_POSITION}"


def _missing_hint(
    place: Place, block: Block, assembly: Assembly, choices: list[Choice]
) -> InputError:
    model, mechanism = place.model, place.mechanism

    def places_of(joint: str) -> list[list[float]]:
        nodes = place_nodes(model, [joint])
        return [place.values(nodes, assembly.with_choice(block, choice)) for choice in choices]

    joint = _meeting_joint(model, block)
    if block.kind == ITERATED:  # the joint that tells the ways apart best
        joint = max(placed_joints(model, block), key=lambda j: np.ptp(places_of(j), axis=0).max())
    result = places_of(joint)
    places = [", ".join(f"{value:.4g}" for value in values) for values in result]
    if block.kind == ITERATED:
        listed = ", ".join(f"[{text}]" for text in places)
        message = (
            f"the {block.label} can be assembled in {len(choices)} ways; expected approximate "
            f"positions of its joints, as '{joint}: [x, y]' ({joint} would be at {listed})"
        )
    else:
        message = (
            f"joint {joint} can be in two places; expected '{joint}: left' (at [{places[0]}]) or "
            f"'{joint}: right' (at [{places[1]}])"
        )
    problem = mechanism.problem(("assembly",), message)
    return SeveralPlacesError(mechanism.source, [problem])


MOST_CHOICES = 200
"""How many sets of free coordinates are tried where the file names none."""


def possible_choices(mechanism: Mechanism) -> Iterator[Mechanism]:
    """A mechanism with the free coordinates that it lacks, in all ways, at most `MOST_CHOICES`.

    Clearances are always free. Beyond them, ground-connected bars are taken whose position at
    t = 0 follows from the `assembly` section.
    """
    known = len(mechanism.prescribed) + len(mechanism.initial)
    needed = gruebler_mobility(mechanism) - known
    if needed <= 0 or unreachable_bodies(topology_graph(mechanism)):
        return
    candidates = [c for body in mechanism.bodies.values() if (c := _candidate(mechanism, body))]
    for choice in islice(combinations(candidates, needed), MOST_CHOICES):
        completed = mechanism
        for component in choice:
            completed = completed.with_component(component)
        yield completed


def _candidate(mechanism: Mechanism, body: Body) -> FreeAngle | None:
    """The angle of a bar on the ground, if the place of another of its joints is known.

    A point that a clearance displaces is as good as at its joint.
    """
    followers = (relation.body for relation in mechanism.relations)
    taken = body.name in {*mechanism.prescribed, *mechanism.initial, *followers}
    pins = [joint for joint in body.points if joint in mechanism.ground]
    beside = {term.renamed: term.joint for term in mechanism.displacements}
    hints = [(j, mechanism.hints.get(beside.get(j, j))) for j in body.points if j not in pins]
    places = [(j, hint.position) for j, hint in hints if hint is not None and hint.position]
    if taken or not body.rotates or not pins or not places or body.name == GROUND:
        return None
    joint, place = places[0]
    origin = [value.value for value in mechanism.ground[pins[0]]]
    pin, point = ([value.value for value in body.points[j]] for j in (pins[0], joint))
    direction = np.arctan2(place[1] - origin[1], place[0] - origin[0])
    own = np.arctan2(point[1] - pin[1], point[0] - pin[0])
    return FreeAngle(name=body.name, angle=float(direction - own))
