"""How a motion is integrated, and for how long."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, Self, TypedDict, cast

from linkages.spec.quantities import Duration, Instant, Name, PositiveInteger, Tolerance

FORM = "form"
"""Key of what a text looks like, in the metadata of its field."""

MAX_STEPS = 10**8
"""Default; using them up takes minutes."""


@dataclass(frozen=True, kw_only=True)
class RunOptions:
    """How a motion is integrated.

    Parameters
    ----------
    method
        Name of a solver, or ``auto``, which picks one by the tolerance, and ``radau`` for oil
        films. Not used if nothing is free to move: such a motion is solved without integrating.
    rtol
        Relative tolerance of an adaptive method.
    atol
        Absolute tolerance of an adaptive method, in rad, m, rad/s and m/s. It is `rtol` if not
        given.
    step
        Step of a fixed-step method in seconds.
    max_steps
        Steps after which a run ends; default: 100 million, and 100,000 a period at each point of a
        sweep. Results up to then are kept.
    change_points
        Whether to ``pass`` smoothly through positions from which the mechanism could continue in
        two ways, or to ``stop`` there. By default, motions with a free coordinate other than a
        clearance pass, and those that drives impose stop.
    """

    method: Name = "dop853"
    rtol: Tolerance = 1e-10
    atol: Tolerance | None = None
    step: Duration | None = None
    max_steps: PositiveInteger | None = None
    change_points: Literal["pass", "stop"] | None = None

    @property
    def most_steps(self) -> int:
        """Steps after which a run gives up."""
        return MAX_STEPS if self.max_steps is None else self.max_steps

    @property
    def integration(self) -> dict[str, Any]:
        """Keyword arguments of `linkages.solvers.integrate`."""
        return {
            "method": self.method,
            "rtol": self.rtol,
            "atol": self.atol,
            "step": self.step,
            "max_steps": self.most_steps,
        }

    @property
    def how(self) -> dict[str, Any]:
        """How a motion is integrated, as attributes of a dataset; nan for what is not set."""
        atol = self.rtol if self.atol is None else self.atol
        step = float("nan") if self.step is None else self.step
        return {"method": self.method, "rtol": self.rtol, "atol": atol, "step": step}

    @classmethod
    def like(cls, run: RunOptions, **own: Any) -> Self:
        """Options with the values of others of a common kind."""
        kind = next(base for base in cls.__mro__ if isinstance(run, base))
        shared = fields(cast(type[RunOptions], kind))
        return cls(**{field.name: getattr(run, field.name) for field in shared} | own)

    def left(self, steps: int) -> int:
        """Steps that are left after so many; one at least."""
        return max(1, self.most_steps - steps)


DEFAULTS = RunOptions()


@dataclass(frozen=True, kw_only=True)
class Span:
    """How long a motion is simulated.

    Parameters
    ----------
    end
        Simulated time in seconds, negative to go back in time.
    samples
        Number of equally spaced output times from 0 to `end`, both included.
    """

    end: Instant = 1.0
    samples: PositiveInteger = 1001


@dataclass(frozen=True, kw_only=True)
class SimulationOptions(RunOptions, Span):
    """How a motion is simulated."""


class RunKeywords(TypedDict, total=False):
    """`RunOptions` as keyword arguments; those of the definition file where they are None."""

    method: str | None
    rtol: float | None
    atol: float | None
    step: float | None
    max_steps: int | None
    change_points: str | None


class SimulationKeywords(RunKeywords, total=False):
    """`SimulationOptions` as keyword arguments."""

    end: float | None
    samples: int | None
