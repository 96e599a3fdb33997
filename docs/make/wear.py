"""The table of costs on the page on wear; `commands` makes its pictures."""

from __future__ import annotations

import time

import linkages
from make.contact_route import ROUTE
from make.registry import makes

WORN = {
    "friction": 0.1,
    "friction_law": "coulomb",
    "width": "20 mm",
    "wear": {"bearing": {"wear_rate": "1e-7 mm^3/(N m)"}},
}


@makes("wear-cost")
def cost() -> str:
    """Cost and errors of the slider-crank."""
    gap = ROUTE.definition.content["clearances"]["gap"]
    mechanism = ROUTE.with_values({"clearances.gap": {**gap, **WORN}})
    heads = "revolutions | jumps | computed | processor time | size | error | half the jumps"
    lines = [f"| {heads} |", "|--:|--:|--:|--:|--:|--:|--:|"]
    for power in (6, 8):
        begun = time.process_time()
        data = linkages.wear(mechanism, revolutions=10**power, rtol=1e-9)
        taken = time.process_time() - begun
        half = linkages.wear(mechanism, revolutions=10**power, rtol=1e-9, confirm=True)
        end, moved = data.isel(jump=-1, clearance=0), float(half.attrs["difference"][0])
        lines.append(
            f"| 10{'⁶' if power == 6 else '⁸'} | {data.sizes['jump'] - 1} "
            f"| {data.attrs['computed']} | {taken:.0f} s | {1e3 * float(end['size']):.5f} mm "
            f"| {1e6 * float(end['error']):.2g} µm | {1e6 * moved:.2g} µm |"
        )
    return "\n".join([*lines, ""])
