"""Laws of friction of slip under a normal force, by name, with their sources."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated

from linkages.components.contributed.component import Fault
from linkages.components.contributed.functions import Function, Number, V, applied
from linkages.components.contributed.terms import Parameter
from linkages.discovery import plugged
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import LawName

GROUP = "linkages.components.frictions"
"""Entry points of other packages that name laws of friction."""

FRICTION_KEYS = ("friction", "static", "slip", "least_slip", "stribeck_speed")
"""Keys of numbers that such laws have: the coefficient of friction, then what shapes the law."""

_SPOKEN = {"slip": "velocity of slip", "least_slip": "velocity of slip below which there is none",
           "static": "coefficient at which it is greatest",
           "stribeck_speed": "velocity over which it falls"}  # fmt: skip

Coefficients = Mapping[str, Number]
"""Keys of `FRICTION_KEYS` that are given → their numbers."""


@dataclass(frozen=True)
class FrictionLaw:
    """A law of friction as definition files name it.

    Parameters
    ----------
    name
        Value of the key ``friction_law``.
    needs, takes
        Keys beside ``friction`` that it must have, and further ones that it may have.
    resists
        Friction against the slip over the normal force, as a function of the velocity `V` of slip
        in m/s, from the numbers at these keys. Its corners are zeros of smooth functions.
    source
        Where it was published, or what it models.
    """

    name: str
    needs: tuple[str, ...]
    resists: Callable[[Coefficients], Function]
    takes: tuple[str, ...] = ()
    source: str = ""


@cache
def friction_laws() -> dict[str, FrictionLaw]:
    """All laws by their names, those of other packages last."""
    return {law.name: law for law in (*BUILT_IN, *(law for _, law in plugged(GROUP)))}


FrictionName = Annotated[str, LawName(friction_laws, "a law of friction")]


def friction_coefficient(name: str, given: Mapping[str, float | None], path: KeyPath) -> Function:
    """Force of friction along the slip over the normal force, as a function of the slip `V`."""
    law = friction_laws()[name]
    values = {key: given.get(key) for key in ("friction", *law.needs, *law.takes)}
    numbers = {
        key: Number(Parameter((*path, key), 1.0 if value is None else float(value)))
        for key, value in values.items()
        if value is not None or key in law.needs
    }
    return applied("neg", law.resists(numbers))


def friction_problems(name: str, given: Mapping[str, float | None]) -> Iterator[Fault]:
    """Keys at fault with sentences: what the law lacks or does not have, and what does not fit."""
    law, size = friction_laws()[name], given["friction"] or 0.0
    known = ("friction", *law.needs, *law.takes)
    there = {key: value for key, value in given.items() if value is not None}
    for key in law.needs:
        if size and key not in there:
            yield (), f"missing key {key!r}: {law.name} needs the {_SPOKEN[key]}"
    for key in there:
        if key not in known:
            yield key, f"{law.name} has no {key!r}; it takes {', '.join(known)}"
    static = there.get("static")
    if static is not None and static < size:
        yield "static", f"expected at least {size:g}, what 'friction' is, found {static:g}"
    if "static" in law.takes and (static is None) != ("stribeck_speed" not in there):
        keys = ("static", "stribeck_speed") if static is None else ("stribeck_speed", "static")
        yield (), f"missing key {keys[0]!r}: it goes with {keys[1]!r}"
    least, slip = there.get("least_slip"), there.get("slip")
    if least is not None and slip is not None and least >= slip:
        yield "least_slip", f"expected less than 'slip', {slip:g}, found {least:g}"


def stribeck(sliding: Function, static: Function, speed: Function) -> Function:
    """F + (F_static − F)·exp(−(v/v_stribeck)²): friction that falls as it gets faster."""
    return sliding + (static - sliding) * applied("exp", applied("neg", (V / speed) ** 2))


def _beyond(speed: Function) -> Function:
    """What is positive where the slip is faster, smooth where it changes its sense."""
    return V**2 - speed**2


def _odd(magnitude: Callable[[Function], Function]) -> Function:
    """The odd function of the slip with this value over its magnitude."""
    size = applied("abs", V)
    # while nothing presses the mode of its sign stands still, and so may exponentials overflow
    result = magnitude(applied("select", size, size, 0))
    return applied("where", V, result, applied("neg", result))


def _ambrosio(numbers: Coefficients) -> Function:
    """Rises in a straight line from 0 at v0 to μ at v1."""
    low, high = numbers["least_slip"], numbers["slip"]

    def part(slip: Function) -> Function:
        rising = applied("where", slip - high, 1, (slip - low) / (high - low))
        return applied("where", slip - low, rising, 0)

    # not of the magnitude, which has a corner of its own where there is no friction
    return numbers["friction"] * (part(V) - part(applied("neg", V)))


def _bengisu_akay(numbers: Coefficients) -> Function:
    """Rises to μ_s at v0, where it has a corner, and falls to μ over the Stribeck speed."""
    sliding, static, peak = numbers["friction"], numbers["static"], numbers["slip"]

    def magnitude(slip: Function) -> Function:
        part, fast = slip / peak, _beyond(peak)
        more = applied("where", fast, (slip - peak) / numbers["stribeck_speed"], 0)
        falling = sliding + (static - sliding) * applied("exp", applied("neg", more))
        return applied("where", fast, falling, static * part * applied("sub", 2, part))

    return _odd(magnitude)


def _brown_mcphee(numbers: Coefficients) -> Function:
    """Reaches about μ_s at the velocity vt of transition."""
    sliding = numbers["friction"]
    part = V / numbers["slip"]
    hump = part / applied("add", applied("mul", 0.25, part**2), 0.75) ** 2
    return sliding * applied("tanh", applied("mul", 4, part)) + (numbers["static"] - sliding) * hump


def _coulomb(numbers: Coefficients) -> Function:
    """With a static coefficient it falls to that of sliding as Stribeck's does."""
    size: Function = numbers["friction"]
    if "static" in numbers and "stribeck_speed" in numbers:
        size = stribeck(size, numbers["static"], numbers["stribeck_speed"])
    return applied("mul", size, applied("sign", V))


