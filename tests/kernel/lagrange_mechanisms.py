"""Mechanisms beyond bars and ground sliders, for `test_kernel_lagrange`: one of each kind."""

QUICK_RETURN = """
gravity: [0.5, -9.81]
joints: {O: [0, 0], P: [0.05, -0.4]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.8, center: 0.05}
  lever: {joints: [P, B], length: 0.75, mass: 2.1, center: [0.4, 0.02]}
  link: {joints: [B, C], length: 0.5, mass: 0.9}
sliders:
  block: {joint: A, on: lever, through: [0.1, 0.03], angle: 4 deg, mass: 0.4, inertia: 2e-3}
  ram: {joint: C, through: [0, 0.5], mass: 3}
CLEARANCE
drives: {crank: {angle: 0, speed: 4}}
loads:
  - {slider: block, force: 12}
  - {slider: ram, force: {harmonic: {amplitude: 50, frequency: 1 Hz}}}
dampers: [{slider: block, damping: 3}, {slider: ram, damping: 7}, {joint: P, damping: 0.4}]
springs: [{between: [O, B], stiffness: 300, length: 0.3, damping: 5}]
"""

SCOTCH_YOKE = """
gravity: [0, -9.81]
joints: {O: [0, 0.1]}
bars: {crank: {joints: [O, A], length: 0.2, mass: 0.5}}
sliders:
  yoke: {joint: Y, through: [0, -0.1], angle: 10 deg, mass: 2, points: {Z: [0.1, 0.05]}}
  pin: {joint: A, on: yoke, through: [0.02, 0.01], angle: 85 deg, mass: 0.3}
free: {crank: {angle: 0, speed: 4}}
springs: [{between: [O, Z], stiffness: 90, length: 0}]
dampers: [{slider: pin, damping: 2}, {between: [O, Z], damping: 4}]
"""

CYLINDER = """
gravity: [0, -9.81]
joints: {O: [0, 0], P: [0.6, -0.1], R: [1.1, 0.2]}
bars:
  boom:
    points: {O: [0, 0], A: [0.7, 0.1], T: [1.2, 0]}
    mass: 12
    center: [0.6, 0.05]
    inertia: 1.4
  barrel: {joints: [P, Q], length: 0.3, mass: 2}
  stick: {joints: [T, E], length: 0.5, mass: 1.5}
  rest: {joints: [R, E], length: 0.75, mass: 0.7}
sliders:
  rod: {joint: A, on: barrel, mass: 1.1, inertia: 0.02, points: {M: [-0.1, 0.02]}}
masses: {E: 4, M: 0.5, T: 0.2}
drives: {rod: {law: LAW}}
loads: [{joint: E, force: [30, {rise: polynomial, to: 100, duration: 1}]}, {bar: stick, torque: 7}]
"""

LAWS = {
    "formula": "0.45 + 0.1*sin(3*t)**2 - 0.02*exp(-t)*sqrt(1 + t**2)"
    " + 0.01*atan(t)*tanh(t)/log(3 + t)*tan(cos(t))",
    "rise": "{rise: modified-sine, from: 0.4, to: 0.55, begin: 0.3, duration: 1.3}",
    "cycloidal": "{rise: cycloidal, from: 0.42, to: 0.55, begin: 0.3, duration: 1.3}",
    "table": "{table: {times: [0.1, 0.5, 0.8, 1.4], values: [0.4, 0.5, 0.45, 0.55]}}",
    "periodic": "{table: {times: [0, 0.5, 0.8, 1.4], values: [0.4, 0.5, 0.45, 0.4],"
    " periodic: true}}",
    "run-up": "{run-up: {from: 0.4, speed: 0.1, duration: 0.8}}",
    "harmonic": "{harmonic: {amplitude: 0.05, frequency: 0.7 Hz, mean: 0.45}}",
}

