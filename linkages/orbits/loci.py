"""Loci of special points in two parameters: folds, doublings, Neimark–Sacker, Hopf, and contact.

A locus is a branch of a larger system of equations: those of the orbit or equilibrium, and the
vanishing of a test function, with one of the two parameters among the unknowns.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.errors import ComputationError
from linkages.options.run import RunOptions
from linkages.orbits.contact_events import Miss, extremum_guard, misses, watched_gradient
from linkages.orbits.equations import Complex, Evaluated, Orbit, Problem, Solution, pair_product

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

FOLLOWED = (
    "fold", "period doubling", "neimark-sacker", "hopf", "grazing", "contact loss",
)  # fmt: skip
"""Kinds of points of which there are loci."""

CONTACTS = ("grazing", "contact loss")
"""Those that are extrema of what a switch watches."""

SLOPE_STEP = 1e-6
"""Step of differences of a test function, in scaled unknowns."""

GAP = 1e-6
"""Gap of the near miss for which a grazing orbit of a rigid contact is solved, over the usual one.

A rigid contact is met a little before it is touched at no rate; the rest of the way is linear.
"""

BEND_STEP = 1e-4
"""Step of second differences along the null vector of a fold."""


class Locus(Problem):
    """Special points of one kind; the last unknown is the first of two places.

    `inner`: equations of the orbit or equilibrium, with two rays.
    `kind`: of the special points.
    `about`: name of the switch, of those of contacts.
    `time`: of the extremum that grazes, as a part of the period.
    """

    def __init__(self, inner: Problem, kind: str, about: str = "", time: float = math.nan) -> None:
        self.inner, self.kind, self.about, self.time = inner, kind, about, time
        self.shooting = inner.shooting
        self.scale = np.append(inner.scale, 1.0)
        self.rigid = isinstance(inner, Orbit) and about in inner.rigid
        self.gap = 0.0

    def where(self, unknowns: Floats, places: Floats) -> Floats:
        """Places along both rays."""
        return np.array([unknowns[-1], places[0]])

    def state(self, unknowns: Floats) -> Floats:
        """State of the orbit or equilibrium, shape (x,)."""
        return self.inner.state(unknowns[:-1])

    def period(self, unknowns: Floats, places: Floats) -> float | None:
        """In seconds."""
        return self.inner.period(unknowns[:-1], self.where(unknowns, places))

    def with_run(self, run: RunOptions) -> Locus:
        """The same locus, integrated in another way."""
        return Locus(self.inner.with_run(run), self.kind, self.about, self.time)

    def stable(self, spectrum: Complex) -> bool:
        """As of the orbit or equilibrium."""
        return self.inner.stable(spectrum)

    def decisive(self, spectrum: Complex) -> Complex:
        """As of the orbit or equilibrium."""
        return self.inner.decisive(spectrum)

    def evaluate(self, unknowns: Floats, places: Floats, near: Evaluated | None) -> Evaluated:
        """Equations of the orbit or equilibrium, and the test function."""
        inner, count = self.inner, len(self.inner.scale)
        vector = np.append(unknowns[:-1] / inner.scale, self.where(unknowns, places))

        def at(scaled: Floats) -> tuple[Evaluated, float]:
            own = inner.evaluate(scaled[:count] * inner.scale, scaled[count:], near)
            return own, self._test(own, scaled[:count] * inner.scale, scaled[count:])

        base, value = at(vector)
        if self.kind in CONTACTS:
            slopes = self._gap_slopes(base, vector[:count] * inner.scale, vector[count:])
        else:
            slopes = np.empty(count + 2)
            for k in range(count + 2):
                moved = vector.copy()
                moved[k] += SLOPE_STEP
                slopes[k] = (at(moved)[1] - value) / SLOPE_STEP
        by_unknowns = np.zeros((count + 1, count + 1))
        by_unknowns[:count, :count], by_unknowns[:count, count] = (
            base.by_unknowns,
            base.by_places[:, 0],
        )
        by_unknowns[count] = slopes[: count + 1] / self.scale
        by_places = np.append(base.by_places[:, 1], slopes[-1])[:, None]
        return Evaluated(
            residual=np.append(base.residual, value),
            by_unknowns=by_unknowns,
            by_places=by_places,
            spectrum=base.spectrum,
            vectors=base.vectors,
            beginning=base.beginning,
            shots=base.shots,
        )

    def _test(self, at: Evaluated, unknowns: Floats, places: Floats) -> float:
        """The test function of the kind."""
        spectrum = self.inner.decisive(at.spectrum)
        match self.kind:
            case "fold":
                matrix = at.by_unknowns * self.inner.scale / self.inner.scale[:, None]
                return float(np.linalg.det(matrix / np.linalg.norm(matrix, axis=1)[:, None]))
            case "period doubling":
                return float(np.prod((1.0 + spectrum) / (1.0 + np.abs(spectrum))).real)
            case "neimark-sacker" | "hopf":
                return pair_product(spectrum, self.kind == "hopf")
        return self._gap(at, unknowns, places)

    def _miss(self, at: Evaluated, unknowns: Floats, places: Floats) -> tuple[Miss, int]:
        """The extremum that grazes, and the part of the orbit in which it is."""
        inner = self.inner
        assert isinstance(inner, Orbit)
        shots = at.shots
        if not self.rigid:
            guards = [extremum_guard(self.about)]
            shots = inner.shots(unknowns, places, at, tangents=False, guards=guards)
        period = inner.period(unknowns, places)
        wanted = [
            (abs((miss.time / period - self.time + 0.5) % 1.0 - 0.5), miss, node)
            for node, shot in enumerate(shots)
            for miss in misses([shot], self.about)
            if miss.highest == (self.kind == "grazing")
        ]
        if not wanted:
            raise ComputationError(f"{self.about} has no extremum any more", time=0.0)
        _, miss, node = min(wanted)
        return miss, node

    def _gap(self, at: Evaluated, unknowns: Floats, places: Floats) -> float:
        """Extremum of what the switch watches, near a time of the period."""
        return self._miss(at, unknowns, places)[0].value + self.gap

    def _gap_slopes(self, at: Evaluated, unknowns: Floats, places: Floats) -> Floats:
        """Derivatives of it by scaled unknowns and places: its time does not matter."""
        inner, shooting = self.inner, self.shooting
        assert isinstance(inner, Orbit)
        miss, node = self._miss(at, unknowns, places)
        unit = inner.period(unknowns, places) / (inner.periods or 1)
        start = 0.0 if inner.free else float(unit * inner.fractions()[node])
        delay = miss.time - start
        state = inner.starts(unknowns)[node]
        held = at.shots[node - 1].held or None
        shot = shooting.shoot(places, state, delay, start=start, held=held)
        gradient = watched_gradient(shooting, places, shot, miss.time, self.about)
        x, count = shooting.size, len(inner.scale)
        result = np.zeros(count + len(places))
        own = slice(node * x, (node + 1) * x)
        result[own] = gradient @ shot.by_state * shooting.scale
        moved = np.zeros(len(places)) if inner.free else shooting.period_slopes(places)
        before = shot.by_state @ at.shots[node - 1].flow
        result[count:] = gradient @ shot.by_place
        if not inner.free:
            result[count:] -= gradient @ before * moved * inner.fractions()[node]
        return result

    def usual_gap(self, at: Evaluated) -> float:
        """Largest extremum of what the switch watches."""
        return max(abs(miss.value) for miss in misses(at.shots, self.about))

    def clearest(self, solution: Solution) -> float:
        """As of the orbit."""
        return self.inner.clearest(self._inner(solution)) if isinstance(self.inner, Orbit) else 0.0

    def later(self, solution: Solution, delay: float) -> tuple[Locus, Floats, Floats]:
        """As of the orbit, with nodes a time in seconds later."""
        inner = self.inner
        assert isinstance(inner, Orbit)
        problem, unknowns, moved = inner.later(self._inner(solution), delay)
        size = len(unknowns)
        result = Locus(problem, self.kind, self.about, self.time)
        result.gap = self.gap
        both = np.eye(size + 1, size + 2)
        both[:size] = moved
        return result, np.append(unknowns, solution.unknowns[-1]), both

    def _inner(self, solution: Solution) -> Solution:
        places = self.where(solution.unknowns, solution.places)
        before = solution.before
        return Solution(solution.unknowns[:-1], places, solution.at, 0, before)

    def settled(self, solution: Solution) -> Floats:
        """Places of a solution, of a rigid contact without the gap that is left."""
        where = self.where(solution.unknowns, solution.places)
        if not self.gap:
            return where
        at, scale = solution.at, self.scale
        matrix = np.hstack([at.by_unknowns * scale, at.by_places]) / scale[:, None]
        aim = np.zeros(len(scale))
        aim[-1] = self.gap
        step = np.linalg.lstsq(matrix, aim, rcond=None)[0]
        return where + step[-2:]

    def degenerate(self, solution: Solution, near: Evaluated) -> dict[str, float]:
        """Functions that change sign where a point is special in two ways at once."""
        spectrum = self.inner.decisive(near.spectrum)
        if self.kind in ("neimark-sacker", "hopf"):
            return self._resonances(spectrum)
        if self.kind == "fold":
            others = _without(spectrum, 1.0)
            result = {"cusp": self._bend(solution)}
            if isinstance(self.inner, Orbit):
                result |= {
                    "fold-flip": _product(others, 1.0),
                    "resonance 1:1": _product(others, -1.0),
                }
            return result
        if self.kind == "period doubling":
            others = _without(spectrum, -1.0)
            return {"fold-flip": _product(others, -1.0), "resonance 1:2": _product(others, 1.0)}
        return {
            "grazing-fold": _product(spectrum, -1.0),
            "grazing-flip": _product(spectrum, 1.0),
        }

    def _resonances(self, spectrum: Complex) -> dict[str, float]:
        if self.kind == "hopf" or len(spectrum) < 2:
            return {}
        pairs = [(a, b) for i, a in enumerate(spectrum) for b in spectrum[i + 1 :]]
        pair = min(pairs, key=lambda pair: abs(pair[0] * pair[1] - 1.0))
        cosine = float((pair[0] + pair[1]).real) / 2.0  # beyond ±1 where the pair is real
        return {
            "resonance 1:1": cosine - 1.0,
            "resonance 1:2": cosine + 1.0,
            "resonance 1:3": cosine + 0.5,
            "resonance 1:4": cosine,
        }

    def _bend(self, solution: Solution) -> float:
        """Quadratic coefficient of a fold, which vanishes at a cusp."""
        inner, scale = self.inner, self.inner.scale
        at = solution.at
        count = len(scale)
        matrix = at.by_unknowns[:count, :count] * scale / scale[:, None]
        left, _, right = np.linalg.svd(matrix)
        normal, null = left[:, -1], right[-1]
        # signs that do not jump from point to point
        null = null * np.sign(null[np.argmax(np.abs(null))])
        normal = normal * np.sign(normal @ (at.by_unknowns[:count, count] / scale) or 1.0)
        unknowns = solution.unknowns[:-1]
        where = self.where(solution.unknowns, solution.places)
        ends = [
            inner.evaluate(unknowns + side * BEND_STEP * null * scale, where, at).residual / scale
            for side in (1.0, -1.0)
        ]
        middle = at.residual[:count] / scale
        return float(normal @ (ends[0] + ends[1] - 2 * middle)) / BEND_STEP**2


def _without(spectrum: Complex, value: float) -> Complex:
    """A spectrum without the entry that is closest to a value."""
    return np.delete(spectrum, np.argmin(np.abs(spectrum - value))) if len(spectrum) else spectrum


def _product(spectrum: Complex, sign: float) -> float:
    """Product of 1 + sign·μ over all entries, 1 without any."""
    return float(np.prod((1.0 + sign * spectrum) / (1.0 + np.abs(spectrum))).real)


def locus_values(data: xr.Dataset, paths: Sequence[str]) -> tuple[str, Floats]:
    """Kind of the points of a locus, and values of parameters in SI, shape (point, path).

    Raises ValueError if it is no locus, or one of other parameters.
    """
    branches = json.loads(data.attrs.get("branches", "[]"))
    if not branches or not branches[0].get("locus"):
        raise ValueError("holds no locus; expected a file that follow --locus wrote")
    varied = [str(path) for path in data["path"].values]
    if not set(paths) <= set(varied):
        own, asked = (" and ".join(each) for each in (varied, paths))
        raise ValueError(f"holds a locus over {own}; the plane varies {asked}")
    values = data["value"].to_numpy()[:, [varied.index(path) for path in paths]]
    return str(branches[0]["locus"]), values