def _tanh(numbers: Coefficients) -> Function:
    """μ tanh(v/vs)."""
    return numbers["friction"] * applied("tanh", V / numbers["slip"])


def _threlfall(numbers: Coefficients) -> Function:
    """μ (1 − exp(−3 |v|/vr)) up to vr; constant beyond, 0.9502 μ (printed as 0.95)."""
    reached = numbers["slip"]

    def magnitude(slip: Function) -> Function:
        part = applied("where", _beyond(reached), 1, slip / reached)
        return applied("sub", 1, applied("exp", applied("mul", -3, part)))

    return numbers["friction"] * _odd(magnitude)


BUILT_IN = (
    FrictionLaw(
        "ambrosio",
        ("least_slip", "slip"),
        _ambrosio,
        source="J. A. C. Ambrósio, Virtual Nonlinear Multibody Systems (Kluwer 2003) 57",
    ),
    FrictionLaw(
        "bengisu-akay",
        ("static", "slip", "stribeck_speed"),
        _bengisu_akay,
        source="M. T. Bengisu, A. Akay, J. Sound Vib. 171 (1994) 557",
    ),
    FrictionLaw(
        "brown-mcphee",
        ("static", "slip"),
        _brown_mcphee,
        source="P. Brown, J. McPhee, J. Comput. Nonlinear Dyn. 11 (2016) 054502",
    ),
    FrictionLaw(
        "coulomb",
        (),
        _coulomb,
        takes=("static", "stribeck_speed"),
        source="set-valued: it sticks until more than the static friction is needed",
    ),
    FrictionLaw("tanh", ("slip",), _tanh, source="smooth: nothing sticks, everything creeps"),
    FrictionLaw(
        "threlfall",
        ("slip",),
        _threlfall,
        source="A. G. Threlfall, Mech. Mach. Theory 13 (1978) 475",
    ),
)
