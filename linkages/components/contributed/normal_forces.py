"""Normal forces across gaps as functions of indentation, from material and restitution."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from linkages.components.contributed.functions import (
    FIRST,
    Function,
    Number,
    Operation,
    Table,
    V,
    X,
    applied,
)
from linkages.components.contributed.terms import CamSize, Parameter, Play
from linkages.components.contributed.wear_laws import Rubbing
from linkages.reading.paths import KeyPath


@dataclass(frozen=True)
class NormalForce:
    """The force that presses a journal against its bearing, as a function of indentation and rate.

    Its functions hold while the indentation `X` is positive; `V` is its rate and `FIRST` what that
    was at the last touch.
    """

    force: Function  # in newtons, positive where it presses
    # The part of it that follows from an energy (N), and that energy (J)
    elastic: Function
    energy: Function
    numbers: tuple[Parameter, Parameter]  # K and n of the elastic part K·dⁿ
    # Negative where the force would pull, which no contact does: it is none then. None for a law
    # that always presses
    pressing: Function | None = None
    # Smallest rate of a touch that counts (m/s), for a law that depends on it
    least_rate: Parameter | None = None


Impact = Literal["newton", "poisson", "moreau"]
"""Laws of impacts under friction."""


@dataclass(frozen=True)
class RigidContact:
    """Impacts by which the rate d' of the indentation becomes −e·d', or 0 where that is slow.

    A journal that does not bounce stays at the wall until its contact force would be tensile, or
    more than adhesion holds.
    """

    restitution: Parameter  # Newton's coefficient e
    # An impact that would bounce with less than this (m/s) closes the contact
    least_rate: Parameter
    friction: Parameter | None = None  # Coulomb's coefficient μ of friction; None without any
    # With friction, whose e it is, and how an impact goes in which no other contact takes part: the
    # ratio of rates (`newton`) or that of impulses behind and before the end of compression
    # (`poisson`), along the path of impulses; or that of rates, and Coulomb's law for the slip
    # behind (`moreau`)
    impact: Impact = "newton"
    # Largest tensile force of a closed contact (N, or N·m of an angle); None of one without
    adhesion: Parameter | None = None


@dataclass(frozen=True)
class OilFilm:
    """Oil that fills the gap between a journal and its bearing, and keeps them apart."""

    viscosity: Parameter  # dynamic viscosity η in Pa·s
    width: Parameter  # of the bearing along its axis (m)
    # Whether the film bears tension, and reaches all around; otherwise it is where it presses
    whole: bool


Across = NormalForce | RigidContact | OilFilm
"""What acts across a gap."""


@dataclass(frozen=True)
class PinInHole:
    """A journal that may leave its bearing, fly, hit its wall and follow it."""

    clearance: str  # name of the clearance
    # The joint, and what the point of the displaced body is called
    joint: str
    displaced: str
    body: str  # the displaced body
    size: Parameter  # radial clearance (m)
    hole: bool  # whether the displaced body has the bearing; otherwise it has the journal
    pin_radius: Parameter  # in metres
    # Amplitudes (m) of cosine and sine of each harmonic of the depth of the bearing over the angle
    # in its frame, from the first one on; empty for a round one
    profile: tuple[tuple[Parameter, Parameter], ...] = ()

    @property
    def axes(self) -> tuple[str, str]:
        """The bodies whose displacements are the offset."""
        return offset_names(self.clearance)


CORNERS = ((-1, 1), (1, 1), (-1, -1), (1, -1))
"""On which sides of the middle of a block its corners are, along the guide and across it."""


@dataclass(frozen=True)
class CornerAtWall:
    """A corner of a block, and the wall of its guide on that side."""

    play: Play  # what moves in the guide
    # The sides on which the corner is: +1 or −1
    along: int
    across: int
    size: Parameter  # distance of a block in the middle of its guide from each wall (m)
    # Of the block along the guide and across it (m)
    length: Parameter
    height: Parameter

    @property
    def together(self) -> str:
        """What corners that slip alike have in common."""
        return self.play.name


@dataclass(frozen=True)
class RoundAtWall:
    """A point of a body, or a round about it, and a wall of another body."""

    # What has the round, and the point in its middle
    body: str
    joint: str
    radius: Parameter  # of the round (m); zero for a point
    # What has the wall (None: the ground), and a point of a straight wall or the middle of a
    # circular one
    wall: str | None
    through: str
    # Direction of a straight wall in the frame of its body (rad); what is on the left is free. None
    # for a circular one
    angle: Parameter | None
    circle: Parameter  # radius of a circular wall (m)
    inside: bool  # whether the round is within the circle
    size: Parameter  # length that indentations are compared with (m)
    # What points of one body at one wall have in common, which slip alike where two press; empty
    # for one alone
    together: str = ""


@dataclass(frozen=True)
class FollowerOnCam:
    """A translating follower and its cam."""

    # The follower, on an axis of the ground, and the body that turns under it
    slider: str
    cam: str
    # The lift as a function of the angle of the cam (m), and its second derivative
    lift: Table
    bends: Table
    offset: Parameter  # position of the slider at a lift of zero (m)
    profile: CamSize  # what touches the cam, and the size of the cam
    size: Parameter  # length that indentations are compared with (m)


Geometry = PinInHole | CornerAtWall | RoundAtWall | FollowerOnCam
"""What touches what."""

WITHOUT_ROOM = (RoundAtWall, FollowerOnCam)
"""Those that are no clearances, and add no coordinates."""


@dataclass(frozen=True)
class Contact:
    """Two bodies that may touch at one place."""

    name: str  # what results call it
    geometry: Geometry  # what touches what
    normal: Across  # the force that presses
    # Force along the slip over the normal force, as a function of the slip `V`; None without any
    friction: Function | None
    path: KeyPath  # where it stands in the definition file
    rubbing: Rubbing | None = None  # that its surfaces wear; None if they do not

    @property
    def size(self) -> Parameter:
        """Length that indentations are compared with (m)."""
        return self.geometry.size

    @property
    def called(self) -> str:
        """What messages call it."""
        kind = "contact" if isinstance(self.geometry, WITHOUT_ROOM) else "clearance"
        return f"{kind} {self.name}"

    @property
    def rigid(self) -> bool:
        """Whether impacts take no time."""
        return isinstance(self.normal, RigidContact)

    @property
    def filled(self) -> bool:
        """Whether oil fills the gap, a film that is stiff where it is thin."""
        return isinstance(self.normal, OilFilm)

    @property
    def dissipates(self) -> bool:
        """Whether impacts or slip lose energy."""
        normal = self.normal
        if not isinstance(normal, NormalForce):
            return True
        return normal.force != normal.elastic or self.friction is not None


def offset_names(clearance: str) -> tuple[str, str]:
    """What the coordinates of the offset of a clearance are called."""
    return f"{clearance}.x", f"{clearance}.y"


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


NARROWEST, WIDEST = 5e-6, 1e-2
"""Sizes between which Pereira's exponent is given (m)."""


