"""Steps that a mechanism grows by: Assur groups, whose motion follows from what is there."""

import cmath

import numpy as np
from growing_mechanisms import Growing, xy
from growth_blocks import corner, local_frame, own_points, slider


def two_bars(g: Growing) -> None:
    """RRR: two bars from two joints to a new one."""
    first = g.some_joint()
    second = g.second_joint(first)
    part = complex(g.draw.number(0.0, 1.0), g.draw.choice([-1, 1]) * g.draw.number(0.5, 1.2))
    new = g.joint(g.places[first] + part * (g.places[second] - g.places[first]))
    light = g.chance(0.1)  # without clearances: some mass must move with each of them
    g.bar(first, new, shared=(not light, False), mass=not light)
    g.bar(second, new, shared=(not light, not light))


def slider_on_ground(g: Growing) -> None:
    """RRP: a bar from a joint to a block on an axis of the ground, at 60° or less from the bar."""
    start, vector = g.some_joint(), g.polar(0.4, 1.0)
    new = g.joint(g.places[start] + vector)
    g.bar(start, new)
    axis = cmath.phase(vector) + g.draw.number(-1.0, 1.0) + g.draw.choice([0.0, cmath.pi])
    name, _ = slider(g, new, g.places[new], axis)
    if g.chance(0.3):
        corner(g, name, axis)


def slider_on_bar(g: Growing) -> None:
    """RPR: a bar that turns about one joint, and a block at another that slides along the bar."""
    block = g.some_joint()
    pivot = g.second_joint(block)
    if g.chance(0.5):
        block, pivot = pivot, block
    tip = g.joint(g.places[pivot] + g.polar(0.5, 1.2))
    bar = g.bar(pivot, tip)
    base, turn = local_frame(g, bar)
    place = (g.places[block] - base) * turn
    reach = place - own_points(g, bar)[pivot]
    back = g.draw.choice([0.0, cmath.pi])
    through = g.chance(0.4)
    axis = cmath.phase(reach) + back + (0.0 if through else g.draw.number(-1.0, 1.0))
    name, _ = slider(g, block, place, axis, on=bar)
    if through:  # the axis goes through the pivot, which may be the origin of the bar's frame
        g.section("sliders")[name]["through"] = pivot
        if own_points(g, bar)[pivot] == 0 and g.chance(0.5):
            del g.section("sliders")[name]["through"]
    if g.chance(0.3):
        corner(g, name, axis + g.angles[bar])


def yoke(g: Growing) -> None:
    """RPP: a joint slides in a slot of a block that itself slides on the ground (Scotch yoke)."""
    pin = g.some_joint()
    axis, slot = g.draw.number(-3.0, 3.0), g.draw.choice([-1, 1]) * g.draw.number(0.6, 2.5)
    base = g.joint(g.places[pin] + g.polar(0.3, 0.8))
    name, _ = slider(g, base, g.places[base], axis)
    local = (g.places[pin] - g.places[base]) * cmath.exp(-1j * axis)
    block, _ = slider(g, pin, local, slot, on=name)
    if g.chance(0.3):
        corner(g, block, axis + slot)


def crossing(g: Growing) -> None:
    """PP: two blocks at one joint, on an axis of the ground and on one of a bar."""
    bar, angle = g.draw.choice(list(g.definition["bars"])), g.draw.number(-3.0, 3.0)
    base, turn = local_frame(g, bar)
    local = g.polar(0.2, 1.0)
    meet = g.joint(base + local / turn)
    slider(g, meet, local, angle, on=bar)
    across = g.draw.choice([-1, 1]) * g.draw.number(0.6, 2.5)
    slider(g, meet, g.places[meet], angle + g.angles[bar] + across)


def triad(g: Growing) -> None:
    """Assur group of class III: a plate on three legs whose lines are far from a common point."""
    first = g.some_joint()
    feet = [first, g.second_joint(first), g.second_joint(first)]
    middle = sum(g.places[foot] for foot in feet) / 3 + g.polar(0.0, 0.3)
    for _ in range(4):
        turn = g.draw.number(-3.0, 3.0)
        tips = [middle + cmath.rect(0.3, turn + k * 2.0) for k in range(3)]
        legs = [tip - g.places[foot] for tip, foot in zip(tips, feet, strict=True)]
        units = np.array([leg / (abs(leg) or 1.0) for leg in legs])
        moments = (np.conj(np.array(tips) - middle) * units).imag / 0.3
        margin = abs(units.real @ np.cross(units.imag, moments))
        if margin > 0.3 and min(map(abs, legs)) > 0.2:
            break
    else:
        return
    joints = [g.joint(tip) for tip in tips]
    name = f"b{len(g.definition['bars']) + 1}"
    local = [xy((tip - middle) * cmath.exp(-1j * turn)) for tip in tips]
    heavy = {"mass": g.draw.number(0.2, 3.0), "center": (0.05, 0.0), "inertia": 0.02}
    points = dict(zip(joints, local, strict=True))
    g.definition["bars"][name] = {"points": points, **heavy}
    g.angles[name] = turn
    for foot, joint in zip(feet, joints, strict=True):
        g.bar(foot, joint, shared=(True, True))


GROUPS = (two_bars, slider_on_ground, slider_on_bar, yoke, crossing, triad)
