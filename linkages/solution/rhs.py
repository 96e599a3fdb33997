"""The equations of motion as a function of time and state."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.solution.interpolated import evaluate_outputs
from linkages.solution.motion import Motion, Piece
from linkages.solution.plan import Plan
from linkages.solution.series import REACTIONS, labelled, requested
from linkages.solution.stop_messages import block_failure
from linkages.solvers.flow import Flow, Kernel
from linkages.solvers.loops.scalar_stages import EVALUATE_STATE, EVALUATE_STATES

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.propagator import Propagator

Floats = NDArray[np.float64]


class Equations:
    """Right-hand side y′ = f(t, y) of the equations of motion, compiled.

    The state y has 2n + s entries: n coordinates, their rates, and s internal states of components
    that have any. `names` and `units` say which. Coordinates are the free ones, in rad or m; behind
    them come, in mechanisms with groups that no closed form solves, the coordinates from which the
    iterations start. Angles may have any number of turns. The assembly mode is that of `state`, and
    stays.

    From `linkages.compile`. It can be pickled, and called from several threads.

    Attributes
    ----------
    system
        The mechanism, assembled.
    mechanism
        What was compiled, with the free coordinates that were chosen for it.
    names : 2n + s of str
        Such as ``("crank.angle", "crank.speed")``.
    units : 2n + s of str
        Unit of each entry of y.
    state : (2n + s,)
        The initial state of the definition.
    time
        Its time in seconds.
    """

    def __init__(self, system: System) -> None:
        self.system = system
        self.mechanism: Mechanism = system.mechanism
        bodies, own = system.mechanism.bodies, system.layout.bodies
        internal = system.mechanism.internal.values()
        angular = [bodies[name].rotates for name in own]
        words = [("angle", "speed") if turns else ("position", "velocity") for turns in angular]
        units = [("rad", "rad/s") if turns else ("m", "m/s") for turns in angular]
        named = [
            (f"{name}.{value}", f"{name}.{rate}")
            for name, (value, rate) in zip(own, words, strict=True)
        ]
        both = [pair[order] for order in (0, 1) for pair in named]
        self.names = (*both, *(state.name for state in internal))
        both = [pair[order] for order in (0, 1) for pair in units]
        self.units = (*both, *(state.unit for state in internal))
        self.state: Floats = system.state[system.layout.state_rows]
        self.time = system.time

    def __reduce__(self) -> tuple[Any, ...]:
        return compile, (self.mechanism,)

    def __repr__(self) -> str:
        return f"Equations({self.mechanism.name!r}, y = [{', '.join(self.names)}])"

    @cached_property
    def _flow(self) -> Flow:
        return Plan.of(self.system).bind(self.system)

    @cached_property
    def _varying(self) -> Varying:
        return Varying(self.mechanism)

    @cached_property
    def _kernel(self) -> NDArray[np.int64]:
        """What `evaluate_state` takes of the kernel."""
        flow, size = self._flow, len(self.state)
        numbers = flow.parameters.ctypes.data
        return np.array([flow.clock, flow.rates, numbers, size, flow.written])

    @cached_property
    def _evaluate(self) -> Callable[[int], int]:
        return partial(EVALUATE_STATE.function, self._kernel.ctypes.data)

    @cached_property
    def _slopes(self) -> Kernel:
        assert self._flow.linearise is not None
        return self._flow.linearise()

    def held(self, t: float, y: ArrayLike) -> dict[str, float]:
        """Modes and latched values that follow from a state at a time."""
        if not self._flow.held:
            return {}
        state = self.system.layout.moving(np.asarray(y, dtype=float))
        values = self.system.at(t, state).starting_held()
        return dict(zip(self.system.model.switches.names, values.tolist(), strict=True))

    def __call__(self, t: float, y: ArrayLike, held: Mapping[str, float] | None = None) -> Floats:
        """Derivative of the state, in the order of `names`.

        Parameters
        ----------
        t
            Time in seconds.
        y : (2n + s,)
            State.
        held
            Modes and what the motion remembers, if it has any; `held` of the state if not given.

        Raises
        ------
        ComputationError
            If the mechanism cannot be assembled in this state, or has no finite accelerations.
        """
        given = np.asarray(y, dtype=np.float64)
        size, written = len(self.state), self._flow.written
        if given.shape != (size,) or self._flow.held or self.system.topology.internal:
            return self.batch(t, given, held)
        # one array for everything: each address costs as much as a right-hand side
        work = np.empty(1 + size + written + self._flow.timed_size)
        work[0], work[1 : 1 + size] = t, given
        status = self._evaluate(work.ctypes.data)
        half = size // 2
        accelerations = work[1 + size : 1 + size + half]
        if status or not math.isfinite(accelerations @ accelerations):
            return self.batch(t, given)
        return np.concatenate([given[half:], accelerations])

    def batch(
        self, times: ArrayLike, states: ArrayLike, held: Mapping[str, float] | None = None
    ) -> Floats:
        """Derivatives of many states with one call, shape (2n + s, m).

        Parameters
        ----------
        times : (m,) or ()
            Times in seconds, or one for all.
        states : (2n + s, m) or (2n + s,)
            A state per column, as SciPy's ``solve_ivp`` returns them; of a single state a single
            derivative is returned, shape (2n + s,).
        held
            As the right-hand side itself takes it, for all states.

        Raises
        ------
        ComputationError
            For the first state that cannot be assembled: which block does not close, and when.
        """
        time, rows, single = self._rows(times, states)
        found = self._evaluated(self._flow, self._flow.written, time, rows, held)
        n = self._flow.coordinates
        changes = np.concatenate([rows[:, n:], found[:, :n]], axis=1)
        result = changes[:, self.system.layout.state_rows]
        return result[0] if single else np.ascontiguousarray(result.T)

    def jacobian(self, t: float, y: ArrayLike, held: Mapping[str, float] | None = None) -> Floats:
        """Derivatives ∂f_i/∂y_j at a time and a state, exact to round-off.

        Of shape (2n + s, 2n + s).

        Parameters
        ----------
        t
            Time in seconds.
        y : (2n + s,)
            State.
        held
            As the right-hand side itself takes it: modes do not change from state to state.

        Raises
        ------
        ComputationError
            As for the right-hand side itself.
        """
        time, rows, _ = self._rows(t, y)
        n, flow, kept = self._flow.coordinates, self._flow, self.system.layout.state_rows
        size = 2 * n * n + 2 * len(flow.margin_scale) + 2 * flow.carried
        slopes = self._evaluated(self._slopes, size, time, rows, held)[0, : 2 * n * n]
        return np.vstack([np.eye(n, 2 * n, n), slopes.reshape(n, 2 * n)])[np.ix_(kept, kept)]

    def outputs(self, names: Iterable[str], times: ArrayLike, states: ArrayLike) -> xr.Dataset:
        """Outputs at some times and states, labelled as `linkages.simulate` labels them.

        Parameters
        ----------
        names
            Outputs, such as ``["joint_position", "drive_effort"]``; those that compare a motion
            with its past or with an ideal one are not among them. Angles that are not integrated
            lie within one turn.
        times : (m,) or ()
            Times in seconds, or one for all.
        states : (2n + s, m) or (2n + s,)
            A state per column.

        Raises
        ------
        ValueError
            For names that are no outputs of this mechanism.
        ComputationError
            For states that cannot be assembled.
        """
        wanted = requested(self.system, names)
        unfit = [name for name in wanted if VARIABLES[name].whole and name not in REACTIONS]
        if unfit:
            raise ValueError(f"{unfit[0]} follows from a whole motion; `linkages.simulate` has it")
        time, rows, _ = self._rows(times, states)
        n = self._flow.coordinates
        piece = Piece(
            system=self.system,
            time=time,
            state=rows.T,
            turns=np.zeros((n, len(time))),
            acceleration=self._evaluated(self._flow, self._flow.written, time, rows)[:, :n].T,
        )
        motion = Motion(pieces=(piece,))
        return labelled(self.system, motion, evaluate_outputs(motion, wanted))

    def bind(self, values: Mapping[str, object]) -> Equations:
        """The equations of the same mechanism with other values.

        Parameters
        ----------
        values
            Dotted path → value, as `Mechanism.with_values` takes them.

        Raises
        ------
        InputError
            If they lead nowhere, cannot be used, or cannot be assembled.
        """
        return Equations(self._varying.at(values))

    def flow(self, tangents: int = 0, **options: Any) -> Propagator:
        """What moves states, and tangents to their motion, over intervals of time.

        Parameters
        ----------
        tangents
            Number of solutions of the variational equations that are moved along.
        options
            ``events``, ``extrema``, ``stop``, ``parameters``, ``method``, ``rtol``, ``atol``,
            ``step`` and ``max_steps``, as `linkages.Propagator` takes them.

        Examples
        --------
        >>> import linkages
        >>> rhs = linkages.compile(linkages.load("pendulum"))
        >>> flow = rhs.flow(tangents=2, events={"rod.speed": "up"})
        >>> end = flow.advance(rhs.state, 0.0, 10.0)
        >>> end.tangents.shape
        (2, 2)
        >>> len(end.crossings["rod.speed"].time)
        3
        """
        from linkages.solution.propagator import Propagator

        return Propagator(self, tangents, **options)

    def _rows(self, times: ArrayLike, states: ArrayLike) -> tuple[Floats, Floats, bool]:
        """Times, shape (m,), motions, (m, 2N), and whether it is a single one."""
        given = np.asarray(states, dtype=np.float64)
        if given.ndim not in (1, 2) or len(given) != len(self.state):
            raise ValueError(
                f"expected states of {len(self.state)} entries ({', '.join(self.names)}), shape "
                f"({len(self.state)},) or ({len(self.state)}, m), found shape {given.shape}"
            )
        moving = self.system.layout.moving(given)
        rows = np.ascontiguousarray(np.atleast_2d(moving.T))
        result = np.asarray(times, dtype=np.float64)
        if result.shape not in ((), (len(rows),)):
            raise ValueError(
                f"expected one time, or one for each of {len(rows)} states, found shape "
                f"{result.shape}"
            )
        return np.ascontiguousarray(np.broadcast_to(result, len(rows))), rows, given.ndim == 1

    def _evaluated(
        self,
        kernel: Kernel,
        written: int,
        time: Floats,
        rows: Floats,
        held: Mapping[str, float] | None = None,
    ) -> Floats:
        """What a kernel writes for each state, shape (m, written)."""
        if not kernel.held:
            return self._alike(kernel, written, time, rows, kernel.parameters)
        result = np.empty((len(rows), written))
        states = rows[:, self.system.layout.state_rows]
        given = [self.held(*at) if held is None else held for at in zip(time, states, strict=True)]
        names = self.system.model.switches.names
        values = np.array([[one[name] for name in names] for one in given])
        for alike in np.unique(values, axis=0):
            here = (values == alike).all(axis=1)
            parameters = kernel.parameters.copy()
            parameters[len(parameters) - kernel.held :] = alike
            result[here] = self._alike(kernel, written, time[here], rows[here], parameters)
        return result

    def _alike(
        self,
        kernel: Kernel,
        written: int,
        time: Floats,
        rows: Floats,
        parameters: Floats,
    ) -> Floats:
        """The same for states with the same modes."""
        result, refused = np.empty((len(rows), written)), np.zeros(1, dtype=np.int64)
        timed = np.empty(max(1, kernel.timed_size))
        addresses = (parameters, timed, time, rows, result)
        status = EVALUATE_STATES.function(
            kernel.clock, kernel.rates, *(array.ctypes.data for array in addresses),
            len(rows), rows.shape[1], written, refused.ctypes.data,
        )  # fmt: skip
        which = int(refused[0])
        if status:
            text = block_failure(self.system.model, status - 1, float(time[which]), False)
            raise ComputationError(f"{text}: y = {rows[which]}", time=float(time[which]))
        sound = np.isfinite(result[:, : self._flow.coordinates]).all(axis=1)
        if not sound.all():
            which = int(np.argmin(sound))
            raise ComputationError(
                f"at t = {time[which]:.9g} s the accelerations are not finite numbers, as in a "
                f"singular position or under a load without a value: y = {rows[which]}",
                time=float(time[which]),
            )
        return result


def compile(mechanism: Mechanism) -> Equations:  # noqa: A001
    """Compile the equations of motion, for one's own integrators and analyses.

    Parameters
    ----------
    mechanism
        With at least one coordinate that is integrated.

    Raises
    ------
    InputError
        If the mechanism cannot be assembled, or drives determine its whole motion.

    Examples
    --------
    >>> import linkages
    >>> from scipy.integrate import solve_ivp
    >>> rhs = linkages.compile(linkages.load("pendulum"))
    >>> rhs.names
    ('rod.angle', 'rod.speed')
    >>> own = solve_ivp(rhs, (0.0, 2.0), rhs.state, method="Radau", jac=rhs.jacobian, rtol=1e-9)
    >>> rhs.outputs(["joint_position"], own.t, own.y).joint_position.dims
    ('time', 'joint', 'axis')
    """
    system = System(mechanism)
    if not system.topology.coordinates:
        message = (
            "nothing is free to move: drives determine the whole motion; `linkages.simulate` "
            "computes it"
        )
        raise InputError(mechanism.source, [Problem(message=message)])
    return Equations(system)
