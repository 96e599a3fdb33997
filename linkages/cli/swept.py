"""What commands that sweep have in common: reasons, files, Ctrl-C; and contact in clearances."""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from linkages.chaos.contact_log import TOUCH
from linkages.chaos.free_states import PAIRS
from linkages.cli.published import EndedError
from linkages.cli.requests import File, Request
from linkages.errors import Interrupted
from linkages.reports.report import Notes, Part, Report, headed

if TYPE_CHECKING:
    import xarray as xr

    from linkages.sweeps.running import Progress

INTERRUPTED = "interrupted: results so far are in"
TOO_EARLY = "interrupted before anything was computed"

_NUMBER = re.compile(r"(?<!\w)[-+−]?\d+(\.\d+)?([eE][-+]?\d+)?")


def failures(data: xr.Dataset) -> dict[str, int]:
    """Reason → how often; of those that differ in numbers only the first stands for all."""
    reasons = [str(reason) for reason in data["reason"].to_numpy().ravel() if reason]
    return counted(reasons)


def counted(texts: Iterable[str]) -> dict[str, int]:
    """Text → how often, the most frequent first; numbers in texts make no difference."""
    return counted_texts(Counter(texts))


def counted_texts(texts: Mapping[str, int]) -> dict[str, int]:
    """The same of texts that have been counted one by one."""
    first: dict[str, str] = {}
    counts: Counter[str] = Counter()
    for text, count in texts.items():
        kind = _NUMBER.sub("#", text)
        first.setdefault(kind, text)
        counts[kind] += count
    return {first[kind]: count for kind, count in counts.most_common()}


def failure_notes(failed: dict[str, int], what: str) -> list[str]:
    """A note for each kind of reason."""
    return [f"{count} {what}{'s' * (count > 1)}: {reason}" for reason, count in failed.items()]


def result(request: Request, label: str, what: str, task: Callable[..., xr.Dataset]) -> xr.Dataset:
    """What a sweep returns that reports its progress, or after Ctrl-C what there is of it."""
    with request.computing(f"{label} of", f"of {what}s") as update:
        try:
            return task(watch=lambda found: update(found.done / found.total, _words(found)))
        except Interrupted as error:
            if not error.kept:  # in the set-up
                raise
            (data,) = error.kept.values()
            return cast("xr.Dataset", data)


def _words(found: Progress) -> str:
    """How fast a sweep is, and what failed so far."""
    failed = [f"{count} {word.replace('_', ' ')}" for word, count in found.failures.items()]
    done = f"{int(found.done)} of {found.total}"
    return ", ".join([done, f"{found.rate:.2g} per second", *failed])


def publish(
    request: Request,
    report: Report,
    data: xr.Dataset,
    what: str,
    files: Iterable[File],
    figures: Callable[[], Iterator[File]],
    store: Path | None = None,
) -> int:
    """Write the files of a sweep, and report what was found; returns the exit code.

    `what` is one of its computations in a word; `store` is where they are kept as they come.
    """
    interrupted, computed = bool(data.attrs["interrupted"]), any_computed(data)
    if interrupted and not computed:
        raise EndedError(TOO_EARLY)
    on = "" if store is None else f"\nthe same command continues with the results in {store}"
    made = chain(files, figures() if request.figures else ())
    written = request.write(made, complete=computed, interrupted=interrupted)
    request.report(report, written)
    if interrupted:
        raise EndedError(f"{INTERRUPTED} {written[0].parent}{on}")
    if not computed:
        print(f"no {what} could be computed: {next(iter(failures(data)))}", file=sys.stderr)
    return int(not computed)


