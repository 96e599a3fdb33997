"""Tangents of many linkages that grow side by side, each as it would alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.systems import Growth, Watch
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.errors import ComputationError, LinkagesError
from linkages.solution.moving.many import march_many
from linkages.solution.moving.renormalising import Renormalised

Floats = NDArray[np.float64]


class Grown:
    """A linkage whose growth has been computed: gives it out as `TangentSystem` does.

    Parameters
    ----------
    state, tangents, angles, time, furthest
        As they were at its start; state and time then as what was given out leaves them.
    """

    def __init__(self, system: LinkageTangents) -> None:
        self.state, self.tangents = system.state, system.tangents
        self.angles, self.time = system.angles, system.time
        self.furthest = system.furthest
        self.parts: list[Growth] = []
        self._given = 0
        self.error: LinkagesError | None = None

    def advance(self, interval: float) -> None:
        """Nothing is left to be computed."""
        raise AssertionError(f"growth over {interval:g} s has been computed")

    def grow(
        self,
        intervals: int,
        interval: float,  # noqa: ARG002
        *,
        orthogonal: bool = True,  # noqa: ARG002
        watch: Watch | None = None,  # noqa: ARG002
    ) -> Iterator[Growth]:
        """Yield what was computed of so many intervals, then raise what ended it early."""
        done = 0
        while done < intervals and self._given < len(self.parts):
            part = self.parts[self._given]
            self._given += 1
            done += len(part.times)
            if done:
                self.state, self.time = part.states[-1], float(part.times[-1])
            yield part
        if done < intervals and self.error is not None:
            raise self.error


def _batches(
    system: LinkageTangents, skip: int, intervals: int, length: float, orthogonal: bool
) -> Iterator[tuple[Floats, Renormalised]]:
    """The integrations for intervals that are skipped, and for those behind them."""
    yield from system.batches(skip, length, orthogonal=True)
    yield from system.batches(intervals, length, orthogonal)


def grow_together(
    systems: Sequence[LinkageTangents],
    intervals: int,
    lengths: Sequence[float],
    *,
    orthogonal: bool,
    skip: int = 0,
    watch: Watch | None = None,
) -> list[Grown]:
    """Grow the tangents of many linkages; each as `LinkageTangents.grow` does it, in all bits.

    Parameters
    ----------
    systems
        At their start; they are left at the end.
    intervals, lengths
        How many, and their length in seconds for each system.
    orthogonal
        Whether tangents are made orthonormal, or only of length one each.
    skip
        Intervals before these, which are given out apart; tangents leave them orthonormal.
    watch
        Called now and then; what it raises ends all of them.
    """
    found = [Grown(system) for system in systems]
    kinds: dict[tuple[int, int], list[int]] = {}
    for index, (system, length) in enumerate(zip(systems, lengths, strict=True)):
        kinds.setdefault(system.sampling(length), []).append(index)
    for indices in kinds.values():
        plans = [_batches(systems[k], skip, intervals, lengths[k], orthogonal) for k in indices]
        for batch in zip(*plans, strict=True):
            going = [
                (k, *part) for k, part in zip(indices, batch, strict=True) if not found[k].error
            ]
            if not going:
                break
            motions = march_many(
                [systems[k].march for k, _, _ in going],
                np.stack([times for _, times, _ in going]),
                renormalised=[each for _, _, each in going],
                watch=watch,
            )
            for (k, _, renormalised), motion in zip(going, motions, strict=True):
                if isinstance(motion, LinkagesError):
                    found[k].error = motion
                    continue
                found[k].parts.append(systems[k].taken(motion, renormalised, lengths[k]))
                try:
                    systems[k].require(motion)
                except ComputationError as error:
                    found[k].error = error
    return found
