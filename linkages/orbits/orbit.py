"""Periodic orbits and their stability."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.free_states import require_free
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.options.analysis_options import OrbitKeywords, OrbitOptions
from linkages.options.option import OptionError, takes
from linkages.orbits.contact_events import contacts
from linkages.orbits.equations import (
    Evaluated,
    NotConvergedError,
    Orbit,
    Problem,
    conserves,
    solve,
)
from linkages.orbits.search import (
    Found,
    at_start,
    found_from,
    from_random_states,
    orbit_near,
    same_orbit,
    settled,
)
from linkages.orbits.shooting import Shooting
from linkages.orbits.starting_states import read_states
from linkages.solution.run_options import options_of
from linkages.solvers.integration import LEAST_RTOL

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

NOISE = 1e-5
"""Multipliers below this are smaller than the errors of those beside them."""

LOST = 1e-12
"""Multipliers below this, where contacts close or stick, are exact zeros."""

EDGE = 10.0
"""Errors of multipliers within which one of magnitude 1 decides nothing."""

NEWTON = 1e-9
"""Least error of multipliers at an orbit that is located as a bifurcation."""

OF_ORBIT = (
    "period", "periods", "stable", "reason", "conservative", "contacts", "zeros", "residual",
    "state_change", "nodes",
)  # fmt: skip
"""Attributes of an orbit; variables of several."""


@dataclass(frozen=True, eq=False)
class Checked:
    """An orbit, and how much of it changes at a tenth of the tolerance."""

    found: Found
    state_change: float
    multiplier_errors: Floats


def require_isolated(mechanism: Mechanism, shooting: Shooting) -> None:
    """Raise where orbits are families because a law remembers how fast contact began."""
    switches = shooting.system.model.switches
    _ = shooting.system.model.changes
    lasting = [memory for memory in switches.memories if not memory.insensitive]
    if not lasting:
        return
    name = switches.switches[lasting[0].owner].name.partition(":")[0]
    message = (
        f"the contact law of {name!r} remembers the rate at which contact began: while contact "
        "lasts, that is a number of the state that the motion does not change, so that closed "
        "orbits form families instead of being isolated; expected a law without memory, such as "
        "hunt-crossley-constant"
    )
    raise mechanism.error([((), message)])


def checked(found: Found) -> Checked:
    """The orbit again at a tenth of the tolerance."""
    problem, solution = found.problem, found.solution
    run = problem.shooting.run
    tighter = replace(run, rtol=max(run.rtol / 10, LEAST_RTOL))
    again = problem.with_run(tighter)
    other = solve(again, solution.unknowns, solution.places, near=solution.at)
    change = np.abs((other.unknowns - solution.unknowns) / problem.scale).max()
    own, theirs = solution.at.spectrum, other.at.spectrum
    errors = np.array([np.abs(theirs - value).min() for value in own])
    return Checked(found, float(change), errors)


def stability(problem: Problem, at: Evaluated, conserving: bool, errors: Floats) -> str:
    """A sentence on why an orbit is stable or not."""
    spectrum = problem.decisive(at.spectrum)
    if not len(spectrum):
        return "there is no neighbour"
    largest = spectrum[np.argmax(np.abs(spectrum))]
    size = f"the largest multiplier has the magnitude {abs(largest):.6g}"
    if at.family:
        return (
            f"{size}; energy is conserved, so that orbits form a family over it, of which this one "
            "has the energy of the start"
        )
    if conserving:
        return f"{size}; energy is conserved, so that neighbours neither approach nor leave"
    if undecided(problem, at, errors):
        return f"{size}, which is 1 within its error: a bifurcation"
    if abs(largest) < 1.0:
        return f"{size}, which is below 1"
    if abs(largest.imag) > NOISE:
        return f"{size}: neighbours spiral away"
    side = "on alternating sides" if largest.real < 0 else "on one side"
    return f"{size}: neighbours leave {side}"


def undecided(problem: Problem, at: Evaluated, errors: Floats) -> bool:
    """Whether the largest multiplier is as near to the unit circle as it is known."""
    spectrum = problem.decisive(at.spectrum)
    largest = float(np.abs(spectrum).max(initial=0.0))
    return abs(largest - 1.0) <= EDGE * float(np.max(errors, initial=NEWTON))


@takes(OrbitOptions)
def orbit(
    mechanism: Mechanism,
    *,
    state: Mapping[str, float] | Sequence[str] | None = None,
    watch: Callable[[float], None] | None = None,
    **options: Unpack[OrbitKeywords],
) -> xr.Dataset:
    """Find a periodic orbit, stable or unstable, and its multipliers.

    Newton's method for a state that returns after some periods of the drives or, without anything
    that depends on time, after a period that is unknown as well. Derivatives are exact, also
    through impacts and changes of contact.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    state
        Coordinate or rate → value in SI, such as ``{"rod.angle": 0.1, "rod.speed": 0}``, where the
        search begins, or texts such as ``"rod.angle=10 deg"``; others are those of the definition.
    watch
        Called with the fraction of starts that are done.
    options
        As `OrbitOptions` describes them.

    Returns
    -------
    Dataset with `state` (coordinate) at the beginning of a period of the drives, `multiplier`
    (index, part) with real and imaginary part and `multiplier_error` (index), and the motion over
    one period as `orbit_state` (time, coordinate). Attributes are the ``period`` in seconds,
    ``periods`` of the drives, ``stable`` and ``reason``, the number of ``contacts`` that close,
    the number of exact zeros among the multipliers, ``residual``, and how much the state changes
    at a tenth of the tolerance, both in amplitudes. Several starts give a dimension `orbit`, along
    which these are variables.

    Raises
    ------
    InputError
        If nothing is free to move, or orbits form families.
    ComputationError
        If no orbit is found.
    """
    run = options_of(OrbitOptions, mechanism, options)
    shooting = Shooting(mechanism, (), run)
    require_free(shooting.system)
    require_isolated(mechanism, shooting)
    places = np.zeros(0)
    first = starting_state(shooting, places, read_states(mechanism, state))
    if run.starts == 1:
        found = found_from(
            shooting, places, first, periods=run.periods, skip=run.skip, longest=run.longest
        )
        if not isinstance(found.problem, Orbit):
            raise ComputationError(
                "the motion comes to rest: there is an equilibrium, and no orbit was found; give "
                "a state near the orbit, or follow equilibria to a Hopf point",
                time=0.0,
            )
        return orbit_data(mechanism, checked(found), run)
    founds = _from_many(shooting, places, first, run, watch)
    return _together([orbit_data(mechanism, checked(each), run) for each in founds])


def _together(each: Sequence[xr.Dataset]) -> xr.Dataset:
    """Several orbits along a dimension, with what attributes say of one as variables."""
    import xarray as xr

    own = {name: ("orbit", [data.attrs.pop(name) for data in each]) for name in OF_ORBIT}
    kept = [data.assign_coords(section=np.arange(data.sizes["section"])) for data in each]
    return xr.concat(kept, "orbit", join="outer").assign(own)


def starting_state(shooting: Shooting, places: Floats, state: Mapping[str, float]) -> Floats:
    """The initial state of the definition, with other values of some of its entries."""
    result = shooting.initial(places)
    for name, value in state.items():
        if name not in shooting.names:
            known = ", ".join(shooting.names)
            raise OptionError("state", f"found no coordinate {name!r}; expected one of: {known}")
        result[shooting.names.index(name)] = value
    return result


def _from_many(
    shooting: Shooting,
    places: Floats,
    first: Floats,
    run: OrbitOptions,
    watch: Callable[[float], None] | None,
) -> list[Found]:
    """Orbits from random states, the stable ones first, each once."""
    if shooting.period(places) is None:
        message = "random starts need drives or loads that depend on time; expected 1"
        raise OptionError("starts", message)
    last, seen = settled(shooting, places, first, run.skip, run.longest)
    found: list[Found] = []
    with suppress(ComputationError):
        found.append(orbit_near(shooting, places, last, run.periods or seen))
    others = np.tile(places, (run.starts - 1, 1))
    for each in from_random_states(shooting, others, last, run, watch=watch):
        if not any(same_orbit(each, other) for other in found):
            found.append(each)
    if not found:
        raise NotConvergedError(f"none of {run.starts} starts led to an orbit", time=0.0)

    def order(each: Found) -> tuple[bool, int]:
        return not each.problem.stable(each.solution.at.spectrum), each.periods

    return sorted(found, key=order)


def orbit_data(mechanism: Mechanism, each: Checked, run: OrbitOptions) -> xr.Dataset:
    """An orbit as labelled arrays."""
    import xarray as xr

    found = each.found
    problem, solution = found.problem, found.solution
    assert isinstance(problem, Orbit)
    points, times, states = at_start(found)
    spectrum = solution.at.spectrum
    zeros = int((np.abs(spectrum) < LOST).sum())
    kept = conserves(spectrum)
    near = undecided(problem, solution.at, each.multiplier_errors)
    names = np.array(problem.shooting.names, dtype=object)
    both = np.stack([spectrum.real, spectrum.imag], axis=1)
    data = {
        "state": ("coordinate", points[0], {"long_name": "state at the beginning of a period"}),
        "unit": ("coordinate", np.array(problem.shooting.units, dtype=object)),
        "multiplier": (("index", "part"), both, {"units": "1", "long_name": "multiplier"}),
        "multiplier_error": (
            "index",
            each.multiplier_errors,
            {"units": "1", "long_name": "change of a multiplier at a tenth of the tolerance"},
        ),
        "orbit_state": (("time", "coordinate"), states, {"long_name": "state"}),
        "section_state": (
            ("section", "coordinate"), points, {"long_name": "state at beginnings of periods"}
        ),
    }  # fmt: skip
    attrs: dict[str, Any] = {
        "name": mechanism.name,
        "source": mechanism.file_name,
        "period": float(problem.period(solution.unknowns, solution.places)),
        "periods": problem.periods or 0,
        "stable": int(problem.stable(spectrum) and not (kept or near)),
        "reason": stability(problem, solution.at, kept, each.multiplier_errors),
        "conservative": int(kept),
        "contacts": contacts(solution.at.changes),
        "zeros": zeros,
        "residual": float(np.abs(solution.at.residual / problem.scale).max()),
        "state_change": each.state_change,
        "nodes": problem.nodes,
        **run.how,
    }
    return xr.Dataset(
        data,
        coords={
            "coordinate": names,
            "index": np.arange(1, len(spectrum) + 1),
            "part": np.array(["real", "imaginary"], dtype=object),
            "time": ("time", times, {"units": "s", "long_name": "time"}),
        },
        attrs=attrs,
    )


def multiplier_texts(data: xr.Dataset) -> list[str]:
    """Multipliers of an orbit as texts, with as many digits as are known."""
    result = []
    values = data["multiplier"].to_numpy() @ [1, 1j]
    errors = data["multiplier_error"].to_numpy()
    for value, error in zip(values.tolist(), errors.tolist(), strict=True):
        if abs(value) < LOST:
            result.append("0")
        elif abs(value) < NOISE:
            result.append(f"< {NOISE:g}")
        else:
            known = -math.floor(math.log10(max(error, 1e-14) / abs(value)))
            digits = max(2, min(10, known))
            imaginary = f" {'+' if value.imag > 0 else '−'} {abs(value.imag):.{digits}g}i"
            result.append(f"{value.real:.{digits}g}" + (imaginary if value.imag else ""))
    return result
