"""The tables of docs/skipping.md.

Operations are counted; times are the least of many rounds in which all cases take turns (whatever
else a machine does only adds to them), as ratios, because they depend on the machine.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

import linkages
from linkages.benchmark.problem import seconds_per_evaluation
from linkages.kernel.code.program import report_kernel
from linkages.kernel.layout import Layout
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.scalars import Level, reachable
from linkages.kernel.system import System
from linkages.solution.evaluation import evaluate_variables
from linkages.solution.joint_reactions import reactions
from linkages.solution.plan import build_flow, kernel_source
from make.registry import machine, makes, table

ROUNDS = 101
LIGHT = {
    f"bars.{name}.{key}": 0 for name in ("link2", "link7", "link8") for key in ("mass", "inertia")
}
LOADED = {"loads": [{"slider": "slider9", "force": -100.0}]}
CASES: dict[str, tuple[str, dict[str, object], bool]] = {
    "as shipped": ("ninebar", {}, False),
    "a force on the slider": ("ninebar", LOADED, False),
    "no gravity": ("ninebar", {"gravity": [0, 0]}, False),
    "links 2, 7 and 8 without mass": ("ninebar", LIGHT, False),
    "both": ("ninebar", {"gravity": [0, 0], **LIGHT}, False),
    "`energy_residual` asked for": ("ninebar", {}, True),
    "no clearance": ("ninebar-ideal", {}, False),
}
REQUESTS: dict[str, Sequence[str]] = {
    "`clearance_angle`": ["clearance_angle"],
    "`slider_position`": ["slider_position"],
    "`clearance_force`": ["clearance_force"],
    "`drive_effort`": ["drive_effort"],
    "`closure_residual`": ["closure_residual"],
    "`kinetic_energy`, `potential_energy`": ["kinetic_energy", "potential_energy"],
    "default": [n for n, found in VARIABLES.items() if found.default and not found.whole],
    "all": [n for n, found in VARIABLES.items() if not found.whole],
}


@makes("kernel-parts")
def kernels() -> str:
    """What an evaluation costs in each case."""
    systems = {
        name: System(linkages.load(file, set=given)) for name, (file, given, _) in CASES.items()
    }
    moving = {name: system for name, system in systems.items() if system.topology.free}
    flows = {name: build_flow(system, CASES[name][2]) for name, system in moving.items()}
    rounds: dict[str, list[float]] = {name: [] for name in flows}
    for _ in range(ROUNDS):
        for name, flow in flows.items():
            state = np.zeros(2 * flow.coordinates)
            rounds[name].append(seconds_per_evaluation(flow, state, repeats=1))
    full = min(rounds["as shipped"])
    heads = ("nine-bar", "once per run", "once per distinct time", "once per state",
             "of these divisions, roots, trigonometric calls", "time per evaluation")  # fmt: skip
    lines = []
    for name in CASES:
        if name not in moving:
            lines.append((name, *"––––", "no kernel, nothing is integrated"))
            continue
        topology = moving[name].topology
        source = kernel_source(topology, Layout.of(topology, CASES[name][2]))
        parts = [*report_kernel(source.model, source.program).counts.values()]
        sums = [sum(part.values()) for part in parts]
        costly = [parts[-1][kind] for kind in ("divisions", "square roots", "trigonometric calls")]
        ratio = min(rounds[name]) / full
        lines.append((name, *sums[:3], ", ".join(map(str, costly)), f"{ratio:.2f}"))
    note = (
        f"Times: least of {ROUNDS} rounds, {1e9 * full:.0f} ns for the nine-bar as "
        f"shipped; {machine()}."
    )
    return f"{table(heads, lines)}\n{note}\n"


@makes("output-parts")
def outputs() -> str:
    """What is evaluated per sample for each request."""
    solution = linkages.simulate(linkages.load("ninebar"), outputs=["clearance_angle"])
    system, motion = solution.system, solution.motion
    cases = {name: _evaluation(motion, names) for name, names in REQUESTS.items()}
    rounds: dict[str, list[float]] = {name: [] for name in [*cases, "`joint_reaction`"]}
    for _ in range(ROUNDS):
        for name, action in [*cases.items()]:
            rounds[name].append(_seconds(action))
        rounds["`joint_reaction`"].append(_seconds(lambda: reactions(motion)))
    full = min(rounds["default"])
    lines = []
    for name, times in rounds.items():
        count = "a linear system" if name not in REQUESTS else str(_count(system, name))
        lines.append((name, count, f"{min(times) / full:.2f}"))
    return table(("outputs", "operations per sample", "time"), lines)


def _evaluation(motion, names):
    return lambda: evaluate_variables(motion, names)


def _seconds(action) -> float:
    begin = time.perf_counter()
    action()
    return time.perf_counter() - begin


def _count(system: System, name: str) -> int:
    """Operations that depend on time or state."""
    nodes = [
        node for variable in REQUESTS[name] for node in VARIABLES[variable].evaluated(system.model)
    ]
    return sum(bool(n.operands) and n.level != Level.PARAMETERS for n in reachable(nodes))
