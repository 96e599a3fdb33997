"""Mechanisms whose orbits are known."""

import json
from pathlib import Path

import numpy as np

import linkages

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "orbits.json").read_text("utf-8"))


def impact_oscillator(amplitude=1.0, frequency=1.0, position=0.0, speed=0.0):
    """x″ + 0.1 x′ + x = A cos(ω t) with a rigid stop at x = 1, restitution 0.8."""
    return linkages.loads(f"""
name: Impact oscillator
gravity: [0, 0]
parameters: {{A: {amplitude!r}, w: {frequency!r}}}
joints: {{O: [0, 0]}}
sliders: {{mass: {{joint: P, through: O, angle: 0, mass: 1}}}}
springs: [{{slider: mass, stiffness: 1, damping: 0.1, position: 0}}]
loads: [{{slider: mass, force: A*cos(w*t)}}]
stops: [{{slider: mass, upper: 1, restitution: 0.8, least_rate: 1e-6}}]
free: {{mass: {{position: {position!r}, speed: {speed!r}}}}}
simulate: {{end: 20, rtol: 1e-12}}
""")


def driven_pendulum(torque=1.05):
    """θ″ + θ′/2 + sin θ = g cos(2t/3), θ from the hanging position."""
    return linkages.loads(f"""
name: Driven pendulum
gravity: [0, -1]
parameters: {{g: {torque!r}}}
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}}}}
dampers: [{{bars: [ground, rod], damping: 0.5}}]
loads: [{{bar: rod, torque: g*cos(2*t/3)}}]
free: {{rod: {{angle: -90 deg, speed: 0}}}}
simulate: {{end: 100, rtol: 1e-12}}
""")


def slider(force, parameters, position=0.3, speed=0.0, rtol="1e-12", end=200):
    """A mass of 1 kg on a guide under a force."""
    return linkages.loads(f"""
gravity: [0, 0]
parameters: {{{parameters}}}
joints: {{O: [0, 0]}}
sliders: {{mass: {{joint: P, through: O, angle: 0, mass: 1}}}}
loads: [{{slider: mass, force: "{force}"}}]
free: {{mass: {{position: {position!r}, speed: {speed!r}}}}}
simulate: {{end: {end}, rtol: {rtol}}}
""")


def pendulum(torque, angle=-90, speed=0.0, damping=0.1):
    """φ″ + damping φ′ + sin φ = torque, φ from the hanging position."""
    damper = f"dampers: [{{bars: [ground, rod], damping: {damping!r}}}]" if damping else ""
    return linkages.loads(f"""
gravity: [0, -1]
parameters: {{m: {torque!r}}}
joints: {{O: [0, 0]}}
bars: {{rod: {{joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}}}}
{damper}
loads: [{{bar: rod, torque: m}}]
free: {{rod: {{angle: {angle!r} deg, speed: {speed!r}}}}}
simulate: {{end: 100, rtol: 1e-12}}
""")


def truss():
    """Two springs of 1 N/m and 1.2 m between supports 2 m apart and an apex that a load presses."""
    return linkages.loads("""
gravity: [0, 0]
parameters: {load: 0.0}
joints: {L: [-1, 0], R: [1, 0], O: [0, 0]}
sliders: {apex: {joint: P, through: O, angle: 90 deg, mass: 1}}
springs:
  - {between: [L, P], stiffness: 1, length: 1.2, damping: 0.2}
  - {between: [R, P], stiffness: 1, length: 1.2}
loads: [{slider: apex, force: -load}]
free: {apex: {position: 0.6, speed: 0}}
simulate: {end: 100, rtol: 1e-12}
""")


def contact_slider_crank(size="0.12 mm"):
    """The slider-crank of docs/contact_published.md whose period doubles below 0.1194 mm."""
    return linkages.loads(f"""
gravity: [0, 0]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 50 mm, mass: 0.30, center: 25 mm, inertia: 1e-5}}
  rod: {{joints: [A, B], length: 120 mm, mass: 0.21, center: 60 mm, inertia: 2.5e-4}}
sliders: {{piston: {{joint: B, through: O, angle: 0, mass: 0.14}}}}
clearances:
  gap:
    joint: B
    bar: rod
    size: {size}
    contact: hunt-crossley-constant
    stiffness: 6.61e10 N/m^1.5
    dissipation: 0.5 s/m
    pin_radius: 9.5 mm
drives: {{crank: {{angle: 0, speed: 5000 rpm}}}}
assembly: {{B: [0.17, 0]}}
simulate: {{end: 0.024, rtol: 1e-11}}
""")


def points(data, kind):
    """Values of the first parameter at the special points of a kind."""
    return [float(data["value"][k, 0]) for k in range(data.sizes["point"]) if data.kind[k] == kind]


CONTACTS = (
    "contact: hunt-crossley-constant, stiffness: 1e8 N/m^1.5, dissipation: 0.5 s/m, "
    "pin_radius: 9 mm",
    "contact: hunt-crossley-constant, stiffness: 1e8 N/m^1.5, dissipation: 0.5 s/m, "
    "pin_radius: 9 mm, friction: 0.1, slip: 10 mm/s",
)


def random_four_bar(seed):
    """A crank-rocker with random lengths and speed, and contact in the joint of its coupler."""
    draw = np.random.default_rng(seed).uniform
    coupler, rocker, ground = draw(0.3, 0.4), draw(0.25, 0.35), draw(0.3, 0.38)
    return linkages.loads(f"""
gravity: [0, -9.81]
joints: {{O: [0, 0], D: [{ground}, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.1, mass: 0.3}}
  coupler: {{joints: [A, B], length: {coupler}, mass: 0.4}}
  rocker: {{joints: [D, B], length: {rocker}, mass: 0.5}}
clearances: {{gap: {{joint: B, bar: coupler, size: 0.1 mm, {CONTACTS[seed % 2]}}}}}
drives: {{crank: {{angle: 0, speed: {draw(3, 10):.3f}}}}}
assembly: {{B: [{ground}, 0.25]}}
dampers: [{{bars: [ground, rocker], damping: 0.1}}]
friction: [{{joint: D, torque: {0.02 * (seed % 3)}}}]
stops: [{{bars: [ground, rocker], upper: {draw(95, 115):.2f} deg, stiffness: 5, damping: 0.1}}]
simulate: {{end: 1, rtol: 1e-12}}
""")
