"""Output variables: one entry each, with all that is peculiar to it.

A variable that follows from time, state and accelerations is a list of nodes of the model, so what
is not asked for is not computed, and the same nodes serve NumPy (samples) and compiled code.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from linkages.discovery import modules_of, plugged
from linkages.kernel.closure.dyads import LinkAndSlider, LinkInGuide, TwoLinks
from linkages.kernel.graph.scalars import Scalar
from linkages.kernel.graph.vectors import Vector
from linkages.kernel.model import Model
from linkages.topology.blocks import Block, Step
from linkages.topology.jacobian import ground_loop

Floats = NDArray[np.float64]

GROUP = "linkages.outputs"
"""Entry points that name outputs, and the folder of those of this package."""

AXES = ("x", "y")
LOADS = ("force", "torque", "spring", "torsional_spring")


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
        Whether polynomials through samples say what is between them: not for what may jump, and for
        residuals, which are noise.
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
    unit_of
        Units of its elements where they differ.
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
    unbounded: bool = False
    reciprocal: bool = False
    reduced: Callable[[Floats], Floats] | None = None
    compared: str = ""
    flags: tuple[str, ...] = ()
    opening: bool = False
    unit_of: Callable[[Model], list[str]] | None = None

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
        return self.nodes(model)

    def described(self, model: Model) -> tuple[str, str]:
        """Units and long name that the variable has for a mechanism."""
        if self.unit_of is not None:
            return " or ".join(dict.fromkeys(self.unit_of(model))), self.long_name
        turning = {model.mechanism.bodies[name].rotates for name in model.topology.driven}
        if self.pushed is None or False not in turning:
            return self.units, self.long_name
        units, name = self.pushed
        if True not in turning:
            return units, name
        return f"{self.units} or {units}", f"{self.long_name} or {name}"


def labels(model: Model, dim: str) -> tuple[str, ...]:
    """Coordinate labels of a dimension."""
    if dim == "axis":
        return AXES
    if dim == "joint":
        return model.topology.joints
    if dim == "drive":
        return model.topology.driven
    if dim == "dyad":
        return tuple(_dyad_label(model, block) for block in _dyads(model))
    if dim == "internal":
        return model.topology.internal
    if dim == "cam":
        return tuple(model.mechanism.cams)
    if dim in LOADS:
        return tuple(load.label for load in model.loads if load.dimension == dim)
    if dim == "clearance":
        return tuple(term.name for term in model.mechanism.displacements)
    kinds = {"bar": ("bar", "plate"), "slider": ("slider",), "offset": ("offset",)}[dim]
    return tuple(n for n, body in model.mechanism.bodies.items() if body.kind in kinds)


def links(model: Model) -> tuple[str, ...]:
    """Clearances whose pin and hole stay in contact: massless links."""
    return tuple(name for name in labels(model, "clearance") if name in model.mechanism.bodies)


def _components(vectors: Sequence[Vector]) -> list[Scalar]:
    return [component for vector in vectors for component in (vector.x, vector.y)]


def _of_bodies(dim: str, field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [getattr(model, field).moving(name) for name in labels(model, dim)]


def _of_turning(dim: str, field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [getattr(model, field).turning(name) for name in labels(model, dim)]


def _of_joints(field: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: _components(
        [getattr(model, field).joints[joint] for joint in labels(model, "joint")]
    )


def _angles(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [model.positions.angle(name) for name in labels(model, dim)]


def _efforts(model: Model) -> list[Scalar]:
    return [
        model.required_force(model.accelerations, model.partial(name))
        for name in model.topology.driven
    ]


def _clearance_forces(model: Model) -> list[Scalar]:
    """Tension: the force that would be needed to lengthen the link, reversed.

    Where pin and hole may part, what presses them together.
    """
    contacts = {nodes.contact.name: nodes for nodes in model.contacts}

    def force(name: str) -> Scalar:
        if name in contacts:
            return contacts[name].force
        return -model.required_force(model.accelerations, model.partial(name, stretch=name))

    return [force(name) for name in labels(model, "clearance")]


def _of_clearances(order: int) -> Callable[[Model], list[Scalar]]:
    """Directions of clearances (`order` 0), or a derivative of them."""
    of_link: Callable[[Model, str], Scalar] = (
        lambda model, name: model.positions.angle(name),
        lambda model, name: model.velocities.bodies[name],
        lambda model, name: model.accelerations.bodies[name],
    )[order]

    def nodes(model: Model) -> list[Scalar]:
        turned = {nodes.contact.name: nodes.turned(order) for nodes in model.contacts}
        names = labels(model, "clearance")
        return [turned[name] if name in turned else of_link(model, name) for name in names]

    return nodes


def _dyads(model: Model) -> list[Block]:
    """Blocks with a link that pushes another body."""
    return [b for b in model.topology.solved_blocks if b.kind in ("RRR", "RRP", "RPR")]


def _dyad_label(model: Model, block: Block) -> str:
    """Its slider, or the joint at which its two links meet."""
    sliders = [name for name in block.unknowns if not model.mechanism.bodies[name].rotates]
    return sliders[0] if sliders else block.loops[0].apex


def _transmission_angles(model: Model) -> list[Scalar]:
    """Between the directions of force and of motion's normal: 90° is best, 0 is singular."""
    graph, found = model.graph, []
    for block in _dyads(model):
        dyad = model.positions.dyads[block.index]
        if isinstance(dyad, TwoLinks):
            crossed, along = dyad.first.cross(dyad.second), -dyad.first.dot(dyad.second)
        else:
            assert isinstance(dyad, LinkAndSlider | LinkInGuide)
            crossed, across = dyad.forward, dyad.across
            along = graph.select(across, across, -across)
        found.append(graph.apply("atan2", graph.select(crossed, crossed, -crossed), along))
    return found