FLOATING_GUIDES = """
gravity: [1, -9.81]
joints: {O: [0, 0], C: [0.8, 0], G: [0.3, -0.5]}
bars:
  crank: {joints: [O, A], length: 0.25, mass: 1}
  coupler:
    points: {A: [0, 0], B: [0.7, 0.05], S: [0.3, 0.2]}
    mass: 2
    center: [0.3, 0.1]
    inertia: 0.1
  rocker: {joints: [C, B], length: 0.5, mass: 1}
  swing: {joints: [G, D], length: 0.6, mass: 0.8}
sliders:
  runner:
    {joint: D, on: coupler, through: S, angle: 70 deg, mass: 0.5, inertia: 1e-3,
     points: {K: [0.05, 0.02]}}
  rider: {joint: V, on: runner, through: [0.02, 0.01], angle: 30 deg, mass: 0.2}
drives: {crank: {angle: 0, speed: 2}}
free: {rider: {position: 0.05, speed: 0}}
springs: [{between: [V, S], stiffness: 200, length: 0.1, damping: 2}]
loads: [{slider: runner, force: 5}, {joint: V, force: [3, -4]}]
dampers: [{slider: rider, damping: 1.5}]
"""

CROSSED_SLIDERS = """
joints: {O: [0, 0]}
gravity: [0, -9.81]
bars: {crank: {joints: [O, A], length: 0.3, mass: 1}}
sliders:
  across: {joint: P, through: O, angle: 20 deg, mass: 1.5}
  up: {joint: A, on: across, angle: 75 deg, mass: 0.5}
drives: {crank: {angle: 0, speed: 3}}
"""

CLASS_THREE = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1.0, 0.1], D: [0.45, 0.9]}
bars:
  crank: {joints: [O, A], length: 0.12, mass: 0.6, center: [0.05, 0.01]}
  leg1: {joints: [A, E], length: 0.38, mass: 0.9}
  leg2: {joints: [C, F], length: 0.42, mass: 0.8, center: 0.2}
  leg3: {joints: [D, G], length: 0.45, mass: 0.7}
  plate:
    points: {E: [0, 0], F: [0.36, 0], G: [0.17, 0.2]}
    mass: 2.2
    center: [0.2, 0.07]
    inertia: 0.06
CLEARANCE
KNOWN
loads: [{joint: G, force: [4, 9]}, {bars: [leg1, plate], torque: 3}]
springs:
  - {between: [O, G], stiffness: 50, length: 0.6, damping: 1}
  - {between_bars: [leg2, plate], stiffness: 2, angle: 30 deg, damping: 0.3}
masses: {F: 0.4}
assembly: {E: [0.35, 0.3], F: [0.7, 0.35], G: [0.5, 0.5]}
"""

CLASS_THREE_SLIDER = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [1.0, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.12, mass: 0.6}
  leg1: {joints: [A, E], length: 0.38, mass: 0.9}
  leg2: {joints: [C, F], length: 0.42, mass: 0.8}
  plate:
    points: {E: [0, 0], F: [0.36, 0], G: [0.17, 0.2]}
    mass: 2.2
    center: [0.2, 0.07]
    inertia: 0.06
sliders: {shoe: {joint: G, through: [0.5, 0], angle: 80 deg, mass: 0.5}}
drives: {crank: {angle: 0, speed: 3}}
dampers: [{slider: shoe, damping: 4}]
assembly: {E: [0.31, 0.33]}
"""

PARALLELOGRAM = """
gravity: [0, -9.81]
joints: {O: [0, 0], P: [0.4, 0], Q: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.2, mass: 0.6}
  second: {joints: [P, B], length: 0.2, mass: 0.5}
  third: {joints: [Q, C], length: 0.2, mass: 0.4, center: [0.1, 0.02]}
  beam: {points: {A: [0, 0], B: [0.4, 0], C: [1, 0]}, mass: 3, center: [0.5, 0.1], inertia: 0.2}
KNOWN
masses: {C: 0.3}
assembly: {A: [0, 0.2], B: [0.4, 0.2], C: [1, 0.2]}
"""

