"""The differential equation of a system, compiled: one program, for any assembly mode."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.compiled import CompiledKernel, compile_kernel
from linkages.kernel.model import Model
from linkages.kernel.modes import Assembly, parameter_values
from linkages.kernel.program import Program, write_functions_of, write_program
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.kernel.variations import variations
from linkages.solvers.flow import Companion, Flow


@dataclass(frozen=True)
class KernelSource:
    """What a kernel is made of.

    Parameters
    ----------
    model
        The equations.
    accelerations
        Second derivatives of all integrated coordinates.
    settled
        Values, then rates, of those that are replaced after each step.
    counted
        Cosines, sines and speeds of dependent angles whose whole turns are counted.
    """

    model: Model
    accelerations: tuple[Scalar, ...]
    settled: tuple[Scalar, ...]
    counted: tuple[Scalar, ...] = ()

    @cached_property
    def program(self) -> Program:
        """The printed kernel."""
        return write_program(self.model, self.accelerations, self.settled, self.counted)


def kernel_source(
    system: System, work: bool = False, tangents: int = 0, counting: bool = False
) -> KernelSource:
    """The equations that are integrated for a system.

    Parameters
    ----------
    system
        A system with integrated coordinates.
    work
        Whether to carry the work of drives and loads along, as the rate of one more coordinate
        whose acceleration is their power.
    tangents
        Number of solutions of the variational equations to carry along: after all others, the n
        components of one are n more coordinates, which obey the equations linearised in the free
        coordinates.
    counting
        Whether to count the whole turns of dependent angles.
    """
    count = len(system.topology.free)
    model = Model(system.topology, more=int(work) + tangents * count)
    free = model.free_accelerations
    accelerations = model.integrated_accelerations(free)
    if work:
        accelerations = [*accelerations, model.power]
    accelerations = [*accelerations, *variations(model, tangents)]
    counted = tuple(model.counted) if counting else ()
    return KernelSource(model, tuple(accelerations), tuple(model.settled), counted)


class Flows:
    """Makes the flows of a system.

    Parameters
    ----------
    system
        A system with integrated coordinates.
    work, tangents, counting
        As in `kernel_source`.
    """

    def __init__(
        self, system: System, work: bool = False, tangents: int = 0, counting: bool = False
    ) -> None:
        self.system = system
        self._source = kernel_source(system, work, tangents, counting)

    @cached_property
    def margin_scale(self) -> NDArray[np.float64]:
        """Sizes of the margins of all blocks."""
        return self.system.evaluate(self.system.model.margin_scales)[:, 0]

    def flow(
        self,
        flipped: Collection[int] = (),
        least_margin: NDArray[np.float64] | None = None,
    ) -> Flow:
        """The flow with some blocks in their other assembly mode.

        Parameters
        ----------
        flipped
            Blocks that are in another mode than at the start.
        least_margin
            Relative margins below which an integration stops, shape (blocks,).
        """
        model, topology = self._source.model, self.system.topology
        program = self._source.program  # asks the model for all parameters before they are counted
        parameters = _numbers(model, self.system.assembly, flipped)
        kernel = compile_kernel(program, parameters)

        def linearise() -> Companion:
            from linkages.kernel.derivatives import compile_jacobian

            return _companion(compile_jacobian(model, self._source.accelerations, parameters))

        bodies = self.system.mechanism.bodies
        rotates = [bodies[n].rotates and not topology.unwrapped(n) for n in topology.coordinates]
        return Flow(
            clock=kernel.clock,
            rates=kernel.rates,
            parameters=kernel.parameters,
            timed_size=kernel.timed,
            coordinates=model.inputs.coordinates,
            rotates=np.array([*rotates, *[False] * (model.inputs.coordinates - len(rotates))]),
            margin_scale=self.margin_scale,
            least_margin=least_margin,
            first_carried=len(topology.free),
            carried=len(self._source.settled) // 2,
            counted=len(self._source.counted) // 3,
            keepalive=kernel,
            linearise=linearise,
        )


def watched(
    system: System,
    function: Callable[[Model], tuple[Scalar, Scalar]],
    more: int = 0,
    flipped: Collection[int] = (),
) -> Companion:
    """A function of position and velocity, compiled for an event in the flow of a system.

    Parameters
    ----------
    system
        A system with integrated coordinates.
    function
        The model → the function and its rate, which may depend on accelerations.
    more
        Number of further coordinates that the flow integrates: work, tangents.
    flipped
        Blocks that are in another mode than at the start.
    """
    model = Model(system.topology, more)
    nodes = function(model)
    program = write_functions_of(model, nodes, "a function of position and velocity, its rate")
    return _companion(compile_kernel(program, _numbers(model, system.assembly, flipped)))


def _numbers(model: Model, assembly: Assembly, flipped: Collection[int]) -> NDArray[np.float64]:
    """Parameters of a model whose program is printed, with some blocks in their other mode."""
    parameters = parameter_values(model, assembly)
    paths = list(model.inputs.parameters)
    for block in flipped:
        if ("side", block) in paths:  # what is watched may not depend on it
            parameters[paths.index(("side", block))] *= -1.0
    return parameters


def _companion(kernel: CompiledKernel) -> Companion:
    return Companion(
        clock=kernel.clock,
        rates=kernel.rates,
        parameters=kernel.parameters,
        timed_size=kernel.timed,
        keepalive=kernel,
    )


def build_flow(system: System, work: bool = False) -> Flow:
    """The differential equation of a system, compiled."""
    return Flows(system, work).flow()
