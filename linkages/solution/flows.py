"""The differential equation of a system, compiled: one program, for any assembly mode."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.compiled import compile_kernel
from linkages.kernel.model import Model
from linkages.kernel.modes import parameter_values
from linkages.kernel.program import Program, write_program
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.kernel.variations import Watched, rate_of, variations
from linkages.solvers.flow import Flow, Linearisation


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
    """

    model: Model
    accelerations: tuple[Scalar, ...]
    settled: tuple[Scalar, ...]

    @cached_property
    def program(self) -> Program:
        """The printed kernel."""
        return write_program(self.model, self.accelerations, self.settled)


def kernel_source(
    system: System, work: bool = False, watched: Watched | None = None, tangents: int = 0
) -> KernelSource:
    """The equations that are integrated for a system.

    Parameters
    ----------
    system
        A system with integrated coordinates.
    work
        Whether to carry the work of drives and loads along, as the rate of one more coordinate
        whose acceleration is their power.
    watched
        A function of position and velocity that is the rate of one more coordinate: events can
        then be looked for where it crosses a level.
    tangents
        Number of solutions of the variational equations to carry along: after all others, the n
        components of one are n more coordinates, which obey the equations linearised in the free
        coordinates.
    """
    count = len(system.topology.free)
    model = Model(system.topology, more=int(watched is not None) + int(work) + tangents * count)
    free = model.free_accelerations
    accelerations = model.integrated_accelerations(free)
    settled = model.settled
    if watched is not None:
        value = watched(model)
        accelerations = [*accelerations, rate_of(model, value)]
        half = len(settled) // 2
        settled = [*settled[:half], model.graph.zero, *settled[half:], value]
    if work:
        accelerations = [*accelerations, model.power]
    accelerations = [*accelerations, *variations(model, tangents)]
    return KernelSource(model, tuple(accelerations), tuple(settled))


class Flows:
    """Makes the flows of a system.

    Parameters
    ----------
    system
        A system with integrated coordinates.
    work, watched, tangents
        As in `kernel_source`.
    """

    def __init__(
        self,
        system: System,
        work: bool = False,
        watched: Watched | None = None,
        tangents: int = 0,
    ) -> None:
        self.system = system
        self._source = kernel_source(system, work, watched, tangents)

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
        parameters = parameter_values(model, self.system.assembly)
        paths = list(model.inputs.parameters)
        for block in flipped:
            parameters[paths.index(("side", block))] *= -1.0
        kernel = compile_kernel(program, parameters)

        def linearise() -> Linearisation:
            from linkages.kernel.derivatives import compile_jacobian

            jacobian = compile_jacobian(model, self._source.accelerations, parameters)
            return Linearisation(
                clock=jacobian.clock,
                rates=jacobian.rates,
                parameters=jacobian.parameters,
                timed_size=jacobian.timed,
                keepalive=jacobian,
            )

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
            keepalive=kernel,
            linearise=linearise,
        )


def build_flow(system: System, work: bool = False) -> Flow:
    """The differential equation of a system, compiled."""
    return Flows(system, work).flow()