def numbered(stem: str, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """A file for each name; it has a number if there are several."""
    for index, name in enumerate(names, 1):
        yield stem if len(names) == 1 else f"{stem}_{index}", name


def any_computed(data: xr.Dataset) -> bool:
    """Whether a sweep has a result: an indicator, or the first point of a section."""
    if "outcome" in data:
        return bool((data["outcome"] == 0).any())
    if "indicator" in data:
        return bool(np.isfinite(data["indicator"]).any())
    return any(
        bool(np.isfinite(array).any())
        for array in data.data_vars.values()
        if "crossing" in array.dims
    )


def free_columns(data: xr.Dataset) -> dict[str, Any]:
    """Head → series of free coordinates, rates and touches, flattened over all other dimensions."""
    columns: dict[str, Any] = {}
    for name, array in data.data_vars.items():
        dim = str(array.dims[-1])
        if "crossing" not in array.dims or dim not in (*PAIRS, TOUCH):
            continue
        for element in data[dim].values:
            series = array.sel({dim: element}).to_numpy().ravel()
            columns[f"{name}[{element}] ({array.attrs['units']})"] = series
    return columns


def varied_columns(data: xr.Dataset, *dims: str) -> dict[str, xr.DataArray]:
    """Head → values of everything that is varied along some dimensions."""
    return {
        headed(name, array.attrs.get("units")): array
        for name, array in data.coords.items()
        if len(array.dims) == 1 and array.dims[0] in dims and name not in dims
    }


def contact_columns(data: xr.Dataset) -> dict[str, xr.DataArray]:
    """Head → what was seen of contact in every clearance."""
    heads = {"contact_lost": "contact lost in {} (share)", "least_force": "least force in {} (N)"}
    return {
        heads[variable].format(name): data[variable].sel(clearance=name)
        for variable in heads
        if variable in data
        for name in data["clearance"].to_numpy()
    }


def failure_columns(data: xr.Dataset) -> dict[str, xr.DataArray]:
    """Head → why there is no result, and when the motion stopped."""
    return {"reason": data["reason"], "stopped (s)": data["stop_time"]}


def flattened(columns: Mapping[str, xr.DataArray], like: xr.DataArray) -> dict[str, np.ndarray]:
    """Columns with a row for each entry of an array."""
    return {
        head: array.broadcast_like(like).transpose(*like.dims).to_numpy().ravel()
        for head, array in columns.items()
    }


def contact_content(data: xr.Dataset) -> list[dict[str, Any]]:
    """Each clearance with the largest share of time without contact, and the least force."""
    if "contact_lost" not in data:
        return []
    lost, force = data["contact_lost"], data["least_force"]
    result = []
    for name in data["clearance"].to_numpy():
        shares = lost.sel(clearance=name).to_numpy()
        checked = bool(np.isfinite(shares).any())
        result.append(
            {
                "clearance": str(name),
                "points": int(np.isfinite(shares).sum()),
                "lost": int((shares > 0).sum()),
                "share_lost": float(np.nanmax(shares)) if checked else None,
                "least_force": float(force.sel(clearance=name).min()) if checked else None,
                "interval": float(lost.attrs["interval"]),
            }
        )
    return result


def outcomes(data: xr.Dataset) -> tuple[xr.DataArray, dict[str, int]]:
    """What became of each point in a word, and word → how often."""
    codes = data["outcome"]
    words = np.array(str(codes.attrs["flag_meanings"]).split(), dtype=object)
    counts = np.bincount(codes.to_numpy().ravel(), minlength=len(words))
    result = {word: int(count) for word, count in zip(words, counts, strict=True) if count}
    return codes.copy(data=words[codes.to_numpy()]), result


def finite_range(values: np.ndarray) -> dict[str, float | None]:
    """``least`` and ``greatest`` of what is finite; None if nothing is."""
    finite = values[np.isfinite(values)]
    least, greatest = (finite.min(), finite.max()) if finite.size else (np.nan, np.nan)
    return {"least": known(least), "greatest": known(greatest)}


def known(value: float) -> float | None:
    """A number, or None if it is not finite."""
    return float(value) if np.isfinite(value) else None


def remarks(data: xr.Dataset, notes: Sequence[str]) -> list[Part]:
    """The last lines of a report: what is to be known of contact, and otherwise."""
    from linkages.chaos.contact_log import contact_kept, contact_sentences

    kept = contact_kept(data)
    return [Notes([*contact_sentences(data), *notes]), *([kept] if kept else [])]
