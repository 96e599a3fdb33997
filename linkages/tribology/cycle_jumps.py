"""Wear over many revolutions by jumps between motions that have settled.

The work W of the normal force along the slip obeys dW/dn = g(W) over the revolutions n, with the
mean g of the motion that settles with clearances as worn as W says. An embedded pair of
Runge–Kutta methods of orders 3 and 2 [1]_ jumps along this equation: the distance of both is the
error of a jump, and standard errors of means count beside it.

References
----------
.. [1] P. Bogacki, L. F. Shampine, "A 3(2) pair of Runge-Kutta formulas", Appl. Math. Lett. 2 (1989)
   321-325.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, Interrupted, UnfinishedError
from linkages.options.analysis_options import WearKeywords, WearOptions
from linkages.options.option import OptionError, takes
from linkages.reading.wording import listed
from linkages.solution.run_options import options_of
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.units import LENGTH, Bound
from linkages.sweeps.engine import Answer, Field
from linkages.sweeps.store import InOrder, in_order
from linkages.tribology.steady_work import PRECISION, SteadyWork, WornMotions
from linkages.tribology.wear_results import wear_dataset
from linkages.tribology.worn_bearings import BINS
from linkages.tribology.worn_joints import WornJoint

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

STAGES = (1 / 2, 3 / 4)
THIRD = np.array([2 / 9, 1 / 3, 4 / 9, 0.0])
"""Weights of the result of third order."""

APART = THIRD - np.array([7 / 24, 1 / 4, 1 / 3, 1 / 8])
"""Weights of its distance from the result of second order."""

FIRST = 0.05
"""Growth of a clearance in the first jump, over its size."""

LEAST = 1e-3
"""Growth in a jump over the size, below which it counts whatever its error: motions may jump."""

NOISE = 3.0
"""Standard errors within which the error of a jump is that of its means."""

ENOUGH = 1.01
"""How far a jump goes to a limit, over the distance from it."""

SAFE, LESS, MORE = 0.9, 0.2, 4.0
"""Factor of the next jump, and its limits."""

TWO_SIGMA = 2.0

MOST_JUMPS = 10_000

Watch = Callable[[float], None]


class Means:
    """Settled motions, one after the other; those that a store has are taken out of it."""

    def __init__(self, motions: WornMotions, results: InOrder, precision: float) -> None:
        self.motions, self._results, self._precision = motions, results, precision
        self.revolutions = 0

    def __call__(self, work: Floats, depths: Floats, before: SteadyWork | None) -> SteadyWork:
        """As `WornMotions.settled`."""
        if (known := self._results.next(self._fields)) is None:
            found = self.motions.settled(work, depths, before, self._precision)
            self._results.keep(self._fields, Answer(vars(found)))
        else:
            found = SteadyWork(**{name: known[name] for name in self._fields})
        self.revolutions += int(found.revolutions)
        return found

    @property
    def _fields(self) -> dict[str, Field]:
        count, size = len(self.motions.joints), len(self.motions.base.state)
        names = ("work", "error", "distance", "peak", "away", "worn", "spread")
        each = dict.fromkeys(names, Field("f8", (count,)))
        each |= {"density": Field("f8", (count, 2, BINS)), "state": Field("f8", (size,))}
        each |= {"depths": Field("f8", (count, BINS))}
        return each | {"trusted": Field("i1"), "revolutions": Field("i8")}


@dataclass(frozen=True)
class Place:
    """Where wear has come to: revolutions, work in each clearance, and errors of that work.

    `slid`: distance of slip so far in m; `profile`: depth in m, (clearances, 2, `BINS`), as if wear
    stayed where it arises.
    `depths`: of bearings that wear out of round, in m, (clearances, `BINS`).
    `jumped`, `noise`: error of jumps so far, and variance by means, of the work, (clearances,).
    """

    revolutions: float
    work: Floats
    here: SteadyWork
    slid: Floats
    profile: Floats
    depths: Floats
    jumped: Floats
    noise: Floats

    @property
    def error(self) -> Floats:
        """Of the work in J: errors of all jumps, and two standard errors, shape (clearances,)."""
        return self.jumped + TWO_SIGMA * np.sqrt(self.noise)


@dataclass(frozen=True)
class Limit:
    """A size at which wear ends."""

    joint: int
    size: float

    def work(self, joints: list[WornJoint]) -> float:
        """Work in that clearance with which it has this size; by bisection."""
        own = joints[self.joint]
        low, high = 0.0, 1.0
        while own.size(high) < self.size:
            low, high = high, 2.0 * high
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if own.size(middle) < self.size else (low, middle)
        return high


def read_limit(joints: list[WornJoint], text: str) -> Limit:
    """Read ``"clearances.gap.size = 0.5 mm"``."""
    path, equals, value = (part.strip() for part in text.partition("="))
    paths = [joint.size_path for joint in joints]
    if not equals or path not in paths:
        expected = f"expected a size of a clearance that wears, such as '{paths[0]} = 0.5 mm'"
        raise OptionError("until", f"{expected}, found {text!r}; there are {listed(paths)}")
    try:
        size = parse_quantity(value, LENGTH, Bound.POSITIVE)
    except QuantityError as error:
        raise OptionError("until", f"{path}: {error}") from None
    joint = paths.index(path)
    if size <= joints[joint].own.size:
        message = f"{path} is {joints[joint].own.size:g} m; expected a larger limit, found {value}"
        raise OptionError("until", message)
    return Limit(joint, size)


class Jumps:
    """Jumps over revolutions, each as far as its error allows."""

    def __init__(self, means: Means, run: WearOptions, limit: Limit | None) -> None:
        self.means, self.run, self.limit = means, run, limit
        self.joints = means.motions.joints
        self.most = math.inf if run.revolutions is None else float(run.revolutions)
        self.last = math.inf if limit is None else limit.work(self.joints)
        self.places: list[Place] = []
        self.forced = 0

    def begin(self) -> Place:
        """The motion before any wear."""
        none = np.zeros(len(self.joints))
        depths = self.means.motions.first_depths
        here = self.means(none, depths, None)
        place = Place(0.0, none, here, none, np.zeros((len(none), 2, BINS)), depths, none, none)
        self.places.append(place)
        return place

    def run_all(self, watch: Watch | None) -> str:
        """Jump to the end; returns why it is one."""
        place = self.begin()
        step = self._at_most(place, FIRST)
        while place.revolutions < self.most and not self._reached(place):
            if len(self.places) > MOST_JUMPS:
                message = f"{MOST_JUMPS} jumps were not enough; expected a lower accuracy"
                raise ComputationError(message, time=0.0)
            if not np.isfinite(step):
                message = "nothing slips under a force: the limit is never reached"
                if np.isfinite(self.most):
                    step = self.most - place.revolutions
                else:
                    raise ComputationError(message, time=0.0)
            step = min(step, self.most - place.revolutions, ENOUGH * self._left(place))
            place, step = self._jump(place, step)
            if self._reached(place):
                place = self._back(place)
            self.places.append(place)
            if watch is not None:
                watch(self._done(place))
        return "limit" if self._reached(place) else "revolutions"

    def _reached(self, place: Place) -> bool:
        # a bisection ends next to it
        return self.limit is not None and place.work[self.limit.joint] >= self.last * (1 - 1e-15)

    def _left(self, place: Place) -> float:
        """Revolutions until the limit at the present rate."""
        if self.limit is None or not place.here.work[self.limit.joint] > 0.0:
            return math.inf
        left = self.last - place.work[self.limit.joint]
        return float(left / place.here.work[self.limit.joint])

    def _done(self, place: Place) -> float:
        """Part of all revolutions, or of the way to the limit."""
        parts = [place.revolutions / self.most]
        if self.limit is not None:
            parts.append(float(place.work[self.limit.joint]) / self.last)
        return min(1.0, max(parts))

    def growth(self, place: Place, more: Floats) -> Floats:
        """Growth of all sizes by more work, in m, shape (clearances,)."""
        pairs = zip(self.joints, place.work.tolist(), more.tolist(), strict=True)
        return np.array([joint.growth(work, own) for joint, work, own in pairs])

    def sizes(self, place: Place) -> Floats:
        """Of all clearances in m, of round bearings, shape (clearances,)."""
        pairs = zip(self.joints, place.work.tolist(), strict=True)
        return np.array([joint.size(work) for joint, work in pairs])

    def _at_most(self, place: Place, part: float) -> float:
        """Revolutions in which no clearance grows by more than a part of its size."""
        rates = self.growth(place, place.here.work) / self.sizes(place)
        fastest = float(rates.max())
        return part / fastest if fastest > 0.0 else math.inf

    def _tried(self, place: Place, step: float) -> tuple[Place, Floats, Floats]:
        """The place behind a jump, the error of its growth in m, and what of that means explain."""
        found = [place.here]
        for part in STAGES:
            last = found[-1]
            work = place.work + part * step * last.work
            layer = part * step * self._layers([last])[0]
            found.append(self.means(work, self._depths(place, layer, work), last))
        slopes = np.array([each.work for each in found])
        work = place.work + step * (THIRD[:3] @ slopes)
        layer = step * np.tensordot(THIRD[:3], self._layers(found), 1)
        depths = self._depths(place, layer, work)
        found.append(self.means(work, depths, found[-1]))
        slopes = np.array([each.work for each in found])
        layers = self._layers(found)
        variances = np.array([each.error for each in found]) ** 2
        error = np.abs(step * (APART @ slopes))
        noise = step**2 * (APART**2 @ variances)
        slid = place.slid + step * (THIRD @ np.array([each.distance for each in found]))
        behind = Place(
            revolutions=place.revolutions + step,
            work=work,
            here=found[-1],
            slid=slid,
            profile=place.profile + step * np.tensordot(THIRD, layers, 1),
            depths=depths,
            jumped=place.jumped + error,
            noise=place.noise + step**2 * (THIRD**2 @ variances),
        )
        wrong = self.growth(place, error)
        by_means = NOISE * self.growth(place, np.sqrt(noise))
        out_of_round = np.array([bool(joint.harmonics) for joint in self.joints])
        if out_of_round.any():  # and wherever wear is around the bearing
            around = np.abs(step * np.tensordot(APART, layers[:, :, 1], 1)).mean(axis=-1)
            spread = np.array([each.spread for each in found]) * slopes * self._thickness[:, 1, 0]
            chance = NOISE * step * np.sqrt(APART**2 @ spread**2)
            wrong = np.where(out_of_round, np.maximum(wrong, around), wrong)
            by_means = np.where(out_of_round, np.maximum(by_means, chance), by_means)
        return behind, wrong, by_means

    def _layers(self, found: list[SteadyWork]) -> Floats:
        """Depth of wear per revolution where it arises, in m, (motions, clearances, 2, `BINS`)."""
        slopes = np.array([each.work for each in found])
        densities = np.array([each.density for each in found])
        return np.asarray(slopes[:, :, None, None] * densities * self._thickness)

    def _depths(self, place: Place, layers: Floats, work: Floats) -> Floats:
        """Depths of bearings behind some layers of wear, shape (clearances, `BINS`)."""
        pairs = zip(self.joints, place.depths, layers, work.tolist(), strict=True)
        return np.array([own.deepened(depth, layer[1], w) for own, depth, layer, w in pairs])

    @property
    def _thickness(self) -> Floats:
        """Depth in m by a work of 1 J per radian, shape (clearances, 2, 1)."""
        return np.array([
            joint.rates / (np.array(joint.radii) * joint.width) if joint.turns else [0.0, 0.0]
            for joint in self.joints
        ])[:, :, None]  # fmt: skip

    def _jump(self, place: Place, step: float) -> tuple[Place, float]:
        """A jump that is accepted, and how far to try the next one."""
        while True:
            behind, wrong, by_means = self._tried(place, step)
            more = behind.work - place.work
            growth, sizes = self.growth(place, more), self.sizes(place)
            allowed = np.maximum(self.run.accuracy * growth, 1e-300)
            with np.errstate(divide="ignore"):
                factor = SAFE * float(np.min((allowed / np.maximum(wrong, 1e-300)) ** (1 / 3)))
            tiny = bool((growth <= LEAST * sizes).all())
            if (wrong <= np.maximum(allowed, by_means)).all() or tiny:
                self.forced += int(tiny and not (wrong <= np.maximum(allowed, by_means)).all())
                factor = max(factor, 1.0) if (wrong <= by_means).all() else factor
                step *= min(max(factor, LESS), MORE)
                return behind, min(step, self._at_most(behind, self.run.largest_jump))
            step *= min(max(factor, LESS), SAFE)

    def _back(self, behind: Place) -> Place:
        """The place within the last jump at which the limit is reached, on a cubic."""
        assert self.limit is not None
        before, k = self.places[-1], self.limit.joint
        length = behind.revolutions - before.revolutions

        def work(part: float) -> Floats:
            first, last = before.here.work * length, behind.here.work * length
            change = behind.work - before.work
            c2, c3 = 3 * change - 2 * first - last, first + last - 2 * change
            return np.asarray(before.work + part * (first + part * (c2 + part * c3)))

        low, high = 0.0, 1.0
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if work(middle)[k] < self.last else (low, middle)

        def between(name: str) -> Floats:
            first, last = getattr(before, name), getattr(behind, name)
            return np.asarray(first + high * (last - first))

        place = work(high)
        place[k] = self.last
        share = (place - before.work) / np.maximum(behind.work - before.work, 1e-300)
        layers = share[:, None, None] * (behind.profile - before.profile)
        return Place(
            revolutions=before.revolutions + high * length,
            work=place,
            here=behind.here,
            slid=between("slid"),
            profile=before.profile + layers,
            depths=self._depths(before, layers, place),
            jumped=between("jumped"),
            noise=between("noise"),
        )

    def halved(self) -> Place:
        """The end by jumps that are half as long."""
        ends = np.array([place.revolutions for place in self.places])
        place = self.places[0]
        for first, last in pairwise(ends.tolist()):
            for _ in (0, 1):
                place, _, _ = self._tried(place, 0.5 * (last - first))
        return place


@takes(WearOptions)
def wear(
    mechanism: Mechanism,
    *,
    until: str | None = None,
    store: str | Path | None = None,
    watch: Watch | None = None,
    **options: Unpack[WearKeywords],
) -> xr.Dataset:
    """Wear the joints of a mechanism over many revolutions: clearances grow and change the motion.

    Archard's law: the volume that a side loses is spread all around, or with ``feedback="profile"``
    taken off the bearing where the journal presses, so that it is no longer round. Jumps over many
    revolutions lead between motions that have settled, as long as the accuracy allows.

    Parameters
    ----------
    mechanism
        With at least one clearance that has the key ``wear``; drives and loads have a common
        period, which is a revolution.
    until
        Limit at which to end, such as ``"clearances.gap.size = 0.5 mm"``.
    store
        Folder in which means are kept as they are found; the same call goes on with them.
    watch
        Called with the fraction that is done.
    options
        As `WearOptions` describes them.

    Returns
    -------
    Dataset along the dimension `jump`: `revolutions`, `size` and its `error` in m (clearance),
    `volume` in m³ (clearance, side), `depth` in m over the angle of journal and bearing as if all
    wear stayed where it arises (clearance, side, angle), `sliding_distance` in m, and of the motion
    there `work` of the normal force along the slip per revolution in J with its standard error
    `work_error`, and `pressure_velocity` in W/m², mean and largest (clearance, of). `computed` is
    the number of revolutions that were computed. With ``feedback="profile"`` there is `profile`,
    the radial clearance in m over the angle of the bearing (clearance, angle), and `size` is that
    of a round bearing of the same volume. Attributes: ``period`` in s, ``ended`` because of the
    ``limit`` or the ``revolutions``, ``notes`` in JSON, ``worn``, what `Mechanism.with_values`
    takes for the worn mechanism, in JSON, and with `confirm` ``difference``, by how much half the
    jumps change sizes and profiles at the end.

    Raises
    ------
    InputError
        If nothing wears, or drives and loads have no common period.
    ComputationError
        If the motion cannot go on, or no wear reaches the limit.
    Interrupted
        After Ctrl-C; ``kept["wear"]`` has what there is.
    """
    run = options_of(WearOptions, mechanism, options)
    if until is None and run.revolutions is None:
        raise OptionError("revolutions", "expected a number of revolutions, or a limit 'until'")
    motions = WornMotions(mechanism, run)
    limit = None if until is None else read_limit(motions.joints, until)
    about = {"until": until, "options": run.__dict__}
    with in_order(store, mechanism, "wear", about) as results:
        means = Means(motions, results, PRECISION * run.accuracy)
        jumps = Jumps(means, run, limit)
        difference = None
        try:
            ended = jumps.run_all(watch)
            if run.confirm:
                difference = _difference(jumps)
        except (KeyboardInterrupt, ComputationError) as error:
            failed = isinstance(error, ComputationError)
            data = wear_dataset(mechanism, jumps, run, "failure" if failed else "interrupt", None)
            if data is None:
                raise
            count = data["revolutions"].to_numpy()[-1]
            there, left = f"after {count:.6g} revolutions", {"wear": data}
            if not isinstance(error, ComputationError):
                raise Interrupted(there, kept=left) from None
            raise UnfinishedError(f"{there}: {error}", left, time=error.time) from None
        data = wear_dataset(mechanism, jumps, run, ended, difference)
        assert data is not None
        results.finish(data)
    return data


def _difference(jumps: Jumps) -> Floats:
    """By how much half the jumps change the sizes at the end, in m, shape (clearances,)."""
    half, last = jumps.halved(), jumps.places[-1]
    apart = np.abs(half.depths - last.depths).max(axis=1)  # zero where bearings stay round
    return np.maximum(np.abs(jumps.growth(last, half.work - last.work)), apart)
