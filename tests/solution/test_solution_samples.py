"""Measures of motions that drives determine do not depend on the samples of the user."""

import numpy as np
import pytest

import linkages
from linkages.design.differentiated import Differentiated
from linkages.kernel.system import System
from linkages.solution.series import system_series

DRIVEN = ["four-bar", "slider-crank", "quick-return", "toggle-press", "scotch-yoke", "jansen",
          "watt-six-bar", "five-bar", "beam-pump", "ninebar-ideal", "peaucellier"]  # fmt: skip
SMALL, WHOLE = "four-bar", ("max", "min", "range", "time_of_max", "mean", "rms", "integral")
COUNTS = (5, 17, 200, 2001)


def measures_of(mechanism):
    """Reductions of series of every kind, and parts and functions of the motion."""
    known = [name for name in system_series(System(mechanism)) if " " not in name and "." in name]
    names = [name for name in known if not name.endswith(("error", "residual", "advantage"))]
    texts = [f"{f}({name})" for k, name in enumerate(names) for f in (WHOLE[k % 7], "max")]
    drive = next(iter(mechanism.prescribed))
    angle = next((n for n in known if n in (f"{drive}.angle", f"{drive}.position")), known[0])
    return [
        *texts,
        f"during(final(t)/3, final(t)/2, max({known[0]}))",
        f"at(time_of_max({known[0]}), {angle})",
        f"harmonic(2, {known[-1]})",
        f"range(cumulative({known[0]} - mean({known[0]})))",
    ]


def assert_same(found, scales=1e-12):
    """All values are those of the first row: the same operations at the same times."""
    first = np.array(found[0])
    for row in found[1:]:
        np.testing.assert_allclose(row, first, rtol=scales, atol=1e-12 * np.abs(first).max())


@pytest.mark.slow_except(SMALL, "toggle-press")
@pytest.mark.parametrize("name", DRIVEN)
def test_measures_do_not_depend_on_samples(name):
    mechanism = linkages.load(name)
    texts = measures_of(mechanism)
    solutions = [linkages.simulate(mechanism, samples=count) for count in COUNTS]
    assert_same([[linkages.measure(one, text) for text in texts] for one in solutions])
    rows = [[(row["value"], row["time"]) for row in one.maxima if "residual" not in row["variable"]
             and "advantage" not in row["variable"]] for one in solutions]  # fmt: skip
    assert_same(rows)


@pytest.mark.slow_except(SMALL)
@pytest.mark.parametrize("name", ["four-bar", "slider-crank", "jansen", "watt-six-bar"])
def test_sweeps_and_derivatives_do_not_depend_on_samples(name):
    mechanism = linkages.load(name)
    known = [n for n in system_series(System(mechanism)) if " " not in n and ".speed" in n]
    texts = [f"{f}({known[-1]})" for f in ("max", "rms", "range", "mean")]
    bar = next(n for n, b in mechanism.definition.value(("bars",)).items() if "length" in b)
    path = f"bars.{bar}.length"
    (length,) = Differentiated(mechanism, [], [path]).values
    axis = {path: [float(length), 1.001 * float(length)]}
    alone = [linkages.measure(linkages.simulate(mechanism, samples=9), text) for text in texts]
    found, slopes = [], []
    for count in COUNTS:
        data = linkages.sweep(mechanism, axis, texts, samples=count, cores=1)
        found.append(np.concatenate([data[text].to_numpy() for text in texts]))
        own = Differentiated(mechanism, texts, [path], run={"samples": count})
        slopes.append(own.at(own.values).derivatives.ravel())
    assert_same(found)
    np.testing.assert_allclose(found[0][::2], alone, rtol=1e-12)
    assert_same(slopes)


def test_peaks_between_few_samples_are_found():
    """x = sin 7φ of a crank at 60 rpm is 1 at (1 + 4k)/28 s; five samples show nothing of it."""
    mechanism = linkages.loads(
        "joints: {O: [0, 0]}\nbars: {crank: {joints: [O, A], length: 1 m}}\n"
        "drives: {crank: {angle: 0, speed: 60 rpm}}\nsimulate: {end: 1, samples: 5}\n"
    )
    solution = linkages.simulate(mechanism)
    assert linkages.measure(solution, "max(sin(7*crank.angle))") == pytest.approx(1.0, abs=1e-15)
    first = linkages.measure(solution, "time_of_max(sin(7*crank.angle))")
    assert first == pytest.approx(1 / 28, abs=1e-8)  # values tell a place to half the digits
    turn = "last_turn(7*crank.angle, range(t))"
    assert linkages.measure(solution, turn) == pytest.approx(1 / 7, abs=1e-13)