def stiffness_of_spheres(modulus: float, poisson: float, hole: float, pin: float) -> float:
    """K = 4/(3 s) √(R_h R_p/(R_h − R_p)) in N/m^1.5, with s = 2 (1 − ν²)/E for equal materials.

    Publications on journals in bearings use it most, although these touch along a line.

    `hole`, `pin`: radii in metres.
    """
    compliance = 2.0 * (1.0 - poisson**2) / modulus
    return 4.0 / (3.0 * compliance) * math.sqrt(hole * pin / (hole - pin))


def stiffness_of_cylinders(
    modulus: float, poisson: float, size: float, width: float
) -> tuple[float, float]:
    """K in N/mⁿ and n of a cylinder in a bearing, as Pereira, Ramalho and Ambrósio fit them [1]_.

    In mm and N/mm² it is F = (0.965 c + 0.0965) L E*/c · d^n with n = Y c^−0.005.

    `size`, `width`: c and L in metres; c from `NARROWEST` to `WIDEST`.

    References
    ----------
    .. [1] C. M. Pereira, A. L. Ramalho, J. A. Ambrósio, "A critical overview of internal and
       external cylinder contact force models", Nonlinear Dyn. 63 (2011) 681-697.
    """
    clearance, length = 1e3 * size, 1e3 * width
    plane = 1e-6 * modulus / (2.0 * (1.0 - poisson**2))
    if clearance < 0.35:
        fitted = 1.51 * math.log(1e3 * clearance) ** -0.151
    else:
        fitted = 0.0151 * clearance + 1.151
    exponent = fitted * clearance**-0.005
    stiffness = (0.965 * clearance + 0.0965) * length * plane / clearance
    return stiffness * 1e3**exponent, exponent


def restitution_reached(factor: float) -> float:
    """What one impact of a free body reaches with K dⁿ (1 + χ d'/d'₀), for every K, n and mass.

    It is the solution e of (1 + χ)/(1 − χ e) = exp(χ (1 + e)), by bisection.
    """
    if factor == 0.0:
        return 1.0
    return _bisected(lambda e: _balance(factor, e), 0.0, min(1.0, 1.0 / factor))


def factor_for(restitution: float) -> float:
    """The damping factor χ with which an impact reaches a restitution in (0, 1]."""
    if restitution == 1.0:
        return 0.0
    least = 0.75 * (1.0 - restitution**2)  # Lankarani and Nikravesh's, which is too small
    return _bisected(lambda factor: _balance(factor, restitution), least, 1.0 / restitution)


def _balance(factor: float, restitution: float) -> float:
    """ln((1 + χ)/(1 − χ e)) − χ (1 + e)."""
    rebound = factor * restitution
    if rebound >= 1.0:
        return math.inf
    return math.log1p(factor) - math.log1p(-rebound) - factor * (1.0 + restitution)


def _bisected(function: Callable[[float], float], low: float, high: float) -> float:
    """Where a function that is negative at `low` and positive at `high` is zero."""
    while low < (middle := 0.5 * (low + high)) < high:
        if function(middle) < 0.0:
            low = middle
        else:
            high = middle
    return high