def _advantages(dim: str) -> Callable[[Model], list[Scalar]]:
    """Effort that a body delivers per effort of a drive: the reciprocal of their speeds' ratio.

    Power in is power out, M_in ω_in = M_out ω_out, with M_out on what resists the body.
    """

    def nodes(model: Model) -> list[Scalar]:
        partials = [model.partial(name) for name in model.topology.driven]
        return [1.0 / partial.moving(name) for partial in partials for name in labels(model, dim)]

    return nodes


def _of_loads(dim: str) -> Callable[[Model], list[Scalar]]:
    return lambda model: [load.acting for load in model.loads if load.dimension == dim]


def _kinetic_energy(model: Model) -> list[Scalar]:
    return [0.5 * model.inertia.product(model.velocities, model.velocities)]


def _potential_energy(model: Model) -> list[Scalar]:
    return [model.potential_energy]


def _drive_power(model: Model) -> list[Scalar]:
    return [model.driven_power]


def _load_power(model: Model) -> list[Scalar]:
    return [model.load_power]


def _closure(model: Model) -> list[Scalar]:
    """Both components of Φ for every loop, from the angles and displacements themselves."""
    units: dict[str | None, Vector] = {}

    def along(step: Step) -> Vector:
        master, own = model.positions.frames.rotation(step.body)
        vector = own.times(model.positions.in_frame(step.body, step.start, step.end))
        if master is None:
            return vector
        if master not in units:
            angle = model.positions.angle(master)
            units[master] = Vector(model.graph.cos(angle), model.graph.sin(angle))
        return units[master].times(vector)

    residuals = []
    for loop in model.topology.closing:
        total = Vector(model.graph.zero, model.graph.zero)
        for sign, way in zip((1.0, -1.0), ground_loop(model.topology, loop), strict=True):
            place = way[0].start if way else loop.apex
            if place in model.mechanism.anchors:
                total = total + model.positions.joints[place] * sign
            for step in way:
                total = total + along(step) * sign
        residuals.append(total)
    return _components(residuals)


def _largest(rows: Floats) -> Floats:
    return np.asarray(np.abs(rows).max(axis=0, initial=0.0)[None])


_COMPARED = "against the ideal mechanism"

