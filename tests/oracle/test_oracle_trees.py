"""Trees of bodies, whose equations are eliminated from the leaves: three independent roads.

The absolute formulation solves for all coordinates and reactions at once; the matrix J_ij of the
free coordinates is that of small mechanisms; chains of point masses have published frequencies.
"""

from __future__ import annotations

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_forces import kinetic_energy
from absolute_outputs import outputs
from kernel_values import at_sample, disagreements, state_at
from random_trees import tree
from scipy.special import roots_laguerre

import linkages
from linkages.kernel import system as systems
from linkages.kernel.differentiation import derivative
from linkages.kernel.lru_cache import LRUCache
from linkages.kernel.model import Model
from linkages.kernel.system import System
from linkages.solution import plan
from linkages.solution.joint_reactions import _solved, statics_of
from linkages.solution.plan import kernel_source
from linkages.topology import topology as topologies

TOLERANCE = 1e-10
"""In parts of the largest value: condition numbers of inertias of such chains are some 1e4."""


def model(system, monkeypatch, few):
    """Equations of their own, eliminated as a whole up to so many free coordinates."""
    monkeypatch.setattr(topologies, "FEW", few)
    made = Model(system.topology)
    assert (made.tree is None) == (few > 100)
    return made


def values(system, own, nodes, held):
    coordinates = len(system.topology.coordinates)
    inputs = {
        "t": np.array([0.3]),
        "y": system.state[:, None],
        "a": np.zeros((coordinates, 1)),
        "p": system.parameters[:, None],
        "mode": held[:, None],
        "memory": np.zeros((0, 1)),
    }
    return np.ravel(np.broadcast_arrays(*own.evaluator(nodes)(**inputs)))


