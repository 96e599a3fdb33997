"""Clearances as their surfaces wear: volumes, sizes, and depth over the angle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from linkages.components.contributed.bearing_profiles import support_of
from linkages.components.joint_clearances import Clearance, ContactClearance, GuideClearance
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.reading.paths import dotted
from linkages.tribology.worn_bearings import ANGLES, BINS, depth_of, harmonics, worn_depth

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WornJoint:
    """A clearance that wears, by the work W of the normal force along the slip.

    Both sides lose k/H times that, all around: the bearing of radius R + c becomes as wide, and the
    journal of radius R as thin, as the volume of a ring of the width L says. A block loses it from
    both faces, a guide where the block passes.

    `stroke`: of a block along its guide in metres.
    `harmonics`: of the profile of a bearing that wears out of round; none if wear is uniform. Its
    depth is that of a round journal, in metres at `ANGLES`.
    """

    own: Clearance | ContactClearance | GuideClearance
    stroke: float = 0.0
    harmonics: int = 0

    @property
    def name(self) -> str:
        """Of the clearance."""
        return self.own.name

    @property
    def turns(self) -> bool:
        """Whether it is a journal in a bearing."""
        return not isinstance(self.own, GuideClearance)

    @property
    def size_path(self) -> str:
        """Where the definition has the size."""
        return dotted((*self.own.path, "size"))

    @cached_property
    def rates(self) -> Floats:
        """k/H of both sides in m²/N, shape (2,)."""
        assert self.own.wear is not None
        return np.array(self.own.wear.rates)

    @property
    def width(self) -> float:
        """Along the axis in metres."""
        assert self.own.width is not None
        return self.own.width

    @property
    def radii(self) -> tuple[float, float]:
        """Of journal and bearing in metres, before wear."""
        assert not isinstance(self.own, GuideClearance)
        assert self.own.pin_radius is not None
        return self.own.pin_radius, self.own.pin_radius + self.own.size

    @property
    def area(self) -> float:
        """Over which the nominal pressure is the normal force, in m²."""
        if isinstance(self.own, GuideClearance):
            return self.own.length * self.width
        return 2.0 * self.radii[0] * self.width

    def volumes(self, work: float) -> Floats:
        """Volumes worn off both sides in m³, shape (2,)."""
        return self.rates * work

    def depths(self, work: float) -> Floats:
        """Depth of uniform wear of both sides in metres, shape (2,)."""
        first, second = self.volumes(work)
        if isinstance(self.own, GuideClearance):
            faces = 2.0 * self.width * np.array([self.own.length, self.own.length + self.stroke])
            return np.array([first, second]) / faces
        (journal, bearing), ring = self.radii, math.pi * self.width
        left = journal**2 - first / ring
        if left <= 0.0:
            raise ComputationError(f"the journal of clearance {self.name} is worn through")
        # differences of squares over sums keep the digits of small depths
        return np.array([
            first / ring / (journal + math.sqrt(left)),
            second / ring / (bearing + math.sqrt(bearing**2 + second / ring)),
        ])  # fmt: skip

    def size(self, work: float) -> float:
        """Of the clearance in metres."""
        return self.own.size + float(self.depths(work).sum())

    def growth(self, work: float, more: float) -> float:
        """By how much the size grows with a little more work, in metres."""
        here = max(abs(work), abs(more), 1e-300) * 1e-6
        slope = (self.depths(work + here).sum() - self.depths(work).sum()) / here
        return float(slope * more)

    @cached_property
    def first_depth(self) -> Floats:
        """Of the bearing before wear, shape (`BINS`,)."""
        if not self.harmonics:
            return np.zeros(BINS)
        assert isinstance(self.own, ContactClearance)
        return depth_of(self.own.profile, self.own.size)

    def deepened(self, depth: Floats, layer: Floats, work: float) -> Floats:
        """The depth of the bearing behind a layer of wear, where the work is so much by then."""
        if not self.harmonics:
            return depth
        volume, thinner = float(self.volumes(work)[1]), float(self.depths(work)[0])
        own = self.radii[0], self.width
        return worn_depth(depth, layer, thinner, self.first_depth, volume, *own)

    def curvature(self, work: float, depth: Floats) -> Floats:
        """Radius of curvature, less the journal's, of the bearing that motions see, at `ANGLES`."""
        mean, cos, sin = harmonics(depth + float(self.depths(work)[0]), self.harmonics)
        support, _, bent = support_of(mean, cos, sin, ANGLES)
        return np.asarray(support + bent)

    def overrides(self, work: float, depth: Floats) -> dict[str, object]:
        """Numbers of the definition, and profiles, by their paths."""
        first = float(self.depths(work)[0])
        result: dict[str, object] = {self.size_path: self.size(work)}
        if self.harmonics:
            mean, cos, sin = harmonics(depth + first, self.harmonics)
            result[self.size_path] = mean
            profile = {"cos": cos.tolist(), "sin": sin.tolist()}
            result[dotted((*self.own.path, "profile"))] = profile
        if isinstance(self.own, GuideClearance):
            result[dotted((*self.own.path, "height"))] = self.own.height - 2.0 * first
        else:
            result[dotted((*self.own.path, "pin_radius"))] = self.radii[0] - first
        return result


