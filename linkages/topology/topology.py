"""The topology of a mechanism: coordinates, mobility, blocks, causes of misfits."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Guide, Relation, point_words
from linkages.components.mechanisms.declared_names import any_hint
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.discovery import html_of
from linkages.errors import InputError
from linkages.reading.paths import KeyPath
from linkages.reading.wording import listed, nearest
from linkages.topology.assur_groups import ITERATED, Block, BlockBuilder, Loop, Step
from linkages.topology.decomposition import (
    Orientation,
    StructureError,
    bodies_at,
    followers_of,
    gruebler_mobility,
    leaders_first,
    loop_count,
    orientations,
    single_joints,
    solution_order,
    topology_graph,
    turned_bodies,
    unreachable_bodies,
)

Finding = tuple[KeyPath, str]

_JOINTS = {"bar": "joints", "plate": "points", "slider": "joint"}
"""Key under which a body names its joints."""

FEW = 12
"""Free coordinates up to which the matrix J_ij is eliminated as a whole, which then costs less."""


def explained(mechanism: Mechanism, error: InputError) -> InputError:
    """An error of mobility or assembly, after what most likely causes it."""
    result = _misspelt(mechanism) or _grounded(mechanism) or _overdriven(mechanism)
    if result is None:
        return error
    path, message = result
    otherwise = "; ".join(problem.message for problem in error.problems)
    stop = "" if message.endswith("?") else "."
    return mechanism.error([(path, f"{message}{stop} Otherwise: {otherwise}")])


def _misspelt(mechanism: Mechanism) -> Finding | None:
    used = _used(mechanism)
    singles = single_joints(mechanism)
    joints = {joint for body in mechanism.bodies.values() for joint in body.points}
    styles = Counter(joint.isupper() for joint in joints)
    # of two names the odd one has unusual capitals, or comes later
    later_first = [*reversed(singles.items())]
    for joint, name in sorted(later_first, key=lambda single: styles[single[0].isupper()]):
        body = mechanism.bodies[name]
        near = nearest(joint, sorted((joints | set(mechanism.ground)) - set(body.points)))
        if near is not None and joint not in used:
            message = f"joint {joint!r} is on one body only, {name}; did you mean {near!r}?"
            return (*body.path, _JOINTS[body.kind]), message
    return None


def _used(mechanism: Mechanism) -> set[str]:
    """Joints that loads, masses and the like name: they may well be on one body only."""
    return {
        joint
        for component in mechanism.components
        if not any_hint(component.terms())
        for _, joint in (*component.references().joints, *component.references().moving)
    }


def _grounded(mechanism: Mechanism) -> Finding | None:
    for name, body in mechanism.bodies.items():
        fixed = [joint for joint in body.points if joint in mechanism.ground]
        if body.rotates and len(fixed) > 1:
            return body.path, (
                f"{name} cannot move: its joints {listed(fixed, 'and')} are fixed to the ground; "
                "expected under 'joints' only those that do not move"
            )
    return None


def _overdriven(mechanism: Mechanism) -> Finding | None:
    mobility = gruebler_mobility(mechanism)
    driven, free = list(mechanism.prescribed), list(mechanism.initial)
    surplus = len(driven) + len(free) - mobility
    if mobility < 1 or surplus < 1:
        return None  # without a mobility by count it is redundancy that lets a mechanism move
    paths = [e.path for e in mechanism.initial.values()]
    paths += [e.path for e in mechanism.prescribed.values()]
    message = f"{mobility_words(mechanism, mobility)}; remove {surplus} of them"
    return paths[-1], message


def mobility_words(mechanism: Mechanism, mobility: int) -> str:
    """How many coordinates may be given, and which are."""
    driven, free = list(mechanism.prescribed), list(mechanism.initial)
    are = "coordinate is" if len(driven) == 1 else "coordinates are"
    names = [f" ({', '.join(names)})" if names else "" for names in (driven, free)]
    result = f"mobility is {mobility}, but {len(driven)} {are} driven{names[0]}"
    return f"{result} and {len(free)} free{names[1]}"


def wrong_mobility(mechanism: Mechanism, mobility: int) -> InputError:
    """Drives and free coordinates do not match the mobility."""
    driven, free = len(mechanism.prescribed), len(mechanism.initial)
    if driven + free > mobility:
        remedy = "expected as many as the mobility: remove a drive or a free coordinate"
    else:
        remedy = (
            "expected as many as the mobility: add a drive, or name a bar under 'free' with its "
            "initial angle"
        )
        ends = ", ".join(f"{j} (of {body})" for j, body in single_joints(mechanism).items())
        if ends:
            remedy += f"; or is one of the joints mistyped that a single body has: {ends}?"
    path: KeyPath = ("drives",) if mechanism.prescribed else ("free",) if mechanism.initial else ()
    return mechanism.error([(path, f"{mobility_words(mechanism, mobility)}; {remedy}")])


def _miscounted(mechanism: Mechanism) -> InputError:
    """Actuators that are not as many as the coordinates that they move."""
    own, driven = len(mechanism.actuations), list(mechanism.prescribed)
    names = f" ({', '.join(driven)})" if driven else ""
    message = (
        f"found {own} for {len(driven)} driven coordinates{names}; expected as many, since "
        "together they make the motion of all drives"
    )
    return mechanism.error([(("actuators",), message)])


def undetermined(mechanism: Mechanism, error: StructureError) -> InputError:
    """Some coordinates follow from no equation."""
    result: list[Finding] = [
        (mechanism.bodies[body].path, f"nothing determines the coordinate of {body!r}")
        for body in error.surplus
    ]
    if error.contested:
        joints = ", ".join(error.contested)
        message = (
            f"more constraints than coordinates at {joints}; expected the drives and free "
            "coordinates to be independent of each other"
        )
        result.append(((), message))
    return mechanism.error(result)


@dataclass(frozen=True)
class Topology:
    """How the bodies of a mechanism hang together."""

    mechanism: Mechanism  # the mechanism
    graph: nx.MultiGraph  # bodies are nodes, joints are edges
    driven: tuple[str, ...]
    free: tuple[str, ...]
    dependent: tuple[str, ...]
    followers: dict[str, Relation]  # body → the weld or gear that its angle follows from
    orientations: dict[str, Orientation]  # body → what its orientation depends on
    turned: frozenset[str]  # bodies whose angle counts with its whole turns
    blocks: tuple[Block, ...]  # in an order in which positions can be solved
    placing: dict[str, str]  # point → the body that places it (points of the ground are missing)
    entry: dict[str, str]  # body → the point that it is placed from
    mobility: int  # by the Chebychev–Grübler–Kutzbach criterion
    loops: int  # number of independent loops
    redundant: tuple[str, ...]  # joints at which constraints repeat others (or contradict them)

    def _repr_html_(self) -> str:
        """What notebooks show: mobility, and blocks in their order of solution."""
        return html_of(self)

    @property
    def redundant_places(self) -> str:
        """What messages call the places where constraints repeat others."""
        return ", ".join(point_words(joint, "") for joint in self.redundant)

    @cached_property
    def iterated(self) -> tuple[str, ...]:
        """Bodies whose coordinate comes out of an iteration, which needs a value to start from."""
        return tuple(u for b in self.blocks if b.kind == ITERATED for u in b.unknowns)

    @cached_property
    def carried(self) -> tuple[str, ...]:
        """Dependent bodies whose coordinate is integrated too, for iterations or whole turns."""
        masters, bodies = self.counting, self.mechanism.bodies
        turned = (n for n in self.dependent if n in masters and bodies[n].rotates)
        return tuple(dict.fromkeys([*self.iterated, *turned]))

    @property
    def internal(self) -> tuple[str, ...]:
        """Names of the internal states."""
        return tuple(self.mechanism.internal)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """What is integrated twice; an internal state is the rate of its coordinate."""
        return (*self.free, *self.internal, *self.carried)

    @cached_property
    def places(self) -> dict[str, int]:
        """Places of `coordinates` by name."""
        return {name: place for place, name in enumerate(self.coordinates)}

    @cached_property
    def counted(self) -> tuple[str, ...]:
        """Dependent turning bodies whose whole turns are to be counted along a motion."""
        bodies, carried = self.mechanism.bodies, self.carried
        follow = {name for name in self.followers if name in self.turned}
        return tuple(
            name
            for name in self.dependent
            if bodies[name].rotates and name not in carried and name not in follow
        )

    def leaders(self, name: str) -> list[str]:
        """Followers that the own coordinate of a body follows from."""
        relation = self.followers.get(name)
        parts = () if relation is None else relation.parts
        return [other for other, _ in parts if other in self.followers]

    def turning(self, name: str) -> tuple[str | None, list[Guide]]:
        """The body that turns a body (None: the ground), and the guides on the way to it."""
        body: str | None = name
        guides: list[Guide] = []
        while body is not None and (guide := self.mechanism.bodies[body].guide) is not None:
            guides.append(guide)
            body = guide.body
        return body, guides

    @property
    def hangs(self) -> bool:
        """Whether all bodies turn by coordinates of their own and close no loop, and are many."""
        return (
            len(self.free) > FEW
            and not self.dependent
            and not self.loops
            and not self.mechanism.contacts
            and all(body.rotates and body.guide is None for body in self.mechanism.bodies.values())
        )

    def unwrapped(self, name: str) -> bool:
        """Whether an integrated coordinate is not to be kept within one turn."""
        return name in self.counting

    @cached_property
    def counting(self) -> set[str]:
        """Bodies with a coordinate of their own that angles with whole turns depend on."""
        return {m for name in self.turned for m in self.orientations[name].masters}

    @cached_property
    def solved_blocks(self) -> tuple[Block, ...]:
        """The blocks that determine dependent coordinates."""
        return tuple(block for block in self.blocks if block.unknowns)

    @property
    def closing(self) -> tuple[Loop, ...]:
        """All loops: those that determine coordinates first, then those that are redundant."""
        idle = [block for block in self.blocks if not block.unknowns]
        return tuple(loop for block in (*self.solved_blocks, *idle) for loop in block.loops)

    @cached_property
    def joints(self) -> tuple[str, ...]:
        """All joints, the ground's first, then in the order of the file."""
        return tuple(bodies_at(self.mechanism))

    @property
    def free_ends(self) -> tuple[str, ...]:
        """Points that only one body has; a ground joint that none uses is not one."""
        return tuple(single_joints(self.mechanism))

    @cached_property
    def placed(self) -> dict[str, tuple[str, ...]]:
        """Body → the points that it places."""
        result: dict[str, list[str]] = {}
        for point, body in self.placing.items():
            result.setdefault(body, []).append(point)
        return {body: tuple(points) for body, points in result.items()}

    def path(self, joint: str) -> tuple[list[Step], str]:
        """Way from the ground to a point along the bodies that place it, and where it starts."""
        steps: list[Step] = []
        place = joint
        while place in self.placing:
            body = self.placing[place]
            steps.append(Step(body, self.entry[body], place))
            place = self.entry[body]
        return steps[::-1], place


