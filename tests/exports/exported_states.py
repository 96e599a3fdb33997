"""Mechanisms, states and what kernels and NumPy say of them: what exported programs must say."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

import linkages
from linkages.exports.writers.exported_model import exported
from linkages.kernel.inputs import NEAREST
from linkages.kernel.system import System
from linkages.kernel.varying import Varying
from linkages.solution.joint_reactions import Statics, row_of
from linkages.solution.series import REACTIONS, system_series

ROOT = Path(__file__).parents[2]
SHIPPED = sorted(path.stem for path in (ROOT / "mechanisms").glob("*.yaml"))
SCENES = {
    # tables over time and over an angle, an internal state, a function, a clearance that is led
    "tables": """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 1.2, inertia: 0.08}
  rod: {joints: [A, B], length: 140 mm, mass: 0.4}
sliders:
  piston: {joint: B, through: O, mass: 0.45}
free: {crank: {angle: 0.3, speed: 100}}
maxwell:
  - {slider: piston, stiffness: 20 N/mm, damping: 400 N s/m}
loads:
  - slider: piston
    force: {table: {over: crank.angle, at: [0, 1, 3, 6.2832], values: [-9, -5, 0, -9],
            periodic: true}}
  - bar: crank
    torque: {table: {times: [0, 0.01, 0.03], values: [1, 3, 2], interpolation: pchip}}
  - {bar: crank, torque: -0.01*tanh(crank.speed/20)*exp(-t)}
assembly: {B: [180 mm, 0]}
""",
    # springs that feel whole turns of dependent angles; a gear, a weld, a cam
    "wound": """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.3, 0], Q: [0, 0.4]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1}
  coupler: {joints: [A, B], length: 0.3, mass: 1}
  rocker: {joints: [C, B], length: 0.2, mass: 1}
  wheel: {joints: [Q, W], length: 0.05, mass: 0.2}
  arm: {joints: [W, V], length: 0.1, mass: 0.1}
sliders:
  valve: {joint: P, through: [0, 0.8], angle: 90 deg, mass: 0.1}
free: {crank: {angle: 1, speed: 2}}
springs:
  - {bar: rocker, stiffness: 3, angle: 400 deg}
  - {between_bars: [coupler, rocker], stiffness: 2, angle: 20 deg, damping: 0.1}
gears:
  - {bars: [crank, wheel], ratio: -1.7}
welds:
  W: {bars: [wheel, arm], angle: 40 deg}
cams:
  - {slider: valve, bar: wheel, angles: [0, 2, 4, 360 deg], lifts: [0, 6 mm, 1 mm, 0],
     offset: 50 mm}
assembly: {B: left}
""",
    # three cranks side by side, one of them redundant: reactions with the least sum of squares
    "side-by-side": """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1, 0], E: [2, 0]}
bars:
  a: {joints: [O, A], length: 0.5, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
  e: {joints: [E, D], length: 0.5, mass: 1}
  b: {points: {A: [0, 0], B: [1, 0], D: [2, 0]}, mass: 2, center: [0.7, 0.1], inertia: 0.3}
free: {a: {angle: 60 deg, speed: -1}}
assembly: {B: [1.25, 0.4]}
""",
    # an impact with restitution, seven times
    "bounce": """
gravity: [0, -9.81]
joints: {O: [0, 0]}
sliders: {ball: {joint: B, through: O, angle: 90 deg, mass: 1}}
stops: [{slider: ball, lower: 0, restitution: 0.8}]
free: {ball: {position: 1, speed: 0}}
""",
    # a disc that bounces and rolls between a floor and a post
    "walls": """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.8, 0.1]}
sliders:
  across: {joint: X, through: O, angle: 0}
  up: {joint: P, through: X, 'on': across, angle: 90 deg, mass: 2}
bars: {disc: {points: {P: [0, 0]}, inertia: 0.01}}
contacts:
  floor: {body: disc, points: [P], radius: 0.1, through: O, angle: 0, contact: restitution,
          restitution: 0.6, friction: 0.2}
  post: {body: disc, points: [P], radius: 0.1, through: C, circle: 0.2, contact: restitution,
         restitution: 0.4}
free: {across: {position: 0, speed: 1.2}, up: {position: 0.3}, disc: {angle: 0, speed: 2}}
""",
    # a flat valve and a roller that cams throw off
    "thrown": """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {cam: {points: {O: [0, 0], P: [0.02, 0]}, mass: 1, center: [0, 0], inertia: 0.01}}
sliders:
  valve: {joint: V, through: O, angle: 90 deg, mass: 0.5}
  other: {joint: W, through: O, angle: 0, mass: 0.2}
