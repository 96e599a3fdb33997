"""A block on a straight guide under forces with modes, and what closed forms say of its motion."""

import contextlib

import numpy as np

from linkages.components.mechanisms.definition import loads
from linkages.kernel.forces.generalised_forces import LoadNodes

LAWS = {}

BLOCK = """name: {name}
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [B, C], length: 1, inertia: 1}}}}
sliders: {{{name}: {{joint: B, through: O, mass: 1}}}}
loads: [{{slider: {name}, force: {outside}}}]
drives: {{rod: {{angle: 0, speed: 0}}}}
free: {{{name}: {{position: {position}, speed: {speed}}}}}
"""


@contextlib.contextmanager
def forces_by_nodes():
    """Loads of mechanisms in LAWS are what these functions make of nodes."""
    own = LoadNodes.value

    def value(self, law):
        bodies = [name for name in self.model.mechanism.bodies if name in LAWS]
        if not bodies or (law is not self.load.force and law is not self.load.working):
            return own(self, law)
        self.outside = own(self, law)
        return LAWS[bodies[0]](self)

    LoadNodes.value = value
    try:
        yield
    finally:
        LoadNodes.value = own


def named(force, body=""):
    """A name of a body with such a load; its own, for equal structures share their equations."""
    name = f"{body}{force.__name__}"
    LAWS[name] = force
    return name


def block(force, position, speed, outside="1 N"):
    """A block of 1 kg."""
    name = named(force)
    return loads(BLOCK.format(name=name, position=position, speed=speed, outside=outside))


def floor(load, g=9.81, stiffness=1e4):
    """Gravity, and a floor that pushes as a spring."""
    x = load.displacement
    touch = load.model.switches.add("floor: touch", -x)
    return load.graph.select(touch, -stiffness * x, load.graph.zero) - g


def damped_floor(load, g=9.81, stiffness=1e4, damping=20.0):
    """The same with a damper (Kelvin and Voigt): the force jumps at the touch."""
    x, v = load.measured(0), load.measured(1)
    touch = load.model.switches.add("floor: touch", -x)
    return load.graph.select(touch, -stiffness * x - damping * v, load.graph.zero) - g


def remembering_floor(load, g=9.81, stiffness=1e6, chi=0.5):
    """Force of Hunt and Crossley with the rate at the last touch, and none where it would pull."""
    graph, switches = load.graph, load.model.switches
    depth, rate = -load.measured(0), -load.measured(1)
    touch = switches.add("floor: touch", depth)
    first = switches.memory("floor: touch", graph.select(rate - 1e-3, rate, graph.number(1e-3)))
    factor = 1.0 + chi * rate / first
    pushing = switches.add("floor: slack", factor, active=touch)
    safe = graph.select(depth, depth, graph.one)
    elastic = graph.select(depth, stiffness * safe * graph.sqrt(safe), graph.zero)
    force = graph.select(pushing, elastic * factor, graph.zero)
    return graph.select(touch, force, graph.zero) - g


def impacts(load, g=9.81, restitution=0.8):
    """Gravity, and a rigid floor that throws back."""
    inputs, free = load.model.inputs, load.model.topology.free
    rates = [inputs.rate(i) for i in range(len(free))]
    own = free.index(load.measure.body)
    rates[own] *= -restitution
    load.model.switches.add("floor: impact", -load.displacement, jump=rates)
    return load.graph.number(-g)


def rubbing(load, stiffness=100.0, friction=0.5):
    """A spring, and friction of constant magnitude."""
    sign = load.model.switches.add("block: sign(speed)", load.measured(1))
    return -stiffness * load.displacement - friction * sign


def choosing(load, stiffness=100.0, friction=0.5):
    """The same as a choice between two forces, which says nothing of what lies between."""
    sign = load.model.switches.add("block: sign(speed)", load.measured(1))
    chosen = load.graph.select(sign, load.graph.number(-friction), load.graph.number(friction))
    return chosen - stiffness * load.displacement


def sticking(load, stiffness=100.0, friction=0.5):
    """A spring, friction, and a force from outside."""
    sign = load.model.switches.add("block: sign(speed)", load.measured(1))
    return load.outside - stiffness * load.displacement - friction * sign


def belted(load, stiffness=100.0, friction=5.0, drop=3.0, belt=0.2, scale=0.1):
    """A spring, and a belt whose friction falls with the speed of sliding (Stribeck)."""
    graph, slip = load.graph, belt - load.measured(1)
    sign = load.model.switches.add("block: sign(slip)", slip, stick=True)
    falling = drop * graph.apply("exp", -(sign * slip) / scale)
    return (friction - drop + falling) * sign - stiffness * load.displacement


def forced_wall(load, stiffness=1e4, damping=20.0, gap=0.01):
    """A spring, a force from outside, and a wall as spring and damper at some distance."""
    x, v = load.measured(0), load.measured(1)
    touch = load.model.switches.add("wall: touch", x - gap)
    pressed = -stiffness * (x - gap) - damping * v
    return load.graph.select(touch, pressed, load.graph.zero) - 100.0 * x - 0.5 * v + load.outside


def forced_impacts(load, stiffness=100.0, damping=0.5, gap=0.01, restitution=0.7):
    """A spring, a damper, a force from outside, and a rigid wall at some distance."""
    inputs, free = load.model.inputs, load.model.topology.free
    x, v = load.measured(0), load.measured(1)
    rates = [inputs.rate(i) for i in range(len(free))]
    rates[free.index(load.measure.body)] *= -restitution
    load.model.switches.add("wall: impact", x - gap, jump=rates)
    return -stiffness * x - damping * v + load.outside


def stopped(load, friction=2.0, stop=0.17, stiffness=1e4):
    """Friction of constant magnitude, and a stop with the rate of its last touch."""
    graph, switches = load.graph, load.model.switches
    x, v = load.measured(0), load.measured(1)
    sign = switches.add("piston: sign(velocity)", v)
    touch = switches.add("stop: touch", x - stop)
    first = switches.memory("stop: touch", graph.select(v - 1e-2, v, graph.number(1e-2)))
    pressed = stiffness * (x - stop) * (1.0 + 0.3 * v / first)
    return -friction * sign - graph.select(touch, pressed, graph.zero)


def bounced(times, height, g=9.81, stiffness=1e4):
    """Position of a block of 1 kg that falls from rest onto the floor of a spring."""
    fall, w = np.sqrt(2 * height / g), np.sqrt(stiffness)
    speed = g * fall
    contact = 2 * (np.pi - np.arctan(speed * w / g)) / w
    t = np.mod(times, 2 * fall + contact)
    inside, rising = t - fall, t - fall - contact
    touching = -g / w**2 * (1 - np.cos(w * inside)) - speed / w * np.sin(w * inside)
    falling, thrown = height - g * t**2 / 2, speed * rising - g * rising**2 / 2
    return np.where(t < fall, falling, np.where(inside < contact, touching, thrown))


def rubbed(times, start, stiffness=100.0, friction=0.5):
    """Position of a block of 1 kg that starts from rest, as long as it goes on sliding."""
    w, loss = np.sqrt(stiffness), friction / stiffness
    half = np.floor(np.asarray(times) * w / np.pi)
    middle = np.where(half % 2 == 0, 1.0, -1.0) * loss  # of this half of a swing
    amplitude = start - loss - 2 * loss * half
    return middle + np.where(half % 2 == 0, 1.0, -1.0) * amplitude * np.cos(
        w * times - np.pi * half
    )
