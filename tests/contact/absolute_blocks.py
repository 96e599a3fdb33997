"""Blocks between the walls of their guides, in absolute coordinates.

A block is a body without constraints of its own. A corner at world place p touches a wall of the
carrier: the indentation is measured across the wall, and both bodies feel opposite forces at p. No
coordinate of a guide occurs.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import yaml
from absolute_bodies import pair as local
from absolute_bodies import turned
from absolute_contact import LOST, RUBBED, AbsoluteContact, Wall
from absolute_gaps import FREE, Gap, gap_of, number, taken_apart
from contact_bodies import Bodies
from kernel_values import at_start

import linkages
from linkages.components.contributed.load_measures import Load

SIDES = ((-1, 1), (1, 1), (-1, -1), (1, -1))


@dataclass(frozen=True)
class Corner:
    """A corner of a block: bodies by their numbers, −1 for the ground; r in the block's frame."""

    block: int
    carrier: int
    origin: np.ndarray
    angle: float
    r: np.ndarray
    side: int
    reach: float


class AbsoluteBlocks(AbsoluteContact):
    """Equations of a definition all of whose sliders have room in their guides."""

    def __init__(self, definition: str) -> None:
        content = yaml.safe_load(definition)
        self.plays = content["clearances"]
        entries = {
            f"{name}.corner{k}": gap_of(
                "", entry | {"joint": "", "bar": "", "offset": [0, 0], "rate": [0, 0]}
            )
            for name, entry in self.plays.items()
            for k in range(1, 5)
        }
        self.definition, (ideal, _) = definition, taken_apart_of(content)
        self.gaps: list[Gap] = [replace(gap, name=name) for name, gap in entries.items()]
        self.mechanism = linkages.loads(ideal)
        loose = [entry["slider"] for entry in self.plays.values()]
        self.bodies = Bodies(self.mechanism, [], loose)
        self.corners = [
            self._corner(entry, along, across)
            for entry in self.plays.values()
            for along, across in SIDES
        ]
        self.size = self.bodies.size
        self.pull = np.zeros(self.size)
        gravity = self.mechanism.gravity
        self.pull[0::3], self.pull[1::3] = gravity.x.value, gravity.y.value
        self.loads = [(load, *self._row(load)) for load in self.mechanism.loads]

    def _corner(self, entry: dict, along: int, across: int) -> Corner:
        names, slider = self.bodies.names, entry["slider"]
        guide = self.mechanism.bodies[slider].guide
        carrier = -1 if guide.body is None else names.index(guide.body)
        centre = 0.0 if carrier < 0 else self.bodies.centres[guide.body]
        half = 0.5 * number(entry["length"]), 0.5 * number(entry["height"])
        r = np.array([along * half[0], across * half[1]]) - self.bodies.centres[slider]
        origin = local(guide.origin) - centre
        reach = half[1] + number(entry["size"])
        return Corner(names.index(slider), carrier, origin, guide.angle.value, r, across, reach)

    def _row(self, load: Load) -> tuple[np.ndarray, float]:
        """A force along a guide of the ground acts on the block at its joint, its centre here."""
        name = load.measure.body
        if name not in self.bodies.loose:
            return super()._row(load)
        guide, k = self.mechanism.bodies[name].guide, self.bodies.names.index(name)
        assert guide.body is None
        row = np.zeros(self.size)
        row[3 * k : 3 * k + 2] = math.cos(guide.angle.value), math.sin(guide.angle.value)
        return row, 0.0

    def start(self) -> np.ndarray:
        """Where the program under test starts; `projected` takes off what does not fit."""
        found, q, v = at_start(linkages.loads(self.definition)), [], []
        plays = {entry["slider"]: entry for entry in self.plays.values()}
        for name, body in self.mechanism.bodies.items():
            if body.guide is None:
                angle, spin = found["bar_angle"][name], found["bar_speed"][name]
            else:
                angle = number(plays[name]["angle"]) + body.guide.angle.value
                spin = number(plays[name]["speed"])
                if body.guide.body is not None:
                    angle += found["bar_angle"][body.guide.body]
                    spin += found["bar_speed"][body.guide.body]
            joint, place = next(iter(body.points.items()))
            arm = turned(angle, self.bodies.centres[name] - local(place))
            q += [*(found["joint_position"][joint] + arm), angle]
            v += [*(found["joint_velocity"][joint] + spin * np.array([-arm[1], arm[0]])), spin]
        return self.projected(0.0, np.array([*q, *v, 0.0, 0.0, 0.0]))

    def placed(self, k: int, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, Wall, list]:
        """Where corner `k` is, how it stands to its wall, and the two bodies with their arms."""
        corner, gap = self.corners[k], self.gaps[k]
        x, y, angle = q[3 * corner.block : 3 * corner.block + 3]
        arm = turned(angle, corner.r)
        place = np.array([x, y]) + arm
        moved = velocity(v, corner.block, arm)
        ends = [(corner.block, arm, 1.0)]
        axis, origin = corner.angle, corner.origin
        if corner.carrier >= 0:
            base = q[3 * corner.carrier : 3 * corner.carrier + 3]
            lever = place - base[:2]
            moved = moved - velocity(v, corner.carrier, lever)
            ends.append((corner.carrier, lever, -1.0))
            axis, origin = axis + base[2], base[:2] + turned(base[2], origin)
        n = corner.side * np.array([-math.sin(axis), math.cos(axis)])
        t = np.array([math.cos(axis), math.sin(axis)])
        rho = float(n @ (place - origin)) - corner.reach + gap.size
        return t, Wall(rho, n, float(n @ moved), float(t @ moved)), ends

    def wall(self, y: np.ndarray, k: int) -> Wall:
        return self.placed(k, self.places(y), self.speeds(y))[1]

    def _press_all(self, modes, q, v, forces, powers):
        for k, mode in enumerate(modes):
            if mode.state == FREE:
                continue
            (t, wall, ends), gap = self.placed(k, q, v), self.gaps[k]
            force = self.force(k, wall, mode)
            elastic = gap.stiffness * max(wall.rho - gap.size, 0.0) ** gap.exponent
            along = -force * gap.rub(wall.slip)
            powers[LOST] += (force - elastic) * wall.speed
            powers[RUBBED] -= along * wall.slip
            pushed = along * t - force * wall.n
            for body, arm, sign in ends:
                torque = arm[0] * pushed[1] - arm[1] * pushed[0]
                forces[3 * body : 3 * body + 3] += sign * np.array([*pushed, torque])


def velocity(v: np.ndarray, body: int, arm: np.ndarray) -> np.ndarray:
    """Velocity of a point of a body."""
    vx, vy, spin = v[3 * body : 3 * body + 3]
    return np.array([vx - spin * arm[1], vy + spin * arm[0]])


def taken_apart_of(content: dict) -> tuple[str, list[Gap]]:
    """The definition without clearances."""
    kept = {key: value for key, value in content.items() if key != "clearances"}
    return taken_apart(yaml.safe_dump(kept, sort_keys=False))
