"""What a run costs beyond integrating: compiling, starting, memory; in processes of their own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass

_PROGRAM = """
import json, sys, time
begin = time.perf_counter()
from linkages.cli.loading import mechanism_from
from linkages.solution.simulate import simulate
mechanism = mechanism_from(sys.argv[1], sys.argv[2:])
loaded = time.perf_counter()
simulate(mechanism)
first = time.perf_counter()
simulate(mechanism)
again = time.perf_counter()
try:
    import resource
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    peak *= 1 if sys.platform == "darwin" else 1024
except ImportError:
    peak = None
print(json.dumps({"load": loaded - begin, "first": first - loaded, "again": again - first,
                  "peak": peak}))
"""


@dataclass(frozen=True)
class Costs:
    """Seconds and bytes.

    Parameters
    ----------
    compile_seconds
        By how much the first simulation takes longer where nothing is cached.
    warm_start_seconds
        From the start of a process, with everything cached, to the end of the first simulation.
    simulation_seconds
        A simulation in a process that has made one already.
    peak_bytes
        Largest resident memory of a warm process; None where the system does not tell.
    """

    compile_seconds: float
    warm_start_seconds: float
    simulation_seconds: float
    peak_bytes: int | None


def measure_costs(file: str, assignments: Sequence[str]) -> Costs:
    """Simulate a file in fresh processes, first with an empty cache of its own, then warm."""
    with tempfile.TemporaryDirectory(prefix="linkages-") as cache:
        cold = _run(file, assignments, cache)
        warm = _run(file, assignments, cache)
    return Costs(
        compile_seconds=cold["first"] - warm["first"],
        warm_start_seconds=warm["load"] + warm["first"],
        simulation_seconds=warm["again"],
        peak_bytes=warm["peak"],
    )


def _run(file: str, assignments: Sequence[str], cache: str) -> dict:
    environment = {**os.environ, "LINKAGES_CACHE_DIR": cache}
    command = [sys.executable, "-c", _PROGRAM, file, *assignments]
    found = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return json.loads(found.stdout)
