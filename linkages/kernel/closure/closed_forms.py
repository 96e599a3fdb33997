"""Blocks with a closed form: what their loops give the dyads to solve."""

from __future__ import annotations

from typing import TYPE_CHECKING

from linkages.kernel.closure.dyads import Dyad, LinkAndSlider, LinkInGuide, TwoLinks, TwoSliders
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.topology.blocks import Block

if TYPE_CHECKING:
    from linkages.kernel.closure.positions import Positions


def solve_dyad(positions: Positions, block: Block) -> Dyad:
    """Solve a dyad and enter the positions of its bodies.

    All links that turn with an unknown angle count as one.
    """
    graph, frames = positions.graph, positions.frames
    loop = block.loops[0]
    gap = positions.gap(loop)
    zero = Vector(graph.zero, graph.zero)
    bases = {name: zero for name in block.unknowns if positions.body(name).rotates}
    slides: dict[str, tuple[Vector, float]] = {}
    for step in loop.steps:
        way = (step.body, step.start, step.end)
        master, own = frames.rotation(step.body)
        sliding = frames.sliding(*way) if step.body in block.unknowns else 0
        if sliding:
            link = own.times(frames.fixed(*way))
            axis = own if master in bases else positions.unit(step.body)
            slides[step.body] = (axis, float(sliding))
        else:
            link = own.times(positions.in_frame(*way))
        if master in bases:
            bases[master] = bases[master] + link
        else:
            gap = gap - positions.turned(master, link)
    dyad = _solved(positions, block, gap, bases, slides)
    _label(positions, block, dyad)
    return dyad


def _solved(
    positions: Positions,
    block: Block,
    gap: Vector,
    bases: dict[str, Vector],
    slides: dict[str, tuple[Vector, float]],
) -> Dyad:
    """Solve for what bridges the gap.

    Parameters
    ----------
    positions, block
        What is solved.
    gap
        From the known end of the first link to that of the second, less what is known between.
    bases
        Unknown angle → the vector that turns with it, in its frame.
    slides
        Unknown displacement → its axis (in the frame of its carrier if that turns with an unknown
        angle), and +1 for a way along it, −1 for one against it.
    """
    first, second = block.unknowns
    if block.kind == "PP":
        (one, one_way), (other, other_way) = slides[first], slides[second]
        sliders = TwoSliders.solve(-gap, one * one_way, other * -other_way)
        positions.displacements |= {first: sliders.first, second: sliders.second}
        return sliders
    side = positions.inputs.side(block.index)
    base = bases[first]
    if block.kind == "RRR":
        links = TwoLinks.solve(gap, base.square, bases[second].square, side)
        positions.links |= {first: (base, links.first), second: (bases[second], links.second)}
        return links
    axis, way = slides[second]
    if block.kind == "RRP":
        pushed = LinkAndSlider.solve(-gap, base.square, axis * -way, side)
        positions.links[first] = (base, pushed.link)
        positions.displacements[second] = pushed.position
        return pushed
    guided = LinkInGuide.solve(gap, base, axis, way, side)
    positions.units[first] = guided.unit
    positions.displacements[second] = guided.position
    return guided


def _label(positions: Positions, block: Block, dyad: Dyad) -> None:
    """Name the results in the printed kernel."""
    for name in block.unknowns:
        if name in positions.links:
            positions.links[name][1].label(f"body{positions.body_numbers[name]}_")
    for name, value in vars(dyad).items():
        if isinstance(value, Scalar) and value.label is None and value.operands:
            value.label = f"block{block.index}_{name}"
