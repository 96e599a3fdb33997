"""Units that readers want instead of SI: ``mm``, ``deg``, ``rpm``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from linkages.reading.wording import listed
from linkages.spec.units import Unit, UnitError, unit

_NAME = re.compile(r"[^\W\d]+")


@dataclass(frozen=True)
class Wanted:
    """Units in which a table is written.

    Parameters
    ----------
    names
        Of units, one for each thing that is measured. ``mm`` stands for the metre in all units
        (``mm/s``, ``N mm``), ``rpm`` for rad/s alone.

    Raises
    ------
    ValueError
        For what is no unit, and for two units of the same thing.
    """

    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        seen: dict[tuple[tuple[str, float], ...], str] = {}
        for name in self.names:
            try:
                found = unit(name)
            except UnitError as error:
                raise ValueError(f"units: {error}") from None
            if before := seen.get(found.exponents):
                raise ValueError(f"units: {before!r} and {name!r} measure the same")
            seen[found.exponents] = name

    def of(self, si: str) -> tuple[str, float]:
        """The unit that is written for one of SI, and the factor from SI to it."""
        if si in ("", "1"):
            return si, 1.0
        own = unit(si)
        whole = self._like(own)
        name = whole or _NAME.sub(lambda found: self._like(unit(found[0])) or found[0], si)
        return name, 1.0 if name == si else own.scale / unit(name).scale

    def check(self, known: Iterable[str]) -> None:
        """Refuse units that no column has.

        Parameters
        ----------
        known
            Units of SI that columns have.

        Raises
        ------
        ValueError
            Names the units that are there.
        """
        there = [text for text in dict.fromkeys(known) if text not in ("", "1")]
        parts = {part for text in there for part in (text, *_NAME.findall(text))}
        measured = {unit(part).exponents for part in parts}
        for name in self.names:
            if unit(name).exponents not in measured:
                raise ValueError(f"units: no output is measured in {name!r}; found {listed(there)}")

    def _like(self, si: Unit) -> str | None:
        return next((name for name in self.names if unit(name).exponents == si.exponents), None)


def wanted(names: Sequence[str] | str) -> Wanted:
    """Units from a list, or from a text with commas."""
    parts = names.split(",") if isinstance(names, str) else names
    return Wanted(tuple(part.strip() for part in parts))
