"""What the components of a mechanism contribute together: bodies, loads, relations and the rest."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import replace
from functools import cached_property, partial
from itertools import chain
from types import GenericAlias
from typing import TypeVar

from linkages.components.contributed.component import Term
from linkages.components.contributed.contact_laws import loosened, resolved, turned, ways
from linkages.components.contributed.load_measures import (
    GROUND,
    Actuation,
    End,
    Friction,
    Load,
    Measure,
    Turn,
    with_sliders,
)
from linkages.components.contributed.normal_forces import Contact, FollowerOnCam
from linkages.components.contributed.state_laws import InternalState, measured_in, winding
from linkages.components.contributed.terms import (
    ZERO,
    Body,
    CamSize,
    Displacement,
    Gravity,
    GroundPin,
    Hint,
    Initial,
    Place,
    Play,
    PointMass,
    Prescribed,
    Relation,
    axis_label,
    oriented,
)

Kind = TypeVar("Kind")


def _all(kind: type[Kind], doc: str) -> cached_property[tuple[Kind, ...]]:
    """All terms of a kind; `doc` says what they are."""
    result = cached_property(lambda self: tuple(t for t in self.terms if isinstance(t, kind)))
    result.__doc__ = doc
    result.func.__annotations__["return"] = GenericAlias(tuple, (kind, ...))  # what the pages show
    return result


def _by(kind: type[Kind], name: str, doc: str) -> cached_property[dict[str, Kind]]:
    """All terms of a kind by what a field of theirs names."""
    terms = _all(kind, "")
    result = cached_property(lambda self: {getattr(t, name): t for t in terms.func(self)})
    result.__doc__ = doc
    result.func.__annotations__["return"] = GenericAlias(dict, (str, kind))
    return result


class Contributions:
    """Terms by what they say, with what has to be looked up among other terms."""

    @cached_property
    @abstractmethod
    def term_groups(self) -> tuple[tuple[Term, ...], ...]:
        """What each component contributes."""

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """What all components contribute, in their order."""
        return tuple(chain.from_iterable(self.term_groups))

    displacements = _all(Displacement, "What clearances displace.")
    plays = _all(Play, "Sliders with room in their guides.")
    prescribed = _by(Prescribed, "body", "Driven coordinates by body.")
    actuations = _by(
        Actuation,
        "name",
        "What makes the motion of the drives in their place, by name; the drives if it is none.",
    )
    initial = _by(Initial, "body", "Free coordinates by body, with their initial state.")
    ends = _all(End, "Where ways end at which bodies bounce.")
    contacts = _all(Contact, "What presses in clearances that open.")
    point_masses = _all(PointMass, "Masses at joints.")
    cam_profiles = _by(CamSize, "slider", "All followers of cams.")
    hints = _by(Hint, "joint", "Where joints are at t = 0.")

    @cached_property
    def ground(self) -> dict[str, Place]:
        """Ground joints and their positions."""
        return {t.joint: t.position for t in self.terms if isinstance(t, GroundPin)}

    @cached_property
    def feet(self) -> tuple[str, ...]:
        """Points of axes at which the joints of blocks would be without play."""
        return tuple(next(iter(self.bodies[play.slider].points)) for play in self.plays)

    @cached_property
    def _given(self) -> dict[str, Body]:
        """What moves and is no part of a clearance alone."""
        return loosened({t.name: t for t in self.terms if isinstance(t, Body)}, self.plays)

    @cached_property
    def bodies(self) -> dict[str, Body]:
        """All moving bodies; clearances have displaced the ends of their bars.

        The origin of every guide of theirs is resolved to coordinates in the frame that carries it;
        the axes of an offset go through the joint itself.
        """
        given = self._given
        renamed: dict[str, dict[str, str]] = {}
        for term in self.displacements:
            renamed.setdefault(term.body, {})[term.joint] = term.renamed
        bodies = [
            self._resolved(body, given, renamed.get(body.name, {})) for body in given.values()
        ]
        links = [link for term in self.displacements for link in term.links]
        links += [way for play in self.plays for way in ways(given, play)]
        return {body.name: body for body in [*bodies, *links]}

    def _resolved(self, body: Body, given: dict[str, Body], renamed: dict[str, str]) -> Body:
        points = {renamed.get(joint, joint): place for joint, place in body.points.items()}
        guide = body.guide
        if guide is not None and isinstance(guide.origin, str):
            places = self.ground if guide.body is None else given[guide.body].points
            guide = replace(guide, origin=places[guide.origin])
        return replace(body, points=points, guide=guide)

    @cached_property
    def meeting(self) -> dict[str, tuple[str, ...]]:
        """Joint → the bodies that meet there: the ground first, then in the order of the file."""
        result: dict[str, list[str]] = {joint: [GROUND] for joint in self.ground}
        for body in self.bodies.values():
            for joint in body.points:
                result.setdefault(joint, []).append(body.name)
        return {joint: tuple(names) for joint, names in result.items()}

    @cached_property
    def anchors(self) -> dict[str, Place]:
        """Points of the ground: its joints, and where the axes that it carries begin."""
        return {**self.ground, **self._axes.get(None, {})}

    @cached_property
    def attachments(self) -> dict[str, dict[str, Place]]:
        """Body → its points in its own frame: its joints, and where the axes that it carries begin.

        The axis point of a slider itself is not among its own, for it moves in its frame.
        """
        axes = self._axes
        return {n: {**body.points, **axes.get(n, {})} for n, body in self.bodies.items()}

    @cached_property
    def _axes(self) -> dict[str | None, dict[str, Place]]:
        """Body (None: the ground) → where the axes that it carries begin."""
        result: dict[str | None, dict[str, Place]] = {}
        for name, body in self.bodies.items():
            guide = body.guide
            if guide is not None and not isinstance(guide.origin, str):
                result.setdefault(guide.body, {})[axis_label(name)] = guide.origin
        return result

    def labels(self, body: str) -> tuple[str, ...]:
        """All points of a body, the axis point of a slider's own guide first."""
        own = () if self.bodies[body].rotates else (self.bodies[body].axis,)
        return (*own, *self.attachments[body])

    def twisting(self, drive: str) -> bool:
        """Whether the effort of a drive, or of an actuator in its place, is a torque."""
        if drive in self.actuations:
            return isinstance(self.actuations[drive].measure, Turn)
        return self.bodies[drive].rotates

    @cached_property
    def loads(self) -> tuple[Load, ...]:
        """Forces, torques, springs and dampers; friction has found its two bodies."""
        bodies, sliders = self._given, self._sliders
        result = (
            resolved(t, bodies, self.ground, self.displacements) if isinstance(t, Friction) else t
            for t in self.terms
            if isinstance(t, Load | Friction)
        )
        return tuple(load.sensing(partial(with_sliders, sliders=sliders)) for load in result)

    @cached_property
    def _sliders(self) -> set[str]:
        """Names of what slides."""
        return {name for name, body in self._given.items() if not body.rotates}

    @cached_property
    def internal(self) -> dict[str, InternalState]:
        """Internal states by name: of loads, then those that belong to none."""
        own = [state for load in self.loads for state in load.states]
        return {state.name: state for state in (*own, *self.states)}

    @cached_property
    def states(self) -> tuple[InternalState, ...]:
        """Internal states that belong to no load."""
        own = (t for t in self.terms if isinstance(t, InternalState))
        return tuple(replace(t, law=with_sliders(t.law, self._sliders)) for t in own)

    @cached_property
    def sampled(self) -> dict[str, InternalState]:
        """Internal states that change at multiples of a period only."""
        return {name: state for name, state in self.internal.items() if state.period is not None}

    @cached_property
    def sensed(self) -> tuple[Measure, ...]:
        """What loads depend on beside what they act along, and states, each once."""
        of_loads = [measure for load in self.loads for measure in load.sensed]
        of_states = [m.measure for state in self.states for m in measured_in(state.law)]
        found = (*of_loads, *of_states)
        return tuple(dict.fromkeys(measure for measure in found if measure is not None))

    @cached_property
    def wound(self) -> tuple[Turn, ...]:
        """Angles whose whole turns laws of loads or states feel."""
        of_loads = [turn for load in self.loads for turn in load.wound]
        of_states = [m.measure for state in self.states for m in winding(state.law)]
        return (*of_loads, *(turn for turn in of_states if isinstance(turn, Turn)))

    def carrier(self, joint: str) -> str | None:
        """The body that loads and masses at a joint belong to: the first there, or None."""
        return None if joint in self.ground else self._carriers.get(joint)

    @cached_property
    def _carriers(self) -> dict[str, str]:
        """Joint → the first body that has it."""
        result: dict[str, str] = {}
        for name, body in self.bodies.items():
            for joint in body.points:
                result.setdefault(joint, name)
        return result

    def placed(self, body: str | None, joint: str) -> tuple[str | None, str]:
        """The body that has a joint (None: the ground), and what it calls it.

        Clearances displace the joints of bars, and blocks with room in their guides have those of
        their sliders.
        """
        renamed = (t.renamed for t in self.displacements if (t.body, t.joint) == (body, joint))
        label = next(renamed, joint)
        own = body is None or label in self.bodies[body].points
        return (body if own else self.carrier(label)), label

    def bearing(self, slider: Body) -> str | None:
        """The body that carries the axis of a sliding body; None for the ground."""
        if slider.afloat:
            return self.carrier(slider.axis)
        return None if slider.guide is None else slider.guide.body

    @property
    def loose(self) -> bool:
        """Whether joints or guides have clearance."""
        return bool(self.displacements or self.plays)

    @property
    def clearance_names(self) -> tuple[str, ...]:
        """Names of clearances in results: those of joints, then corners of blocks, and walls."""
        pins = [term.name for term in self.displacements]
        return tuple(dict.fromkeys([*pins, *(contact.name for contact in self.contacts)]))

    @cached_property
    def rubbing(self) -> tuple[Contact | Displacement, ...]:
        """Contacts, then massless links, whose surfaces wear."""
        terms: list[Contact | Displacement] = [*self.contacts, *self.displacements]
        return tuple(term for term in terms if term.rubbing is not None)

    @property
    def lifting(self) -> tuple[Turn, ...]:
        """Angles of cams that followers may leave, where whole turns of them count."""
        cams = (c.geometry for c in self.contacts if isinstance(c.geometry, FollowerOnCam))
        return tuple(Turn(cam.cam, None) for cam in cams if not cam.lift.turning)

    @cached_property
    def relations(self) -> tuple[Relation, ...]:
        """Welds, gears and racks, and what turns blocks."""
        known = {*self.prescribed, *self.initial}
        result = oriented((t for t in self.terms if isinstance(t, Relation)), known)
        return (*result, *(turned(self._given, play) for play in self.plays))

    @cached_property
    def cams(self) -> dict[str, CamSize]:
        """Followers with a roller or a knife edge on cams whose size is known."""
        profiles = self.cam_profiles.values()
        return {p.slider: p for p in profiles if p.base is not None and not p.flat}

    @cached_property
    def gravity(self) -> Gravity:
        """The gravitational acceleration; zero if none is given."""
        return next((t for t in self.terms if isinstance(t, Gravity)), Gravity(ZERO, ZERO))
