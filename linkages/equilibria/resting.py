"""Search for all positions in which a mechanism can rest.

Newton's method from many positions side by side, for every set of rigid contacts that may press.
Where dry friction holds, equilibria are sets, whose extent in each coordinate is found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from linkages.equilibria.statics import Places, Statics
from linkages.errors import ComputationError
from linkages.kernel.number_effects import effects, numbers_of, value_of
from linkages.kernel.varying import Varying

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

STEPS = 40
"""Along a ray from the start on which positions that can be reached are looked for."""

MOST_FLIPPED = 4
"""Blocks with two ways of assembly, of which all combinations are tried; else one at a time."""

MEETING = 1e-3
"""Part of the size of a mechanism by which joints in two ways of assembly that meet are apart."""

MOST = 60
"""Steps of Newton's method."""

LONGEST = 0.5
"""Sizes of a coordinate that a step is long at most."""

HALVINGS = 6

GROWTH = 1.2
"""By which the imbalance may grow in a step that is not shortened."""

BALANCED = 1e-10
"""Imbalance of an equilibrium, in sizes of its forces; round-off leaves 1e-15."""

ROUND_OFF, TRUSTED = 1e-14, 1e-3
"""Of positions, in sizes of coordinates, and the largest imbalance that it may explain: beyond it
forces change without bound, as at a change point."""

NEUTRAL, SINGULAR = 1e-11, 1e-14
"""Singular values of a stiffness in sizes of forces and coordinates, or over the largest one, below
which a direction is neutral."""

SAME = 1e-6
"""Sizes of coordinates by which two equilibria differ at least."""

ASIDE = 0.25
"""Part of the distance of two equilibria of one family by which one half-way is aside."""

MOST_CONTACTS = 256
"""Sets of contacts that are tried."""

PULLS = 1e-9
"""Part of the size of forces by which a contact may pull: round-off."""

NARROWED = 80
"""Halvings by which the end of an interval is found."""

EDGE = 1.0 - 1e-6
"""Part of its largest force from which on a friction takes all of it at an end of an interval."""

WIDENED = 1.5
"""By which steps outwards from an equilibrium grow until friction does not hold any more."""

MEMBERS = 12
"""Starts from which sets that friction holds are looked for where no other force balances."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A position in which a mechanism can rest."""

    place: Places  # one position
    sigma: Floats  # how much of the largest force of each dry friction acts, shape (frictions,)
    pressed: dict[int, float] = field(default_factory=dict)  # rigid contact → its force
    rubbed: dict[int, float] = field(default_factory=dict)  # rough contact that presses → its σ
    neutral: int = 0  # directions in which neighbours are equilibria as well
    interval: Floats | None = None  # ends of what dry friction holds, shape (n + m, 2)

    @property
    def z(self) -> Floats:
        """Coordinates, then internal states, shape (n + m,)."""
        return self.place.z[:, 0]