def build_topology(mechanism: Mechanism, whole: bool = False) -> Topology:
    """Analyse a mechanism whose free coordinates are all named."""
    graph = topology_graph(mechanism)
    loose = unreachable_bodies(graph)
    if loose:
        message = "not connected to the ground by any chain of joints"
        result = [(mechanism.bodies[body].path, message) for body in loose]
        raise explained(mechanism, mechanism.error(result))
    known = dict.fromkeys([*mechanism.prescribed, *mechanism.initial])
    mobility = gruebler_mobility(mechanism)
    if mobility > len(known):
        raise explained(mechanism, wrong_mobility(mechanism, mobility))
    if mechanism.actuations and len(mechanism.actuations) != len(mechanism.prescribed):
        raise _miscounted(mechanism)
    followers = followers_of(mechanism)
    turned = orientations(mechanism, followers)
    try:
        order = solution_order(mechanism, (*known, *followers), turned, whole)
    except StructureError as error:
        raise explained(mechanism, undetermined(mechanism, error)) from None
    sliding = [name for group in order.groups for name in group.sliding]
    builder = BlockBuilder(mechanism, turned, sliding)
    blocks = tuple(builder.add(group) for group in order.groups)
    if not whole and any(block.surplus < 0 for block in blocks):
        # bodies that repeat each other: one would be turned before it is placed
        return build_topology(mechanism, whole=True)
    loose = _outside_loops(blocks, turned)
    if loose:
        raise explained(mechanism, undetermined(mechanism, StructureError(loose, ())))
    return Topology(
        mechanism=mechanism,
        graph=graph,
        driven=tuple(b for b in mechanism.bodies if b in mechanism.prescribed),
        free=tuple(b for b in mechanism.bodies if b in mechanism.initial),
        dependent=tuple(b for b in mechanism.bodies if b not in known),
        followers=followers,
        orientations=turned,
        turned=frozenset(turned_bodies(mechanism)),
        blocks=blocks,
        placing=builder.placing,
        entry=builder.entry,
        mobility=mobility,
        loops=loop_count(graph),
        redundant=order.redundant,
    )


