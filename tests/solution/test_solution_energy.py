"""Energy balances, closure, and efforts against each other."""

import numpy as np
import pytest
from solution_mechanisms import FOUR_BAR, SLIDER_CRANK, derivative, mechanism

import linkages
from linkages.reading.document import shipped

ENERGIES = ["kinetic_energy", "potential_energy", "drive_power", "energy_residual"]


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return", "class-three")
@pytest.mark.parametrize("name", shipped())
def test_closure_is_kept_to_round_off(name):
    """The project's promise; positions are closed forms, so nothing can drift."""
    data = linkages.simulate(linkages.load(name), outputs=["closure_residual"]).data
    assert float(data.closure_residual.max()) <= 1e-13


@pytest.mark.parametrize("text", [FOUR_BAR, SLIDER_CRANK], ids=["four-bar", "slider-crank"])
@pytest.mark.parametrize("samples", [2, 11, 1001])
def test_driven_motion_balances_to_round_off(text, samples):
    """Work by Gauss quadrature, however few samples there are: a few roundings per turn."""
    data = linkages.simulate(mechanism(text), end=2.0, samples=samples, outputs="all").data
    scale = float(data.kinetic_energy.max()) + float(np.ptp(data.potential_energy.to_numpy()))
    scale += 200 * 0.08 * 16 if "piston" in text else 0.0  # work of the load, to and fro
    assert float(np.abs(data.energy_residual).max()) < 1e-12 * scale


@pytest.mark.parametrize("text", [FOUR_BAR, SLIDER_CRANK], ids=["four-bar", "slider-crank"])
def test_efforts_are_the_derivative_of_energy(text):
    """d(T + V)/dt = P_drive + P_load, the left side by differences of order 8."""
    spacing = 2e-3 if text is FOUR_BAR else 2e-4
    data = linkages.simulate(
        mechanism(text), end=400 * spacing, samples=401, outputs=[*ENERGIES, "load_power"]
    ).data
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    power = (data.drive_power + data.load_power).to_numpy()[4:-4]
    # (ω·spacing)⁸/630 of the fastest harmonics that matter is below 1e-9; round-off of the
    # energy over the spacing is below that.
    assert np.abs(derivative(energy, spacing) - power).max() < 1e-8 * np.abs(power).max()


def test_drive_power_is_effort_times_speed():
    data = linkages.simulate(linkages.load("ninebar-ideal"), outputs="all").data
    efforts = data.drive_effort.to_numpy()
    speeds = [-np.pi, np.pi]
    assert np.allclose(efforts @ speeds, data.drive_power, rtol=1e-13, atol=1e-12)


def residual(rtol, end=0.5):
    data = linkages.simulate(
        linkages.load("ninebar"), end=end, samples=51, rtol=rtol, outputs=["energy_residual"]
    ).data
    return float(np.abs(data.energy_residual).max())


@pytest.mark.slow
def test_nine_bar_balances_at_tolerance_level():
    """Work is integrated along with the motion; only the energy of the swing, ½ M r² α̇² of some
    mJ, feels the error of the integration: 2000 steps of 1e-8 leave 1e-9 J.
    """
    coarse, middle, fine = (residual(rtol) for rtol in (1e-8, 1e-10, 1e-12))
    assert coarse < 1e-8
    assert middle < coarse / 20
    assert fine < middle / 20


def test_nine_bar_integrated_work_matches_its_efforts():
    """Power from integrated work, differentiated, against power from efforts at the samples."""
    spacing = 1e-5
    solution = linkages.simulate(
        linkages.load("ninebar"), end=100 * spacing, samples=101, rtol=1e-13, outputs=ENERGIES
    )
    assert solution.motion.work is not None
    power = solution.data.drive_power.to_numpy()[4:-4]
    # Work is known to some 1e-15 J; divided by the spacing that is 1e-9 W.
    assert np.abs(derivative(solution.motion.work, spacing) - power).max() < 1e-7


@pytest.mark.parametrize(
    ("order", "values", "rates"),
    [
        (1, "joint_position", "joint_velocity"),
        (1, "joint_velocity", "joint_acceleration"),
        (2, "joint_position", "joint_acceleration"),
        (1, "bar_angle", "bar_speed"),
        (1, "bar_speed", "bar_acceleration"),
        (1, "slider_position", "slider_velocity"),
        (1, "slider_velocity", "slider_acceleration"),
    ],
)
def test_rates_are_derivatives(order, values, rates):
    spacing = 2e-3
    data = linkages.simulate(linkages.load("ninebar-ideal"), end=2.0, samples=1001).data
    found = derivative(data[values].to_numpy(), spacing, order)
    wanted = data[rates].to_numpy()[4:-4]
    # Differences of order 8, harmonics up to some 40 rad/s; round-off of 1e-16 over spacing².
    assert np.abs(found - wanted).max() < 1e-7 * max(1.0, np.abs(wanted).max())


def test_rates_of_the_clearance_are_derivatives():
    spacing = 1e-5
    data = linkages.simulate(
        linkages.load("ninebar"), end=2e-3, samples=201, method="dop853", rtol=1e-13
    ).data
    for values, rates in (
        ("clearance_angle", "clearance_speed"),
        ("clearance_speed", "clearance_acceleration"),
        ("slider_velocity", "slider_acceleration"),
    ):
        found = derivative(data[values].to_numpy(), spacing)
        wanted = data[rates].to_numpy()[4:-4]
        # The dense output is of order 7 within steps of some 2e-4 s: it joins up to 1e-8.
        assert np.abs(found - wanted).max() < 1e-6 * np.abs(wanted).max()
