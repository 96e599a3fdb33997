"""Tangents that come far apart within an interval, against exponents in closed form."""

import numpy as np
import pytest
from chaos_systems import exponents_of

from linkages.components.mechanisms.definition import from_document
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.reading.document import parse
from linkages.solution.moving.march import March
from linkages.solution.moving.renormalising import Renormalised
from linkages.solvers.renormalisation import MOST_DOUBT

G, WEAK = 9.81, 1.0


def bars(damping):
    """Two point masses of 1 kg on bars of 1 m, which hang at rest beside each other."""
    text = f"""\
name: Two bars
gravity: [0, {-G}]
joints: {{O: [0, 0], Q: [3, 0]}}
bars:
  a: {{joints: [O, A], length: 1}}
  b: {{joints: [Q, B], length: 1}}
masses: {{A: 1 kg, B: 1 kg}}
dampers: [{{joint: O, damping: {WEAK}}}, {{joint: Q, damping: {damping}}}]
free: {{a: {{angle: -90 deg}}, b: {{angle: -90 deg}}}}
simulate: {{end: 1}}
"""
    return from_document(parse(text, "bars.yaml"))


def known(damping):
    """Real parts of the roots of λ² + d λ + g for both bars, the largest first."""
    roots = np.concatenate([np.roots([1.0, d, G]) for d in (WEAK, damping)])
    return np.sort(roots.real)[::-1]


@pytest.mark.parametrize("damping", [30.0, 300.0, 3000.0])
@pytest.mark.parametrize("interval", [0.02, 0.4])
def test_exponents_of_strong_damping(damping, interval):
    """Whatever the interval, in which tangents come apart by up to e³⁰⁰.

    The pair of the weakly damped bar swings about its mean within an interval.
    """
    found = exponents_of(bars(damping), periods=64, skip=16, interval=interval)
    assert found.values[-1] == pytest.approx(known(damping)[-1], rel=MOST_DOUBT)
    total = next(row for row in found.certificate if row.name == "sum of all exponents")
    assert total.found == pytest.approx(-WEAK - damping, rel=MOST_DOUBT)
    assert total.tolerance < 0.01 * damping
    assert total.holds


@pytest.mark.parametrize(
    "how",
    [
        {"method": "vern9"},
        pytest.param({"method": "radau", "rtol": 1e-8}, marks=pytest.mark.slow),
        {"method": "gauss8", "step": 2e-3},
        {"method": "rk4", "step": 5e-4},
    ],
    ids=["vern9", "radau", "gauss8", "rk4"],
)
def test_every_kind_of_loop_brings_tangents_back(how):
    """As closely as rk4 follows a decay by 0.15 per step, 0.15⁵/120 of it: 4e-6."""
    found = exponents_of(bars(300.0), periods=64, skip=16, interval=0.05, **how)
    assert found.values[-1] == pytest.approx(known(300.0)[-1], rel=MOST_DOUBT)


def test_an_interval_may_be_cut_anywhere():
    """What tangents have grown by goes from one integration to the next, and nothing is lost."""
    system = System(bars(300.0))
    times = np.linspace(0, 1.6, 17)[1:]

    def grown(cuts):
        march, renormalised = March(system, RunOptions(), tangents=4), Renormalised(8)
        for part in np.split(times, cuts):
            march.advance(part, renormalised=renormalised)
        return renormalised.lengths

    whole = grown([])
    assert whole.shape == (2, 4)
    assert whole[:, -1] == pytest.approx(0.8 * known(300.0)[-1], rel=1e-2)  # less their mean swing
    assert grown([3, 11]) == pytest.approx(whole, abs=1e-3)


def test_lengths_without_orthogonality_do_not_depend_on_intervals():
    """Two tangents that shrink become parallel; their lengths are those of the slowest decay."""
    system, lengths = System(bars(300.0)), []
    for every in (1, 40):
        march = March(system, RunOptions(), tangents=4)
        renormalised = Renormalised(every, orthogonal=False)
        march.advance(np.linspace(0, 20, 41)[1:], renormalised=renormalised)
        lengths.append(renormalised.lengths.sum(axis=0))
    assert lengths[0] == pytest.approx(lengths[1], rel=1e-4)
    # e⁻¹⁰ on the side of the weakly damped bar
    assert lengths[1].min() == pytest.approx(-0.5 * WEAK * 20, abs=1.0)
