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

from linkages.equilibria.statics import Statics
from linkages.errors import ComputationError
from linkages.kernel.number_effects import effects, numbers_of
from linkages.kernel.scalars import components
from linkages.kernel.varying import Varying

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

STEPS = 40
"""Along a ray from the start on which positions that can be reached are looked for."""

MOST = 60
"""Steps of Newton's method."""

LONGEST = 0.5
"""Sizes of a coordinate that a step is long at most."""

HALVINGS = 6

GROWTH = 1.2
"""By which the imbalance may grow in a step that is not shortened."""

BALANCED = 1e-10
"""Imbalance of an equilibrium, in sizes of its forces; round-off leaves 1e-15."""

SINGULAR = 1e-12
"""Part of the largest singular value of the stiffness below which a direction is neutral."""

SAME = 1e-6
"""Sizes of coordinates by which two equilibria differ at least."""

BETWEEN = (0.2639, 0.7361)
"""Parts of the way between two equilibria that are equilibria as well where they are a family."""

MOST_CONTACTS = 256
"""Sets of contacts that are tried."""

PULLS = 1e-9
"""Part of the size of forces by which a contact may pull: round-off."""

NARROWED = 80
"""Halvings by which the end of an interval is found."""

WIDENED = 1.5
"""By which steps outwards from an equilibrium grow until friction does not hold any more."""

MEMBERS = 12
"""Starts from which sets that friction holds are looked for where no other force balances."""


