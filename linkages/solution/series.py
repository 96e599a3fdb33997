"""Series of outputs by name, as labelled arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import Table
from linkages.components.contributed.state_laws import leaves
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, coordinate_of, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.reading.wording import TOO_LARGE, listed, nearest, suggestion
from linkages.solution.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

REACTION = "joint_reaction"
PIN = "pin_reaction"
GUIDE = "guide_reaction"
MOMENT = "guide_moment"
AT_JOINTS = (REACTION, PIN)
REACTIONS = (*AT_JOINTS, GUIDE, MOMENT)
"""Outputs that follow from the forces on all bodies at one time."""

STATE = "clearance_state"
LOSS = "impact_loss"
TOUCHES = "touches"
DISSIPATION = ("clearance_normal_dissipation", "clearance_friction_dissipation")
WORN = ("clearance_sliding_work", "clearance_sliding_distance", "wear_volume")
INTEGRATED = (*DISSIPATION, *WORN)
OF_CONTACTS = (STATE, TOUCHES, LOSS, *INTEGRATED)
"""Outputs of contacts: of changes of mode, and those integrated along with the motion."""


def requested(system: System, outputs: Iterable[str] | None) -> list[str]:
    """The outputs to compute: what was asked for, or the default set that the mechanism has."""
    if outputs is None:
        return [name for name in available(system) if VARIABLES[name].default]
    if outputs == "all":
        return available(system)
    if not isinstance(outputs, Iterable):
        raise TypeError(f"outputs must be names, or 'all', found {outputs!r}")
    names = outputs.split(",") if isinstance(outputs, str) else [*outputs]
    own = available(system)
    for name in names:
        expected = f"; expected: {', '.join(own)}"
        if name not in VARIABLES:
            raise ValueError(f"unknown output {name!r}{suggestion(name, own) or expected}")
        if name not in own:
            raise ValueError(f"this mechanism has no {name}{expected}")
    if REACTION in names and PIN in own:  # of several bodies at a pin it shows the first
        names.insert(names.index(REACTION) + 1, PIN)
    return list(dict.fromkeys(names))


def available(system: System) -> list[str]:
    """All outputs that a mechanism has."""
    return [name for name in VARIABLES if _has(system, name)]


def _has(system: System, name: str) -> bool:
    variable = VARIABLES[name]
    if variable.compared and not system.mechanism.loose:
        return False
    if variable.opening and not system.model.contacts:
        return False
    if variable.worn and not system.model.mechanism.rubbing:
        return False
    laws = [drive.law for drive in system.mechanism.prescribed.values()]
    if variable.jerking and any(isinstance(leaf, Table) for law in laws for leaf in leaves(law)):
        return False
    return all(labels(system.model, dim) for dim in variable.dims)


Floats = NDArray[np.float64]


TIME = "time"

SYNONYMS = {
    "displacement": "position",
    "rotation": "angle",
    "torque": "effort",
    "force": "effort",
    "velocities": "velocity",
    "omega": "speed",
    "alpha": "acceleration",
}
"""Words that people look for → those of names."""


@dataclass(frozen=True)
class Series:
    """One element of an output variable."""

    name: str  # ``ELEMENT.QUANTITY``, or the variable where it has no elements
    variable: str  # entry of the outputs, or ``time``
    place: Mapping[str, str]  # dimension → label, in the order of the dimensions
    size: bool = False  # whether it is the magnitude of a vector; of those that figures show

    @property
    def angle(self) -> bool:
        """Whether it is an angle in which whole turns count."""
        return self.variable != TIME and VARIABLES[self.variable].angle

    def of(self, data: xr.Dataset) -> xr.DataArray:
        """The series in a solution's data."""
        array = data[self.variable]
        result = array.sel(dict(self.place)) if self.place else array
        return result.reduce(np.hypot.reduce, "axis") if self.size else result

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
    result = dict(known)
    for series in known.values():
        if "axis" in series.place and VARIABLES[series.variable].magnitude:
            place = {dim: label for dim, label in series.place.items() if dim != "axis"}
            name = element_name(series.variable, place)
            result.setdefault(name, Series(name, series.variable, place, size=True))
    return result


def example_series(system: System, *, rate: bool = False) -> str:
    """An example of a series: of the first free coordinate of a mechanism, or of a driven one."""
    topology, bodies = system.topology, system.mechanism.bodies
    name = next(iter([*topology.free, *topology.driven, *bodies]))
    variable = coordinate_of(bodies[name].kind)
    variable = VARIABLES[variable].rate if rate else variable
    known = system_series(system).values()
    return next(s.name for s in known if s.variable == variable and name in s.place.values())


