"""The equations of a mechanism as routines, with names and numbers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import Parameter
from linkages.exports.writers.definition_numbers import REFUSED, Feed, feed_of
from linkages.kernel.assembly import turning
from linkages.kernel.code.program import Program, write_routines
from linkages.kernel.code.statements import Routine
from linkages.kernel.differentiation import derivative_along
from linkages.kernel.layout import Layout
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Level, Scalar, reachable
from linkages.kernel.state_jumps import transition_nodes
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.reading.paths import KeyPath
from linkages.solution.joint_reactions import Statics, row_of
from linkages.solution.motion import movable, passes
from linkages.solution.plan import KernelSource, kernel_source, switching_of
from linkages.solution.series import REACTIONS, TIME, Series, system_series
from linkages.solution.stop_messages import (
    COULD_PASS,
    FOUND_NONE,
    block_alignment,
    block_stop,
    joint_of,
)
from linkages.solvers.flow import Switching
from linkages.solvers.trajectory import Outcome
from linkages.topology.assur_groups import ITERATED

MOST = 200
"""Unknown forces; a program that solves for more at every time takes seconds for a motion."""


def reaction_nodes(model: Model) -> list[Scalar]:
    """Reactions in the order of `row_of`: x and y of one joint after the other, of pins, of guides.

    None at all for mechanisms with more than `MOST` unknown forces.
    """
    graph = model.graph

    def nodes(wanted: Sequence[Scalar]) -> Any:
        return np.array([*wanted, None], dtype=object)[:-1, None]  # None keeps it from being empty

    def number(parameter: Parameter) -> Scalar:
        if parameter.path:
            return model.inputs.parameter(parameter)
        return graph.number(parameter.value)  # structure

    statics = Statics(model, model.topology, 1, nodes, number)
    matrix, right = (part[0] for part in statics.equations())
    if sum(matrix.shape) > MOST:
        return []
    forces = _solved(model, matrix, right)
    if not len(forces):
        return [graph.zero] * 2 * len(model.topology.joints)
    result = statics.at_places(np.array([forces], dtype=object))
    return [graph.lift(entry) for entry in result.ravel()]


def _solved(model: Model, matrix: Any, right: Any) -> list[Scalar]:
    """The forces; those with the least sum of squares where constraints are redundant.

    These are f = Aᵀ λ with A f = b, one larger system: products of A with itself would be worse
    conditioned.
    """
    graph, (rows, columns) = model.graph, matrix.shape
    if rows != columns:
        above = np.hstack([np.eye(columns), -matrix.T])
        below = np.hstack([matrix, np.zeros((rows, rows))])
        matrix, right = np.vstack([above, below]), np.concatenate([np.zeros(columns), right])
    entries = [[graph.lift(entry) for entry in row] for row in matrix]
    return graph.solve(entries, [graph.lift(entry) for entry in right])[:columns]


Floats = NDArray[np.float64]

STEP_TOO_SMALL, NOT_BACK, SINGULAR, SLIDING, CHATTER = -2, -3, 1000, 2000, 3000
"""Statuses with which motions end; the last three are added to the number of a block or mode."""

_LEFT_OUT = ("joint_jerk", "closure_residual")
"""Outputs that cost more than all others together, and that say nothing of another program."""

_RATES = (
    "equations",
    "Accelerations, settled coordinates, functions of modes, margins, rates.",
)
_SETTLE = "settle", "Whole turns of angles that springs feel."
_OUTPUTS = "quantities", "Outputs; accelerations stand behind the state."

_HOLD = "hold", "What modes stand for with which a motion sticks."
_DERIVE = (
    "derive",
    "Derivatives along a direction: of accelerations, modes' functions and values, margins.",
)
_FURTHER = "derive_outputs", "Derivatives of outputs along a direction, which has those as well."
_CHANGE = "become", "What is remembered, and new rates, where a mode changes."


@dataclass(frozen=True)
class Quantity:
    """An output of a program.

    `name`, `variable`, `unit`, `label`: as solutions have them.
    """

    name: str
    variable: str
    unit: str
    label: str


@dataclass(frozen=True)
class Exported:
    """What is written in a language."""

    system: System  # the mechanism
    feed: Feed  # how parameters and initial state follow from numbers of the definition file
    # ``prepare(p)``, ``clock(t, p, timed)``, ``equations(y, p, timed, out)``, and with the same
    # arguments ``settle``, ``quantities`` and ``become``
    program: Program
    parameters: tuple[KeyPath, ...]  # paths of parameters
    state: Floats  # the initial state
    p: Floats  # all that stands in the array of parameters at the start
    quantities: tuple[Quantity, ...]  # what ``quantities`` writes
    margin_scale: Floats  # sizes of the margins of blocks at the start
    turned: tuple[int, ...]  # places of the parameters that ``settle`` writes
    # Contacts and friction that change the equations; None if there are none
    switching: Switching | None
    # Whether motions go on through change points where `linkages.simulate` does by these options.
    # Redundant constraints let both go on
    passing: bool
    stuck: tuple[int, ...]  # numbers of modes that may stick, whose values ``hold`` writes
    # Places of the parameters that inputs set; there are routines ``derive`` and ``derive_outputs``
    # then, which take a direction behind the accelerations
    inputs: tuple[int, ...] | None

    @property
    def sides(self) -> tuple[int, ...]:
        """Places of the parameters that tell the assembly branches of blocks; -1 where none do."""
        places = self.system.model.inputs.parameters
        return tuple(places.get(("side", block), -1) for block in self.blocks)

    @property
    def blocks(self) -> tuple[int, ...]:
        """Numbers of the blocks that have margins."""
        return tuple(block.index for block in self.system.topology.solved_blocks)

    @property
    def modes(self) -> tuple[str, ...]:
        """Names of what changes the equations."""
        return () if self.switching is None else self.switching.names

    @property
    def routines(self) -> tuple[Routine, ...]:
        """All that is written, in the order of its calls."""
        return (self.feed.routine, *self.program.routines)

    @property
    def sizes(self) -> dict[str, int]:
        """Array → number of its entries."""
        return {
            array: size
            for routine in self.routines
            for array, size in routine.arguments.items()
            if array not in ("out", "t")
        }

    @property
    def written(self) -> int:
        """Number of entries that ``equations`` writes."""
        return self.program.routines[2].arguments["out"]

    @property
    def statuses(self) -> dict[int, str]:
        """Status → what it means."""
        result = {
            REFUSED: "these numbers do not lead to the same equations",
            STEP_TOO_SMALL: str(Outcome.STEP_TOO_SMALL),
            NOT_BACK: f"{', '.join(self.modes)}: what remembers or jumps cannot be followed "
            "backward in time, for a state does not say where it came from",
        }
        for number, name in enumerate(self.modes):
            result[SLIDING + number] = f"{name}: {Outcome.SLIDING}"
            result[CHATTER + number] = f"{name}: {Outcome.CHATTER}"
        for block in self.system.topology.solved_blocks:
            model = self.system.model
            joint = joint_of(model, block)
            names = " and ".join(block.unknowns)
            text = f"the mechanism cannot be assembled: joint {joint}, {block.title} of {names}"
            if block.kind != ITERATED:
                text += f" (at the limit {block_alignment(model, block.index)})"
            result[1 + block.index] = text
            way_on = FOUND_NONE if self.passing else COULD_PASS
            if self.passing and movable(self.system):
                way_on = f"{FOUND_NONE} in these free coordinates, and programs keep to theirs"
            stop = block_stop(model, block.index, singular=True, way_on=way_on)
            remedy = f". {Outcome.SINGULAR.remedy}" if len(self.state) else ""
            result[SINGULAR + block.index] = f"{stop}{remedy}"
        return result


def exported(
    system: System,
    variables: Sequence[str] | None = None,
    run: RunOptions | None = None,
    inputs: Sequence[KeyPath] | None = None,
) -> Exported:
    """All that programs need of a mechanism.

    `inputs`: paths of the parameters of loads that another program gives; they are no outputs.
    """
    source = kernel_source(system.topology)
    model = source.model
    margins = [*model.margins, *model.margin_rates]
    equations = [*source.accelerations, *model.settled, *source.switched, *margins]
    changed = transition_nodes(model, Layout.of(system.topology))
    turned = turning(model)
    turns = [_whole_turns(node) for node in turned.values()]
    result = _quantities(system, variables)
    places = model.inputs.parameters
    set_from_outside = None if inputs is None else tuple(places[path] for path in inputs)
    if inputs is not None:
        given = {load.label for load in model.loads if load.load.path in inputs}
        result = {name: s for name, s in result.items() if given.isdisjoint(s.place.values())}
    reactions = []
    if any(one.variable in REACTIONS for one in result.values()):
        reactions = reaction_nodes(model)
    if not reactions:
        result = {name: one for name, one in result.items() if one.variable not in REACTIONS}
    outputs = [
        reactions[row_of(series, model)] if series.variable in REACTIONS else series.node(model)
        for series in result.values()
    ]
    held_modes = model.switches.equivalent
    wanted = {_RATES: equations, _SETTLE: turns, _OUTPUTS: outputs, _HOLD: [*held_modes.values()]}
    if set_from_outside is not None:
        wanted[_DERIVE], wanted[_FURTHER] = _derivatives(source, outputs, set_from_outside)
    wanted[_CHANGE] = changed
    program = write_routines(model, wanted, "what the routine says")
    used = [
        node
        for node in reachable([*equations, *turns, *outputs, *changed])
        if node.operation in ("input", "spline")
    ]
    count, held = program.parameters[0], program.held
    p = np.zeros(sum(program.parameters) + held)
    p[:count] = system.parameters
    p[[*(set_from_outside or ())]] = 0.0
    if held:
        p[-held:] = system.starting_held()
    return Exported(
        system=system,
        feed=feed_of(system, [node for node in used if node.operation == "input"]),
        program=program,
        parameters=tuple(places),
        state=system.state.copy(),
        p=p,
        quantities=tuple(_described(model, series) for series in result.values()),
        margin_scale=system.margin_scale,
        turned=tuple(places["turns", load] for load in turned),
        switching=switching_of(model, Layout.of(system.topology)),
        passing=passes(system, run or system.mechanism.simulation)
        or bool(system.topology.redundant),
        stuck=tuple(held_modes),
        inputs=set_from_outside,
    )


def _derivatives(
    source: KernelSource, outputs: Sequence[Scalar], given: Sequence[int]
) -> tuple[list[Scalar], list[Scalar]]:
    """Derivatives along a direction: of accelerations, modes and margins; of outputs.

    The direction has an entry for each of the state and of the inputs, then for accelerations and
    for values of modes that stick. Coordinates that are carried along follow from the others, whose
    derivatives do not depend on where iterations begin.
    """
    model = source.model
    graph, inputs, n = model.graph, model.inputs, model.inputs.coordinates
    moving, held = range(n - len(model.topology.carried)), model.switches.equivalent
    first = 2 * n + len(given)
    state = [(k, inputs.coordinate(k)) for k in moving]
    state += [(n + k, inputs.rate(k)) for k in moving]
    state += [(2 * n + k, graph.input("p", p, Level.PARAMETERS)) for k, p in enumerate(given)]
    further = [*map(inputs.acceleration, range(n)), *map(inputs.mode, held)]

    def along(places: Iterable[tuple[int, Scalar]], nodes: Sequence[Scalar]) -> list[Scalar]:
        direction = {node.index: graph.input("seed", k, Level.STATE) for k, node in places}
        return [rate for (rate,) in derivative_along(nodes, [direction])]

    functions = source.switched[: len(source.switched) // 2]
    return (
        along(state, [*source.accelerations, *functions, *held.values(), *model.margins]),
        along([*state, *enumerate(further, first)], outputs),
    )


def _whole_turns(angle: Scalar) -> Scalar:
    """The multiple of 2π that is nearest to an angle."""
    graph = angle.graph
    return graph.apply("floor", angle / (2 * np.pi) + 0.5) * (2 * np.pi)


def _asked(variable: str, variables: Sequence[str] | None) -> bool:
    return variable not in _LEFT_OUT if variables is None else variable in variables


def _quantities(system: System, variables: Sequence[str] | None) -> dict[str, Series]:
    """What follows from the motion at one time."""
    return {
        name: series
        for name, series in system_series(system).items()
        if series.variable != TIME
        and _asked(series.variable, variables)
        and (series.variable in REACTIONS or not VARIABLES[series.variable].whole)
        and VARIABLES[series.variable].reduced is None
    }


def _described(model: Model, series: Series) -> Quantity:
    variable: Any = VARIABLES[series.variable]
    unit, label = variable.described(model)
    if variable.unit_of is not None:
        unit = variable.unit_of(model)[series.index(model)]
    return Quantity(series.name, series.variable, unit, label)
