"""Mechanisms of tests on equilibria, as definitions."""

G = 9.81


def chain(count):
    """Equal point masses on massless bars of one metre, nearly hanging."""
    points = ["O", *(f"P{k}" for k in range(count))]
    bars = [f"  b{k}: {{joints: [{points[k]}, {points[k + 1]}], length: 1}}" for k in range(count)]
    masses = ", ".join(f"P{k}: 1" for k in range(count))
    free = ", ".join(f"b{k}: {{angle: {-90 + 3 * (k % 2)} deg, speed: 0}}" for k in range(count))
    return "\n".join([
        f"gravity: [0, -{G}]", "joints: {O: [0, 0]}", "bars:", *bars, f"masses: {{{masses}}}",
        f"free: {{{free}}}",
    ])  # fmt: skip


TRUSS = """
joints: {A: [-1, 0], B: [1, 0], G: [0, 0]}
sliders: {apex: {joint: P, through: G, angle: 90 deg, mass: 2}}
springs:
  - {between: [A, P], stiffness: 1000, length: 1.2}
  - {between: [B, P], stiffness: 1000, length: 1.2}
loads: [{slider: apex, force: -10}]
free: {apex: {position: 0.5, speed: 0}}
"""
"""A von Mises truss: two springs k = 1000 of free length 1.2 over a half span of 1."""

BALANCER = f"""
gravity: [0, -{G}]
joints: {{O: [0, 0], H: [0, 0.3]}}
bars:
  arm:
    points: {{O: [0, 0], Q: [0.2, 0], P: [0.6, 0]}}
    mass: 2
    center: [0.4, 0]
    inertia: 0.05
springs: [{{between: [H, Q], stiffness: 100, length: 0}}]
free: {{arm: {{angle: 20 deg, speed: 0}}}}
"""
"""An arm held by a spring without free length, which balances it everywhere if it is right."""

FOUR_BAR = """
gravity: [0, -9.81]
joints: {{O: [0, 0], C: [0.4, 0], S: [{sx}, {sy}]}}
bars:
  crank: {{joints: [O, A], length: {a}, mass: 1}}
  coupler: {{joints: [A, B], length: {b}, mass: 2}}
  rocker: {{joints: [C, B], length: {c}, mass: 1.5}}
springs:
  - {{between: [A, C], stiffness: 200, length: 0.3}}
  - {{between: [B, S], stiffness: 90, length: 0.2}}
"""

FRICTION = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 3, inertia: 0}}
friction: [{joint: O, torque: 2}]
free: {rod: {angle: -70 deg, speed: 0}}
"""

SERIES = """
joints: {O: [0, 0], W: [2, 0]}
sliders:
  a: {joint: A, through: O, angle: 0, mass: 2}
  b: {joint: B, through: O, angle: 0}
springs:
  - {between: [O, A], stiffness: 100, length: 0.5, damping: 1}
  - {between: [A, B], stiffness: 50, length: 0.5}
  - {between: [B, W], stiffness: 50, length: 0.5, damping: DAMPING}
free: {a: {position: 0.6, speed: 0}, b: {position: 1.2, speed: 0}}
"""
"""A mass between springs, and a massless block between two of them."""
