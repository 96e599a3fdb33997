"""Motions with contact that are known to many digits, each by two independent methods.

tests/data/contact holds nine files: states and events in quadruple precision by extrapolation,
confirmed in double precision by other coordinates and DOP853. Every file holds its definition, its
conventions, and how many digits each state is good for.
"""

import json
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).parents[1] / "data" / "contact"
MOTIONS = ("2-pin-in-hole", "3-pendulum-with-friction", "4-slider-crank-5000rpm",
           "5-engine-crank-pin", "6-free-crank-energy", "7-rigid-pin-in-hole")  # fmt: skip
PIN_RADIUS = {"4-slider-crank-5000rpm": 9.5e-3, "6-free-crank-energy": 8e-3}
"""What the slip of a file without friction counts with: its definition does not need it."""


@cache
def content(name: str) -> dict:
    """A file as it stands."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Reference:
    """A motion with one clearance, called gap."""

    name: str

    @property
    def definition(self) -> str:
        return content(self.name)["definition_in_words_of_a_file"]

    @property
    def states(self) -> list[dict[str, str]]:
        return content(self.name)["states"]

    @property
    def events(self) -> list[dict]:
        return content(self.name)["events"]

    @cached_property
    def times(self) -> np.ndarray:
        return np.array([float(state["t"]) for state in self.states])

    def column(self, *names: str) -> np.ndarray:
        """Numbers of all states, shape (states, names)."""
        return np.array([[float(state[name]) for name in names] for state in self.states])

    @property
    def offset(self) -> np.ndarray:
        return self.column("gap.offset_x", "gap.offset_y")

    @property
    def rate(self) -> np.ndarray:
        return self.column("gap.rate_x", "gap.rate_y")

    def jacobian(self) -> tuple[float, np.ndarray]:
        """Its time, and ∂(offset, rate)/∂(their start)."""
        found = content(self.name)["jacobian"]
        return float(found["T"]), np.array(found["matrix"], dtype=float)


def off(found: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """Largest difference at each time, in parts of the largest value of the run."""
    return np.abs(found - expected).max(axis=1) / np.abs(expected).max()
