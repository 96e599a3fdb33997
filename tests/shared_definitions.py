"""Definitions that tests of several folders begin with; each adds sections of its own."""

# the pendulum of docs/chaos.md (Baker and Gollub, Chaotic Dynamics, with their g = 1.15)
DRIVEN_PENDULUM = """\
name: Driven pendulum
gravity: [0, -1]
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1}}
masses: {P: 1 kg}
dampers: [{joint: O, damping: 0.5}]
loads: [{bar: arm, torque: "1.15*cos(2*t/3)"}]
free: {arm: {angle: -1.2, speed: 0}}
"""

IMPACTS = """\
name: Impact oscillator
parameters: {A: 0.3, w: 1.2}
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 1}}
loads: [{slider: block, force: "A*cos(w*t) - block.position - 0.1*block.speed"}]
stops: [{slider: block, upper: 1, restitution: 0.8}]
free: {block: {position: 0, speed: 0}}
simulate: {end: 100, rtol: 1e-9}
"""

# its rod is too short for the crank to turn
STUCK = """
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 40 mm}, rod: {joints: [A, B], length: 35 mm, mass: 0.5}}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
drives: {crank: {angle: 0, speed: 60 rpm}}
assembly: {B: [75 mm, 0]}
"""

ENGINE = """
name: engine
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 50 mm, mass: 1}
  rod: {joints: [A, B], length: 150 mm, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.3}}
free: {crank: {angle: 10 deg, speed: 30}}
assembly: {B: [0.2, 0]}
simulate: {end: 0.4, samples: 81}
"""

DRIVEN_ROD = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: 0.5, speed: 0}}
loads: [{bar: rod, torque: "0.5*cos(2*t)"}]
simulate: {end: 5, rtol: 1e-6}
"""


def loaded_engine(sections: str) -> str:
    """A slider-crank whose piston is pushed back."""
    return f"""\
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}}
  rod: {{joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
loads: [{{slider: piston, force: -200 N}}]
assembly: {{B: [0.18, 0]}}
{sections}"""


def turning_engine(sections: str) -> str:
    """The same one with an inertia of its piston, which turns where its guide has room."""
    return loaded_engine(sections).replace("mass: 0.4}", "mass: 0.4, inertia: 1e-4}")


def worn_engine(sections: str) -> str:
    """The same one in millimetres, with the centre of its rod where it is by default."""
    return f"""\
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 40 mm, mass: 0.8, center: 10 mm}}
  rod: {{joints: [A, B], length: 140 mm, mass: 0.5}}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
loads: [{{slider: piston, force: -200 N}}]
assembly: {{B: [0.18, 0]}}
{sections}"""
