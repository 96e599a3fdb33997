"""Clearances at any pin, one or several, from the definition file alone."""

import numpy as np
import pytest
from solution_mechanisms import FOUR_BAR, SLIDER_CRANK, mechanism

import linkages

SIZE = 1e-4
PINS = {
    "slider-crank O": (SLIDER_CRANK, {"r": ("O", "crank")}),
    "slider-crank A": (SLIDER_CRANK, {"r": ("A", "rod")}),
    "slider-crank B": (SLIDER_CRANK, {"r": ("B", "rod")}),
    "four-bar O2": (FOUR_BAR, {"r": ("O2", "crank")}),
    "four-bar A": (FOUR_BAR, {"r": ("A", "coupler")}),
    "four-bar A crank": (FOUR_BAR, {"r": ("A", "crank")}),
    "four-bar B": (FOUR_BAR, {"r": ("B", "coupler")}),
    "four-bar O4": (FOUR_BAR, {"r": ("O4", "rocker")}),
    "four-bar A B": (FOUR_BAR, {"r": ("A", "coupler"), "s": ("B", "rocker")}),
    "slider-crank all": (SLIDER_CRANK, {"r": ("O", "crank"), "s": ("A", "rod"), "t": ("B", "rod")}),
}
SLOW = {"slider-crank all", "four-bar O4", "four-bar A crank", "slider-crank O"}


def with_clearances(text, pins):
    entries = (
        f"  {name}: {{joint: {joint}, bar: {bar}, size: {SIZE}, angle: {0.3 + i}}}"
        for i, (name, (joint, bar)) in enumerate(pins.items())
    )
    return mechanism(text, "clearances:", *entries)


@pytest.mark.parametrize(
    "case", [pytest.param(c, marks=[pytest.mark.slow] if c in SLOW else []) for c in PINS]
)
def test_clearance_at_every_pin(case):
    text, pins = PINS[case]
    solution = linkages.simulate(
        with_clearances(text, pins), end=0.05, samples=51, rtol=1e-10, outputs="all"
    )
    data = solution.data
    assert solution.system.topology.mobility == 1 + len(pins)
    assert solution.system.topology.free == tuple(pins)
    assert list(data.clearance.to_numpy()) == list(pins)
    assert float(data.closure_residual.max()) <= 1e-13
    # Work of the drive and the load makes up for every change of energy: 1e-10 of what is moved
    # per step, over some thousand steps.
    moved = float(data.kinetic_energy.max()) + 16.0 * ("piston" in text)
    assert float(np.abs(data.energy_residual).max()) < 1e-8 * moved
    for name, (joint, _) in pins.items():
        pin = data.joint_position.sel(joint=joint).to_numpy()
        end = data.joint_position.sel(joint=f"{joint}.{name}").to_numpy()
        angle = data.clearance_angle.sel(clearance=name).to_numpy()
        link = SIZE * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        assert np.allclose(end - pin, link, rtol=0, atol=1e-16)
        # The link has no mass: the force along it is all that passes through it.
        force = data.clearance_force.sel(clearance=name).to_numpy()[:, None] * link / SIZE
        through = data.joint_reaction.sel(joint=f"{joint}.{name}").to_numpy()
        scale = np.abs(force).max()
        # The transverse part is the error of an integrated acceleration.
        assert np.abs(np.abs(through) - np.abs(force)).max() < 1e-7 * scale


def test_motion_with_a_small_clearance_is_near_the_ideal_one():
    """The piston strays by no more than the clearance times how far it moves when the pin is
    displaced: 1/cos φ ≤ 1.05 for a rod of 3.5 cranks.
    """
    ideal = linkages.simulate(mechanism(SLIDER_CRANK), end=0.05, samples=51).data
    for pins in (PINS["slider-crank A"][1], PINS["slider-crank B"][1]):
        data = linkages.simulate(with_clearances(SLIDER_CRANK, pins), end=0.05, samples=51).data
        error = (data.slider_position - ideal.slider_position).to_numpy()
        assert 0.01 * SIZE < np.abs(error).max() < 1.05 * SIZE
        # what the solution itself calls the error is the same, to the last digit
        for name in ("position", "velocity", "acceleration"):
            own = data[f"slider_{name}_error"]
            wanted = data[f"slider_{name}"] - ideal[f"slider_{name}"]
            assert np.array_equal(own, wanted)


def test_slider_errors_of_the_nine_bar():
    data = linkages.simulate(linkages.load("ninebar")).data
    ideal = linkages.simulate(linkages.load("ninebar-ideal")).data
    for name in ("position", "velocity", "acceleration"):
        wanted = data[f"slider_{name}"] - ideal[f"slider_{name}"]
        assert np.array_equal(data[f"slider_{name}_error"], wanted)


def test_nine_bar_maxima_are_those_of_the_prototypes():
    """Measured with prototypes in two languages: 1.07e-4 m, 6.3e-3 m/s, 8.4 m/s², 27.7 N·m and
    24.8 N·m from α1 = −36.7°. The start is given to 0.1°: half of that changes the efforts by up
    to 0.09 N·m.
    """
    data = linkages.simulate(linkages.load("ninebar"), samples=20001).data
    found = [
        float(np.abs(data[f"slider_{name}_error"]).max())
        for name in ("position", "velocity", "acceleration")
    ]
    assert found[0] == pytest.approx(1.07e-4, abs=0.005e-4)
    assert found[1] == pytest.approx(6.3e-3, abs=0.05e-3)
    assert found[2] == pytest.approx(8.4, abs=0.1)
    efforts = np.abs(data.drive_effort).max(dim="time").to_numpy()
    assert efforts == pytest.approx([27.7, 24.8], abs=0.05 + 0.09)


def test_no_errors_without_clearances():
    assert not [n for n in linkages.simulate(mechanism(FOUR_BAR)).data if n.endswith("_error")]


def test_size_by_assignment():
    """Halving the size halves the distance, and recompiles nothing that could change."""
    for size in (1e-4, 5e-5):
        press = linkages.load("ninebar", set={"clearances.r1.size": size})
        data = linkages.simulate(press, end=0.01, samples=11).data
        gap = data.joint_position.sel(joint="C.r1") - data.joint_position.sel(joint="C")
        assert np.hypot(*gap.to_numpy().T) == pytest.approx(size, rel=1e-11)
