"""Forces in clearances along a motion, loss of contact, and impacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.kernel.outputs import labels, links
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.evaluation import evaluate_nodes, evaluate_variables
from linkages.solution.guards import Surface
from linkages.solution.march import compute_motion
from linkages.solution.motion import Motion, Piece, Settings
from linkages.solution.series import system_series

if TYPE_CHECKING:
    import xarray as xr

    from linkages.solution.solution import Solution

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LinkForce:
    """The force along a clearance link over time.

    A journal in a bearing can be pulled away from the bearing's centre only as far as the clearance
    goes: it presses outward, which is tension in the link. Where the model asks for compression, a
    real journal would leave the bearing and fly, until it hits it again.

    `smallest`, `largest`: extreme forces in newtons, tension positive.
    `steps`: steps of the integration between two looks, on average. Methods take many steps per
    oscillation: with too many, oscillations between two looks are not seen.
    """

    clearance: str  # its name
    share_lost: float  # part of the time in which the link is compressed
    # First time of that in seconds, linearly interpolated; None if there is none
    first_loss: float | None
    smallest: float
    largest: float
    least_time: float  # when the smallest was found, in seconds
    steps: float = 0.0

    @property
    def sentence(self) -> str:
        """What it means; empty where contact is never lost."""
        if self.first_loss is None:
            return ""
        return (
            f"The force in {self.clearance} has the wrong sign for {100 * self.share_lost:.2g} % "
            f"of the time, first at t = {self.first_loss:.4g} s: a real journal would leave "
            "its bearing there, and move otherwise from then on."
        )


def contact_check(clearance: str, time: ArrayLike, force: ArrayLike) -> LinkForce:
    """Check a clearance force, shape (samples,), in newtons at times in seconds."""
    t, f = np.asarray(time, dtype=float), np.asarray(force, dtype=float)
    if t.shape != f.shape or t.ndim != 1 or t.size < 2:
        raise ValueError("time and force need equally many samples, at least two")
    spans = lost_spans(t, f)
    share = sum(end - begin for begin, end in spans) / float(t[-1] - t[0])
    first = spans[0][0] if spans else None
    least = float(t[np.argmin(f)])
    return LinkForce(clearance, share, first, float(f.min()), float(f.max()), least)


def lost_spans(time: Floats, force: Floats) -> list[tuple[float, float]]:
    """Beginning and end of each span of negative force, with zeros between samples by line."""
    lost = force < 0
    edges = np.flatnonzero(np.diff(lost.astype(np.int8)))
    marks = [_zero(time, force, int(edge)) for edge in edges]
    marks = [float(time[0])] * bool(lost[0]) + marks + [float(time[-1])] * bool(lost[-1])
    return list(zip(marks[::2], marks[1::2], strict=True))


def _zero(time: Floats, force: Floats, index: int) -> float:
    before, after = force[index], force[index + 1]
    share = before / (before - after) if np.isfinite(before - after) else 0.5
    return float(time[index] + share * (time[index + 1] - time[index]))


def force_of(solution: Solution) -> xr.DataArray | None:
    """Clearance forces that a solution has, (time, clearance), wherever its samples are."""
    if "clearance_force" not in solution.data or solution.data.sizes["time"] < 2:
        return None
    return solution.dense(["clearance_force"])["clearance_force"]


def contact_of(solution: Solution) -> tuple[LinkForce, ...]:
    """The check of every massless link."""
    massless = links(solution.system.model)
    if "clearance_force" not in solution.arrays.variables or len(solution.time) < 2 or not massless:
        return ()
    time, rows = solution.closely.time, solution.closely.values("clearance_force")
    names = labels(solution.system.model, "clearance")
    return tuple(contact_check(name, time, rows[:, names.index(name)]) for name in massless)


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

    `interval`: time between two looks, from `check_interval`.
    """

    @classmethod
    def of(
        cls, system: System, span: float = 0.0, run: RunOptions | None = None
    ) -> ContactLog | None:
        """What looks as `check_interval` says; None without clearances."""
        interval = check_interval(system, span, run)
        return None if interval is None else cls(interval)

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
    result = evaluate_variables(motion, ["clearance_force"])["clearance_force"]
    known = labels(motion.pieces[0].system.model, "clearance")
    return motion.time, result[:, [known.index(name) for name in names]]


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
        (result.share_lost, result.smallest, result.least_time, result.steps)
        if (result := by_name.get(name))
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
    """What is to be said of clearances in which a massless link had to push."""
    result = []
    for name in data["clearance"].to_numpy() if "contact_lost" in data else ():
        shares, forces = (
            data[each].sel(clearance=name).to_numpy() for each in ("contact_lost", "least_force")
        )
        lost, checked = int((shares > 0).sum()), int(np.isfinite(shares).sum())
        if lost:
            up_to = f"at {lost} of {checked} points, for up to " if shares.ndim else "for "
            result.append(
                f"The force in {name} has the wrong sign {up_to}{100 * np.nanmax(shares):.2g} % of "
                f"the time, least {np.nanmin(forces):.4g} N: a real journal would leave "
                "its bearing there, and move otherwise from then on."
            )
    return result


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


TOUCH = "touch"
"""Dimension of what is known of touches: the clearance, or the end of a way."""

VARIABLES = {
    "touch_phase": ("", "part of the period of the drives"),
    "touch_direction": (
        "rad",
        "direction of the touch, from the centre of bearing, pin or round",
    ),
    "touch_rate": ("m/s", "rate of the indentation"),
}
"""Name → unit and what it is, over crossings and clearances."""


def touch_values(system: System, motion: Motion, surface: Surface) -> dict[str, Floats]:
    """What is known of touches, shape (crossings, 1) each; nothing of other sections.

    Without a common period of the drives there is no phase, without an offset no direction. Rates
    at stops are those before an impact.
    """
    if not surface.touch:
        return {}
    known = system_series(system)

    def along(quantity: str) -> Floats | None:
        series = known.get(f"{surface.touch}.{quantity}")
        if series is None:
            return None
        return _evaluated(motion, lambda piece: series.node(piece.system.model))

    rate, x, y = along("indentation rate"), along("x offset"), along("y offset")
    if surface.end:
        rate = _evaluated(motion, lambda piece: surface.nodes(piece.system.model)[1])
    result = {
        "touch_phase": _phase(system, motion),
        "touch_direction": None if x is None or y is None else np.arctan2(y, x),
        "touch_rate": rate,
    }
    return {name: values[:, None] for name, values in result.items() if values is not None}


def touch_variables(
    values: Mapping[str, Floats], section: str, dims: tuple[str, ...] = ("crossing",)
) -> dict[str, Any]:
    """Those of `values` that are about touches, as variables of a dataset."""
    import xarray as xr

    name = section.strip().rpartition(".")[0]
    return {
        variable: xr.DataArray(
            values[variable],
            dims=(*dims, TOUCH),
            coords={TOUCH: np.array([name], dtype=object)},
            attrs={"units": unit, "long_name": text},
        )
        for variable, (unit, text) in VARIABLES.items()
        if variable in values
    }


def _evaluated(motion: Motion, node: Callable[[Piece], Scalar]) -> Floats:
    return np.concatenate([evaluate_nodes(piece, [node(piece)])[0] for piece in motion.pieces])


def _phase(system: System, motion: Motion) -> Floats | None:
    try:
        period = common_period(system.mechanism)
    except NoPeriodError:
        return None
    return np.asarray(motion.time / period % 1.0)