def worn_joints(
    mechanism: Mechanism, strokes: Mapping[str, float], harmonics: int = 0
) -> list[WornJoint]:
    """All clearances that wear; `strokes` are those of blocks by the names of their clearances."""
    return [WornJoint(own, strokes.get(own.name, 0.0), harmonics) for own in mechanism.worn]


def profiled(mechanism: Mechanism, harmonics: int) -> Mechanism:
    """The mechanism with so many harmonics of all bearings that wear.

    Raises
    ------
    InputError
        If something else wears, or profiles have more harmonics.
    """
    problems, values = [], {}
    for own in mechanism.worn:
        if not isinstance(own, ContactClearance) or "stiffness" not in own.law.needs:
            expected = "expected a journal and a contact with a stiffness, or uniform feedback"
            problems.append(((*own.path, "wear"), f"this has no profile; {expected}"))
            continue
        given = ((), ()) if own.profile is None else (own.profile.cos, own.profile.sin)
        if max(map(len, given)) > harmonics:
            found = f"found {max(map(len, given))}, with {harmonics} of wear"
            problems.append(((*own.path, "profile"), f"expected fewer harmonics, {found}"))
            continue
        cos, sin = ([*row, *[0.0] * (harmonics - len(row))] for row in given)
        values[dotted((*own.path, "profile"))] = {"cos": cos, "sin": sin}
    if problems:
        raise mechanism.error(problems)
    return mechanism.with_values(values)


NO_HITS = np.zeros(0), np.zeros(0)


def density(
    angles: Floats,
    work: Floats,
    halves: Floats | None = None,
    hits: tuple[Floats, Floats] = NO_HITS,
) -> Floats:
    """How work is distributed over the angle, per radian; its integral is 1, shape (`BINS`,).

    `angles`: of the contact at samples, in radians, shape (samples,).
    `work`: done between samples, shape (samples − 1,).
    `halves`: how far a contact reaches to either side there; the pressure over it is Hertz's half
    ellipse. What is not known counts as a point, which sweeps over the arc between two samples.
    `hits`: angles at which work is done at once, and that work, shape (hits,) each.
    """
    swept = np.diff(angles)
    swept = swept - 2 * np.pi * np.round(swept / (2 * np.pi))
    middle = angles[:-1] + 0.5 * swept
    half = np.maximum(0.5 * np.abs(swept), 1e-9)
    wide = np.zeros(len(half), dtype=bool)
    if halves is not None:
        between = np.minimum(0.5 * (halves[1:] + halves[:-1]), 0.5 * np.pi)
        wide = between > half
        half = np.where(wide, between, half)
    places, struck = hits
    middle, work = np.append(middle, places), np.append(work, struck)
    half = np.append(half, np.full(len(places), 1e-9))
    wide = np.append(wide, np.zeros(len(places), dtype=bool))
    done = work > 0.0
    if not done.any():
        return np.zeros(BINS)
    total, step = np.zeros(BINS), 2 * np.pi / BINS
    order = np.flatnonzero(done)[np.argsort(half[done], kind="stable")]  # few bins at a time
    for some in np.array_split(order, 1 + len(order) // 1024):
        first = np.floor((middle[some] - half[some]) / step).astype(int)[:, None]
        bins = first + np.arange(int(2 * half[some].max() / step) + 2)
        edges = np.append(bins, bins[:, -1:] + 1, axis=1) * step
        x = np.clip((edges - middle[some, None]) / half[some, None], -1.0, 1.0)
        ellipse = 0.5 + (x * np.sqrt(1.0 - x * x) + np.arcsin(x)) / np.pi
        shares = np.where(wide[some, None], ellipse, 0.5 * (x + 1.0))
        parts = np.diff(shares, axis=1) * work[some, None]
        total += np.bincount((bins % BINS).ravel(), parts.ravel(), BINS)
    return total / (work[done].sum() * step)