PULLED_TABLE = """
gravity: [0, -9.81]
joints: {O: [-0.6, 0], P: [0, 0], Q: [1, 0], S: [0.4, -0.1]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.3}
  rod: {joints: [A, R], length: 0.95, mass: 0.8}
  first: {joints: [P, B], length: 0.3, mass: 0.5}
  second: {joints: [Q, C], length: 0.3, mass: 0.4, center: [0.1, 0.02]}
  third: {joints: [S, D], length: 0.3, mass: 0.2}
  table:
    points: {B: [0, 0], C: [1, 0], D: [0.4, -0.1], R: [0.2, 0.05]}
    mass: 3
    center: [0.5, 0.1]
    inertia: 0.2
springs: [{between: [O, C], stiffness: 40, length: 1.2, damping: 3}]
drives: {crank: {angle: 0.3, speed: 3}}
assembly: {B: [0.15, 0.26], R: [0.35, 0.31]}
"""

GEARED_FIVE_BAR = """
gravity: [0, -9.81]
joints: {O: [0, 0], P: [0.5, 0]}
bars:
  crank: {joints: [O, A], length: 0.2, mass: 1}
  other: {joints: [P, B], length: 0.15, mass: 0.8, center: [0.1, 0.02]}
  left: {joints: [A, C], length: 0.45, mass: 0.6}
  right: {joints: [B, C], length: 0.5, mass: 0.7}
gears: [{bars: [BARS], ratio: RATIO, angle: 0.3}]
springs: [{between_bars: [left, right], stiffness: 3, angle: 1, damping: 0.2}]
loads: [{joint: C, force: [5, 2]}]
KNOWN
"""

PLANETARY = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, A], length: 0.2, mass: 1}
  sun: {points: {O: [0, 0], S: [0.05, 0]}, mass: 1, center: [0.01, 0], inertia: 3e-3}
  planet: {points: {A: [0, 0], T: [0.1, 0.02]}, mass: 0.7, center: [0.02, 0.01], inertia: 2e-3}
  rod: {joints: [T, E], length: 0.6, mass: 0.5}
sliders: {ram: {joint: E, through: [0, 0.05], angle: 10 deg, mass: 1}}
gears: [{bars: [sun, planet], ratio: -1.5, carrier: arm}]
masses: {T: 0.2}
springs: [{bar: planet, stiffness: 1.5, angle: 0.3, damping: 0.05}]
drives: {sun: {angle: 0, speed: 2}}
free: {arm: {angle: 0.4, speed: 0}}
loads: [{bar: planet, torque: "2*cos(3*t)"}]
"""

FIXED_SUN = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, A], length: 0.2, mass: 1}
  planet: {points: {A: [0, 0], T: [0.1, 0.02]}, mass: 0.7, center: [0.02, 0.01], inertia: 2e-3}
gears: [{bars: [ground, planet], ratio: -2, carrier: arm}]
free: {arm: {angle: 0.4, speed: 0}}
springs: [{between_bars: [arm, planet], stiffness: 3, angle: 0.5}]
"""

WELDED = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.5, 0.1], W: [0.1, -0.2]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.5}
  coupler: {joints: [A, B], length: 0.55, mass: 1.1, center: 0.4}
  arm: {joints: [B, T], length: 0.2, mass: 0.3, center: [0.1, 0.01]}
  rocker: {joints: [C, T], length: 0.45, mass: 0.7}
  bracket: {joints: [W, V], length: 0.3, mass: 0.2}
