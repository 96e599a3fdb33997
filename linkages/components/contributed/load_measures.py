"""What loads act along: distances, angles, axes; and the quantities that laws may refer to.

A measure has a value x and its rate v. The law gives the force that increases x, as a function of
x, v and time; so its power is force · v, and whatever a measure is, any law goes with it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import cached_property
from operator import is_
from typing import ClassVar, assert_never

from linkages.components.contributed.functions import (
    PRESSED,
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
    V,
    X,
)
from linkages.components.contributed.normal_forces import RigidContact
from linkages.components.contributed.state_laws import (
    NOTHING,
    InternalState,
    addends,
    exchanged,
    folded,
    internal,
    leaves,
    measured_in,
    monomial,
    of_state,
    rated,
    stored,
    sum_of,
    time_functions,
    variables,
    winding,
)
from linkages.components.contributed.terms import Parameter
from linkages.operations import ATOM, ELEMENTARY
from linkages.reading.paths import KeyPath
from linkages.spec.formulas import Sensed


@dataclass(frozen=True)
class Distance:
    """The distance of two joints (m). A force that increases it pushes them apart."""

    unit: ClassVar[str] = "N"

    first: str
    second: str


@dataclass(frozen=True)
class Turn:
    """The angle of a body against another one, or the ground (None); whole turns count (rad).

    A torque that increases it acts on ``body``, the opposite one on ``reference``.
    """

    unit: ClassVar[str] = "N m"

    body: str
    reference: str | None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Those that turn."""
        return (self.body,) if self.reference is None else (self.body, self.reference)


@dataclass(frozen=True)
class Slide:
    """The displacement of a sliding body (m). What carries its axis gets the opposite force."""

    unit: ClassVar[str] = "N"

    body: str


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a joint in the ground's frame (m): `axis` 0 is x, 1 is y."""

    unit: ClassVar[str] = "N"

    joint: str
    axis: int


@dataclass(frozen=True)
class BodyAxis:
    """An axis of a body's own frame, at a joint: `axis` 0 is its first one, 1 its second.

    A force along it turns with the body. It has a rate, the joint's velocity along the axis, but no
    value: what such a force does depends on the way.
    """

    unit: ClassVar[str] = "N"

    joint: str
    body: str
    axis: int


# A closed union: `assert_never` behind a match finds a measure that somebody forgot.
Measure = Distance | Turn | Slide | Coordinate | BodyAxis


@dataclass(frozen=True)
class Actuation:
    """A force or torque along a measure that makes the motion of drives, in their place."""

    name: str
    measure: Measure
    path: KeyPath


@dataclass(frozen=True)
class Bearing:
    """Where the reaction is that presses the surfaces of a friction together."""

    # It acts on a body at a joint; or at the point of a slider's axis, across that axis
    body: str
    point: str


