"""What acts on a grown mechanism: gravity, loads, springs, dampers, masses at joints."""

import math

from growing_mechanisms import Growing
from random_laws import strength


def gravity(g: Growing) -> None:
    g.definition["gravity"] = (g.draw.number(-3.0, 3.0), g.draw.number(-9.81, 9.81))


def joint_load(g: Growing) -> None:
    force = [strength(g, 20.0), strength(g, 20.0)]
    g.definition.setdefault("loads", []).append({"joint": g.moving_joint(), "force": force})


def bar_load(g: Growing) -> None:
    bars = list(g.definition["bars"])
    bar, other, torque = g.draw.choice(bars), g.draw.choice(bars), strength(g, 5.0)
    load = {"bar": bar} if bar == other else {"bars": [other, bar]}
    load["torque"] = torque
    g.definition.setdefault("loads", []).append(load)


def slider_load(g: Growing) -> None:
    for name in g.definition.get("sliders", {}):
        load = {"slider": name, "force": strength(g, 20.0)}
        g.definition.setdefault("loads", []).append(load)


def damper(g: Growing) -> None:
    """In all guides, and between two bars."""
    found = [{"slider": name} for name in g.definition.get("sliders", {})]
    bars = list(g.definition["bars"])
    pair = [g.draw.choice(["ground", *bars]), g.draw.choice(bars)]
    if pair[0] != pair[1]:
        found.append({"bars": pair})
    for load in found:
        load["damping"] = g.draw.number(0.0, 5.0)
    g.definition.setdefault("dampers", []).extend(found)


def spring(g: Growing) -> None:
    """Between any two joints that are not at one place."""
    first, second = g.some_joint(), g.some_joint()
    if abs(g.places[first] - g.places[second]) > 0.1:
        entry = {"between": [first, second], "stiffness": g.draw.number(0.0, 200.0)}
        entry |= {"length": g.draw.number(0.0, 1.0), "damping": g.draw.number(0.0, 5.0)}
        g.definition.setdefault("springs", []).append(entry)


def torsion_spring(g: Growing) -> None:
    """Between bars within half a turn of each other, so that whole turns do not matter."""
    bars = list(g.definition["bars"])
    first, second = g.draw.choice(["ground", *bars]), g.draw.choice(bars)
    if first != second:
        pair = {"bar": second} if first == "ground" else {"between_bars": [first, second]}
        entry = {**pair, "stiffness": g.draw.number(0.0, 20.0)}
        difference = g.angles[second] - g.angles.get(first, 0.0)
        entry |= {"angle": difference + g.draw.number(-4.0, 4.0)}
        entry |= {"damping": g.draw.number(0.0, 2.0)}
        if abs(difference) < math.pi:
            g.definition.setdefault("springs", []).append(entry)


def mass(g: Growing) -> None:
    g.section("masses")[g.moving_joint()] = g.draw.number(0.1, 2.0)


DECORATIONS = (
    gravity,
    joint_load,
    bar_load,
    slider_load,
    damper,
    spring,
    torsion_spring,
    mass,
)
