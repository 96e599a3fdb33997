"""What each model of the joints of the worn engine costs, for docs/which-model.md.

Processor time of `linkages.simulate` over one revolution with 1001 samples, equations
compiled before: the least of several rounds of all models by turns, as a multiple of that of the
ideal mechanism.
"""

from __future__ import annotations

import time

import linkages
from make.registry import makes, table

ENGINE = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.8, center: 10 mm}
  rod: {joints: [A, B], length: 140 mm, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4, inertia: 2e-4}}
drives: {crank: {angle: 0, speed: 60 rpm}}
loads: [{slider: piston, force: -200 N}]
assembly: {B: [0.18, 0]}
simulate: {end: 1, samples: 1001}
"""
_GAP = "clearances: {gap: {joint: A, bar: rod, size: 0.1 mm, %s}}"
_ELASTIC = "contact: hunt-crossley-constant, stiffness: 2e9 N/m^1.5, dissipation: 1.5 s/m"
_RIGID = "contact: restitution, restitution: 0.5"
_FRICTION = "friction: 0.1, pin_radius: 8 mm"
_PLAY = "clearances: {play: {slider: piston, size: 0.1 mm, length: 60 mm, height: 40 mm, %s}}"
MODELS = {
    "ideal joints": "",
    "ideal, friction that follows the reaction": (
        "friction: [{joint: A, coefficient: 0.1, radius: 8 mm, slip_speed: 0.1 rad/s}]"
    ),
    "massless link": _GAP % "angle: 180 deg",
    "massless link with a damper": (
        _GAP % "angle: 180 deg" + "\ndampers: [{clearance: gap, damping: 2e-6}]"
    ),
    "elastic contact": _GAP % _ELASTIC,
    "elastic contact with friction": _GAP % f"{_ELASTIC}, {_FRICTION}, slip: 1 mm/s",
    "rigid contact": _GAP % _RIGID,
    "rigid contact with friction": _GAP % f"{_RIGID}, {_FRICTION}",
    "lubricated": (
        _GAP % "contact: lubricated, viscosity: 0.1 Pa*s, width: 15 mm, pin_radius: 8 mm"
    ),
    "elastic block in its guide": _PLAY % _ELASTIC,
    "rigid block in its guide": _PLAY % _RIGID,
}
DUTIES: dict[str, dict[str, object]] = {
    "60 rpm, 200 N": {"simulate.end": 1},
    "600 rpm, 20 N": {"drives.crank.speed": "600 rpm", "loads[0].force": -20, "simulate.end": 0.1},
}
ROUNDS = 5


def measured() -> dict[str, dict[str, float]]:
    """Processor time of each model at each duty in seconds, least of all rounds."""
    spent: dict[str, dict[str, float]] = {name: {} for name in MODELS}
    # the first round compiles, and counts for nothing
    for counts in (False, *[True] * ROUNDS):
        for name, text in MODELS.items():
            for duty, values in DUTIES.items():
                mechanism = linkages.loads(ENGINE + text).with_values(values)
                start = time.process_time()
                linkages.simulate(mechanism)
                passed = time.process_time() - start
                if counts:
                    spent[name][duty] = min(passed, spent[name].get(duty, passed))
    return spent


@makes("models")
def models() -> str:
    """Ratios with two digits."""
    spent = measured()
    ideal = spent["ideal joints"]
    rows = (
        (name, *(f"{float(f'{taken / ideal[duty]:.2g}'):g}" for duty, taken in times.items()))
        for name, times in spent.items()
    )
    return table(("model", *DUTIES), rows)
