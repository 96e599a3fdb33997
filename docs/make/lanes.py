"""Make the table of docs/kernel.md on lanes.

    python docs/figures_lanes.py

Wall time of an evaluation for one state, of which `tests/benchmarks/lanes.py` takes the least.
"""

from __future__ import annotations

import platform
import sys
from importlib import metadata
from pathlib import Path

from make.accuracy import machine, write_table

sys.path.insert(0, str(Path(__file__).parents[2] / "tests" / "benchmarks"))

import against_heyoka
import lanes

SETS = {"AVX-512": "x86-64-v4", "AVX2": "x86-64-v3"}


def rows() -> list[str]:
    """Nanoseconds, and the ratio of one state alone to the best number of lanes."""
    found = [
        "| | instructions |" + "".join(f" W = {n} |" for n in lanes.LANES) + " best ratio |",
        "|---|---|" + "--:|" * (len(lanes.LANES) + 1),
    ]
    for name, make in lanes.MECHANISMS.items():
        for said, processor in SETS.items():
            with lanes.compiled_for(processor):
                times = lanes.measured(make())
            cells = " | ".join(f"{1e9 * seconds:.0f}" for seconds in times.values())
            ratio = times[1] / min(times.values())
            found.append(f"| {name} | {said} | {cells} | {ratio:.1f} |")
    return found


def main() -> None:
    """Write the table."""
    if platform.machine().lower() not in ("x86_64", "amd64"):
        raise SystemExit("this table compares instruction sets of x86-64; run it on such a machine")
    note = f"Nanoseconds for an evaluation of one state, least of {lanes.ROUNDS}; {machine()}."
    write_table("lanes", "\n".join([*rows(), "", note, "", *heyoka(), ""]))


def heyoka() -> list[str]:
    """Whole motions against those of heyoka's batches."""
    of = against_heyoka
    note = (
        f"Processor time of {of.MOTIONS} motions of the nine-bar over {of.END:g} s, from as many "
        f"states, on one core, at a median error of {of.ERROR:g} rad at the end; least of "
        f"{of.ROUNDS}, in turn; heyoka {metadata.version('heyoka')}, whose batches are compiled "
        "before; lanes include setting motions up in Python."
    )
    return [*of.rows(of.measured()), "", note]


if __name__ == "__main__":
    main()
