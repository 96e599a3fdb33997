"""A mechanism: components that fit together, and the terms that they contribute."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

from linkages.components.clearance import Clearance
from linkages.components.component import Component
from linkages.components.consistency import Declared, findings
from linkages.components.simulation import SimulationDefaults
from linkages.components.terms import (
    ZERO,
    AxialForce,
    Body,
    Displacement,
    Gravity,
    GroundPin,
    Hint,
    Initial,
    Parameter,
    Path,
    Prescribed,
    Term,
)
from linkages.errors import InputError, Problem
from linkages.reading.document import Document, dotted


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """A planar linkage, from a definition file or built in Python.

    Parameters
    ----------
    components
        Bars, joints, sliders, … in the order that reports and results keep.
    name
        For titles.
    source
        What messages call the place that it comes from.
    document
        The definition file, if there is one: gives problems their line.

    Raises
    ------
    InputError
        With everything that does not fit together.
    """

    components: tuple[Component, ...]
    name: str = "mechanism"
    source: str = "mechanism"
    document: Document | None = field(default=None, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "components", tuple(self.components))
        found = findings(self.components, Declared(self.components))
        if found:
            raise self.error(found)

    def problem(self, path: Path, message: str) -> Problem:
        """A problem at a place of the definition, with its line where there is a file."""
        if self.document is not None:
            return self.document.problem(path, message)
        return Problem(message=message, path=dotted(path))

    def error(self, found: Iterable[tuple[Path, str]]) -> InputError:
        """An error that lists problems at their places."""
        return InputError(self.source, [self.problem(path, message) for path, message in found])

    @cached_property
    def terms(self) -> tuple[Term, ...]:
        """What all components contribute, in their order."""
        return tuple(term for component in self.components for term in component.terms())

    @cached_property
    def ground(self) -> dict[str, tuple[Parameter, Parameter]]:
        """Ground joints and their positions."""
        return {t.joint: t.position for t in self.terms if isinstance(t, GroundPin)}

    @cached_property
    def bodies(self) -> dict[str, Body]:
        """All moving bodies; clearances have displaced the ends of their bars."""
        displaced = [t for t in self.terms if isinstance(t, Displacement)]
        bodies = [self._resolved(t, displaced) for t in self.terms if isinstance(t, Body)]
        return {body.name: body for body in [*bodies, *(term.link for term in displaced)]}

    def _resolved(self, body: Body, displaced: list[Displacement]) -> Body:
        renamed = {t.joint: t.renamed for t in displaced if t.body == body.name}
        points = {renamed.get(joint, joint): place for joint, place in body.points.items()}
        guide = body.guide
        if guide is not None and isinstance(guide.origin, str):
            guide = replace(guide, origin=self.ground[guide.origin])
        return replace(body, points=points, guide=guide)

    @cached_property
    def prescribed(self) -> dict[str, Prescribed]:
        """Driven coordinates by body."""
        return {t.body: t for t in self.terms if isinstance(t, Prescribed)}

    @cached_property
    def initial(self) -> dict[str, Initial]:
        """Free coordinates by body, with their initial state."""
        return {t.body: t for t in self.terms if isinstance(t, Initial)}

    @cached_property
    def forces(self) -> tuple[AxialForce, ...]:
        """Forces on sliders."""
        return tuple(t for t in self.terms if isinstance(t, AxialForce))

    @cached_property
    def gravity(self) -> Gravity:
        """The gravitational acceleration; zero if none is given."""
        return next((t for t in self.terms if isinstance(t, Gravity)), Gravity(ZERO, ZERO))

    @cached_property
    def hints(self) -> dict[str, Hint]:
        """Where joints are at t = 0."""
        return {t.joint: t for t in self.terms if isinstance(t, Hint)}

    @cached_property
    def simulation(self) -> SimulationDefaults:
        """How its author wants it to be simulated."""
        own = (c for c in self.components if isinstance(c, SimulationDefaults))
        return next(own, SimulationDefaults())

    def with_component(self, component: Component) -> Mechanism:
        """The same mechanism with one more component."""
        return replace(self, components=(*self.components, component))

    def ideal(self) -> Mechanism:
        """The same mechanism without its clearances."""
        kept = tuple(c for c in self.components if not isinstance(c, Clearance))
        return replace(self, components=kept, name=f"{self.name} (ideal)")
