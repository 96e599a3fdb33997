"""Printed modules as namespaces, and what the kernel says about the same quantities."""

from itertools import combinations_with_replacement

import numpy as np
from lagrange_states import Kernel, analysed

import linkages
from linkages.equations import derive, render
from linkages.topology.topology import build_topology


def topology_of(text):
    return analysed(linkages.loads(text))


def equations_of(text):
    return derive(build_topology(linkages.loads(text)))


def module_of(equations):
    module = {}
    exec(compile(render(equations, "python"), "equations.py", "exec"), module)
    return module


def projections(model):
    """Velocity coefficients, inertia terms, and what loads, springs and gravity do."""
    names = (*model.topology.driven, *model.topology.free)
    partials = {name: model.partial(name) for name in names}
    found = {
        ("coefficient", body, name): partial.bodies[body]
        for name, partial in partials.items()
        for body in partial.bodies
    }
    for first, second in combinations_with_replacement(names, 2):
        found["inertia", first, second] = model.inertia.product(partials[first], partials[second])
    for name, partial in partials.items():
        inert = model.inertia.product(model.accelerations, partial)
        found["force", name] = inert - model.required_force(model.accelerations, partial)
        found["effort", name] = model.required_force(model.accelerations, partial)
    return found


class GeneratedProgram:
    """The equations of a mechanism, their printed module, and states of the kernel."""

    def __init__(self, topology, count):
        self.topology = topology
        self.equations = derive(topology)
        self.module = module_of(self.equations)
        self.bodies = list(self.equations.symbols.coordinates)
        self.generalised = (*topology.driven, *topology.free)
        self.states = Kernel(topology, projections).random_states(count)
        assert len(self.states) == count

    def of(self, values):
        """What a state says about every coordinate of the module."""
        return np.array([values[name] for name in self.bodies])

    def parameters(self, state):
        """Parameters of the module at a state, whose drives are random."""
        symbols = self.equations.symbols
        given = {s.name: state.parameters.get(path, symbols.values[s])
                 for s, path in symbols.paths.items()}  # fmt: skip
        assert given.keys() == self.module["PARAMETERS"].keys()
        return given

    def coefficients(self, state):
        """K of the kernel."""
        return np.array(
            [[state.more["coefficient", b, g] for g in self.generalised] for b in self.bodies]
        ).reshape(len(self.bodies), len(self.generalised))

    def inertia(self, state):
        """J of the kernel."""
        size = len(self.generalised)
        matrix = np.zeros((size, size))
        for i, first in enumerate(self.generalised):
            for j, second in enumerate(self.generalised[i:], i):
                matrix[i, j] = matrix[j, i] = state.more["inertia", first, second]
        return matrix

    def row(self, state, what):
        """A value for every generalised coordinate."""
        return np.array([state.more[what, name] for name in self.generalised])
