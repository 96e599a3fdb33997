"""What a measure may depend on by chance: numbers with tolerances, and pins in holes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.mechanisms.units import unit_at
from linkages.design.tolerances.held import HeldClearance, clearances_of, holding, with_room
from linkages.reading.paths import dotted
from linkages.spec.tolerance_zones import ToleranceZone

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Contributors:
    """What varies from one copy of a mechanism to the next.

    Parameters
    ----------
    mechanism
        As it is defined.
    zones
        Path → zone of its numbers with a tolerance; not those of clearances.
    clearances
        Journals that rest against their bearings, and blocks against the walls of their guides.
    """

    mechanism: Mechanism
    zones: dict[str, ToleranceZone]
    clearances: tuple[HeldClearance, ...]

    @property
    def names(self) -> list[str]:
        """Paths of the definition: numbers, then clearances."""
        return [*self.zones, *(each.path for each in self.clearances)]

    @property
    def units(self) -> list[str]:
        """SI unit of each."""
        own = [unit_at(self.mechanism.definition, path) for path in self.zones]
        return own + ["m"] * len(self.clearances)

    @cached_property
    def nominal(self) -> Mechanism:
        """The mechanism that errors are against: without clearances."""
        return self.mechanism.ideal() if self.clearances else self.mechanism

    @cached_property
    def varied(self) -> Mechanism:
        """The mechanism that is varied."""
        return holding(self.mechanism) if self.clearances else self.mechanism

    @property
    def distributions(self) -> dict[str, str]:
        """Path of `varied` → distribution of its number, in SI."""
        found = {path: distribution(zone) for path, zone in self.zones.items()}
        for each in self.clearances:
            found[each.angle_path] = each.turned
            if each.zone is not None:
                found[each.size_path] = distribution(each.zone)
        return found

    @cached_property
    def middles(self) -> Floats:
        """Means of the numbers less what they are nominally, shape (numbers,)."""
        return np.array([zone.middle - zone.nominal for zone in self.zones.values()])

    @cached_property
    def halves(self) -> Floats:
        """Half of each zone, and the largest size of each clearance, shape (contributors,)."""
        return np.array(
            [
                *(zone.half for zone in self.zones.values()),
                *(each.largest for each in self.clearances),
            ]
        )

    @cached_property
    def deviations(self) -> Floats:
        """Standard deviations; of the displacement along a direction for clearances."""
        zones = [zone.deviation for zone in self.zones.values()]
        return np.array([*zones, *(each.variance**0.5 for each in self.clearances)])

    def overrides(self, offsets: Floats, shifts: Floats) -> dict[str, float]:
        """Numbers of `varied` for some deviations.

        Parameters
        ----------
        offsets
            Of the numbers from what they are nominally, shape (numbers,).
        shifts
            Displacements of the pins in metres, shape (clearances, 2).
        """
        found = {
            path: zone.nominal + float(offset)
            for (path, zone), offset in zip(self.zones.items(), offsets, strict=True)
        }
        for each, (x, y) in zip(self.clearances, shifts, strict=True):
            found[each.size_path] = float(np.hypot(x, y))
            found[each.angle_path] = float(np.arctan2(y, x))
        return found

    def drawn(self, values: dict[str, Floats]) -> tuple[Floats, Floats]:
        """Deviations of draws, as `overrides` takes them, shapes (draws, …).

        Parameters
        ----------
        values
            Path of `varied` → what was drawn, shape (draws,).
        """
        count = len(next(iter(values.values())))
        offsets = [values[path] - zone.nominal for path, zone in self.zones.items()]
        shifts = np.empty((count, len(self.clearances), 2))
        for k, each in enumerate(self.clearances):
            size = values.get(each.size_path, np.full(count, each.size))
            angle = values[each.angle_path]
            shifts[:, k] = np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)
        return np.array(offsets).reshape(len(self.zones), count).T, shifts


def contributors_of(mechanism: Mechanism) -> Contributors:
    """All that varies of a mechanism.

    Raises
    ------
    ValueError
        If nothing does.
    """
    clearances = clearances_of(mechanism)
    sections = [dotted(each.path) for each in with_room(mechanism)]
    zones = {
        path: zone
        for path, zone in mechanism.tolerances.items()
        if not any(path.startswith(f"{section}.") for section in sections)
    }
    if not zones and not clearances:
        raise ValueError(
            "nothing varies: no number of the definition has a tolerance; expected for example "
            "length: 140 ± 0.05 mm, or a clearance"
        )
    return Contributors(mechanism, zones, clearances)


def distribution(zone: ToleranceZone) -> str:
    """A zone in the words of sweeps."""
    match zone.distribution:
        case "normal":
            return f"normal({zone.middle!r}, {zone.deviation!r})"
        case "uniform":
            return f"uniform({zone.low!r}, {zone.high!r})"
        case _:
            return f"triangular({zone.low!r}, {zone.middle!r}, {zone.high!r})"
