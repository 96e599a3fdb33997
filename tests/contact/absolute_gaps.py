"""Clearances with contact as a definition states them, read without the package under test."""

import math
import re
from dataclasses import dataclass

import yaml
from contact_laws import DAMPING_FACTORS
from friction_formulas import FORMULAS

UNITS = {"mm": 1e-3, "mm/s": 1e-3, "rpm": math.tau / 60, "deg": math.pi / 180}
FRICTION = ("friction", "static", "slip", "least_slip", "stribeck_speed")
FREE, CONTACT, SLACK = "free", "contact", "slack"


def number(value: object, default: float = 0.0) -> float:
    """A number in SI units from a number or a text such as ``0.2 mm``."""
    if value is None:
        return default
    first, _, unit = str(value).partition(" ")
    return float(first) * UNITS.get(unit, 1.0)


@dataclass(frozen=True)
class Gap:
    """One clearance: F = K dᵖ (1 + factor·d′) in contact, and friction along the wall.

    Parameters
    ----------
    chi, dissipation, damping
        One of them damps: χ by the first rate, a in 1 + a d′, or D of Kelvin and Voigt.
    carries
        What the displaced end is: ``"hole"`` or ``"pin"``.
    """

    name: str
    joint: str
    bar: str
    size: float
    stiffness: float
    exponent: float
    chi: float
    dissipation: float
    damping: float
    least_rate: float
    carries: str
    pin_radius: float
    friction: dict[str, float]
    friction_law: str
    offset: tuple[float, float]
    rate: tuple[float, float]

    def push(self, depth: float, speed: float, first: float) -> float:
        """What the law gives where it presses: negative where it would pull."""
        elastic = self.stiffness * depth**self.exponent
        if self.damping:
            return elastic + self.damping * speed
        return elastic * self.factor(speed, first)

    def rub(self, slip: float) -> float:
        """Friction against the slip over the normal force."""
        return FORMULAS[self.friction_law](slip, self.friction) if self.friction else 0.0

    def factor(self, speed: float, first: float) -> float:
        """The sign of the push, a smooth function at d = 0 as well (not for Kelvin and Voigt)."""
        return 1 + (self.chi / first if self.chi else self.dissipation) * speed


def gap_of(name: str, entry: dict) -> Gap:
    """The clearance of an entry of ``clearances``."""
    law = entry["contact"]
    restitution = number(entry.get("restitution"), 1.0)
    return Gap(
        name=name,
        joint=entry["joint"],
        bar=entry["bar"],
        size=number(entry["size"]),
        stiffness=number(entry["stiffness"]),
        exponent=number(entry.get("exponent"), 1.0 if law == "kelvin-voigt" else 1.5),
        chi=DAMPING_FACTORS[law](restitution) if law in DAMPING_FACTORS else 0.0,
        dissipation=number(entry.get("dissipation")),
        damping=number(entry.get("damping")),
        least_rate=number(entry.get("least_rate")),
        carries=entry.get("carries", "hole"),
        pin_radius=number(entry.get("pin_radius")),
        friction={key: number(entry[key]) for key in FRICTION if key in entry},
        friction_law=entry.get("friction_law", "tanh"),
        offset=tuple(number(v) for v in entry.get("offset", (0, 0))),
        rate=tuple(number(v) for v in entry.get("rate", (0, 0))),
    )


def taken_apart(definition: str) -> tuple[str, list[Gap]]:
    """The definition without its clearances, and the clearances."""
    content = yaml.safe_load(definition)
    entries = content.pop("clearances", {})
    text = yaml.safe_dump(content, sort_keys=False)
    # PyYAML reads 1e-5 as a text, and writes it in quotes
    text = re.sub(r"'([-+0-9.]+e[-+]?\d+)'", r"\1", text)
    return text, [gap_of(name, entry) for name, entry in entries.items()]
