"""Mechanisms drawn at random: by hypothesis (they shrink) or from a seed (they are quick)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from absolute_bodies import State
from absolute_coordinates import AbsoluteModel
from decorating_mechanisms import DECORATIONS
from definition_terms import mechanism_of
from growing_mechanisms import Draw, Growing
from growth_chains import CHAINS, crank
from growth_groups import GROUPS
from hypothesis import strategies as st

from linkages import Mechanism

STEPS = (*GROUPS, *CHAINS)


@dataclass(frozen=True)
class Grown:
    """A mechanism, its definition, and where its joints and bodies are at t = 0."""

    definition: dict[str, Any]
    places: dict[str, complex]
    angles: dict[str, float]

    @property
    def mechanism(self) -> Mechanism:
        return mechanism_of(self.definition)

    @property
    def text(self) -> str:
        """The definition as a file."""
        return yaml.safe_dump(plain(self.definition), sort_keys=False, default_flow_style=None)

    def __repr__(self) -> str:
        return f"\n{self.text}"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        """Show failures of hypothesis as files."""
        printer.text(repr(self))

    def start(self, model: AbsoluteModel) -> State:
        """The state at t = 0 in absolute coordinates."""
        places = {joint: np.array([z.real, z.imag]) for joint, z in self.places.items()}
        rates = {name: start.speed for name, start in model.mechanism.initial.items()}
        return model.state(0.0, model.configuration(places, self.angles), rates)


def plain(value: Any) -> Any:
    """Tuples as lists."""
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    return [plain(entry) for entry in value] if isinstance(value, list | tuple) else value


def grown(draw: Draw, most: int, steps: Sequence = STEPS, clearances: float = 0.15) -> Grown:
    """A mechanism of up to `most` steps after its crank."""
    g = Growing(draw, clearances)
    crank(g)
    for _ in range(round(draw.number(0, most))):
        draw.choice(list(steps))(g)
    for decoration in DECORATIONS:
        if g.chance(0.35):
            decoration(g)
    return Grown(g.definition, g.places, g.angles)


class Seeded:
    """Numbers of a random generator."""

    def __init__(self, seed: int) -> None:
        self.generator = np.random.default_rng(seed)

    def number(self, low: float, high: float) -> float:
        return float(self.generator.uniform(low, high))

    def choice(self, options: list) -> Any:
        return options[int(self.generator.integers(len(options)))]


class Drawn:
    """Numbers of hypothesis: hundredths of a range, so that they shrink to short ones."""

    def __init__(self, draw: st.DrawFn) -> None:
        self.draw = draw

    def number(self, low: float, high: float) -> float:
        return round(low + (high - low) * self.draw(st.integers(0, 100)) / 100, 4)

    def choice(self, options: list) -> Any:
        return self.draw(st.sampled_from(options))


def seeded(seed: int, most: int = 6, **how: Any) -> Grown:
    """The mechanism of a seed."""
    return grown(Seeded(seed), most, **how)


@st.composite
def mechanisms(draw: st.DrawFn, most: int = 4, steps: Sequence = STEPS) -> Grown:
    """Strategy of mechanisms."""
    return grown(Drawn(draw), most, steps)