cams:
  - {slider: valve, bar: cam, angles: [0, 60 deg, 120 deg, 180 deg, 240 deg, 300 deg, 360 deg],
     lifts: [0, 5 mm, 15 mm, 20 mm, 15 mm, 5 mm, 0], base_radius: 30 mm, offset: 30 mm, flat: true,
     contact: restitution, restitution: 0.4, friction: 0.1}
  - {slider: other, bar: cam, angles: [0, 90 deg, 180 deg, 270 deg, 360 deg],
     lifts: [0, 8 mm, 0, 8 mm, 0], base_radius: 30 mm, offset: 40 mm, roller_radius: 10 mm,
     contact: hunt-crossley-constant, stiffness: 1e8, dissipation: 0.4}
springs:
  - {slider: valve, stiffness: 3000, position: 10 mm}
  - {slider: other, stiffness: 1e3, position: 10 mm}
free:
  cam: {angle: 0.3, speed: 170}
  valve: {position: 32 mm}
  other: {position: 43 mm, speed: 1}
""",
    # states with equations of their own, one of which jumps
    "oil": """
joints: {O: [0, 0]}
sliders: {piston: {joint: B, through: O, mass: 20}}
parameters: {area: 1.2e-3, supply: 1e7}
states:
  pressure: {initial: 2e6, rate: "7e12*(sqrt(abs(supply - pressure.value))*1e-8
             - area*piston.velocity)"}
  wanted: {rate: "where(t < 0.02, 3, -1) - wanted.value"}
springs: [{slider: piston, stiffness: 2e5, damping: 3e3, position: 0}]
loads: [{slider: piston, force: area*pressure.value + 10*wanted.value}]
free: {piston: {position: 0.05, speed: 0}}
""",
    # a digital controller, and a sampled state of another period
    "sampled": """
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 2}}
springs: [{slider: block, stiffness: 30, damping: 1.5, position: 0}]
controllers:
  hold: {slider: block, of: block.position, setpoint: goal.value, proportional: 25, integral: 40,
         derivative: 2, limits: [-6, 6], period: 20 ms}
states: {goal: {initial: 0.2, next: 0.6 - goal.value, period: 0.15}}
free: {block: {position: 0.1, speed: 0}}
""",
    # a stop that adhesion holds until a force of 7 N pulls, and one whose damping pulls
    "glued": """
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 2}}
stops:
  - {slider: block, upper: 0, restitution: 0.4, adhesion: 7}
  - {slider: block, lower: -0.5, stiffness: 500, damping: 20, pulls: true, adhesion: 0.5}
loads: [{slider: block, force: 5 - 20*t}]
free: {block: {position: 0, speed: 0}}
""",
    # Coulomb friction, in which the block sticks in the end
    "rub": """
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 1}}
springs: [{slider: block, stiffness: 50, position: 0}]
loads: [{slider: block, force: -2*sign(block.velocity)}]
free: {block: {position: 0.3, speed: 0}}
""",
}  # fmt: skip
NAMES = [*SHIPPED, *SCENES]
PARALLELOGRAM = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.5, mass: 1}
  b: {joints: [A, B], length: 1, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
drives: {a: {angle: 60 deg, speed: -6}}
assembly: {B: [1.25, 0.4]}
simulate: {end: 0.4, samples: 4}
"""
PASSING = {
    "free": (PARALLELOGRAM.replace("drives", "gravity: [0, -9.81]\nfree").replace("-6", "-9"), 1.0),
    "driven": (f"{PARALLELOGRAM.rstrip().removesuffix('}')}, change_points: pass}}\n", 1.0),
    "rigid": (
        """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 50 mm, mass: 0.3, inertia: 1e-4}
  rod: {joints: [A, B], length: 120 mm, mass: 0.2, inertia: 3e-4}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.15}}
clearances:
  gap: {joint: B, bar: rod, size: 0.2 mm, contact: restitution, restitution: 0.6,
        pin_radius: 8 mm, friction_law: coulomb, friction: 0.05}
drives: {crank: {angle: 0, speed: 3000 rpm}}
assembly: {B: [0.17, 0]}
""",
        0.01,
    ),
}
"""The same moving freely, and led through, past three and two change points; rigid contacts with
friction that stick. And for how long."""
CHANGES = np.pi / 3 / 6
"""When its bars are in line."""
STUCK = """
joints: {O: [0, 0], C: [1, 0]}
bars:
  a: {joints: [O, A], length: 0.3, mass: 1}
  b: {joints: [A, B], length: 1, mass: 1}
  c: {joints: [C, B], length: 0.5, mass: 1}
free: {c: {angle: 90 deg, speed: 6}}
assembly: {A: [0.28, 0.1]}
"""
"""A crank that its rocker drives: it reaches a dead centre, where other coordinates are needed."""
SWITCHED = {
    "slider-crank-contact": 0.003,
    "bounce": 2.5,
    "rub": 3.0,
    "oil": 0.1,
    "sampled": 1.0,
    "glued": 1.4,
    "walls": 1.2,
    "thrown": 0.1,
}
"""Mechanisms whose equations change, and for how long they are followed."""
TIMES = (0.0, 0.013, 0.04)

