"""What was assumed about a mechanism because its definition does not say it."""

from __future__ import annotations

from linkages.kernel.assembly import placed_joints
from linkages.kernel.system import System
from linkages.topology.blocks import Block


def assumptions(system: System) -> list[str]:
    """A sentence for each free coordinate and each assembly mode that was chosen."""
    found = [
        f"{name} was chosen as a free coordinate, at rest where 'assembly' puts it"
        for name in system.chosen
    ]
    blocks = system.topology.solved_blocks
    return found + [_assumed(system, blocks[index]) for index in system.assembly.assumed]


def _assumed(system: System, block: Block) -> str:
    link, slider = block.unknowns
    joints = placed_joints(system.model, block)
    if block.kind == "RPR":
        text = f"{slider} is assumed to lie on {link} in the direction of its axis"
    else:
        text = f"{link} is assumed to point forward along the axis of {slider}"
    if not joints:
        return text
    return f"{text}; give joint {joints[0]} a place under 'assembly' to say otherwise"
