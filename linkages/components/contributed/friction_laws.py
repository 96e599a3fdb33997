"""Laws of friction of slip under a normal force, by their names.

They are those of files in `linkages.components.frictions`. Nothing here knows what slips.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated

from linkages.components.contributed.functions import Function, Number, V, applied
from linkages.components.contributed.law_names import LawName, laws_in
from linkages.components.contributed.terms import Parameter, Path

GROUP = "linkages.components.frictions"
"""Entry points that name laws of friction, and the folder of those of this package."""

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
    """

    name: str
    needs: tuple[str, ...]
    resists: Callable[[Coefficients], Function]
    takes: tuple[str, ...] = ()


def friction_laws() -> dict[str, FrictionLaw]:
    """All laws by their names."""
    return laws_in(GROUP)


FrictionName = Annotated[str, LawName(GROUP, "a law of friction")]


def friction_coefficient(name: str, given: Mapping[str, float | None], path: Path) -> Function:
    """Force of friction along the slip over the normal force, as a function of the slip `V`.

    Parameters
    ----------
    name
        Of the law.
    given
        Values at `FRICTION_KEYS`; what is missing, as `friction_problems` says, is 1 here.
    path
        Of the mapping that they stand in.
    """
    law = friction_laws()[name]
    values = {key: given.get(key) for key in ("friction", *law.needs, *law.takes)}
    numbers = {
        key: Number(Parameter((*path, key), 1.0 if value is None else float(value)))
        for key, value in values.items()
        if value is not None or key in law.needs
    }
    return applied("neg", law.resists(numbers))


def friction_problems(name: str, given: Mapping[str, float | None]) -> Iterator[tuple[str, str]]:
    """Keys at fault with sentences: what the law lacks or does not have, and what does not fit.

    Parameters
    ----------
    name
        Of the law.
    given
        Values at `FRICTION_KEYS`; without friction nothing is missing.
    """
    law, size = friction_laws()[name], given["friction"] or 0.0
    known = ("friction", *law.needs, *law.takes)
    there = {key: value for key, value in given.items() if value is not None}
    for key in law.needs:
        if size and key not in there:
            yield "friction", f"missing key {key!r}: {law.name} needs the {_SPOKEN[key]}"
    for key in there:
        if key not in known:
            yield key, f"{law.name} has no {key!r}; it takes {', '.join(known)}"
    static = there.get("static")
    if static is not None and static < size:
        yield "static", f"expected at least {size:g}, what 'friction' is, found {static:g}"
    if "static" in law.takes and (static is None) != ("stribeck_speed" not in there):
        keys = ("static", "stribeck_speed") if static is None else ("stribeck_speed", "static")
        yield keys[1], f"missing key {keys[0]!r}: it goes with {keys[1]!r}"
    least, slip = there.get("least_slip"), there.get("slip")
    if least is not None and slip is not None and least >= slip:
        yield "least_slip", f"expected less than 'slip', {slip:g}, found {least:g}"


def stribeck(sliding: Function, static: Function, speed: Function) -> Function:
    """F + (F_static − F)·exp(−(v/v_stribeck)²): friction that falls as it gets faster."""
    return sliding + (static - sliding) * applied("exp", applied("neg", (V / speed) ** 2))


def beyond(speed: Function) -> Function:
    """What is positive where the slip is faster, smooth where it changes its sense."""
    return V**2 - speed**2


def odd(magnitude: Callable[[Function], Function]) -> Function:
    """The odd function of the slip with this value over its magnitude."""
    size = applied("abs", V)
    # while nothing presses the mode of its sign stands still, and so may exponentials overflow
    found = magnitude(applied("select", size, size, 0))
    return applied("where", V, found, applied("neg", found))