def _outside_loops(blocks: Sequence[Block], turned: Mapping[str, Orientation]) -> list[str]:
    """Unknowns that no loop of their block moves: bodies that repeat each other hide them."""
    result = []
    for block in blocks:
        steps = [step.body for loop in block.loops for step in loop.steps]
        followed = (m for body in steps for m in (*turned[body].masters, *turned[body].moved))
        moving = {*steps, *followed}
        result += [unknown for unknown in block.unknowns if unknown not in moving]
    return result


Places = Mapping[str, NDArray[np.float64]]


def ground_loop(topology: Topology, loop: Loop) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """Both ways from the ground to the apex of a loop, without the steps that they share."""
    apex_at = next((i for i, step in enumerate(loop.steps) if step.end == loop.apex), -1)
    out = [*topology.path(loop.start)[0], *loop.steps[: apex_at + 1]]
    back = [*topology.path(loop.end)[0], *(s.reversed for s in reversed(loop.steps[apex_at + 1 :]))]
    shared = 0
    while shared < min(len(out), len(back)) and out[shared] == back[shared]:
        shared += 1
    return tuple(out[shared:]), tuple(back[shared:])


def owners(topology: Topology) -> tuple[str, ...]:
    """Bodies with a coordinate of their own: all but those that a weld or gear turns."""
    return tuple(b for b in topology.mechanism.bodies if b not in topology.followers)


