"""How many cores this process may use."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path

CGROUPS = Path("/sys/fs/cgroup")
OWN = Path("/proc/self/cgroup")


def available_cores() -> int:
    """Cores by affinity, and by the quota of a container where there is one; at least one."""
    count: Callable[[], int | None] = getattr(os, "process_cpu_count", _by_affinity)  # from 3.13
    allowed, granted = count() or 1, quota()
    return allowed if granted is None else max(1, min(allowed, granted))


def _by_affinity() -> int | None:
    if hasattr(os, "sched_getaffinity"):  # not on macOS and Windows
        return len(os.sched_getaffinity(0))
    return os.cpu_count()


def quota(root: Path = CGROUPS, own: Path = OWN) -> int | None:
    """Cores that control groups grant, rounded up; None where nothing limits them.

    Parameters
    ----------
    root
        Where control groups (version 2) are mounted.
    own
        The file that says in which of them this process is.
    """
    found: list[int] = []
    for folder in _groups(root, own):
        try:
            granted, period = (folder / "cpu.max").read_text(encoding="ascii").split()
        except (OSError, ValueError):
            continue
        if granted != "max":
            found.append(math.ceil(int(granted) / int(period)))
    return min(found, default=None)


def _groups(root: Path, own: Path) -> list[Path]:
    """The group of this process and all that it is part of."""
    try:
        lines = own.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    inner = next((line.removeprefix("0::/") for line in lines if line.startswith("0::")), "")
    group = root / inner
    return [group, *(parent for parent in group.parents if parent.is_relative_to(root))]
