"""Forces in clearances along a motion that is computed for something else."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.sections.common_period import NoPeriodError, common_period
from linkages.chaos.sections.contact import LinkForce, contact_check
from linkages.kernel.outputs import labels, links
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.moving.evaluation import evaluate_variables
from linkages.solution.moving.march import compute_motion
from linkages.solution.moving.motion import Motion, Settings

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

PER_PERIOD = 128
"""Least number of looks at forces in a period of the drives: below a tenth of the cost of a motion
with a clearance."""

STEPS_PER_LOOK = 4.0
"""Steps between two looks where these follow a motion: at usual tolerances methods take twelve
steps or more per oscillation."""

RESOLVED = 6.0
"""Steps between two looks up to which oscillations are seen. Beyond, reports say that contact may
be lost in between."""

MOST_TIMES = 1_000_000
"""Times that are looked at in one motion; they lie further apart in a longer one."""


def check_interval(
    system: System, span: float = 0.0, run: RunOptions | None = None
) -> float | None:
    """Time between two looks at the forces in clearances, in seconds; None without clearances.

    A part of the period of the drives, or the interval of samples of the definition where drives
    have none; longer for a motion over a `span` that would need too many. With options of a `run`,
    short enough for the oscillations of the motion.
    """
    if not links(system.model):
        return None
    try:
        lasting, parts = common_period(system.mechanism), PER_PERIOD
    except NoPeriodError:
        defaults = system.mechanism.simulation
        lasting, parts = abs(defaults.end), max(1, defaults.samples - 1)
    if run is not None:
        parts = looks_in(system, run, lasting, parts)
    return max(lasting / parts, span / MOST_TIMES)


def looks_in(system: System, run: RunOptions, lasting: float, fewest: int = PER_PERIOD) -> int:
    """Looks in a time in seconds that follow the oscillations of a motion.

    As many times the fewest, a power of two, as the steps of a motion that lasts as long need.
    """
    times = system.time + np.array([lasting])
    motion = compute_motion(system, Settings(times=times, run=run))
    reached = (motion.time[-1] if len(motion.time) else motion.stop_time) or lasting
    steps = motion.cost.get("steps", 0) * lasting / abs(reached - system.time or lasting)
    return int(fewest * 2 ** max(0, math.ceil(math.log2(max(1, steps) / STEPS_PER_LOOK / fewest))))


class ContactLog:
    """Looks at the forces of a motion that is integrated part by part.

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
        self._looked: list[tuple[Floats, Floats]] = []
        self._names: Sequence[str] = ()
        self._begun, self._rate = math.nan, 0.0

    def looks(self, span: float) -> int:
        """How many looks a time in seconds is worth, at least one."""
        return max(1, round(span / self.interval))

    def note(self, motion: Motion) -> None:
        """Look at the samples of the next part of the motion."""
        if not len(motion.time):
            return
        if math.isnan(self._begun):
            self._begun = float(motion.time[0])
        if (lasted := float(motion.time[-1]) - self._begun) > 0.0:
            self._rate = motion.cost.get("steps", 0) / lasted
        first = int(np.searchsorted(motion.time, self._since))
        if first < len(motion.time):
            self._names = links(motion.pieces[0].system.model)
            self._looked.append(_forces(motion.part(first), self._names))

    @property
    def contacts(self) -> tuple[LinkForce, ...]:
        """The check of every clearance; empty for too short a motion."""
        if not self._looked:
            return ()
        times, forces = zip(*self._looked, strict=True)
        return _contacts(np.concatenate(times), np.concatenate(forces), self._names, self._rate)


def contacts_in(motion: Motion, rate: float, places: Any = slice(None)) -> tuple[LinkForce, ...]:
    """The check of every clearance at some samples of a motion; empty for fewer than two.

    `rate` is how many steps the integration took per second.

    The share of time is that of the samples: forces have peaks between two of them, so that lines
    that join them would be positive for too long.
    """
    names = links(motion.pieces[0].system.model)
    time, forces = _forces(motion, names)
    return _contacts(time[places], forces[places], names, rate)


def _forces(motion: Motion, names: Sequence[str]) -> tuple[Floats, Floats]:
    """Times of the samples, and the forces in clearances there, shape (samples, clearances)."""
    found = evaluate_variables(motion, ["clearance_force"])["clearance_force"]
    known = labels(motion.pieces[0].system.model, "clearance")
    return motion.time, found[:, [known.index(name) for name in names]]


def _contacts(
    time: Floats, forces: Floats, names: Sequence[str], rate: float
) -> tuple[LinkForce, ...]:
    if len(time) < 2:
        return ()
    return tuple(
        replace(
            contact_check(name, time, force),
            share_lost=float((force < 0).mean()),
            steps=rate * float(time[-1] - time[0]) / (len(time) - 1),
        )
        for name, force in zip(names, forces.T, strict=True)
    )


def contact_values(contacts: Sequence[LinkForce], names: Sequence[str]) -> dict[str, Floats]:
    """Variables of `CONTACT` for some clearances; nan where not checked."""
    by_name: Mapping[str, LinkForce] = {contact.clearance: contact for contact in contacts}
    rows = [
        (found.share_lost, found.smallest, found.least_time, found.steps)
        if (found := by_name.get(name))
        else (np.nan,) * len(CONTACT)
        for name in names
    ]
    table = np.array(rows, dtype=float).reshape(len(names), len(CONTACT))
    return dict(zip(CONTACT, table.T, strict=True))


CONTACT = {
    "contact_lost": ("1", "share of time in which the massless link would have to push"),
    "least_force": ("N", "least clearance force, of those that were looked at"),
    "least_force_time": ("s", "time of the least clearance force"),
    "steps_per_look": ("1", "steps of the integration between two looks at the force"),
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
        shares, forces = (
            data[each].sel(clearance=name).to_numpy() for each in ("contact_lost", "least_force")
        )
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
    steps, least = float(data["steps_per_look"].max()), _least(data)
    if steps > RESOLVED:
        return (
            f"journal and bearing are in contact where the force was {looked}, {least};"
            f" the motion takes {steps:.2g} steps between two looks, so contact may be lost in "
            "between: simulate follows every oscillation"
        )
    return f"journal and bearing stay in contact: {least}, {looked}"


def _least(data: xr.Dataset) -> str:
    """The least force that was found, its clearance and, of a single motion, its time."""
    forces = data["least_force"].min(
        [dim for dim in data["least_force"].dims if dim != "clearance"]
    )
    name = str(data["clearance"].to_numpy()[np.nanargmin(forces)])
    text = f"least force {float(forces.min()):.4g} N in {name}"
    if data["least_force"].ndim > 1:
        return text
    return f"{text} at t = {float(data['least_force_time'].sel(clearance=name)):.4g} s"
