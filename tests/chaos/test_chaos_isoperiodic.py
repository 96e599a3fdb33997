"""Planes of periods, of motions whose period is known."""

import numpy as np
import pytest
from make.contact_route import ROUTE
from make.periods import doubling
from scipy.optimize import brentq

import linkages
from linkages.options.option import OptionError
from linkages.sweeps.running import Threads
from linkages.sweeps.store import status

OSCILLATOR = """\
name: Impact oscillator
gravity: [0, 0]
parameters: {A: 0.6, w: 0.8}
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, angle: 0, mass: 1}}
springs: [{slider: block, stiffness: 1, position: 0, damping: 0.1}]
stops: [{slider: block, upper: 1, restitution: 0.8, least_rate: 1e-6}]
loads: [{slider: block, force: "A*cos(w*t)"}]
free: {block: {position: 0, speed: 0}}
"""
A, W = "parameters.A", "parameters.w"
PERIODIC, CHAOTIC, UNDECIDED = 1, 2, 3


def oscillator():
    return linkages.loads(OSCILLATOR)


def plane(mechanism, x, y, **options):
    return linkages.chaos_map(mechanism, x, y, indicator="period", **options)


def alone(mechanism, x, **options):
    """One row."""
    return plane(mechanism, x, {"gravity[0]": [0.0, 0.0]}, **options).isel(y=0)


