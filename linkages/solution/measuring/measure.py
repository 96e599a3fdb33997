"""A measure of a solution: a number, with its unit."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.reading.paths import split
from linkages.solution.measuring.followed import Followed, resolved_motion
from linkages.solution.measuring.reduced import Source, reduced, require_alone
from linkages.solution.values.requests import DISSIPATION, requested
from linkages.solution.values.series import TIME, Series, example_series, find_series, system_series
from linkages.spec.grammar import NumberError
from linkages.spec.measures import Measure, read_measure, spelled

if TYPE_CHECKING:
    from linkages.solution.solution import Solution


def measure(solution: Solution, text: str) -> float:
    """A number out of a motion, such as ``"max(abs(crank.effort))"``.

    Series are named as on axes: ``crank.effort``, ``piston.position``, ``B.x velocity``,
    ``kinetic_energy``. They are reduced by ``max``, ``min``, ``mean``, ``rms``, ``range``,
    ``stroke``, ``final``, ``time_of_max``, ``time_of_min`` and ``at(0.2 s, …)``; arithmetic and the
    functions of formulas go within and around. Extremes are located between samples.

    Parameters
    ----------
    solution
        From `linkages.simulate`; what is computed from more than the motion at one time, such as
        reactions of joints, must be among its outputs.
    text
        The measure.

    Returns
    -------
    In SI.

    Raises
    ------
    ValueError
        If the text is no measure, or names no output of the mechanism.
    ComputationError
        If the measure has no finite value, as where it divides by zero, or asks for a time outside
        of the motion.
    """
    found = read_measure(text)
    series = measured_series(solution.system, found)
    for name, each in series.items():
        whole = each.variable in VARIABLES and VARIABLES[each.variable].whole
        if whole and each.variable not in solution.data:
            raise ValueError(
                f"measure {text!r}: {name} was not computed; expected outputs that have "
                f"{each.variable!r}"
            )
    measure_unit(solution.system, found, series)
    system, data, settings = solution.system, solution.data, solution.settings
    lost = any(each.variable in DISSIPATION for each in series.values())
    settings = replace(settings, losses=settings.losses and lost)
    motion, time, _ = resolved_motion(system, solution.motion, settings, found.integrates)
    return single(found, Followed(system, motion, series, data, time, settings))


def single(found: Measure, source: Source, nominal: Source | None = None) -> float:
    """A measure of the one motion of a source; raises ComputationError as `measure` does."""
    value = reduced(found, source, nominal)
    if reason := value.reason(0):
        raise ComputationError(reason, time=None)
    return float(value.values[0])


def measured_series(system: System, found: Measure) -> dict[str, Series]:
    """Name → series that a measure names; spaces in names may be written as underscores.

    Raises
    ------
    ValueError
        For a name that is no output of the mechanism, with the nearest one.
    """
    try:
        return known_series(system, found.series)
    except ValueError as error:
        raise ValueError(f"measure {found.text!r}: {error}") from None


def known_series(system: System, names: Iterable[str]) -> dict[str, Series]:
    """Name → series of a mechanism; raises ValueError for a name that is none of them."""
    known = system_series(system)
    found = {}
    for name in names:
        try:
            found[name] = find_series(known, name, spelled)
        except ValueError:
            if system.mechanism.definition.value(split(name) or ("",)) is None:
                raise
            example = spelled(example_series(system))
            raise ValueError(
                f"{name!r} is a value of the definition; expected an output, such as {example!r}"
            ) from None
    return found


def example_measure(mechanism: Mechanism) -> str:
    """A measure of this mechanism, for messages."""
    return f"max({spelled(example_series(System(mechanism)))})"


def measure_unit(system: System, found: Measure, series: dict[str, Series]) -> str:
    """The unit of a measure of a mechanism, in SI.

    Raises
    ------
    ValueError
        If quantities in it do not go together.
    """
    try:
        return found.units(lambda name: series_unit(system, series[name]))
    except NumberError as error:
        raise ValueError(f"measure {found.text!r}: {error.message}{error.hint}") from None


def unit_of(solution: Solution, text: str) -> str:
    """The unit of a measure of a solution, in SI; empty for a pure number."""
    found = read_measure(text)
    return measure_unit(solution.system, found, measured_series(solution.system, found))


def with_measured(
    mechanism: Mechanism, outputs: Sequence[str] | None, texts: Iterable[str]
) -> Sequence[str]:
    """Outputs with those that measures need besides; checks the texts.

    Parameters
    ----------
    mechanism
        What is measured.
    outputs
        What was asked for, as `linkages.simulate` takes it.
    texts
        Measures.

    Raises
    ------
    ValueError
        If a text is no measure of the mechanism, or one of errors.
    """
    system = System(mechanism)
    found = [read_measure(text) for text in texts]
    for one in found:
        measure_unit(system, one, measured_series(system, one))
        require_alone(one)
    needed = [name for name in needed_outputs(system, found) if VARIABLES[name].whole]
    return list(dict.fromkeys([*requested(system, outputs), *needed]))


def needed_outputs(system: System, measures: Iterable[Measure]) -> list[str]:
    """Outputs that measures are made of."""
    found = [each.variable for one in measures for each in measured_series(system, one).values()]
    return [name for name in dict.fromkeys(found) if name != TIME]


def series_unit(system: System, series: Series) -> str:
    """The unit of a series, in SI."""
    if series.variable == TIME:
        return "s"
    variable = VARIABLES[series.variable]
    name = series.place.get("drive")
    pushed = variable.pushed is not None and name is not None
    if pushed and variable.pushed and not system.mechanism.bodies[str(name)].rotates:
        return variable.pushed[0]
    return variable.units
