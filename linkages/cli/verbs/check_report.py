"""The report of ``check`` as text."""

from __future__ import annotations

from typing import Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.terminal import print_changes, print_notes, table


def print_report(content: dict[str, Any], screen: Console) -> None:
    """Print everything that `check` found."""
    print_changes(content.get("changes", ()), screen)
    screen.print(f"[bold]{escape(content['mechanism'])}[/bold]")
    _print_bodies(content, screen)
    _print_contributions(content, screen)
    _print_mobility(content, screen)
    _print_blocks(content, screen)
    print_notes(content["notes"], screen)
    if "modes" in content:
        from linkages.cli.verbs.modes import print_modes

        print_modes(content["modes"], screen)
    if "kernel" in content:
        _print_kernel(content["kernel"], screen)


def _print_bodies(content: dict[str, Any], screen: Console) -> None:
    rows = [
        [b["name"], b["kind"], "–".join(b["joints"]), b["mass"], b["inertia"], b["coordinate"]]
        for b in content["bodies"]
    ]
    heads = ["body", "kind", "joints", "mass (kg)", "inertia (kg m²)", "coordinate"]
    screen.print(table("\nBodies", heads, rows))
    joints = [[j["joint"], ", ".join(j["bodies"]), *j["position"]] for j in content["joints"]]
    heads = ["joint", "bodies", "x (m)", "y (m)"]
    screen.print(table("\nJoints at t = 0", heads, joints, numbers=2))


def _print_contributions(content: dict[str, Any], screen: Console) -> None:
    """Welds and gears; drives; loads, springs, dampers and masses at joints."""
    headings = {
        "relations": "Welds and gears",
        "drives": "Drives",
        "loads": "Loads, springs and masses",
    }
    for key, heading in headings.items():
        rows = [[r["kind"], r["on"], r["value"], r["path"]] for r in content[key]]
        if rows:
            screen.print(table(f"\n{heading}", ["kind", "on", "value", "in the file"], rows))


def _print_mobility(content: dict[str, Any], screen: Console) -> None:
    mobility = content["mobility"]
    screen.print(
        f"\n{content['revolute_pairs']} revolute and {content['prismatic_pairs']} prismatic pairs, "
        f"{content['loops']} independent loops\n"
        f"mobility {mobility['gruebler']} by the Chebychev–Grübler–Kutzbach criterion, "
        f"{mobility['numerical']} by the rank of the closure Jacobian"
    )
    for what in ("driven", "free", "dependent"):
        screen.print(f"{what}: {', '.join(content[what]) or 'none'}", markup=False)
    if content["redundant"]:
        screen.print(f"redundant joints: {', '.join(content['redundant'])}", markup=False)


def _print_blocks(content: dict[str, Any], screen: Console) -> None:
    keys = ("block", "kind", "unknowns", "apex", "side", "condition")
    rows = [[", ".join(b[k]) if k == "unknowns" else b[k] for k in keys] for b in content["blocks"]]
    heads = ["block", "kind", "solves for", "at joint", "branch", "condition number"]
    if rows:
        screen.print(table("\nBlocks (Assur groups) in order of solution", heads, rows, numbers=1))


def _print_kernel(kernel: dict[str, Any], screen: Console) -> None:
    if "note" in kernel:
        screen.print(f"\nkernel: {kernel['note']}")
        return
    counts = kernel["operations"]
    kinds = list(next(iter(counts.values())))
    rows = [[part, *(count[kind] for kind in kinds)] for part, count in counts.items()]
    screen.print(table("\nOperations of the kernel", ["part", *kinds], rows, numbers=len(kinds)))
    left_out = ", ".join(kernel["left_out"]) or "nothing"
    screen.print(f"left out because the motion does not depend on it: {left_out}", markup=False)
