"""Definitions with contact in one to three clearances, drawn from a seed.

The geometry is that of mechanisms which turn over, with lengths changed by some per cent; laws,
stiffness, friction, loads and starts are free within what machines of such sizes have.
"""

import numpy as np
import yaml
from contact_laws import DAMPING_FACTORS

FOUR_BAR = """
joints: {O: [0, 0], D: [0.3, 0.02]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.5, center: 0.03}
  rod: {joints: [A, B], length: 0.3, mass: 0.6}
  rocker: {joints: [D, B], length: 0.25, mass: 0.7}
drives: {crank: {angle: 0.7, speed: 12}}
assembly: {B: [0.27, 0.27]}
"""
SLIDER_CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.4, center: 0.02}
  rod: {joints: [A, B], length: 0.15, mass: 0.5}
sliders: {piston: {joint: B, through: [0, 0.005], angle: 0.1, mass: 0.3}}
drives: {crank: {angle: 1.0, speed: 30}}
assembly: {B: [0.18, 0.02]}
"""
SIX_BAR = """
joints: {O: [0, 0], D: [0.3, 0.02], G: [0.45, 0.3]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.5, center: 0.03}
  rocker: {joints: [D, B], length: 0.25, mass: 0.7}
  link: {joints: [P, Q], length: 0.22, mass: 0.4}
  arm: {joints: [G, Q], length: 0.2, mass: 0.5}
  rod:
    points: {A: [0, 0], B: [0.3, 0], P: [0.15, 0.1]}
    mass: 0.8
    center: [0.15, 0.04]
    inertia: 0.008
drives: {crank: {angle: 0.7, speed: 10}}
assembly: {B: [0.27, 0.27], P: [0.15, 0.28], Q: [0.37, 0.47]}
"""
PENDULUMS = """
joints: {O: [0, 0]}
bars:
  upper: {joints: [O, A], length: 0.3, mass: 0.5}
  lower: {joints: [A, B], length: 0.25, mass: 0.4}
masses: {B: 0.2}
free:
  upper: {angle: -0.9, speed: 1.0}
  lower: {angle: -1.2, speed: -2.0}
"""
TEMPLATES = {
    "four-bar": (FOUR_BAR, [("A", "rod"), ("B", "rocker"), ("D", "rocker")]),
    "slider-crank": (SLIDER_CRANK, [("A", "rod"), ("B", "rod")]),
    "six-bar": (SIX_BAR, [("A", "rod"), ("B", "rod"), ("Q", "link"), ("G", "arm"), ("P", "link")]),
    "pendulums": (PENDULUMS, [("O", "upper"), ("A", "lower")]),
}
ENDS = {"four-bar": 0.02, "slider-crank": 0.012, "six-bar": 0.02, "pendulums": 0.02}
"""Seconds in which pins hit their holes a few times, and errors grow a hundred- to thousandfold."""
LAWS = ("hertz", "hunt-crossley-constant", "kelvin-voigt", *DAMPING_FACTORS)


def plain(value: float) -> float:
    """Six digits: both programs shall read the same number."""
    return float(f"{value:.6g}")


def clearance(random: np.random.Generator, joint: str, bar: str) -> dict:
    """One clearance with a law, a start and perhaps friction."""
    size = plain(random.uniform(1e-4, 4e-4))
    law = str(random.choice(LAWS))
    entry = {"joint": joint, "bar": bar, "size": size, "contact": law}
    entry["stiffness"] = plain(10 ** random.uniform(8.5, 10))
    if law == "hunt-crossley-constant":
        entry["dissipation"] = plain(random.uniform(0.3, 1.5))
    elif law == "kelvin-voigt":
        entry["stiffness"] = plain(10 ** random.uniform(6.5, 7.5))
        entry["damping"] = plain(random.uniform(20, 300))
    elif law in DAMPING_FACTORS:
        entry["restitution"] = plain(random.uniform(0.4, 0.95))
        entry["least_rate"] = 1e-3
    if random.random() < 0.5:
        entry["friction"] = plain(random.uniform(0.02, 0.2))
        entry["slip"] = plain(random.uniform(5e-3, 5e-2))
    entry["pin_radius"] = plain(random.uniform(4e-3, 1.2e-2))
    entry["carries"] = str(random.choice(["hole", "pin"]))
    angle, share = random.uniform(0, 2 * np.pi), random.uniform(0, 0.8)
    entry["offset"] = [plain(share * size * f(angle)) for f in (np.cos, np.sin)]
    entry["rate"] = [plain(v) for v in random.uniform(-0.02, 0.02, 2)]
    return entry


def kind(seed: int) -> str:
    """Which of the templates a seed has."""
    return list(TEMPLATES)[seed % len(TEMPLATES)]


def definition(seed: int) -> str:
    """The text of a definition file."""
    random, name = np.random.default_rng(seed), kind(seed)
    text, places = TEMPLATES[name]
    content = yaml.safe_load(text)
    for bar in content["bars"].values():
        if "length" in bar:
            bar["length"] = plain(bar["length"] * random.uniform(0.97, 1.03))
    count = int(random.integers(1, min(3, len(places)) + 1))
    chosen = sorted(random.choice(len(places), count, replace=False))
    content["clearances"] = {
        f"gap{k}": clearance(random, *places[place]) for k, place in enumerate(chosen)
    }
    if random.random() < 0.7:
        content["gravity"] = [0, -9.81]
    loaded = "piston" if "sliders" in content else list(content["bars"])[-1]
    if random.random() < 0.5:
        keys, size = (("slider", "force"), 40) if loaded == "piston" else (("bar", "torque"), 2)
        values = loaded, plain(random.uniform(-size, size))
        content["loads"] = [dict(zip(keys, values, strict=True))]
    return yaml.safe_dump({"name": f"{name} {seed}", **content}, sort_keys=False)
