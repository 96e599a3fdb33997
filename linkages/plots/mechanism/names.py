"""Names of a drawing: what is written beside joints, bodies, clearances and loads."""

from __future__ import annotations

from linkages.plots.mechanism import outlining
from linkages.plots.mechanism.bodies import body_role, clearance_ends
from linkages.plots.mechanism.efforts import load_words
from linkages.plots.mechanism.guides import RAIL, pin_of
from linkages.plots.mechanism.links import anchored_outlines
from linkages.plots.mechanism.pose import Pose
from linkages.plots.mechanism.shapes import Anchor, Look, Word

GUIDED = RAIL + 2.0
"""Points from the joint of a slider to the name of its room."""


def words_of(pose: Pose) -> list[Word]:
    """Names of joints, sliders, clearances and bodies, and sizes of loads, most important first."""
    mechanism, shown = pose.mechanism, pose.positions
    hidden = {*clearance_ends(mechanism), *mechanism.feet}
    found = [
        _beside(joint, joint, outlining.PIN + 2.0, "ink", strong=True)
        for joint in shown
        if joint not in hidden and "." not in joint  # which no definition can name
    ]
    for body in mechanism.bodies.values():
        joints = list(pose.shown(body.name))
        if joints and body.guide is not None and body.kind != "offset":
            gap, role = outlining.BLOCK[1] + 2.0, body_role(mechanism, body.name)
            found.append(_beside(body.name, joints[0], gap, role))
    found += [
        _beside(term.name, term.joint, outlining.CLEARANCE_RING + 2.0, "clearance")
        for term in mechanism.displacements
        if term.joint in shown
    ]
    found += [
        Word(play.name, (pin_of(pose, play.slider),), Look("clearance"), GUIDED, name=play.name)
        for play in mechanism.plays
        if pose.axis(play.slider) is not None
    ]
    for body, corners, direction in anchored_outlines(pose):
        if body.rotates:
            look = Look(body_role(mechanism, body.name))
            found.append(Word(body.name, corners, look, direction=direction, name=body.name))
    return [*found, *load_words(pose)]


def _beside(text: str, joint: str, gap: float, role: str, *, strong: bool = False) -> Word:
    anchor = Anchor(((joint, 1.0),))
    return Word(text, (anchor,), Look(role), gap, name=text, strong=strong)
