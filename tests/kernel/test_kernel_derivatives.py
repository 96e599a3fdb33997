"""Derivatives of kernels, against symbolic ones, differences and the compiled code."""

import ctypes
from functools import partial

import numpy as np
import pytest
import sympy
from linkage_models import LOOPED, program, system

from linkages.kernel.code.program import bind_kernel
from linkages.kernel.differentiation import Evaluator
from linkages.kernel.scalars import Level, ScalarGraph, reachable
from linkages.kernel.state_jumps import derivative, jacobian_nodes, write_jacobian

POINTER = ctypes.POINTER(ctypes.c_double)


EXPRESSIONS = {
    "sum": lambda _, x, z: x + 3.0 * z,
    "difference": lambda _, x, z: x * x - z,
    "product": lambda _, x, z: x * z * z,
    "quotient": lambda _, x, z: x / (z + 2.0),
    "constant quotient": lambda _, x, z: 2.0 / x + z / 4.0,
    "negative": lambda _, x, z: -(x * z),
    "root": lambda m, x, z: m.sqrt(x * x + z),
    "sine": lambda m, x, z: m.sin(x * z),
    "cosine": lambda m, x, z: m.cos(x - z * z),
    "angle": lambda m, x, z: getattr(m, "atan2", partial(ScalarGraph.apply, m, "atan2"))(
        x * z, z + 1.0
    ),
    "chain": lambda m, x, z: m.sin(x) / m.sqrt(1.0 + m.cos(z) * m.cos(z)) - x * m.sin(x),
}


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_operations_follow_symbolic_derivatives(graph, inputs, name):
    expression, point = EXPRESSIONS[name], {"x": 0.7, "z": 1.3}
    symbols = sympy.symbols("x z")
    symbolic = expression(sympy, *symbols)
    ((dx, dz),) = derivative([expression(graph, *inputs)], inputs)
    found = Evaluator([dx, dz])(y=np.array([0.7, 1.3]))
    exact = [float(symbolic.diff(symbol).subs(point)) for symbol in symbols]
    assert [float(value) for value in found] == pytest.approx(exact, rel=1e-14)


def test_second_derivatives(graph, inputs):
    x, z = inputs
    (row,) = derivative([graph.sin(x) * z], inputs)
    (dxx, dxz), (dzx, dzz) = derivative(row, inputs)
    found = [float(v) for v in Evaluator([dxx, dxz, dzx, dzz])(y=np.array([0.7, 1.3]))]
    assert found == pytest.approx([-1.3 * np.sin(0.7), np.cos(0.7), np.cos(0.7), 0.0], abs=1e-15)


def test_zeros_fold_away_and_parts_are_shared(graph, inputs):
    x, z = inputs
    parameter = graph.input("p", 0, Level.PARAMETERS)
    root = graph.sqrt(x * x + parameter)
    rows = derivative([root, parameter * 2.0, z], inputs)
    assert rows[0] == [(0.5 / root) * (x + x), graph.zero]
    assert rows[1] == [graph.zero, graph.zero]
    assert rows[2] == [graph.zero, graph.one]


def test_derivatives_with_respect_to_parameters(graph, inputs):
    parameter = graph.input("p", 0, Level.PARAMETERS)
    ((found,),) = derivative([parameter * parameter * inputs[0]], [parameter])
    assert Evaluator([found])(p=[3.0], y=[2.0, 0.0])[0] == 12.0


def test_nothing_to_differentiate(inputs):
    assert derivative([], inputs) == []


def moving(name):
    """A linkage with its model, its numbers, and a state in motion."""
    of = system(name)
    model, n = of.model, of.model.inputs.coordinates
    accelerations = model.free_accelerations
    state = np.array(of.state) + np.concatenate([np.full(n, 0.01), np.linspace(1.0, 2.0, n)])
    return model, accelerations, of.parameters, state


FREE = [name for name in LOOPED if system(name).topology.free]


@pytest.mark.parametrize("name", FREE)
def test_jacobian_follows_central_differences(name):
    model, accelerations, parameters, state = moving(name)
    rows = jacobian_nodes(model, accelerations)
    count, width = len(accelerations), len(state)
    exact = Evaluator([entry for row in rows for entry in row])
    value = Evaluator(accelerations)

    def at(y):
        return np.array([float(a) for a in value(t=[0.01], p=parameters, y=y)])

    found = np.reshape([float(e) for e in exact(t=[0.01], p=parameters, y=state)], (count, width))
    steps = 1e-4 * np.maximum(1e-2, np.abs(state)) * np.eye(width)
    # Richardson's extrapolation: errors of h⁴ and ε/h balance at some ten digits.
    differences = [
        (8 * (at(state + d / 2) - at(state - d / 2)) - (at(state + d) - at(state - d)))
        / (6 * d.sum())
        for d in steps
    ]
    scale = np.abs(at(state)).max() + np.abs(found).max()
    assert found == pytest.approx(np.transpose(differences), rel=1e-7, abs=1e-8 * scale)


@pytest.mark.parametrize("name", FREE[:2])
def test_compiled_jacobian_is_the_evaluated_one(name):
    model, accelerations, parameters, state = moving(name)
    entries = [entry for row in jacobian_nodes(model, accelerations) for entry in row]
    kernel = bind_kernel(write_jacobian(model, accelerations), parameters)
    timed, out = (
        np.zeros(max(1, kernel.timed_size)),
        np.zeros(len(entries) + 2 * len(model.margins)),
    )

    def address(values):
        return values.ctypes.data_as(POINTER)

    clock = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, POINTER, POINTER)(kernel.clock)
    rates = ctypes.CFUNCTYPE(ctypes.c_int64, *[POINTER] * 4)(kernel.rates)
    assert clock(0.01, address(kernel.parameters), address(timed)) == 0
    assert rates(address(state), address(kernel.parameters), address(timed), address(out)) == 0
    exact = [float(e) for e in Evaluator(entries)(t=[0.01], p=parameters, y=state)]
    # Contracted multiply-adds round differently.
    assert out[: len(entries)] == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).max())


def test_jacobian_costs_little_more_than_the_accelerations():
    of = system(FREE[0])
    plain = program(of)
    both = write_jacobian(of.model, of.model.free_accelerations)
    assert len(both.text) < 3 * len(plain.text) * len(of.state)
    assert len(reachable(of.model.free_accelerations)) > 0
