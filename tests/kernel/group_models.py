"""Mechanisms with a group that has no closed form: a plate that is held at three points."""

TRIAD = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.33, -0.07], D: [0.25, 0.39]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.2}
  leg1: {joints: [A, E], length: 0.23, mass: 0.3}
  leg2: {joints: [C, F], length: 0.15, mass: 0.3}
  leg3: {joints: [D, G], length: 0.21, mass: 0.3}
  plate: {points: {E: [0, 0], F: [0.2, 0], G: [0.09, 0.16]}, mass: 0.8, center: [0.097, 0.053],
    inertia: 4.0e-3}
drives: {crank: {angle: 0, speed: 3}}
assembly: {E: [0.138, 0.212], F: [0.217, 0.028], G: [0.321, 0.192]}
"""
WITH_SLIDER = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.33, -0.07], D: [0.25, 0.39]}
bars:
  crank: {joints: [O, A], length: 0.03, mass: 0.2}
  leg1: {joints: [A, E], length: 0.23, mass: 0.3}
  leg2: {joints: [C, F], length: 0.15, mass: 0.3}
  plate: {points: {E: [0, 0], F: [0.2, 0], G: [0.09, 0.16]}, mass: 0.8, center: [0.097, 0.053],
    inertia: 4.0e-3}
sliders: {shoe: {joint: G, through: [0.3, 0.15], angle: 100 deg, mass: 0.1}}
drives: {crank: {angle: 0, speed: 3}}
assembly: {E: [0.138, 0.212], F: [0.217, 0.028], G: [0.321, 0.192]}
"""