def closure_jacobian(topology: Topology, places: Places, axes: Places) -> NDArray[np.float64]:
    """∂Φ/∂q with all columns scaled to unit length, shape (2·loops, coordinates).

    Rows come in the order of the blocks, those of redundant loops that determine nothing last, and
    columns in that of `owners`. `axes` has the axis of each slider, of a cam's follower times the
    slope of the lift.
    """
    rows = ClosureRows(topology, places, axes)
    jacobian = np.zeros((2 * len(topology.closing), rows.columns))
    for index, row in enumerate(rows):
        jacobian[2 * index : 2 * index + 2] = row
    # in powers of two near the largest entries, whose squares might overflow
    size = np.ldexp(1.0, np.frexp(np.abs(jacobian).max(axis=0, initial=0.0))[1] - 1)
    norms = size * np.linalg.norm(jacobian / size, axis=0)
    return jacobian / np.where(norms > 0, norms, 1.0)


class ClosureRows:
    """∂Φ/∂q loop by loop, shape (2, coordinates) each, without scales.

    Ways from the ground are arrays of numbers of steps, for those of long chains are long.
    """

    def __init__(self, topology: Topology, places: Places, axes: Places) -> None:
        self._topology, self._places, self._axes = topology, places, axes
        self._column = {body: index for index, body in enumerate(owners(topology))}
        self.columns = len(self._column)
        self._gradients, self._moves = turning_gradients(topology), moving_gradients(topology)
        steps: list[tuple[list[int], list[NDArray[np.float64]]]] = []
        self._ways: dict[str, NDArray[np.int32]] = {}
        for loop in topology.closing:
            self._find_way(loop.start, steps)
            self._find_way(loop.end, steps)
        self._counts = np.array([len(columns) for columns, _ in steps], dtype=np.intp)
        self._first = np.cumsum(self._counts) - self._counts
        self._on = np.array([column for columns, _ in steps for column in columns], dtype=np.intp)
        self._values = np.array([v for _, values in steps for v in values]).reshape(-1, 2).T

    def _entries(self, step: Step) -> tuple[list[int], list[NDArray[np.float64]]]:
        """Columns of what a step depends on, and its derivatives."""
        x, y = self._places[step.end] - self._places[step.start]
        turned = np.array([-y, x])
        columns, values = [], []
        for master, ratio in self._gradients[step.body].items():
            columns.append(self._column[master])
            values.append(ratio * turned)
        body = self._topology.mechanism.bodies[step.body]
        own = 0 if body.rotates else (step.start == body.axis) - (step.end == body.axis)
        for master, ratio in self._moves[step.body].items() if own else ():
            columns.append(self._column[master])
            values.append(own * ratio * self._axes[step.body])
        return columns, values

    def _find_way(
        self, point: str, steps: list[tuple[list[int], list[NDArray[np.float64]]]]
    ) -> None:
        """Enter the numbers of the steps from the ground to a point."""
        topology, waiting = self._topology, []
        while point not in self._ways and point in topology.placing:
            waiting.append(point)
            point = topology.entry[topology.placing[point]]
        way = self._ways.setdefault(point, np.empty(0, dtype=np.int32))
        for placed in reversed(waiting):
            body = topology.placing[placed]
            way = np.append(way, np.int32(len(steps)))
            steps.append(self._entries(Step(body, topology.entry[body], placed)))
            self._ways[placed] = way

    def __iter__(self) -> Iterator[NDArray[np.float64]]:
        for loop in self._topology.closing:
            apex_at = next((i for i, step in enumerate(loop.steps) if step.end == loop.apex), -1)
            own = [(1.0, step) for step in loop.steps[: apex_at + 1]]
            own += [(-1.0, step.reversed) for step in reversed(loop.steps[apex_at + 1 :])]
            out, back = self._ways[loop.start], self._ways[loop.end]
            shared = min(len(out), len(back))
            differing = np.flatnonzero(out[:shared] != back[:shared])
            shared = differing[0] if len(differing) else shared
            columns, values = [], []
            for sign, way in ((1.0, out[shared:]), (-1.0, back[shared:])):
                counts = self._counts[way]
                within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
                entries = np.repeat(self._first[way], counts) + within
                columns.append(self._on[entries])
                values.append(sign * self._values[:, entries])
                for step in (step for own_sign, step in own if own_sign == sign):
                    on, moved = self._entries(step)
                    columns.append(np.array(on, dtype=np.intp))
                    values.append(sign * np.array(moved).reshape(-1, 2).T)
            places, axes = np.concatenate(columns), np.concatenate(values, axis=1)
            yield np.array([np.bincount(places, axis, minlength=self.columns) for axis in axes])


