"""Tangents that come far apart within an interval, against exponents in closed form."""

import numpy as np
import pytest
from chaos_systems import exponents_of

import linkages
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.march import March
from linkages.solution.motion import Renormalised
from linkages.solvers.flow import MOST_DOUBT

G, WEAK = 9.81, 1.0


def bars(damping):
    """Two point masses of 1 kg on bars of 1 m, which hang at rest beside each other."""
    return linkages.loads(f"""\
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
""")


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


MOTOR = """
joints: {{O: [0, 0]}}
bars: {{wheel: {{points: {{O: [0, 0], P: [0.1, 0]}}, mass: 4, center: [0, 0], inertia: 0.02}}}}
motors: {{h: {{bar: wheel, voltage: "6 + 3*sin(5*t)", torque_constant: 0.5 N m/A, resistance: 2 ohm,
             inductance: {inductance}}}}}
free: {{wheel: {{angle: 0}}}}
"""
SLIDER = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
free: {m: {position: 0.1}}
simulate: {end: 2}
"""
PID = """controllers: {hold: {slider: m, of: m.position, setpoint: 0, proportional: 6, integral: 5,
                       derivative: 4}}
"""
MAXWELL = """springs: [{slider: m, stiffness: 2}]
maxwell: [{slider: m, stiffness: 3, damping: 1}]
"""
UNSTABLE = 'loads: [{slider: m, force: "250000*m.position"}]\n'


def motor(inductance):
    """Its equations for speed and current, J ω' = k i, L i' = −k ω − R i, beside the angle."""
    matrix = [[0, 1, 0], [0, 0, 0.5 / 0.02], [0, -0.5 / inductance, -2 / inductance]]
    return MOTOR.format(inductance=f"{inductance} H"), matrix


LINEAR = {
    "motor": motor(0.05),
    "slow motor": motor(0.5),
    # z' = −I x, F = −P x + z − D v
    "PID": (SLIDER + PID, [[0, 1, 0], [-6, -4, 1], [-5, 0, 0]]),
    # s' = v − k s/d
    "Maxwell": (SLIDER + MAXWELL, [[0, 1, 0], [-2, 0, -3], [0, 1, -3]]),
}


@pytest.mark.slow_except("slow motor-*", "Maxwell-*", "PID-40*")
@pytest.mark.parametrize("interval", [0.5, 40.0])
@pytest.mark.parametrize(("text", "matrix"), LINEAR.values(), ids=LINEAR)
def test_internal_states(text, matrix, interval):
    """Exponents of linear systems, in runs so long that tangents would shrink below e⁻³⁵⁰ by far.

    Pairs swing about their mean within an interval.
    """
    known = np.sort(np.linalg.eigvals(matrix).real)[::-1]
    mechanism = linkages.loads(text)
    found = exponents_of(mechanism, periods=int(1280 / interval), skip=5, interval=interval)
    assert found.values == pytest.approx(known, abs=6e-3)
    assert found.values.sum() == pytest.approx(np.trace(matrix), rel=1e-6)
    assert found.lost == 0


@pytest.mark.slow_except("tsit5", "rk4")
@pytest.mark.parametrize(
    "how",
    [
        {"method": "tsit5"},
        {"method": "rk4", "step": 2e-3},
        {"method": "gauss8", "step": 1e-2},
    ],
    ids=["tsit5", "rk4", "gauss8"],
)
def test_internal_states_in_every_kind_of_loop(how):
    text, matrix = LINEAR["motor"]
    known = np.sort(np.linalg.eigvals(matrix).real)[::-1]
    mechanism = linkages.loads(text)
    found = exponents_of(mechanism, periods=64, skip=2, interval=0.4, **how)
    assert found.values == pytest.approx(known, abs=1e-3)


def test_bristles_of_friction():
    """Their exponent is that of the bristles where they are bent while a mass slides, −σ₀|v|/F."""
    text = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, mass: 1}}
friction: [{slider: m, force: 1, bristle_stiffness: 1e3}]
loads: [{slider: m, force: 1}]
free: {m: {position: 0, speed: 0.5}}
simulate: {end: 1}
"""
    found = exponents_of(linkages.loads(text), periods=20, skip=1)
    assert found.values[-1] == pytest.approx(-500.0, rel=1e-2)
    assert found.values[0] == pytest.approx(0.0, abs=0.2)


@pytest.mark.slow_except("*-1")
@pytest.mark.parametrize("count", [1, 2])
@pytest.mark.parametrize("how", [{}, {"method": "rk4", "step": 1e-4}], ids=["dop853", "rk4"])
def test_intervals_in_which_tangents_would_overflow(how, count):
    """A body at rest on a top, from which neighbours fall by e¹⁰⁰⁰ within an interval."""
    text = SLIDER.replace("0.1", "0") + UNSTABLE
    mechanism = linkages.loads(text)
    found = exponents_of(mechanism, periods=16, skip=1, interval=8.0, count=count, **how)
    assert found.values == pytest.approx([500.0, -500.0][:count], rel=1e-3)
