"""A motion at the sample times, and how its deviation vectors grow from one to the next."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.terms import PLAYING
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.kernel.layout import Layout
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.remarks import longest
from linkages.solvers.flow import Renormalisation
from linkages.solvers.tableau import cardinals
from linkages.solvers.trajectory import Trajectory

if TYPE_CHECKING:
    from linkages.solution.guards import Guard


Floats = NDArray[np.float64]
Watch = Callable[[float], None]


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a motion is computed."""

    times: Floats  # sample times in seconds, shape (samples,), away from where the motion starts
    run: RunOptions  # how it is integrated
    work: bool = False  # whether to integrate the work of drives and loads along with the motion
    losses: bool = False  # whether to integrate what contacts lose
    # Whether to count the whole turns of dependent angles. Where free coordinates may be exchanged
    # they are counted anyway
    counting: bool = False
    watch: Watch | None = None  # called now and then with the fraction of simulated time done
    events: tuple[Guard, ...] = ()  # crossings to look for

    def plain(self, times: Floats) -> Settings:
        """The same for the motion alone at other samples."""
        return replace(self, times=times, work=False, losses=False, watch=None, events=())


@dataclass(frozen=True, eq=False)
class Tangents:
    """How the samples of a motion change with each of P numbers of the definition."""

    state: Floats  # free coordinates, rates and internal states, shape (x, P, samples)
    # Second derivatives of the free coordinates and rates of internal states, (n, P, samples)
    rate: Floats
    memories: Floats  # what is remembered, shape (P, memories, samples)

    def part(self, part: slice | NDArray[np.bool_] | NDArray[np.intp]) -> Tangents:
        """Those of some of the samples."""
        return Tangents(self.state[..., part], self.rate[..., part], self.memories[..., part])

    def interpolated(self, piece: Piece) -> Tangents:
        """Those of the wanted times of a piece."""
        state, rate = piece.interpolated(self.state), piece.interpolated(self.rate)
        return Tangents(state, rate, np.repeat(self.memories[..., :1], len(piece.wanted), axis=-1))


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """Part of a motion with the same integrated coordinates."""

    system: System  # its equations
    time: Floats  # shape (samples,)
    # Integrated coordinates (angles within one turn), then rates, shape (2n, samples)
    state: Floats
    turns: Floats  # whole turns to add to the coordinates, shape (n, samples)
    acceleration: Floats  # shape (n, samples)
    # Work of drives and loads since t = 0 in joules, shape (samples,), if it was asked for
    work: Floats | None = None
    # What contacts lost since t = 0 in joules, across walls, then along them, shape (2 contacts,
    # samples), if it was asked for
    losses: Floats | None = None
    # Dependent body → its angle with the whole turns made since the start, shape (samples,), if
    # they were counted
    counted: Mapping[str, Floats] = field(default_factory=dict)
    # Blocks that are in the other assembly branch than at the start, shape (samples,) each
    flipped: Mapping[int, NDArray[np.bool_]] = field(default_factory=dict)
    held: Floats | None = None  # modes of the switches, then what is remembered, shape (h, samples)
    # Where outputs are wanted if not at `time`: they are interpolated, for there they could only be
    # computed with large round-off (near a change point)
    samples: Floats | None = None
    crossing: float = 0.0  # time of that change point
    # How all of this changes with numbers of the definition, if that was asked for
    tangents: Tangents | None = None

    @classmethod
    def driven(cls, system: System, times: Floats, flipped: Collection[int]) -> Piece:
        """Times at which drives determine the positions, with some blocks in the other branch."""
        nothing = np.zeros((0, len(times)))
        flags = {block: np.ones(len(times), dtype=bool) for block in flipped}
        return cls(
            system=system, time=times, state=nothing, turns=nothing, acceleration=nothing,
            flipped=flags,
        )  # fmt: skip

    @property
    def wanted(self) -> Floats:
        """Times of the samples that come out of this piece."""
        return self.time if self.samples is None else self.samples

    def part(self, part: slice | NDArray[np.bool_] | NDArray[np.intp]) -> Piece:
        """Some of the times at which the motion was computed."""
        return replace(
            self,
            time=self.time[part],
            state=self.state[:, part],
            turns=self.turns[:, part],
            acceleration=self.acceleration[:, part],
            work=None if self.work is None else self.work[part],
            losses=None if self.losses is None else self.losses[:, part],
            counted={name: angles[part] for name, angles in self.counted.items()},
            flipped={block: where[part] for block, where in self.flipped.items()},
            held=None if self.held is None else self.held[:, part],
            samples=None,
            tangents=None if self.tangents is None else self.tangents.part(part),
        )

    def direct(self) -> Piece:
        """The same at the wanted times themselves, by interpolation of the state."""
        if self.samples is None:
            return self
        changed = {b: where for b, where in self.flipped.items() if not where.all()}
        after = {b: bool(where[-1]) for b, where in changed.items()}
        beyond = (self.samples - self.crossing) * (self.time[-1] - self.time[0]) > 0
        modes = {b: beyond == after[b] for b in changed}
        kept = {b: np.ones(len(beyond), dtype=bool) for b in self.flipped if b not in changed}
        return replace(
            self,
            time=self.samples,
            state=self.interpolated(self.state),
            turns=np.repeat(self.turns[:, :1], len(self.samples), axis=1),
            acceleration=self.interpolated(self.acceleration),
            work=None if self.work is None else self.interpolated(self.work),
            losses=None if self.losses is None else self.interpolated(self.losses),
            counted={name: self.interpolated(angles) for name, angles in self.counted.items()},
            flipped={**modes, **kept},
            held=None if self.held is None else np.repeat(self.held[:, :1], len(beyond), axis=1),
            samples=None,
            tangents=None if self.tangents is None else self.tangents.interpolated(self),
        )

    def interpolated(self, rows: Floats) -> Floats:
        """Values at the wanted times from those at `time`, the last axis of both."""
        if self.samples is None:
            return rows
        return np.asarray(rows @ cardinals(self.time, self.samples).T)


