"""Output variables, as lists of nodes of the model that serve NumPy and compiled code alike."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from linkages.discovery import modules_of, plugged
from linkages.kernel.model import Model
from linkages.kernel.scalars import Scalar
from linkages.kernel.scalars import components as components
from linkages.topology.assur_groups import Block
from linkages.topology.decomposition import shared_pins

Floats = NDArray[np.float64]

GROUP = "linkages.outputs"
"""Entry points that name outputs, and the folder of those of this package."""

AXES = ("x", "y")

SIDES = ("journal", "bearing")
"""Sides of a clearance that wear; in a guide they are those of the block and of the guide."""


@dataclass(frozen=True)
class Variable:
    """An output.

    Parameters
    ----------
    dims
        Dimensions beside time.
    units, long_name
        For labels; of drives that all turn.
    nodes
        The model → one node per element, the last dimension running fastest.
        None for an output that needs more than the motion at one time.
    pushed
        Units and long name where all drives push a slider, if they differ.
    default
        Whether it is computed unless others are asked for.
    coordinate
        Whether it is the coordinate of the bodies of its dimension, angle or displacement.
    angle
        Whether whole turns are counted in it.
    rate
        The output that is its derivative with respect to time, if there is one.
    magnitude
        Whether it is a vector whose magnitude has a largest value worth a row.
    smooth
        Whether polynomials through samples say what is between them: not for what may jump, and not
        for noise.
    noise
        Whether it is round-off, so that nothing is to be looked for between samples.
    unbounded
        Whether it may grow without bound towards a change point, or have a kink or a jump there, so
        that it cannot be interpolated.
    reciprocal
        Whether it may be infinite, and its reciprocal is smooth.
    reduced
        What becomes of the values of its nodes, shape (nodes, times) before and (elements, times)
        after; taken as they are if not given.
    compared
        The output that it compares with that of the same mechanism without clearances.
    flags
        What the numbers 0, 1, … of a variable mean that has no other values.
    opening
        Whether it is there for mechanisms with a clearance that opens only.
    worn
        Whether it is there for mechanisms with a clearance that wears only.
    unit_of
        Units of its elements where they differ.
    jerking
        Whether it takes third derivatives of the laws of drives, which tables do not have.
    """

    dims: tuple[str, ...]
    units: str
    long_name: str
    nodes: Callable[[Model], list[Scalar]] | None
    pushed: tuple[str, str] | None = None
    default: bool = False
    coordinate: bool = False
    angle: bool = False
    rate: str = ""
    magnitude: bool = False
    smooth: bool = True
    noise: bool = False
    unbounded: bool = False
    reciprocal: bool = False
    reduced: Callable[[Floats], Floats] | None = None
    compared: str = ""
    flags: tuple[str, ...] = ()
    opening: bool = False
    worn: bool = False
    unit_of: Callable[[Model], list[str]] | None = None
    jerking: bool = False

    @property
    def whole(self) -> bool:
        """Whether it needs more than the motion at one time."""
        return self.nodes is None

    def evaluated(self, model: Model) -> list[Scalar]:
        """Its nodes in a model, one per element.

        Raises
        ------
        ValueError
            If it needs more than the motion at one time.
        """
        if self.nodes is None:
            raise ValueError(f"{self.long_name} follows from a whole motion")
        if self not in model.outputs:  # asked for again at every point of a sweep
            model.outputs[self] = self.nodes(model)
        return model.outputs[self]

    def described(self, model: Model) -> tuple[str, str]:
        """Units and long name that the variable has for a mechanism."""
        if self.unit_of is not None:
            return " or ".join(dict.fromkeys(self.unit_of(model))), self.long_name
        if "clearance" in self.dims and not model.mechanism.loose:
            return self.units, self.long_name.replace("clearance", "contact")
        turning = {model.mechanism.twisting(name) for name in labels(model, "drive")}
        if self.pushed is None or False not in turning:
            return self.units, self.long_name
        units, name = self.pushed
        if True not in turning:
            return units, name
        return f"{self.units} or {units}", f"{self.long_name} or {name}"


def labels(model: Model, dim: str) -> tuple[str, ...]:
    """Coordinate labels of a dimension."""
    topology, mechanism = model.topology, model.mechanism
    match dim:
        case "axis":
            return AXES
        case "side":
            return SIDES
        case "frame":
            return ("ground",)
        case "joint":
            return topology.joints
        case "pin":
            # a massless link transmits the force on the bar whose clearance it is
            bars = {one.name: one.bar for one in mechanism.clearances}
            return tuple(
                f"{joint}.{bars.get(body, body)}" for joint, body in shared_pins(mechanism)
            )
        case "drive":
            return tuple(mechanism.actuations) or topology.driven
        case "actuator":
            return tuple(mechanism.actuations)
        case "rotary_actuator" | "linear_actuator":
            twists = dim == "rotary_actuator"
            return tuple(n for n in mechanism.actuations if mechanism.twisting(n) == twists)
        case "actuation":
            return ("actuators",) if mechanism.actuations else ()
        case "dyad":
            return tuple(_dyad_label(model, block) for block in dyads(model))
        case "internal":
            return topology.internal
        case "cam":
            return tuple(mechanism.cams)
        case "force" | "torque" | "spring" | "torsional_spring":
            return tuple(load.label for load in model.loads if load.dimension == dim)
        case "stop" | "torsional_stop":
            ends = mechanism.ends
            return tuple(end.name for end in ends if end.twists == (dim == "torsional_stop"))
        case "contact":
            return tuple(contact.name for contact in model.rigid)
        case "touch":
            return (*(c.name for c in mechanism.contacts), *(end.name for end in mechanism.ends))
        case "clearance":
            return mechanism.clearance_names
        case "bar" | "slider" | "offset" | "tilt" | "guided":
            kinds = (dim, "plate") if dim == "bar" else (dim,)
            return tuple(n for n, body in mechanism.bodies.items() if body.kind in kinds)
    raise KeyError(dim)


def links(model: Model) -> tuple[str, ...]:
    """Clearances whose journal and bearing stay in contact: massless links."""
    return tuple(name for name in labels(model, "clearance") if name in model.mechanism.bodies)


def dyads(model: Model) -> list[Block]:
    """Blocks with a link that pushes another body."""
    return [b for b in model.topology.solved_blocks if b.kind in ("RRR", "RRP", "RPR")]


def _dyad_label(model: Model, block: Block) -> str:
    """Its slider, or the joint at which its two links meet."""
    sliders = [name for name in block.unknowns if not model.mechanism.bodies[name].rotates]
    return sliders[0] if sliders else block.loops[0].apex


_REGISTERED: dict[str, Variable] = {}


class _Variables(Mapping[str, Variable]):
    """All outputs; those that stand elsewhere are looked for when one is first asked for."""

    def __getitem__(self, name: str) -> Variable:
        return _all()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_all())

    def __len__(self) -> int:
        return len(_all())


VARIABLES: Mapping[str, Variable] = _Variables()
"""Name → output: those of files in `linkages.outputs`, and those of other packages."""


@cache
def _all() -> dict[str, Variable]:
    result = [entry for module in modules_of(GROUP) for entry in module.OUTPUTS.items()]
    return {**dict(result), **dict(plugged(GROUP)), **_REGISTERED}


def register(name: str, variable: Variable) -> None:
    """Add an output to those that can be asked for; one that was registered before is replaced.

    Raises
    ------
    ValueError
        If the name is none, or taken by an output of a package.
    """
    if not name.isidentifier() or (name in _all() and name not in _REGISTERED):
        raise ValueError(f"expected a name for the output that is not taken, found {name!r}")
    _REGISTERED[name] = variable
    _all.cache_clear()


def unregister(name: str) -> None:
    """Take away an output that was registered; KeyError if none of that name was."""
    del _REGISTERED[name]
    _all.cache_clear()


def coordinate_of(kind: str) -> str:
    """The output that is the coordinate of a kind of body: angle or displacement."""
    dim = "bar" if kind == "plate" else kind
    return next(n for n, item in VARIABLES.items() if item.coordinate and item.dims == (dim,))