sliders: {shoe: {joint: Z, on: arm, through: [0.05, 0], angle: 90 deg, mass: 0.3, inertia: 1e-3}}
welds: {B: {bars: [coupler, arm], angle: 50 deg}, W: {bars: [ground, bracket], angle: 35 deg}}
KNOWN
springs: [{between: [V, Z], stiffness: 70, length: 0.2, damping: 1.5}]
dampers: [{joint: T, damping: 0.3}]
"""

SPRING_PENDULUMS = """
gravity: [0, -9.81]
joints: {O: [0, 0], H: [0.7, 0.1]}
bars:
  upper: {joints: [O, A], length: 0.4, mass: 1}
  lower: {joints: [A, B], length: 0.3, mass: 0.7}
  third: {joints: [H, K], length: 0.35, mass: 0.5}
masses: {B: 0.8, K: 0.2}
free: {upper: {angle: 0, speed: 0}, lower: {angle: 0, speed: 0}, third: {angle: 0, speed: 0}}
springs:
  - {between: [H, B], stiffness: 40, length: 0.5, damping: 0.7}
  - {between: [A, K], stiffness: 20, length: 0}
  - {bar: upper, stiffness: 5, angle: 0.2, damping: 0.1}
  - {between_bars: [third, lower], stiffness: 2, angle: -1}
dampers: [{joint: A, damping: 0.3}, {between: [O, K], damping: 1.1}]
loads:
  - {bars: [upper, lower], torque: {harmonic: {amplitude: 2, frequency: 1 Hz, phase: 20 deg}}}
  - {bar: third, torque: {rise: harmonic, from: 1, to: 2, begin: 0.2, duration: 1}}
  - {joint: B, force: ["3*sin(5*t)", {table: {times: [0, 0.5, 1, 1.8], values: [1, 5, -3, 2]}}]}
"""

LOADED_CLEARANCES = """
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.5, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.5}
  coupler: {joints: [A, B], length: 0.55, mass: 1.1, center: 0.4}
  rocker: {joints: [C, B], length: 0.35, mass: 0.7, center: [0.1, -0.03]}
clearances:
  rA: {joint: A, bar: coupler, size: 4 mm}
  rC: {joint: C, bar: rocker, size: 3 mm}
drives: {crank: {angle: 0, speed: 9}}
masses: {B: 0.4}
springs: [{between: [O, B], stiffness: 80, length: 0.3, damping: 2}]
dampers: [{clearance: rA, damping: 1e-3}, {joint: B, damping: 0.1}]
loads: [{joint: B, force: [20, -5]}, {bar: rocker, torque: 3}]
"""

ACTUATED = """
gravity: [0, -9.81]
joints: {O: [0, 0], H: [0.7, 0.1]}
bars:
  upper: {joints: [O, A], length: 0.4, mass: 1}
  lower: {joints: [A, B], length: 0.3, mass: 0.7}
sliders:
  cart: {joint: C, through: H, angle: 30 deg, mass: 2}
  shoe: {joint: D, on: lower, through: [0.1, 0.02], angle: 70 deg, mass: 0.2}
free:
  upper: {angle: 0, speed: 0}
  lower: {angle: 0, speed: 0}
  cart: {position: 0, speed: 0}
  shoe: {position: 0, speed: 0}
springs:
  - {slider: cart, stiffness: 200, position: 5 cm, damping: 1}
  - {slider: shoe, stiffness: 30, damping: 0.2}
  - {between: [H, B], force: 30, damping: 0.5}
loads:
  - {joint: B, on: lower, force: [3, 2]}
  - {joint: A, on: shoe, force: [0, "1 + sin(t)"]}
  - {joint: D, on: upper, force: ["2*t", -1]}
  - {between: [O, B], force: "20*sin(3*t)"}
"""

MOTORISED = """
gravity: [0, -9.81]
joints: {O: [0, 0], H: [0.3, -0.2]}
bars:
  boom: {joints: [O, A], length: 0.8, mass: 10}
  tip: {joints: [A, B], length: 0.3, mass: 2}
