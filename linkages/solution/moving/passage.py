"""Through a change point in one step, so that nothing is evaluated close to it.

At a change point the closure is singular, but the motion that inertia continues is smooth: the
assembly mode of the blocks concerned changes sign with their margin. Close to it accelerations
have lost their digits to round-off (ε/m³ at the relative margin m). One step of collocation at
Gauss's nodes leads across, with the change point in its middle, between two nodes; nodes beyond it
are in the other mode. Its order is so high that the step can be long, and all nodes stay away
from the change point. Outputs in between are interpolated from those at the nodes.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial.legendre import leggauss
from numpy.typing import NDArray

from linkages.kernel.closure.dyads import LEAST_MARGIN
from linkages.solvers.coefficients.collocation import cardinals
from linkages.solvers.flow import Flow
from linkages.solvers.methods.foreign import caller

Floats = NDArray[np.float64]

STAGES = 10
"""Even, so that no node lies in the middle."""

COMPARED = 8
"""Stages of the step that the first one is compared with."""

MOST_ITERATIONS = 100

CENTRINGS = 2
"""How often the time of the change point is improved before the step across it."""

SAME_TIME = 0.2
"""Blocks whose margins vanish within this part of the way are taken to do so together."""

CONTINUES = 0.5
"""How much the rate of a margin may change in the step, relative to itself."""


def vanishes(times: Floats, margins: Floats, crossing: float) -> bool:
    """Whether margins on both sides of a change point say that there is one.

    Their square is smooth. Where links miss each other, or cannot quite reach, its least value is
    above or below zero, and the motion goes on in the same mode, or ends.

    Parameters
    ----------
    times, margins
        Relative margins of a block at times around the change point, shape (m,).
    crossing
        About when the margin vanishes.
    """
    place, beside, least = crossing, 0.05 * (times[-1] - times[0]), np.inf
    for _ in range(3):
        around = cardinals(times, place + beside * np.array([-1.0, 0.0, 1.0]))
        before, least, after = around @ margins**2
        slope, bend = 0.5 * (after - before), before - 2.0 * least + after
        if not bend > 0.0:
            return False
        place, least = place - beside * slope / bend, least - 0.5 * slope**2 / bend
        beside *= 0.1
    return bool(abs(least) <= LEAST_MARGIN**2)


@dataclass(frozen=True)
class Passage:
    """A step through a change point.

    Parameters
    ----------
    time
        Where the state was computed, its ends included, shape (m,).
    state, acceleration
        Shape (2n, m) and (n, m).
    angles
        Dependent angles with their whole turns, shape (d, m).
    beyond
        Which of these times lie behind the change point.
    crossing
        Time of the change point.
    blocks
        Those that changed their mode.
    evaluations
        How often the kernel was called.
    """

    time: Floats
    state: Floats
    acceleration: Floats
    angles: Floats
    beyond: NDArray[np.bool_]
    crossing: float
    blocks: tuple[int, ...]
    evaluations: int


class Crossing:
    """Tries to step across the change point that margins head for.

    Parameters
    ----------
    flow
        The equations in the mode before the change point.
    direction
        +1 forward in time, −1 backward.
    """

    def __init__(self, flow: Flow, direction: float) -> None:
        self._flow = flow
        self._direction = direction
        self._size = flow.written
        self._evaluations = 0

    def ahead(self, t: float, y: Floats) -> tuple[float, tuple[int, ...]] | None:
        """Time until the next margin vanishes if it goes on as it does, and the blocks."""
        status, out = caller(self._flow, self._size)(t, y)
        if status != 0:
            return None
        margin, rate = self._margins(out)
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.where(margin * rate * self._direction < 0, np.abs(margin / rate), np.inf)
        nearest = float(left.min(initial=np.inf))
        if not np.isfinite(nearest):
            return None
        return nearest, tuple(int(b) for b in np.flatnonzero(left <= nearest * (1 + SAME_TIME)))

    def across(
        self,
        other: Flow,
        t: float,
        y: Floats,
        left: float,
        blocks: Collection[int],
        tolerance: Floats,
        angles: Floats,
    ) -> Passage | None:
        """Step across, or None if no smooth motion leads there.

        Parameters
        ----------
        other
            The equations in the mode beyond.
        t, y
            Time and state before the change point.
        left, blocks
            From `ahead`.
        tolerance
            Allowed error, shape (2n,).
        angles
            Dependent angles before the change point, shape (d,).
        """
        self._other = other
        for _ in range(CENTRINGS):
            rough = self._collocated(t, y, 2.0 * self._direction * left, COMPARED)
            if rough is None:
                return None
            left = abs(self._zero(rough[0], rough[2], min(blocks)) - t)
        h = 2.0 * self._direction * left
        found = self._collocated(t, y, h, STAGES)
        compared = self._collocated(t, y, h, COMPARED)
        if found is None or compared is None:
            return None
        times, states, outputs = found
        if not (np.abs(states[-1] - compared[1][-1]) <= tolerance).all():
            return None
        if not self._continues(outputs[0], outputs[-1], blocks):
            return None
        crossing = t + self._direction * left
        relative = np.array([self._margins(out)[0] for out in outputs]) / self._flow.margin_scale
        if not all(vanishes(times, relative[:, block], crossing) for block in blocks):
            return None
        n = self._flow.coordinates
        return Passage(
            time=times,
            state=np.array(states).T,
            acceleration=np.array([out[:n] for out in outputs]).T,
            angles=self._angles(angles, h, outputs),
            beyond=(times - crossing) * self._direction > 0,
            crossing=crossing,
            blocks=tuple(blocks),
            evaluations=self._evaluations,
        )

    def _zero(self, times: Floats, outputs: list[Floats], block: int) -> float:
        """When a margin vanishes, by inverse interpolation."""
        margins = [self._margins(out)[0][block] for out in outputs]
        if not (np.diff(margins) * np.sign(margins[-1] - margins[0]) > 0).all():
            return float(0.5 * (times[0] + times[-1]))
        return float((cardinals(np.array(margins), np.zeros(1)) @ times)[0])

    def _margins(self, out: Floats) -> tuple[Floats, Floats]:
        n, b = self._flow.coordinates, len(self._flow.margin_scale)
        return out[n : n + b], out[n + b : n + 2 * b]

    def _continues(self, first: Floats, last: Floats, blocks: Collection[int]) -> bool:
        """Whether margins went through zero, and no others did, as smoothly as they began."""
        (margin, rate), (margin_end, rate_end) = self._margins(first), self._margins(last)
        for block in range(len(margin)):
            changed = margin[block] * margin_end[block] < 0
            if changed != (block in blocks):
                return False
            if changed and abs(rate_end[block] - rate[block]) > CONTINUES * abs(rate[block]):
                return False
        return True

    def _rates(self, t: float, y: Floats, beyond: bool) -> Floats | None:
        self._evaluations += 1
        status, out = caller(self._other if beyond else self._flow, self._size)(t, y)
        return out if status == 0 and np.isfinite(out).all() else None

    def _collocated(
        self, t: float, y: Floats, h: float, stages: int
    ) -> tuple[Floats, list[Floats], list[Floats]] | None:
        """Times, states and outputs of the kernel at the start, the nodes and the end of a step."""
        nodes, weights, once = gauss(stages)
        times = t + h * nodes
        beyond = nodes > 0.5
        n = self._flow.coordinates
        first = self._rates(t, y, beyond=False)
        if first is None:
            return None
        position, speed, acceleration = y[:n], y[n:], np.tile(first[:n], (stages, 1))
        before = np.inf
        for _ in range(MOST_ITERATIONS):
            speeds = speed + h * once @ acceleration
            states = np.concatenate([position + h * once @ speeds, speeds], axis=1)
            outputs = [self._rates(*at) for at in zip(times, states, beyond, strict=True)]
            rows = [out[:n] for out in outputs if out is not None]
            if len(rows) < stages:
                return None
            change = float(np.abs(np.array(rows) - acceleration).max())
            acceleration = np.array(rows)
            # a motion without acceleration has its round-off alone: speeds say how much matters
            scale = max(float(np.abs(rows).max()), float(np.abs(speed).max()) / abs(h))
            if change == 0.0 or (change >= 0.5 * before and change <= 1e-6 * scale):
                break  # the rest is round-off
            before = change
        else:
            return None
        speeds = speed + h * once @ acceleration
        end = np.concatenate([position + h * weights @ speeds, speed + h * weights @ acceleration])
        last = self._rates(t + h, end, beyond=True)
        if last is None:
            return None
        reached = [y, *states, end]
        found = [first, *(out for out in outputs if out is not None), last]
        settled = [self._settled(at, out) for at, out in zip(reached, found, strict=True)]
        return np.array([t, *times, t + h]), settled, found

    def _angles(self, start: Floats, h: float, outputs: list[Floats]) -> Floats:
        """Dependent angles at the start, the nodes and the end of a step, shape (d, m)."""
        if not len(start):
            return np.zeros((0, len(outputs)))
        end = self._size - 2 * self._flow.switches
        last = np.array(outputs)[:, end - 3 * len(start) : end].reshape(len(outputs), 3, -1)
        cosines, sines, speeds = last.transpose(1, 2, 0)
        _, weights, once = gauss(STAGES)
        turned = h * speeds[:, 1:-1] @ np.vstack([np.zeros(STAGES), once, weights]).T
        angles = np.arctan2(sines, cosines)
        return angles + 2 * np.pi * np.round((start[:, None] + turned - angles) / (2 * np.pi))

    def _settled(self, y: Floats, out: Floats) -> Floats:
        """A state with what iterations found for the coordinates that are carried along."""
        flow, state = self._flow, y.copy()
        n, place = flow.coordinates, flow.coordinates + 2 * len(flow.margin_scale)
        first = flow.first_carried
        state[first : first + flow.carried] = out[place : place + flow.carried]
        rates = place + flow.carried
        state[n + first : n + first + flow.carried] = out[rates : rates + flow.carried]
        return state


@cache
def gauss(stages: int) -> tuple[Floats, Floats, Floats]:
    """Nodes and weights on [0, 1], and integrals of the cardinal polynomials up to each node."""
    nodes, weights = (1.0 + leggauss(stages)[0]) / 2, leggauss(stages)[1] / 2
    once = np.array([node * (weights @ cardinals(nodes, node * nodes)) for node in nodes])
    return nodes, weights, once
