"""Archard's law of wear: keys of surfaces that wear, and published coefficients of material pairs.

A surface loses the volume V = (k/H) ∫ F |v| dt under a normal force F that slips with v [1]_. The
factor 1/3 that some write besides k is part of k here.

References
----------
.. [1] J. F. Archard, "Contact and rubbing of flat surfaces", J. Appl. Phys. 24 (1953) 981-988.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar

from pydantic import ConfigDict
from pydantic.dataclasses import dataclass as validated_dataclass

from linkages.components.contributed.terms import Parameter
from linkages.spec.quantities import LawName, PositiveNumber, PositivePressure, Quantity
from linkages.spec.units import Bound, Dimension

WEAR_RATE = Dimension("wear rate", "m**2/N", "m²/N")
WearRate = Annotated[float, Quantity(WEAR_RATE, Bound.POSITIVE)]

_HIRST = "J. F. Archard, W. Hirst, Proc. R. Soc. A 236 (1956) 397, unlubricated, 1.8 m/s"


@dataclass(frozen=True)
class WearPair:
    """A material with what it slides on."""

    name: str  # value of the key `pair`
    coefficient: float  # Archard's dimensionless k of that material
    source: str = _HIRST  # where it was published


PAIRS = {
    pair.name: pair
    for pair in (
        WearPair("mild-steel-on-mild-steel", 7e-3),
        WearPair("brass-on-tool-steel", 6e-4),
        WearPair("hard-tool-steel-on-tool-steel", 1.3e-4),
        WearPair("beryllium-copper-on-tool-steel", 3.7e-5),
        WearPair("ptfe-on-tool-steel", 2.5e-5),
        WearPair("stainless-steel-on-tool-steel", 1.7e-5),
        WearPair("pmma-on-tool-steel", 7e-6),
        WearPair("polyethylene-on-tool-steel", 1.3e-7),
    )
}

PairName = Annotated[str, LawName(lambda: PAIRS, "a pair of materials")]
Uncertainty = Annotated[float, Quantity(Dimension("factor"), Bound.POSITIVE)]

USUAL_UNCERTAINTY = 5.0
"""Factor between which and its inverse 95 of 100 wear rates are, where nothing else is said:
published ones of one pair differ by factors of 2 to 10."""

_nested = validated_dataclass(frozen=True, kw_only=True, config=ConfigDict(extra="forbid"))


@_nested
class WornSurface:
    """How fast a surface wears: its wear rate, or a coefficient over its hardness.

    Parameters
    ----------
    wear_rate
        k/H in m²/N, which is 1e9 mm³/(N m).
    coefficient
        Archard's dimensionless k.
    hardness
        H of the surface in Pa.
    pair
        A pair of materials, in the place of the coefficient.
    """

    wear_rate: WearRate | None = None
    coefficient: PositiveNumber | None = None
    hardness: PositivePressure | None = None
    pair: PairName | None = None

    @property
    def rate(self) -> float:
        """k/H in m²/N; 1 where `problems` says that something is missing."""
        if self.wear_rate is not None:
            return self.wear_rate
        k = self.coefficient if self.pair is None else PAIRS[self.pair].coefficient
        return 1.0 if k is None or self.hardness is None else k / self.hardness

    def problems(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Keys at fault with sentences."""
        given = [key for key in ("wear_rate", "coefficient", "pair") if getattr(self, key)]
        if len(given) != 1:
            found = " and ".join(repr(key) for key in given) or "none"
            expected = "expected one of 'wear_rate', 'coefficient' and 'pair'"
            yield (), f"{expected}, found {found}"
        elif given == ["wear_rate"] and self.hardness is not None:
            yield ("hardness",), "the wear rate is k/H already; expected no hardness beside it"
        elif given != ["wear_rate"] and self.hardness is None:
            yield (), "missing key 'hardness': the wear rate is k/H"


class Wearing:
    """What wear of a journal and its bearing, and of a block and its guide have in common."""

    sides: ClassVar[tuple[str, str]]
    uncertainty: float

    @property
    def surfaces(self) -> dict[str, WornSurface | None]:
        """Key → surface, that of the journal or block first."""
        return {side: getattr(self, side) for side in self.sides}

    @property
    def rates(self) -> tuple[float, float]:
        """k/H of both sides in m²/N; 0 for one that does not wear."""
        first, second = self.surfaces.values()
        return (0.0 if first is None else first.rate, 0.0 if second is None else second.rate)

    def problems(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Keys at fault with sentences."""
        if not any(self.surfaces.values()):
            yield (), f"nothing wears; expected {' or '.join(map(repr, self.surfaces))}"
        for name, surface in self.surfaces.items():
            for key, message in () if surface is None else surface.problems():
                yield (name, *key), message
        if self.uncertainty < 1.0:
            message = f"expected a factor of at least 1, found {self.uncertainty:g}"
            yield ("uncertainty",), message

    def faults_of(self, entry: object, *needed: str) -> Iterator[tuple[tuple[str, ...], str]]:
        """Steps from an entry that wears to keys at fault, with sentences; it needs some keys."""
        for key, message in self.problems():
            yield ("wear", *key), message
        for name in needed:
            if getattr(entry, name) is None:
                yield (), f"missing key {name!r}: wear is spread over it"


@_nested
class JournalWear(Wearing):
    """How journal and bearing wear.

    Parameters
    ----------
    journal, bearing
        How fast each of them wears; one that is not given does not.
    uncertainty
        Factor u of both wear rates: 95 of 100 are between 1/u and u times what is given.
    """

    sides: ClassVar[tuple[str, str]] = ("journal", "bearing")

    journal: WornSurface | None = None
    bearing: WornSurface | None = None
    uncertainty: Uncertainty = USUAL_UNCERTAINTY


@_nested
class GuideWear(Wearing):
    """How a block and its guide wear.

    Parameters
    ----------
    block, guide
        How fast each of them wears; one that is not given does not.
    uncertainty
        Factor u of both wear rates: 95 of 100 are between 1/u and u times what is given.
    """

    sides: ClassVar[tuple[str, str]] = ("block", "guide")

    block: WornSurface | None = None
    guide: WornSurface | None = None
    uncertainty: Uncertainty = USUAL_UNCERTAINTY


@dataclass(frozen=True)
class Rubbing:
    """That the two sides of a clearance rub, where work and distance of their slip are wanted."""

    area: Parameter  # over which the pressure is the normal force (m²)
    # Of the journal (m); not that of a corner, whose gap has all that its slip needs
    radius: Parameter | None = None
    hole: bool = True  # whether the displaced body has the bearing
