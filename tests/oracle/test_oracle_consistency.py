"""The absolute formulation of random mechanisms against laws of mechanics; no kernel runs here."""

import numpy as np
import pytest
from absolute_bodies import State
from absolute_coordinates import AbsoluteModel
from absolute_forces import heavy_points, inertia, kinetic_energy, loads, weight
from absolute_measures import angles
from absolute_outputs import ground_force, outputs
from changed_definitions import renamed, scaled
from hypothesis import given, settings
from random_mechanisms import mechanisms, seeded

SEEDS = range(40)
DIFFERENCES = np.array([-1 / 60, 3 / 20, -3 / 4, 0, 3 / 4, -3 / 20, 1 / 60])
SECOND_DIFFERENCES = np.array([1 / 90, -3 / 20, 3 / 2, -49 / 18, 3 / 2, -3 / 20, 1 / 90])
"""Order 6 (Fornberg 1988, Table 1)."""


class Started:
    """A random mechanism at t = 0, and on the parabola that has its rates and accelerations."""

    def __init__(self, grown):
        self.grown = grown
        self.model = AbsoluteModel(grown.mechanism)
        self.mechanism = self.model.mechanism
        self.state = grown.start(self.model)
        self.solved = self.model.solve(self.state)
        fastest = np.abs(self.state.rates).max() + np.sqrt(np.abs(self.solved.accelerations).max())
        self.step = 0.02 / (1 + fastest)

    def at(self, time):
        rates = self.state.rates + time * self.solved.accelerations
        places = self.state.places + time * 0.5 * (self.state.rates + rates)
        return State(self.model.layout, time, places, rates)

    def samples(self, function):
        return np.array([function(self.at(k * self.step)) for k in range(-3, 4)])


@pytest.fixture(scope="module", params=SEEDS)
def started(request):
    return Started(seeded(request.param))


@pytest.mark.slow_except("?")
def test_measures_know_their_derivatives(started):
    """All constraints at once: Φ along a parabola."""
    phi = started.samples(lambda state: np.concatenate(
        [c.measure(state).value for c in started.model.constraints]
    ))  # fmt: skip
    found = [c.measure(started.state) for c in started.model.constraints]
    rates = np.concatenate([m.jacobian @ started.state.rates for m in found])
    second = np.concatenate([m.jacobian @ started.solved.accelerations + m.bias for m in found])
    h = started.step
    # h times the rate of any angle is 0.02: truncation 0.02⁶/140, round-off 1e-15/0.02²
    assert np.abs(DIFFERENCES @ phi - h * rates).max() < 1e-10
    assert np.abs(SECOND_DIFFERENCES @ phi - h**2 * second).max() < 1e-10


def test_closure_holds_with_its_first_two_derivatives(started):
    """Φ − law along the parabola stays zero to third order, whatever the laws are."""
    assert np.abs(started.model.closure(started.state)).max() < 1e-14
    off = started.samples(started.model.closure)
    assert np.abs(DIFFERENCES @ off).max() < 1e-10
    assert np.abs(SECOND_DIFFERENCES @ off).max() < 1e-10


def test_power(started):
    """The kinetic energy grows by what gravity, loads and drives do."""
    state, mechanism = started.state, started.mechanism
    energy = started.samples(lambda at: kinetic_energy(mechanism, at))
    forces = weight(mechanism, state) + loads(mechanism, state)
    power = forces @ state.rates + sum(
        effort[0] * constraint.prescribed(state.time)[1]
        for constraint, effort in started.solved.efforts
        if constraint.kind == "drive"
    )
    gained = DIFFERENCES @ energy
    scale = energy.max() + np.abs(started.step * power)
    assert gained == pytest.approx(started.step * power, abs=1e-9 * scale)


def test_mass_matrix_gives_the_kinetic_energy(started):
    matrix, _ = inertia(started.mechanism, started.state)
    expected = 0.5 * started.state.rates @ matrix @ started.state.rates
    assert kinetic_energy(started.mechanism, started.state) == pytest.approx(expected, rel=1e-12)


def test_momentum(started):
    """The ground and the loads move the centre of mass."""
    state, mechanism = started.state, started.mechanism
    change = np.zeros(2)
    for point, mass in heavy_points(mechanism, state.layout):
        acceleration = state.jacobian(point) @ started.solved.accelerations + state.bias(point)
        change += mass * acceleration
    forces = weight(mechanism, state) + loads(mechanism, state)
    outside = forces.reshape(-1, 3)[:, :2].sum(axis=0)
    found = ground_force(started.model, started.solved) + outside
    reactions = outputs(started.model, started.solved)["joint_reaction"].values()
    scale = 1 + np.abs(change).max() + max(np.abs(force).max() for force in reactions)
    assert found == pytest.approx(change, abs=1e-11 * scale)


def test_reciprocity(started):
    """Bar i answers a torque on bar j as j answers one on i (Betti); more torque, more answer."""
    model, turning = started.model, [n for n, b in started.mechanism.bodies.items() if b.rotates]
    matrix, _ = inertia(started.mechanism, started.state)
    phi = model.jacobian(started.state)
    system = np.block([[matrix, phi.T], [phi, np.zeros((len(phi), len(phi)))]])
    rows = np.array([angles(model.layout, [(n, 1.0)])(started.state).jacobian[0] for n in turning])
    torques = np.concatenate([rows.T, np.zeros((len(phi), len(turning)))])
    answers = rows @ np.linalg.solve(system, torques)[: model.layout.size]
    scale = 1e-3 + np.abs(answers).max()  # nothing answers where nothing is free
    assert np.abs(answers - answers.T).max() <= 1e-9 * scale
    assert np.linalg.eigvalsh(answers + answers.T).min() >= -1e-9 * scale


@pytest.mark.slow_except("?")
def test_names_and_units(started):
    """The changes that the kernel's tests make leave the absolute formulation's results alone."""
    new, other = renamed(started.grown, np.random.default_rng(1))
    again = Started(other).solved.accelerations.reshape(-1, 3)
    order = [list(Started(other).mechanism.bodies).index(new[n]) for n in started.mechanism.bodies]
    own = started.solved.accelerations.reshape(-1, 3)
    scale = 1 + np.abs(own).max()
    assert np.abs(again[order] - own).max() < 1e-10 * scale
    small = Started(scaled(started.grown, 1e-3, 1e2, 10.0)).solved.accelerations.reshape(-1, 3)
    assert np.abs(small * 1e2 * [1e3, 1e3, 1] - own).max() < 1e-10 * scale


@pytest.mark.slow
@settings(max_examples=25)
@given(mechanisms())
def test_drawn_mechanisms_can_be_assembled(grown):
    """Hints and all: places by the generator and by Newton's method agree."""
    model = AbsoluteModel(grown.mechanism)
    state = grown.start(model)
    assert np.abs(model.closure(state)).max() < 1e-14
    for joint, place in grown.places.items():
        found = complex(*state.place(model.layout.points[joint][0]))
        assert abs(found - place) < 1e-13
