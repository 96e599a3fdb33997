"""Mechanisms as models of MuJoCo (MJCF).

References
----------
MuJoCo: XML reference, https://mujoco.readthedocs.io/en/stable/XMLreference.html
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, assert_never
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.functions import (
    Function,
    Internal,
    Measured,
    Number,
    Operation,
    Table,
    Time,
)
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Load,
    Slide,
    Turn,
)
from linkages.components.contributed.normal_forces import FollowerOnCam, RoundAtWall
from linkages.components.contributed.terms import GUIDED
from linkages.exports.writers.body_tree import (
    WORLD,
    Branch,
    Gap,
    Pin,
    Rail,
    Tree,
    frames_of,
    slides_of,
    tree_of,
)
from linkages.kernel.system import System
from linkages.operations import value_of
from linkages.reading.paths import KeyPath
from linkages.reading.wording import listed

_PROBES = ((0.3, -0.7, 0.2), (-1.1, 0.4, 1.7), (2.3, 1.9, 5.1), (0.05, 0.01, 0.9))
_ROUND_OFF = 1e-12


class Line(NamedTuple):
    """A force c − k·x − d·v."""

    constant: float
    stiffness: float
    damping: float


def line_of(load: Load) -> Line | None:
    """The law of a load if it is a line in its own measure and rate, without time."""
    try:
        constant = _value(load.force, 0.0, 0.0, 0.0)
        slope = _value(load.force, 1.0, 0.0, 0.0) - constant
        rate = _value(load.force, 0.0, 1.0, 0.0) - constant
        for x, v, t in _PROBES:
            result, line = _value(load.force, x, v, t), constant + slope * x + rate * v
            size = abs(constant) + abs(slope * x) + abs(rate * v)
            if abs(result - line) > _ROUND_OFF * size:
                return None
    except (ArithmeticError, ValueError):  # no value there: no line
        return None
    return Line(constant, -slope, -rate)


def _value(law: Function, x: float, v: float, t: float) -> float:
    match law:
        case Number(parameter):
            return float(parameter.value)
        case Time():
            return t
        case Measured(order, None) if order < 2:
            return v if order else x
        case Measured() | Internal() | Table():
            raise ValueError("depends on more than x, v and t")
        case Operation(name, arguments):
            return value_of(name, *(_value(argument, x, v, t) for argument in arguments))
    assert_never(law)


Floats = NDArray[np.float64]

_TIMES = 11


def _refused(system: System) -> Iterator[tuple[KeyPath, str]]:
    """All that MuJoCo cannot express."""
    mechanism = system.mechanism
    for contact in mechanism.contacts:
        what = "clearances that open"
        if isinstance(contact.geometry, RoundAtWall | FollowerOnCam):
            walls = isinstance(contact.geometry, RoundAtWall)
            what = "contacts with walls" if walls else "cams"
        yield contact.path, f"{what} are not exported to MuJoCo"
    for end in mechanism.ends:
        yield end.path, "ends at which bodies bounce are not exported to MuJoCo"
    for path in dict.fromkeys(b.path for b in mechanism.bodies.values() if b.kind == GUIDED):
        yield path, "drives of points are not exported to MuJoCo; expected drives of bars"
    for actuation in mechanism.actuations.values():
        yield actuation.path, "actuators in the place of drives are not exported to MuJoCo"
    for play in mechanism.plays:
        yield play.path, "clearances of guides are not exported to MuJoCo"
    for relation in mechanism.relations:
        if relation.profile is not None:
            yield relation.path, "cams are not exported to MuJoCo"
    for name, prescribed in mechanism.prescribed.items():
        if polynomial(system, name) is None and harmonic(system, name) is None:
            what = "polynomials of time up to degree 4, and harmonic motions"
            yield prescribed.path, f"MuJoCo follows drives with {what} only"
    for state in mechanism.states:
        yield state.path, "states with equations of their own are not exported to MuJoCo"
    for load in mechanism.loads:
        if not load.absent and line_in(load) is None:
            yield load.path, "only springs, dampers and forces of constant numbers go to MuJoCo"


def line_in(load: Load) -> Line | None:
    """The law of a load as MuJoCo has it: a spring and damper, or a constant; None if it cannot."""
    result = line_of(load)
    if result is None or load.states or load.bearing is not None or min(result[1:]) < 0.0:
        return None
    moving = result.stiffness or result.damping
    fixed = isinstance(load.measure, BodyAxis)
    return None if fixed or (moving and isinstance(load.measure, Coordinate)) else result


class Harmonic(NamedTuple):
    """A motion radius·sin(frequency·t + phase) about a middle."""

    radius: float
    frequency: float
    phase: float


def polynomial(system: System, name: str) -> tuple[float, ...] | None:
    """Coefficients of t to t⁴ of a drive; None if it is no such polynomial."""
    times, values = _probed(system, name)
    rate, accelerations = values[1, 0], values[2]
    powers = np.vander(times, 3, increasing=True)
    result = np.linalg.lstsq(powers, accelerations, rcond=None)[0]
    apart = np.abs(powers @ result - accelerations).max()
    if apart > _ROUND_OFF * max(1.0, np.abs(accelerations).max()):
        return None
    result[np.abs(result) <= _ROUND_OFF * np.abs(accelerations).max()] = 0.0
    return float(rate), *(result / (2.0, 6.0, 12.0)).tolist()


def harmonic(system: System, name: str) -> Harmonic | None:
    """A drive as a harmonic motion; None if it is none: then x″ is no line in x that falls."""
    _, (values, rates, accelerations) = _probed(system, name)
    line = np.stack([values, np.ones_like(values)], axis=1)
    (slope, constant), *_ = np.linalg.lstsq(line, accelerations, rcond=None)
    apart = np.abs(line @ (slope, constant) - accelerations).max()
    if apart > _ROUND_OFF * np.abs(accelerations).max() or not slope < 0.0:
        return None
    frequency = np.sqrt(-slope)
    along, across = values[0] + constant / slope, rates[0] / frequency
    return Harmonic(*map(float, (np.hypot(along, across), frequency, np.arctan2(along, across))))


def _probed(system: System, name: str) -> tuple[Floats, Floats]:
    """Times, the first zero, and a drive's coordinate, rate and acceleration there."""
    law, end = system.model.positions.laws[name], abs(system.mechanism.simulation.end)
    # at times that no period has in common
    times = np.append(0.0, np.random.default_rng(0).uniform(0.0, max(end, 1.0), _TIMES))
    state = np.repeat(system.state[:, None], len(times), axis=1)
    return times, system.evaluate([law.value, law.rate, law.acceleration], times, state)


