"""Motions with free coordinates, integrated by a compiled solver."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from linkages.kernel.assembly import parameter_values
from linkages.kernel.compiled import compile_kernel
from linkages.kernel.model import Model
from linkages.kernel.program import Program, write_program
from linkages.kernel.scalars import Evaluator, Scalar
from linkages.kernel.system import System
from linkages.solution.motion import Motion, Settings, block_failure
from linkages.solvers.flow import Flow, Linearisation
from linkages.solvers.integrate import integrate
from linkages.solvers.outcome import Outcome
from linkages.solvers.trajectory import Trajectory


@dataclass(frozen=True)
class KernelSource:
    """What a kernel is made of: a model and the second derivatives of its coordinates."""

    model: Model
    accelerations: tuple[Scalar, ...]

    @property
    def program(self) -> Program:
        """The printed kernel."""
        return write_program(self.model, self.accelerations)


def kernel_source(system: System, work: bool = False) -> KernelSource:
    """The equations that are integrated for a system.

    Parameters
    ----------
    system
        A system with free coordinates.
    work
        Whether to carry the work of drives and loads along, as the rate of one more coordinate
        whose acceleration is their power.
    """
    model = Model(system.topology, quadratures=int(work))
    power = (model.power,) if work else ()
    return KernelSource(model, (*model.free_accelerations, *power))


def build_flow(system: System, work: bool = False) -> Flow:
    """The differential equation of a system, compiled."""
    source = kernel_source(system, work)
    model = source.model
    program = source.program  # asks the model for all parameters before they are counted
    parameters = parameter_values(model, system.sides)
    kernel = compile_kernel(program, parameters)

    def linearise() -> Linearisation:
        from linkages.kernel.derivatives import compile_jacobian

        jacobian = compile_jacobian(model, source.accelerations, parameters)
        return Linearisation(
            clock=jacobian.clock,
            rates=jacobian.rates,
            parameters=jacobian.parameters,
            timed_size=jacobian.timed,
            keepalive=jacobian,
        )

    rotates = [system.mechanism.bodies[name].rotates for name in system.topology.free]
    scales = Evaluator(model.margin_scales)(p=parameters)
    return Flow(
        clock=kernel.clock,
        rates=kernel.rates,
        parameters=kernel.parameters,
        timed_size=kernel.timed,
        coordinates=model.inputs.coordinates,
        rotates=np.array([*rotates, *([False] if work else [])]),
        margin_scale=np.array([float(scale) for scale in scales]),
        keepalive=kernel,
        linearise=linearise,
    )


def integrated_motion(system: System, settings: Settings) -> Motion:
    """Integrate a system that has free coordinates."""
    count = len(system.topology.free)
    extra = [0.0] if settings.work else []
    start = np.array([*system.state[:count], *extra, *system.state[count:], *extra])
    trajectory = integrate(
        build_flow(system, settings.work),
        start,
        settings.times,
        start=0.0,
        method=settings.method,
        rtol=settings.rtol,
        atol=settings.atol,
        step=settings.step,
        max_steps=settings.max_steps,
        watch=settings.watch,
    )
    total = count + len(extra)
    coordinates, rates = trajectory.state.T[:total], trajectory.state.T[total:]
    return Motion(
        time=trajectory.time,
        state=np.concatenate([coordinates[:count], rates[:count]]),
        turns=trajectory.turns.T[:count].astype(float),
        acceleration=trajectory.acceleration.T[:count],
        work=rates[count] if settings.work else None,
        failure=failure_text(system, trajectory),
        stop_time=trajectory.stop_time,
        method=trajectory.method,
        reason=trajectory.reason,
        cost={
            "steps": trajectory.steps,
            "rejected": trajectory.rejected,
            "evaluations": trajectory.evaluations,
        },
    )


def failure_text(system: System, trajectory: Trajectory) -> str | None:
    """Why an integration stopped before its end, as a sentence; None if it did not."""
    outcome = trajectory.outcome
    if outcome is Outcome.DONE:
        return None
    if outcome in (Outcome.UNREACHABLE, Outcome.SINGULAR) and trajectory.block >= 0:
        singular = outcome is Outcome.SINGULAR
        text = block_failure(system.model, trajectory.block, trajectory.stop_time, singular)
        return f"{text}. {outcome.remedy}"
    return f"at t = {trajectory.stop_time:.9g} s: {outcome}"