class Balance:
    """The equations of rest where some rigid contacts press.

    Unknowns w are coordinates that no drive holds, internal states, forces of contacts, then σ of
    frictions and of rough contacts, all in units of their sizes.
    """

    def __init__(self, statics: Statics, closed: Sequence[int]) -> None:
        self.statics, self.closed = statics, list(closed)
        n, m = statics.n, statics.m
        self.rows = np.concatenate([statics.own, np.arange(n, n + m)]).astype(int)
        contacts = statics.nodes.contacts
        sizes = [contact.gap.size for contact in contacts]
        gaps = statics.values(sizes, statics.start)[:, 0]
        forces = statics.force_sizes
        energy = forces[0] * statics.sizes[0]
        self.gap_sizes = gaps
        self.units = np.concatenate([statics.sizes[self.rows], energy / gaps[self.closed]])
        self.scales = np.concatenate([forces[self.rows], gaps[self.closed]])
        self.rough = [k for k in self.closed if statics.nodes.slips[k] is not None]
        self.count = len(self.units)
        self.frictions = len(statics.nodes.sticky)

    def placed(self, w: Floats, near: Places) -> Places:
        """Positions of w, with coordinates that drives hold, near others."""
        z = np.repeat(self.statics.start.z, w.shape[1], axis=1)
        count = len(self.rows)
        z[self.rows] = w[:count] * self.units[:count, None]
        return near.with_z(z)

    def at(self, w: Floats, near: Places) -> tuple[Floats, Floats]:
        """Imbalance and its derivatives, shapes (N, equations) and (N, equations, unknowns)."""
        rows, own, count = self.rows, self.statics.own, len(self.rows)
        forces = w[count : self.count] * self.units[count:, None]
        sigma = w[self.count : self.count + self.frictions]
        rubbed = dict(zip(self.rough, w[self.count + self.frictions :], strict=True))
        at = self.statics.at(self.placed(w, near), sigma)
        size, many = self.count + self.frictions + len(self.rough), w.shape[1]
        residual, slopes = np.zeros((self.count, many)), np.zeros((self.count, size, many))
        residual[:count] = at.forces[rows]
        slopes[:count, :count] = at.by_state[np.ix_(rows, rows)]
        slopes[:count, self.count : self.count + self.frictions] = at.by_friction[rows]
        for place, k in enumerate(self.closed):
            part, force = rubbed.get(k, np.zeros(many)), forces[place]
            push = at.normals[k][own] - part * at.slips[k][own]
            bend = at.bends[k] - part * at.slip_bends[k]
            residual[: len(own)] -= force * push
            slopes[: len(own), : len(own)] -= force * bend[np.ix_(own, own)]
            slopes[: len(own), count + place] -= push
            if k in rubbed:
                column = self.count + self.frictions + self.rough.index(k)
                slopes[: len(own), column] += force * at.slips[k][own]
            residual[count + place] = at.gaps[k]
            slopes[count + place, : len(own)] = at.normals[k][own]
        units = np.concatenate([self.units, np.ones(size - self.count)])
        slopes *= units[:, None] / self.scales[:, None, None]
        return (residual / self.scales[:, None]).T, slopes.transpose(2, 0, 1)

    def unknowns_at(self, places: Places) -> Floats:
        """Unknowns of positions, with all forces and frictions at zero, shape (unknowns, N)."""
        count = len(self.rows)
        size = self.count + self.frictions + len(self.rough)
        result = np.zeros((size, places.count))
        result[:count] = places.z[self.rows] / self.units[:count, None]
        return result

    def solved(self, w: Floats, near: Places) -> tuple[Floats, Places, Flags]:
        """Newton's method from many starts; frictions stay; which of them have converged."""
        count, w = self.count, w.copy()
        residual, slopes = self.at(w, near)
        step = np.full((count, w.shape[1]), np.inf)
        for _ in range(MOST):
            sound = np.isfinite(residual).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2))
            going = sound & (np.abs(step).max(axis=0) > 1e-15)
            if not going.any():
                break
            step = np.zeros_like(step)
            step[:, going] = -_least(slopes[going][:, :, :count], residual[going]).T
            longest = np.abs(step).max(axis=0)
            step *= np.minimum(1.0, LONGEST / np.maximum(longest, 1e-300))
            before = np.linalg.norm(residual, axis=1)
            short = np.ones(w.shape[1])
            for _halving in range(HALVINGS):
                moved = w.copy()
                moved[:count] += short * step
                there = self.statics.settled(self.placed(moved, near))
                residual, slopes = self.at(moved, there)
                size = np.linalg.norm(residual, axis=1)
                worse = going & ~(size <= np.maximum(GROWTH * before, BALANCED))
                if not worse.any():
                    break
                short[worse] *= 0.5
            w, near = moved, there
        # under a stiff contact the round-off of a position is a large force
        with np.errstate(invalid="ignore"):
            size = np.maximum(1.0, np.abs(w[:count]).max(axis=0))
            least = ROUND_OFF * np.abs(slopes[:, :, :count]).sum(axis=2) * size[:, None]
            least = np.clip(least, BALANCED, TRUSTED)
            balanced = (np.abs(residual) < least).all(axis=1)
        return w, near, balanced

    def neutral(self, slopes: Floats) -> int:
        """Number of directions in which the imbalance does not change."""
        sizes = np.linalg.svd(slopes[:, : self.count], compute_uv=False)
        return int((sizes <= max(NEUTRAL, SINGULAR * sizes[0])).sum())

    def rest(self, w: Floats, near: Places) -> Rest:
        """The position of one solution, shape (unknowns,)."""
        count, end = len(self.rows), self.count
        place = self.placed(w[:, None], near)
        turns = np.where(self.statics.turning[:, None], np.round(place.z / (2 * np.pi)), 0.0)
        turns[self.statics.held] = 0.0
        forces = (w[count:end] * self.units[count:]).tolist()
        _, slopes = self.at(w[:, None], near)
        return Rest(
            place=place.with_z(place.z - 2 * np.pi * turns + 0.0),
            sigma=w[end : end + self.frictions],
            pressed=dict(zip(self.closed, forces, strict=True)),
            rubbed=dict(zip(self.rough, w[end + self.frictions :].tolist(), strict=True)),
            neutral=self.neutral(slopes[0]),
        )

    def unknowns(self, rest: Rest) -> Floats:
        """The opposite of `rest`, shape (unknowns,)."""
        forces = [rest.pressed[k] for k in self.closed]
        own = np.concatenate([rest.z[self.rows], forces]) / self.units
        return np.concatenate([own, rest.sigma, [rest.rubbed[k] for k in self.rough]])