def impacts(amplitude, frequency, periods=600, kept=60, state=(0.0, 0.0)):
    """Period and impacts in it of the oscillator, from the closed form between two impacts.

    x″ + 0.1 x′ + x = A cos ωt with x ≤ 1 and v → −0.8 v; the solution is the response of the
    oscillator without a stop, plus a damped oscillation that begins anew at every impact.
    """
    c, length = 0.1, 2 * np.pi / frequency
    own = np.sqrt(1 - c * c / 4)
    gain = amplitude / complex(1 - frequency**2, c * frequency)

    def response(t):
        turned = gain * np.exp(1j * frequency * t)
        return turned.real, (1j * frequency * turned).real

    def motion(t, begin, x, v):
        at, rate = response(begin)
        a, s = x - at, t - begin
        b = (v - rate + c / 2 * a) / own
        decay, cosine, sine = np.exp(-c / 2 * s), np.cos(own * s), np.sin(own * s)
        place, speed = response(t)
        free = decay * (a * cosine + b * sine)
        return place + free, speed - c / 2 * free + own * decay * (b * cosine - a * sine)

    points, counts = [], []
    for number in range(periods):
        begin, end, hits = number * length, (number + 1) * length, 0
        while True:
            times = np.linspace(begin, end, 400)
            beyond = motion(times, begin, *state)[0] - 1.0
            above = np.flatnonzero((beyond[1:] > 0) & (beyond[:-1] <= 0))
            if not len(above):
                state = motion(end, begin, *state)
                break
            first = times[above[0]]

            def gap(t, begin=begin, state=state):
                return motion(t, begin, *state)[0] - 1.0

            hit = brentq(gap, first, times[above[0] + 1], xtol=1e-14)
            state = (1.0, -0.8 * motion(hit, begin, *state)[1])
            begin, hits = hit, hits + 1
        points.append(state)
        counts.append(hits)
    last, counts = np.array(points[-kept:]), np.array(counts[-kept:])
    for period in range(1, kept // 2):
        if np.abs(last[period:] - last[:-period]).max() < 1e-8:
            return period, int(counts[-period:].sum())
    return None, None


@pytest.mark.parametrize(
    ("frequency", "amplitudes"),
    [
        # grazing at 0.36878…, doubling at 0.51821… (closed form, 17 digits): silent below, then
        # many motions, one impact in one period above
        (0.8, [0.3, 0.35, 0.4, 0.45, 0.5, 0.53, 0.6]),
        # grazing at 0.51478…, doubling at 0.52685…
        (0.7, [0.45, 0.51, 0.54, 0.8]),
    ],
)
def test_periods_and_impacts_against_the_closed_form(frequency, amplitudes):
    data = plane(oscillator(), {A: amplitudes}, {W: [frequency, frequency]}).isel(y=0)
    known = [impacts(amplitude, frequency) for amplitude in amplitudes]
    cycle = data.indicator.to_numpy()
    assert [None if np.isnan(p) else int(p) for p in cycle] == [period for period, _ in known]
    touches = data.touches.sel(touch="stops[0].upper").to_numpy() * cycle
    assert touches[np.isfinite(cycle)] == pytest.approx([n for p, n in known if p], abs=1e-12)


def test_sides_of_grazings_and_doublings():
    """At ω = 0.8: silent below A = 0.36878…; one impact above 0.51821…, two in two periods below.

    So close to a doubling the approach is slow, and the period must not be that of the other side.
    """
    doubling, grazing = 0.51820986659787257, 0.36878177829171549
    amplitudes = [0.99 * grazing, 0.99 * doubling, 1.01 * doubling]
    data = plane(oscillator(), {A: amplitudes}, {W: [0.8, 0.8]}, periods=400).isel(y=0)
    assert data.indicator.to_numpy().tolist() == [1, 2, 1]
    assert data.touches.to_numpy().ravel().tolist() == [0, 1, 1]
    assert (data.lasted < 400).all()
    near = plane(oscillator(), {A: [doubling + 1e-7, doubling - 1e-7]}, {W: [0.8, 0.8]}).isel(y=0)
    assert (near.regime == UNDECIDED).all()


def test_the_plane_agrees_with_loci_in_closed_form():
    """Beside the line on which the motion with one impact in a period doubles its period."""
    frequencies = np.linspace(0.76, 0.94, 7)
    locus = np.array([*map(doubling, frequencies)])
    assert doubling(0.8) == pytest.approx(0.51820986659787257, rel=1e-13)
    for factor, period in ((0.98, 2), (1.02, 1)):
        data = alone(oscillator(), {A: factor * locus, W: frequencies}, periods=200)
        assert (data.indicator == period).all()
        assert period == 2 or (data.touches == 1).all()  # the cycle of two may graze


def test_both_motions_that_coexist_are_found():
    """At ω = 1.2 a knocking motion begins at A = 0.15168… and a silent one ends at 0.45607…."""
    amplitudes = {A: [0.1, 0.2, 0.3, 0.4, 0.5]}
    for start, knocking in (("forward", [0, 0, 0, 0, 1]), ("backward", [0, 1, 1, 1, 1])):
        data = plane(oscillator(), amplitudes, {W: [1.2, 1.2]}, start=start, periods=200)
        assert (data.indicator == 1).all()
        assert data.touches[0, :, 0].to_numpy().tolist() == knocking
        assert data.attrs["start"] == start


LINEAR = """\
gravity: [0, 0]
parameters: {c: 0.1}
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, angle: 0, mass: 1}}
springs: [{slider: block, stiffness: 1, position: 0, damping: "c"}]
loads: [{slider: block, force: "cos(2*t)"}]
free: {block: {position: 1, speed: 0}}
"""


def test_a_slow_approach_from_alternating_sides_is_no_double_period():
    """Driven at twice its own frequency a linear oscillator has both multipliers near −e^{−πc/2}.

    With damping there is one motion of one period; two periods later it seems to repeat. Without,
    every other motion has two periods.
    """
    damping = [0.0, 1e-4, 1e-3, 5e-3, 0.06, 0.2]
    data = alone(linkages.loads(LINEAR), {"parameters.c": damping}, periods=100)
    assert data.regime.to_numpy().tolist() == [PERIODIC, *[UNDECIDED] * 3, PERIODIC, PERIODIC]
    assert data.indicator[[0, 4, 5]].to_numpy().tolist() == [2, 1, 1]
    multipliers = np.exp(-np.pi * np.array(damping[4:]) / 2)
    assert data.contraction[4:].to_numpy() == pytest.approx(multipliers, rel=0.1)


DRIVEN = """\
name: Driven pendulum
gravity: [0, -1]
parameters: {g: 1.15}
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}]
loads: [{bar: arm, torque: "g*cos(2*t/3)"}]
free: {arm: {angle: -1.2, speed: 0}}
"""


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-10])
def test_a_pendulum_doubles_its_period_and_becomes_chaotic(rtol):
    """The first doubling is at g = 1.06637286… (30-digit Taylor series); g = 1.15 is chaotic."""
    values = {"parameters.g": [1.06, 1.072, 1.15]}
    data = alone(linkages.loads(DRIVEN), values, periods=200, rtol=rtol)
    assert data.regime.to_numpy().tolist() == [PERIODIC, PERIODIC, CHAOTIC]
    assert data.indicator[:2].to_numpy().tolist() == [1, 2]
    assert data.rotation_number[:2].to_numpy().ravel().tolist() == [0, 0]


def test_the_rotation_number_is_that_of_a_locked_turn():
    """θ″ + 0.9 θ′ = 0.3 + 0.1 cos t turns by 0.3/0.9 · 2π, a third of a turn, in a period of 2π."""
    text = DRIVEN.replace("[0, -1]", "[0, 0]").replace("damping: 0.5", "damping: 0.9")
    text = text.replace("g*cos(2*t/3)", "0.3 + 0.1*cos(t)")
    data = alone(linkages.loads(text), {"dampers[0].damping": [0.9, 0.3]})
    assert data.indicator.to_numpy().tolist() == [3, 1]
    assert data.rotation_number[:, 0].to_numpy() == pytest.approx([1 / 3, 1.0], abs=1e-12)


