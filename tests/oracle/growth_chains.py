"""Steps that a mechanism grows by: bars and carts that hang on it with a motion of their own."""

from growing_mechanisms import Growing
from growth_blocks import displaced, local_frame, own_points, slider
from random_laws import motion


def crank(g: Growing) -> None:
    """A bar on a new pin of the ground, driven or free."""
    open_chain(g, g.ground_pin(complex(g.draw.number(0.0, 1.0), 0.0)))


def pendulum(g: Growing) -> None:
    """A bar on any joint, driven (its angle, not that against its neighbour) or free."""
    open_chain(g, g.some_joint())


def open_chain(g: Growing, start: str) -> None:
    tip = g.joint(g.places[start] + g.polar(0.3, 0.8), hint=False)
    bar = g.bar(start, tip)
    move(g, bar, g.angles[bar], "angle")


def move(g: Growing, body: str, start: float, key: str) -> None:
    """Drive a coordinate, or leave it free."""
    if g.chance(0.5):
        law = motion(g.draw, start)
        if "angle" in law:
            law[key] = law.pop("angle")
        g.section("drives")[body] = law
    else:
        g.section("free")[body] = {key: start, "speed": g.draw.number(-3.0, 3.0)}


def cart(g: Growing) -> None:
    """A block on an axis of the ground or of a bar, driven or free, and a bar that hangs on it."""
    if g.chance(0.5):
        bar = g.draw.choice(list(g.definition["bars"]))
        base, turn = local_frame(g, bar)
        more = {"on": bar}
    else:
        base, turn, more = 0j, 1 + 0j, {}
    local = g.polar(0.2, 1.0)
    pivot = g.joint(base + local / turn)
    name, position = slider(g, pivot, local, g.draw.number(-3.0, 3.0), **more)
    g.section("sliders")[name]["mass"] = g.draw.number(0.5, 2.0)
    move(g, name, position, "position")
    open_chain(g, pivot)


def gear(g: Growing) -> None:
    """A bar on a joint whose angle follows from that of another bar, seen from a carrier or not."""
    bars, ratio = list(g.definition["bars"]), g.draw.choice([1.0, -1.0, 0.5, -2.5])
    start, other, carrier = g.some_joint(), g.draw.choice(bars), g.draw.choice(bars)
    bar = g.bar(start, g.joint(g.places[start] + g.polar(0.3, 0.8), hint=False))
    entry = {"bars": [other, bar], "ratio": ratio}
    angle = g.angles[bar] - ratio * g.angles[other]
    if carrier != other and g.chance(0.4):
        entry["carrier"] = carrier
        angle -= (1.0 - ratio) * g.angles[carrier]
    g.definition.setdefault("gears", []).append({**entry, "angle": angle})


def weld(g: Growing) -> None:
    """A bar that is fixed to another one, or to the ground, at one of its joints."""
    if g.chance(0.2):
        other, joints = "ground", list(g.section("joints"))
    else:
        other = g.draw.choice(list(g.definition["bars"]))
        joints = [j for j in own_points(g, other) if not displaced(g, other, j)]
    joints = [joint for joint in joints if joint not in g.definition.get("welds", {})]
    if not joints:
        return
    start = g.draw.choice(joints)
    tip = g.joint(g.places[start] + g.polar(0.3, 0.8), hint=False)
    bar = g.bar(start, tip, shared=(False, False))
    angle = g.angles[bar] - g.angles.get(other, 0.0)
    g.section("welds")[start] = {"bars": [other, bar], "angle": angle}


CHAINS = (pendulum, cart, gear, weld)