free: {boom: {angle: 0.5, speed: 0}, tip: {angle: -1, speed: 0}}
cylinders:
  lift:
    {between: [H, A], bore: 20 mm, rod: 10 mm, pressure: "5e5*(1 + 0.1*sin(5*t))",
     rod_pressure: 0.5 bar, damping: 20}
  strut: {between: [H, B], bore: 22 mm, gas_pressure: 8 bar, length: 0.8, volume: 300 cm^3}
  slow:
    {between: [O, B], bore: 22 mm, gas_pressure: 2 bar, length: 0.8, volume: 1 liter, exponent: 1}
motors:
  wrist:
    {bar: tip, against: boom, stall_torque: 0.5, no_load_speed: 1500 rpm, gear_ratio: 20,
     rotor_inertia: 30 g*cm**2, joint: A}
  base:
    {bar: boom, voltage: "12*cos(t)", torque_constant: 0.05, resistance: 1.2, gear_ratio: -10}
"""

RACK = """
gravity: [0.3, -9.81]
joints: {O: [0, 0]}
bars:
  pinion: {joints: [O, A], length: 0.05, mass: 1, center: [0.02, 0.01]}
  rod: {joints: [A, B], length: 0.3, mass: 0.5}
sliders:
  rack: {joint: R, through: [0, 0.05], angle: 20 deg, mass: 3}
  block: {joint: B, on: rack, through: [0, -0.05], angle: 60 deg, mass: 0.3}