def test_the_cascade_of_the_contact_slider_crank():
    """Doublings at 0.11931518 and 0.11871144 mm (docs/contact_published.md), and 0.11861602 mm."""
    sizes = ["0.11865 mm", "0.1190 mm", "0.1195 mm", "0.1200 mm"]
    data = plane(
        ROUTE, {"clearances.gap.size": sizes}, {"drives.crank.speed": ["5000 rpm", "5000 rpm"]},
        start="backward", skip=300, rtol=1e-9,
    )  # fmt: skip
    assert data.indicator[0].to_numpy().tolist() == [4, 2, 1, 1]
    assert (data.touches == 0).all()  # the journal never leaves the wall


AXES = {A: np.linspace(0.1, 0.6, 14)}, {W: np.linspace(0.7, 1.0, 11)}


def test_nothing_depends_on_who_computes_what(tmp_path):
    """Workers, chunks, stores, and what a store had before."""
    whole = plane(oscillator(), *AXES, executor=Threads(1))
    assert whole.identical(plane(oscillator(), *AXES, executor=Threads(3)))
    store = tmp_path / "plane"
    assert whole.identical(plane(oscillator(), *AXES, store=store))
    assert status(store)["finished"]
    next(iter((store / "chunks").iterdir())).unlink()
    assert whole.identical(plane(oscillator(), *AXES, store=store))
    row = plane(oscillator(), AXES[0], {W: AXES[1][W][3:5]})
    assert row.drop_vars(W).identical(whole.isel(y=slice(3, 5)).drop_vars(W))


def test_a_refined_plane_equals_the_whole_one(tmp_path):
    """Where it was computed in all bits, elsewhere in what makes neighbours differ."""
    whole, store = plane(oscillator(), *AXES), tmp_path / "plane"
    data = plane(oscillator(), *AXES, refine=4, store=store)
    filled = data.filled.to_numpy() > 0
    assert 0 < filled.sum() < filled.size
    for name in ("indicator", "regime", "touches", "lasted", "contraction", "outcome"):
        ours, theirs = (each[name].to_numpy()[~filled] for each in (data, whole))
        assert np.array_equal(ours, theirs, equal_nan=True)
    assert (data.lasted.to_numpy()[filled] == 0).all()
    right = data.regime.to_numpy()[filled] == whole.regime.to_numpy()[filled]
    assert right.mean() > 0.9
    rounds = sorted(store.iterdir())
    for chunk in (rounds[1] / "chunks").iterdir():
        chunk.unlink()
    assert data.identical(plane(oscillator(), *AXES, refine=4, store=store))


def test_neighbours_do_not_depend_on_workers_or_stores(tmp_path):
    axes, given = [{p: v[::3] for p, v in axis.items()} for axis in AXES], {"start": "forward"}
    whole = plane(oscillator(), *axes, executor=Threads(1), **given)
    assert whole.identical(plane(oscillator(), *axes, executor=Threads(3), **given))
    store = tmp_path / "plane"
    assert whole.identical(plane(oscillator(), *axes, store=store, **given))
    sorted((store / "chunks").iterdir())[-1].unlink()
    assert whole.identical(plane(oscillator(), *axes, store=store, **given))


def test_failed_points_have_their_reason():
    data = plane(oscillator(), {A: [0.3, 0.4]}, {"sliders.block.mass": [-1.0, 1.0]})
    assert (data.regime[0] == 0).all()
    assert (data.outcome[0] != 0).all()
    assert "mass" in data.reason[0, 0].item()
    assert (data.regime[1] == PERIODIC).all()
    data = plane(oscillator(), {A: [0.3, 0.4]}, {W: [0.8, 0.9]}, max_steps=50)
    assert (data.regime == 0).all()
    assert "max_steps" in data.reason[0, 0].item()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"refine": 3}, "power of two, found 3"),
        ({"refine": 4, "start": "forward"}, "goes with start = 'same'"),
        ({"periods": 8}, "needs at least 12 periods, found 8"),
        ({"indicator": "fli", "start": "forward"}, "goes with the indicator 'period'"),
        ({"indicator": "fli", "refine": 2}, "goes with the indicator 'period'"),
    ],
)
def test_options_that_make_no_sense(options, message):
    with pytest.raises(OptionError, match=message):
        linkages.chaos_map(
            oscillator(), {A: [0.3, 0.4]}, {W: [0.8, 0.9]}, **{"indicator": "period", **options}
        )


def test_without_a_period_of_the_drives_there_is_no_plane():
    text = OSCILLATOR.replace("A*cos(w*t)", "A")
    with pytest.raises(ValueError, match="nothing depends on time"):
        plane(linkages.loads(text), {A: [0.3, 0.4]}, {"sliders.block.mass": [1.0, 2.0]})


def test_chaos_may_be_a_long_transient():
    """Just below grazing the silent motion attracts all others, some after 100 periods of chaos."""
    amplitude = 0.999 * 0.36878177829171549
    found = [
        plane(oscillator(), {A: [amplitude] * 2}, {W: [0.8, 0.8]}, periods=periods).isel(x=0, y=0)
        for periods in (100, 1000)
    ]
    assert [each.regime for each in found] == [CHAOTIC, PERIODIC]
    assert found[1].touches == 0
