"""Maps whose motion is known."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from make.verdicts.known import Known, of_map
from make.verdicts.own_systems import Map

GOLDEN = (math.sqrt(5) - 1) / 2
MAY = "R. M. May, Nature 261 (1976) 459"
SPROTT = "J. C. Sprott, Chaos and Time-Series Analysis (2003)"
FEIGENBAUM = "M. J. Feigenbaum, J. Stat. Phys. 19 (1978) 25"


def logistic(r: float, start: float = 0.3) -> Map:
    return Map(lambda x: r * x * (1 - x), lambda x: [[r * (1 - 2 * x[0])]], [start])


def ricker(r: float) -> Map:
    return Map(
        lambda x: x * np.exp(r * (1 - x)),
        lambda x: [[(1 - r * x[0]) * math.exp(r * (1 - x[0]))]],
        [0.4],
    )


def henon(a: float, b: float = 0.3) -> Map:
    return Map(
        lambda x: (1 - a * x[0] ** 2 + x[1], b * x[0]),
        lambda x: ((-2 * a * x[0], 1.0), (b, 0.0)),
        [0.1, 0.1],
    )


def delayed(a: float) -> Map:
    return Map(
        lambda x: (a * x[0] * (1 - x[1]), x[0]),
        lambda x: ((a * (1 - x[1]), -a * x[0]), (1.0, 0.0)),
        [0.4, 0.45],
    )


def circle(omega: float, strength: float) -> Map:
    return Map(
        lambda x: x + 2 * math.pi * omega - strength * np.sin(x),
        lambda x: [[1 - strength * math.cos(x[0])]],
        [0.2],
        angles=[True],
    )


def standard(strength: float, angle: float, momentum: float) -> Map:
    def rule(x):
        p = x[1] + strength * math.sin(x[0])
        return x[0] + p, p

    def jacobian(x):
        slope = strength * math.cos(x[0])
        return (1 + slope, 1.0), (slope, 1.0)

    return Map(rule, jacobian, [angle, momentum], angles=[True, True])


@cache
def golden(strength: float) -> float:
    """Momentum at angle π of the curve of the standard map that turns by the golden section.

    Between the islands at 0 and 1/1 turns a step grow with momentum there.
    """
    low, high = math.pi, 2 * math.pi
    for _ in range(40):
        momentum = 0.5 * (low + high)
        if _turns(strength, momentum) < GOLDEN:
            low = momentum
        else:
            high = momentum
    return 0.5 * (low + high)


def _turns(strength: float, momentum: float) -> float:
    """Mean turns of a step, with weights that vanish at both ends (Das et al., 2017)."""
    count, angle, rates = 20_000, math.pi, []
    for _ in range(count):
        momentum += strength * math.sin(angle)
        angle += momentum
        rates.append(momentum)
    place = (np.arange(count) + 0.5) / count
    weights = np.exp(-1 / (place * (1 - place)))
    return float(weights @ rates / weights.sum() / (2 * math.pi))


def lozi() -> Map:
    return Map(
        lambda x: (1 - 1.7 * abs(x[0]) + x[1], 0.5 * x[0]),
        lambda x: ((-1.7 * math.copysign(1, x[0]), 1.0), (0.5, 0.0)),
        [-0.1, 0.1],
    )


def cat() -> Map:
    return Map(
        lambda x: (x[0] + x[1], x[0] + 2 * x[1]),
        lambda _: ((1.0, 1.0), (1.0, 2.0)),
        [0.5, 0.7],
        angles=[True, True],
    )


def translation(first: float, second: float) -> Map:
    return Map(
        lambda x: (x[0] + 2 * math.pi * first, x[1] + 2 * math.pi * second),
        lambda _: np.eye(2),
        [0.3, 0.4],
        angles=[True, True],
    )


def area_preserving(start: float) -> Map:
    cos, sin = 0.4, math.sqrt(1 - 0.4**2)
    return Map(
        lambda x: (
            x[0] * cos - (x[1] - x[0] ** 2) * sin,
            x[0] * sin + (x[1] - x[0] ** 2) * cos,
        ),
        lambda x: (
            (cos + 2 * x[0] * sin, -sin),
            (sin - 2 * x[0] * cos, cos),
        ),
        [start, 0.0],
    )


def mcmillan() -> Map:
    mu = 0.8

    def slope(y: float) -> float:
        return 2 * mu * (1 - y * y) / (1 + y * y) ** 2

    return Map(
        lambda x: (x[1], -x[0] + 2 * mu * x[1] / (1 + x[1] ** 2)),
        lambda x: ((0.0, 1.0), (-1.0, slope(x[1]))),
        [0.5, 0.1],
    )


def froeschle(strength: float, coupling: float, start: list[float]) -> Map:
    """Two standard maps, coupled: C. Froeschlé, Astrophys. Space Sci. 14 (1971) 110."""

    def rule(x):
        shared = coupling * math.sin(x[0] + x[1])
        p = x[2] + strength * math.sin(x[0]) + shared
        q = x[3] + strength * math.sin(x[1]) + shared
        return x[0] + p, x[1] + q, p, q

    def jacobian(x):
        shared = coupling * math.cos(x[0] + x[1])
        kicks = np.array(
            [
                [strength * math.cos(x[0]) + shared, shared],
                [shared, strength * math.cos(x[1]) + shared],
            ]
        )
        return np.block([[np.eye(2) + kicks, np.eye(2)], [kicks, np.eye(2)]])

    return Map(rule, jacobian, start, angles=[True] * 4)


def _logistics() -> list[Known]:
    window = "period-three window, " + MAY
    cases: list[tuple[float, str, int | None, str]] = [
        (0.8, "periodic", 1, "fixed point 0, multiplier r"),
        (2.8, "periodic", 1, "fixed point 1 − 1/r, multiplier 2 − r"),
        (3.2, "periodic", 2, MAY),
        (3.5, "periodic", 4, MAY),
        (3.55, "periodic", 8, MAY),
        (3.6, "chaotic", None, "two bands, " + MAY),
        (3.6266, "periodic", 6, "period-six window, " + MAY),
        (3.7, "chaotic", None, SPROTT),
        (3.7017, "periodic", 7, "period-seven window, " + MAY),
        (3.739, "periodic", 5, "period-five window, " + MAY),
        (3.82, "chaotic", None, "intermittency, Y. Pomeau, P. Manneville (1980)"),
        (3.828, "chaotic", None, "intermittency, Y. Pomeau, P. Manneville (1980)"),
        (3.83, "periodic", 3, window),
        (3.845, "periodic", 6, window),
        (3.9, "chaotic", None, SPROTT),
        (4.0, "chaotic", None, "exponent ln 2"),
    ]
    known = [
        Known(f"Logistic, r = {r:g}", verdict, period, source, of_map(lambda r=r: logistic(r)))
        for r, verdict, period, source in cases
    ]
    transient = "transient chaos before the period-three cycle, " + MAY
    return [
        *known,
        Known("Logistic, r = 3.84, from 0.123", "periodic", 3, transient,
              of_map(lambda: logistic(3.84, 0.123))),
        Known("Logistic, r = 1 + √8", "periodic", 3, "tangent bifurcation, " + MAY,
              of_map(lambda: logistic(1 + math.sqrt(8)))),
    ]  # fmt: skip


def _others() -> list[Known]:
    kam = "KAM theorem; J. M. Greene, J. Math. Phys. 20 (1979) 1183"
    greene = "golden curve, which breaks at 0.9716: J. M. Greene (1979)"
    locked = "Arnold tongue; E. Ott, Chaos in Dynamical Systems (1993)"
    sacker = "Neimark–Sacker bifurcation at a = 2; " + SPROTT
    found: list[tuple[str, str, int | None, str, object, bool]] = [
        ("Ricker, r = 1.5", "periodic", 1, MAY, lambda: ricker(1.5), True),
        ("Ricker, r = 2.3", "periodic", 2, MAY, lambda: ricker(2.3), True),
        ("Ricker, r = 2.6", "periodic", 4, MAY, lambda: ricker(2.6), True),
        ("Ricker, r = 3", "chaotic", None, MAY, lambda: ricker(3.0), True),
        ("Hénon, a = 0.2", "periodic", 1, "fixed point stable to a = 0.3675", lambda: henon(0.2),
         True),
        ("Hénon, a = 0.6", "periodic", 2, "M. Hénon, Commun. Math. Phys. 50 (1976) 69",
         lambda: henon(0.6), True),
        ("Hénon, a = 1", "periodic", 4, "M. Hénon (1976)", lambda: henon(1.0), True),
        ("Hénon, a = 1.4", "chaotic", None, "M. Hénon (1976)", lambda: henon(1.4), True),
        ("Lozi, a = 1.7, b = 0.5", "chaotic", None, "M. Misiurewicz (1980); " + SPROTT, lozi, True),
        ("Delayed logistic, a = 1.9", "periodic", 1, sacker, lambda: delayed(1.9), True),
        ("Delayed logistic, a = 2.1", "quasi-periodic", None, sacker, lambda: delayed(2.1), True),
        ("Delayed logistic, a = 2.27", "chaotic", None, SPROTT, lambda: delayed(2.27), True),
        ("Circle map, Ω golden, K = 0", "quasi-periodic", None, "a rotation",
         lambda: circle(GOLDEN, 0.0), True),
        ("Circle map, Ω golden, K = 0.5", "quasi-periodic", None, "V. I. Arnold (1961)",
         lambda: circle(GOLDEN, 0.5), True),
        ("Circle map, Ω = 0.1, K = 0.9", "periodic", 1, locked, lambda: circle(0.1, 0.9), True),
        ("Circle map, Ω = 0.5, K = 0.9", "periodic", 2, locked, lambda: circle(0.5, 0.9), True),
        ("Translation of a torus by golden and √2", "quasi-periodic", None, "three frequencies",
         lambda: translation(GOLDEN, math.sqrt(2)), False),
        ("Standard map, K = 0.5, golden curve", "quasi-periodic", None, kam,
         lambda: standard(0.5, math.pi, golden(0.5)), False),
        ("Standard map, K = 0.9, golden curve", "quasi-periodic", None, greene,
         lambda: standard(0.9, math.pi, golden(0.9)), False),
        ("Standard map, K = 1.5, island", "quasi-periodic", None, kam,
         lambda: standard(1.5, math.pi + 0.1, 0.0), False),
        ("Standard map, K = 1.5, elliptic point", "periodic", 1, "fixed point (π, 0)",
         lambda: standard(1.5, math.pi, 0.0), False),
        ("Standard map, K = 1.2, near the separatrix", "chaotic", None,
         "B. V. Chirikov, Phys. Rep. 52 (1979) 263", lambda: standard(1.2, 1e-3, 0.0), False),
        ("Standard map, K = 5", "chaotic", None, "B. V. Chirikov (1979): exponent about ln 2.5",
         lambda: standard(5.0, 1.0, 1.0), False),
        ("Hénon's area-preserving map, cos α = 0.4, from 0.2", "quasi-periodic", None,
         "M. Hénon, Quart. Appl. Math. 27 (1969) 291", lambda: area_preserving(0.2), False),
        ("McMillan's map", "quasi-periodic", None, "integrable: E. McMillan (1971)", mcmillan,
         False),
        ("Arnold's cat map", "chaotic", None, "exponent ln((3 + √5)/2)", cat, False),
        ("Coupled standard maps, K = 0.3, coupling 0.02", "quasi-periodic", None,
         "KAM theorem; C. Froeschlé (1971)",
         lambda: froeschle(0.3, 0.02, [2.5, 3.5, 0.2, 0.3]), False),
        ("Coupled standard maps, K = 3, coupling 0.5", "chaotic", None, "C. Froeschlé (1971)",
         lambda: froeschle(3.0, 0.5, [0.5, 0.7, 0.1, 0.2]), False),
    ]  # fmt: skip
    return [
        Known(
            name,
            verdict,
            period,
            source,
            of_map(system, dissipative=dissipative),
            dissipative,
        )
        for name, verdict, period, source, system, dissipative in found
    ]


MAPS = [*_logistics(), *_others()]
