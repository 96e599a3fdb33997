"""Vibration about a position: the linear equations without massless and held directions.

M δa + C δv + K δq − H δs = B u with C = −∂F/∂v, K = −∂F/∂q of the equations with their contacts,
and dδs/dt = P δq + Q δv + R δs. Contacts that press and frictions that hold take directions away.
Directions without mass obey equations of first order where they are damped, and follow the others
without delay where they are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from linkages.equilibria.resting import Rest
from linkages.equilibria.statics import Statics
from linkages.errors import ComputationError

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

MASSLESS = 1e-12
"""Part of the largest inertia below which a direction has none, in scaled coordinates."""

UNDAMPED = 1e-12
"""Part of the size of a matrix that is round-off."""

ON_AXIS = 1e-7
"""Part of the magnitude, and of the largest one, by which eigenvalues are off the imaginary axis:
where two coincide, their errors are the root of round-off."""

SKEW = 1e-9
"""Part of the rates' forces that is gyroscopic where they are to be named so."""


@dataclass(frozen=True, eq=False)
class LinearModel:
    """dx/dt = A x + B u, and what follows from x and u.

    Deviations of everything are δq = T_q x + D_q u, δv = T_v x + D_v u, δa = T_a x + D_a u, and
    δs = T_s x.
    """

    a: Floats  # shape (states, states)
    b: Floats  # shape (states, inputs)
    names: tuple[str, ...]  # of states, such as rod.angle and rod.speed
    units: tuple[str, ...]
    # Of coordinates, rates and accelerations, shape (n, states + inputs). Those of massless
    # directions may also follow the rates of inputs: `jumps` (2, n, inputs) is 0 where not
    coordinates: Floats
    rates: Floats
    accelerations: Floats
    internal: Floats
    jumps: Floats
    driven: tuple[int, ...]  # which states are values and rates of drives
    inertia: Floats  # M of directions that are not held, shape (free, free)
    damping: Floats  # C of the same
    stiffness: Floats  # K of the same
    free: Floats  # these directions, with those of drives behind them, shape (n, free + drives)
    massless: int  # directions without mass
    stuck: int  # directions that contacts and friction take away


@dataclass(frozen=True, eq=False)
class VibrationMode:
    """A vibration mode: a pair of eigenvalues, or a real one."""

    eigenvalue: complex  # in 1/s, the one of a pair with the positive imaginary part
    frequency: float  # in Hz: |eigenvalue|/2π of a pair, 0 of a real one
    damping_ratio: float
    kind: str
    shape: Complex  # of all coordinates, shape (n,)


