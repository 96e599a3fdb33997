"""The arguments of a kernel: parameters, time and state as nodes of its graph."""

from __future__ import annotations

from collections.abc import Iterable

from linkages.components.contributed.terms import Parameter, Path
from linkages.kernel.graph.scalars import Level, Scalar, ScalarGraph
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.numbers.effects import Fed, slots
from linkages.kernel.numbers.parameters import NEAREST

_KEYS = frozenset(
    {
        "angle", "center", "damping", "dissipation", "exponent", "force", "friction", "inertia",
        "law", "least_rate", "length", "mass", "pin_radius", "points", "position", "ratio",
        "restitution", "size", "slip", "speed", "spline", "stiffness", "through", "torque",
    }
)  # fmt: skip


class Inputs:
    """Nodes of a graph for the arguments of a kernel.

    Parameters
    ----------
    graph
        The graph that gets the input nodes.
    coordinates
        Number of integrated coordinates n; the state is n coordinates, then n rates.
    paths
        Path of each entry of the parameter array.

    Attributes
    ----------
    parameters
        Path → its place in the parameter array.
    """

    def __init__(self, graph: ScalarGraph, coordinates: int, paths: Iterable[Path] = ()) -> None:
        self.graph = graph
        self.coordinates = coordinates
        self.parameters = {path: place for place, path in enumerate(paths)}

    @property
    def time(self) -> Scalar:
        """Time in seconds."""
        return self.graph.input("t", 0, Level.TIME)

    def coordinate(self, index: int) -> Scalar:
        """Integrated coordinate `index`."""
        return self.graph.input("y", index, Level.STATE)

    def rate(self, index: int) -> Scalar:
        """Rate of integrated coordinate `index`."""
        return self.graph.input("y", self.coordinates + index, Level.STATE)

    def acceleration(self, index: int) -> Scalar:
        """Second derivative of coordinate `index`, known after the rates have been evaluated."""
        return self.graph.input("a", index, Level.STATE)

    def parameter(self, parameter: Parameter) -> Scalar:
        """A number of the definition file; a structural zero is the constant 0."""
        if parameter.absent:
            return self.graph.zero
        return self._placed(parameter.path)

    def vector(self, pair: tuple[Parameter, Parameter]) -> Vector:
        """Two numbers of the definition file."""
        return Vector(self.parameter(pair[0]), self.parameter(pair[1]))

    def side(self, block: int) -> Scalar:
        """The sign that selects the assembly mode of a block, +1 or −1."""
        return self._placed(("side", block))

    def turns(self, load: int) -> Scalar:
        """The multiple of 2π by which the difference of a spring's angles is too large at t = 0."""
        return self._placed(("turns", load))

    def slope(self, slot: int) -> Scalar:
        """Derivative of a parameter by a number of the definition, see `Effects.slopes`."""
        if ("slope", slot) in self.parameters:
            return self._placed(("slope", slot))
        return self.graph.input("slope", slot, Level.PARAMETERS)

    def fed(self, paths: Fed) -> list[dict[int, Scalar]]:
        """For each number of a definition the rates of the parameters that it feeds."""
        found: list[dict[int, Scalar]] = [{} for _ in paths]
        for slot, (number, path) in enumerate(slots(paths)):
            found[number][self._placed(path).index] = self.slope(slot)
        return found

    @property
    def nearest(self) -> Scalar:
        """Distance of a spring's ends below which it is round-off, in metres."""
        return self._placed(NEAREST)

    def mode(self, index: int) -> Scalar:
        """Mode of a switch, +1 or −1."""
        return self.graph.input("mode", index, Level.STATE)

    def memory(self, index: int) -> Scalar:
        """A number kept from the last time at which a switch rose."""
        return self.graph.input("memory", index, Level.STATE)

    def memory_tangent(self, index: int) -> Scalar:
        """Derivative of such a number along a tangent."""
        return self.graph.input("memory_tangent", index, Level.STATE)

    def iterate(self, index: int) -> Scalar:
        """An unknown within an iteration."""
        return self.graph.input("z", index, Level.STATE)

    def _placed(self, path: Path) -> Scalar:
        return self.graph.input("p", self.parameters[path], Level.PARAMETERS)

    def describe(self) -> list[str]:
        """What each parameter is, with numbers in the place of the file's names."""
        numbers: dict[tuple, int] = {}
        return [_numbered_path(path, numbers) for path in self.parameters]


def _numbered_path(path: Path, numbers: dict[tuple, int]) -> str:
    """A path without any text of the user, for comments of the generated code.

    Keys of a component stand second behind the section; whatever stands elsewhere is a name, even
    if it reads like a key.
    """
    section, *rest = path
    parts = [str(section)]
    for place, element in enumerate(rest):
        if isinstance(element, int) or (place == 1 and element in _KEYS):
            parts.append(str(element))
        else:
            family = [key for key in numbers if key[:2] == (section, place)]
            parts.append(f"#{numbers.setdefault((section, place, element), len(family))}")
    return ".".join(parts)