@dataclass(frozen=True)
class Load:
    """A force or torque along a measure.

    Parameters
    ----------
    measure
        What it acts along.
    law
        The force (N, N·m) as a function of time, of the measure's value `X` and rate `V`, and of
        other measures.
    path
        Where it stands in the definition file.
    called
        What reports call it; empty where its measure and the form of its law say that.
    applied
        Whether outputs list it with forces and torques from outside, though it depends on the
        state: a motor, a cylinder.
    stores
        The potential energy in J where the form of the law does not give it: a function of `X`, of
        all terms without v and t, or a function of internal states.
    states
        Internal states that belong to it; their laws are functions like its own.
    bearing
        Whose reaction the law is a multiple of, if it depends on one.
    """

    measure: Measure
    law: Function
    path: KeyPath
    called: str = ""
    applied: bool = False
    stores: Function | None = None
    states: tuple[InternalState, ...] = ()
    bearing: Bearing | None = None

    def __post_init__(self) -> None:
        """What the law senses of its own measure is its value and its rate."""
        object.__setattr__(self, "law", self._owned(self.law))
        states = tuple(replace(state, law=self._owned(state.law)) for state in self.states)
        object.__setattr__(self, "states", states)

    def _owned(self, law: Function) -> Function:
        if any(m.measure is not None and self._own(m.measure) for m in measured_in(law)):
            return exchanged(law, self._renamed)
        return law

    def sensing(self, changed: Callable[[Function], Function]) -> Load:
        """The same where what its laws sense is something else."""
        law = changed(self.law)
        inner = [changed(state.law) for state in self.states]
        if law is self.law and all(map(is_, inner, (state.law for state in self.states))):
            return self
        states = tuple(map(lambda s, law: replace(s, law=law), self.states, inner))
        return replace(self, law=law, states=states)

    @property
    def functions(self) -> tuple[Function, ...]:
        """The law without what exact zeros remove, and the laws of internal states."""
        return (self.force, *(state.law for state in self.states))

    def _own(self, other: Measure) -> bool:
        back = isinstance(other, Distance) and Distance(other.second, other.first)
        return self.measure in (other, back)

    def _renamed(self, found: Measured) -> Measured:
        own = found.measure is not None and self._own(found.measure)
        return Measured(found.order) if own else found

    @property
    def unit(self) -> str:
        """Of the force or torque."""
        return self.measure.unit

    @property
    def twists(self) -> bool:
        """Whether it is a torque."""
        return self.unit == "N m"

    @property
    def given(self) -> bool:
        """Whether the force is a function of time, as it is written: not a spring or damper."""
        return not of_state(self.law)

    @property
    def sensed(self) -> tuple[Measure, ...]:
        """Other measures that the force and internal states depend on."""
        result = (leaf.measure for law in self.functions for leaf in measured_in(law))
        return tuple(dict.fromkeys(measure for measure in result if measure is not None))

    @property
    def passive(self) -> bool:
        """Whether outputs list it with springs and dampers."""
        return not self.applied and (self.stores is not None or not self.given)

    @property
    def pushes(self) -> bool:
        """Whether it is a force or torque from outside, for drawings and reports."""
        return self.given or (self.applied and not self.called)

    @property
    def follows(self) -> bool:
        """Whether it turns with a body: no energy then says what it does along a way."""
        return isinstance(self.measure, BodyAxis) and not self.absent

    @cached_property
    def force(self) -> Function:
        """The law without what exact zeros remove."""
        return folded(self.law)

    @property
    def absent(self) -> bool:
        """Whether exact zeros remove all of it."""
        return self.force == NOTHING

    @property
    def elastic(self) -> bool:
        """Whether it depends on the value of the measure, or internal states store energy."""
        return X in leaves(self.force) or internal(self.energy)

    @property
    def dissipates(self) -> bool:
        """Whether it depends on a rate or an internal state; sets of states may shrink then."""
        return rated(self.force) or internal(self.force)

    @cached_property
    def wound(self) -> tuple[Turn, ...]:
        """Angles whose whole turns it feels."""
        angles = (m.measure for law in self.functions for m in winding(law))
        result = (self.measure if measure is None else measure for measure in angles)
        return tuple(dict.fromkeys(m for m in result if isinstance(m, Turn)))

    @property
    def turned(self) -> tuple[str, ...]:
        """Bodies whose whole turns it feels."""
        return tuple(dict.fromkeys(body for turn in self.wound for body in turn.bodies))

    @property
    def laws(self) -> tuple[Function, ...]:
        """The functions of time that it follows: all of a given force, the factors of another."""
        if self.given:
            return (self.law,)
        return tuple(part for law in self.functions for part in time_functions(law))

    @property
    def deflection(self) -> Function:
        """What it is a spring of: x, less where it is relaxed."""
        products = map(monomial, addends(self.force))
        return next((m.base for m in products if m is not None and m.base is not None), X)

    @cached_property
    def energy(self) -> Function:
        """The potential energy that it has in a closed form, a function of `X` (J)."""
        if self.stores is not None:
            return folded(self.stores)
        return sum_of(energy for term in addends(self.force) if (energy := stored(term)))

    @cached_property
    def working(self) -> Function:
        """The part of the force whose work is in no `energy`."""
        return sum_of(term for term in addends(self.force) if not self._stored(term))

    def _stored(self, term: Function) -> bool:
        if self.stores is not None:
            return variables(term) in (["x"], [])
        return stored(term) is not None

    @cached_property
    def still(self) -> Function:
        """The part of the force that no rate is in."""
        return sum_of(term for term in addends(self.force) if not rated(term))


@dataclass(frozen=True)
class JointFriction:
    """What acts at a joint where two bodies turn; if not named, between the only two there.

    A mechanism makes it a `Load` along their angle.
    """

    joint: str
    bodies: tuple[str, str] | None
    law: Function
    path: KeyPath
    called: str = ""
    stores: Function | None = None
    states: tuple[InternalState, ...] = ()


@dataclass(frozen=True)
class ClearanceFriction:
    """What turns the link of a clearance with the bar that it displaces.

    A mechanism makes it a `Load` along their angle.
    """

    clearance: str
    law: Function
    path: KeyPath


Friction = JointFriction | ClearanceFriction


Factor = Parameter | Function
"""A number of the definition file, or a law."""


def damper_law(damping: Factor) -> Function:
    """Return −damping·v."""
    return Operation("neg", (Operation("mul", (_function(damping), V)),))


def spring_law(stiffness: Factor, relaxed: Factor, damping: Factor) -> Function:
    """Return −damping·v − stiffness·(x − relaxed)."""
    deflection = Operation("sub", (X, _function(relaxed)))
    spring = Operation("mul", (_function(stiffness), deflection))
    return Operation("sub", (damper_law(damping), spring))


def _function(factor: Factor) -> Function:
    return Number(factor) if isinstance(factor, Parameter) else factor


GROUND = "ground"


@dataclass(frozen=True, kw_only=True)
class Revolute:
    """Two bodies that share a joint and turn freely about it.

    The reaction of the pair is the force that `first` exerts on `second`.
    """

    joint: str  # joint name
    # Bodies; `first` may be the ground
    first: str
    second: str


def revolute_pairs(joint: str, bodies: tuple[str, ...]) -> tuple[Revolute, ...]:
    """A joint of k bodies as k − 1 revolute pairs, all with the first body.

    `joint`: joint name.
    `bodies`: the bodies that meet there, the ground first where it is one of them.
    """
    first, *others = bodies
    return tuple(Revolute(joint=joint, first=first, second=other) for other in others)


