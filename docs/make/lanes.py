"""The tables of docs/kernel.md on lanes.

Wall time of an evaluation for one state, of which `tests/benchmarks/lanes.py` takes the least.
"""

from __future__ import annotations

import platform
from importlib import metadata

from make.registry import machine, makes, table

SETS = {"AVX-512": "x86-64-v4", "AVX2": "x86-64-v3"}


@makes("lanes")
def both() -> str:
    """Nanoseconds, and the ratio of one state alone to the best number of lanes; whole motions."""
    import lanes  # of the tests

    if platform.machine().lower() not in ("x86_64", "amd64"):
        raise SystemExit("this table compares instruction sets of x86-64; run it on such a machine")
    found = []
    for name, make in lanes.MECHANISMS.items():
        for said, processor in SETS.items():
            with lanes.compiled_for(processor):
                times = lanes.measured(make())
            ratio = times[1] / min(times.values())
            cells = (f"{1e9 * seconds:.0f}" for seconds in times.values())
            found.append((name, said, *cells, f"{ratio:.1f}"))
    heads = "", "instructions", *(f"W = {n}" for n in lanes.LANES), "best ratio"
    note = f"Nanoseconds for an evaluation of one state, least of {lanes.ROUNDS}; {machine()}."
    return f"{table(heads, found, 2)}\n{note}\n\n{heyoka()}\n"


def heyoka() -> str:
    """Whole motions against those of heyoka's batches."""
    import against_heyoka as of  # of the tests

    note = (
        f"Processor time of {of.MOTIONS} motions of the nine-bar over {of.END:g} s, from as many "
        f"states, on one core, at a median error of {of.ERROR:g} rad at the end; least of "
        f"{of.ROUNDS}, in turn; heyoka {metadata.version('heyoka')}, whose batches are compiled "
        "before; lanes include setting motions up in Python."
    )
    return "\n".join([*of.rows(of.measured()), "", note])
