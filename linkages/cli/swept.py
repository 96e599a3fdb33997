"""What commands that sweep have in common: reasons, files, Ctrl-C; and contact in clearances."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from linkages.cli.published import EndedError
from linkages.cli.requests import Request
from linkages.cli.terminal import console, print_notes
from linkages.errors import Interrupted

if TYPE_CHECKING:
    import xarray as xr

INTERRUPTED = "interrupted: what was computed up to then is in"
TOO_EARLY = "interrupted before anything was computed"

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


def swept(request: Request, label: str, what: str, task: Callable[..., xr.Dataset]) -> xr.Dataset:
    """What a sweep returns that reports its progress, or after Ctrl-C what there is of it."""
    with request.computing(f"{label} of", f"of {what}s") as update:
        try:
            return task(watch=lambda progress: update(progress.done / progress.total))
        except Interrupted as error:
            if not error.kept:  # in the set-up
                raise
            (data,) = error.kept.values()
            return cast("xr.Dataset", data)


def publish_sweep(
    request: Request,
    data: xr.Dataset,
    what: str,
    save: Callable[[Path], None],
    content: Mapping[str, Any],
    show: Callable[[Sequence[Path]], None],
) -> int:
    """Write the files of a sweep, and report `content` as JSON or show it; returns the exit code.

    `what` is one of its computations in a word.
    """
    interrupted, computed = bool(data.attrs["interrupted"]), any_computed(data)
    if interrupted and not computed:
        raise EndedError(TOO_EARLY)
    with request.publishing(complete=computed, interrupted=interrupted) as place:
        save(place.folder)
    request.report(content, place.files, lambda _: show(place.files))
    if interrupted:
        raise EndedError(f"{INTERRUPTED} {place.files[0].parent}")
    if not computed:
        print(f"no {what} could be computed: {next(iter(failures(data)))}", file=sys.stderr)
    return int(not computed)


def any_computed(data: xr.Dataset) -> bool:
    """Whether a sweep has a result: an indicator, or the first point of a section."""
    if "indicator" in data:
        return bool(np.isfinite(data["indicator"]).any())
    return any(
        bool(np.isfinite(array).any())
        for array in data.data_vars.values()
        if "crossing" in array.dims
    )


def coordinate_head(name: object, array: xr.DataArray) -> str:
    """Head of a column of what is varied."""
    unit = array.attrs.get("units", "")
    return f"{name} ({unit})" if unit else str(name)


def contact_columns(data: xr.Dataset) -> dict[str, Any]:
    """Head → column with an entry for each point, for every clearance."""
    from linkages.chaos.sections.contact_log import CONTACT

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


def close_report(data: xr.Dataset, notes: Sequence[str], files: Sequence[Path]) -> None:
    """The last lines of a report: what is to be known of contact and otherwise, and the files."""
    from linkages.chaos.sections.contact_log import contact_kept, contact_sentences

    screen = console()
    print_notes([*contact_sentences(data), *notes], screen)
    if kept := contact_kept(data):
        screen.print(kept, markup=False)
    screen.print(f"{len(files)} files in {files[0].parent}", markup=False)