_RATES = ("velocity", "speed", "vx", "vy")


def measured_by(found: Sensed) -> Measured:
    """The measure that a quantity of a formula is, or its rate.

    A speed is that of an angle until the whole mechanism tells sliders: see `with_sliders`.
    """
    order = 1 if found.rate or found.word in _RATES else 0
    return Measured(order, _measure(found.word, found.names))


def _measure(word: str, names: tuple[str, ...]) -> Measure:
    match word, names:
        case "distance", (first, second):
            return Distance(first, second)
        case "angle", (first, second):
            return Turn(second, None if first == GROUND else first)
        case (("position" | "velocity"), (body,)):
            return Slide(body)
        case (("x" | "y" | "vx" | "vy"), (joint,)):
            return Coordinate(joint, "xy".index(word[-1]))
        case _, (body, *_):
            return Turn(body, None)
    raise ValueError(f"no quantity {word!r}")


def with_sliders(function: Function, sliders: Collection[str]) -> Function:
    """The same function where the speeds of sliders are those along their axes."""

    def slid(found: Measured) -> Measured:
        match found.measure:
            case Turn(body, None) if body in sliders:
                return Measured(found.order, Slide(body))
        return found

    if any(slid(item) != item for item in measured_in(function)):
        return exchanged(function, slid)
    return function


def words(measure: Measure, order: int) -> str:
    """What formulas call the value of a measure (`order` 0) or its rate (1)."""
    match measure:
        case Distance(first, second):
            return _rate(f"distance({first}, {second})", order)
        case Turn(body, None):
            return f"{body}.{'speed' if order else 'angle'}"
        case Turn(body, reference):
            return _rate(f"angle({reference}, {body})", order)
        case Slide(body):
            return f"{body}.{'velocity' if order else 'position'}"
        case Coordinate(joint, axis):
            return f"{joint}.{'v' * order}{'xy'[axis]}"
        case BodyAxis(joint, body):
            return f"the velocity of {joint} along {body}"
        case _:
            assert_never(measure)


def _rate(text: str, order: int) -> str:
    return f"rate({text})" if order else text


def written(function: Function, own: Measure | None = None) -> str:
    """A function as sentences show it, shortened.

    `function`: part of a law.
    `own`: what its load acts along; None if it belongs to none.
    """
    text = _written(function, own)[0]
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 1]}…"


_LONGEST = 60


def _written(function: Function, own: Measure | None) -> tuple[str, int]:
    """Text, and how strongly it binds."""
    match function:
        case Number(parameter):
            return f"{parameter.value:.6g}", ATOM if parameter.value >= 0.0 else 1
        case Time():
            return "t", ATOM
        case Measured() if function == PRESSED:
            return "reaction", ATOM
        case Measured(order, measure):
            of = own if measure is None else measure
            return "xv"[order] if of is None else words(of, order), ATOM
        case Internal(name):
            return name, ATOM
        case Table():
            return f"table({_written(function.over, own)[0]})", ATOM
        case Operation("where", (difference, *_)):
            return f"where({_written(difference, own)[0]} >= 0)", ATOM
        case Operation("power", (base, Number(exponent))):
            return f"{_bound(base, own, ATOM)}**{exponent.value:.0f}", 3
        case Operation(name, arguments):
            form = ELEMENTARY[name].operator if name in ELEMENTARY else None
            if form is None:
                return f"{name}({', '.join(_written(a, own)[0] for a in arguments)})", ATOM
            parts = (_bound(a, own, s) for a, s in zip(arguments, form.operands, strict=False))
            return form.template.format(*parts), form.strength
        case _:
            assert_never(function)


def _bound(function: Function, own: Measure | None, strength: int) -> str:
    text, own_strength = _written(function, own)
    return text if own_strength >= strength else f"({text})"


def named(function: Function, own: Measure | None = None) -> list[str]:
    """What a function depends on, t last: own measures are x and v unless they are given."""

    def word(leaf: Measured | Internal) -> str:
        if isinstance(leaf, Internal):
            return leaf.name
        of = leaf.measure or own
        return "xv"[leaf.order] if of is None else words(of, leaf.order)

    found = (leaf for leaf in leaves(function) if isinstance(leaf, Measured | Internal))
    result = dict.fromkeys(word(leaf) for leaf in found if leaf != PRESSED)
    ordered = [name for name in ("x", "v") if name in result]
    timed = ["t"] if "t" in variables(function) else []
    return [*ordered, *(name for name in result if name not in ordered), *timed]


@dataclass(frozen=True)
class End:
    """A value that a measure does not pass."""

    name: str  # what results and sentences call it
    measure: Measure  # what it ends
    limit: Parameter  # the value (m, rad)
    upper: bool  # whether the measure is not larger; otherwise it is not smaller
    law: RigidContact  # of the impacts there
    path: KeyPath  # where it stands in the definition file

    @property
    def twists(self) -> bool:
        """Whether it exerts a torque."""
        return isinstance(self.measure, Turn)
