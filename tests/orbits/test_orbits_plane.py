"""Orbits of the points of a plane of periods, against closed forms and `linkages.orbit`."""

import numpy as np
import pytest

import linkages
from linkages.options.analysis_options import OrbitOptions
from linkages.options.option import OptionError
from linkages.orbits.plane_orbits import plane_orbits
from linkages.solution.run_options import options_of
from linkages.sweeps.axes import axis_of
from linkages.sweeps.running import Threads

A, W, C = "parameters.A", "parameters.w", 0.1
SLIDER_CRANK = {"clearances.gap.size": [1.1845e-4, 1.2e-4]}, {"drives.crank.speed": [523.0, 523.6]}


def orbits(mechanism, x, y, workers=None, **options):
    data = linkages.chaos_map(mechanism, x, y, indicator="period", states=True, **options)
    run = options_of(OrbitOptions, mechanism, {})
    return data, plane_orbits(mechanism, axis_of(x), axis_of(y), data, run, Threads(workers))


def spectrum(data, y, x):
    return data.multiplier[y, x].to_numpy() @ [1, 1j]


def test_orbits_without_impacts_are_the_closed_form():
    """x = Re(A exp(iwt)/(1 − w² + icw)); multipliers exp(λT), λ the roots of λ² + cλ + 1."""
    mechanism = linkages.load("impact-oscillator")
    amplitudes, frequencies = [0.1, 0.2], [0.6, 0.7, 1.3]
    settled, data = orbits(mechanism, {A: amplitudes}, {W: frequencies})
    assert data.entry.to_numpy().tolist() == ["mass.position", "mass.velocity"]
    for row, w in enumerate(frequencies):
        known = np.exp(np.roots([1.0, C, 1.0]) * 2 * np.pi / w)
        for column, a in enumerate(amplitudes):
            swing = a / (1 - w**2 + 1j * C * w)
            exact = [swing.real, (1j * w * swing).real]
            # the file's rtol is 1e-10; a settled motion is a little beside the orbit
            np.testing.assert_allclose(data.state[row, column], exact, rtol=0, atol=1e-9)
            assert np.abs(settled.state[row, column] - exact).max() < 1e-4
            found = sorted(spectrum(data, row, column), key=np.imag)
            assert found == pytest.approx(sorted(known, key=np.imag), abs=1e-8)
            assert data.drive_period[row, column] == pytest.approx(2 * np.pi / w, rel=1e-14)


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [
        ("impact-oscillator", {A: [0.45, 0.9]}, {W: [0.8, 1.1]}),  # with impacts, periods 2 and 1
        ("contact-slider-crank", *SLIDER_CRANK),
    ],
)
def test_multipliers_are_those_of_orbit(name, x, y):
    mechanism = linkages.load(name)
    _, data = orbits(mechanism, x, y)
    ((across, xs),), ((up, ys),) = x.items(), y.items()
    compared = 0
    for row, b in enumerate(ys):
        for column, a in enumerate(xs):
            if np.isnan(data.indicator[row, column]):
                assert np.isnan(spectrum(data, row, column)).all()
                continue
            state = dict(zip(data.entry.values, data.state[row, column].values, strict=True))
            periods = int(data.indicator[row, column])
            other = linkages.orbit(
                linkages.load(name, set={across: a, up: b}), state=state, periods=periods, skip=0
            )
            known = other.multiplier.to_numpy() @ [1, 1j]
            own = spectrum(data, row, column)
            assert np.abs(own[:, None] - known).min(axis=1).max() < 1e-6
            assert (np.diff(np.abs(own)) <= 0).all()
            compared += 1
    assert compared >= 2


def test_settled_states_change_nothing_else_and_do_not_depend_on_workers():
    mechanism, axes = linkages.load("impact-oscillator"), ({A: [0.3, 0.5]}, {W: [0.7, 0.8]})
    for start in ("same", "backward"):
        settled, one = orbits(mechanism, *axes, 1, start=start)
        _, two = orbits(mechanism, *axes, 2, start=start)
        assert one.identical(two)
        plain = linkages.chaos_map(mechanism, *axes, indicator="period", start=start)
        assert settled.drop_vars("state").identical(plain)


@pytest.mark.parametrize("options", [{"indicator": "fli"}, {"indicator": "period", "refine": 2}])
def test_states_are_kept_of_whole_planes_of_periods_only(options):
    mechanism = linkages.load("impact-oscillator")
    with pytest.raises(OptionError, match="states are kept of the indicator 'period'"):
        linkages.chaos_map(mechanism, {A: [0.3, 0.5]}, {W: [0.7, 0.8]}, states=True, **options)
