"""Linkages of the package pylinkage, which synthesises and optimises their kinematics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from linkages.bridges.pmks import Draft, named, refused
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.spec.units import Unit, unit

if TYPE_CHECKING:
    from pylinkage.simulation.linkage import Linkage

SOURCE = "pylinkage"


def from_pylinkage(
    linkage: Linkage,
    *,
    units: str = "m",
    step: float = 1.0,
    mass_per_length: float = 0.0,
    clearances: Mapping[str, float] | None = None,
) -> Mechanism:
    """A mechanism from a linkage of `pylinkage`, in the position that it is in.

    Parameters
    ----------
    linkage
        Of fixed points, cranks, and dyads of the kinds RRR, RRP and fixed.
    units
        What its lengths are in.
    step
        Seconds that one of its steps takes: cranks turn by `angular_velocity` in a step.
    mass_per_length
        Of all bars, in kg/m; plates have it along their outline.
    clearances
        Name of a joint → radial size in metres.

    Raises
    ------
    InputError
        For what a definition cannot express, such as an actuator that goes back and forth.
    ValueError
        If units, step, mass or joints make no sense.

    Examples
    --------
    >>> import linkages, pylinkage
    >>> O, C = pylinkage.Ground(0, 0, name="O"), pylinkage.Ground(3, 0, name="C")
    >>> crank = pylinkage.Crank(O, radius=1, angular_velocity=0.1, name="A")
    >>> rocker = pylinkage.RRRDyad(crank.output, C, distance1=3, distance2=2, name="B")
    >>> linkages.from_pylinkage(pylinkage.Linkage([O, C, crank, rocker], name="Four-bar"))
    Mechanism('Four-bar', joints=2, bars=3, drives=1, assembly=1)
    """
    import pylinkage

    if not isinstance(linkage, pylinkage.Linkage):
        raise TypeError(f"expected a pylinkage.Linkage, found {linkage!r}")
    if not step > 0.0:
        raise ValueError(f"step must be seconds > 0, found {step!r}")
    if not mass_per_length >= 0.0:
        raise ValueError(f"mass_per_length must be kg/m >= 0, found {mass_per_length!r}")
    reading = _Reading(linkage, unit(units), step)
    draft = reading.draft
    if mass_per_length:
        draft.weigh(mass_per_length)
    draft.loosen(clearances or {})
    return draft.mechanism()


class _Reading:
    """Component after component becomes joints, bars and sliders of a draft."""

    def __init__(self, linkage: Linkage, units: Unit, step: float) -> None:
        import pylinkage

        self._metres, self._step = units.convert, step
        self.draft = Draft(named(_given(linkage), "linkage", ()))
        self._names: dict[int, str] = {}
        kinds = {
            pylinkage.Ground: self._ground,
            pylinkage.Crank: self._crank,
            pylinkage.RRRDyad: self._two_bars,
            pylinkage.FixedDyad: self._fixed,
            pylinkage.RRPDyad: self._slider,
        }
        linkage.rebuild()
        for component in linkage._solve_order:
            read: Any = kinds.get(type(component))
            if read is None:
                kind, known = type(component).__name__, ", ".join(k.__name__ for k in kinds)
                raise refused(
                    SOURCE,
                    f"{component.name} is a {kind}, which a definition cannot express; expected "
                    f"one of {known}",
                )
            given = _given(component)
            name = named(given, f"J{len(self._names) + 1}", self._names.values())
            self._names[id(component)] = name
            read(component, name)

    def _name(self, anchor: Any) -> str:
        return self._names[id(getattr(anchor, "_parent", anchor))]

    def _place(self, component: Any) -> tuple[float, float]:
        return self._metres(component.x), self._metres(component.y)

    def _bar(self, first: str, second: str, length: float) -> str:
        if not length > 0.0:
            raise refused(SOURCE, f"the bar from {first} to {second} has length {length:g}")
        name = named(f"{first}-{second}", "bar", self.draft.bodies)
        self.draft.bodies[name] = {first: (0.0, 0.0), second: (self._metres(length), 0.0)}
        return name

    def _ground(self, component: Any, name: str) -> None:
        self.draft.joints[name] = self._place(component)

    def _crank(self, component: Any, name: str) -> None:
        anchor = component.anchor
        bar = self._bar(self._name(anchor), name, component.radius)
        angle = math.atan2(component.y - anchor.y, component.x - anchor.x)
        speed = component.angular_velocity / self._step
        self.draft.drives[bar] = {"angle": angle, "speed": speed}

    def _two_bars(self, component: Any, name: str) -> None:
        self._bar(self._name(component.anchor1), name, component.distance1)
        self._bar(self._name(component.anchor2), name, component.distance2)
        self.draft.assembly[name] = self._place(component)

    def _fixed(self, component: Any, name: str) -> None:
        first, second = self._name(component.anchor1), self._name(component.anchor2)
        if first in self.draft.joints and second in self.draft.joints:
            self.draft.joints[name] = self._place(component)
            return
        body = self.draft.body_with(first, second)
        if body is None:
            raise refused(
                SOURCE,
                f"{name} keeps its place to {first} and {second}, which are not on one bar: it is "
                "on no rigid body",
            )
        polar = self._metres(component.distance), component.angle
        self.draft.fix(body, name, first, second, polar)

    def _slider(self, component: Any, name: str) -> None:
        first, second = self._name(component.line_anchor1), self._name(component.line_anchor2)
        if first in self.draft.joints and second in self.draft.joints:
            (x, y), (u, v) = self.draft.joints[first], self.draft.joints[second]
            axis: dict[str, Any] = {"through": first, "angle": math.atan2(v - y, u - x)}
        else:
            body = self.draft.body_with(first, second)
            if body is None:
                raise refused(
                    SOURCE,
                    f"{name} slides along the line through {first} and {second}, which are not on "
                    "one bar",
                )
            (x, y), (u, v) = (self.draft.bodies[body][point] for point in (first, second))
            axis = {"on": body, "through": first, "angle": math.atan2(v - y, u - x)}
        self._bar(self._name(component.revolute_anchor), name, component.distance)
        block = named(f"slider {name}", "slider", [*self.draft.bodies, *self.draft.sliders])
        self.draft.sliders[block] = {"joint": name, **axis}
        self.draft.assembly[name] = self._place(component)


def _given(part: Any) -> str:
    """The name that somebody gave; where nobody did, pylinkage has the address in memory."""
    return "" if str(part.name) == str(id(part)) else str(part.name)
