"""Diagrams over a parameter of all attractors that many starts tend to, with hysteresis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.attractors.basins import CONFIDENCE, about, share
from linkages.attractors.matching import (
    NOWHERE,
    Attractor,
    clustered,
    linked,
    numbered,
    ordered,
    ranges,
    with_undecided,
)
from linkages.attractors.settling import FIRST, Clock, Kind
from linkages.attractors.starts import Starts, box_words, drawn, is_state, sides_of
from linkages.attractors.tracing import renumbered, traced
from linkages.chaos.bifurcation import bifurcation_asked
from linkages.chaos.contact_log import TOUCH
from linkages.chaos.diagram import touchable
from linkages.chaos.free_states import circular
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.varying import Varying
from linkages.options.analysis_options import BasinKeywords, BasinOptions, BifurcationOptions
from linkages.options.option import OptionError, takes
from linkages.reading.paths import dotted
from linkages.solution.guards import free_vectors
from linkages.solution.march import March
from linkages.solution.plan import Plan
from linkages.sweeps.axes import (
    Axis,
    Vary,
    axis_of,
    coordinates,
    first_possible,
    require_different,
    require_feasible,
)
from linkages.sweeps.engine import CODES, Arrays, Computed, Watch, reasons
from linkages.sweeps.places import swept
from linkages.sweeps.running import Executor

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

POINTS = 64
"""Points that are kept of motions that do not repeat, and most of a cycle, unless it is said."""

WIDER = 0.5
"""Part of the range of rates of the file's motion by which their box is wider on either side; that
of positions is not, for there may be stops behind."""


@takes(BasinOptions)
def attractor_diagram(
    mechanism: Mechanism,
    vary: Vary,
    *,
    starts: int,
    within: Vary | Sequence[Vary] = (),
    seed: int = 0,
    device: str = "cpu",
    executor: Executor | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    **options: Unpack[BasinKeywords],
) -> xr.Dataset:
    """All attractors at each value of a parameter, from many starts, matched over the values.

    At every value the same random states are followed to their attractors. Each attractor is then
    followed from value to value, by motions that start from its last state, until it is lost: that
    shows hysteresis, and basins that no start met.

    Parameters
    ----------
    mechanism
        From a file or made in Python, with friction, damping or contact that takes energy.
    vary
        A parameter, as `linkages.bifurcation` takes it.
    starts
        Number of random states.
    within
        Ranges of the box that they are drawn from, such as ``"free.rod.angle=-180deg:180deg:2"``.
        If not given, positions of the motion from the definition's state at the first, middle and
        last value, rates of it with half their range more on either side, and all angles.
    seed
        Of the states: each is a function of seed, path and number alone.
    device, executor, store, watch
        As `linkages.bifurcation` takes them.
    options
        As `BasinOptions` describes them.

    Returns
    -------
    Dataset with `family` (value, start), the number of the attractor of each start, −1 where
    nothing could be computed, and of each attractor `kind` (attractor), `exists` (value,
    attractor): 1 where starts tend to it, 2 where it was followed to, 0 elsewhere; `period`,
    `fraction` of starts with its 95 % interval from `low` to `high`, `found`, `points` (value,
    attractor, point, state). `jump` has where attractors are lost: `lost`, `became` (−1 if not
    known), and the values `last` and `behind` it. `outcome` and `reason` (value, start).

    Raises
    ------
    InputError
        If a path names nothing, nothing is free, or nothing dissipates.
    ValueError, TypeError
        For arguments that make no sense, and where drives have no common period.
    Interrupted
        After Ctrl-C; ``kept["bifurcation"]`` has what was met so far.
    """
    axis = axis_of(vary)
    if isinstance(starts, bool) or starts < 1:
        raise OptionError("starts", f"starts must be at least 1, found {starts}")
    given = {"longest": POINTS} | {name: each for name, each in options.items() if each is not None}
    if is_state(mechanism, axis):
        raise ValueError(
            f"{axis.label} is an initial state: attractors are the same for all of them; expected "
            "a parameter"
        )
    box = box_of(mechanism, axis, within)
    require_different([axis, *box])
    require_feasible(len(axis) * starts)
    question = _question(mechanism, axis, box, starts, seed, given)
    first = question.first
    Plan.of(first).bind(first)  # compiled here, once
    made = partial(_dataset, question, axis, box)
    return swept(
        question, mechanism, "bifurcation", "starts", made,
        device=device, executor=executor, store=store, watch=watch,
    )  # fmt: skip


def _question(
    mechanism: Mechanism,
    axis: Axis,
    box: Sequence[Axis],
    starts: int,
    seed: int,
    given: Mapping[str, Any],
) -> Starts:
    """The same starts at every value, value by value."""
    states = drawn(box, [True] * len(box), starts, seed)
    nodes = np.repeat(np.arange(len(axis)), starts)
    rows = np.hstack([axis.values.T[nodes], np.tile(states, (len(axis), 1))])
    return Starts(
        Varying(mechanism),
        (*axis.paths, *(path for side in box for path in side.paths)),
        tuple(side.unit for side in (axis, *box) for _ in side.paths),
        rows,
        nodes,
        given,
        {"analysis": "bifurcation", "starts": starts, "seed": seed},
    )


def box_of(mechanism: Mechanism, axis: Axis, within: Vary | Sequence[Vary]) -> list[Axis]:
    """The sides of the box of initial states."""
    result = sides_of(within)
    for side in result:
        if not is_state(mechanism, side):
            raise ValueError(
                f"{side.label} is no initial state, as the sides of a box of starts are"
            )
    return result or _usual_box(mechanism, axis)


def _usual_box(mechanism: Mechanism, axis: Axis) -> list[Axis]:
    """About the motion from the definition's state."""
    varying = Varying(mechanism)
    places = sorted({0, len(axis) // 2, len(axis) - 1})
    first = first_possible(lambda place: varying.at(axis.at(place)), range(len(axis)))
    options = BasinOptions(rtol=mechanism.simulation.rtol or 1e-8)
    low, high = np.full(first.layout.directions, np.inf), np.full(first.layout.directions, -np.inf)
    for place in places:
        system = first if place == 0 else varying.at(axis.at(place))
        clock = Clock.of(system, options)
        lasting = clock.period * (FIRST if clock.driven else 1)
        times = system.time + lasting * np.linspace(0, 1, 32 * FIRST + 1)[1:]
        reached = free_vectors(system, March(system, options).advance(times))
        low, high = np.minimum(low, reached.min(axis=0)), np.maximum(high, reached.max(axis=0))
    angles, size = circular(first), len(first.topology.free)
    wider = np.where(np.arange(len(low)) < size, 0.0, WIDER * (high - low))
    low, high = low - wider, high + wider
    low[angles], high[angles] = -np.pi, np.pi
    sides = []
    for index, name in enumerate(first.topology.free):
        initial = first.mechanism.initial[name]
        for keys, entry in zip(initial.keys, (index, size + index), strict=True):
            if high[entry] > low[entry]:
                path = dotted((*initial.path, *keys))
                sides.append(Axis((path,), np.array([[low[entry], high[entry]]])))
    if not sides:
        message = "nothing moves from the state of the definition: give the box of starts"
        raise OptionError("within", f"{message}, such as free.rod.angle=-180deg:180deg:2")
    return sides


def _dataset(question: Starts, axis: Axis, box: Sequence[Axis], result: Computed) -> xr.Dataset:
    import xarray as xr

    found, mechanism = result.arrays, question.varying.mechanism
    angles = circular(question.first)
    scale = ranges(found, angles)
    met = clustered(found, question.nodes, angles, question.options.settled)
    met = with_undecided(met, found, question.unstable(met.attractors))
    open_ = [n for n, each in enumerate(met.attractors) if each.kind == Kind.UNDECIDED]
    everything = traced(question, axis, met.attractors, scale)
    pairs = [(node, node + 1) for node in range(len(axis) - 1)]
    # numbers do not depend on the direction of the range
    rank = np.argsort(np.argsort(axis.values[0], kind="stable"), kind="stable")
    families = linked(everything.attractors, pairs, angles, scale)
    ranked = [replace(each, node=int(rank[each.node])) for each in everything.attractors]
    families = numbered(families, ordered(ranked, scale))
    count = 1 + int(families.max(initial=-1))
    numbers = np.append(families, [count] * len(open_) + [NOWHERE])[
        np.where(met.labels == NOWHERE, len(families) + len(open_), met.labels)
    ]
    jumps = renumbered(everything.jumps, families.tolist())
    shape = len(axis), len(found["outcome"]) // len(axis)
    grid = numbers.reshape(shape)
    own = _described(question, everything.attractors, families, grid, bool(open_))
    labels = np.where(grid == NOWHERE, NOWHERE, grid + 1)
    missing = np.array(
        [NOWHERE if j.became is None else j.became + 1 for j in jumps], dtype=np.int64
    )
    values = axis.values[0]
    varied = coordinates(mechanism, axis, "value")
    units = varied[axis.label][2]
    members = {name: own.pop(name) for name in ("state", "coordinate", "attractor", TOUCH)}
    run = question.options
    return xr.Dataset(
        {
            "family": (("value", "start"), labels,
                       {"long_name": "number of the attractor, -1 where nothing was computed"}),
            **own,
            "lost": ("jump", np.array([j.lost + 1 for j in jumps], dtype=np.int64),
                     {"long_name": "attractor that is lost"}),
            "became": ("jump", missing, {"long_name": "attractor that its motion tends to then"}),
            "last": ("jump", np.array([values[j.last] for j in jumps], dtype=float),
                     units | {"long_name": "last value at which it exists"}),
            "behind": ("jump", np.array([values[j.behind] for j in jumps], dtype=float),
                       units | {"long_name": "value at which it is lost"}),
            "outcome": (("value", "start"), found["outcome"].reshape(shape), CODES),
            "reason": (("value", "start"), reasons(found).reshape(shape)),
        },
        {**varied, **members},
        {
            "name": mechanism.name, "source": mechanism.file_name, "varied": axis.label,
            "box": box_words(box),
            "starts": shape[1], "seed": question.about["seed"], "confidence": CONFIDENCE,
            "periods": run.periods, "longest": run.longest, "settled": run.settled,
            **run.how, "max_steps": run.most_steps, "interrupted": int(result.interrupted),
        },
    )  # fmt: skip


def _described(
    question: Starts,
    attractors: Sequence[Attractor],
    families: Integers,
    grid: Integers,
    undecided: bool,
) -> dict[str, Any]:
    """Variables of attractors at each value."""
    system = question.first
    count = 1 + int(families.max(initial=-1))
    values, total = len(grid), count + undecided
    last = dict(zip(families.tolist(), attractors, strict=True))
    free, contacts = len(system.topology.free), len(touchable(system))
    nothing = Attractor(
        Kind.UNDECIDED, np.nan, NOWHERE, np.zeros(free), np.full(contacts, np.nan),
        np.zeros((0, 0)), NOWHERE, NOWHERE,
    )  # fmt: skip
    own = about(system, [*(last[number] for number in range(count)), *[nothing] * undecided])
    most = max((len(each.points) for each in attractors), default=0)
    points = np.full((values, total, most, own["state"][1].size), np.nan)
    exists, many = np.zeros((values, total), dtype=np.int8), np.zeros(total, dtype=np.int8)
    period = np.full((values, total), np.nan)
    for each, number in zip(attractors, families.tolist(), strict=True):
        points[each.node, number, : len(each.points)] = each.points
        exists[each.node, number] = 2 if each.place < 0 else 1
        period[each.node, number] = each.period
        many[number] = max(many[number], each.family)
    found = np.array([(grid == number).sum(axis=1) for number in range(total)]).T.reshape(
        values, total
    )
    started = (grid != NOWHERE).sum(axis=1)
    if undecided:
        exists[:, count] = found[:, count] > 0
    shares = [[share(int(n), int(of)) for n in row] for row, of in zip(found, started, strict=True)]
    one = {"units": "1"}

    def of_value(name: str) -> Floats:
        return np.array([[getattr(each, name) for each in row] for row in shares]).reshape(
            values, total
        )

    both = ("value", "attractor")
    return {
        **own,
        "many": ("attractor", many, {"long_name": "one of many side by side"}),
        "exists": (both, exists, {"flag_values": np.array([0, 1, 2], dtype=np.int8),
                                  "flag_meanings": "no met followed"}),
        "period": (both, period, {"units": "s", "long_name": "period"}),
        "found": (both, found, one | {"long_name": "starts that tend to it"}),
        "fraction": (both, of_value("fraction"), one | {"long_name": "share of the starts"}),
        "low": (both, of_value("low"), one | {"long_name": "lower end of its 95 % interval"}),
        "high": (both, of_value("high"), one | {"long_name": "upper end of its 95 % interval"}),
        "points": ((*both, "point", "state"), points, {"long_name": "points of the section"}),
    }  # fmt: skip


def coexisting(exists: NDArray[np.int8]) -> list[tuple[int, int, tuple[int, ...]]]:
    """First and last value of each stretch with the same attractors, several of them.

    `exists`: of all but undecided motions, shape (values, attractors).
    """
    result: list[tuple[int, int, tuple[int, ...]]] = []
    for value, row in enumerate(exists):
        there = tuple((np.flatnonzero(row) + 1).tolist())
        if len(there) < 2:
            continue
        if result and result[-1][1] == value - 1 and result[-1][2] == there:
            result[-1] = (result[-1][0], value, there)
        else:
            result.append((value, value, there))
    return result


@takes(BifurcationOptions)
def diagram_asked(
    mechanism: Mechanism,
    vary: Sequence[str],
    *,
    starts: int | None = None,
    within: Sequence[str] = (),
    seed: int = 0,
    initial: Sequence[str] = (),
    **options: Any,
) -> xr.Dataset:
    """The diagram of a command: of many starts, or as `linkages.bifurcation` makes it.

    Parameters
    ----------
    mechanism, vary
        As `linkages.bifurcation` takes them.
    starts, within, seed
        As `attractor_diagram` takes them; no starts for another diagram.
    initial
        ``PATH=VALUE,…`` for each initial state of that.
    options
        As `BifurcationOptions` describes them.
    """
    if starts is None:
        return bifurcation_asked(mechanism, vary, initial=initial, **options)
    how: dict[str, Any] = {"within": within, "seed": seed, **basin_options(options)}
    return attractor_diagram(mechanism, vary, starts=starts, **how)


def basin_options(given: Mapping[str, Any]) -> dict[str, Any]:
    """Options of a diagram over many starts out of those of bifurcation diagrams.

    Raises OptionError for what goes with other diagrams only.
    """
    kept = {
        field for field in BasinOptions.__dataclass_fields__ if field not in ("periods", "skip")
    }
    defaults = BifurcationOptions()
    result = {}
    for name, value in given.items():
        if name == "periods":
            result["longest"] = value
        elif name in kept:
            result[name] = value
        elif value is not None and value != getattr(defaults, name, None):
            raise OptionError(
                name,
                f"{name} = {value} goes with diagrams from given states; with starts, motions are "
                "followed until their attractor is known, and points are taken once a period",
            )
    return result


def found_arrays(data: xr.Dataset) -> Arrays:
    """Points at which each attractor exists: value, attractor, number of the point, and states."""
    values = data["points"].to_numpy()
    there = np.isfinite(values).all(axis=3)
    value, attractor, point = np.nonzero(there)
    return {"value": value, "attractor": attractor, "point": point, "states": values[there]}
