"""What is known of Lyapunov exponents before they are computed, and what was found instead."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Invariant:
    """A combination of exponents whose value is known, all numbers in 1/s.

    Parameters
    ----------
    name
        What it is, such as ``"sum of all exponents"``.
    reason
        Why it is known.
    found, expected
        From the exponents, and what is known.
    tolerance
        How much the two may differ: four standard errors of the difference, or a tenth of the
        largest standard error of the exponents where the two must agree along every motion.
    """

    name: str
    reason: str
    found: float
    expected: float
    tolerance: float

    @property
    def holds(self) -> bool:
        """Whether the two agree within the tolerance."""
        return abs(self.found - self.expected) <= self.tolerance

    @property
    def violation(self) -> str:
        """What is wrong, as a sentence; empty if it holds."""
        if self.holds:
            return ""
        return (
            f"The {self.name} must be {self.expected:.4g} ± {self.tolerance:.2g} 1/s "
            f"({self.reason}), and {self.found:.4g} 1/s was found: the exponents cannot be right. "
            "Take a smaller step or tolerance, or a longer run."
        )

    def to_dict(self) -> dict[str, Any]:
        """As plain data for JSON."""
        return {**asdict(self), "holds": self.holds}
