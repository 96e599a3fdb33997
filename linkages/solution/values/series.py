"""Single series of outputs by name: ``slider9.velocity``, ``r1.force``, ``B.x position``."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.system import System
from linkages.reading.wording import listed, suggestion
from linkages.solution.values.requests import available

Floats = NDArray[np.float64]

if TYPE_CHECKING:
    import xarray as xr

TIME = "time"

SYNONYMS = {
    "displacement": "position",
    "rotation": "angle",
    "torque": "effort",
    "velocities": "velocity",
    "omega": "speed",
    "alpha": "acceleration",
}
"""Words that people look for → those of names."""


@dataclass(frozen=True)
class Series:
    """One element of an output variable.

    Parameters
    ----------
    name
        ``ELEMENT.QUANTITY``, or the variable where it has no elements.
    variable
        Entry of the outputs, or ``time``.
    place
        Dimension → label, in the order of the dimensions.
    size
        Whether it is the magnitude of a vector; of those that figures show.
    """

    name: str
    variable: str
    place: Mapping[str, str]
    size: bool = False

    @property
    def angle(self) -> bool:
        """Whether it is an angle in which whole turns count."""
        return self.variable != TIME and VARIABLES[self.variable].angle

    def of(self, data: xr.Dataset) -> xr.DataArray:
        """The series in a solution's data."""
        array = data[self.variable]
        found = array.sel(dict(self.place)) if self.place else array
        return (found**2).sum("axis") ** 0.5 if self.size else found

    def words(self, long_name: str) -> str:
        """What an axis calls it: the variable's name, and whose it is."""
        elements = [label for dim, label in self.place.items() if dim != "axis"]
        component = f", {self.place['axis']} component" if "axis" in self.place else ""
        of = f" of {' by '.join(reversed(elements))}" if elements and self.variable != TIME else ""
        return f"{long_name}{of}{component}"

    def node(self, model: Model) -> Scalar:
        """The series as a node of a model; for variables that are evaluated from nodes."""
        return VARIABLES[self.variable].evaluated(model)[self.index(model)]

    def index(self, model: Model) -> int:
        """Its place among all elements of the variable, the last dimension running fastest."""
        index = 0
        for dim, label in self.place.items():
            names = labels(model, dim)
            index = index * len(names) + names.index(label)
        return index

    def picked(self, values: Mapping[str, Floats], model: Model) -> Floats:
        """The series out of values of variables, which have shape (samples, …) each."""
        rows = values[self.variable]
        return rows.reshape(len(rows), -1)[:, self.index(model)]


def system_series(system: System) -> dict[str, Series]:
    """Name → series, all that a mechanism has."""
    dims = {name: VARIABLES[name].dims for name in available(system)}
    return _series(dims, lambda dim: labels(system.model, dim))


def data_series(data: xr.Dataset) -> dict[str, Series]:
    """Name → series, all that the data have."""
    dims = {str(name): [str(d) for d in array.dims[1:]] for name, array in data.data_vars.items()}
    return _series(dims, lambda dim: [str(label) for label in data[dim].values])


def with_sizes(known: Mapping[str, Series]) -> dict[str, Series]:
    """These and the magnitudes of vectors among them, such as ``B.velocity`` and ``M.reaction``."""
    found = dict(known)
    for series in known.values():
        if "axis" in series.place and VARIABLES[series.variable].magnitude:
            place = {dim: label for dim, label in series.place.items() if dim != "axis"}
            name = _name(series.variable, place)
            found.setdefault(name, Series(name, series.variable, place, size=True))
    return found


def find_series(known: Mapping[str, Series], name: str) -> Series:
    """The series of that name.

    Raises
    ------
    ValueError
        If there is none; the message says what is near.
    """
    if name in known:
        return known[name]
    element, dot, quantity = name.rpartition(".")
    named = {series.name: series for series in known.values()}  # whatever spellings it has
    own = [other.rpartition(".")[2] for other in named if other.rpartition(".")[0] == element]
    if dot and own:
        words = " ".join(SYNONYMS.get(word, word) for word in quantity.replace("_", " ").split())
        near = f"; did you mean {words!r}?" if words in own else suggestion(words, own)
        raise ValueError(f"{element} has no {quantity!r}{near or f'; expected {listed(own)}'}")
    elements = list(dict.fromkeys(other.rpartition(".")[0] for other in known if "." in other))
    if dot:
        near = suggestion(element, elements) or f"; expected one of: {listed(sorted(elements))}"
        raise ValueError(f"unknown element {element!r}{near}")
    of = [other for other, series in named.items() if series.variable == name]
    near = f"; expected one of its series: {listed(of)}" if of else suggestion(name, known)
    near = near or f"; expected a name such as {next(iter(known))}"
    raise ValueError(f"unknown output {name!r}{near}")


def _series(
    dims: Mapping[str, Sequence[str]], labelled: Callable[[str], Sequence[str]]
) -> dict[str, Series]:
    found: dict[str, Series] = {}
    for variable, along in dims.items():
        places: list[dict[str, str]] = [{}]
        for dim in along:
            places = [{**place, dim: label} for place in places for label in labelled(dim)]
        for place in places:
            name = _name(variable, place)
            found[name] = Series(name, variable, place)
    return {**found, TIME: Series(TIME, TIME, {})}


def _name(variable: str, place: Mapping[str, str]) -> str:
    """Elements, then what is left of the variable's name without their kind."""
    elements = [label for dim, label in place.items() if dim != "axis"]
    words = variable
    for dim in place:
        words = dim if words.endswith(f"_{dim}") else words.removeprefix(f"{dim}_")
    words = " ".join(part for part in (place.get("axis", ""), words.replace("_", " ")) if part)
    return ".".join([*elements, words]) if elements else variable