@dataclass(frozen=True, eq=False)
class Rest:
    """A position in which a mechanism can rest."""

    z: Floats  # coordinates, then internal states, shape (n + m,)
    carried: Floats | None  # coordinates from which iterations start, shape (c,)
    sigma: Floats  # how much of the largest force of each dry friction acts, shape (frictions,)
    pressed: dict[int, float] = field(default_factory=dict)  # rigid contact → its force
    rubbed: dict[int, float] = field(default_factory=dict)  # rough contact that presses → its σ
    neutral: int = 0  # directions in which neighbours are equilibria as well
    interval: Floats | None = None  # ends of what dry friction holds, shape (n + m, 2)


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
        motion = statics.motions(statics.start[:, None])
        gaps = statics.values(sizes, motion)[:, 0] if sizes else np.zeros(0)
        forces = statics.force_sizes.copy()
        forces[:n][forces[:n] == 0.0] = 1.0
        energy = float((forces[:n] * statics.sizes[:n]).max())
        self.gap_sizes = gaps
        self.units = np.concatenate([statics.sizes[self.rows], energy / gaps[self.closed]])
        self.scales = np.concatenate([forces[self.rows], gaps[self.closed]])
        self.rough = [k for k in self.closed if statics.nodes.slips[k] is not None]
        self.count = len(self.units)
        self.frictions = len(statics.nodes.sticky)

    def whole(self, w: Floats) -> Floats:
        """Coordinates of w with those that drives hold, and internal states, shape (n + m, N)."""
        result = np.repeat(self.statics.start[:, None], w.shape[1], axis=1)
        count = len(self.rows)
        result[self.rows] = w[:count] * self.units[:count, None]
        return result

    def at(self, w: Floats, carried: Floats | None) -> tuple[Floats, Floats]:
        """Imbalance and its derivatives, shapes (N, equations) and (N, equations, unknowns)."""
        rows, own, count = self.rows, self.statics.own, len(self.rows)
        forces = w[count : self.count] * self.units[count:, None]
        sigma = w[self.count : self.count + self.frictions]
        rubbed = dict(zip(self.rough, w[self.count + self.frictions :], strict=True))
        at = self.statics.at(self.whole(w), sigma, carried)
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

    def padded(self, w: Floats) -> Floats:
        """Unknowns with all frictions at zero, shape (…, N)."""
        more = self.frictions + len(self.rough)
        return np.concatenate([w, np.zeros((more, w.shape[1]))])

    def solved(self, w: Floats, carried: Floats | None) -> tuple[Floats, Floats | None, Flags]:
        """Newton's method from many starts; frictions stay; which of them have converged."""
        count, w = self.count, w.copy()
        residual, slopes = self.at(w, carried)
        step = np.full((count, w.shape[1]), np.inf)
        for _ in range(MOST):
            sound = np.isfinite(residual).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2))
            going = sound & (np.abs(step).max(axis=0) > 1e-15)
            if not going.any():
                break
            step = np.zeros_like(step)
            inverse = np.linalg.pinv(slopes[going][:, :, :count], rcond=SINGULAR)
            step[:, going] = -(inverse @ residual[going][..., None])[..., 0].T
            longest = np.abs(step).max(axis=0)
            step *= np.minimum(1.0, LONGEST / np.maximum(longest, 1e-300))
            before = np.linalg.norm(residual, axis=1)
            short = np.ones(w.shape[1])
            for _halving in range(HALVINGS):
                moved = w.copy()
                moved[:count] += short * step
                there = self.statics.settled(self.whole(moved), carried)
                residual, slopes = self.at(moved, there)
                size = np.linalg.norm(residual, axis=1)
                worse = going & ~(size <= np.maximum(GROWTH * before, BALANCED))
                if not worse.any():
                    break
                short[worse] *= 0.5
            w, carried = moved, there
        with np.errstate(invalid="ignore"):
            balanced = np.abs(residual).max(axis=1) < BALANCED
        return w, carried, balanced

    def neutral(self, slopes: Floats) -> int:
        """Number of directions in which the imbalance does not change."""
        sizes = np.linalg.svd(slopes[:, : self.count], compute_uv=False)
        return int((sizes <= 1e-9 * max(sizes[0], 1e-9)).sum())

    def rest(self, w: Floats, carried: Floats | None) -> Rest:
        """The position of one solution, shape (unknowns,)."""
        count, place = len(self.rows), self.count
        z = self.whole(w[:, None])[:, 0]
        turns = np.where(self.statics.turning, np.round(z / (2 * np.pi)), 0.0)
        turns[self.statics.held] = 0.0
        forces = (w[count:place] * self.units[count:]).tolist()
        _, slopes = self.at(w[:, None], None if carried is None else carried[:, None])
        return Rest(
            z=z - 2 * np.pi * turns,
            carried=carried,
            sigma=w[place : place + self.frictions],
            pressed=dict(zip(self.closed, forces, strict=True)),
            rubbed=dict(zip(self.rough, w[place + self.frictions :].tolist(), strict=True)),
            neutral=self.neutral(slopes[0]),
        )

    def unknowns(self, rest: Rest) -> Floats:
        """The opposite of `rest`, shape (unknowns,)."""
        forces = [rest.pressed[k] for k in self.closed]
        own = np.concatenate([rest.z[self.rows], forces]) / self.units
        return np.concatenate([own, rest.sigma, [rest.rubbed[k] for k in self.rough]])


