"""Laws of what acts across a gap as definition files name them, and how they are made."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from linkages.components.contributed.contacts import Across, NormalForce, OilFilm
from linkages.components.contributed.functions import (
    FIRST,
    Function,
    Number,
    Operation,
    V,
    X,
    applied,
)
from linkages.components.contributed.terms import Parameter

Numbers = Mapping[str, Parameter]
"""Keys of a clearance → their numbers."""


@dataclass(frozen=True)
class ContactLaw:
    """A law of contact as definition files name it.

    Parameters
    ----------
    name
        Value of the key ``contact``.
    needs, takes
        Keys of a clearance that it must have, and further ones that it may have.
    force
        What acts, from the numbers at these keys.
    restitution
        Damping factor χ over wanted restitution, for a law that has one.
    rigid
        Whether impacts take no time.
    source
        Where it was published, or what it models.
    """

    name: str
    needs: tuple[str, ...]
    force: Callable[[Numbers], Across]
    takes: tuple[str, ...] = ("exponent",)
    restitution: Callable[[float], float] | None = None
    rigid: bool = False
    source: str = ""


def elastic_law(name: str, source: str) -> ContactLaw:
    """K dⁿ."""

    def force(numbers: Numbers) -> NormalForce:
        elastic, energy, own = elastic_part(numbers)
        return NormalForce(elastic, elastic, energy, own)

    return ContactLaw(name, ("stiffness",), force, source=source)


def dissipative_law(name: str, source: str) -> ContactLaw:
    """K dⁿ (1 + a d')."""

    def force(numbers: Numbers) -> NormalForce:
        elastic, energy, own = elastic_part(numbers)
        factor = 1.0 + Number(numbers["dissipation"]) * V
        return NormalForce(elastic * factor, elastic, energy, own, factor)

    return ContactLaw(name, ("stiffness", "dissipation"), force, source=source)


def restitution_law(name: str, factor: Callable[[float], float], source: str) -> ContactLaw:
    """K dⁿ (1 + χ d'/d'₀), with the rate d'₀ of the last touch and a factor χ of restitution."""

    def force(numbers: Numbers) -> NormalForce:
        elastic, energy, own = elastic_part(numbers)
        damped = 1.0 + Number(numbers["restitution"]) * V / FIRST
        return NormalForce(elastic * damped, elastic, energy, own, damped, numbers["least_rate"])

    needs = ("stiffness", "restitution")
    return ContactLaw(name, needs, force, ("exponent", "least_rate"), factor, source=source)


def viscous_law(name: str, source: str) -> ContactLaw:
    """K d + D d'."""

    def force(numbers: Numbers) -> NormalForce:
        elastic, energy, own = elastic_part(numbers)
        total = elastic + Number(numbers["damping"]) * V
        return NormalForce(total, elastic, energy, own, total)

    return ContactLaw(name, ("stiffness", "damping"), force, (), source=source)


def film_law(name: str, source: str, *, whole: bool) -> ContactLaw:
    """The film of a short journal bearing."""

    def force(numbers: Numbers) -> OilFilm:
        return OilFilm(numbers["viscosity"], numbers["width"], whole)

    return ContactLaw(name, ("viscosity", "width"), force, (), source=source)


def elastic_part(numbers: Numbers) -> tuple[Function, Function, tuple[Parameter, Parameter]]:
    """Force K dⁿ and energy K dⁿ⁺¹/(n + 1) for d > 0, and their numbers K and n."""
    stiffness, exponent = numbers["stiffness"], numbers["exponent"]
    force = Number(stiffness) * raised(exponent)
    power = 1.0 + (exponent.value if halves(exponent) is not None else Number(exponent))
    return force, force * X / power, (stiffness, exponent)


def halves(exponent: Parameter) -> int | None:
    """Twice an exponent if that is a whole number: it is structure then."""
    twice = 2.0 * exponent.value
    return None if exponent.kept or twice != round(twice) else round(twice)


def raised(exponent: Parameter) -> Function:
    """Xⁿ; roots and products where n is a multiple of one half."""
    twice = halves(exponent)
    if twice is None:
        return Operation("exp", (Number(exponent) * applied("log", X),))
    whole = None if twice < 2 else X if twice < 4 else X ** (twice // 2)
    if twice % 2 == 0:
        assert whole is not None
        return whole
    root = applied("sqrt", X)
    return root if whole is None else whole * root