def find_series(
    known: Mapping[str, Series], name: str, spelled: Callable[[str], str] = str
) -> Series:
    """The series of that name, or with underscores for spaces; ValueError suggests a near one.

    Where only one is meant, the name may lack its quantity, ``loads[0].y``, or parts of its
    element, ``arm.mechanical_advantage``.
    """
    if name in known:
        return known[name]
    own = (one for one in known.values() if one.variable == name.replace(" ", "_"))
    of = [*{one.name: one for one in own}.values()]  # whatever spellings it has
    if len(of) == 1:
        return of[0]
    plain = _plain(name)
    for other, series in known.items():
        if _plain(other) == plain:
            return series
    meant = _meant(known, plain)
    if len(meant) == 1:
        return known[meant[0]]
    raise ValueError(_unknown(known, name, of, spelled))


def _meant(known: Mapping[str, Series], plain: str) -> list[str]:
    """Names that are longer: of an element without its quantity, or of a part of an element."""
    element, _, quantity = plain.rpartition(".")
    of = [other for other in known if other.rpartition(".")[0] == plain and "." in plain]
    if of or not element:
        return of
    return [
        other
        for other in known
        if other.rpartition(".")[2] == quantity and element in other.rpartition(".")[0].split(".")
    ]


def _plain(name: str) -> str:
    element, dot, quantity = name.rpartition(".")
    return f"{element}{dot}{quantity.replace('_', ' ')}"


def _unknown(
    known: Mapping[str, Series], name: str, of: Sequence[Series], spelled: Callable[[str], str]
) -> str:
    """What to say of a name that no series has."""
    elements = list(dict.fromkeys(other.rpartition(".")[0] for other in known if "." in other))
    if name in elements or of:
        result = [s.name for s in of] or [n for n in known if n.rpartition(".")[0] == name]
        what = "has several elements" if of else "is an element"
        return f"{name!r} {what}; expected one of its series: {listed(map(spelled, result))}"
    element, dot, quantity = name.rpartition(".")
    if not dot:
        near = nearest(name, [*known, *(series.variable for series in known.values())])
        example = spelled(next((other for other in known if "." in other), next(iter(known))))
        return f"unknown output {name!r}" + (
            f"; did you mean {spelled(near)!r}?" if near else f"; expected a name such as {example}"
        )
    if element in elements:
        return f"{element} has no {quantity!r}{_nearby(known, element, quantity, spelled)}"
    near = nearest(_plain(name), known)
    if near is not None and _plain(near).replace(".", " ") == _plain(name).replace(".", " "):
        return f"unknown name {name!r}; did you mean {spelled(near)!r}?"
    other = nearest(element, elements)
    if other is None:
        return f"unknown element {element!r}; expected one of: {listed(sorted(elements))}"
    whole = _plain(f"{other}.{quantity}")
    meant = spelled(whole) if whole in known else other
    return f"unknown element {element!r}; did you mean {meant!r}?"


def _nearby(
    known: Mapping[str, Series], element: str, quantity: str, spelled: Callable[[str], str]
) -> str:
    """What to say beside an element that has no such quantity."""
    own = [other.rpartition(".")[2] for other in known if other.rpartition(".")[0] == element]
    words = _plain(f".{quantity}")[1:]
    meant = " ".join(SYNONYMS.get(word, word) for word in words.split())
    alike = {
        other: series
        for other, series in known.items()
        if f" {other.rpartition('.')[2]}".endswith(f" {words}") and "." in other
    }
    mine = [n for n in alike if element in n.rpartition(".")[0].split(".")]
    if meant in own:
        near = [f"{element}.{meant}"]
    elif mine:
        near = mine
    elif alike:
        first, series = next(iter(alike.items()))
        kind = next(iter(series.place)).replace("_", " ")
        such = f"; this is a quantity of a {kind}, such as {spelled(first)!r}"
        return f"{such}; expected {listed(own)}"
    else:
        near = [f"{element}.{word}" for word in [nearest(words, own)] if word]
    if near:
        return f"; did you mean {listed(repr(spelled(each)) for each in near)}?"
    return f"; expected {listed(own)}"


def _series(
    dims: Mapping[str, Sequence[str]], labelled: Callable[[str], Sequence[str]]
) -> dict[str, Series]:
    result: dict[str, Series] = {}
    for variable, along in dims.items():
        places: list[dict[str, str]] = [{}]
        for dim in along:
            places = [{**place, dim: label} for place in places for label in labelled(dim)]
        for place in places:
            name = element_name(variable, place)
            result[name] = Series(name, variable, place)
    return {**result, TIME: Series(TIME, TIME, {})}


