"""Sizes, speeds and masses over many decades."""

import math

import numpy as np
import pytest
from stress_mechanisms import CLOSURE, HELD, double_pendulum, moved_energy, nine_bar

import linkages

OUTPUTS = [
    "clearance_angle",
    "clearance_speed",
    "clearance_acceleration",
    "clearance_force",
    "kinetic_energy",
    "potential_energy",
    "energy_residual",
    "closure_residual",
    "slider_velocity",
    "slider_acceleration",
]
SIZES = [10.0**k for k in range(-9, -1)]


def period(data):
    """Time from one turning point of the clearance to the next but one, on average."""
    time, speed = data.time.to_numpy(), data.clearance_speed.to_numpy()[:, 0]
    before = np.flatnonzero(np.diff(np.sign(speed)) != 0)
    before = before[before > 0]
    share = speed[before] / (speed[before] - speed[before + 1])
    turning = time[before] + share * np.diff(time)[before]
    return 2 * (turning[-1] - turning[0]) / (len(turning) - 1)


def test_swing_frequency_goes_with_the_root_of_the_size():
    """A swing on a link of length r under an acceleration that does not depend on r: ω² = g/r.

    Drives are held, so that nothing else changes in time. The mechanism's own positions change
    by r, so that the law holds up to terms of the order r/1 m.
    """
    found = []
    for size in SIZES:
        swings = 20.2 / 400 * math.sqrt(size / 1e-5)
        data = linkages.simulate(
            linkages.load("ninebar", set={**HELD, "clearances.r1.size": size}),
            end=swings,
            samples=4001,
            outputs=OUTPUTS,
            method="vern9",
        ).data
        assert float(data.closure_residual.max()) <= CLOSURE
        # round-off of 163 J of weight, and 1e-10 of what moves per step over some hundred steps
        assert float(np.abs(data.energy_residual).max()) < 5e-13 + 1e-7 * moved_energy(data)
        found.append(1 / period(data))
    slopes = np.diff(np.log10(found))
    assert slopes[:4] == pytest.approx(-0.5, abs=1e-5)
    assert slopes == pytest.approx(-0.5, abs=2e-2)


@pytest.mark.parametrize("size", SIZES)
def test_driven_press_with_a_clearance_of_any_size(size):
    """From 1 nm to 10 mm: positions close, energy balances, the force stays that of the press."""
    end = min(0.05, 40 * math.sqrt(size / 9.81))
    mechanism = nine_bar(clearances__r1__size=size)
    solution = linkages.simulate(mechanism, end=end, samples=201, outputs=OUTPUTS)
    data = solution.data
    assert float(data.closure_residual.max()) <= CLOSURE
    # round-off of 160 J of weight, then 1e-10 of the energy of the swing (160 N · size) per step,
    # of either sign
    steps = math.sqrt(solution.motion.cost["steps"])
    assert float(np.abs(data.energy_residual).max()) < 1e-12 + 1e-10 * steps * 160 * size
    # α̈ grows as 1/r, the force along the link does not: weights and what the drives accelerate
    assert 1 < float(np.abs(data.clearance_force).max()) < 300


@pytest.mark.parametrize("speed", [0.001, 0.1, 1.0, 10.0, 50.0])
def test_drives_from_standstill_to_fifty_times_the_speed(speed):
    """From 0.001π to 50π rad/s; the press without clearance shows how fast the rest moves."""
    assignments = {"drives.crank1.speed": -speed * math.pi, "drives.crank4.speed": speed * math.pi}
    end = min(0.25, 2.0 / speed)
    data = linkages.simulate(
        linkages.load("ninebar", set=assignments), end=end, samples=501, outputs=OUTPUTS
    ).data
    assert float(data.closure_residual.max()) <= CLOSURE
    # What is moved grows with speed²; 1e-10 per step of it over at most 1e4 steps.
    assert float(np.abs(data.energy_residual).max()) < 1e-12 + 1e-9 * moved_energy(data)
    # Velocities of the ideal press are in proportion to the drives, accelerations to their square.
    ideal = [
        linkages.simulate(
            linkages.load("ninebar-ideal", set=given), end=0.5 / factor, samples=51
        ).data
        for given, factor in (({}, 1.0), (assignments, speed))
    ]
    for name, power in (("slider_velocity", 1), ("slider_acceleration", 2)):
        slow, fast = (part[name].to_numpy() for part in ideal)
        scale = np.abs(slow).max() * speed**power
        assert np.abs(fast - slow * speed**power).max() < 1e-12 * scale


def masses_times(factor):
    """Assignments that multiply every mass and inertia of the nine-bar."""
    bodies = linkages.load("ninebar").bodies.values()
    return {
        ".".join([*body.path, key]): value.value * factor
        for body in bodies
        for key, value in (("mass", body.mass), ("inertia", body.inertia))
        if not value.absent
    }


@pytest.mark.parametrize("factor", [2.0**-20, 2.0**20], ids=["2^-20", "2^20"])
def test_motion_does_not_depend_on_the_unit_of_mass(factor):
    """All masses times 2^±20 (1e6): a power of two passes through every formula without rounding,
    so that the motion is the same to the last bit and forces are multiplied exactly.
    """
    names = ["clearance_angle", "clearance_speed", "clearance_force", "slider_velocity"]
    plain, scaled = (
        linkages.simulate(
            linkages.load("ninebar", set=given), end=0.1, samples=51, outputs=names
        ).data
        for given in ({}, masses_times(factor))
    )
    for name in names:
        times = factor if name == "clearance_force" else 1.0
        assert np.array_equal(scaled[name], plain[name] * times), name


@pytest.mark.parametrize("body", ["bars.link3", "bars.rocker6", "sliders.slider9"])
@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1e3, 1e6])
def test_one_body_a_million_times_lighter_or_heavier(body, ratio):
    section, name = body.split(".")
    mass = linkages.load("ninebar").bodies[name].mass.value * ratio
    given = {f"{body}.mass": mass}
    if section == "bars":
        given[f"{body}.inertia"] = mass * 0.85**2 / 12
    solution = linkages.simulate(
        linkages.load("ninebar", set=given), end=0.02, samples=101, outputs=OUTPUTS
    )
    data = solution.data
    assert float(data.closure_residual.max()) <= CLOSURE
    # Weights of up to 1e6 kg: a rounding of their potential energy, then 1e-10 per step.
    scale = float(np.abs(data.potential_energy).max()) + moved_energy(data)
    assert float(np.abs(data.energy_residual).max()) < 1e-10 * scale


@pytest.mark.parametrize("ratio", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_double_pendulum_of_unequal_masses(ratio):
    data = linkages.simulate(
        double_pendulum(masses=(1.0, ratio)), end=5.0, samples=101, outputs="all"
    ).data
    # A light lower mass is thrown about by the upper one, a heavy one whips the upper one about:
    # 1e-10 per step of what moves.
    assert float(np.abs(data.energy_residual).max()) < 1e-7 * moved_energy(data)
    assert np.isfinite(data.bar_acceleration).all()


def test_pendulum_with_a_light_bob_does_not_feel_it():
    """In the limit of a weightless lower mass, the upper one is a simple pendulum of 1 m."""
    upper = {
        ratio: linkages.simulate(double_pendulum(masses=(1.0, ratio)), end=5.0, samples=51).data
        for ratio in (1e-6, 1e-9)
    }
    angles = [data.bar_angle.sel(bar="upper").to_numpy() for data in upper.values()]
    # The difference is of the order of the larger mass ratio, times some ten for five seconds.
    assert np.abs(angles[0] - angles[1]).max() < 1e-4
