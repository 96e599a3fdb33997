"""Branches of orbits and equilibria over a parameter, from one solution to all that leave it."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.free_states import require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.design.ranges import Range, Ranges, ranges_of
from linkages.errors import ComputationError, Interrupted
from linkages.kernel.number_effects import NoDerivativeError, numbers_of, value_of
from linkages.options.analysis_options import FollowKeywords, FollowOptions
from linkages.options.option import OptionError, takes
from linkages.orbits.arclength import (
    Branch,
    Point,
)
from linkages.orbits.contact_events import contacts
from linkages.orbits.equations import (
    Equilibrium,
    Evaluated,
    NotConvergedError,
    Problem,
    Solution,
    solve,
)
from linkages.orbits.following import Beginning, Following
from linkages.orbits.loci import FOLLOWED, GAP, Locus
from linkages.orbits.orbit import require_isolated, starting_state
from linkages.orbits.search import (
    Found,
    at_start,
    equilibrium_near,
    found_from,
    from_random_states,
)
from linkages.orbits.shooting import Ray, Shooting
from linkages.orbits.starting_states import read_states
from linkages.solution.run_options import options_of
from linkages.sweeps.engine import Answer, Field
from linkages.sweeps.store import InOrder, in_order

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

BESIDE = 1e-4
"""Distance from a grazing orbit at which that with a small gap is looked for."""

Watch = Callable[[str], None]


class RememberedSolver:
    """Solves equations, and takes solutions out of a store where it has them.

    Solutions are kept in the order in which they are asked for. Of each there is where its
    equations were evaluated last, so that the same bits follow from it.
    """

    def __init__(self, results: InOrder) -> None:
        self._results = results

    def __call__(
        self,
        problem: Problem,
        unknowns: Floats,
        places: Floats,
        conditions: Any = (),
        *,
        near: Evaluated | None = None,
        patient: bool = False,
    ) -> Solution:
        """As `solve`."""
        count, size = len(unknowns), len(unknowns) + len(places)
        fields = {"before": Field("f8", (size,)), "after": Field("f8", (size,)),
                  "iterations": Field("i8")}  # fmt: skip
        if (known := self._results.next(fields)) is not None:
            if known["iterations"] < 0:
                raise NotConvergedError(str(known["reason"]), time=0.0)
            before, after = known["before"], known["after"]
            at = problem.evaluate(before[:count], before[count:], near)
            return Solution(after[:count], after[count:], at, int(known["iterations"]), before)
        try:
            result = solve(problem, unknowns, places, conditions, near=near, patient=patient)
        except NotConvergedError as error:
            nothing = np.full(size, np.nan)
            values = {"before": nothing, "after": nothing, "iterations": -1}
            self._results.keep(fields, Answer(values, reason=str(error)[:500]))
            raise
        after = np.concatenate([result.unknowns, result.places])
        values = {"before": result.before, "after": after, "iterations": result.iterations}
        self._results.keep(fields, Answer(values))
        return result


def ray_of(mechanism: Mechanism, vary: Any) -> tuple[Ray, Ranges]:
    """The ray along which parameters are varied, and their ranges."""
    ranges = ranges_of(mechanism, vary, either_way=True)
    first, last = (tuple(float(x) for x in ends) for ends in (ranges.lower, ranges.upper))
    return Ray(tuple(ranges.paths), first, last), ranges


@takes(FollowOptions)
def follow(
    mechanism: Mechanism,
    vary: Mapping[str, Any] | list[str],
    *,
    state: Mapping[str, float] | Sequence[str] | None = None,
    locus: str | None = None,
    other: Mapping[str, Any] | list[str] | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    **options: Unpack[FollowKeywords],
) -> xr.Dataset:
    """Follow branches of orbits or equilibria over a parameter, stable and unstable, round folds.

    Pseudo-arclength continuation with exact derivatives. Special points are located to round-off
    and labelled: F fold, PD period doubling, NS Neimark–Sacker, H Hopf, BP branch point, SB
    symmetry breaking, G grazing, CL contact loss, ST start of sticking, CS change of the contact
    sequence.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    vary
        Dotted path → both ends of its range: numbers in SI, or texts with units. Several parameters
        change together. The branch begins at the value of the definition if that is inside,
        otherwise at the first end.
    state
        Where the search begins, as `linkages.orbit` takes it.
    locus
        Label of a point of the branches, such as ``PD1``: it is followed in two parameters, and
        the result is its locus.
    other
        The second of these, as `vary` has the first.
    store
        Folder in which solutions are kept as they are found; the same call goes on with them.
    watch
        Called with a line about each point.
    options
        As `FollowOptions` describes them.

    Returns
    -------
    Dataset with, for each point, `value` (point, path) of the parameters in SI, `period` in
    seconds (nan for equilibria), `state` (point, coordinate), `multiplier` (point, index, part) of
    orbits or `eigenvalue` of equilibria in 1/s, `stable`, `contacts`, the number of its `branch`,
    and for special points `label`, `kind`, and `about`, the contact that changes there. The
    attribute ``branches`` says in JSON of each branch its periods, the label of the point at which
    it begins, and why it ended.

    Raises
    ------
    InputError
        If nothing is free to move, or orbits form families.
    ComputationError
        If no orbit or equilibrium is found to begin with.
    """
    run = options_of(FollowOptions, mechanism, options)
    ray, ranges = ray_of(mechanism, vary)
    begun = read_states(mechanism, state)
    shooting = Shooting(mechanism, (ray,), run)
    require_free(shooting.system)
    require_isolated(mechanism, shooting)
    about = {"vary": {p: [a, b] for p, a, b in zip(ray.paths, ray.first, ray.last, strict=True)},
             "state": begun, "options": run.__dict__}  # fmt: skip
    second = None
    if (locus is None) != (other is None):
        raise OptionError("locus", "a locus needs a label and a second parameter")
    if other is not None:
        second, more = ray_of(mechanism, other)
        about |= {"locus": locus, "other": [second.paths, second.first, second.last]}
        ranges = Ranges((*ranges.each, *more.each))
    with in_order(store, mechanism, "branches", about) as results:
        solver = RememberedSolver(results)
        following = Following(run, solver, _told(watch, ranges))
        interrupted = False
        try:
            following.everything(_starts(shooting, ranges.each[0], begun, run, solver))
            if second is not None:
                following = _locus(following, str(locus), second, more, run)
        except KeyboardInterrupt:
            if not following.branches:
                raise
            interrupted = True
        data = branches_data(mechanism, following, ranges, run)
        if interrupted:
            count = data.sizes["point"]
            raise Interrupted(f"after {count} points", time=0.0, kept={"follow": data})
        results.finish(data)
    return data


def _locus(
    following: Following, label: str, second: Ray, ranges: Ranges, run: FollowOptions
) -> Following:
    """The locus of a labelled point in two parameters."""
    points = {p.label: p for branch in following.branches for p in branch.points if p.label}
    known = {name: p for name, p in points.items() if p.kind in FOLLOWED}
    if label not in known:
        found = f"found none of {label!r}" if label not in points else f"{label} has no locus"
        message = f"{found}; points that have one: {', '.join(known) or 'none'}"
        raise OptionError("locus", message)
    point = known[label]
    shooting = point.problem.shooting.with_ray(second)
    inner = point.problem.with_shooting(shooting)
    problem = Locus(inner, point.kind, point.about, point.time)
    place = second.place(_value(shooting.mechanism, ranges.each[0]))
    if not 0.0 <= place <= 1.0:
        message = f"{second.paths[0]} of the definition is outside of its range"
        raise OptionError("and", message)
    vector = np.concatenate([point.solution.unknowns / inner.scale, point.solution.places])
    sides = [vector]
    if problem.rigid:
        problem.gap = GAP * problem.usual_gap(point.at)
        sides = [vector + side * BESIDE * point.tangent for side in (1.0, -1.0)]
    result = Following(run, following.solver, following.watch)
    failure = None
    for guess in sides:
        unknowns = np.append(guess[:-1] * inner.scale, guess[-1])
        try:
            start = following.solver(problem, unknowns, np.array([place]), near=point.at)
        except NotConvergedError as error:
            failure = error
        else:
            break
    else:
        raise failure or NotConvergedError("no point of the locus was found", time=0.0)
    result.branches = [result.both_ways(Beginning(problem, start, parent=label))]
    return result


def _told(watch: Watch | None, ranges: Ranges) -> Callable[[Branch, Point], None] | None:
    """What is said of each point while branches are followed."""
    if watch is None:
        return None
    told = watch
    first = ranges.each[0]

    def line(branch: Branch, point: Point) -> None:
        value = first.lower + point.place * (first.upper - first.lower)
        what = f"{point.label} {point.kind}" if point.label else ""
        told(f"{len(branch.points)} {first.shown(value)} {what}".strip())

    return line


def _value(mechanism: Mechanism, varied: Range) -> float:
    """The value of the definition in SI."""
    try:
        (number,) = numbers_of(mechanism, [varied.path])
    except NoDerivativeError:
        return varied.written_value
    return value_of(mechanism, number)


def _starts(
    shooting: Shooting,
    varied: Range,
    state: Mapping[str, float],
    run: FollowOptions,
    solver: Callable[..., Solution],
) -> Iterator[Found]:
    """The solution that the definition leads to, then those of random states and parameters."""
    place = shooting.rays[0].place(_value(shooting.mechanism, varied))
    start = np.array([place if 0.0 <= place <= 1.0 else 0.0])
    if run.starts == 1:
        yield _start(shooting, start, state, run, solver)
        return
    if shooting.period(start) is None or run.what == "equilibria":
        message = "random starts need drives or loads that depend on time, and orbits; expected 1"
        raise OptionError("starts", message)
    failure: ComputationError | None = None
    places = np.linspace(0.0, 1.0, run.starts - 1)[:, None]
    centre = shooting.initial(places[0])
    try:
        first = _start(shooting, start, state, run, solver)
    except ComputationError as error:
        failure = error
    else:
        yield first
        centre = at_start(first)[0][0]
    for found in from_random_states(
        shooting, places, centre, run, solver=solver, unstable=run.unstable
    ):
        failure = None
        yield found
    if failure is not None:
        raise failure


def _start(
    shooting: Shooting,
    places: Floats,
    state: Mapping[str, float],
    run: FollowOptions,
    solver: Callable[..., Solution],
) -> Found:
    """The solution that the state of the definition leads to."""
    first = starting_state(shooting, places, state)
    if run.what == "equilibria":
        if shooting.period(places) is not None:
            raise ComputationError(
                "drives or loads depend on time: there is no equilibrium", time=0.0
            )
        shooting.scale = shooting.sizes
        return equilibrium_near(shooting, places, first, solver)
    found = found_from(
        shooting,
        places,
        first,
        periods=run.periods,
        skip=run.skip,
        longest=run.longest,
        solver=solver,
    )
    if found.solution.at.family:
        raise ComputationError(
            "energy is conserved, so that orbits form a family over it, and no single one can be "
            "followed; add a damper",
            time=0.0,
        )
    if run.what == "orbits" and isinstance(found.problem, Equilibrium):
        raise ComputationError(
            "the motion comes to rest: there is an equilibrium and no orbit", time=0.0
        )
    return found


def branches_data(
    mechanism: Mechanism, following: Following, ranges: Ranges, run: FollowOptions
) -> xr.Dataset:
    """Branches as labelled arrays."""
    import xarray as xr

    rows = [(k, point) for k, branch in enumerate(following.branches) for point in branch.points]
    problem = following.branches[0].problem
    shooting = problem.shooting
    values = [[*shooting.values(point.where).values()] for _, point in rows]
    spectrum = np.full((len(rows), shooting.size, 2), np.nan)
    for row, (_, point) in enumerate(rows):
        own = point.at.spectrum[: shooting.size]
        spectrum[row, : len(own)] = np.stack([own.real, own.imag], axis=1)
    periods = np.array([point.period for _, point in rows], dtype=float)  # nan of equilibria
    orbits = np.isfinite(periods)
    units = [each.si for each in ranges.each[: len(values[0])]]

    def texts(name: str) -> NDArray[np.object_]:
        return np.array([getattr(point, name) for _, point in rows], dtype=object)

    data = {
        "value": (("point", "path"), np.array(values), {"long_name": "parameter"}),
        "unit": ("path", np.array(units, dtype=object)),
        "branch": ("point", np.array([k for k, _ in rows], dtype=np.int64)),
        "period": ("point", periods, {"units": "s", "long_name": "period"}),
        "state": (
            ("point", "coordinate"),
            np.array([point.at.beginning for _, point in rows]),
            {"long_name": "state at the beginning of a period of the drives"},
        ),
        "coordinate_unit": ("coordinate", np.array(shooting.units, dtype=object)),
        "spectrum": (
            ("point", "index", "part"),
            spectrum,
            {"long_name": "multipliers of orbits, eigenvalues of equilibria in 1/s"},
        ),
        "stable": (
            "point",
            np.array([p.problem.stable(p.at.spectrum) for _, p in rows], dtype=np.int8),
        ),
        "contacts": (
            "point",
            np.array([contacts(p.at.changes) for _, p in rows], dtype=np.int64),
        ),
        "label": ("point", texts("label")),
        "kind": ("point", texts("kind")),
        "about": ("point", texts("about")),
    }
    described = [
        {
            "periods": branch.periods,
            "parent": branch.parent,
            "locus": branch.problem.kind if isinstance(branch.problem, Locus) else "",
            "ends": [end._asdict() for end in branch.ends],
        }
        for branch in following.branches
    ]
    return xr.Dataset(
        data,
        coords={
            "path": np.array([path for ray in shooting.rays for path in ray.paths], dtype=object),
            "coordinate": np.array(shooting.names, dtype=object),
            "index": np.arange(1, shooting.size + 1),
            "part": np.array(["real", "imaginary"], dtype=object),
        },
        attrs={
            "name": mechanism.name,
            "source": mechanism.file_name,
            "what": "orbits" if orbits.any() else "equilibria",
            "branches": json.dumps(described),
            "notes": json.dumps(following.notes),
            **run.how,
        },
    )
