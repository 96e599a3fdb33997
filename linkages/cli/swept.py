"""What the verbs that sweep have in common: reasons, contact, Ctrl-C."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from linkages.errors import Interrupted

if TYPE_CHECKING:
    import xarray as xr

    from linkages.chaos.sweep import Progress

_NUMBER = re.compile(r"(?<!\w)[-+−]?\d+(\.\d+)?([eE][-+]?\d+)?")


def failures(data: xr.Dataset) -> dict[str, int]:
    """Reason → how often; of those that differ in numbers only the first stands for all."""
    reasons = [str(reason) for reason in data["reason"].to_numpy().ravel() if reason]
    return counted(reasons)


def counted(texts: Iterable[str]) -> dict[str, int]:
    """Text → how often, the most frequent first; numbers in texts make no difference."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for text in texts:
        kind = _NUMBER.sub("#", text)
        first.setdefault(kind, text)
        counts[kind] += 1
    return {first[kind]: count for kind, count in counts.most_common()}


def failure_notes(failed: dict[str, int], what: str) -> list[str]:
    """A note for each kind of reason."""
    return [f"{count} {what}{'s' * (count > 1)}: {reason}" for reason, count in failed.items()]


def finished(task: Callable[[], xr.Dataset]) -> xr.Dataset:
    """The result of a sweep, or after Ctrl-C what there is of it."""
    try:
        return task()
    except Interrupted as error:
        if not error.kept:  # in the set-up
            raise
        (data,) = error.kept.values()
        return cast("xr.Dataset", data)


def watched(update: Callable[[float], None]) -> Callable[[Progress], None]:
    """Show the progress of a sweep as a fraction."""
    return lambda progress: update(progress.done / progress.total)


def contact_columns(data: xr.Dataset) -> dict[str, Any]:
    """Head → column with an entry for each point, for every clearance."""
    from linkages.chaos.contact_log import CONTACT

    heads = {"contact_lost": "contact lost in {} (share)", "least_force": "least force in {} (N)"}
    return {
        heads[variable].format(name): data[variable].sel(clearance=name).to_numpy().ravel()
        for variable in CONTACT
        if variable in data
        for name in data["clearance"].to_numpy()
    }


def contact_content(data: xr.Dataset) -> list[dict[str, Any]]:
    """Each clearance with the largest share of time without contact, and the least force."""
    if "contact_lost" not in data:
        return []
    lost, force = data["contact_lost"], data["least_force"]
    found = []
    for name in data["clearance"].to_numpy():
        shares = lost.sel(clearance=name).to_numpy()
        checked = bool(np.isfinite(shares).any())
        found.append(
            {
                "clearance": str(name),
                "points": int(np.isfinite(shares).sum()),
                "lost": int((shares > 0).sum()),
                "share_lost": float(np.nanmax(shares)) if checked else None,
                "least_force": float(force.sel(clearance=name).min()) if checked else None,
                "interval": float(lost.attrs["interval"]),
            }
        )
    return found