def directions(
    statics: Statics, rest: Rest, sticking: Floats, drives: Sequence[int]
) -> tuple[Floats, NDArray[np.int_]]:
    """Directions that nothing holds, as columns, and the coordinates that are their parameters.

    `sticking`: derivatives of slip rates by rates, shape (frictions, n).
    `drives`: rows of coordinates that move as given; their directions come last.
    Returns: shapes (n, free + drives) and (free,).
    """
    from scipy.linalg import qr

    at = statics.at(rest.place, rest.sigma[:, None])
    rows = [at.normals[k][:, 0] for k in rest.pressed]
    rows += [at.slips[k][:, 0] for k in rest.rubbed]
    most = np.abs(at.by_friction[: statics.n, :, 0]).max(axis=0, initial=0.0)
    rows += [row for row, force in zip(sticking, most, strict=True) if force > 0.0 and row.any()]
    own, sizes = statics.own, statics.sizes[: statics.n]
    given = [*drives]
    # a matrix without rows has no factors in SciPy 1.13
    scaled = np.array(rows or [np.zeros(statics.n)]) * sizes
    scaled /= np.maximum(np.abs(scaled).max(axis=1, keepdims=True, initial=0.0), 1e-300)
    _, triangle, order = qr(scaled[:, own], mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    rank = int((diagonal > 1e-10 * max(diagonal.max(initial=0.0), 1e-300)).sum())
    held, free = own[order[:rank]], own[np.sort(order[rank:])]
    moving = np.array([*free, *given], dtype=int)
    result = np.zeros((statics.n, len(moving)))
    result[moving] = np.eye(len(moving))
    if rank:
        follow = -np.linalg.lstsq(scaled[:, held], scaled[:, moving], rcond=None)[0]
        result[held] = follow * sizes[held][:, None] / sizes[moving]
    return result, free


def linear_model(
    statics: Statics,
    rest: Rest,
    inputs: Floats,
    accelerated: Sequence[int] = (),
    rates: Floats | None = None,
    accelerations: Floats | None = None,
) -> LinearModel:
    """The linear model about a position.

    `inputs`: generalised forces on all coordinates for a unit of each input, shape (n, inputs).
    `accelerated`: rows of coordinates of drives whose accelerations are further inputs, behind the
    others; their values and rates are further states.
    `rates`, `accelerations`: of a motion, shape (n,); at rest if not given.
    Raises ComputationError if neither mass, damping nor stiffness determines a direction.
    """
    n, m = statics.n, statics.m
    given = [None if each is None else each[:, None] for each in (rates, accelerations)]
    linear = statics.linearised(rest.place, rest.sigma[:, None], *given)
    stiffness = -linear.by_coordinates[:n] + _bent(statics, rest)
    drives = list(accelerated)
    # what slides in a motion holds nothing
    sticking = linear.sticking if rates is None else 0.0 * linear.sticking
    basis, parameters = directions(statics, rest, sticking, drives)
    free = len(parameters)
    scale = statics.sizes[parameters]

    def projected(matrix: Floats) -> Floats:
        return basis.T @ matrix @ basis

    inertia, k = projected(linear.inertia), projected(stiffness)
    c = projected(-linear.by_rates[:n])
    massive, light = _split(inertia[:free, :free], scale)
    damped, loose = _damped(c[:free, :free], light, scale)
    whole = np.zeros((free + len(drives), free + len(drives)))
    groups = [massive, damped, loose]
    whole[:free, :free] = np.hstack(groups)
    whole[free:, free:] = np.eye(len(drives))
    counts = [part.shape[1] for part in groups]
    inertia, k, c = (whole.T @ matrix @ whole for matrix in (inertia, k, c))
    turn = basis @ whole
    h = turn.T @ linear.by_internal[:n]
    force = turn.T @ inputs
    p, q = linear.by_coordinates[n:] @ turn, linear.by_rates[n:] @ turn
    r = linear.by_internal[n:]
    ends = np.cumsum([*counts, len(drives)])
    a_, b_, l_, d_ = (np.arange(*pair) for pair in zip([0, *ends[:-1]], ends, strict=True))
    _require_regular(statics, k, c, q, (a_, b_, l_, d_), basis, whole, scale)

    # states: values of a, b, d; rates of a, d; internal states; all else follows from them and u
    many = inputs.shape[1] + len(drives)
    size = 2 * len(a_) + len(b_) + 2 * len(d_) + m
    width = size + many
    total = free + len(drives)
    unit = np.eye(size, width)
    values, speeds, pushes = (np.zeros((total, width)) for _ in range(3))
    values[[*a_, *b_, *d_]] = unit[: len(a_) + len(b_) + len(d_)]
    at = len(a_) + len(b_) + len(d_)
    speeds[[*a_, *d_]] = unit[at : at + len(a_) + len(d_)]
    inner = unit[size - m : size]
    applied = np.zeros((total, width))
    applied[:, size : size + inputs.shape[1]] = force
    driven = np.zeros((len(d_), width))
    driven[:, size + inputs.shape[1] :] = np.eye(len(d_))
    pushes[d_] = driven
    balance = applied + h @ inner
    if len(l_):
        right = balance[l_] - (k @ values)[l_] - (c @ speeds)[l_]
        right -= inertia[np.ix_(l_, d_)] @ driven
        values[l_] = np.linalg.solve(k[np.ix_(l_, l_)], right)
    if len(b_):
        right = balance[b_] - (k @ values)[b_] - (c @ speeds)[b_]
        right -= inertia[np.ix_(b_, d_)] @ driven
        speeds[b_] = np.linalg.solve(c[np.ix_(b_, b_)], right)
    right = balance[a_] - (k @ values)[a_] - (c @ speeds)[a_] - inertia[np.ix_(a_, d_)] @ driven
    pushes[a_] = np.linalg.solve(inertia[np.ix_(a_, a_)], right)
    changes = p @ values + q @ speeds + r @ inner
    derivatives = np.vstack([speeds[[*a_, *b_, *d_]], pushes[[*a_, *d_]], changes])
    a, b = derivatives[:, :size], derivatives[:, size:]

    # what follows from states and inputs alone has rates that follow from the rates of inputs
    jumps = np.zeros((2, total, many))
    if len(l_):
        speeds[l_], jumps[0, l_] = values[l_, :size] @ derivatives, values[l_, size:]
    for rows in (b_, l_):
        pushes[rows] = speeds[rows, :size] @ derivatives
        jumps[1, rows] = np.abs(speeds[rows, size:]) + np.abs(jumps[0, rows])
    names, units = _named(statics, turn, (a_, b_, d_))
    return LinearModel(
        a=a, b=b, names=names, units=units, coordinates=turn @ values, rates=turn @ speeds,
        accelerations=turn @ pushes, internal=inner, jumps=np.abs(turn) @ np.abs(jumps),
        driven=(*range(at - len(d_), at), *range(at + len(a_), at + len(a_) + len(d_))),
        inertia=inertia[:free, :free], damping=c[:free, :free], stiffness=k[:free, :free],
        free=turn, massless=counts[1] + counts[2], stuck=len(statics.own) - free,
    )  # fmt: skip


def no_model(n: int, m: int, inputs: int) -> LinearModel:
    """A linear model without states, of what is not determined: it says nothing (nan)."""
    unknown, none = np.full((n, inputs), np.nan), np.zeros((0, 0))
    return LinearModel(
        a=none, b=np.zeros((0, inputs)), names=(), units=(), coordinates=unknown, rates=unknown,
        accelerations=unknown, internal=np.full((m, inputs), np.nan),
        jumps=np.zeros((2, n, inputs)), driven=(), inertia=none, damping=none, stiffness=none,
        free=np.zeros((n, 0)), massless=0, stuck=0,
    )  # fmt: skip


def _bent(statics: Statics, rest: Rest) -> Floats:
    """What forces of contacts add to the stiffness, as their directions turn, shape (n, n)."""
    result = np.zeros((statics.n, statics.n))
    if not rest.pressed:
        return result
    at = statics.at(rest.place, rest.sigma[:, None])
    for number, force in rest.pressed.items():
        part = rest.rubbed.get(number, 0.0)
        result += force * (at.bends[number] - part * at.slip_bends[number])[..., 0]
    return result


def _split(inertia: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """Directions with and without mass: the latter as they are, the former some coordinates."""
    scaled = inertia * scale * scale[:, None]
    size = len(scaled)
    if not size:
        return np.zeros((0, 0)), np.zeros((0, 0))
    # each direction in the measure of its own inertia, so that a light body is not a massless one
    diagonal = np.diag(scaled)
    nothing = diagonal <= MASSLESS**2 * diagonal.max(initial=0.0)
    measure = 1.0 / np.sqrt(np.where(nothing, 1.0, diagonal))
    values, vectors = np.linalg.eigh(scaled * measure * measure[:, None])
    light = vectors[:, values <= MASSLESS * max(1.0, values.max())]
    if not light.shape[1]:
        return np.eye(size), np.zeros((size, 0))
    light = light * measure[:, None] * scale[:, None]
    from scipy.linalg import qr

    _, _, order = qr((light / scale[:, None]).T, pivoting=True)
    chosen, others = np.sort(order[: light.shape[1]]), np.sort(order[light.shape[1] :])
    light = light @ np.linalg.inv(light[chosen])
    light[np.abs(light) < 1e-14] = 0.0
    return np.eye(size)[:, others], light


def _damped(damping: Floats, light: Floats, scale: Floats) -> tuple[Floats, Floats]:
    """Massless directions with and without damping."""
    if not light.shape[1]:
        return light, light
    own = light.T @ damping @ light
    sizes = np.abs(light / scale[:, None]).max(axis=0)
    left, values, _ = np.linalg.svd(own / sizes / sizes[:, None])
    whole = np.abs(damping * scale * scale[:, None]).max(initial=0.0)
    loose = values <= UNDAMPED * whole if whole else np.ones(len(values), dtype=bool)
    if loose.all():
        return light[:, :0], light
    if not loose.any():
        return light, light[:, :0]
    turned = light @ (left / sizes[:, None])
    return turned[:, ~loose], turned[:, loose]


def _require_regular(
    statics: Statics,
    k: Floats,
    c: Floats,
    q: Floats,
    groups: tuple[NDArray[np.int_], ...],
    basis: Floats,
    whole: Floats,
    scale: Floats,
) -> None:
    """Refuse massless directions that nothing determines, or whose rates act on others."""
    loose = groups[2]
    if not len(loose):
        return
    turned = basis @ whole
    sizes = np.abs(turned[:, loose] / statics.sizes[: statics.n, None]).max(axis=0)
    weights = scale.max(initial=1.0)
    own = k[np.ix_(loose, loose)] / sizes / sizes[:, None]
    others = np.abs(k).max(initial=0.0) * weights**2
    values, vectors = np.linalg.eig(own)
    idle = np.abs(values) <= UNDAMPED * max(others, np.abs(own).max(initial=0.0), 1e-300)
    free = statics.system.topology.free
    if idle.any():
        moved = np.abs(turned[:, loose] @ (vectors[:, idle][:, 0] / sizes))
        names = [free[row] for row in np.flatnonzero(moved > 0.1 * moved.max())]
        raise ComputationError(
            f"neither mass, damping nor stiffness determines how {' and '.join(names)} moves here; "
            "expected one of them",
            time=statics.time,
        )
    rows = np.delete(np.arange(len(c)), loose)
    mixed = np.abs(c[:, loose]).max(initial=0.0), np.abs(c[np.ix_(loose, rows)]).max(initial=0.0)
    felt = np.abs(q[:, loose]).max(initial=0.0) > 1e-9 * np.abs(q).max(initial=0.0)
    if felt or max(mixed) > 1e-9 * np.abs(c).max(initial=0.0):
        names = [free[row] for row in np.flatnonzero(np.abs(turned[:, loose]).max(axis=1))]
        raise ComputationError(
            f"rates of {' and '.join(names)}, which moves no mass, act on what they do not damp; "
            "expected a mass or a damper there",
            time=statics.time,
        )


def _named(
    statics: Statics, turn: Floats, groups: tuple[NDArray[np.int_], ...]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names and units of states: of the coordinate that is the parameter of each direction."""
    each = [*zip(*statics.listed(range(statics.n)), strict=True)]
    values: list[tuple[str, str]] = []
    speeds: list[tuple[str, str]] = []
    for which, group in enumerate(groups):
        for column in group:
            own = np.abs(turn) > 1e-12
            rows = np.flatnonzero((np.abs(turn[:, column] - 1.0) < 1e-12) & (own.sum(axis=1) == 1))
            row = int(rows[0]) if len(rows) else int(np.abs(turn[:, column]).argmax())
            note = "" if len(rows) else f" (direction {column + 1})"
            (name, unit), (rate, per) = each[row], each[statics.n + row]
            values.append((name + note, unit))
            if which != 1:
                speeds.append((rate + note, per))
    result = [*values, *speeds, *each[2 * statics.n :]]
    return tuple(name for name, _ in result), tuple(unit for _, unit in result)


def vibration_modes(model: LinearModel, still: float = 0.0) -> list[VibrationMode]:
    """Vibration modes, the slowest first; drives stand still in them.

    `still`: eigenvalues below this in 1/s, or a part of the largest one, are those of neighbours
    that are equilibria as well; 0 where none are.
    """
    kept = np.delete(np.arange(len(model.a)), model.driven)
    eigenvalues, shapes = _conservative(model) if _conserves(model) else _general(model, kept)
    largest = float(np.abs(eigenvalues).max(initial=0.0))
    skew = np.abs(model.damping - model.damping.T).max(initial=0.0)
    gyroscopic = skew > SKEW * max(np.abs(model.damping).max(initial=0.0), 1e-300)
    result = []
    for value, shape in zip(eigenvalues.tolist(), shapes.T, strict=True):
        magnitude = abs(value)
        ratio = 0.0 - value.real / magnitude if magnitude else 0.0
        frequency = magnitude / (2 * np.pi) if value.imag else 0.0
        if magnitude <= (max(still, ON_AXIS * largest) if still else 1e-15 * largest):
            kind, frequency, ratio = "neutral", 0.0, 0.0
        elif value.imag == 0.0:
            kind = "aperiodic" if value.real < 0.0 else "divergent"
        else:
            kind = "undamped" if abs(ratio) < ON_AXIS else "damped" if ratio > 0.0 else "growing"
        if gyroscopic and kind != "neutral":
            kind += ", gyroscopic"
        if value.imag >= 0.0:
            result.append(VibrationMode(complex(value), frequency, ratio, kind, _scaled(shape)))
    return sorted(result, key=lambda mode: (abs(mode.eigenvalue), mode.eigenvalue.real))


def _conserves(model: LinearModel) -> bool:
    """Whether there is inertia and symmetric stiffness alone."""
    k, c = model.stiffness, model.damping
    symmetric = np.abs(k - k.T).max(initial=0.0) <= 1e-12 * np.abs(k).max(initial=0.0)
    return symmetric and not c.any() and not model.massless and not len(model.internal)


def _conservative(model: LinearModel) -> tuple[Complex, Complex]:
    """Eigenvalues and shapes from the symmetric problem, which is exact to round-off."""
    from scipy.linalg import eigh

    k = 0.5 * (model.stiffness + model.stiffness.T)
    squares, vectors = eigh(k, model.inertia) if len(k) else (np.zeros(0), k)
    roots = np.sqrt(-squares.astype(complex))
    real = roots.imag == 0.0
    shapes = model.free[:, : len(k)] @ vectors
    values = np.concatenate([np.where(real, roots.real, 1j * np.abs(roots.imag)), -roots[real]])
    return values, np.hstack([shapes, shapes[:, real]]).astype(complex)


def _general(model: LinearModel, kept: NDArray[np.int_]) -> tuple[Complex, Complex]:
    a = model.a[np.ix_(kept, kept)]
    values, vectors = np.linalg.eig(a) if len(a) else (np.zeros(0), np.zeros((0, 0)))
    return values.astype(complex), (model.coordinates[:, kept] @ vectors).astype(complex)


def _scaled(shape: Complex) -> Complex:
    """With a largest entry of 1, which is real."""
    if not len(shape) or not np.abs(shape).max():
        return shape.astype(complex)
    largest = shape[np.abs(shape).argmax()]
    return np.asarray(shape / largest, dtype=complex)


def verdict(model: LinearModel, modes: Sequence[VibrationMode], rest: Rest) -> tuple[bool, str]:
    """Whether an equilibrium is stable, and why."""
    held = ""
    if model.stuck:
        what = f"{model.stuck} of its directions" if modes else "it"
        held = f"{'contact' if rest.pressed else 'dry friction'} holds {what}"
        if not modes:
            return True, held
        held += "; "
    words = {mode.kind.partition(",")[0] for mode in modes}
    if words & {"growing", "divergent"}:
        worst = max(modes, key=lambda mode: mode.eigenvalue.real)
        how = "on one side" if worst.eigenvalue.imag == 0.0 else "in a growing oscillation"
        rate = worst.eigenvalue.real
        return False, f"{held}neighbours leave {how}, by a factor e in {1 / rate:.3g} s"
    if "neutral" in words or rest.neutral:
        return False, f"{held}neutral: neighbouring positions are equilibria as well, or nearly so"
    if words <= {"damped", "aperiodic"}:
        return True, f"{held}neighbours come back: all vibration dies out"
    k, c = model.stiffness, model.damping
    symmetric = np.abs(k - k.T).max(initial=0.0) <= 1e-9 * np.abs(k).max(initial=0.0)
    lost = np.linalg.eigvalsh(c + c.T) if len(c) else np.zeros(1)
    losing = lost[0] >= -1e-9 * max(abs(lost[-1]), 1e-300)
    if len(k) and symmetric and losing and np.linalg.eigvalsh(k)[0] > 0.0:
        return True, f"{held}stored energy is least here: neighbours vibrate and stay near"
    return False, f"{held}undecided: the linear equations neither grow nor die out"


def responses(a: Floats, b: Floats, c: Floats, d: Floats, frequencies: Floats) -> Complex:
    """C (iω − A)⁻¹ B + D at frequencies in Hz, shape (frequencies, outputs, inputs).

    Infinite at a natural frequency without damping.
    """
    shifted = 2j * np.pi * frequencies[:, None, None] * np.eye(len(a)) - a
    sound = np.linalg.det(shifted) != 0.0
    result = np.full((len(frequencies), *d.shape), complex(np.inf))
    result[sound] = c @ np.linalg.solve(shifted[sound], b.astype(complex)[None]) + d
    return result
