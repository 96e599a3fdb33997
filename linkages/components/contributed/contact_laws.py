"""Laws of contact by name, with their sources, and keys of contacts in joints, guides and stops."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Annotated, ClassVar

from linkages.components.contributed.component import Component, Fault, component
from linkages.components.contributed.friction_laws import (
    FRICTION_KEYS,
    FrictionName,
    friction_coefficient,
    friction_problems,
)
from linkages.components.contributed.functions import PRESSED, Function
from linkages.components.contributed.load_measures import (
    GROUND,
    Bearing,
    ClearanceFriction,
    Friction,
    JointFriction,
    Load,
    Turn,
)
from linkages.components.contributed.normal_forces import (
    Across,
    ContactLaw,
    Impact,
    RigidContact,
    dissipative_law,
    elastic_law,
    factor_for,
    film_law,
    restitution_law,
    viscous_law,
)
from linkages.components.contributed.state_laws import leaves
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    Displacement,
    Guide,
    Parameter,
    Play,
    Relation,
)
from linkages.components.contributed.wear_laws import Wearing
from linkages.discovery import plugged
from linkages.reading.paths import KeyPath
from linkages.spec.quantities import (
    ContactStiffness,
    Damping,
    LawName,
    Name,
    PositiveLength,
    PositiveNumber,
    PositiveSpeed,
    Quantity,
    exponent_of,
    stiffness_unit,
)
from linkages.spec.units import NUMBER, Bound, Dimension

GROUP = "linkages.components.contacts"
"""Entry points of other packages that name laws of contact."""

# e is the coefficient of restitution, the value of each function the damping factor χ
BUILT_IN = (
    restitution_law(
        "carvalho-martins",
        lambda e: 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e),
        "A. S. Carvalho, J. M. Martins, Mech. Mach. Theory 138 (2019); for e > 1/3",
    ),
    dissipative_law(
        "hunt-crossley-constant",  # no memory of the touch: following contact has one attractor
        "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440, with constant dissipation",
    ),
    restitution_law(
        "exact",
        factor_for,
        "J. Zhang, I. Sharf, ASME J. Appl. Mech. 76 (2009): one impact of a free body is exact",
    ),
    restitution_law(
        "flores",
        lambda e: 1.6 * (1.0 - e) / e,
        "P. Flores et al., Multibody Syst. Dyn. 25 (2011) 357",
    ),
    restitution_law(
        "gonthier",
        lambda e: (1.0 - e**2) / e,
        "Y. Gonthier et al., Multibody Syst. Dyn. 11 (2004) 209",
    ),
    restitution_law(
        "herbert-mcwhannell",
        lambda e: 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0),
        "R. G. Herbert, D. C. McWhannell, J. Eng. Ind. 99 (1977) 795",
    ),
    elastic_law("hertz", "H. Hertz, J. reine angew. Math. 92 (1881) 156: two elastic spheres"),
    restitution_law(
        "hu-guo",
        lambda e: 1.5 * (1.0 - e) / e,
        "S. Hu, X. Guo, Multibody Syst. Dyn. 35 (2015) 361",
    ),
    restitution_law(
        "hunt-crossley",
        lambda e: 1.5 * (1.0 - e),
        "K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440",
    ),
    viscous_law("kelvin-voigt", "linear spring and damper; the force jumps at the touch"),
    restitution_law(
        "lankarani-nikravesh",
        lambda e: 0.75 * (1.0 - e**2),
        "H. M. Lankarani, P. E. Nikravesh, J. Mech. Des. 112 (1990) 369",
    ),
    restitution_law(
        "lee-wang",
        lambda e: 0.75 * (1.0 - e),
        "T. W. Lee, A. C. Wang, J. Mech. Transm. Autom. Des. 105 (1983) 534",
    ),
    film_law(
        "lubricated",
        "short journal bearing, ruptured where the film would pull (Gümbel, Ocvirk)",
        whole=False,
    ),
    film_law(
        "lubricated-full",
        "short journal bearing with a film that bears tension, as under high pressure",
        whole=True,
    ),
    ContactLaw(
        "restitution",
        ("restitution",),
        lambda numbers: RigidContact(numbers["restitution"], numbers["least_rate"]),
        ("least_rate",),
        rigid=True,
        source="rigid bodies: Newton's impact law, and a constraint while contact lasts",
    ),
    restitution_law(
        "safaeifar-farshidianfar",
        lambda e: 1.25 * (1.0 - e) / e,
        "H. Safaeifar, A. Farshidianfar, Multibody Syst. Dyn. (2020)",
    ),
    restitution_law(
        "zhiying-qishao",
        lambda e: 0.75 * (1.0 - e**2) * math.exp(2.0 * (1.0 - e)),
        "Q. Zhiying, L. Qishao, J. Dyn. Control 4 (2006) 294",
    ),
)


@cache
def contact_laws() -> dict[str, ContactLaw]:
    """All laws by their names, those of other packages last."""
    return {law.name: law for law in (*BUILT_IN, *(law for _, law in plugged(GROUP)))}


ContactName = Annotated[str, LawName(contact_laws, "a law of contact")]


Dissipation = Annotated[float, Quantity(Dimension("dissipation", "s/m", "s/m"), Bound.NON_NEGATIVE)]
Ratio = Annotated[float, Quantity(NUMBER, Bound.NON_NEGATIVE)]

USUAL_RATE = 1e-3
"""Touches are no slower than this in laws that divide by their rate (m/s)."""

PRESSED_SHARE, PLACED = 0.5, 1e-3
"""How deep a start may be within a wall, over the size: of an elastic one, and of a rigid one.