STEP = 1e-4
"""Of MuJoCo's integration in seconds; constraints need two of them to come back to zero."""

CLOCK = "clock"
"""The coordinate that counts seconds: drives follow it."""

INERT = 1e12
"""Mass of the clock in kg: drives do not slow it down."""

TREE, LOOPS, DRIVEN = 1e-12, 1e-6, 1e-3
"""Mass of a body that has none, as a part of the heaviest one's: MuJoCo needs one.

Constraints yield the more the lighter the bodies are that they hold: loops and drives open by about
4e-10 m s²/part times the load over the largest mass. In a tree without constraints nothing yields.
Where drives alone determine the motion, masses do not change it, only forces.
"""

LEAST = 1e-12
"""Inertia in kg·m² of a body that has none: MuJoCo needs one."""


def mjcf_text(system: System) -> str:
    """The text of a model."""
    root = _Writer(system).written()
    indent(root)
    return tostring(root, encoding="unicode") + "\n"


def massless(system: System) -> str:
    """What masses that MuJoCo needs change, in a sentence; empty where all bodies have one."""
    return _Writer(system).note


class _Writer:
    def __init__(self, system: System) -> None:
        self.system, self.mechanism = system, system.mechanism
        if refused := [*_refused(system)]:
            raise self.mechanism.error(refused)
        self.tree: Tree = tree_of(self.mechanism)
        self.frames, self.slides = frames_of(system), slides_of(system)
        self.places = system.places()
        self.nodes: dict[str, Element] = {}
        self.speeds: dict[str, float] = {}

    # --- the model ---

    def written(self) -> Element:
        """The whole model."""
        root = Element("mujoco", model=self.mechanism.name)
        if self.note:
            root.append(Comment(f" {self.note.replace('--', '__')} "))
        SubElement(root, "compiler", angle="radian", autolimits="true")
        gravity = [self.mechanism.gravity.x.value, self.mechanism.gravity.y.value, 0.0]
        SubElement(root, "option", timestep=repr(STEP), gravity=_row(gravity), integrator="RK4",
                   tolerance="1e-14", iterations="100")  # fmt: skip
        defaults = SubElement(root, "default")
        SubElement(defaults, "equality", solref=f"{2 * STEP!r} 1", solimp="0.9999 0.9999 0.001")
        SubElement(defaults, "geom", contype="0", conaffinity="0", rgba="0.3 0.4 0.6 1")
        world = SubElement(root, "worldbody")
        self.nodes[WORLD] = world
        if self.mechanism.prescribed:
            self._clock(world)
        for branch in self.tree.branches:
            self._body(branch)
        self._sites()
        equality = SubElement(root, "equality")
        tendon, actuator = SubElement(root, "tendon"), SubElement(root, "actuator")
        for pin in self.tree.loops:
            self._loop(equality, pin)
        for relation in self.mechanism.relations:
            parts = {relation.body: 1.0}
            for name, ratio in relation.parts:
                parts[name] = parts.get(name, 0.0) - ratio.value
            self._held(tendon, equality, f"relation.{relation.body}", parts)
        for name in self.mechanism.prescribed:
            self._drive(tendon, equality, name)
        for place, load in enumerate(self.mechanism.loads):
            if not load.absent:
                self._load(tendon, actuator, f"load.{place}", load)
        for part in (equality, tendon, actuator):
            if not len(part):
                root.remove(part)
        # MuJoCo counts joints as they stand in its tree
        speeds = [self.speeds[str(joint.get("name"))] for joint in world.iter("joint")]
        keyframe = SubElement(root, "keyframe")
        SubElement(keyframe, "key", name="start", qvel=_row(speeds))
        return root

    def _clock(self, world: Element) -> None:
        body = SubElement(world, "body", name=CLOCK)
        SubElement(body, "joint", name=CLOCK, type="slide", axis="0 0 1")
        SubElement(body, "inertial", pos="0 0 0", mass=repr(INERT), diaginertia="1 1 1")
        self.speeds[CLOCK] = 1.0

    def _body(self, branch: Branch) -> None:
        own, parent = self.frames[branch.body], self.frames[branch.parent]
        body = self.mechanism.bodies[branch.body]
        node = SubElement(self.nodes[branch.parent], "body", name=branch.body,
                          pos=_point(parent.local(own.origin)),
                          euler=_row([0.0, 0.0, own.angle - parent.angle]))  # fmt: skip
        self.nodes[branch.body] = node
        self._joints(node, branch)
        inertia = max(body.inertia.value, LEAST)
        centre = [number.value for number in body.centre]
        mass = float(body.mass.value)
        if not mass:
            masses = [item.mass.value for item in self.mechanism.bodies.values()]
            mass = self._part * (max(masses) or 1.0)
            inertia = max(inertia, mass * self._size**2)
            node.append(Comment(" no mass in the definition: MuJoCo needs one "))
        SubElement(node, "inertial", pos=_point(centre), mass=repr(mass),
                   diaginertia=_row([inertia] * 3))  # fmt: skip
        points = [np.array([number.value for number in point]) for point in body.points.values()]
        size = repr(0.02 * self._size)
        SubElement(node, "geom", type="sphere", size=size, pos=_point(points[0]))
        for point in points[1:]:
            if np.linalg.norm(point - points[0]) > 0.0:
                ends = f"{_point(points[0])} {_point(point)}"
                SubElement(node, "geom", type="capsule", size=size, fromto=ends)
        for term in self.mechanism.point_masses:
            if self.mechanism.carrier(term.joint) == branch.body and term.mass.value:
                place = _point(own.local(self.places[term.joint]))
                lump = SubElement(node, "body", pos=place)
                SubElement(lump, "inertial", pos="0 0 0", mass=repr(float(term.mass.value)),
                           diaginertia=_row([LEAST] * 3))  # fmt: skip

    @property
    def note(self) -> str:
        """What masses that MuJoCo needs change; empty where all bodies have one."""
        bodies = self.mechanism.bodies
        names = [own.body for own in self.tree.branches if not bodies[own.body].mass.value]
        effect = {
            TREE: "",
            LOOPS: "; where they carry loads, loops may open by 1e-5 m: give them masses",
            DRIVEN: "; drives determine the motion, forces change by about this part",
        }[self._part]
        given = f"{self._part:g} of the largest mass each{effect}"
        return f"MuJoCo needs a mass for {listed(names, 'and')}: {given}" if names else ""

    @property
    def _part(self) -> float:
        """Mass of a body that has none, as a part of the largest one."""
        if self.system.topology.free:
            held = self.tree.loops or self.mechanism.relations or self.mechanism.prescribed
            return LOOPS if held else TREE
        return DRIVEN

    @property
    def _size(self) -> float:
        return float(np.ptp(np.array([*self.places.values()]), axis=0).max())

    def _joints(self, node: Element, branch: Branch) -> None:
        own, parent = self.frames[branch.body], self.frames[branch.parent]
        match branch.joining:
            case Pin(joint):
                self._hinge(node, branch.body, own.local(self.places[joint]))
                self.speeds[branch.body] = own.speed - parent.speed
            case Rail(_, slider):
                sign = 1.0 if slider == branch.body else -1.0
                axis = own.axes.T @ self.frames[slider].axes[:, 0]
                SubElement(node, "joint", name=branch.body, type="slide", axis=_point(sign * axis))
                self.speeds[branch.body] = self.slides[slider]
            case Gap(term, _, other):
                ends = [self.places[term.joint], self.places[term.renamed]]
                first, second = ends if other == branch.body else ends[::-1]
                link = self.frames[term.links[0].name]
                self._hinge(node, term.links[0].name, own.local(first))
                self._hinge(node, branch.body, own.local(second))
                self.speeds[term.links[0].name] = link.speed - parent.speed
                self.speeds[branch.body] = own.speed - link.speed
            case _:
                assert_never(branch.joining)

    def _hinge(self, node: Element, name: str, place: object) -> None:
        SubElement(node, "joint", name=name, type="hinge", axis="0 0 1", pos=_point(place))

    def _loop(self, equality: Element, pin: Pin) -> None:
        """Bodies of a joint that the tree has opened."""
        named = {"body1": pin.other}
        if pin.one != WORLD:
            named["body2"] = pin.one
        place = self.frames[pin.other].local(self.places[pin.joint])
        named |= {"name": f"{pin.joint}.{pin.other}", "anchor": _point(place)}
        SubElement(equality, "connect", named)

    # --- coordinates as sums of joints ---

    def _coordinate(self, name: str) -> dict[str, float]:
        """Joint → factor, whose sum is what a body's coordinate has changed by."""
        if self.mechanism.bodies[name].rotates:
            return self._angle(name)
        joinings = ((branch.joining, branch.body) for branch in self.tree.branches)
        return {body: 1.0 for own, body in joinings if isinstance(own, Rail) and own.other == name}

    def _angle(self, name: str) -> dict[str, float]:
        """Hinges below a body, or below the link of a clearance and its own."""
        above = {b.joining.term.links[0].name: b for b in self.tree.branches
                 if isinstance(b.joining, Gap)}  # fmt: skip
        if name in above:
            return {**self._angle(above[name].parent), name: 1.0}
        result: dict[str, float] = {}
        for branch in self.tree.path(name):
            if isinstance(branch.joining, Gap):
                result[branch.joining.term.links[0].name] = 1.0
            if not isinstance(branch.joining, Rail):
                result[branch.body] = 1.0
        return result

    def _sum(self, parts: dict[str, float]) -> dict[str, float]:
        result: dict[str, float] = {}
        for name, factor in parts.items():
            for joint, own in self._coordinate(name).items():
                result[joint] = result.get(joint, 0.0) + factor * own
        return {joint: factor for joint, factor in result.items() if factor}

    def _fixed(self, tendon: Element, name: str, parts: dict[str, float], **more: str) -> None:
        """A sum of coordinates."""
        node = SubElement(tendon, "fixed", {"name": name, **more})
        for joint, factor in self._sum(parts).items():
            SubElement(node, "joint", joint=joint, coef=repr(factor))

    def _held(self, tendon: Element, equality: Element, name: str, parts: dict[str, float]) -> None:
        """A sum of coordinates that stays what it is."""
        self._fixed(tendon, name, parts)
        SubElement(equality, "tendon", name=name, tendon1=name, polycoef="0 0 0 0 0")

    def _drive(self, tendon: Element, equality: Element, name: str) -> None:
        followed, joint = polynomial(self.system, name), CLOCK
        if followed is None:
            joint, followed = self._yoke(equality, name), (1.0, 0.0, 0.0, 0.0)
        own, other = f"drive.{name}", f"drive.{name}.{CLOCK}"
        self._fixed(tendon, own, {name: 1.0})
        node = SubElement(tendon, "fixed", name=other)
        SubElement(node, "joint", joint=joint, coef="1")
        SubElement(equality, "tendon", name=own, tendon1=own, tendon2=other,
                   polycoef=_row([0.0, *followed]))  # fmt: skip

    def _yoke(self, equality: Element, name: str) -> str:
        """A Scotch yoke, whose wheel turns with the clock; the slide that moves harmonically."""
        motion = harmonic(self.system, name)
        assert motion is not None
        radius, frequency, phase = motion
        wheel, across, along = (f"drive.{name}.{part}" for part in ("wheel", "across", "along"))
        place = _row([radius * np.cos(phase), radius * np.sin(phase), 0.0])
        world = self.nodes[WORLD]
        turning = SubElement(world, "body", name=wheel)
        SubElement(turning, "joint", name=wheel, type="hinge", axis="0 0 1")
        SubElement(turning, "inertial", pos="0 0 0", mass="1", diaginertia=_row([INERT] * 3))
        outer = SubElement(world, "body", name=across, pos=place)
        SubElement(outer, "joint", name=across, type="slide", axis="1 0 0")
        SubElement(outer, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        inner = SubElement(outer, "body", name=along)
        SubElement(inner, "joint", name=along, type="slide", axis="0 1 0")
        SubElement(inner, "inertial", pos="0 0 0", mass="1", diaginertia="1 1 1")
        SubElement(equality, "joint", name=wheel, joint1=wheel, joint2=CLOCK,
                   polycoef=_row([0.0, frequency, 0.0, 0.0, 0.0]))  # fmt: skip
        SubElement(equality, "connect", name=along, body1=wheel, body2=along, anchor=place)
        self.speeds[wheel] = frequency
        self.speeds[across] = -radius * frequency * np.sin(phase)
        self.speeds[along] = radius * frequency * np.cos(phase)
        return along

    # --- loads ---

    def _load(self, tendon: Element, actuator: Element, name: str, load: Load) -> None:
        """A spring and damper along a tendon, or a constant force: an actuator without control."""
        line = line_in(load)
        assert line is not None
        if isinstance(load.measure, Coordinate):
            gear = [0.0] * 6
            gear[load.measure.axis] = 1.0
            along = {"site": f"site.{load.measure.joint}", "refsite": "site.", "gear": _row(gear)}
        else:
            along = {"tendon": name}
            relaxed = line.constant / line.stiffness if line.stiffness else 0.0
            numbers = {"stiffness": line.stiffness, "damping": line.damping}
            self._tendon(tendon, name, load, relaxed, {n: repr(v) for n, v in numbers.items() if v})
        if not line.stiffness:
            along |= {"name": name, "gainprm": "0", "biastype": "affine"}
            SubElement(actuator, "general", along, biasprm=_row([line.constant, 0.0, 0.0]))

    def _tendon(
        self, tendon: Element, name: str, load: Load, relaxed: float, numbers: dict[str, str]
    ) -> None:
        """What a load acts along; sums of joints count from the start."""
        spring = {"springlength": repr(relaxed)} if "stiffness" in numbers else {}
        from_start = {key: repr(relaxed - self._at(load)) for key in spring}
        match load.measure:
            case Distance(first, second):
                node = SubElement(tendon, "spatial", {"name": name, **numbers, **spring})
                SubElement(node, "site", site=f"site.{first}")
                SubElement(node, "site", site=f"site.{second}")
            case Turn(body, reference):
                parts = {body: 1.0} | ({} if reference is None else {reference: -1.0})
                self._fixed(tendon, name, parts, **numbers, **from_start)
            case Slide(body):
                self._fixed(tendon, name, {body: 1.0}, **numbers, **from_start)
            case Coordinate() | BodyAxis():
                raise AssertionError(load.measure)  # has no tendon, or is refused
            case _:
                assert_never(load.measure)

    def _at(self, load: Load) -> float:
        """The value of what a load acts along, at the start."""
        nodes = self.system.model.loads[self.mechanism.loads.index(load)]
        return float(self.system.evaluate([nodes.displacement])[0, 0])

    def _sites(self) -> None:
        joints: list[str] = []
        for measure in (load.measure for load in self.mechanism.loads):
            if isinstance(measure, Distance):
                joints += [measure.first, measure.second]
            elif isinstance(measure, Coordinate):
                joints.append(measure.joint)
        if joints:
            SubElement(self.nodes[WORLD], "site", name="site.", pos="0 0 0")
        for joint in dict.fromkeys(joints):
            body = self.mechanism.carrier(joint) or WORLD
            place = self.frames[body].local(self.places[joint])
            SubElement(self.nodes[body], "site", name=f"site.{joint}", pos=_point(place))


def _row(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _point(place: object) -> str:
    x, y = np.asarray(place, dtype=float)
    return _row([x, y, 0.0])
