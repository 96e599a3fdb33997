"""Linkages of pylinkage: positions over a turn are those that it computes itself."""

from __future__ import annotations

import math
import re

import numpy as np
import pylinkage
import pytest

import linkages

STEPS = 40
SPEED = 2 * math.pi / STEPS


def crank_on(anchor, radius=1.0, angle=0.3):
    return pylinkage.Crank(
        anchor, radius=radius, angular_velocity=SPEED, initial_angle=angle, name="A"
    )


def four_bar():
    O, C = pylinkage.Ground(0, 0, name="O"), pylinkage.Ground(3, 0.2, name="C")  # noqa: E741
    crank = crank_on(O)
    rocker = pylinkage.RRRDyad(crank.output, C, distance1=3, distance2=2, name="B")
    pen = pylinkage.FixedDyad(crank.output, rocker, distance=1.5, angle=0.6, name="P")
    tail = pylinkage.FixedDyad(pen, rocker, distance=0.7, angle=-1.1, name="Q")
    return pylinkage.Linkage([O, C, crank, rocker, pen, tail], name="Four-bar")


def slider_crank():
    O, one, two = (pylinkage.Ground(*p) for p in ((0, 0), (-1, 0.2), (4, 0.5)))  # noqa: E741
    crank = crank_on(O)
    block = pylinkage.RRPDyad(crank.output, one, two, distance=2.5, x=3.0, y=0.4, name="B")
    return pylinkage.Linkage([O, one, two, crank, block], name="Slider-crank")


def guide_on_a_bar():
    """A rod whose end slides along the line of a rocker."""
    O, C, D = (pylinkage.Ground(*p) for p in ((0, 0), (3, 0.2), (3.5, -0.5)))  # noqa: E741
    crank = crank_on(O, radius=0.6)
    rocker = pylinkage.RRRDyad(crank.output, C, distance1=3, distance2=2, name="B")
    block = pylinkage.RRPDyad(D, C, rocker, distance=2.5, x=3.5, y=1.9, name="E")
    return pylinkage.Linkage([O, C, D, crank, rocker, block], name="Guide on a bar")


@pytest.mark.parametrize("made", [four_bar, slider_crank, guide_on_a_bar])
def test_positions_are_those_that_pylinkage_computes(made):
    mechanism = linkages.from_pylinkage(made(), step=0.02)
    found = linkages.simulate(mechanism, end=0.02 * STEPS, samples=STEPS + 1).data
    linkage = made()
    given = [c.name for c in linkage.components if c.name != str(id(c))]
    assert set(given) <= set(found.joint.to_numpy())
    track = np.array(list(linkage.step(STEPS)), dtype=float)
    for column, component in enumerate(linkage.components):
        name = component.name
        if name in found.joint and not isinstance(component, pylinkage.Ground):
            places = found.joint_position.sel(joint=name).to_numpy()[1:]
            # pylinkage turns its crank step by step: some forty roundings of numbers of size 3
            assert places == pytest.approx(track[:, column], abs=1e-13)


def test_units_masses_and_clearances():
    mechanism = linkages.from_pylinkage(
        four_bar(), units="cm", mass_per_length=3.0, clearances={"B": 1e-5}
    )
    by_name = {getattr(part, "name", ""): part for part in mechanism.components}
    assert by_name["C-B"].length == 0.02
    assert by_name["C-B"].mass == pytest.approx(0.06, rel=1e-15)
    (clearance,) = mechanism.clearances
    assert (clearance.joint, clearance.bar, clearance.size) == ("B", "C-B", 1e-5)
    # rods along the outline of a plate of four points: their mass is its length
    points = [*by_name["A-B"].points.values()]
    outline = sum(math.dist(p, q) for p, q in zip(points, [*points[1:], points[0]], strict=True))
    assert by_name["A-B"].mass == pytest.approx(3.0 * outline, rel=1e-14)
    solution = linkages.simulate(mechanism, end=0.01, samples=11)
    assert solution.completed


def test_rods_along_an_equilateral_triangle_have_its_inertia():
    from linkages.bridges.pmks import Draft

    draft = Draft("triangle")
    draft.bodies["plate"] = {"A": (0.0, 0.0), "B": (1.0, 0.0), "C": (0.5, math.sqrt(0.75))}
    draft.weigh(2.0)
    weight = draft.weights["plate"]
    # three rods of mass 2, their middles 1/(2√3) from the centre: 3·2·(1/12 + 1/12) = 1
    assert weight["mass"] == pytest.approx(6.0)
    assert weight["center"] == pytest.approx([0.5, math.sqrt(0.75) / 3])
    assert weight["inertia"] == pytest.approx(1.0)


def test_what_cannot_be_expressed_is_named():
    O = pylinkage.Ground(0, 0, name="O")  # noqa: E741
    arc = pylinkage.ArcCrank(O, radius=1, arc_start=0, arc_end=1, name="wiper")
    with pytest.raises(linkages.InputError, match="wiper is a ArcCrank, which a definition cannot"):
        linkages.from_pylinkage(pylinkage.Linkage([O, arc]))
    linkage = four_bar()
    *known, crank, rocker, _, _ = linkage.components
    other = pylinkage.FixedDyad(known[1], crank.output, distance=1, angle=0.1, name="loose")
    with pytest.raises(linkages.InputError, match="it is on no rigid body"):
        linkages.from_pylinkage(pylinkage.Linkage([*known, crank, rocker, other]))
    with pytest.raises(ValueError, match=re.escape("no bar has a joint 'X'")):
        linkages.from_pylinkage(linkage, clearances={"X": 1e-4})
    with pytest.raises(ValueError, match="step must be seconds > 0"):
        linkages.from_pylinkage(linkage, step=0)
    with pytest.raises(TypeError, match=re.escape("expected a pylinkage.Linkage")):
        linkages.from_pylinkage("four-bar")
