"""Definitions with one or two blocks in their guides, drawn from a seed."""

import numpy as np
import yaml
from random_contact import clearance, plain

CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.4, center: 0.02}
  rod: {joints: [A, B], length: 0.15, mass: 0.5}
sliders: {piston: {joint: B, through: [0, 0.005], angle: 0.1, mass: 0.3, inertia: 2e-4}}
drives: {crank: {angle: 1.0, speed: 30}}
assembly: {B: [0.18, 0.02]}
"""
INVERTED = """
joints: {O: [0, 0], D: [0.12, 0.01]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.4, center: 0.02}
  lever: {joints: [D, E], length: 0.3, mass: 0.5}
sliders:
  block: {joint: A, "on": lever, angle: 0.05, through: [0.01, 0.02], mass: 0.3, inertia: 1e-4}
drives: {crank: {angle: 1.0, speed: 30}}
assembly: {E: [-0.15, 0.1]}
"""
TRAMMEL = """
joints: {O: [0, 0]}
bars: {rod: {joints: [A, B], length: 0.2, mass: 0.5}}
sliders:
  across: {joint: A, through: O, mass: 0.3, inertia: 2e-4}
  up: {joint: B, through: O, angle: 1.5, mass: 0.2, inertia: 1e-4}
free: {rod: {angle: 2.2, speed: 12}}
"""
TEMPLATES = {
    "crank": (CRANK, ["piston"]),
    "inverted": (INVERTED, ["block"]),
    "trammel": (TRAMMEL, ["across", "up"]),
}


def play(random: np.random.Generator, slider: str) -> dict:
    """One block with a law, a start and perhaps friction."""
    entry = clearance(random, "", "")
    size = entry["size"]
    for key in ("joint", "bar", "pin_radius", "carries", "offset", "rate"):
        del entry[key]
    length, height = plain(random.uniform(0.03, 0.08)), plain(random.uniform(0.02, 0.06))
    entry |= {"slider": slider, "length": length, "height": height}
    entry["offset"] = plain(random.uniform(-0.5, 0.5) * size)
    entry["angle"] = plain(random.uniform(-0.8, 0.8) * size / length)
    entry["rate"] = plain(random.uniform(-0.05, 0.05))
    entry["speed"] = plain(random.uniform(-1.0, 1.0))
    return entry


def kind(seed: int) -> str:
    """Which of the templates a seed has."""
    return list(TEMPLATES)[seed % len(TEMPLATES)]


def definition(seed: int) -> str:
    """The text of a definition file."""
    random, name = np.random.default_rng(seed), kind(seed)
    text, sliders = TEMPLATES[name]
    content = yaml.safe_load(text)
    content["clearances"] = {f"play{k}": play(random, own) for k, own in enumerate(sliders)}
    if random.random() < 0.7:
        content["gravity"] = [0, -9.81]
    if name != "inverted" and random.random() < 0.5:
        content["loads"] = [{"slider": sliders[0], "force": plain(random.uniform(-40, 40))}]
    return yaml.safe_dump({"name": f"{name} {seed}", **content}, sort_keys=False)
