"""The differential equation of a mechanism, as a solver sees it."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.code.program import Kernel
from linkages.kernel.code.statements import Routine
from linkages.kernel.dyads import LEAST_MARGIN

UPDATES = 2
"""Of switches at which other functions may jump, and internal states, but no rates of bodies."""


@dataclass(frozen=True, kw_only=True)
class Switching:
    """Modes of a flow, which change where functions of time and state cross zero.

    The last parameters of the flow are held between such times: a mode, +1 or −1, for each switch,
    the latched values, and their tangents, tangent by tangent. Where a switch rises, `transition`
    writes latched values, then new rates, from a state ``[q (n), v (n), a (n)]``; with tangents
    also their derivatives, see `linkages.kernel.state_jumps`. It is None if nothing is latched or
    jumps.
    """

    names: tuple[str, ...]  # one for each of m switches, for sentences
    active: tuple[int, ...]
    # For each number remembered the switch that renews it when it rises
    owners: tuple[int, ...] = ()
    jumps: tuple[int, ...] = ()
    sticks: tuple[bool, ...] = ()
    # 0, 1 or `UPDATES`
    couples_others: tuple[int, ...] = ()
    # Number of free coordinates and internal states: the first ones, whose rates may jump
    free: int = 0
    tangents: int = 0  # number of tangents, the last coordinates, with `free` entries each
    constraints: tuple[tuple[int, int], ...] = ()
    transition: Kernel | None = None

    @property
    def held(self) -> int:
        """Number h of modes, numbers remembered and their tangents."""
        return len(self.names) + len(self.owners) * (1 + self.tangents)

    @property
    def constrains(self) -> bool:
        """Whether changes may leave no neighbours in some directions."""
        return bool(self.constraints) or UPDATES in self.couples_others

    @property
    def values(self) -> int:
        """Number of new values that `transition` writes."""
        return len(self.owners) + self.free * sum(place >= 0 for place in self.jumps)

    @property
    def written(self) -> int:
        """Length of what `transition` writes."""
        further = self.values * (1 + self.tangents) + len(self.names) * self.tangents
        further += len(self.constraints) * 2 * self.free
        return self.values + (further if self.tangents else 0)


@dataclass(frozen=True, kw_only=True)
class Flow(Kernel):
    """The kernel of a differential equation, and what is known of its coordinates.

    `rates` reads ``state = [q (n), v (n)]`` and writes ``out = [a (n), margin (b), margin_rate (b),
    settled (c), settled_rate (c), cosine (d), sine (d), speed (d), function (m), function_rate
    (m)]``. The c coordinates from `first_carried` on are starting values of an iteration: after a
    step they are replaced by its result. The 3d numbers behind belong to dependent angles whose
    whole turns are counted, the last 2m to switches. Solvers change modes in a copy of the
    parameters.

    `linearise` compiles the derivatives of the accelerations, ``out[2n·i + j] = ∂a_i/∂state_j``,
    followed by 2b + 2c numbers that mean nothing.
    """

    coordinates: int  # number n of free coordinates
    rotates: NDArray[np.bool_]
    margin_scale: NDArray[np.float64]
    least_margin: NDArray[np.float64] | None = None
    first_carried: int = 0
    carried: int = 0
    counted: int = 0  # number d of dependent angles whose whole turns are counted
    linearise: Callable[[], Kernel] | None = None
    switching: Switching | None = None  # modes that change on the way; None if there are none
    # Statements of both functions, for processors of another kind; None if unavailable
    routines: Callable[[], Sequence[Routine]] | None = None
    stiff: bool = False  # whether an oil film bounds the steps of explicit methods
    longest_step: float = math.inf  # seconds

    def __post_init__(self) -> None:
        contiguous = np.ascontiguousarray
        object.__setattr__(self, "parameters", contiguous(self.parameters, dtype=np.float64))
        object.__setattr__(self, "rotates", contiguous(self.rotates, dtype=np.bool_))
        object.__setattr__(self, "margin_scale", contiguous(self.margin_scale, dtype=np.float64))
        object.__setattr__(self, "held", 0 if self.switching is None else self.switching.held)
        if self.least_margin is None:
            object.__setattr__(self, "least_margin", np.full(len(self.margin_scale), LEAST_MARGIN))
        if not (self.clock and self.rates):
            raise ValueError("clock and rates must be addresses of compiled functions, found 0")
        if self.parameters.ndim != 1 or self.margin_scale.ndim != 1:
            raise ValueError("parameters and margin_scale must have one dimension")
        if self.rotates.shape != (self.coordinates,):
            raise ValueError(
                f"rotates must have one entry for each of {self.coordinates} coordinates, "
                f"found shape {self.rotates.shape}"
            )
        if not (self.margin_scale > 0).all():
            raise ValueError(f"margin_scale must be > 0, found {self.margin_scale}")

    @property
    def written(self) -> int:
        """Length of what `rates` writes."""
        pairs = len(self.margin_scale) + self.carried
        return self.coordinates + 2 * (pairs + self.switches) + 3 * self.counted

    @property
    def switches(self) -> int:
        """Number m of switches."""
        return 0 if self.switching is None else len(self.switching.names)

    @property
    def smallest_margins(self) -> NDArray[np.float64]:
        """Margins at which an integration stops, shape (b,)."""
        return np.asarray(self.least_margin) * self.margin_scale


POINTER = ctypes.POINTER(ctypes.c_double)
CLOCK = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_double, POINTER, POINTER)
RATES = ctypes.CFUNCTYPE(ctypes.c_int64, POINTER, POINTER, POINTER, POINTER)


def caller(kernel: Kernel, size: int) -> Callable[[float, NDArray], tuple[int, NDArray]]:
    """A function of time and state that returns the status and `size` numbers of a kernel."""
    clock, rates = CLOCK(kernel.clock), RATES(kernel.rates)
    parameters, timed = kernel.parameters, np.zeros(max(1, kernel.timed_size))

    def evaluate(t: float, y: NDArray) -> tuple[int, NDArray]:
        state, out = np.ascontiguousarray(y, dtype=np.float64), np.zeros(size)
        status = clock(t, _address(parameters), _address(timed))
        if status == 0:
            status = rates(_address(state), _address(parameters), _address(timed), _address(out))
        return status, out

    return evaluate


def _address(array: NDArray) -> Any:
    return array.ctypes.data_as(POINTER)


Floats = NDArray[np.float64]

MOST_DOUBT = 1e-3
"""Part of the shortest tangent that the error of a step may amount to."""

LONGEST = 1e50
"""Length to which a tangent may grow: numbers end at 1e150, which long intervals would reach."""


@dataclass(frozen=True, kw_only=True)
class Renormalisation:
    """Which coordinates of a flow are tangents, and at which samples they are renormalised.

    The last ``columns·size`` coordinates are those of tangents, one after the other. `grown` has
    the logarithms by which they have grown since the last time.
    """

    size: int
    columns: int
    # Of those of a tangent the first ones are lengths themselves; only the rates of the others are
    placed: int
    grown: Floats
    every: int = 1  # they are renormalised at every sample whose number is a multiple of this
    offset: int = 0  # how many samples are taken to be before the first one
    orthogonal: bool = True  # whether tangents are made orthonormal, or only of length one each

    def count(self, samples: int) -> int:
        """How often tangents are renormalised within so many samples."""
        return (samples + self.offset) // self.every

    def _factors(self, tangents: Floats) -> tuple[Floats, Floats]:
        """Logarithms of lengths, and the factor of (2·size, columns) tangents, on the right."""
        upper = np.linalg.qr(tangents)[1]
        grown = upper if self.orthogonal else np.diag(np.linalg.norm(tangents, axis=0))
        taken = np.diag(grown) == 0.0
        grown = grown + np.diag(taken)
        lengths = np.where(taken, -np.inf, np.log(np.abs(np.diag(grown))))
        return lengths, np.linalg.inv(grown)

    def undone(self, samples: Floats, grown: Floats) -> tuple[Floats, Floats, Floats]:
        """What renormalisation gives for (samples, size + placed, columns) tangents that had none.

        Returns logarithms of lengths, shape (times, columns), tangents behind, and what later
        tangents are to be multiplied by.
        """
        lengths, result, factor = [], [], np.eye(self.columns)
        for number, tangents in enumerate(samples, start=self.offset + 1):
            if number % self.every:
                continue
            further, then = self._factors(tangents @ factor)
            lengths.append(grown + further)
            grown[:] = 0.0
            factor = factor @ then
            result.append(tangents @ factor)
        shape = (len(result), *samples.shape[1:])
        return np.reshape(lengths, (-1, self.columns)), np.reshape(result, shape), factor
