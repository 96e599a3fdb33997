"""Basins of attraction over a plane, and their shares of a box of initial states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.matching import (
    NOWHERE,
    Attractor,
    Matched,
    clustered,
    linked,
    numbered,
    ordered,
    ranges,
    with_undecided,
)
from linkages.attractors.settling import Kind
from linkages.attractors.starts import Starts, box_words, drawn, is_state, sides_of
from linkages.chaos.contact_log import TOUCH
from linkages.chaos.diagram import free_names_of_angles, touchable
from linkages.chaos.free_states import circular, state_outputs
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import BasinKeywords, BasinOptions
from linkages.options.option import takes
from linkages.solution.plan import Plan
from linkages.sweeps.axes import (
    Axis,
    Vary,
    axis_of,
    coordinates,
    require_different,
    require_feasible,
)
from linkages.sweeps.engine import CODES, Arrays, Computed, Watch, marks, reasons
from linkages.sweeps.places import swept
from linkages.sweeps.running import Executor

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

DRAWS, CONFIDENCE = 1000, 0.95
"""States drawn from the box unless it is said, and the confidence of intervals of shares."""


@dataclass(frozen=True)
class Share:
    """Part of a box that tends to an attractor.

    `found`, `draws`: drawn states that do, and all that could be started.
    `low`, `high`: exact binomial interval (Clopper–Pearson) with a confidence of 95 %.
    """

    found: int
    draws: int
    fraction: float  # their ratio; nan without draws
    low: float
    high: float


def share(found: int, draws: int) -> Share:
    """The share of an attractor, by C. J. Clopper and E. S. Pearson, Biometrika 26 (1934) 404."""
    from scipy.stats import binomtest

    if not draws:
        return Share(0, 0, np.nan, 0.0, 1.0)
    interval = binomtest(found, draws).proportion_ci(CONFIDENCE, method="exact")
    return Share(found, draws, found / draws, float(interval.low), float(interval.high))


@takes(BasinOptions)
def basins(
    mechanism: Mechanism,
    x: Vary,
    y: Vary,
    *,
    also: Vary | Sequence[Vary] = (),
    draws: int = DRAWS,
    seed: int = 0,
    device: str = "cpu",
    executor: Executor | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    **options: Unpack[BasinKeywords],
) -> xr.Dataset:
    """All attractors that a plane or a box of initial states tends to, and their basins.

    Every motion is followed until its section points, or its states, have converged to a cycle, or
    to rest, by their measured contraction; where they do not, its largest Lyapunov exponent and the
    arrangement of its points decide. Attractors are matched by the distance of their points.

    Parameters
    ----------
    mechanism
        From a file or made in Python, with friction, damping or contact that takes energy.
    x, y
        As `linkages.chaos_map` takes them: initial values of free coordinates and their rates, such
        as ``"free.rod.angle=-180deg:180deg:200"``, or parameters.
    also
        Further ranges, of which only states are drawn; the grid has those of the definition.
    draws
        Number of states that are drawn uniformly from the box of all ranges, for the shares. Values
        of parameters are drawn from those of their range.
    seed
        Of the draws: draw i depends on seed, path and i alone.
    device, executor, store, watch
        As `linkages.bifurcation` takes them.
    options
        As `BasinOptions` describes them.

    Returns
    -------
    Dataset with `basin` (y, x) and `draw_basin` (draw), the numbers of attractors, −1 where nothing
    could be computed. Of each `attractor`: `kind` (fixed point, periodic, quasi-periodic, chaotic;
    undecided, the last one), `period` in seconds, `fraction` of the box with its 95 % interval from
    `low` to `high` (exact binomial, Clopper–Pearson), `found`, the number of draws, `points` of the
    section (attractor, point, state), angles within a turn, `turns` (attractor, coordinate) of free
    angles in a period, and `family`: whether it is one of many side by side. `outcome`, `reason`
    and `stop_time` (y, x) as `linkages.chaos_map` has them, `draw_outcome`, `draw_reason` (draw).

    Raises
    ------
    InputError
        If a path names nothing, nothing is free, or nothing dissipates.
    ValueError, TypeError
        For arguments that make no sense, and where drives have no common period.
    Interrupted
        After Ctrl-C; ``kept["basins"]`` has the points so far.
    """
    across, up = axis_of(x), axis_of(y)
    box = [across, up, *sides_of(also)]
    require_different(box)
    if isinstance(draws, bool) or draws < 0:
        raise ValueError(f"draws must be at least 0, found {draws}")
    require_feasible(len(across) * len(up) + draws)
    given = {name: value for name, value in options.items() if value is not None}
    question = _question(mechanism, across, up, box, draws, seed, given)
    first = question.first
    Plan.of(first).bind(first)  # compiled here, once
    made = partial(_dataset, question, (up, across), box)
    return swept(
        question, mechanism, "basins", "starts", made,
        device=device, executor=executor, store=store, watch=watch,
    )  # fmt: skip


def _question(
    mechanism: Mechanism,
    across: Axis,
    up: Axis,
    box: Sequence[Axis],
    draws: int,
    seed: int,
    given: Mapping[str, Any],
) -> Starts:
    """Starts of the grid, row by row, then those that are drawn."""
    states = [is_state(mechanism, axis) for axis in box]
    rows, columns = (each.ravel() for each in np.indices((len(up), len(across))))
    grid = np.concatenate([across.values[:, columns], up.values[:, rows]]).T
    further = sum(len(axis.paths) for axis in box[2:])
    grid = np.hstack([grid, np.full((len(grid), further), np.nan)])
    every = np.concatenate([grid, drawn(box, states, draws, seed)])
    if not all(states[2:]):
        path = next(axis.label for axis, state in zip(box, states, strict=True) if not state)
        raise ValueError(f"{path} is no initial state, as only further ranges may be; vary x or y")
    # starts with the same parameters belong together
    column, row = (
        np.zeros(len(every), dtype=np.int64)
        if state
        else np.unique(every[:, place], return_inverse=True)[1]
        for place, state in ((0, states[0]), (len(across.paths), states[1]))
    )
    nodes = row * (1 + int(column.max())) + column
    about = {"analysis": "basins", "grid": [len(up), len(across)], "draws": draws, "seed": seed}
    return Starts(
        Varying(mechanism),
        tuple(path for axis in box for path in axis.paths),
        tuple(axis.unit for axis in box for _ in axis.paths),
        every,
        nodes,
        given,
        about | {"states": states},
    )


def beside(states: Sequence[bool], across: Axis, up: Axis) -> list[tuple[int, int]]:
    """Pairs of neighbouring parameters, as numbers of `nodes`."""
    columns, rows = (1 if s else len(a) for s, a in zip(states, (across, up), strict=False))
    numbers = np.arange(rows * columns).reshape(rows, columns)
    pairs = [(numbers[:, :-1], numbers[:, 1:]), (numbers[:-1], numbers[1:])]
    return [(int(a), int(b)) for each in pairs for a, b in zip(*map(np.ravel, each), strict=True)]


def matched(
    question: Starts, found: Arrays, neighbours: Sequence[tuple[int, int]]
) -> tuple[Matched, Integers, list[str]]:
    """Attractors at all parameters, the number of the basin of each, and what is to be known."""
    angles, options = circular(question.first), question.options
    result = clustered(found, question.nodes, angles, options.settled)
    unstable = question.unstable(result.attractors)
    notes = []
    if lost := [number for number, left in unstable.items() if left]:
        starts = int(np.isin(result.labels, lost).sum())
        notes.append(
            f"{starts} start{'s' * (starts > 1)} end on an unstable cycle or state at rest, whose "
            "neighbours leave it: undecided"
        )
    result = with_undecided(result, found, unstable)
    scale = ranges(found, angles)
    families = linked(result.attractors, neighbours, angles, scale)
    return result, numbered(families, ordered(result.attractors, scale)), notes


def state_names(system: System) -> tuple[list[str], list[str]]:
    """Names of the entries of states, such as ``rod.angle``, and their units."""
    own: tuple[list[tuple[str, str, str]], ...] = ([], [], [])
    for output, (_, names) in state_outputs(system).items():
        units = VARIABLES[output].described(system.model)[0]
        kind = 2 if output == "internal_state" else int(not VARIABLES[output].coordinate)
        own[kind].extend((name, output.rpartition("_")[2], units) for name in names)
    order = {name: place for place, name in enumerate(system.topology.free)}
    moving = [*(sorted(part, key=lambda entry: order[entry[0]]) for part in own[:2])]
    entries = [(f"{name}.{quantity}", units) for part in moving for name, quantity, units in part]
    entries += [(name, units) for name, _, units in own[2]]
    return [name for name, _ in entries], [units for _, units in entries]


def described(
    question: Starts, found: Matched, families: Integers, draw_labels: Integers
) -> dict[str, Any]:
    """Variables of attractors, by the numbers of their basins."""
    system = question.first
    representatives = [
        min((a for a, f in zip(found.attractors, families, strict=True) if f == number),
            key=lambda each: each.node)
        for number in range(1 + int(families.max(initial=-1)))
    ]  # fmt: skip
    shares = [
        share(int((draw_labels == number).sum()), int((draw_labels != NOWHERE).sum()))
        for number in range(len(representatives))
    ]
    one = {"units": "1"}

    def of_shares(name: str, kind: type = float) -> NDArray[Any]:
        return np.array([getattr(each, name) for each in shares], dtype=kind)

    own = about(system, representatives)
    points = np.full((len(representatives), _most(representatives), own["state"][1].size), np.nan)
    for row, each in zip(points, representatives, strict=True):
        if each.kind != Kind.UNDECIDED:
            row[: len(each.points)] = each.points
    return own | {
        "period": ("attractor", np.array([a.period for a in representatives]),
                   {"units": "s", "long_name": "period"}),
        "family": ("attractor", np.array([a.family for a in representatives], dtype=np.int8),
                   {"long_name": "one of many side by side"}),
        "fraction": ("attractor", of_shares("fraction"), one | {"long_name": "share of the box"}),
        "low": ("attractor", of_shares("low"),
                one | {"long_name": "lower end of its 95 % interval"}),
        "high": ("attractor", of_shares("high"),
                 one | {"long_name": "upper end of its 95 % interval"}),
        "found": ("attractor", of_shares("found", int),
                  one | {"long_name": "draws that tend to it"}),
        "points": (("attractor", "point", "state"), points, {"long_name": "points of the section"}),
    }  # fmt: skip


def _most(attractors: Sequence[Attractor]) -> int:
    return max((len(each.points) for each in attractors), default=0)


def about(system: System, attractors: Sequence[Attractor]) -> dict[str, Any]:
    """What is known of attractors wherever they are, by their numbers, with coordinates."""
    names, units = state_names(system)
    angles, touching, count = free_names_of_angles(system), touchable(system), len(attractors)
    places = [system.topology.free.index(name) for name in angles]
    turns = np.array([each.turns[places] for each in attractors]).reshape(count, len(angles))
    touches = np.array([each.touches for each in attractors]).reshape(count, len(touching))
    cycles = [len(each.points) if each.kind == Kind.PERIODIC else 0 for each in attractors]
    one = {"units": "1"}
    return {
        "kind": ("attractor", np.array([each.kind.words for each in attractors], dtype=object)),
        "cycle": ("attractor", np.array(cycles),
                  one | {"long_name": "section points in a period, 0 if it has none"}),
        "turns": (("attractor", "coordinate"), turns,
                  one | {"long_name": "whole turns in a period"}),
        "touches": (("attractor", TOUCH), touches, one | {"long_name": "touches in a period"}),
        TOUCH: (TOUCH, np.array(touching, dtype=object)),
        "state_units": ("state", np.array(units, dtype=object)),
        "state": ("state", np.array(names, dtype=object)),
        "coordinate": ("coordinate", np.array(angles, dtype=object)),
        "attractor": ("attractor", np.arange(1, count + 1)),
    }  # fmt: skip


def _dataset(
    question: Starts, axes: tuple[Axis, Axis], box: Sequence[Axis], result: Computed
) -> xr.Dataset:
    import xarray as xr

    up, across = axes
    found, shape = result.arrays, (len(up), len(across))
    size = shape[0] * shape[1]
    pairs = beside(question.about["states"], across, up)
    attractors, families, notes = matched(question, found, pairs)
    labels = np.append(families, NOWHERE)[attractors.labels]
    mechanism = question.varying.mechanism
    lasted = {"units": "s", "long_name": "time after which its attractor was known"}
    said = reasons(found)
    numbered = {"long_name": "number of the attractor, -1 where nothing was computed"}
    names = np.where(labels == NOWHERE, NOWHERE, labels + 1)
    variables: dict[str, Any] = {
        "basin": (("y", "x"), names[:size].reshape(shape), numbered),
        "lasted": (("y", "x"), found["lasted"][:size].reshape(shape), lasted),
        **marks({name: array[:size] for name, array in found.items()}, ("y", "x"), shape),
        "draw_basin": ("draw", names[size:], numbered),
        "draw_outcome": ("draw", found["outcome"][size:], CODES),
        "draw_reason": ("draw", said[size:]),
    }
    own = described(question, attractors, families, labels[size:])
    members = {name: own.pop(name) for name in ("state", "coordinate", "attractor", TOUCH)}
    columns = question.rows[size:].T
    for axis in box:
        for path, column in zip(axis.paths, columns, strict=False):
            unit = coordinates(mechanism, axis, "value")[path][2]
            variables[f"drawn {path}"] = ("draw", column, unit)
        columns = columns[len(axis.paths) :]
    run = question.options
    return xr.Dataset(
        variables | own,
        {**coordinates(mechanism, across, "x"), **coordinates(mechanism, up, "y"), **members},
        {
            "name": mechanism.name,
            "source": mechanism.file_name,
            "x": across.label,
            "y": up.label,
            "box": box_words(box),
            "draws": question.about["draws"],
            "seed": question.about["seed"],
            "confidence": CONFIDENCE,
            "periods": run.periods,
            "longest": run.longest,
            "settled": run.settled,
            **run.how,
            "max_steps": run.most_steps,
            "evaluations": int(found["evaluations"].sum()),
            "warning": " ".join(notes),
            "interrupted": int(result.interrupted),
        },
    )


def reasons_of(data: xr.Dataset) -> dict[str, int]:
    """Why starts could not be computed, of grid and draws together: text → how many."""
    both = [*data["reason"].to_numpy().ravel(), *data["draw_reason"].to_numpy()]
    return dict(Counter(str(text) for text in both if text))