_OWN: dict[str, Variable] = {
    "bar_angle": Variable(
        ("bar",), "rad", "angle", _angles("bar"),
        default=True, coordinate=True, angle=True, rate="bar_speed",
    ),
    "bar_speed": Variable(
        ("bar",), "rad/s", "angular speed", _of_turning("bar", "velocities"),
        default=True, rate="bar_acceleration",
    ),
    "bar_acceleration": Variable(
        ("bar",), "rad/s^2", "angular acceleration", _of_turning("bar", "accelerations"),
        default=True,
    ),
    "slider_position": Variable(
        ("slider",),
        "m",
        "displacement",
        lambda m: [m.positions.displacement(name) for name in labels(m, "slider")],
        default=True, coordinate=True, rate="slider_velocity",
    ),
    "slider_velocity": Variable(
        ("slider",), "m/s", "velocity", _of_bodies("slider", "velocities"),
        default=True, rate="slider_acceleration",
    ),
    "slider_acceleration": Variable(
        ("slider",), "m/s^2", "acceleration", _of_bodies("slider", "accelerations"), default=True
    ),
    "slider_position_error": Variable(
        ("slider",), "m", f"displacement error {_COMPARED}", None,
        default=True, compared="slider_position",
    ),
    "slider_velocity_error": Variable(
        ("slider",), "m/s", f"velocity error {_COMPARED}", None,
        default=True, compared="slider_velocity",
    ),
    "slider_acceleration_error": Variable(
        ("slider",), "m/s^2", f"acceleration error {_COMPARED}", None,
        default=True, compared="slider_acceleration",
    ),
    "clearance_angle": Variable(
        ("clearance",), "rad", "clearance angle", _of_clearances(0),
        default=True, coordinate=True, angle=True, rate="clearance_speed",
    ),
    "clearance_speed": Variable(
        ("clearance",), "rad/s", "clearance speed", _of_clearances(1),
        default=True, rate="clearance_acceleration",
    ),
    "clearance_acceleration": Variable(
        ("clearance",),
        "rad/s^2",
        "clearance acceleration",
        _of_clearances(2),
        default=True,
    ),
    "clearance_force": Variable(
        ("clearance",), "N", "force along the clearance link", _clearance_forces,
        default=True, unbounded=True,
    ),
    "joint_position": Variable(
        ("joint", "axis"), "m", "joint position", _of_joints("positions"),
        default=True, rate="joint_velocity",
    ),
    "joint_velocity": Variable(
        ("joint", "axis"), "m/s", "joint velocity", _of_joints("velocities"),
        default=True, rate="joint_acceleration", magnitude=True,
    ),
    "joint_acceleration": Variable(
        ("joint", "axis"), "m/s^2", "joint acceleration", _of_joints("accelerations"),
        default=True, magnitude=True,
    ),
    "transmission_angle": Variable(
        ("dyad",), "rad", "transmission angle", _transmission_angles,
        unbounded=True, reduced=np.abs,  # atan2(-0.0, -1.0) is -π
    ),
    "mechanical_advantage": Variable(
        ("drive", "bar"),
        "1",
        "torque that a bar delivers per torque of a drive",
        _advantages("bar"),
        ("m", "torque that a bar delivers per force of a drive"),
        reciprocal=True,
    ),
    "slider_mechanical_advantage": Variable(
        ("drive", "slider"),
        "1/m",
        "force that a slider delivers per torque of a drive",
        _advantages("slider"),
        ("1", "force that a slider delivers per force of a drive"),
        reciprocal=True,
    ),
    "drive_effort": Variable(
        ("drive",), "N m", "driving torque", _efforts, ("N", "driving force"), default=True
    ),
    "load_force": Variable(
        ("force",), "N", "force of a load", _of_loads("force"),
        default=True, smooth=False, unbounded=True,
    ),
    "load_torque": Variable(
        ("torque",), "N m", "torque of a load", _of_loads("torque"),
        default=True, smooth=False, unbounded=True,
    ),
    "spring_force": Variable(("spring",), "N", "force of a spring or damper", _of_loads("spring")),
    "torsional_spring_torque": Variable(
        ("torsional_spring",),
        "N m",
        "torque of a torsional spring or damper",
        _of_loads("torsional_spring"),
    ),
    "kinetic_energy": Variable((), "J", "kinetic energy", _kinetic_energy),
    "potential_energy": Variable((), "J", "potential energy", _potential_energy),
    "drive_power": Variable((), "W", "power of all drives", _drive_power),
    "load_power": Variable((), "W", "power of all loads", _load_power),
    "closure_residual": Variable(
        (), "m", "largest residual of the closure equations", _closure,
        default=True, smooth=False, reduced=_largest,
    ),
    "joint_reaction": Variable(
        ("joint", "axis"), "N", "joint reaction", None, magnitude=True
    ),
    "energy_residual": Variable(
        (), "J", "energy gained beyond the work of drives and loads", None, smooth=False
    ),
}  # fmt: skip

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
"""Name → output: those above, those of files in `linkages.outputs`, and those of other packages."""


@cache
def _all() -> dict[str, Variable]:
    found = [entry for module in modules_of(GROUP) for entry in module.OUTPUTS.items()]
    return {**_OWN, **dict(found), **dict(plugged(GROUP)), **_REGISTERED}


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
    return next(n for n, found in VARIABLES.items() if found.coordinate and found.dims == (dim,))