def _least(matrices: Floats, right: Floats) -> Floats:
    """Least solutions of linear systems, shapes (N, equations, unknowns) and (N, equations)."""
    left, sizes, across = np.linalg.svd(matrices, full_matrices=False)
    cut = np.maximum(NEUTRAL, SINGULAR * sizes[:, :1])
    factors = np.where(sizes > cut, 1.0 / np.maximum(sizes, 1e-300), 0.0)
    parts = factors * (left.transpose(0, 2, 1) @ right[..., None])[..., 0]
    return np.asarray((across.transpose(0, 2, 1) @ parts[..., None])[..., 0])


class Search:
    """All equilibria that are found from many positions within reach.

    `count`: of positions; `seed`: of their directions.
    """

    def __init__(self, statics: Statics, count: int, seed: int) -> None:
        self.statics, self._count, self._seed = statics, count, seed
        self.notes: list[str] = []

    @cached_property
    def starts(self) -> Places:
        """Positions that can be reached on straight lines from the start, which is the first."""
        statics, first = self.statics, self._held()
        own, reach = statics.own, statics.reaches
        random = np.random.default_rng(self._seed)
        if len(own) == 1:
            rays, steps = np.array([[1.0, -1.0]]), max(STEPS, -(-self._count // 2))
        else:
            rays, steps = random.normal(size=(len(own), self._count)), STEPS
            rays /= np.abs(rays).max(axis=0)
        path = self._followed(first, rays * reach[own, None] / steps, steps)
        if len(own) > 1:
            lasting = np.array([len(ray) for ray in path])
            drawn = (random.random(len(path)) * lasting).astype(int).tolist()
            path = [[ray[k]] for ray, k in zip(path, drawn, strict=True)]
        chosen = [first, *(place for ray in path for place in ray)]
        z, branch = zip(*((place.z, place.branch) for place in chosen), strict=True)
        return Places(np.hstack(z), np.hstack(branch))

    def _followed(self, first: Places, rays: Floats, steps: int) -> list[list[Places]]:
        """Positions along rays as far as the mechanism can be assembled.

        Through positions where two ways of assembly meet they go on smoothly. Where it cannot be
        assembled any further, they come back in the other way of assembly.
        """
        statics, count = self.statics, rays.shape[1]
        rays, here = rays.copy(), first.at([0] * count)
        paths: list[list[Places]] = [[] for _ in range(count)]
        left, returned = np.full(count, steps), np.zeros(count, dtype=bool)
        joints = self._joints(here)
        before = np.full_like(joints, np.nan)
        while (left > 0).any():
            expected = 2 * joints - before
            there = self._moved(here, rays)
            found = self._joints(there)
            missed = np.nan_to_num(np.abs(found - expected).max(axis=0), nan=np.inf)
            pace = np.nan_to_num(np.abs(joints - before).max(axis=0))
            finite = np.isfinite(found).all(axis=0)
            for sides in self._others if (~finite | (missed > pace)).any() else ():
                other = self._moved(statics.flipped(here, sides), rays)
                places = self._joints(other)
                off = np.nan_to_num(np.abs(places - expected).max(axis=0), nan=np.inf)
                better = (off < 0.5 * missed) & (off <= pace)
                there, found = there.where(better, other), np.where(better, places, found)
                missed, finite = np.where(better, off, missed), finite | better
            turned = ~finite & (left > 0)
            if turned.any():
                here, back = self._returning(here, rays, turned)
                rays[:, back] *= -1.0
                left[back & ~returned] += 2 * steps
                returned |= back
                left[turned & ~back] = 0
                joints = np.where(turned, self._joints(here), joints)
                before[:, turned] = np.nan
            going = finite & (left > 0)
            here = here.where(going, there)
            before, joints = np.where(going, joints, before), np.where(going, found, joints)
            left -= 1
            for k in np.flatnonzero(going).tolist():
                paths[k].append(here.at([k]))
        return paths

    def _moved(self, places: Places, rays: Floats) -> Places:
        z = places.z.copy()
        z[self.statics.own] += rays
        return self.statics.settled(places.with_z(z))

    @cached_property
    def _others(self) -> list[tuple[int, ...]]:
        """Blocks that may be assembled in their other ways together."""
        count = range(len(self.statics.sides))
        most = len(count) if len(count) <= MOST_FLIPPED else 1
        return [own for size in range(1, most + 1) for own in combinations(count, size)]

    def _returning(self, here: Places, rays: Floats, turned: Flags) -> tuple[Places, Flags]:
        """The last positions on some rays, in the other way of assembly that meets there."""
        low, high = np.zeros(here.count), np.ones(here.count)
        for _ in range(NARROWED // 2):
            middle = 0.5 * (low + high)
            sound = np.isfinite(self._joints(self._moved(here, middle * rays))).all(axis=0)
            low, high = np.where(sound, middle, low), np.where(sound, high, middle)
        last = self._moved(here, low * rays)
        joints, back = self._joints(last), np.zeros(here.count, dtype=bool)
        result = here.where(turned, last)
        size = float(np.ptp(self._joints(self.statics.start), axis=0).max()) or 1.0
        for sides in self._others:
            other = self.statics.flipped(last, sides)
            apart = np.abs(self._joints(other) - joints).max(axis=0)
            meets = turned & ~back & (apart < MEETING * size)
            result, back = result.where(meets, other), back | meets
        return result, back

    def _held(self) -> Places:
        """The position of the definition with drives at their time, moved there step by step."""
        statics = self.statics
        start, held = statics.start, statics.held
        first = start.z.copy()
        first[held] = statics.system.state[held][:, None]
        steps = 1 + int(np.abs(start.z - first).max(initial=0.0) / 0.3)
        here = start.with_z(first)
        for k in range(1, steps + 1):
            here = statics.settled(here.with_z(first + k / steps * (start.z - first)))
        if not np.isfinite(self._joints(here)).all():
            raise ComputationError(
                f"the mechanism cannot be assembled with its drives at t = {statics.time:g} s and "
                "its free coordinates as the definition has them; give others in 'free'",
                time=statics.time,
            )
        return here

    def _joints(self, places: Places) -> Floats:
        """Places of all joints, shape (2·joints, N)."""
        return self.statics.values(self.statics.nodes.joints, places)

    def _contacts(self) -> Iterator[tuple[int, ...]]:
        """Sets of rigid contacts that may press, none first."""
        count, tried = len(self.statics.nodes.contacts), 0
        for size in range(min(count, len(self.statics.own)) + 1):
            for chosen in combinations(range(count), size):
                tried += 1
                if tried > MOST_CONTACTS:
                    self.notes.append(f"only {MOST_CONTACTS} sets of contacts that press are tried")
                    return
                yield chosen

    def found(self) -> list[Rest]:
        """All equilibria, each once; sets that friction holds, each once."""
        result: list[Rest] = []
        for closed in self._contacts():
            balance = Balance(self.statics, closed)
            own = self._frictionless(balance)
            result += [each for each in own if self._allowed(balance, each)]
        return self._held_by_friction(result) if self.rubs else result

    @property
    def rubs(self) -> bool:
        """Whether dry friction holds anything anywhere."""
        nodes = self.statics.nodes
        if any(rough is not None for rough in nodes.slips):
            return True
        if not nodes.sticky:
            return False
        return bool((np.abs(np.nan_to_num(self.statics.at(self.starts).by_friction)) > 0).any())

    def _frictionless(self, balance: Balance) -> list[Rest]:
        w, places, good = balance.solved(balance.unknowns_at(self.starts), self.starts)
        families: list[list[Rest]] = []
        for k in np.flatnonzero(good).tolist():
            each = balance.rest(w[:, k], places.at([k]))
            if not self._reached(each):
                continue
            own = next((one for one in families if self._belongs(balance, each, one)), None)
            if own is None:
                families.append(own := [])
            own.append(each)
        many = self.starts.count
        if many > 1 and len(families) == 1 and len(families[0]) == many and not balance.closed:
            moved = np.abs(places.z - self.starts.z)[balance.rows].max()
            if families[0][0].neutral and moved == 0.0:
                self.notes.append("every position within reach is an equilibrium")
        return [one[0] for one in families]

    def _reached(self, rest: Rest) -> bool:
        """Whether no angle has made more than half a turn, of those whose turns count."""
        statics = self.statics
        rows = [k for k in statics.own if statics.winding[k]]
        return bool((np.abs(rest.z - statics.start.z[:, 0])[rows] <= np.pi + SAME).all())

    def _apart(self, one: Floats, other: Floats) -> Floats:
        """Difference of positions, without whole turns, shape (n + m, N)."""
        apart = one - other
        turns = np.where(self.statics.turning[:, None], np.round(apart / (2 * np.pi)), 0.0)
        return np.asarray(apart - 2 * np.pi * turns)

    def _belongs(self, balance: Balance, rest: Rest, family: Sequence[Rest]) -> bool:
        """Whether an equilibrium is one that is known, or belongs to its family."""
        sides = slice(len(self.statics.system.topology.carried), None)
        if (rest.place.branch[sides] != family[0].place.branch[sides]).any():
            return False
        z = np.stack([other.z for other in family], axis=1)
        rows, apart = balance.rows, self._apart(z, rest.place.z)
        distance = np.abs(apart[rows] / self.statics.sizes[rows, None]).max(axis=0)
        near = int(distance.argmin())
        if distance[near] < SAME:
            return True
        if not (rest.neutral and family[0].neutral):
            return False
        between = rest.place.with_z(rest.place.z + 0.5 * apart[:, [near]])
        first = balance.unknowns_at(between)
        w, there, good = balance.solved(first, between)
        aside = np.abs(w - first)[: len(rows)].max()
        half_way = bool(good[0]) and aside <= ASIDE * distance[near]
        return half_way and balance.rest(w[:, 0], there).neutral > 0

    def _allowed(self, balance: Balance, rest: Rest) -> bool:
        """Whether contacts push, or adhesion holds them, and all others are open."""
        least = -(self.statics.adhesions + PULLS * balance.units[-1])
        if any(force < least[k] for k, force in rest.pressed.items()):
            return False
        gaps = self.statics.at(rest.place)
        others = [k for k in range(len(balance.gap_sizes)) if k not in rest.pressed]
        return bool((gaps.gaps[others, 0] <= SAME * balance.gap_sizes[others]).all())

    # -- dry friction ----------------------------------------------------------------------------

    def _held_by_friction(self, smooth: Sequence[Rest]) -> list[Rest]:
        """Sets that friction holds: those about equilibria without it, and others."""
        statics = self.statics
        if len(statics.own) == 1 and not statics.m and not statics.nodes.contacts:
            return self._intervals(smooth)
        members = [*smooth, *self._members()]
        result: list[Rest] = []
        for each in members:
            balance = Balance(statics, [*each.pressed])
            found = replace(each, interval=self._extent(balance, each))
            if not any(self._alike(found, other) for other in result):
                result.append(found)
        return result

    def _alike(self, one: Rest, other: Rest) -> bool:
        assert one.interval is not None
        assert other.interval is not None
        apart = np.abs(one.interval - other.interval).max(axis=1)
        wide = np.ptp(one.interval, axis=1) + self.statics.sizes * SAME
        return one.pressed.keys() == other.pressed.keys() and bool((apart <= 0.02 * wide).all())

    def _intervals(self, smooth: Sequence[Rest]) -> list[Rest]:
        """Intervals of the only coordinate, from every position within reach that is held."""
        statics = self.statics
        (own,) = statics.own.tolist()
        starts = self.starts
        limits: dict[tuple[float, ...], list[float]] = {}
        sides = starts.branch[len(statics.system.topology.carried) :]
        for k in range(starts.count):
            limits.setdefault(tuple(sides[:, k]), []).append(float(starts.z[own, k]))
        grid = 2 * statics.reaches[own] / self._count

        def over(place: Places, value: float) -> tuple[float, Places]:
            """By how much the force is larger than all frictions, at another position near."""
            z = statics.start.z.copy()
            z[own] = value
            there = statics.settled(place.with_z(z))
            at = statics.at(there)
            return float(abs(at.forces[own, 0]) - np.abs(at.by_friction[own, :, 0]).sum()), there

        def end(place: Places, sense: float, last: float) -> float:
            value, step = float(place.z[own, 0]), SAME * statics.sizes[own]
            while value != last:
                further = sense * min(sense * (value + sense * step), sense * last)
                excess, there = over(place, further)
                if not excess <= 0.0:
                    break
                value, place, step = further, there, min(WIDENED * step, grid)
            else:
                return value
            for _ in range(NARROWED):
                middle = 0.5 * (value + further)
                excess, there = over(place, middle)
                value, further = (middle, further) if excess <= 0.0 else (value, middle)
                place = there if excess <= 0.0 else place
            return value

        nearest = np.argsort(np.abs(starts.z[own] - statics.start.z[own]), kind="stable")
        places = [*(each.place for each in smooth), *(starts.at([int(k)]) for k in nearest)]
        result: list[Rest] = []
        known: list[tuple[tuple[float, ...], float, float]] = []
        for place in places:
            value = float(place.z[own, 0])
            side = tuple(place.branch[len(statics.system.topology.carried) :, 0])
            if any(s == side and a <= value <= b for s, a, b in known):
                continue
            excess, there = over(place, value)
            if not excess <= 0.0:
                continue
            reach = limits.get(side, [value])
            ends = end(there, -1.0, min(*reach, value)), end(there, 1.0, max(*reach, value))
            known.append((side, *ends))
            if ends == (min(reach), max(reach)):
                self.notes.append("friction holds the mechanism everywhere within reach")
            interval = np.repeat(statics.start.z, 2, axis=1)
            interval[own] = ends
            at = statics.at(there)
            most = at.by_friction[own, :, 0]
            total = np.abs(most).sum()
            part = -at.forces[own, 0] / total if total else 0.0
            result.append(Rest(there, part * np.sign(most), interval=interval))
        return result

    def _bounds(self, balance: Balance, middle: Floats) -> tuple[Floats, Floats]:
        """Of unknowns: coordinates within reach of a position, contacts push, −1 ≤ σ ≤ 1."""
        count = len(balance.rows)
        low, high = np.full(len(middle), -1.0), np.ones(len(middle))
        reach = np.full(count, np.inf)
        reach[: len(self.statics.own)] = self.statics.reaches[self.statics.own]
        reach /= balance.units[:count]
        low[:count], high[:count] = middle[:count] - reach, middle[:count] + reach
        adhesions = self.statics.adhesions[[*balance.closed]]
        low[count : balance.count] = -adhesions / balance.units[count : balance.count]
        high[count : balance.count] = np.inf
        return low, high

    def _members(self) -> list[Rest]:
        """Positions that friction holds, the nearest ones to some starts."""
        from scipy.optimize import least_squares

        starts, result = self.starts, []
        for closed in self._contacts():
            balance = Balance(self.statics, closed)
            count = len(balance.rows)
            for k in range(min(MEMBERS, starts.count)):
                near = starts.at([k])
                w = balance.unknowns_at(near)[:, 0]
                w[count : balance.count] = 1e-3
                low, high = self._bounds(balance, w)
                if not np.isfinite(balance.at(w[:, None], near)[0]).all():
                    continue

                def of(w: Floats, which: int, own: Balance = balance, at: Places = near) -> Floats:
                    return np.nan_to_num(own.at(w[:, None], at)[which][0], nan=1e6)

                best = least_squares(
                    lambda w, of=of: of(w, 0), w, jac=lambda w, of=of: of(w, 1),
                    bounds=(low, high), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=100,
                )  # fmt: skip
                if np.abs(best.fun).max() < BALANCED:
                    own = balance.rest(best.x, near)
                    if self._allowed(balance, own):
                        result.append(own)
        return result

    def _extent(self, balance: Balance, rest: Rest) -> Floats:
        """The least and the largest value of each coordinate that friction holds, (n + m, 2)."""
        from scipy.optimize import minimize

        near, points = rest.place, [balance.unknowns(rest)]
        bounds = [*zip(*self._bounds(balance, points[0]), strict=True)]
        equal = {
            "type": "eq",
            "fun": lambda w: balance.at(w[:, None], near)[0][0],
            "jac": lambda w: balance.at(w[:, None], near)[1][0],
        }
        # from a position that is symmetric, another one that is held may be the better start
        for place in [*range(len(balance.rows))] * (2 if len(balance.rows) > 1 else 1):
            for sense in (1.0, -1.0):
                slope = np.zeros(len(points[0]))
                slope[place] = sense
                best = minimize(
                    lambda w, slope=slope: slope @ w, min(points, key=lambda w: slope @ w),
                    jac=lambda _, slope=slope: slope, method="SLSQP", bounds=bounds,
                    constraints=[equal], options={"ftol": 1e-14, "maxiter": 200},
                )  # fmt: skip
                w = best.x
                most = w[balance.count :]
                most[:] = np.where(np.abs(most) > EDGE, np.sign(most), most)
                solved, _, good = balance.solved(w[:, None], near)
                if good[0]:
                    points.append(solved[:, 0])
                else:
                    self.notes.append("an end of an interval that friction holds was not found")
        result = np.repeat(rest.z[:, None], 2, axis=1)
        each = np.array(points)[:, : len(balance.rows)] * balance.units[: len(balance.rows)]
        result[balance.rows] = np.stack([each.min(axis=0), each.max(axis=0)], axis=1)
        return result


def solved_numbers(
    statics: Statics, paths: Sequence[str], wanted: dict[int, float]
) -> dict[str, float]:
    """Values of numbers of the definition for which wanted coordinates are an equilibrium.

    `paths`: as many as coordinates are wanted; `wanted`: place in `statics.own` → value in SI.
    Raises ComputationError if Newton's method finds none.
    """
    balance = Balance(statics, ())
    mechanism = statics.released
    numbers = numbers_of(mechanism, paths)
    varying = Varying(mechanism)
    system = varying.at({})
    values = np.array([value_of(mechanism, number) for number in numbers])
    units = np.where(values == 0.0, 1.0, np.abs(values))
    kept = [k for k in range(len(balance.rows)) if k not in wanted]
    near = statics.start
    for k, value in wanted.items():
        near.z[statics.own[k]] = value
    w = balance.unknowns_at(near)
    for _ in range(MOST):
        statics.take(system)
        near = statics.settled(balance.placed(w, near))
        found = effects(system, numbers)
        residual, slopes = balance.at(w, near)
        moved = statics.along(found, near)[balance.rows] / balance.scales[:, None]
        matrix = np.hstack([slopes[0][:, kept], moved * units])
        if not np.isfinite(matrix).all() or not np.isfinite(residual).all():
            break
        step = -_least(matrix[None], residual)[0]
        longest = float(np.abs(step).max())
        step *= min(1.0, LONGEST / max(longest, 1e-300))
        if longest < 1e-13 and np.abs(residual).max() < BALANCED:
            break
        w[kept, 0] += step[: len(kept)]
        values = values + step[len(kept) :] * units
        system = varying.at(dict(zip(paths, values.tolist(), strict=True)))
    if not np.abs(residual).max() < BALANCED:
        raise ComputationError(
            f"no value of {', '.join(paths)} was found for which this position is an equilibrium; "
            "start from values that are nearer, with --set",
            time=statics.time,
        )
    return dict(zip(paths, values.tolist(), strict=True))
