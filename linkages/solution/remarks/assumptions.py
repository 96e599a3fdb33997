"""What was assumed about a mechanism because its definition does not say it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from linkages.kernel.assembly.hints import placed_joints
from linkages.kernel.system import System
from linkages.reading.paths import dotted
from linkages.topology.blocks import Block


def assumptions(system: System) -> list[str]:
    """A sentence for each free coordinate, assembly mode and number of turns that was chosen."""
    found = [
        f"{name} was chosen as a free coordinate, at rest where 'assembly' puts it"
        for name in system.chosen
    ]
    blocks = system.topology.solved_blocks
    found += [_assumed(system, blocks[index]) for index in system.assembly.assumed]
    return [*found, *_wound(system)]


def _wound(system: System) -> Iterator[str]:
    """Torsional springs that start more than half a turn from where the file has no torque.

    Whole turns of angles that the file does not give are not known.
    """
    for load in system.model.loads:
        if load.index not in system.assembly.turns:
            continue
        deflection = load.value(load.load.deflection)
        turns = system.evaluate([deflection])[0, 0] / (2 * np.pi)
        if abs(turns) > 0.5:
            yield (
                f"{dotted(load.load.path)} starts wound by {turns:.3g} turns: angles that are not "
                "given start within half a turn"
            )


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