def turning_gradients(topology: Topology) -> dict[str, dict[str, float]]:
    """Body → how its orientation changes with the angles of the bodies that it depends on."""
    moves = moving_gradients(topology)
    turning = {name: topology.turning(name)[0] for name in topology.mechanism.bodies}
    return {name: {} if other is None else moves[other] for name, other in turning.items()}


def moving_gradients(topology: Topology) -> dict[str, dict[str, float]]:
    """Body → how its own coordinate changes with the coordinates that it depends on."""
    bodies = topology.mechanism.bodies
    result = {name: {name: 1.0} for name in bodies if name not in topology.followers}
    for name in leaders_first(topology.followers, topology.leaders):
        total = result.setdefault(name, {})
        for other, ratio in topology.followers[name].parts:
            for master, value in result[other].items():
                total[master] = total.get(master, 0.0) + ratio.value * value
    return result


def distance_from_singular(
    topology: Topology, jacobian: NDArray[np.float64], free: Collection[str]
) -> float:
    """How well the closure determines other coordinates: its least singular value over the largest.

    Redundant equations count: they may tell which way a mechanism goes on where the others do not.
    """
    known = {*topology.driven, *free}
    columns = [i for i, name in enumerate(owners(topology)) if name not in known]
    if not columns:
        return 1.0
    values = np.linalg.svd(jacobian[:, columns], compute_uv=False)
    return float(values[len(columns) - 1] / values[0])


def numerical_mobility(jacobian: NDArray[np.float64]) -> int:
    """Number of coordinates minus the rank of the closure Jacobian."""
    if jacobian.size == 0:
        return jacobian.shape[1]
    return jacobian.shape[1] - int(np.linalg.matrix_rank(jacobian, tol=1e-9))


def block_conditions(topology: Topology, places: Places, axes: Places) -> list[float]:
    """Condition numbers of the systems that blocks solve for their unknown rates."""
    column = {body: index for index, body in enumerate(owners(topology))}
    unknown = [[column[body] for body in b.unknowns] for b in topology.solved_blocks]
    counts = [len(block.loops) for block in topology.solved_blocks]
    which = iter(np.repeat(np.arange(len(counts)), counts).tolist())
    largest, squares = np.zeros((2, len(column)))
    own: list[list[NDArray[np.float64]]] = [[] for _ in unknown]
    row: NDArray[np.float64]
    with np.errstate(over="ignore"):  # such squares are not used
        for row in ClosureRows(topology, places, axes):
            largest = np.maximum(largest, np.abs(row).max(axis=0))
            squares += row[0] * row[0]
            squares += row[1] * row[1]
            if (block := next(which, None)) is not None:
                own[block].append(row[:, unknown[block]])
    if not ((largest == 0.0) | ((largest > 1e-100) & (largest < 1e100))).all():
        jacobian = closure_jacobian(topology, places, axes)
        ends = np.cumsum(counts)
        own = [
            [jacobian[2 * (end - count) : 2 * end, columns]]
            for end, count, columns in zip(ends, counts, unknown, strict=True)
        ]
        squares = np.ones(len(column))
    norms = np.where(squares > 0.0, np.sqrt(squares), 1.0)
    return [
        float(np.linalg.cond(np.concatenate(rows) / norms[columns]))
        for rows, columns in zip(own, unknown, strict=True)
    ]
