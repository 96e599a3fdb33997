"""States and deviation vectors moved over intervals of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.errors import ComputationError, Interrupted
from linkages.kernel.number_effects import effects, numbers_of
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.guards import free_vectors, parse_events, parse_extrema
from linkages.solution.march import March
from linkages.solution.motion import Motion
from linkages.solution.run_options import options_of
from linkages.solution.simulate import whole_number

if TYPE_CHECKING:
    from linkages.solution.rhs import Equations

Floats = NDArray[np.float64]

FLIPPED = "a change point was passed: the equations are those of one assembly mode"


@dataclass(frozen=True, kw_only=True)
class Crossed:
    """Crossings of one event.

    Parameters
    ----------
    time : (m,)
        When, in seconds.
    y : (2n + s, m)
        The state there.
    """

    time: Floats
    y: Floats


@dataclass(frozen=True, kw_only=True)
class Advanced:
    """Where an advance came to.

    Parameters
    ----------
    time
        In seconds: the end, or that of the crossing at which the advance stopped.
    y : (2n + s,)
        The state there; angles with all the turns made since the beginning.
    tangents : (2f + s, k)
        Tangents there.
    crossings
        Event → its crossings on the way.
    by_parameters : (2f + s, p)
        Derivatives of the state by the parameters, at the same end.
    held
        Modes and what the motion remembers, by their names; tangents and derivatives by parameters
        of the latter with them.
    """

    time: float
    y: Floats
    tangents: Floats
    by_parameters: Floats
    crossings: Mapping[str, Crossed] = field(default_factory=dict)
    held: Mapping[str, Floats] = field(default_factory=dict)


class Propagator:
    """Moves a state, and solutions of the variational equations, along the motion.

    It keeps nothing between calls. From `linkages.Equations.flow`.

    Parameters
    ----------
    equations
        Of a mechanism.
    tangents
        Number k of tangents, at most 2f + s, f being the number of free coordinates, s that of
        internal states. A tangent has as many entries: deviations of the free coordinates, of their
        rates, and of internal states.
    events
        Series → how it crosses its value: ``{"piston.velocity": "up"}``, ``"down"`` or ``"both"``.
        A value other than 0 stands behind it: ``"crank.angle=90 deg"``.
    extrema
        Series of position → which extrema are found, ``"max"``, ``"min"`` or ``"both"``, and
        returned as crossings: ``{"gap.indentation": "max"}``.
    parameters
        Dotted paths of p numbers of the definition, such as ``["bars.rod.length"]``, by which the
        state at the end is differentiated in the same pass.
    stop
        Whether an advance ends at the first crossing of an event or extremum.
    options
        ``method``, ``rtol``, ``atol``, ``step`` and ``max_steps``, as `linkages.simulate` takes
        them; what is None is that of the definition.

    Raises
    ------
    ValueError
        For arguments that make no sense.
    InputError
        If a path names no number, or one without a known derivative.
    """

    def __init__(
        self,
        equations: Equations,
        tangents: int = 0,
        *,
        events: Mapping[str, str] | None = None,
        stop: bool = False,
        extrema: Mapping[str, str] | None = None,
        parameters: Sequence[str] = (),
        **options: Any,
    ) -> None:
        system, self._effects = equations.system, None
        if parameters:
            numbers = numbers_of(equations.mechanism, parameters)
            system = System(equations.mechanism.keeping([number.path for number in numbers]))
            self._effects = effects(system, [*[None] * int(tangents), *numbers])
        self._system = system
        most = system.layout.directions
        self.tangents = whole_number("tangents", tangents)
        if not 0 <= self.tangents <= most:
            extra = ", and the internal states" if system.topology.internal else ""
            result = f"tangents must be from 0 to {most}, twice the free coordinates{extra}"
            raise ValueError(f"{result}; found {tangents}")
        # the equations are those of one assembly mode: behind a change point there are others
        given = {**options, "change_points": "stop"}
        self._run = options_of(RunOptions, equations.mechanism, given)
        if twice := (events or {}).keys() & (extrema or {}).keys():
            raise ValueError(f"found {', '.join(sorted(twice))} among both events and extrema")
        guards = (*parse_events(system, events or {}), *parse_extrema(system, extrema or {}))
        self._events = [replace(guard, wanted=int(stop)) for guard in guards]

    def advance(
        self,
        y: ArrayLike,
        t0: float,
        t1: float,
        tangents: ArrayLike | None = None,
        held: Mapping[str, Floats] | None = None,
        by_parameters: ArrayLike | None = None,
    ) -> Advanced:
        """Move a state, and tangents to it, from one time to another.

        Parameters
        ----------
        y : (2n + s,)
            State at `t0`, as `Equations` has it.
        t0, t1
            Times in seconds; `t1` may be the earlier one.
        tangents : (2f + s, k)
            Tangents at `t0` as columns; the first k columns of the unit matrix if not given.
        held
            Of the advance before, in mechanisms with modes; they follow from the state if not
            given.
        by_parameters : (2f + s, p)
            Derivatives of the state `y` by the parameters; zero if not given.

        Raises
        ------
        ComputationError
            If the motion cannot go on.
        Interrupted
            After Ctrl-C.
        """
        system = self._system
        layout, given = system.layout, np.array(y, dtype=np.float64)
        if given.shape != layout.state_rows.shape:
            raise ValueError(f"y must have shape {layout.state_rows.shape}, found {given.shape}")
        shape = layout.directions, self.tangents
        columns = np.eye(*shape) if tangents is None else np.asarray(tangents, dtype=float)
        if columns.shape != shape:
            raise ValueError(f"tangents must have shape {shape}, found {columns.shape}")
        if self._effects is not None:
            shape = layout.directions, len(self._effects) - self.tangents
            moved = np.zeros(shape) if by_parameters is None else np.asarray(by_parameters, float)
            if moved.shape != shape:
                raise ValueError(f"by_parameters must have shape {shape}, found {moved.shape}")
            columns = np.hstack([columns, moved])
        start = system.at(float(t0), layout.moving(given))
        if self._effects is not None:
            start = start.affected(self._effects)
        count = columns.shape[1]
        march = March(start, self._run, tangents=count, tangent_atol=self._run.rtol, held=held)
        march.tangents = columns
        motion = march.advance(np.array([float(t1)]), guards=self._events)
        if motion.failure is not None or march.flipped:
            kind = Interrupted if motion.interrupted else ComputationError
            raise kind(motion.failure or FLIPPED, time=motion.stop_time)
        moved = march.tangents_of(system.topology.free)
        return Advanced(
            time=march.time,
            y=self._vectors(Motion(pieces=(march.sample,)))[0],
            tangents=moved[:, : self.tangents],
            by_parameters=moved[:, self.tangents :],
            crossings={
                name: Crossed(time=met.time, y=self._vectors(met).T)
                for name, met in motion.crossings.items()
            },
            held=march.held,
        )

    def _vectors(self, motion: Motion) -> Floats:
        """States with all turns, shape (m, 2n + s)."""
        return free_vectors(self._system, motion, names=self._system.layout.bodies)
