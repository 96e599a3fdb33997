"""Write the definition file of N four-bar linkages in a row (benchmark A02 of IFToMM).

    python docs/make/n_four_bar.py 40 > n-four-bar-40.yaml

Posts A0–B0, …, AN–BN stand one length apart; links join their heads. All bars are uniform, with
1 m and 1 kg. The posts are upright at t = 0 and the heads move along +x at 1 m/s. The mechanism has
one degree of freedom, except where all bars are in line: there each window of it could fold.

`definition` gives the file, `mechanism` builds the same from components.
"""

from __future__ import annotations

import sys

from linkages import (
    AssemblyHint,
    Bar,
    FreeAngle,
    GroundJoint,
    Mechanism,
    SimulationDefaults,
    UniformGravity,
)

GRAVITY = 9.81
SPEED = 1.0


def definition(count: int) -> str:
    """Return the definition file of `count` four-bar linkages."""
    numbers = range(count + 1)
    bars = [_bar("post", 0, "A0", "B0")]
    for i in numbers[1:]:
        bars += [_bar("link", i, f"B{i - 1}", f"B{i}"), _bar("post", i, f"A{i}", f"B{i}")]
    return "\n".join(
        [
            f"name: N-four-bar mechanism (N = {count})",
            f"gravity: [0, -{GRAVITY}]",
            "joints:",
            *(f"  A{i}: [{i}, 0]" for i in numbers),
            "bars:",
            *bars,
            "free:",
            f"  post0: {{angle: 90 deg, speed: -{SPEED}}}",
            "assembly:",
            *(f"  B{i}: [{i}, 1]" for i in numbers[1:]),
            "simulate: {end: 20, samples: 2001, rtol: 1e-11}",
            "",
        ]
    )


def _bar(kind: str, number: int, first: str, second: str) -> str:
    return f"  {kind}{number}: {{joints: [{first}, {second}], length: 1, mass: 1}}"


def mechanism(count: int) -> Mechanism:
    """Build `count` four-bar linkages from components."""
    numbers = range(count + 1)
    posts = [Bar(name=f"post{i}", joints=(f"A{i}", f"B{i}"), length=1, mass=1) for i in numbers]
    links = [
        Bar(name=f"link{i}", joints=(f"B{i - 1}", f"B{i}"), length=1, mass=1) for i in numbers[1:]
    ]
    return Mechanism(
        name=f"N-four-bar mechanism (N = {count})",
        components=(
            UniformGravity(acceleration=(0, -GRAVITY)),
            *(GroundJoint(name=f"A{i}", position=(i, 0)) for i in numbers),
            posts[0],
            *(bar for pair in zip(links, posts[1:], strict=True) for bar in pair),
            FreeAngle(name="post0", angle="90 deg", speed=-SPEED),
            *(AssemblyHint(name=f"B{i}", where=(i, 1)) for i in numbers[1:]),
            SimulationDefaults(end=20, samples=2001, rtol=1e-11),
        ),
    )


if __name__ == "__main__":
    sys.stdout.write(definition(int(sys.argv[1])))