racks: [{slider: rack, bar: pinion, radius: -50 mm, offset: 0.1}]
KNOWN
springs: [{slider: rack, stiffness: 200}, {bar: pinion, stiffness: 2, angle: 1, damping: 0.1}]
dampers: [{slider: block, damping: 2}]
loads: [{slider: rack, force: "5*sin(t)"}]
"""

ROLLING_WHEEL = """
gravity: [0, -9.81]
joints: {O: [0, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.3}
  rod: {joints: [A, P], length: 0.5, mass: 0.6, center: [0.2, 0.01]}
  wheel: {points: {C: [0, 0], P: [0.03, 0.02]}, mass: 2, center: [0.01, 0], inertia: 0.01}
sliders: {carriage: {joint: C, through: [0, 0.1], angle: 5 deg, mass: 1}}
racks: [{slider: carriage, bar: wheel, radius: -0.1, offset: 0.5}]
KNOWN
assembly: {P: [0.5, 0.14]}
loads: [{slider: carriage, force: 3}]
dampers: [{slider: carriage, damping: 0.5}, {joint: C, damping: 0.02}]
"""

RACK_ON_ARM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  arm: {joints: [O, E], length: 0.6, mass: 2}
  pinion: {points: {M: [0, 0], N: [0.04, 0]}, mass: 0.5, center: [0.01, 0], inertia: 1e-3}
  hub: {joints: [O, M], length: 0.3, mass: 0.1}
sliders:
  rack: {joint: R, on: arm, through: [0.1, 0.05], angle: 10 deg, mass: 0.7}
  weight: {joint: W, through: [-0.2, 0], angle: 90 deg, mass: 1.5}
welds: {O: {bars: [arm, hub], angle: 0}}
racks:
  - {slider: rack, bar: pinion, radius: 0.05, carrier: arm}
  - {sliders: [rack, weight], ratio: -2, offset: 0.3}
KNOWN
springs:
  - {between_bars: [arm, pinion], stiffness: 3}
  - {between: [O, R], stiffness: 20, length: 0.1}
"""

CAM = """
gravity: [0.3, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 1, center: [0.02, 0.01]}
  rod: {joints: [V, B], length: 0.3, mass: 0.5}
sliders:
  valve: {joint: V, through: [0, 0.05], angle: 80 deg, mass: 0.3}
  foot: {joint: B, through: [0.2, 0], angle: 5 deg, mass: 0.2}
cams:
  - {slider: valve, bar: crank, angles: [0, 1, 2, 3.5, 5, 360 deg], lifts: [0, 0.01, 0.03, 0.04,
     0.02, 0], offset: 0.03, base_radius: 0.04}
KNOWN
springs: [{slider: valve, stiffness: 200}]
dampers: [{slider: foot, damping: 2}]
"""

DRIVEN = "drives: {crank: {angle: 0.5, speed: 3}}"
FREE = "free: {crank: {angle: 0.5, speed: 3}}"


def filled(text: str, **words: str) -> str:
    """A text with some words replaced."""
    for word, value in words.items():
        text = text.replace(word, value)
    return text


MORE_MECHANISMS = {
    "quick-return": filled(QUICK_RETURN, CLEARANCE=""),
    "quick-return-loose": filled(
        QUICK_RETURN, CLEARANCE="clearances: {rB: {joint: B, bar: link, size: 2 mm}}"
    ),
    "scotch-yoke": SCOTCH_YOKE,
    **{f"cylinder-{name}": filled(CYLINDER, LAW=law) for name, law in LAWS.items()},
    "floating-guides": FLOATING_GUIDES,
    "crossed-sliders": CROSSED_SLIDERS,
    "class-three": filled(CLASS_THREE, CLEARANCE="", KNOWN=DRIVEN),
    "class-three-free": filled(CLASS_THREE, CLEARANCE="", KNOWN=FREE),
    "class-three-loose": filled(
        CLASS_THREE, CLEARANCE="clearances: {r: {joint: F, bar: leg2, size: 5 mm}}", KNOWN=DRIVEN
    ),
    "class-three-slider": CLASS_THREE_SLIDER,
    "parallelogram-driven": filled(PARALLELOGRAM, KNOWN="drives: {crank: {angle: pi/2, speed: 3}}"),
    "parallelogram-free": filled(PARALLELOGRAM, KNOWN="free: {crank: {angle: pi/2, speed: 3}}"),
    "pulled-table": PULLED_TABLE,
    "geared-five-bar": filled(GEARED_FIVE_BAR, BARS="crank, other", RATIO="-1", KNOWN=DRIVEN),
    "geared-five-bar-free": filled(GEARED_FIVE_BAR, BARS="crank, other", RATIO="-2", KNOWN=FREE),
    "geared-five-bar-middle": filled(GEARED_FIVE_BAR, BARS="crank, left", RATIO="-1.5", KNOWN=FREE),
    "planetary": PLANETARY,
    "fixed-sun": FIXED_SUN,
    "welded": filled(WELDED, KNOWN=DRIVEN + "\nfree: {shoe: {position: 0.1, speed: 0}}"),
    "welded-free": filled(
        WELDED, KNOWN="free: {crank: {angle: 0, speed: 0}, shoe: {position: 0.1, speed: 0}}"
    ),
    "spring-pendulums": SPRING_PENDULUMS,
    "loaded-clearances": LOADED_CLEARANCES,
    "actuated": ACTUATED,
    "motorised": MOTORISED,
    "cam": filled(CAM, KNOWN=DRIVEN),
    "cam-free": filled(CAM, KNOWN=FREE),
    "rack": filled(RACK, KNOWN="free: {pinion: {angle: 0.5, speed: 2}}"),
    "rack-from-slider": filled(RACK, KNOWN="free: {rack: {position: 0.1, speed: 2}}"),
    "rack-from-block": filled(RACK, KNOWN="free: {rod: {angle: 0.1, speed: 2}}"),
    "rolling-wheel": filled(ROLLING_WHEEL, KNOWN=DRIVEN),
    "rolling-wheel-free": filled(ROLLING_WHEEL, KNOWN="free: {carriage: {position: 0.5}}"),
    "rack-on-arm": filled(
        RACK_ON_ARM, KNOWN="free: {arm: {angle: 0.4, speed: 0}, pinion: {angle: 0.1, speed: 1}}"
    ),
    "rack-on-arm-from-weight": filled(
        RACK_ON_ARM, KNOWN="free: {arm: {angle: 0.4, speed: 0}, weight: {position: 0.1, speed: 1}}"
    ),
}
