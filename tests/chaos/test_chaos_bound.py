"""Sweeps bind numbers: their results are those of mechanisms that are read and built one by one."""

import numpy as np
import pytest
import xarray as xr

import linkages
from linkages.kernel.varying import Varying
from linkages.sweeps.running import Threads

GAP = {"clearances": {"gap": {"joint": "B", "bar": "rod", "size": "0.1 mm"}}}
SIZES = {"clearances.gap.size": [1e-4, 2e-4, 4e-4]}
SPEEDS = {"drives.crank.speed": [20.0, 30.0]}
RUN = {"periods": 4, "rtol": 1e-7}


@pytest.fixture(scope="module")
def loose():
    """A slider-crank with a clearance."""
    return linkages.load("slider-crank", set=GAP)


@pytest.fixture(scope="module")
def pendulum():
    damper = {"dampers": [{"joint": "P", "damping": 0.1}]}
    return linkages.load("double-pendulum", set=damper)


def one_by_one(monkeypatch):
    """Read and build every mechanism from the start."""
    monkeypatch.setattr(Varying, "at", Varying.built)
    monkeypatch.setattr(Varying, "mechanism_at", lambda self, o: self.mechanism.with_values(o))


@pytest.mark.slow_except("fli")
@pytest.mark.parametrize("indicator", ["exponent", "fli", "gali"])
def test_a_map_is_that_of_mechanisms_built_one_by_one(loose, indicator, monkeypatch):
    run = {**RUN, "indicator": indicator}
    bound = linkages.chaos_map(loose, SIZES, SPEEDS, **run, executor=Threads(2))
    one_by_one(monkeypatch)
    xr.testing.assert_identical(bound, linkages.chaos_map(loose, SIZES, SPEEDS, **run))
    assert not any(bound["reason"].to_numpy().ravel())


@pytest.mark.slow
def test_a_map_through_another_structure(pendulum, monkeypatch):
    """Undamped within a range of dampings, and a mechanism that is refused beside others."""
    x = {"dampers[0].damping": [0.05, 0.0, 0.1, -1.0]}
    y = {"free.lower.angle": [0.3, 0.4]}
    bound = linkages.chaos_map(pendulum, x, y, **RUN)
    one_by_one(monkeypatch)
    xr.testing.assert_identical(bound, linkages.chaos_map(pendulum, x, y, **RUN))
    reasons = bound["reason"].to_numpy()
    assert [bool(reason) for reason in reasons[0]] == [False, False, False, True]
    assert "damping" in reasons[0, 3]


@pytest.mark.slow_except("None-*")
@pytest.mark.parametrize("start", ["same", "forward"])
@pytest.mark.parametrize("section", [None, "piston.velocity=0"])
def test_a_diagram_is_that_of_mechanisms_built_one_by_one(loose, start, section, monkeypatch):
    run = {"periods": 3, "skip": 1, "start": start, "section": section}
    run["initial"] = [{}, {"clearances.gap.angle": 1.0}]
    bound = linkages.bifurcation(loose, SIZES, **run)
    one_by_one(monkeypatch)
    xr.testing.assert_identical(bound, linkages.bifurcation(loose, SIZES, **run))


def test_values_of_a_diagram_are_sections_of_their_own(loose):
    found = linkages.bifurcation(loose, SIZES, periods=3, skip=1)
    for column, size in enumerate(SIZES["clearances.gap.size"]):
        alone = linkages.poincare(
            loose.with_values({"clearances.gap.size": size}), periods=3, skip=1
        )
        for name in ("clearance_angle", "clearance_speed"):
            assert (found[name].to_numpy()[0, column] == alone[name].to_numpy()).all()


def test_points_depend_on_their_numbers_alone(loose):
    """Not on the order, the other points, the number of workers or what is swept."""
    whole = linkages.chaos_map(loose, SIZES, SPEEDS, **RUN, executor=Threads(1))
    turned = {path: values[::-1] for path, values in SIZES.items()}
    other = linkages.chaos_map(
        loose.with_values({"clearances.gap.size": 3e-4, "drives.crank.speed": 25.0}),
        turned, SPEEDS, **RUN, executor=Threads(3),
    )  # fmt: skip
    for name in ("indicator", "error", "contact_lost", "least_force"):
        assert (whole[name].to_numpy() == other[name].to_numpy()[:, ::-1]).all()
    part = linkages.chaos_map(
        loose, {"clearances.gap.size": [4e-4, 1e-4]}, {"drives.crank.speed": [30.0, 20.0]}, **RUN
    )
    expected = whole["indicator"].to_numpy()[::-1][:, [2, 0]]
    assert (part["indicator"].to_numpy() == expected).all()
    assert np.isfinite(expected).all()
