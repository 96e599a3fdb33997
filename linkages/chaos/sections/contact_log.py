"""Forces in clearances along a motion that is computed for something else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.chaos.sections.contact import LinkForce, contact_check
from linkages.kernel.outputs import labels, links
from linkages.kernel.system import System
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.motion import Motion, Piece

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

PER_PERIOD = 128
"""Times in a period of the drives at which forces are looked at: below a tenth of the cost of a
motion with a clearance. What is shorter than the time between two of them may be missed."""

MOST_TIMES = 1_000_000
"""Times that are looked at in one motion; they lie further apart in a longer one."""


def check_interval(system: System, span: float = 0.0) -> float | None:
    """Time between two looks at the forces in clearances, in seconds; None without clearances.

    A part of the period of the drives, or the interval of samples of the definition where drives
    have none; longer for a motion over a `span` that would need too many.
    """
    if not links(system.model):
        return None
    try:
        interval = common_period(system.mechanism) / PER_PERIOD
    except NoPeriodError:
        defaults = system.mechanism.simulation
        interval = defaults.end / max(1, defaults.samples - 1)
    return max(interval, span / MOST_TIMES)


class ContactLog:
    """Notes the states of a motion that is integrated part by part, to look at forces later.

    Parameters
    ----------
    interval
        Time between two looks, from `check_interval`.
    """

    def __init__(self, interval: float) -> None:
        self.interval = interval
        self.restart()

    def restart(self, since: float = 0.0) -> None:
        """Forget what was noted; what happens before a time in seconds is left out."""
        self._since = since
        self._pieces: list[Piece] = []

    def looks(self, span: float) -> int:
        """How many looks a time in seconds is worth, at least one."""
        return max(1, round(span / self.interval))

    def note(self, motion: Motion) -> None:
        """Keep the samples of the next part of the motion."""
        first = int(np.searchsorted(motion.time, self._since))
        self._pieces += motion.part(first).pieces

    @property
    def contacts(self) -> tuple[LinkForce, ...]:
        """The check of every clearance; empty for too short a motion."""
        return contacts_in(Motion(pieces=tuple(self._pieces))) if self._pieces else ()


def contacts_in(motion: Motion, places: Any = slice(None)) -> tuple[LinkForce, ...]:
    """The check of every clearance at some samples of a motion; empty for fewer than two.

    The share of time is that of the samples: forces have peaks between two of them, so that lines
    that join them would be positive for too long.
    """
    time = motion.time[places]
    if len(time) < 2:
        return ()
    forces = evaluate_variables(motion, ["clearance_force"])["clearance_force"][places]
    model = motion.pieces[0].system.model
    names, known = links(model), labels(model, "clearance")
    forces = forces[:, [known.index(name) for name in names]]
    return tuple(
        replace(contact_check(name, time, force), share_lost=float((force < 0).mean()))
        for name, force in zip(names, forces.T, strict=True)
    )


def contact_values(contacts: Sequence[LinkForce], names: Sequence[str]) -> dict[str, Floats]:
    """Share of time without contact and least force of some clearances; nan where not checked."""
    by_name: Mapping[str, LinkForce] = {contact.clearance: contact for contact in contacts}
    pairs = [
        (found.share_lost, found.smallest) if (found := by_name.get(name)) else (np.nan, np.nan)
        for name in names
    ]
    shares, forces = np.array(pairs, dtype=float).reshape(len(names), 2).T
    return {"contact_lost": shares, "least_force": forces}


CONTACT = {
    "contact_lost": ("1", "share of time in which the massless link would have to push"),
    "least_force": ("N", "least clearance force"),
}
"""Variable of a dataset → its unit and name."""


def contact_variables(
    values: Mapping[str, Floats], interval: float, dims: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Variables of a dataset, with the time between two looks in their attribute ``interval``."""
    return {
        name: (
            (*dims, "clearance"),
            values[name],
            {"units": units, "long_name": words, "interval": interval},
        )
        for name, (units, words) in CONTACT.items()
    }


def contact_sentences(data: xr.Dataset) -> list[str]:
    """What is to be said of clearances in which a massless link had to push.

    Parameters
    ----------
    data
        With `contact_lost` and `least_force` (…, clearance), as analyses return them.
    """
    found = []
    for name in data["clearance"].to_numpy() if "contact_lost" in data else ():
        shares, forces = (data[each].sel(clearance=name).to_numpy() for each in CONTACT)
        lost, checked = int((shares > 0).sum()), int(np.isfinite(shares).sum())
        if lost:
            up_to = f"at {lost} of {checked} points, for up to " if shares.ndim else "for "
            found.append(
                f"The force in {name} has the wrong sign {up_to}{100 * np.nanmax(shares):.2g} % of "
                f"the time, least {np.nanmin(forces):.4g} N: a real journal would leave "
                "its bearing there, and move otherwise from then on."
            )
    return found


def contact_kept(data: xr.Dataset) -> str:
    """That contact is kept, as far as was looked; empty where it is lost, or can not be."""
    if "contact_lost" not in data:
        return ""
    if not np.isfinite(data["contact_lost"]).any():
        return "contact of journal and bearing was not looked at: the motion was too short"
    if (data["contact_lost"] > 0).any():
        return ""
    interval = data["contact_lost"].attrs["interval"]
    looked = f"looked at every {interval:.3g} s after what is skipped"
    return f"journal and bearing stay in contact: {looked}"
