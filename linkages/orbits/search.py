"""Search for an orbit or an equilibrium from a motion that settles, or from given states."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.periods import find_period
from linkages.chaos.strobed_motion import Followed
from linkages.errors import ComputationError, InputError, LinkagesError
from linkages.options.analysis_options import FEWEST_LOOKED_AT, MapOptions, OrbitOptions
from linkages.orbits.equations import (
    Equilibrium,
    NotConvergedError,
    Orbit,
    Problem,
    Solution,
    solve,
    with_energy,
)
from linkages.orbits.shooting import Ray, Shooting
from linkages.solution.many import Going, side_by_side

Floats = NDArray[np.float64]

LONGEST = 16
"""Periods of the drives within which a settled motion may repeat, if it is not said."""

ALIKE = 1e-3
"""Part of the amplitude by which section points of a settled motion differ after a period."""

SAMPLES = 400
"""Of an orbit."""

PER_NODE = 4
"""Periods of the drives between two nodes of multiple shooting."""

LARGEST = 1e6
"""Multiplier beyond which orbits are divided into more parts."""

PER_STEP, FEWEST_SAMPLES, MOST_SAMPLES = 4, 2000, 400_000
"""Samples per step of a motion without drives in which its period is looked for, and limits."""

AT_REST = 1e-6
"""Part of the size of a coordinate by which it moves at most when it has come to rest."""

DAMPINGS = (1.0, 10.0, 100.0, 0.1)
"""Dampings by which conservative orbits are unfolded, in inertias per period."""

SETTLING_STEPS = 2_000_000
"""Most steps of a motion with such a damping, which may be too stiff."""

SETTLING = 10
"""Periods to settle that count as one ``simulate.end`` where there are no drives."""


BOX = 3.0
"""Size of the box of random initial states, in amplitudes of the settled motion."""

NEARER = (1.0, 0.3, 0.1)
"""Parts of the way from the centre at which a random start is tried."""

RETURN = 0.05
"""Amplitudes within which a motion that does not repeat returns near an unstable orbit."""

LINGERING = 3
"""Times of settling for which a motion is followed that has not settled: transients may be long."""

TOGETHER = 64
"""Random starts that are followed side by side."""

APART = 1e-5
"""Amplitudes by which two orbits differ at least."""


@dataclass(frozen=True, eq=False)
class Found:
    """Equations and their solution."""

    problem: Problem
    solution: Solution

    @property
    def periods(self) -> int:
        """Periods of the drives that an orbit lasts; 0 of equilibria and without drives."""
        return getattr(self.problem, "periods", None) or 0


def nodes_for(periods: int | None) -> int:
    """Into how many parts an orbit is divided."""
    return 1 if periods is None else max(1, periods // PER_NODE)


def settled(
    shooting: Shooting, places: Floats, state: Floats, skip: int, longest: int
) -> tuple[Floats, int]:
    """Where a driven motion comes to, and after how many periods it repeats there.

    One period is returned for a motion that does not repeat. The amplitudes of `shooting` become
    those of the last period.
    """
    period = shooting.period(places)
    assert period is not None
    if skip:
        state = shooting.within_turn(
            shooting.shoot(places, state, skip * period, tangents=False).end
        )
    count = 4 * longest
    shot = shooting.shoot(
        places,
        state,
        count * period,
        tangents=False,
        samples=np.asarray(period * np.arange(1, count + 1), dtype=float),
    )
    points = shooting.states(shot.motion)
    shooting.scale = shooting.amplitudes(points)
    last = shooting.within_turn(points[-1])
    path = shooting.shoot(
        places, last, period, start=0.0, tangents=False, samples=period * np.arange(1, 129) / 128
    )
    shooting.scale = shooting.amplitudes(np.vstack([points[-1:], shooting.states(path.motion)]))
    found = find_period(
        points, angles=shooting.angles, tolerance=ALIKE * shooting.scale, longest=longest
    )
    return last, found.count or 1


def orbit_near(
    shooting: Shooting,
    places: Floats,
    state: Floats,
    periods: int | None,
    guess: float = 0.0,
    solver: Callable[..., Solution] = solve,
) -> Found:
    """The orbit near a state, after some periods of the drives or a guessed period in seconds.

    Raises NotConvergedError if Newton's method finds none.
    """
    nodes = nodes_for(periods)
    while True:
        problem = Orbit(shooting, periods, nodes)
        unknowns = first_unknowns(problem, places, state, guess)
        near = solver(problem, unknowns, places, patient=True)
        if near.at.family:
            condition = with_energy(problem, places, shooting.energy(places, state))
            near = solver(problem, near.unknowns, places, [condition])
        found = Found(problem, near)
        largest = np.abs(found.solution.at.spectrum).max(initial=0.0)
        if largest < LARGEST ** (nodes) or nodes >= 64:
            break
        nodes *= 4
    delay = problem.clearest(found.solution)
    if delay:
        later, unknowns, _ = problem.later(found.solution, delay)
        found = Found(later, solver(later, unknowns, places, patient=True))
    return found


def first_unknowns(problem: Orbit, places: Floats, state: Floats, guess: float) -> Floats:
    """States at all nodes on the motion from a state, with the period where it is unknown."""
    shooting = problem.shooting
    period = guess if problem.free else problem.period(state, places)
    span = period / problem.nodes
    states = [state]
    for node in range(1, problem.nodes):
        shot = shooting.shoot(places, states[-1], span, start=(node - 1) * span, tangents=False)
        states.append(shooting.within_turn(shot.end))
    return np.concatenate([*states, [period]] if problem.free else states)


def free_motion(
    shooting: Shooting, places: Floats, state: Floats, settling: float, duration: float
) -> tuple[Floats, float | None]:
    """Where a motion without drives comes to, and its period; None if it comes to rest.

    `settling`, `duration`: times in seconds in which it settles, and in which its period is looked
    for.
    Raises ComputationError if it does neither within the duration.
    """
    if settling:
        state = shooting.within_turn(shooting.shoot(places, state, settling, tangents=False).end)
    steps = shooting.shoot(places, state, duration, tangents=False).motion.cost["steps"]
    count = min(max(PER_STEP * steps, FEWEST_SAMPLES), MOST_SAMPLES)
    samples: Floats = duration * np.arange(1, count + 1) / count
    shot = shooting.shoot(places, state, duration, tangents=False, samples=samples)
    states = shooting.states(shot.motion)
    last = states[count // 2 :]
    scale = shooting.sizes
    moving = np.ptp(last[-count // 8 :], axis=0)
    if (moving < AT_REST * scale).all():
        shooting.scale = scale
        return shooting.within_turn(last[-1]), None
    shooting.scale = shooting.amplitudes(last)
    distance = shooting.distances(last[:-1] - last[-1])
    # the last return before the end: a minimum of the distance behind its largest values
    near = distance < 0.25
    beyond = np.flatnonzero(~near)
    if not len(beyond) or not near[: beyond[-1]].any():
        raise ComputationError(
            f"the motion neither rests nor repeats within {duration:g} s; give a state near the "
            "orbit, or a longer simulate.end",
            time=float(samples[-1]),
        )
    stop = beyond[-1]
    group = np.flatnonzero(near[:stop])[-1]
    start = group
    while start > 0 and near[start - 1]:
        start -= 1
    place = start + int(np.argmin(distance[start : group + 1]))
    return shooting.within_turn(last[-1]), float(samples[-1] - samples[count // 2 + place])


def unfolded(
    shooting: Shooting, places: Floats, state: Floats, periods: int | None, skip: int
) -> Found:
    """The orbit of a driven mechanism that conserves energy, by way of damped ones.

    Nothing settles there, and Newton's method needs a start that is close. Dampers in its massless
    clearances let it settle, and their coefficient then falls to zero, by steps of its logarithm.

    Raises NotConvergedError if there is no such clearance, or the orbit is lost on the way.
    """
    mechanism = shooting.mechanism.with_values(shooting.values(places))
    names = [name for name in mechanism.clearance_names if name in shooting.system.topology.free]
    given = mechanism.definition.content.get("dampers", [])
    period = shooting.period(places)
    assert period is not None
    failure = "nothing settles, for energy is conserved"
    for part in DAMPINGS if names else ():
        try:
            sizes = [part * _inertia(shooting, places, state, name) / period for name in names]
            added = [
                {"clearance": name, "damping": size}
                for name, size in zip(names, sizes, strict=True)
            ]
            damped = mechanism.with_values({"dampers": [*given, *added]})
            paths = [f"dampers[{len(given) + k}].damping" for k in range(len(names))]
            ray = Ray(tuple(paths), tuple(sizes), (0.0,) * len(names))
            own = Shooting(damped, (ray,), replace(shooting.run, max_steps=SETTLING_STEPS))
            last, seen = settled(own, np.zeros(1), state, skip, periods or 1)
            found = orbit_near(own, np.zeros(1), last, periods or seen)
            start = found.solution
            for fall in np.append(1.0 - 10.0 ** -np.arange(0.5, 8.0, 0.5), 1.0):
                start = solve(
                    found.problem, start.unknowns, np.array([fall]), near=start.at, patient=True
                )
            shooting.scale = own.scale
            problem = found.problem.with_shooting(shooting)
            return Found(problem, solve(problem, start.unknowns, places))
        except ComputationError as error:
            failure = f"dampers in {', '.join(names)} were followed to zero in vain: {error}"
    raise NotConvergedError(f"no orbit was found: {failure}; give a state near the orbit", time=0.0)


def _inertia(shooting: Shooting, places: Floats, state: Floats, name: str) -> float:
    """Second derivative of the energy by the rate of a free coordinate."""
    free = shooting.system.topology.free
    row = len(free) + free.index(name)
    energies = []
    for rate in (1.0, 0.0, -1.0):
        moved = state.copy()
        moved[row] = rate
        energies.append(shooting.energy(places, moved))
    return energies[0] - 2 * energies[1] + energies[2]


def equilibrium_near(
    shooting: Shooting, places: Floats, state: Floats, solver: Callable[..., Solution] = solve
) -> Found:
    """The equilibrium near a state.

    Raises ComputationError if dry friction holds the mechanism wherever its force is small enough.
    """
    model = shooting.system.model
    _ = model.changes
    if model.switches.equivalent:
        names = [model.switches.switches[number].name for number in model.switches.equivalent]
        raise ComputationError(
            f"dry friction ({', '.join(names)}) holds the mechanism, so that equilibria form "
            "intervals instead of points, and none is followed",
            time=0.0,
        )
    problem = Equilibrium(shooting)
    return Found(problem, solver(problem, problem.unknowns(state), places, patient=True))


def approached(
    shooting: Shooting,
    places: Floats,
    centre: Floats,
    away: Floats,
    run: OrbitOptions,
    unstable: bool = True,
) -> list[list[tuple[int, Floats]]]:
    """Periods and states near the orbits that motions come to, for each of many starts.

    Motions are followed side by side. One that does not repeat, such as a chaotic one, comes near
    to unstable orbits: if these are wanted, the state of its closest return in each period is
    taken. Starts in a wall are moved towards the centre.

    `places`, `away`: shapes (starts, P) and (starts, x); where starts are, from the centre.
    """
    if not run.skip:
        return [[(run.periods or 1, centre + own)] for own in away]
    longest = max(4 * run.longest, LINGERING * run.skip, FEWEST_LOOKED_AT)
    asked = MapOptions.like(run, indicator="period", periods=longest, skip=run.skip)

    def begun(place: Floats, own: Floats) -> Followed:
        for part in NEARER:
            with suppress(InputError):
                return Followed(shooting.system_at(place, centre + part * own), asked)
        return Followed(shooting.system_at(place, centre), asked)

    def following(place: Floats, own: Floats) -> Going[list[tuple[int, Floats]]]:
        followed = begun(place, own)
        cycle = yield from followed.going()
        points = followed.points
        if cycle is not None:
            return [(run.periods or cycle.count, points[-1])]
        wanted = [run.periods] if run.periods else range(1, run.longest + 1)
        result = []
        for count in wanted if unstable else ():
            distances = shooting.distances(points[count:] - points[:-count])
            if distances.min() < RETURN:
                result.append((count, points[int(distances.argmin())]))
        return result

    found = side_by_side([following(*each) for each in zip(places, away, strict=True)])
    return [[] if isinstance(each, LinkagesError) else each for each in found]


def from_random_states(
    shooting: Shooting,
    places: Floats,
    centre: Floats,
    run: OrbitOptions,
    *,
    solver: Callable[..., Solution] = solve,
    unstable: bool = True,
    watch: Callable[[float], None] | None = None,
) -> Iterator[Found]:
    """Orbits that motions from random states lead to, some of them more than once.

    `places`: of each start, shape (starts, P).
    `centre`: of the box of states, shape (x,).
    """
    scale, count = shooting.scale, len(places)
    draws = np.random.default_rng(run.seed).uniform(-BOX, BOX, (count, shooting.size))
    for first in range(0, count, TOGETHER):
        part = slice(first, min(first + TOGETHER, count))
        near = approached(shooting, places[part], centre, draws[part] * scale, run, unstable)
        for index, candidates in enumerate(near, first):
            for periods, state in candidates:
                try:
                    found = orbit_near(shooting, places[index], state, periods, solver=solver)
                    yield shortest(found, solver)
                except ComputationError:
                    continue
            if watch:
                watch((index + 1) / count)


def shortest(found: Found, solver: Callable[..., Solution] = solve) -> Found:
    """The same orbit run through once, where it was found over several times its period."""
    points, shooting = at_start(found)[0], found.problem.shooting
    for count in range(1, found.periods // 2 + 1):
        apart = shooting.distances(points[count % found.periods] - points[0])
        if not found.periods % count and apart < APART:
            return orbit_near(shooting, found.solution.places, points[0], count, solver=solver)
    return found


def at_start(found: Found) -> tuple[Floats, Floats, Floats]:
    """States at the beginnings of periods of the drives, then times and states of one orbit."""
    problem, solution = found.problem, found.solution
    assert isinstance(problem, Orbit)
    period = problem.period(solution.unknowns, solution.places)
    count = problem.periods or 1
    unit = period / count
    ahead = 0.0 if problem.free else (-problem.phase % 1.0) * unit
    shooting = problem.shooting
    start = problem.state(solution.unknowns)
    held = solution.at.shots[-1].held or None
    begin = problem.phase * unit if not problem.free else 0.0
    grid = np.union1d(
        ahead + period * np.arange(SAMPLES + 1) / SAMPLES, ahead + unit * np.arange(count + 1)
    )
    # the same time from both, but for round-off, is one
    grid = grid[np.append(grid[0] > 0.0, np.diff(grid) > 1e-12 * unit)]
    motion = shooting.shoot(
        solution.places,
        start,
        float(grid[-1]),
        start=begin,
        tangents=False,
        held=held,
        samples=grid,
    ).motion
    times = np.concatenate([[0.0], grid]) if ahead == 0.0 else grid
    states = shooting.states(motion)
    if ahead == 0.0:
        states = np.vstack([start, states])
    marks = np.searchsorted(times, ahead + unit * np.arange(count) - 1e-12 * unit)
    points = states[marks]
    return shooting.within_turn(points), times - ahead, states


def same_orbit(one: Found, other: Found) -> bool:
    """Whether two orbits are the same, begun at another of their periods perhaps."""
    if one.periods != other.periods:
        return False
    first, second = (at_start(each)[0] for each in (one, other))
    return bool((one.problem.shooting.distances(second - first[0]) < APART).any())


def _conserving(shooting: Shooting) -> bool:
    """Whether massless clearances are all that moves freely."""
    names = shooting.mechanism.clearance_names
    return all(name in names for name in shooting.system.topology.free)


def found_from(
    shooting: Shooting,
    places: Floats,
    state: Floats,
    *,
    periods: int | None,
    skip: int,
    longest: int = LONGEST,
    solver: Callable[..., Solution] = solve,
) -> Found:
    """The orbit, or the equilibrium, that the motion from a state leads to.

    `periods`: of the drives until the orbit closes; found from the motion if not given.
    `skip`: periods of the drives in which the motion settles; without drives, tenths of
    ``simulate.end``.
    """
    if shooting.period(places) is not None:
        last, seen = settled(shooting, places, state, skip, longest)
        wanted = seen if periods is None else periods
        try:
            return orbit_near(shooting, places, last if skip else state, wanted, solver=solver)
        except NotConvergedError:
            if solver is not solve or not _conserving(shooting):
                raise
            return unfolded(shooting, places, state, periods, skip)
    duration = abs(shooting.mechanism.simulation.end)
    settling = duration * skip / SETTLING
    last, guess = free_motion(shooting, places, state, settling, duration)
    if guess is None:
        return equilibrium_near(shooting, places, last, solver)
    return orbit_near(shooting, places, last, None, guess, solver)
