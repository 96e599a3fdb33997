"""Mechanisms, states and what kernels and NumPy say of them: what exported programs must say."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

import linkages
from linkages.exports.kernels.exported import exported
from linkages.kernel.numbers.parameters import NEAREST
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.solution.values.series import system_series

ROOT = Path(__file__).parents[2]
NAMES = sorted(path.stem for path in (ROOT / "mechanisms").glob("*.yaml"))
TIMES = (0.0, 0.013, 0.04)

NEAR = 1e-12
"""Of the largest value of a variable: libraries differ in last digits of sines, and formulas with
cancellation carry some of that on."""


@cache
def system(name):
    """A shipped mechanism, assembled."""
    return System(linkages.load(ROOT / "mechanisms" / f"{name}.yaml"))


@cache
def kernel(name):
    """The same as it is exported."""
    return exported(system(name))


@dataclass(frozen=True)
class Case:
    """A time, a state, and what follows."""

    time: float
    state: np.ndarray
    rates: np.ndarray
    outputs: np.ndarray


@cache
def cases(name):
    """States about the initial one, whose loops close."""
    of, random = system(name), np.random.default_rng(5)
    own = kernel(name).quantities
    nodes = [system_series(of)[q.name].node(of.model) for q in own]
    accelerations = of.model.integrated_accelerations(of.model.changes)
    moved = of.layout.moved
    half = len(of.layout.coordinates)
    found = []
    for time in TIMES:
        state = of.state.copy()
        for rows in (slice(0, moved), slice(half, half + moved)):
            state[rows] += 0.02 * (time > 0) * random.normal(size=moved)
        held = of.starting_held()[:, None]
        if of.layout.carried:
            state[of.layout.carried_rows] = of.evaluate(
                of.model.settled, time, state[:, None], held=held
            )[:, 0]
        second = of.evaluate(accelerations, time, state[:, None], held=held)
        outputs = of.evaluate(nodes, time, state[:, None], second, held=held)[:, 0]
        rates = np.concatenate([state[half:], second[:, 0]])
        rates[len(of.layout.free) : moved] = 0.0
        found.append(Case(time, state, rates, outputs))
    return found


def assert_near(found, expected, groups=None):
    """Equal but for round-off of the largest value of a group."""
    expected = np.array(expected, dtype=float)
    found = np.array([float(str(value).replace("Infinity", "inf")) for value in found])
    names = np.array(groups if groups is not None else [""] * len(found))
    for group in dict.fromkeys(names):
        rows = names == group
        sizes = np.abs(expected[rows])
        near = NEAR * sizes[np.isfinite(sizes)].max(initial=1.0)
        np.testing.assert_allclose(found[rows], expected[rows], rtol=0, atol=near, err_msg=group)


CHANGED = 1.004
"""By how much numbers are changed: mechanisms can still be assembled, and round-off is far less."""


@cache
def changes(name):
    """For each number of the file, and for all at once: numbers, parameters, initial state."""
    own, varying = kernel(name), Varying(system(name).mechanism)
    values = [number.value for number in own.feed.numbers]
    # without closed forms each is assembled by a search, which takes its time
    every = range(0, len(values), 6 if system(name).layout.carried else 1)
    found = []
    for changed in (*({place} for place in every), set(every)):
        numbers = [v * (CHANGED if k in changed else 1.0) for k, v in enumerate(values)]
        paths = {own.feed.numbers[k].path: numbers[k] for k in changed}
        other = varying.at(paths)
        found.append((numbers, other.parameters, other.state))
    return found


def compared_parameters(name):
    """Places of parameters that follow from numbers: what tells round-off apart does not."""
    return [k for k, path in enumerate(kernel(name).parameters) if path != NEAREST]