Laws are made for a tenth; a motion of a soft one may go on from where it got to. Numbers of a file
place a pin at rigid walls to some digits.
"""

_KEYS = ("stiffness", "exponent", "dissipation", "restitution", "least_rate", "damping")


@component
class ContactKeys(Component):
    """Two sides that press and rub where they touch.

    Parameters
    ----------
    size
        How far the two sides are apart, in metres, > 0.
    contact
        Law of the normal force.
    stiffness
        K of the force K·dⁿ at an indentation d, in N/mⁿ.
    exponent
        n; 1.5 if not given.
    dissipation
        a of the factor 1 + a·d' in s/m.
    restitution
        Wanted ratio of the rates after and before an impact, in (0, 1].
    least_rate
        Rate of a touch that slower ones count as, in m/s; 1 mm/s if not given.
    damping
        D of the force D·d' in N·s/m.
    friction
        Coulomb's coefficient of friction.
    friction_law
        How friction depends on the slip. If not given, ``tanh``; rigid contacts have ``coulomb``.
    slip
        Velocity of slip over which friction rises, in m/s.
    least_slip
        Velocity of slip below which there is no friction, in m/s.
    static
        Coefficient at which friction is greatest, at least `friction`.
    stribeck_speed
        Velocity of slip over which it falls from there, in m/s.
    impact
        Whose the restitution of a rigid contact with friction is: of rates (``newton``), of
        impulses (``poisson``), or of rates with Coulomb's law for the slip behind (``moreau``).
    """

    touched: ClassVar[str] = "wall"
    """What messages call what is touched."""

    size: PositiveLength
    contact: ContactName
    stiffness: ContactStiffness | None = None
    exponent: PositiveNumber | None = None
    dissipation: Dissipation | None = None
    restitution: PositiveNumber | None = None
    least_rate: PositiveSpeed | None = None
    damping: Damping | None = None
    friction: Ratio = 0.0
    friction_law: FrictionName | None = None
    slip: PositiveSpeed | None = None
    least_slip: PositiveSpeed | None = None
    static: Ratio | None = None
    stribeck_speed: PositiveSpeed | None = None
    impact: Impact = "newton"

    @property
    def law(self) -> ContactLaw:
        """The law of the normal force."""
        return contact_laws()[self.contact]

    @property
    def stiffness_exponent(self) -> float:
        """The exponent n of the force K·dⁿ."""
        usual, given = 1.5 if "exponent" in self.law.takes else 1.0, self.supplied["exponent"]
        return usual if given is None else given

    @property
    def supplied(self) -> dict[str, float | None]:
        """The numbers that laws may need; None for those that are missing."""
        return {key: getattr(self, key) for key in _KEYS}

    @property
    def deepest_start(self) -> float:
        """Indentation at which a motion may start at most, in metres."""
        return (PRESSED_SHARE if "stiffness" in self.law.needs else PLACED) * self.size

    def start_problem(self, depth: float, what: str) -> str | None:
        """What is wrong where something starts at an indentation in metres; None if nothing is."""
        if depth <= self.deepest_start:
            return None
        kind = "elastic" if "stiffness" in self.law.needs else "rigid"
        return (
            f"{what} starts {depth:.3g} m within the {self.touched}; expected at most "
            f"{self.deepest_start:.3g} m, {self.deepest_start / self.size:g} of the size, of "
            f"{self.touched}s that are {kind}"
        )

    def faults(self) -> Iterator[Fault]:
        """Keys that the law has or lacks, and numbers out of its range."""
        law = self.law
        if not set(law.needs) <= self.supplied.keys():
            yield "contact", f"{law.name} is a law of journals in bearings; expected another one"
        for key, value in self.supplied.items():
            if key in law.needs and value is None:
                yield (), f"missing key {key!r}, which {law.name} needs"
            elif value is not None and key not in (*law.needs, *law.takes):
                known = ", ".join((*law.needs, *law.takes))
                yield key, f"{law.name} has no {key!r}; it takes {known}"
        written, expected = exponent_of(self.stiffness), self.stiffness_exponent
        if written is not None and written != expected:
            yield (
                "stiffness",
                f"expected a stiffness in {stiffness_unit(expected)}, for the exponent is "
                f"{expected:g}; found {stiffness_unit(written)}",
            )
        yield from self.friction_problems()
        if not self._reachable:
            message = f"expected a restitution > 0 and at most 1, found {self.restitution:g}"
            yield "restitution", message

    def wear_problems(self, wear: Wearing | None, *needed: str) -> Iterator[Fault]:
        """What is wrong with wear, which needs some keys."""
        if wear is None:
            return
        yield from wear.faults_of(self, *needed)
        if not self.rubs:
            expected = "expected a law with a stiffness, or restitution"
            yield "wear", f"{self.law.name} keeps the sides apart; {expected}"

    def friction_problems(self) -> Iterator[Fault]:
        """What friction lacks."""
        rigid, law = self.law.rigid, self._friction_law
        if self.friction and not self.rubs:
            yield "friction", f"{self.law.name} has no friction; expected the law of a force"
        elif rigid and (law != "coulomb" or self.static is not None):
            key = "static" if law == "coulomb" else "friction_law"
            yield key, f"{self.law.name} takes Coulomb's friction alone; expected no {key!r}"
        else:
            yield from friction_problems(law, self._of_slip)
        if self.impact != "newton" and not rigid:
            yield "impact", f"{self.law.name} has no 'impact'; it is for rigid contact"

    @property
    def rubs(self) -> bool:
        """Whether the law of the normal force goes with friction."""
        return self.law.rigid or "stiffness" in self.law.needs

    @property
    def _friction_law(self) -> str:
        if self.friction_law is not None:
            return self.friction_law
        return "coulomb" if self.law.rigid else "tanh"

    @property
    def _of_slip(self) -> dict[str, float | None]:
        return {key: getattr(self, key) for key in FRICTION_KEYS}

    @property
    def _reachable(self) -> bool:
        return self.restitution is None or self.restitution <= 1.0

    @property
    def normal(self) -> Across:
        """The force that presses: the damping factor stands in the place of the restitution.

        What is missing or out of range, as `problems` says, is 1 here.
        """
        usual = USUAL_RATE if self.least_rate is None else self.least_rate
        values: dict[str, float | None] = dict.fromkeys(self.law.needs) | self.supplied
        values |= {"exponent": self.stiffness_exponent, "least_rate": usual}
        factor = self.law.restitution
        if factor is not None and self.restitution is not None and self._reachable:
            values["restitution"] = factor(self.restitution)
        result = self.law.force(
            {
                key: Parameter((*self.path, key), 1.0 if value is None else float(value))
                for key, value in values.items()
            }
        )
        if isinstance(result, RigidContact) and not self.number("friction").absent:
            friction = Parameter((*self.path, "friction"), self.friction)
            return replace(result, friction=friction, impact=self.impact)
        return result

    @property
    def rubbing(self) -> Function | None:
        """Friction along the slip over the normal force, if there is any that forces tell."""
        if self.law.rigid or self.number("friction").absent:
            return None
        return friction_coefficient(self._friction_law, self._of_slip, self.path)


@component
class Touching(ContactKeys):
    """A clearance whose two sides press and rub where they touch.

    Parameters
    ----------
    name
        Clearance name.
    """

    name: Name


@component
class WithoutRoom(ContactKeys):
    """Two bodies that touch without a clearance between them.

    Parameters
    ----------
    size
        Length that indentations are compared with, in metres: laws are made for a tenth of it.
    restitution
        Wanted ratio of the rates after and before an impact, in (0, 1]; 0 as well of rigid bodies.
    """

    size: PositiveLength = 1e-3
    restitution: Ratio | None = None

    @property
    def _reachable(self) -> bool:
        return super()._reachable and (self.law.rigid or self.restitution != 0.0)


def turning_with(name: str, bodies: Mapping[str, Body]) -> str:
    """The body that turns with a body: itself, or what carries the axis of a slider in the end."""
    passed: set[str] = set()
    while name in bodies and name not in passed:
        guide = bodies[name].guide
        if guide is None:
            return name
        passed.add(name)
        name = guide.body or GROUND
    return GROUND


def meeting(joint: str, bodies: Mapping[str, Body], ground: Iterable[str]) -> tuple[str, ...]:
    """What can turn at a joint: bodies that turn, and the ground, each once, the ground first."""
    here = [turning_with(name, bodies) for name, body in bodies.items() if joint in body.points]
    result = [GROUND, *here] if joint in ground else here
    return tuple(sorted(dict.fromkeys(result), key=lambda name: name != GROUND))


def resolved(
    term: Friction,
    bodies: Mapping[str, Body],
    ground: Iterable[str],
    displacements: Iterable[Displacement],
) -> Load:
    """Return the load along an angle that a friction is.

    `bodies` have their joints as the definition names them, not displaced by clearances.
    """
    if isinstance(term, ClearanceFriction):
        second = term.clearance
        first = next(d.body for d in displacements if d.name == second)
    else:
        first, second = term.bodies or meeting(term.joint, bodies, ground)
    against = None if first == GROUND else first
    load = Load(Turn(second, against), term.law, term.path)
    if isinstance(term, ClearanceFriction):
        return load
    pressed = PRESSED in leaves(term.law)
    bearing = _bearing(term.joint, (second, first), bodies, ground) if pressed else None
    return replace(
        load, called=term.called, stores=term.stores, states=term.states, bearing=bearing
    )


def _bearing(
    joint: str, turning: tuple[str, str], bodies: Mapping[str, Body], ground: Iterable[str]
) -> Bearing:
    """The reaction on one of the bodies, but not on the one that loads at the joint belong to."""
    there = [name for name, body in bodies.items() if joint in body.points]
    others = there if joint in ground else there[1:]
    chosen = next((name for name in turning if name in others), others[0])
    return Bearing(chosen, joint)


def ambiguity(
    term: JointFriction, bodies: Mapping[str, Body], ground: Iterable[str]
) -> tuple[KeyPath, str] | None:
    """What is wrong where a joint does not tell between which bodies its friction acts."""
    if term.bodies is not None:
        return None
    result = meeting(term.joint, bodies, ground)
    if len(result) == 2:
        return None
    listed = ", ".join(result)
    if len(result) > 2:
        example = f"bars: [{result[0]}, {result[1]}]"
        message = f"{len(result)} bodies turn at joint {term.joint!r} ({listed})"
        return term.path, f"{message}; expected 'bars' to name two of them, such as {example}"
    message = f"nothing turns at joint {term.joint!r} against {listed or 'anything'}"
    return (*term.path, "joint"), f"{message}; expected a joint of two bodies"


_ONE = Parameter((), 1.0)
_ACROSS = Parameter((), math.pi / 2)


def foot(play: Play, joint: str) -> str:
    """What the point of the axis is called that the joint of a slider would be at without play."""
    return f"{joint}.{play.name}"


def loosened(bodies: Mapping[str, Body], plays: Iterable[Play]) -> dict[str, Body]:
    """Bodies of which some sliders are places on their axes, with blocks behind them.

    A block has all that its slider had: joints, mass, moment of inertia, and what slides on it.
    """
    result, blocks = dict(bodies), {play.slider: play for play in plays}
    for name, body in bodies.items():
        guide = body.guide
        if guide is not None and guide.body in blocks:
            result[name] = replace(body, guide=replace(guide, body=blocks[guide.body].block))
    ordered: dict[str, Body] = {}
    for name, body in result.items():
        play = blocks.get(name)
        if play is None:
            ordered[name] = body
            continue
        place = {foot(play, next(iter(body.points))): (ZERO, ZERO)}
        ordered[name] = replace(body, points=place, mass=ZERO, inertia=ZERO)
        ordered[play.block] = replace(body, name=play.block, kind="block", guide=None)
    return ordered


def ways(bodies: Mapping[str, Body], play: Play) -> tuple[Body, Body]:
    """What leads from the axis to the middle of a block, and what the block is turned by."""
    joint = next(iter(bodies[play.block].points))
    here = {joint: (ZERO, ZERO)}
    across = Guide(foot(play, joint), _ACROSS, play.slider)
    return (
        Body(name=play.offset, kind="offset", path=play.path, points=here, guide=across),
        Body(name=play.tilt, kind="tilt", path=play.path, points=here),
    )


def turned(bodies: Mapping[str, Body], play: Play) -> Relation:
    """The angle of a block: that of its guide, and what it is turned in it."""
    angles, name = [], play.slider
    while name in bodies and (guide := bodies[name].guide) is not None:
        angles.append(guide.angle)
        if guide.body is None:
            return Relation(play.block, ((play.tilt, _ONE),), _sum(play, angles), play.path)
        name = guide.body
    parts = ((name, _ONE), (play.tilt, _ONE))
    return Relation(play.block, parts, _sum(play, angles), play.path)


def _sum(play: Play, angles: list[Parameter]) -> Parameter:
    """The angle of a guide on others."""
    if len(angles) == 1:
        return angles[0]
    kept = any(angle.kept for angle in angles)
    total = sum(angle.value for angle in angles)
    return Parameter((*play.path, "axis"), total, structural=True, kept=kept)