class Search:
    """All equilibria that are found from many positions within reach.

    `count`: of positions; `seed`: of their directions.
    """

    def __init__(self, statics: Statics, count: int, seed: int) -> None:
        self.statics, self._count, self._seed = statics, count, seed
        self.notes: list[str] = []

    @cached_property
    def starts(self) -> tuple[Floats, Floats | None]:
        """Positions that can be reached on straight lines from the start, which is the first."""
        statics = self.statics
        z, carried = self._held()
        own, reach = statics.own, statics.reaches
        random = np.random.default_rng(self._seed)
        if len(own) == 1:
            rays = np.array([[1.0, -1.0]])
            steps = max(STEPS, -(-self._count // 2))
        else:
            rays, steps = random.normal(size=(len(own), self._count)), STEPS
            rays /= np.abs(rays).max(axis=0)
        here = np.repeat(z, rays.shape[1], axis=1)
        near = None if carried is None else np.repeat(carried, rays.shape[1], axis=1)
        places = [(here, near, np.ones(rays.shape[1], dtype=bool))]
        alive = places[0][2]
        for k in range(1, steps + 1):
            moved = here.copy()
            moved[own] += k / steps * rays * reach[own, None]
            near = statics.settled(moved, near)
            alive = alive & self._assembled(moved, near)
            if not alive.any():
                break
            places.append((moved, near, alive))
        if len(own) == 1:
            chosen = [(k, ray) for k, (_, _, ok) in enumerate(places) for ray in np.flatnonzero(ok)]
        else:
            last = np.sum([ok for _, _, ok in places], axis=0)
            drawn = (random.random(rays.shape[1]) * last).astype(int)
            chosen = [(0, 0), *enumerate_pairs(drawn)]
        points = np.stack([places[k][0][:, ray] for k, ray in chosen], axis=1)
        if carried is None:
            return points, None
        return points, np.stack([places[k][1][:, ray] for k, ray in chosen], axis=1)  # type: ignore[index]

    def _held(self) -> tuple[Floats, Floats | None]:
        """The position of the definition with drives at their time, moved there step by step."""
        statics = self.statics
        system, start = statics.system, statics.start.copy()
        first = start.copy()
        first[statics.held] = system.state[statics.held]
        carried = statics.settled(first[:, None], None)
        steps = 1 + int(np.abs(start - first).max(initial=0.0) / 0.3) if carried is not None else 1
        for k in range(1, steps + 1):
            here = first + k / steps * (start - first)
            carried = statics.settled(here[:, None], carried)
        if not self._assembled(start[:, None], carried).all():
            raise ComputationError(
                f"the mechanism cannot be assembled with its drives at t = {statics.time:g} s and "
                "its free coordinates as the definition has them; give others in 'free'",
                time=statics.time,
            )
        return start[:, None], carried

    def _assembled(self, z: Floats, carried: Floats | None) -> Flags:
        statics = self.statics
        nodes = [*components(statics.model.positions.joints.values()), *statics.nodes.coordinates]
        values = statics.values(nodes, statics.motions(z, carried))
        return np.asarray(np.isfinite(values).all(axis=0))

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
        z, carried = self.starts
        return bool((np.abs(np.nan_to_num(self.statics.at(z, None, carried).by_friction)) > 0).any())

    def _frictionless(self, balance: Balance) -> list[Rest]:
        z, carried = self.starts
        w = np.zeros((balance.count, z.shape[1]))
        w[: len(balance.rows)] = z[balance.rows] / balance.units[: len(balance.rows), None]
        w, carried, good = balance.solved(balance.padded(w), carried)
        result: list[Rest] = []
        for k in np.flatnonzero(good):
            each = balance.rest(w[:, k], None if carried is None else carried[:, k])
            if not any(self._same(balance, each, other) for other in result):
                result.append(each)
        return result

    def _same(self, balance: Balance, one: Rest, other: Rest) -> bool:
        """Whether two equilibria are one, or belong to one family."""
        rows = balance.rows
        apart = one.z - other.z
        apart -= np.where(self.statics.turning, 2 * np.pi * np.round(apart / (2 * np.pi)), 0.0)
        if (np.abs(apart[rows]) < SAME * self.statics.sizes[rows]).all():
            return True
        if not (one.neutral and other.neutral):
            return False
        first, last = balance.unknowns(replace(other, z=one.z - apart)), balance.unknowns(one)
        between = np.stack([first + part * (last - first) for part in BETWEEN], axis=1)
        carried = None if one.carried is None else np.repeat(one.carried[:, None], 2, axis=1)
        residual, _ = balance.at(between, carried)
        return bool(np.abs(residual).max() < BALANCED)

    def _allowed(self, balance: Balance, rest: Rest) -> bool:
        """Whether contacts push, and all others are open."""
        if any(force < -PULLS * balance.units[-1] for force in rest.pressed.values()):
            return False
        z = rest.z[:, None]
        gaps = self.statics.at(z, None, None if rest.carried is None else rest.carried[:, None])
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
        z, carried = self.starts
        order = np.argsort(z[own])
        grid = float(np.diff(z[own][order]).max(initial=SAME * statics.sizes[own]))
        low, high = z[own][order[[0, -1]]]

        def over(value: float, near: Floats | None) -> tuple[float, Floats | None]:
            """By how much the force is larger than all frictions; and where iterations start."""
            place = statics.start[:, None].copy()
            place[own] = value
            near = statics.settled(place, near)
            at = statics.at(place, None, near)
            return float(abs(at.forces[own, 0]) - np.abs(at.by_friction[own, :, 0]).sum()), near

        def end(value: float, near: Floats | None, sense: float) -> float:
            step = SAME * statics.sizes[own]
            while True:
                further = min(max(value + sense * step, low), high)
                excess, there = over(further, near)
                if not excess <= 0.0:
                    break
                value, near, step = further, there, min(WIDENED * step, grid)
                if value in (low, high):
                    return value
            for _ in range(NARROWED):
                middle = 0.5 * (value + further)
                excess, there = over(middle, near)
                value, further = (middle, further) if excess <= 0.0 else (value, middle)
                near = there if excess <= 0.0 else near
            return value

        places = [(float(each.z[own]), each.carried) for each in smooth]
        nearest = np.argsort(np.abs(z[own] - statics.start[own]), kind="stable")
        places += [(float(z[own, k]), None if carried is None else carried[:, k]) for k in nearest]
        result: list[Rest] = []
        for value, started in places:
            near = None if started is None else started[:, None]
            known = (rest.interval[own] for rest in result if rest.interval is not None)
            if any(a <= value <= b for a, b in known) or not over(value, near)[0] <= 0.0:
                continue
            ends = end(value, near, -1.0), end(value, near, 1.0)
            if ends[0] == low and ends[1] == high:
                self.notes.append("friction holds the mechanism everywhere within reach")
            interval = np.repeat(statics.start[:, None], 2, axis=1)
            interval[own] = ends
            place = statics.start.copy()
            place[own] = value
            there = statics.settled(place[:, None], near)
            at = statics.at(place[:, None], None, there)
            most = at.by_friction[own, :, 0]
            total = np.abs(most).sum()
            part = -at.forces[own, 0] / total if total else 0.0
            carries = None if there is None else there[:, 0]
            result.append(Rest(place, carries, part * np.sign(most), interval=interval))
        return result

    def _bounds(self, balance: Balance, middle: Floats) -> tuple[Floats, Floats]:
        """Of unknowns: coordinates within reach of a position, contacts push, −1 ≤ σ ≤ 1."""
        count = len(balance.rows)
        low, high = np.full(len(middle), -1.0), np.ones(len(middle))
        reach = np.full(count, np.inf)
        reach[: len(self.statics.own)] = self.statics.reaches[self.statics.own]
        reach /= balance.units[:count]
        low[:count], high[:count] = middle[:count] - reach, middle[:count] + reach
        low[count : balance.count], high[count : balance.count] = 0.0, np.inf
        return low, high

    def _members(self) -> list[Rest]:
        """Positions that friction holds, the nearest ones to some starts."""
        from scipy.optimize import least_squares

        z, carried = self.starts
        result = []
        for closed in self._contacts():
            balance = Balance(self.statics, closed)
            count = len(balance.rows)
            for k in range(min(MEMBERS, z.shape[1])):
                near = None if carried is None else carried[:, k : k + 1]
                w = balance.padded(np.zeros((balance.count, 1)))[:, 0]
                w[:count] = z[balance.rows, k] / balance.units[:count]
                w[count : balance.count] = 1e-3
                low, high = self._bounds(balance, w)
                if not np.isfinite(balance.at(w[:, None], near)[0]).all():
                    continue

                def of(w: Floats, which: int, own: Balance = balance, near=near) -> Floats:  # type: ignore[no-untyped-def]
                    return np.nan_to_num(own.at(w[:, None], near)[which][0], nan=1e6)

                best = least_squares(
                    lambda w, of=of: of(w, 0), w, jac=lambda w, of=of: of(w, 1),
                    bounds=(low, high), xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=100,
                )  # fmt: skip
                if np.abs(best.fun).max() < BALANCED:
                    own = balance.rest(best.x, None if near is None else near[:, 0])
                    if self._allowed(balance, own):
                        result.append(own)
        return result

    def _extent(self, balance: Balance, rest: Rest) -> Floats:
        """The least and the largest value of each coordinate that friction holds, (n + m, 2)."""
        from scipy.optimize import minimize

        middle = balance.unknowns(rest)
        low, high = self._bounds(balance, middle)
        near = None if rest.carried is None else rest.carried[:, None]
        result = np.repeat(rest.z[:, None], 2, axis=1)
        equal = {
            "type": "eq",
            "fun": lambda w: balance.at(w[:, None], near)[0][0],
            "jac": lambda w: balance.at(w[:, None], near)[1][0],
        }
        for place, row in enumerate(balance.rows):
            for side, sense in enumerate((1.0, -1.0)):
                slope = np.zeros(len(middle))
                slope[place] = sense
                best = minimize(
                    lambda w, slope=slope: slope @ w, middle, jac=lambda _, slope=slope: slope,
                    method="SLSQP", bounds=[*zip(low, high, strict=True)], constraints=[equal],
                    options={"ftol": 1e-14, "maxiter": 200},
                )  # fmt: skip
                w = best.x
                edge = np.abs(w[balance.count :]) > 1 - 1e-6
                w[balance.count :][edge] = np.sign(w[balance.count :][edge])
                solved, _, good = balance.solved(w[:, None], near)
                sound = np.abs(equal["fun"](w)).max() < 1e-6
                chosen = solved[:, 0] if good[0] and edge.all() else w
                if good[0] or sound:
                    result[row, side] = self.statics.sizes[row] * chosen[place]
                else:
                    self.notes.append("an end of an interval that friction holds was not found")
        return np.sort(result, axis=1)


def enumerate_pairs(drawn: NDArray[np.int_]) -> list[tuple[int, int]]:
    """Step and ray of what is drawn on each ray."""
    return [(int(k), ray) for ray, k in enumerate(drawn)]


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
    from linkages.kernel.number_effects import value_of

    values = np.array([value_of(mechanism, number) for number in numbers])
    units = np.where(values == 0.0, 1.0, np.abs(values))
    kept = [k for k in range(len(balance.rows)) if k not in wanted]
    z = statics.start.copy()
    for k, value in wanted.items():
        z[statics.own[k]] = value
    w = z[balance.rows] / balance.units
    carried = None
    for _ in range(MOST):
        statics.take(system)
        place = balance.whole(w[:, None])
        carried = statics.settled(place, carried)
        found = effects(system, numbers)
        residual, slopes = balance.at(balance.padded(w[:, None]), carried)
        moved = statics.along(found, place[:, 0], carried)[balance.rows] / balance.scales[:, None]
        matrix = np.hstack([slopes[0][:, kept], moved * units])
        if not np.isfinite(matrix).all() or not np.isfinite(residual).all():
            break
        step = -np.linalg.pinv(matrix, rcond=SINGULAR) @ residual[0]
        longest = float(np.abs(step).max())
        step *= min(1.0, LONGEST / max(longest, 1e-300))
        if longest < 1e-13 and np.abs(residual).max() < BALANCED:
            break
        w[kept] += step[: len(kept)]
        values = values + step[len(kept) :] * units
        system = varying.at(dict(zip(paths, values.tolist(), strict=True)))
    if not np.abs(residual).max() < BALANCED:
        raise ComputationError(
            f"no value of {', '.join(paths)} was found for which this position is an equilibrium; "
            "start from values that are nearer, with --set",
            time=statics.time,
        )
    return dict(zip(paths, values.tolist(), strict=True))
