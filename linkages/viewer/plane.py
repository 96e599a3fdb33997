"""The page of an isoperiodic plane: a point that is chosen plays its motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.free_states import require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.kernel.number_effects import value_of, written
from linkages.kernel.system import System
from linkages.options.analysis_options import OrbitOptions
from linkages.options.run import SimulationOptions
from linkages.orbits.orbit import NOISE, require_isolated
from linkages.orbits.shooting import Shooting
from linkages.plots.chaos.diagrams import LOOKS, classes, locus_curves
from linkages.plots.style import DEGREES, path_words
from linkages.solution.run_options import options_of
from linkages.solution.simulate import simulate
from linkages.spec.units import unit
from linkages.sweeps.axes import Axis
from linkages.viewer.content import page_content
from linkages.viewer.recorded import Packed, dense, wanted

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

MOST_MULTIPLIERS = 4
"""Multipliers of a point that a page has: the largest ones."""

UNREPEATED = 4
"""Periods of the drives that are played of a motion that does not repeat."""

RTOL = 1e-12
"""Relative tolerance with which points are played, unless that of the plane is less.

Impacts magnify the errors of a step.
"""

STEP = 2.0**-20
"""Part of a state by which it is moved to see which number of the definition follows it."""


def require_playable(mechanism: Mechanism, x: Axis, y: Axis) -> None:
    """Refuse what has no isolated orbits, and what a page cannot change."""
    first = mechanism.with_values({**y.at(0), **x.at(0)})
    shooting = Shooting(first, (), options_of(OrbitOptions, first, {}))
    require_free(shooting.system)
    require_isolated(mechanism, shooting)
    system = shooting.system
    if system.topology.internal:
        names = ", ".join(system.topology.internal)
        message = f"a page cannot start a motion from internal states, and there are: {names}"
        raise InputError("--page", [Problem(message=message)])
    base = _in_state(first, np.concatenate(_free_state(system)))
    known = {number.path for number in written(base)}
    missing = [path for path in (*x.paths, *y.paths) if path not in known]
    if missing:
        message = f"a page cannot change {', '.join(missing)}: expected numbers of the definition"
        raise InputError("--page", [Problem(message=message)])


def plane_page(
    mechanism: Mechanism,
    x: Axis,
    y: Axis,
    data: xr.Dataset,
    loci: Sequence[xr.Dataset],
    given: Mapping[str, Any],
) -> str | None:
    """The text of a page that plays the points of a plane; None if no point can start it.

    Parameters
    ----------
    mechanism, x, y
        What `linkages.chaos_map` was asked.
    data
        What `plane_orbits` returned.
    loci
        Results of `linkages.follow` that are drawn on top.
    given
        How motions are integrated, as `linkages.simulate` takes it.
    """
    states = data["state"].transpose("y", "x", "entry").to_numpy()
    begun = _begun(mechanism, x, y, data, states)
    if begun is None:
        return None
    (row, column), base = begun
    spans = _counts(data) * data["drive_period"].transpose("y", "x").to_numpy()
    rtol = min(RTOL, options_of(SimulationOptions, mechanism, given).rtol)
    how = {**given, "rtol": rtol, "end": float(spans[row, column])}
    solution = simulate(base, outputs=wanted(System(base)), throw=False, **how)

    def content(packed: Packed) -> dict[str, Any]:
        multipliers = data["multiplier"].transpose("y", "x", "entry", "part").to_numpy()
        shown = multipliers[:, :, :MOST_MULTIPLIERS]
        curves = locus_curves(data, loci)
        across, up = (_drawn(data, dim) for dim in ("x", "y"))
        return {
            "x": _axis(data, "x", x),
            "y": _axis(data, "y", y),
            "first": [row, column],
            "classes": packed.add(classes(data)),
            "counts": packed.add(_counts(data)),
            "spans": packed.add_exact(spans.ravel()),
            "states": packed.add_exact(states.ravel()),
            "paths": state_paths(base, states[row, column]),
            "multipliers": packed.add(shown),
            "several": [shown.shape[2], multipliers.shape[2]],
            "noise": NOISE,
            "looks": [[number, *look] for number, look in LOOKS.items()],
            "loci": [
                [label, packed.add(across * np.asarray(xs)), packed.add(up * np.asarray(ys))]
                for label, (xs, ys) in curves.items()
            ],
        }

    failure = solution.motion.failure
    return page_content(
        base, dense(solution), solution.options, solution.notes, failure, plane=content
    )


def shown_order(data: xr.Dataset) -> list[tuple[int, int]]:
    """Row and column of points with a motion: periodic ones first, the middle before the edges."""
    there = np.isfinite(data["drive_period"].transpose("y", "x").to_numpy())
    repeated = np.isfinite(data["indicator"].transpose("y", "x").to_numpy())
    middle = np.array(there.shape) // 2

    def key(place: tuple[int, int]) -> tuple[bool, float]:
        return not repeated[place], float(np.hypot(*(place - middle)))

    return sorted(((int(row), int(column)) for row, column in np.argwhere(there)), key=key)


def _begun(
    mechanism: Mechanism, x: Axis, y: Axis, data: xr.Dataset, states: Floats
) -> tuple[tuple[int, int], Mechanism] | None:
    """The point with which a page begins, and its mechanism; None if a definition can have none.

    A definition may not begin deep in a wall, where motions may well be.
    """
    for row, column in shown_order(data):
        own = mechanism.with_values({**y.at(row), **x.at(column)})
        with suppress(InputError):
            return (row, column), _in_state(own, states[row, column])
    return None


def _counts(data: xr.Dataset) -> Floats:
    """Periods of the drives that are played of each point."""
    found = data["indicator"].transpose("y", "x").to_numpy()
    return np.where(np.isfinite(found), found, UNREPEATED)


def _drawn(data: xr.Dataset, dim: str) -> float:
    """What values of an axis are multiplied with where they are drawn."""
    return DEGREES if data[data.attrs[dim]].attrs["units"] == "rad" else 1.0


def _axis(data: xr.Dataset, dim: str, axis: Axis) -> dict[str, Any]:
    """An axis as it is drawn, and the numbers in SI that each of its points sets."""
    units = str(data[data.attrs[dim]].attrs["units"])
    convert = unit(axis.unit).convert if axis.unit else float
    return {
        "label": path_words(axis.label),
        "unit": "deg" if units == "rad" else units,
        "values": (_drawn(data, dim) * axis.values[0]).tolist(),
        "sets": [
            [path, [convert(float(number)) for number in numbers]]
            for path, numbers in zip(axis.paths, axis.values, strict=True)
        ],
    }


def _free_state(system: System) -> tuple[Floats, Floats]:
    """Values and rates of the free coordinates."""
    layout, free = system.layout, system.topology.free
    whole = layout.motion(system.state)
    places = [layout.coordinates.index(name) for name in free]
    return whole[places], whole[len(layout.coordinates) :][places]


def _in_state(mechanism: Mechanism, state: Floats) -> Mechanism:
    """A mechanism that begins in a state: free coordinates, then their rates."""
    free = System(mechanism).topology.free
    # a definition does not write offsets of zero, and a page changes only what is written
    state = np.where(state == 0.0, np.finfo(float).tiny, state)
    pairs = zip(state[: len(free)].tolist(), state[len(free) :].tolist(), strict=True)
    return mechanism.with_state(dict(zip(free, pairs, strict=True)))


def state_paths(mechanism: Mechanism, state: Floats) -> list[str]:
    """Paths of the numbers of the definition that are the entries of a state."""

    def numbers(vector: Floats) -> dict[str, float]:
        own = _in_state(mechanism, vector)
        return {number.path: value_of(own, number) for number in written(own)}

    before, result = numbers(state), []
    for entry in range(len(state)):
        moved = state.copy()
        moved[entry] -= STEP * (moved[entry] or STEP)  # not further into a wall
        (path,) = (path for path, value in numbers(moved).items() if value != before[path])
        result.append(path)
    return result
