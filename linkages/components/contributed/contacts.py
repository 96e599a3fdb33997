"""What acts across gaps, as functions of indentation, and between what."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from linkages.components.contributed.functions import Function
from linkages.components.contributed.terms import Parameter, Path, Play


@dataclass(frozen=True)
class NormalForce:
    """The force that presses a journal against its bearing, as a function of indentation and rate.

    Its functions hold while the indentation `X` is positive; `V` is its rate and `FIRST` what that
    was at the last touch.

    Parameters
    ----------
    force
        In newtons, positive where it presses.
    elastic, energy
        The part of it that follows from an energy (N), and that energy (J).
    numbers
        K and n of the elastic part K·dⁿ.
    pressing
        Negative where the force would pull, which no contact does: it is none then. None for a law
        that always presses.
    least_rate
        Smallest rate of a touch that counts (m/s), for a law that depends on it.
    """

    force: Function
    elastic: Function
    energy: Function
    numbers: tuple[Parameter, Parameter]
    pressing: Function | None = None
    least_rate: Parameter | None = None


Impact = Literal["newton", "poisson", "moreau"]
"""Laws of impacts under friction."""


@dataclass(frozen=True)
class RigidContact:
    """Impacts by which the rate d' of the indentation becomes −e·d', or 0 where that is slow.

    A journal that does not bounce stays at the wall until its contact force would be tensile.

    Parameters
    ----------
    restitution
        Newton's coefficient e.
    least_rate
        An impact that would bounce with less than this (m/s) closes the contact.
    friction
        Coulomb's coefficient μ of friction; None without any.
    impact
        With friction, whose e it is, and how an impact goes in which no other contact takes part:
        the ratio of rates (``newton``) or that of impulses behind and before the end of compression
        (``poisson``), along the path of impulses; or that of rates, and Coulomb's law for the slip
        behind (``moreau``).
    """

    restitution: Parameter
    least_rate: Parameter
    friction: Parameter | None = None
    impact: Impact = "newton"


@dataclass(frozen=True)
class OilFilm:
    """Oil that fills the gap between a journal and its bearing, and keeps them apart.

    Parameters
    ----------
    viscosity
        Dynamic viscosity η in Pa·s.
    width
        Of the bearing along its axis (m).
    whole
        Whether the film bears tension, and reaches all around; otherwise it is where it presses.
    """

    viscosity: Parameter
    width: Parameter
    whole: bool


Across = NormalForce | RigidContact | OilFilm
"""What acts across a gap."""


@dataclass(frozen=True)
class PinInHole:
    """A journal that may leave its bearing, fly, hit its wall and follow it.

    Parameters
    ----------
    clearance
        Name of the clearance.
    joint, displaced
        The joint, and what the point of the displaced body is called.
    body
        The displaced body.
    size
        Radial clearance (m).
    hole
        Whether the displaced body has the bearing; otherwise it has the journal.
    pin_radius
        In metres.
    """

    clearance: str
    joint: str
    displaced: str
    body: str
    size: Parameter
    hole: bool
    pin_radius: Parameter

    @property
    def axes(self) -> tuple[str, str]:
        """The bodies whose displacements are the offset."""
        return offset_names(self.clearance)


CORNERS = ((-1, 1), (1, 1), (-1, -1), (1, -1))
"""On which sides of the middle of a block its corners are, along the guide and across it."""


@dataclass(frozen=True)
class CornerAtWall:
    """A corner of a block, and the wall of its guide on that side.

    Parameters
    ----------
    play
        What moves in the guide.
    along, across
        The sides on which the corner is: +1 or −1.
    size
        Distance of a block in the middle of its guide from each wall (m).
    length, height
        Of the block along the guide and across it (m).
    """

    play: Play
    along: int
    across: int
    size: Parameter
    length: Parameter
    height: Parameter


Geometry = PinInHole | CornerAtWall
"""What touches what."""


@dataclass(frozen=True)
class Contact:
    """Two bodies that may touch at one place.

    Parameters
    ----------
    name
        What results call it.
    geometry
        What touches what.
    normal
        The force that presses.
    friction
        Force along the slip over the normal force, as a function of the slip `V`; None without any.
    path
        Where it stands in the definition file.
    """

    name: str
    geometry: Geometry
    normal: Across
    friction: Function | None
    path: Path

    @property
    def size(self) -> Parameter:
        """Length that indentations are compared with (m)."""
        return self.geometry.size

    @property
    def rigid(self) -> bool:
        """Whether impacts take no time."""
        return isinstance(self.normal, RigidContact)

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
