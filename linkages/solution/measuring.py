"""Measures and formulas of one solution, and what is doubtful about them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.solution.interpolated import InterpolatedMotions, resolved_motion
from linkages.solution.measure_names import (
    measure_unit,
    measured_series,
    needed_outputs,
    resolved_text,
)
from linkages.solution.measured import Evaluation, Place, require_alone, single
from linkages.solution.series import (
    TIME,
    Series,
    find_series,
    requested,
    system_series,
    with_sizes,
)
from linkages.spec.formulas import Call, Clock, Node
from linkages.spec.measures import (
    DURING,
    HARMONICS,
    LAST_TURN,
    WINDOWS,
    Measure,
    argument,
    read_measure,
)

if TYPE_CHECKING:
    from linkages.solution.solution import Solution

Floats = NDArray[np.float64]


def measure(solution: Solution, text: str) -> float:
    """A number out of a motion, such as ``"max(abs(crank.effort))"``.

    Series are named as on axes: ``crank.effort``, ``piston.position``, ``B.x velocity``,
    ``kinetic_energy``. They are reduced by ``max``, ``min``, ``range``, ``stroke``, ``mean``,
    ``rms``, ``integral``, ``first``, ``final``, ``at(0.2 s, …)``, ``time_of_max``, ``time_of_min``,
    ``harmonic(2, …)`` and ``phase(2, …)``, in a part of the motion with ``during(1 s, 2 s, …)`` and
    ``last_turn(crank.angle, …)``. Numbers of the definition, such as ``bars.rod.length``, are
    measures as well. Arithmetic and the functions of formulas go within and around. Extremes are
    located between samples.

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
        If the measure has no finite value, as where it divides by zero, or asks for a time or a
        part outside of the motion.
    """
    result = resolved_text(solution.system, text)
    measure_unit(solution.system, result)
    return single(result, _source(solution, result))


def _source(solution: Solution, found: Measure) -> InterpolatedMotions:
    """The motion of a solution as the source of a measure."""
    series = measured_series(solution.system, found)
    for name, each in series.items():
        whole = each.variable in VARIABLES and VARIABLES[each.variable].whole
        if whole and each.variable not in solution.data:
            raise ValueError(
                f"measure {found.text!r}: {name} was not computed; expected outputs that have "
                f"{each.variable!r}"
            )
    system, settings = solution.system, solution.settings
    integrated = found.integrates and bool(solution.motion.method)
    if integrated not in solution.resolved:
        solution.resolved[integrated] = resolved_motion(
            system, solution.motion, settings, integrated
        )
    motion, time, _ = solution.resolved[integrated]
    return InterpolatedMotions(
        [system], [motion], series, time, data=solution.data, settings=settings
    )


def is_formula(known: Mapping[str, Series], text: str) -> bool:
    """Whether a text is more than the name of a series."""
    if not any(sign in text for sign in "(*+/"):
        return False
    try:
        find_series(known, text)
    except ValueError:
        return True
    return False


class FormulaSeries:
    """A formula of series over time, such as ``cumulative(crank.effort*crank.speed)``.

    Attributes
    ----------
    unit
        In SI; empty for a pure number.
    """

    def __init__(self, solution: Solution, text: str) -> None:
        found = resolved_text(solution.system, f"final({text})")
        self.unit = measure_unit(solution.system, found)
        require_alone(found)
        self._evaluation = Evaluation(found, _source(solution, found))
        self._node = argument(found)

    def at(self, times: Floats) -> Floats:
        """Values at times within the motion, shape (times,); nan where it has none."""
        place = Place(np.zeros(len(times), dtype=int), times=times)
        with np.errstate(all="ignore"):
            return np.broadcast_to(self._evaluation.series(self._node, place), times.shape).copy()


STEADY = 1e-3
"""Part of a measure by which it may differ from that of the turn before, and of the range of a
series by which its ends may differ over a whole period."""

_ROUND_OFF = 1e-9
"""What measures near zero differ by at least, in SI."""


def doubts(solution: Solution, text: str) -> list[str]:
    """Sentences about last turns that differ from those before, and periods that are not whole."""
    found = resolved_text(solution.system, text)
    asked = [*_asked(found.tree, ())]
    if not asked:
        return []
    source, result = _source(solution, found), []
    for tree, said in asked:
        try:
            own, other = (single(Measure(text, each), source) for each in tree)
        except ComputationError:  # there is no other turn
            continue
        if abs(own - other) > max(STEADY * max(abs(own), abs(other)), _ROUND_OFF):
            result.append(f"measure {text!r}: {said(own, other)}")
    return list(dict.fromkeys(result))


Asked = tuple[tuple[Node, Node], Callable[[float, float], str]]
"""Two measures that should be alike, and what to say if they are not."""


def _asked(node: Node, windows: tuple[tuple[str, tuple[Node, ...]], ...]) -> Iterator[Asked]:
    if not isinstance(node, Call):
        return

    def within(inner: Node) -> Node:
        return reduce(lambda m, one: Call(one[0], (*one[1], m)), reversed(windows), inner)

    match node:
        case Call(name, (angle, inner)) if name == LAST_TURN:
            start = Call("first", (Clock(),))
            begun = Call(LAST_TURN, (angle, start))
            before = Call(DURING, (start, begun, node))
            yield (within(node), within(before)), _unsteady
        case Call(name, (_, series)) if name in HARMONICS:
            size = Call("range", (series,))
            apart = Call("sub", (Call("final", (series,)), Call("first", (series,))))
            whole = Call("add", (size, Call("abs", (apart,))))
            yield (within(size), within(whole)), _partial
    if node.name in WINDOWS:
        *edges, inner = node.arguments
        for edge in edges:
            yield from _asked(edge, windows)
        yield from _asked(inner, (*windows, (node.name, tuple(edges))))
        return
    for each in node.arguments:
        yield from _asked(each, windows)


def _unsteady(own: float, other: float) -> str:
    return (
        f"{own:.6g} in the last turn, {other:.6g} in the turn before: the motion is not steady; "
        "simulate it for longer"
    )


def _partial(size: float, other: float) -> str:
    return (
        f"the ends of the window differ by {100 * (other - size) / size:.2g} % of the range of "
        "what is analysed: the window is no whole period of it, or it jumps there"
    )


def unit_of(solution: Solution, text: str) -> str:
    """The unit of a measure of a solution, in SI; empty for a pure number."""
    return measure_unit(solution.system, read_measure(text))


def with_measured(
    mechanism: Mechanism, outputs: Sequence[str] | None, texts: Iterable[str]
) -> Sequence[str]:
    """Outputs with those that measures need besides; checks the texts."""
    system = System(mechanism)
    result = [read_measure(text) for text in texts]
    for one in result:
        measure_unit(system, one)
        require_alone(one)
    needed = [name for name in needed_outputs(system, result) if VARIABLES[name].whole]
    return list(dict.fromkeys([*requested(system, outputs), *needed]))


def outputs_with(system: System, names: Sequence[str]) -> list[str]:
    """Outputs that some series and formulas are of, magnitudes of vectors among them."""
    known = with_sizes(system_series(system))
    written = [name for name in names if is_formula(known, name)]
    result = [find_series(known, name).variable for name in names if name not in written]
    result += needed_outputs(system, [resolved_text(system, f"final({name})") for name in written])
    return [name for name in dict.fromkeys(result) if name != TIME]


def measured_rows(solution: Solution, texts: Iterable[str]) -> list[dict[str, Any]]:
    """A row for each measure: its text, value, unit, and why it has no value."""
    rows: list[dict[str, Any]] = []
    for text in texts if len(solution.time) else ():
        value, why = None, None
        try:
            value = measure(solution, text)
        except ComputationError as error:
            why = str(error)
        units = unit_of(solution, text)
        rows.append({"measure": text, "value": value, "units": units, "reason": why})
    return rows