@dataclass(frozen=True, kw_only=True, eq=False)
class Changed:
    """Changes of a mode."""

    # States just before the changes, with the modes and memories behind them; without accelerations
    pieces: tuple[Piece, ...]
    rises: NDArray[np.bool_]  # whether the function rose through zero, shape (changes,)
    count: int  # number of changes, of which the first are kept

    @classmethod
    def none(cls) -> Changed:
        """No change."""
        return cls(pieces=(), rises=np.zeros(0, dtype=bool), count=0)

    @property
    def time(self) -> Floats:
        """In seconds, shape (changes,)."""
        return np.concatenate([piece.time for piece in self.pieces])

    def followed_by(self, piece: Piece, rises: NDArray[np.bool_], count: int) -> Changed:
        """These and `count` more, of which the first are those in a piece."""
        return Changed(
            pieces=(*self.pieces, piece),
            rises=np.concatenate([self.rises, rises]),
            count=self.count + count,
        )

    def joined(self, later: Changed) -> Changed:
        """These and later ones."""
        return Changed(
            pieces=(*self.pieces, *later.pieces),
            rises=np.concatenate([self.rises, later.rises]),
            count=self.count + later.count,
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class Motion:
    """The computed part of a motion, piece by piece.

    `reason` says why the method was chosen automatically; `method` is empty if nothing was
    integrated.
    """

    pieces: tuple[Piece, ...]  # at least one, in the order of time
    failure: str | None = None  # why it stopped before the end, as a sentence; None if it did not
    stop_time: float = 0.0  # where it stopped
    interrupted: bool = False  # whether Ctrl-C stopped it
    # Numbers for the summary: steps, rejected steps, evaluations
    cost: dict[str, int] = field(default_factory=dict)
    method: str = ""
    reason: str = ""
    # What happened on the way: change points passed, coordinates changed
    notes: tuple[str, ...] = ()
    # Name of a guard → states at which it was crossed, without accelerations
    crossings: Mapping[str, Motion] = field(default_factory=dict)
    # Name of a switch → changes of its mode
    changes: Mapping[str, Changed] = field(default_factory=dict)

    def __repr__(self) -> str:
        ended = "" if self.failure is None else f", stopped at t = {self.stop_time:g} s"
        return f"Motion({len(self.time)} samples in {len(self.pieces)} pieces{ended})"

    @property
    def time(self) -> Floats:
        """Sample times that were reached, shape (samples,)."""
        first, *further = (piece.wanted for piece in self.pieces)
        return np.concatenate([first, *further]) if further else first

    @property
    def work(self) -> Floats | None:
        """Work of drives and loads since t = 0 in joules, shape (samples,), if it was asked for."""
        works = [p.interpolated(p.work) for p in self.pieces if p.work is not None]
        return np.concatenate(works) if len(works) == len(self.pieces) else None

    @property
    def losses(self) -> Floats | None:
        """What contacts lost, shape (2 contacts, samples) as in pieces, if it was asked for."""
        result = [p.interpolated(p.losses) for p in self.pieces if p.losses is not None]
        return np.concatenate(result, axis=1) if len(result) == len(self.pieces) else None

    @property
    def state(self) -> Floats:
        """Coordinates of each piece (angles within one turn) and rates, shape (2n, samples)."""
        return np.concatenate([p.interpolated(p.state) for p in self.pieces], axis=1)

    def part(self, first: int = 0, last: int | None = None, each: int = 1) -> Motion:
        """Some of the samples: every so many-th from one to before another."""
        kept, begin = [], 0
        chosen = np.arange(len(self.time))[first:last:each]
        for piece in self.pieces:
            end = begin + len(piece.wanted)
            places = chosen[(begin <= chosen) & (chosen < end)] - begin
            if piece.samples is None:
                kept.append(piece.part(places))
            else:
                kept.append(replace(piece, samples=piece.samples[places]))
            begin = end
        filled = [piece for piece in kept if len(piece.wanted)]
        return replace(self, pieces=tuple(filled or kept[:1]))


TANGENT_ATOL = 1e-6
"""Absolute tolerance of tangents that are only asked how they grow: they are of length one when
they start."""

ANYTHING = 1e300
"""Absolute tolerance of what means nothing."""


def movable(system: System) -> tuple[str, ...]:
    """Free coordinates that others could take the place of: all but clearances."""
    bodies = system.model.mechanism.bodies  # what they are is the same in all of a structure
    return tuple(name for name in system.topology.free if bodies[name].kind not in PLAYING)


def passes(system: System, run: RunOptions) -> bool:
    """Whether a motion goes on through change points, as `RunOptions` describes it."""
    return bool(movable(system)) if run.change_points is None else run.change_points == "pass"


def absolute_tolerances(
    mechanism: Mechanism,
    layout: Layout,
    run: RunOptions,
    tangent_atol: float | NDArray[np.float64],
) -> NDArray[np.float64]:
    """Absolute tolerances of all coordinates of a layout, shape (2n,).

    By default lengths are measured in sizes where clearances open, and angles by what they move:
    contact amplifies errors.
    """
    result = np.full(2 * layout.size, run.rtol if run.atol is None else run.atol)
    if run.atol is None and mechanism.contacts:
        length = min(contact.size.value for contact in mechanism.contacts)
        turned = length / (max(map(longest, mechanism.bodies.values())) or 1.0)
        bodies = mechanism.bodies
        sizes = {name: turned if bodies[name].rotates else length for name in bodies}
        scales = [sizes.get(name, 1.0) for name in layout.coordinates]
        result[layout.motion_rows] *= [*scales, *scales]
    if layout.internal:
        result[layout.internal_rows] *= [state.scale for state in mechanism.internal.values()]
    result[layout.tangent_rows] = tangent_atol
    result[layout.idle_rows] = ANYTHING
    return result


class Renormalised:
    """Rescales tangents to length one after `every` samples, and records their growth.

    They are made orthonormal if `orthogonal`.
    """

    def __init__(self, every: int = 1, *, orthogonal: bool = True) -> None:
        self._every, self.orthogonal = every, orthogonal
        self._seen = 0
        self._grown: Floats | None = None
        self._lengths: list[Floats] = []
        self._tangents: list[Floats] = []

    def plan(self, layout: Layout) -> Renormalisation:
        """What the next integration is to do with its tangents."""
        if self._grown is None:
            self._grown = np.zeros(layout.tangents)
        return Renormalisation(
            size=layout.moved,
            placed=len(layout.free),
            columns=layout.tangents,
            grown=self._grown,
            every=self._every,
            offset=self._seen % self._every,
            orthogonal=self.orthogonal,
        )

    def add(self, trajectory: Trajectory, layout: Layout) -> None:
        """Take what an integration did."""
        self._lengths.append(trajectory.lengths)
        self._grown = trajectory.grown
        first = self._every - 1 - self._seen % self._every
        self._tangents.append(trajectory.state[first :: self._every, layout.tangent_rows])
        self._seen += len(trajectory.time)

    def led_through(self, layout: Layout, samples: Floats) -> Floats:
        """Take samples (samples, x, k) of tangents that were not renormalised.

        Returns the factor for tangents at their end, shape (k, k).
        """
        plan = self.plan(layout)
        lengths, tangents, factor = plan.undone(samples, plan.grown)
        self._lengths.append(lengths)
        self._tangents.append(tangents)
        self._seen += len(samples)
        return factor

    @property
    def lengths(self) -> Floats:
        """Logarithms of the lengths before they were renormalised, shape (times, k)."""
        return np.concatenate(self._lengths)

    @property
    def tangents(self) -> Floats:
        """Tangents after that, shape (times, x, k), in the coordinates they were integrated in."""
        return np.concatenate(self._tangents)