def element_name(variable: str, place: Mapping[str, str]) -> str:
    """Elements, then what is left of the variable's name without their kind."""
    elements = [label for dim, label in place.items() if dim != "axis"]
    words = variable
    for dim in place:
        words = dim if words.endswith(f"_{dim}") else words.removeprefix(f"{dim}_")
    words = " ".join(part for part in (place.get("axis", ""), words.replace("_", " ")) if part)
    return ".".join([*elements, words]) if elements else variable


@dataclass(frozen=True)
class LabelledArrays:
    """Name → dimensions, array and attributes of a dataset, without importing xarray and pandas."""

    variables: Mapping[str, tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]]
    coordinates: Mapping[str, tuple[tuple[str, ...], NDArray[Any], dict[str, Any]]]
    attrs: dict[str, Any]  # of the whole

    @classmethod
    def of(cls, data: xr.Dataset) -> LabelledArrays:
        """Those of a dataset."""
        variables, coordinates = (
            {
                str(name): (tuple(map(str, one.dims)), one.to_numpy(), one.attrs)
                for name, one in part.items()
            }
            for part in (data.data_vars, data.coords)
        )
        return cls(variables, coordinates, data.attrs)

    @property
    def values(self) -> dict[str, NDArray[Any]]:
        """Variable → array."""
        return {name: array for name, (_, array, _) in self.variables.items()}

    def dataset(self) -> xr.Dataset:
        """The dataset."""
        import xarray as xr

        return xr.Dataset(self.variables, self.coordinates, self.attrs)


def labelled_arrays(
    system: System, motion: Motion, values: Mapping[str, NDArray[np.float64]]
) -> LabelledArrays:
    """Arrays with coordinates, units and names."""
    variables = {}
    dims: dict[str, None] = {}
    for name, array in values.items():
        entry = VARIABLES[name]
        dims |= dict.fromkeys(entry.dims)
        units, long_name = entry.described(system.model)
        attrs: dict[str, Any] = {"units": units, "long_name": long_name}
        if entry.flags:
            attrs["flag_values"] = np.arange(len(entry.flags), dtype=np.int8)
            attrs["flag_meanings"] = " ".join(entry.flags)
        variables[name] = ((TIME, *entry.dims), array, attrs)
    coordinates: dict[str, Any] = {
        TIME: ((TIME,), motion.time, {"units": "s", "long_name": "time"})
    }
    for dim in dims:
        coordinates[dim] = ((dim,), np.array(labels(system.model, dim), dtype=object), {})
    attrs = {"name": system.mechanism.name, "source": system.mechanism.file_name}
    if system.topology.free:
        attrs["free"] = " ".join(system.topology.free)
    return LabelledArrays(variables, coordinates, attrs)


def labelled(system: System, motion: Motion, values: dict[str, NDArray[np.float64]]) -> xr.Dataset:
    """Put arrays into a dataset with coordinates, units and names."""
    return labelled_arrays(system, motion, values).dataset()


Values = dict[str, NDArray[np.float64]]


def finite_part(
    system: System, motion: Motion, values: Mapping[str, NDArray[np.float64]]
) -> tuple[Motion, Values]:
    """A motion up to the first sample whose values are not finite, and why it ends there.

    An advantage may be infinite, where a drive does not move a body.
    """
    first: tuple[int, str] | None = None
    for name, array in values.items():
        sound = ~np.isnan(array) if VARIABLES[name].reciprocal else np.isfinite(array)
        samples, *elements = np.nonzero(~sound)  # in the order of the samples
        if samples.size and (first is None or samples[0] < first[0]):
            first = (
                int(samples[0]),
                _element_name(system, name, [int(index[0]) for index in elements]),
            )
    if first is None:
        return motion, dict(values)
    sample, what = first
    time = float(motion.time[sample])
    failure = f"at t = {time:.9g} s: the {what} is not a finite number. {TOO_LARGE}"
    return (
        replace(motion.part(last=sample), failure=failure, stop_time=time),
        {name: array[:sample] for name, array in values.items()},
    )


def _element_name(system: System, name: str, index: Sequence[int]) -> str:
    """An output and the element that an index into its values belongs to."""
    variable = VARIABLES[name]
    _, long_name = variable.described(system.model)
    places = zip(variable.dims, index, strict=True)
    words = [labels(system.model, dim)[i] for dim, i in places if dim != "axis"]
    return f"{long_name} of {' and '.join(words)}" if words else long_name