@pytest.mark.parametrize("rows", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_trees_move_as_by_the_whole_matrix(seed, rows, monkeypatch):
    """Accelerations, efforts of drives, and derivatives by the state."""
    system = System(tree(seed, 20, rows))
    n = len(system.topology.free)
    found = []
    for few in (1, 1000):
        own = model(system, monkeypatch, few)
        accelerations = own.changes
        inputs = own.inputs
        state = [*map(inputs.coordinate, range(n)), *map(inputs.rate, range(n))]
        slopes = derivative(accelerations, state)
        efforts = own.required_forces(own.bias, own.topology.driven, own.acting)
        held = np.linspace(-1, 1, len(own.switches.switches)) if own.switches.switches else []
        nodes = [*accelerations, own.power, *efforts, *(s for row in slopes for s in row)]
        given = values(system, own, nodes, np.array(held))
        found.append(np.split(given, [n, len(nodes) - 2 * n * n]))
    for one, other in zip(*found, strict=True):
        assert np.abs(one - other).max() <= TOLERANCE * np.abs(other).max()


@pytest.mark.slow_except("0")
@pytest.mark.parametrize("seed", range(3))
def test_motions_of_trees_obey_the_absolute_formulation(seed):
    """Accelerations, reactions and efforts at all samples, and the balance of energy."""
    mechanism = tree(seed, 18)
    own = AbsoluteModel(mechanism)
    run = {"end": 0.02, "samples": 3, "rtol": 1e-11}
    data = linkages.simulate(mechanism, outputs="all", **run).data
    for sample, time in enumerate(data.time.to_numpy()):
        found = at_sample(data, sample)
        state = state_at(own, found, float(time))
        off = disagreements(found, outputs(own, own.solve(state)), TOLERANCE)
        assert not off, (time, off)
        energy = kinetic_energy(own.mechanism, state)
        assert float(data.kinetic_energy[sample]) == pytest.approx(energy, rel=TOLERANCE)
    # of some 100 J, at a tolerance of 1e-11 and with modes that change
    assert float(np.abs(data.energy_residual).max()) < 1e-7


def test_forces_along_a_tree_are_those_of_the_linear_system():
    motion = linkages.simulate(tree(5, 18), end=0.02, samples=3).motion
    statics = statics_of(motion.pieces[0])
    expected = statics.at_places(_solved(*statics.equations()))
    found = statics.reactions()
    assert np.abs(found - expected).max() <= TOLERANCE * np.abs(expected).max()


def masses_on_a_string(count, length=0.3, heavy=None):
    """Equal point masses on massless bars, all of them hanging; the last bars may have none."""
    bars = [f"  b{i}: {{joints: [J{i}, J{i + 1}], length: {length}}}" for i in range(count)]
    masses = [f"  J{i + 1}: 2" for i in range(count if heavy is None else heavy)]
    free = [f"  b{i}: {{angle: -pi/2, speed: 0}}" for i in range(count)]
    parts = ["joints: {J0: [0, 0]}", "gravity: [0, -9.81]", "bars:", *bars, "masses:", *masses]
    return linkages.loads("\n".join([*parts, "free:", *free]))


def test_frequencies_of_a_string_of_masses():
    """ω² l/g are the zeros of the Laguerre polynomial of the number of masses.

    J. L. Lagrange, Mécanique analytique, part 2, section 6: equal masses at equal distances.
    """
    count, length = 16, 0.3
    system = System(masses_on_a_string(count, length))
    own = system.model
    assert own.tree is not None
    coordinates = [own.inputs.coordinate(i) for i in range(count)]
    slopes = derivative(own.free_accelerations, coordinates)
    matrix = system.evaluate([node for row in slopes for node in row])[:, 0]
    squares = -np.linalg.eigvals(matrix.reshape(count, count)).real
    zeros, _ = roots_laguerre(count)
    # entries up to 1e3 of a matrix that is not symmetric, beside a least eigenvalue of 3
    np.testing.assert_allclose(np.sort(squares), zeros * 9.81 / length, rtol=1e-9)


def test_terms_are_proportional_to_the_bars():
    """Twice the bars from n to 2n, and from 2n to 4n, double what is added."""

    def terms(count):
        source = kernel_source(System(masses_on_a_string(count)).topology)
        return sum(len(routine.block.statements) for routine in source.program.routines)

    few, middling, many = map(terms, (16, 32, 64))
    assert many - middling == 2 * (middling - few)


def test_few_bars_keep_their_matrix():
    """Kernels of small mechanisms are the same text as ever."""
    few = topologies.FEW
    assert System(masses_on_a_string(few)).model.tree is None
    assert System(masses_on_a_string(few + 1)).model.tree is not None


def test_bars_without_inertia_are_named():
    with pytest.raises(linkages.InputError, match="no mass moves with b13 at t = 0"):
        linkages.simulate(masses_on_a_string(14, heavy=13), end=0.1)


STOPPED = """
stops:
  - {bars: [ground, b0], lower: -1.2, restitution: 0.6}
  - {bars: [b3, b4], upper: 0.6, stiffness: 200, damping: 1}
"""
FRICTIONS = """
friction:
  - {joint: J1, coefficient: 0.2, radius: 0.03, slip_speed: 0.1}
  - {joint: J0, coefficient: 0.1, radius: 0.05, slip_speed: 0.1}
  - {between_bars: [b1, b2], torque: 0.1, slip_speed: 0.2}
"""


def swinging(more):
    """A chain that swings against a stop."""
    bars = "\n".join(
        f"  b{i}: {{joints: [J{i}, J{i + 1}], length: 0.1, mass: 1}}" for i in range(14)
    )
    free = "\n".join(f"  b{i}: {{angle: {-1 + 0.05 * i}, speed: -1}}" for i in range(14))
    text = f"joints: {{J0: [0, 0]}}\ngravity: [0, -9.81]\nbars:\n{bars}\nfree:\n{free}\n{more}"
    return linkages.loads(text)


def anew(monkeypatch, few):
    """Structures and plans are made again, with the whole matrix up to so many coordinates."""
    monkeypatch.setattr(topologies, "FEW", few)
    for module, name in (
        (systems, "_TOPOLOGIES"), (systems, "_STRUCTURES"), (plan, "_PLANS"), (plan, "_FURTHER"),
        (plan, "_WIDE"),
    ):  # fmt: skip
        monkeypatch.setattr(module, name, LRUCache(8))


@pytest.mark.parametrize("more", [STOPPED, FRICTIONS], ids=["stops", "frictions"])
def test_impacts_and_frictions_are_those_of_the_whole_matrix(more, monkeypatch):
    """Impulses and reactions are solved with columns of the inverse of the matrix."""
    found = []
    for few in (12, 1000):
        anew(monkeypatch, few)
        data = linkages.simulate(swinging(more), end=0.2, samples=5, rtol=1e-11).data
        found.append(data.bar_speed.to_numpy())
    # rad/s, of up to some 20, through some ten changes of modes of a chain that is not yet chaotic
    np.testing.assert_allclose(*found, rtol=0, atol=1e-7)


def test_deviation_vectors_grow_as_by_the_whole_matrix(monkeypatch):
    found = []
    for few in (12, 1000):
        anew(monkeypatch, few)
        result = linkages.lyapunov(swinging(""), count=2, periods=2, interval=0.1, rtol=1e-10)
        found.append(result.exponent.to_numpy())
    np.testing.assert_allclose(*found, rtol=1e-6)  # per second, of neighbours at 1e-10


def test_results_of_chains_do_not_depend_on_their_neighbours():
    """Lanes have the same bits beside others, also of trees."""
    values = [0.9, 1.1, 1.3]
    run = {"end": 0.1, "samples": 3}
    swept = linkages.sweep(
        swinging(""), {"bars.b5.mass": values}, {"top": "max(b13.speed)"}, cores=1, **run
    )
    for value, found in zip(values, swept["top"].to_numpy(), strict=True):
        other = linkages.sweep(
            swinging(""), {"bars.b5.mass": [value, 2.0]}, {"top": "max(b13.speed)"}, cores=1, **run
        )
        assert other["top"].to_numpy()[0] == found
