"""Tangents of many linkages that grow side by side, each as it would alone."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.growth.exponents import Exponents, lyapunov_spectrum
from linkages.chaos.growth.lyapunov import characteristic_period, parts_of
from linkages.chaos.growth.systems import Growth, Watch, replace_lost, start_tangents
from linkages.chaos.growth.tangents import LinkageTangents
from linkages.chaos.sections.free_states import require_free
from linkages.errors import LinkagesError
from linkages.kernel.system import System
from linkages.options.exponents import ExponentOptions
from linkages.solution.moving.many import Going, side_by_side
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
    if skip:
        replace_lost(system)
    yield from system.batches(intervals, length, orthogonal)


def growing(
    system: LinkageTangents, intervals: int, length: float, *, orthogonal: bool, skip: int = 0
) -> Going[Grown]:
    """Grow the tangents of a linkage by integrations that it asks for; see `grow_together`."""
    found = Grown(system)
    try:
        for times, renormalised in _batches(system, skip, intervals, length, orthogonal):
            motion = yield from system.march.advancing(times, renormalised=renormalised)
            found.parts.append(system.taken(motion, renormalised, length))
            system.require(motion)
    except LinkagesError as error:
        found.error = error
    return found


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
    going = [
        growing(system, intervals, length, orthogonal=orthogonal, skip=skip)
        for system, length in zip(systems, lengths, strict=True)
    ]
    found = side_by_side(going, watch)
    return [grown for grown in found if isinstance(grown, Grown)]


def exponents_of(system: System, options: ExponentOptions) -> Going[Exponents]:
    """The largest exponents of a motion, by integrations that it asks for.

    As `linkages.chaos.growth.lyapunov.run_exponents` has them, where these are not all of them.
    """
    assert options.count is not None
    require_free(system)
    parts, length = parts_of(options), options.interval or characteristic_period(system.mechanism)
    tangents = LinkageTangents(system, options.count, options)
    start_tangents(tangents, options.count)
    intervals, interval, skip = options.periods * parts, length / parts, options.skip * parts
    grown = yield from growing(tangents, intervals, interval, orthogonal=True, skip=skip)
    return lyapunov_spectrum(
        grown, intervals=intervals, interval=interval, count=options.count, skip=skip
    )
