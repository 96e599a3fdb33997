"""Random mechanisms: the program under test against the absolute formulation."""

import math

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_forces import kinetic_energy
from absolute_outputs import outputs
from changed_definitions import renamed, scaled
from hypothesis import given, settings
from kernel_values import at_sample, at_start, configuration, disagreements, state_at
from random_mechanisms import mechanisms, seeded

import linkages

TOLERANCE = 1e-11
"""In parts of the largest value of a variable, or of 1. Positions are right to 1e-16; both ways
then solve systems whose condition numbers are at most some 1e3 for the closure (the generator keeps
away from singular positions) and 1e2 for the inertia of free coordinates, each scaled. Of 400
mechanisms, none differs by more than 5e-13."""
CLOSURE = 1e-13
"""The promise of the project, in metres: how far bodies are from where closure holds exactly."""
RUN = {"end": 0.02, "samples": 3, "rtol": 1e-11, "throw": False}
QUICK, MANY = range(100), range(100, 400)


def check_start(grown):
    model = AbsoluteModel(grown.mechanism)
    expected = outputs(model, model.solve(grown.start(model)))
    off = disagreements(at_start(grown.mechanism), expected, TOLERANCE)
    assert not off, grown


@pytest.mark.slow_except("?", "1?", "2?")
@pytest.mark.parametrize("seed", QUICK)
def test_at_the_start(seed):
    """Positions, velocities, accelerations, efforts; nothing is compiled."""
    check_start(seeded(seed, most=4))


@pytest.mark.slow
@pytest.mark.parametrize("seed", MANY)
def test_large_mechanisms_at_the_start(seed):
    check_start(seeded(seed, most=9, clearances=0.25))


@pytest.mark.slow
@settings(max_examples=40)
@given(mechanisms())
def test_drawn_mechanisms_at_the_start(grown):
    """The same for round numbers, where terms vanish; a failure shrinks to a small mechanism."""
    check_start(grown)


def check_run(grown):
    """All samples of a short motion; it may end early where the mechanism becomes singular."""
    model = AbsoluteModel(grown.mechanism)
    names = [*outputs(model, model.solve(grown.start(model))), "kinetic_energy", "energy_residual"]
    data = linkages.simulate(grown.mechanism, outputs=names, **RUN).data
    moved = 1e-3  # joules; most mechanisms have thousands of times as much
    for sample, time in enumerate(data.time.to_numpy()):
        found = at_sample(data, sample)
        state = state_at(model, found, float(time))
        assert np.abs(state.places - configuration(model, found)).max() <= CLOSURE
        off = disagreements(found, outputs(model, model.solve(state)), TOLERANCE)
        assert not off, (time, off, grown)
        energy = kinetic_energy(model.mechanism, state)
        assert float(data.kinetic_energy[sample]) == pytest.approx(energy, rel=TOLERANCE)
        moved = max(moved, energy)
    assert float(np.abs(data.energy_residual).max()) < 1e-8 * moved


@pytest.mark.slow_except("0", "3")
@pytest.mark.parametrize("seed", range(4))
def test_motion(seed):
    check_run(seeded(seed, most=3))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4, 64))
def test_motions(seed):
    check_run(seeded(seed, most=6))


@pytest.mark.slow_except("2?")
@pytest.mark.parametrize("seed", range(20, 50))
def test_names_and_order_change_nothing(seed):
    grown = seeded(seed, most=4)
    new, other = renamed(grown, np.random.default_rng(seed))
    first, second = at_start(grown.mechanism), at_start(other.mechanism)
    moved = {
        name: {new[label]: value for label, value in values.items()}
        for name, values in first.items()
    }
    assert not disagreements(second, moved, TOLERANCE)


DIMENSIONS = {  # length, mass, time
    "angle": (0, 0, 0), "speed": (0, 0, -1), "position": (1, 0, 0), "velocity": (1, 0, -1),
    "reaction": (1, 1, -2), "effort": (2, 1, -2), "force": (1, 1, -2),
}  # fmt: skip


def dimension(name, label, mechanism):
    """Exponents of an output; those of accelerations and efforts depend on what moves."""
    kind, _, suffix = name.partition("_")
    if suffix == "acceleration":
        return (0, 0, -2) if kind in ("bar", "clearance") else (1, 0, -2)
    if suffix == "effort" and not mechanism.bodies[label].rotates:
        return (1, 1, -2)
    return DIMENSIONS[suffix]


@pytest.mark.slow_except("50-*", "51-*", "52-*")
@pytest.mark.parametrize("units", [(1e-3, 1e-3, 1.0), (1.0, 1.0, 1e3), (7.0, 1e4, 1e-2)], ids=str)
@pytest.mark.parametrize("seed", range(50, 60))
def test_units_scale_results(seed, units):
    """A mechanism in millimetres, grams or milliseconds moves as one in metres does."""
    grown = seeded(seed, most=4)
    other = at_start(scaled(grown, *units).mechanism)
    back = {
        name: {
            label: value / math.prod(u**n for u, n in zip(units, exponents, strict=True))
            for label, value in values.items()
            for exponents in [dimension(name, label, grown.mechanism)]
        }
        for name, values in other.items()
    }
    assert not disagreements(back, at_start(grown.mechanism), TOLERANCE)
