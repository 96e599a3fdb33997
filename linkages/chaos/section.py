"""Poincaré sections: stroboscopic at the period of the drives, or where a function is crossed."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.chaos.free_states import free_values, labelled_states, require_free
from linkages.components.mechanism import Mechanism
from linkages.errors import ComputationError
from linkages.kernel.model import Model
from linkages.kernel.outputs import VARIABLES, labels
from linkages.kernel.scalars import Scalar
from linkages.kernel.system import System
from linkages.kernel.variations import NeedsAccelerationsError
from linkages.reading.wording import listed, suggestion
from linkages.solution.evaluation import ANGLES
from linkages.solution.flows import Flows
from linkages.solution.integration import failure_text
from linkages.solution.motion import Motion, Piece, Settings, compute_motion
from linkages.solvers.events import Event
from linkages.solvers.integrate import MAX_STEPS, integrate
from linkages.solvers.outcome import Outcome

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

DIRECTIONS = {"up": 1, "down": -1, "both": 0}
SECTION = "slider9.velocity=0"


@dataclass(frozen=True)
class Surface:
    """Where a section is taken: an output of one element has a value.

    Parameters
    ----------
    variable, element
        An output of position or velocity and one of its elements.
    level
        In SI.
    """

    variable: str
    element: str
    level: float

    @property
    def turns(self) -> bool:
        """Whether it is an angle, which has a value again after every turn."""
        return self.variable in ANGLES

    def node(self, model: Model) -> Scalar:
        """What crosses zero there (an angle also half a turn away)."""
        entry = VARIABLES[self.variable]
        nodes = entry.nodes(model)
        names = labels(model, entry.dims[0])
        if len(entry.dims) > 1:
            joint, axis = self.element.rsplit(".", 1)
            value = nodes[2 * names.index(joint) + ("x", "y").index(axis)]
        else:
            value = nodes[names.index(self.element)]
        difference = value - self.level
        return model.graph.sin(difference) if self.turns else difference


def poincare(
    mechanism: Mechanism,
    *,
    periods: int = 500,
    skip: int = 0,
    phase: float = 0.0,
    section: str | None = None,
    direction: str = "up",
    end: float | None = None,
    wrap: bool = True,
    method: str | None = None,
    rtol: float | None = None,
) -> xr.Dataset:
    """Points of a Poincaré section.

    Parameters
    ----------
    mechanism
        With at least one free coordinate.
    periods
        Number of points: one per common period of the drives, or one per crossing of `section`.
    skip
        Points left out before.
    phase
        Where in the period points are taken, from 0 to 1.
    section
        Where points are taken instead: ``"slider9.velocity=0"``, an element, a quantity of position
        or velocity (angle, speed, position, velocity) and a value in SI.
    direction
        ``"up"``, ``"down"`` or ``"both"``: how the quantity crosses the value.
    end
        Time until which crossings of a section are looked for; ``periods + skip`` times the common
        period of the drives (or the file's end time, if there is none) if not given.
    wrap
        Whether angles are taken within one turn.
    method, rtol
        As `linkages.simulate` takes them; those of the file if not given.

    Returns
    -------
    Dataset with `time` (crossing) and, for each kind of free coordinate, value and rate, such as
    `clearance_angle` and `clearance_speed` (crossing, clearance).

    Raises
    ------
    InputError
        If nothing is free, or the section names nothing.
    ValueError
        For arguments that make no sense; `NoPeriodError` where drives have no common period.
    ComputationError
        If the motion cannot go on, or never crosses the section.
    """
    system = System(mechanism)
    require_free(system)
    if periods < 1 or skip < 0:
        raise ValueError(f"expected periods > 0 and skip >= 0, found {periods} and {skip}")
    settings = section_settings(mechanism, method, rtol)
    attributes: dict[str, object]
    if section is None:
        motion = _stroboscopic(system, settings, periods, skip, phase)
        attributes = {"period": common_period(mechanism), "phase": phase}
    else:
        surface = parse_section(system, section)
        last = _limit(system, periods + skip) if end is None else end
        motion = _crossed(system, settings, surface, periods, skip, direction, last)
        attributes = {"section": section, "direction": direction}
    return labelled_states(
        system,
        free_values(system, motion, wrap),
        "crossing",
        {"time": ("crossing", motion.time, {"units": "s", "long_name": "time"})},
        attributes,
    )


def section_settings(mechanism: Mechanism, method: str | None, rtol: float | None) -> Settings:
    """How a motion is integrated whose samples are chosen later."""
    defaults = mechanism.simulation
    return Settings(
        times=np.zeros(1),
        method=defaults.method if method is None else method,
        rtol=defaults.rtol if rtol is None else rtol,
        atol=defaults.atol if rtol is None else None,
        step=defaults.step,
        max_steps=MAX_STEPS,
    )


def _stroboscopic(
    system: System, settings: Settings, periods: int, skip: int, phase: float
) -> Motion:
    if not 0.0 <= phase < 1.0:
        raise ValueError(f"phase must be from 0 to below 1, found {phase:g}")
    period = stroboscopic_period(system.mechanism)
    times = period * (phase + skip + np.arange(periods, dtype=np.float64))
    motion = compute_motion(system, replace(settings, times=times))
    if motion.failure is not None:
        raise ComputationError(motion.failure, time=motion.stop_time)
    return motion


def stroboscopic_period(mechanism: Mechanism) -> float:
    """The common period, or an error that says what to do without one."""
    try:
        return common_period(mechanism)
    except NoPeriodError as error:
        message = f"{error}; take a geometric section instead, such as {SECTION!r}"
        raise NoPeriodError(message) from None


def _limit(system: System, points: int) -> float:
    try:
        return points * common_period(system.mechanism)
    except NoPeriodError:
        return points * system.mechanism.simulation.end


_QUANTITIES = {
    "bar": {"angle": "bar_angle", "speed": "bar_speed"},
    "clearance": {"angle": "clearance_angle", "speed": "clearance_speed"},
    "slider": {"position": "slider_position", "velocity": "slider_velocity"},
    "joint": {
        f"{axis} {word}": f"joint_{word}" for axis in "xy" for word in ("position", "velocity")
    },
}


def parse_section(system: System, text: str) -> Surface:
    """Read ``"slider9.velocity=0"``, ``"crank.angle=90 deg"``, ``"B.y position=0.1"``.

    Raises
    ------
    ValueError
        If it names nothing of the mechanism; the message says what is expected.
    """
    from linkages.spec import dimensions
    from linkages.spec.conversion import QuantityError, parse_quantity

    match = re.fullmatch(r"\s*(.+?)\.([^.=]+?)\s*=\s*(.+?)\s*", text)
    if match is None:
        raise ValueError(f"expected a section such as {SECTION!r}, found {text!r}")
    element, quantity, level = match.groups()
    kinds = {name: dim for dim in _QUANTITIES for name in labels(system.model, dim)}
    if element not in kinds:
        near = suggestion(element, kinds) or f"; expected one of: {listed(sorted(kinds))}"
        raise ValueError(f"section {text!r}: unknown element {element!r}{near}")
    quantities = _QUANTITIES[kinds[element]]
    if quantity not in quantities:
        raise ValueError(
            f"section {text!r}: {element} has no {quantity!r}; expected {listed(quantities)}"
        )
    variable = quantities[quantity]
    measured = {
        "rad": dimensions.ANGLE,
        "rad/s": dimensions.ANGULAR_SPEED,
        "m": dimensions.LENGTH,
        "m/s": dimensions.SPEED,
    }[VARIABLES[variable].units]
    try:
        value = parse_quantity(level, measured)
    except QuantityError as error:
        raise ValueError(f"section {text!r}: {error}") from None
    name = f"{element}.{quantity[0]}" if kinds[element] == "joint" else element
    return Surface(variable, name, value)


def _crossed(
    system: System,
    settings: Settings,
    surface: Surface,
    points: int,
    skip: int,
    direction: str,
    end: float,
) -> Motion:
    """Integrate until enough crossings are found."""
    if direction not in DIRECTIONS:
        raise ValueError(f"direction must be up, down or both, found {direction!r}")
    try:
        flow = Flows(system, watched=surface.node).flow()
    except NeedsAccelerationsError as error:
        raise ValueError(f"a section cannot be taken there: {error}") from None
    own = len(system.topology.coordinates)
    total = flow.coordinates
    weights = np.zeros(2 * total)
    weights[total + own] = 1.0
    wanted = points + skip
    # An angle's sine vanishes half a turn away as well, going the other way.
    capacity = 2 * wanted + 2 if surface.turns else wanted
    event = Event(
        weights=weights,
        direction=0 if surface.turns else DIRECTIONS[direction],
        terminal=capacity,
        capacity=capacity,
    )
    state = np.zeros(2 * total)
    half = len(system.state) // 2
    state[:own], state[total : total + own] = system.state[:half], system.state[half:]
    state[total + own] = float(system.evaluate([surface.node(system.model)])[0, 0])
    trajectory = integrate(
        flow,
        state,
        [end],
        start=system.time,
        method=settings.method,
        rtol=settings.rtol,
        atol=settings.atol,
        step=settings.step,
        events=[event],
    )
    if trajectory.outcome not in (Outcome.DONE, Outcome.EVENT):
        text = failure_text(system, trajectory)
        raise ComputationError(str(text), time=trajectory.stop_time)
    found = trajectory.crossings[0]
    piece = Piece(
        system=system,
        time=found.time,
        state=np.concatenate([found.state[:, :own], found.state[:, total : total + own]], axis=1).T,
        turns=found.turns[:, :own].T.astype(float),
        acceleration=np.zeros((own, len(found.time))),
    )
    if surface.turns:
        piece = piece.part(_right_way(piece, surface, DIRECTIONS[direction]))
    piece = piece.part(slice(skip, wanted))
    if not len(piece.time):
        name = f"{surface.element} {surface.variable.split('_')[-1]} = {surface.level:g}"
        raise ComputationError(
            f"the section {name} is crossed {len(found.time)} times within {end:.6g} s, which "
            f"leaves no point after the {skip} skipped; expected a value that the motion reaches",
            time=float(end),
        )
    return Motion(pieces=(piece,), stop_time=trajectory.stop_time)


def _right_way(piece: Piece, surface: Surface, direction: int) -> NDArray[np.bool_]:
    """Crossings of the angle itself, in the direction asked for."""
    entry = VARIABLES[surface.variable]
    model = piece.system.model
    index = labels(model, entry.dims[0]).index(surface.element)
    speed = VARIABLES[surface.variable.replace("angle", "speed")].nodes(model)[index]
    angle = entry.nodes(model)[index]
    values = piece.system.evaluate([angle, speed], piece.time, piece.state)
    there = np.cos(values[0] - surface.level) > 0
    return there if direction == 0 else there & (values[1] * direction > 0)