NEAR = 1e-13
"""Of the largest value of a variable: libraries differ in last digits of sines, and formulas with
cancellation carry some of that on."""


@cache
def system(name):
    """A shipped mechanism or a scene, assembled."""
    if name in PASSING:
        return System(linkages.loads(PASSING[name][0]))
    if name in SCENES:
        return System(linkages.loads(SCENES[name]))
    return System(linkages.load(ROOT / "mechanisms" / f"{name}.yaml"))


@cache
def kernel(name):
    """The same as it is exported."""
    return exported(system(name))


@dataclass(frozen=True)
class Case:
    """A time, a state, and what follows."""

    time: float
    state: np.ndarray
    rates: np.ndarray
    outputs: np.ndarray


@cache
def cases(name):
    """States about the initial one, whose loops close."""
    of, random = system(name), np.random.default_rng(5)
    series = [system_series(of)[q.name] for q in kernel(name).quantities]
    nodes = [one.node(of.model) for one in series if one.variable not in REACTIONS]
    accelerations = of.model.integrated_accelerations(of.model.changes)
    moved = of.layout.moved
    half = len(of.layout.coordinates)
    found = []
    for time in TIMES:
        state = of.state.copy()
        for rows in (slice(0, moved), slice(half, half + moved)):
            state[rows] += 0.02 * (time > 0) * random.normal(size=moved)
        held = of.starting_held()[:, None]
        if of.layout.carried:
            state[of.layout.carried_rows] = of.evaluate(
                of.model.settled, time, state[:, None], held=held
            )[:, 0]
        second = of.evaluate(accelerations, time, state[:, None], held=held)
        at = partial(of.evaluate, time=time, state=state[:, None], acceleration=second, held=held)
        plain = iter(at(nodes)[:, 0])
        reactions = Statics(of.model, of.topology, 1, at).reactions().ravel()
        outputs = np.array(
            [
                reactions[row_of(one, of.model)] if one.variable in REACTIONS else next(plain)
                for one in series
            ]
        )
        rates = np.concatenate([state[half:], second[:, 0]])
        rates[len(of.layout.free) : moved] = 0.0
        if of.layout.free and not kernel(name).modes:  # what compiled code says of it
            rows = of.layout.state_rows
            rates[rows] = linkages.compile(of.mechanism)(time, state[rows])
        found.append(Case(time, state, rates, outputs))
    return found


def assert_near(found, expected, groups=None):
    """Equal but for round-off of the largest value of a group."""
    expected = np.array(expected, dtype=float)
    found = np.array([float(str(value).replace("Infinity", "inf")) for value in found])
    names = np.array(groups if groups is not None else [""] * len(found))
    for group in dict.fromkeys(names):
        rows = names == group
        sizes = np.abs(expected[rows])
        near = NEAR * sizes[np.isfinite(sizes)].max(initial=1.0)
        np.testing.assert_allclose(found[rows], expected[rows], rtol=0, atol=near, err_msg=group)


CHANGED = 1.004
"""By how much numbers are changed: mechanisms can still be assembled, and round-off is far less."""


@cache
def changes(name):
    """For each number of the file, and for all at once: numbers, parameters, initial state."""
    own, varying = kernel(name), Varying(system(name).mechanism)
    values = [number.value for number in own.feed.numbers]
    # without closed forms each is assembled by a search, which takes its time
    every = range(0, len(values), 6 if system(name).layout.carried else 1)
    found = []
    for changed in (*({place} for place in every), set(every)):
        numbers = [v * (CHANGED if k in changed else 1.0) for k, v in enumerate(values)]
        paths = {own.feed.numbers[k].path: numbers[k] for k in changed}
        other = varying.at(paths)
        found.append((numbers, other.parameters, other.state))
    return found


def compared_parameters(name):
    """Places of parameters that follow from numbers: what tells round-off apart does not."""
    return [k for k, path in enumerate(kernel(name).parameters) if path != NEAREST]


FOLLOWED = ("joint_position", "slider_position")


def switched(name):
    """Times, and what `linkages.simulate` says of a mechanism whose equations or modes change."""
    times = np.linspace(0.0, PASSING[name][1] if name in PASSING else SWITCHED[name], 31)
    known = {quantity.variable for quantity in kernel(name).quantities}
    outputs = [variable for variable in FOLLOWED if variable in known]
    data = linkages.simulate(system(name).mechanism, times=times, rtol=1e-12, outputs=outputs).data
    known = [data[variable].values.reshape(31, -1) for variable in outputs]
    return times, np.hstack(known)


def followed_rows(name):
    """Places of the same among all outputs."""
    quantities = kernel(name).quantities
    return [k for v in FOLLOWED for k, q in enumerate(quantities) if q.variable == v]
