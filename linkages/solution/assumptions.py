"""What was assumed about a mechanism because its definition does not say it."""

from __future__ import annotations

from linkages.kernel.system import System


def assumptions(system: System) -> list[str]:
    """A sentence for each free coordinate and each assembly mode that was chosen."""
    found = [
        f"{name} was chosen as a free coordinate, at rest where 'assembly' puts it"
        for name in system.chosen
    ]
    for index in system.assumed:
        block = system.topology.solved_blocks[index]
        link, slider = block.unknowns
        found.append(
            f"{link} is assumed to point forward along the axis of {slider}; "
            f"give joint {block.loops[0].apex} a place under 'assembly' to say otherwise"
        )
    return found
