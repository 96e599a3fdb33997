"""The motion at the sample times: integrated, or solved directly where everything is driven."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.components.terms import axis_label
from linkages.kernel.model import Model
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solvers.collocation import cardinals
from linkages.topology.blocks import ITERATED

if TYPE_CHECKING:
    from linkages.solution.guards import Guard

Floats = NDArray[np.float64]
Watch = Callable[[float], None]


COULD_PASS = "'change_points: pass' takes the smooth one"
FOUND_NONE = "no smooth way on was found"
"""What is said of the way on from a singular position."""


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How a motion is computed.

    Parameters
    ----------
    times
        Sample times in seconds, shape (samples,), away from where the motion starts.
    run
        How it is integrated.
    work
        Whether to integrate the work of drives and loads along with the motion.
    counting
        Whether to count the whole turns of dependent angles. Where free coordinates may be
        exchanged they are counted anyway.
    watch
        Called now and then with the fraction of simulated time done.
    events
        Crossings to look for.
    """

    times: Floats
    run: RunOptions
    work: bool = False
    counting: bool = False
    watch: Watch | None = None
    events: tuple[Guard, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Piece:
    """Part of a motion with the same integrated coordinates.

    Parameters
    ----------
    system
        Its equations.
    time
        Shape (samples,).
    state
        Integrated coordinates (angles within one turn), then rates, shape (2n, samples).
    turns
        Whole turns to add to the coordinates, shape (n, samples).
    acceleration
        Shape (n, samples).
    work
        Work of drives and loads since t = 0 in joules, shape (samples,), if it was asked for.
    counted
        Dependent body → its angle with the whole turns made since the start, shape (samples,), if
        they were counted.
    flipped
        Blocks that are in the other assembly mode than at the start, shape (samples,) each.
    samples
        Where outputs are wanted if not at `time`: they are interpolated, for there they could only
        be computed with large round-off (near a change point).
    crossing
        Time of that change point.
    """

    system: System
    time: Floats
    state: Floats
    turns: Floats
    acceleration: Floats
    work: Floats | None = None
    counted: Mapping[str, Floats] = field(default_factory=dict)
    flipped: Mapping[int, NDArray[np.bool_]] = field(default_factory=dict)
    samples: Floats | None = None
    crossing: float = 0.0

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
            counted={name: angles[part] for name, angles in self.counted.items()},
            flipped={block: where[part] for block, where in self.flipped.items()},
            samples=None,
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
            counted={name: self.interpolated(angles) for name, angles in self.counted.items()},
            flipped={**modes, **kept},
            samples=None,
        )

    def interpolated(self, rows: Floats) -> Floats:
        """Values at the wanted times from those at `time`, the last axis of both."""
        if self.samples is None:
            return rows
        return np.asarray(rows @ cardinals(self.time, self.samples).T)


@dataclass(frozen=True, kw_only=True, repr=False)
class Motion:
    """What was reached of a motion, piece by piece.

    Parameters
    ----------
    pieces
        At least one, in the order of time.
    failure
        Why it stopped before the end, as a sentence; None if it did not.
    stop_time
        Where it stopped.
    interrupted
        Whether Ctrl-C stopped it.
    cost
        Numbers for the summary: steps, rejected steps, evaluations.
    method, reason
        The method that was used, and why if it was chosen automatically; empty where nothing was
        integrated.
    notes
        What happened on the way: change points passed, coordinates changed.
    crossings
        Name of a guard → states at which it was crossed, without accelerations.
    """

    pieces: tuple[Piece, ...]
    failure: str | None = None
    stop_time: float = 0.0
    interrupted: bool = False
    cost: dict[str, int] = field(default_factory=dict)
    method: str = ""
    reason: str = ""
    notes: tuple[str, ...] = ()
    crossings: Mapping[str, Motion] = field(default_factory=dict)

    def __repr__(self) -> str:
        ended = "" if self.failure is None else f", stopped at t = {self.stop_time:g} s"
        return f"Motion({len(self.time)} samples in {len(self.pieces)} pieces{ended})"

    @property
    def time(self) -> Floats:
        """Sample times that were reached, shape (samples,)."""
        return np.concatenate([piece.wanted for piece in self.pieces])

    @property
    def work(self) -> Floats | None:
        """Work of drives and loads since t = 0 in joules, shape (samples,), if it was asked for."""
        works = [p.interpolated(p.work) for p in self.pieces if p.work is not None]
        return np.concatenate(works) if len(works) == len(self.pieces) else None

    @property
    def state(self) -> Floats:
        """Integrated coordinates (within one turn) and rates, shape (2n, samples).

        What the coordinates are may change from piece to piece.
        """
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


def compute_motion(system: System, settings: Settings) -> Motion:
    """Solve for the motion of a system; nothing is integrated if it has no free coordinate."""
    if system.topology.coordinates:
        from linkages.solution.march import integrated_motion

        return integrated_motion(system, settings)
    from linkages.solution.driven import driven_motion

    return driven_motion(system, settings)


def block_place(model: Model, block: int, time: float) -> str:
    """When and where something happens to a block."""
    found = next(b for b in model.topology.solved_blocks if b.index == block)
    names = " and ".join(found.unknowns)
    apex = found.loops[0].apex
    slid = next((n for n in found.unknowns if axis_label(n) == apex), None)
    joint = apex if slid is None else next(iter(model.mechanism.bodies[slid].points))
    return f"at t = {time:.9g} s, joint {joint}, block {block} ({found.title} of {names})"


def block_alignment(model: Model, block: int) -> str:
    """What a block looks like at a singular position."""
    found = next(b for b in model.topology.solved_blocks if b.index == block)
    one, other = found.unknowns[0], found.unknowns[-1]
    return {
        "RRR": f"{' and '.join(found.unknowns)} are in line",
        "RRP": f"{one} is perpendicular to the axis of {other}",
        "RPR": f"the axis of {other} on {one} passes its pin at right angles",
        "PP": f"the axes of {one} and {other} are parallel",
    }.get(found.kind, "the group has a singular position")


def passed_text(model: Model, time: float, blocks: tuple[int, ...]) -> str:
    """A sentence about a change point that a motion went through."""
    places = [block_place(model, block, time).split(", ", 1)[1] for block in blocks[:3]]
    more = f" and {len(blocks) - 3} more" if len(blocks) > 3 else ""
    return (
        f"at t = {time:.6g} s the motion went on smoothly through a change point: "
        f"{'; '.join(places)}{more}, where {block_alignment(model, blocks[0])}"
    )


def block_failure(
    model: Model, block: int, time: float, singular: bool, way_on: str = COULD_PASS
) -> str:
    """A sentence that says when, where and why a motion cannot go on.

    Parameters
    ----------
    model, block, time
        What stopped it, and when.
    singular
        Whether there are positions beyond.
    way_on
        What can be said of the way on then: `COULD_PASS` or its like.
    """
    found = next(b for b in model.topology.solved_blocks if b.index == block)
    place = block_place(model, block, time)
    aligned = block_alignment(model, block)
    if found.kind == "PP":
        return f"{place}: {aligned}, so nothing determines their positions"
    if singular:
        return (
            f"{place}: {aligned}; this position is singular, from it the mechanism can go on in "
            f"two ways and double precision cannot tell which ({way_on})"
        )
    if found.kind == ITERATED:
        why = "where its constraints contradict each other, or" if found.surplus else "which is"
        return f"{place}: no position closes its loops beyond this one, {why} a limit of its motion"
    return f"{place}: the mechanism cannot be assembled beyond this position, where {aligned}"
