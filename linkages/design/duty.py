"""The duty of drives over a cycle: what a motor must give, and the flywheel of a drive.

References
----------
.. [1] R. L. Norton, *Design of Machinery*, 5th ed., McGraw-Hill, 2012, section 11.11: the flywheel
   for a coefficient of speed fluctuation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.reading.wording import listed, suggestion
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.units import ANGULAR_SPEED, FORCE, NUMBER, SPEED, TORQUE, Bound

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

INTERVALS = 4096
"""Parts of a cycle; integrals by the trapezoidal rule, which is exact to round-off for smooth
motions that repeat."""

STEADY = 1e-6
"""Change of the speed of a drive, beside its mean, that is none."""

ROUGH = 1e-5
"""Change of a result with half of the samples, beside its size, that is noted."""


@dataclass(frozen=True)
class MotorLine:
    """A motor whose effort falls in a straight line from standstill to its speed without load.

    Parameters
    ----------
    stall, no_load
        Effort at standstill (N·m or N) and speed without load (rad/s or m/s) of the rotor, > 0.
    gear_ratio
        Speed of the rotor over that of the drive, > 0.
    """

    stall: float
    no_load: float
    gear_ratio: float = 1.0

    def least_and_most(self, speed: Floats) -> tuple[Floats, Floats]:
        """Efforts that it can give the drive at a speed; when it brakes, no more than at rest."""
        most = self.stall * self.gear_ratio
        fall = most / self.no_load * self.gear_ratio
        return -np.minimum(most, most + fall * speed), np.minimum(most, most - fall * speed)


def duty(
    mechanism: Mechanism,
    *,
    fluctuation: float | None = None,
    motors: Mapping[str, MotorLine] | Sequence[str] = (),
) -> xr.Dataset:
    """What drives (or actuators) must give over a cycle, and the flywheel that evens a drive out.

    A cycle is the common period of all drives and loads, the last one of the run; or the whole run
    where there is none.

    Parameters
    ----------
    mechanism
        With at least one drive. `simulate.end` says how long it runs.
    fluctuation
        Wanted coefficient of speed fluctuation, (ω_max − ω_min)/ω_mean, of a shaft that a constant
        torque turns in the place of its drive; for drives that turn steadily.
    motors
        Drive (or actuator) → `MotorLine`, or texts such as ``"crank=30 N m, 1500 rpm, 5"``: effort
        at standstill, speed without load, and perhaps the ratio of a gear.

    Returns
    -------
    Dataset over `drive`: largest magnitude, root mean square and mean of the effort (`effort_peak`,
    `effort_rms`, `effort_mean`), `speed_peak`, `power_peak`, `power_mean`, `energy_given`,
    `energy_returned` per cycle; `flywheel` in kg·m² and `energy_fluctuation`, nan for drives that
    do not turn steadily; `margin`, the least ratio of what the motor can give to what is needed,
    `margin_time`; and `effort` and `speed` (time, drive) over the cycle. The attribute ``warning``
    says what is less certain.

    Raises
    ------
    ValueError
        If nothing is driven, or an argument makes no sense.
    ComputationError
        If the motion stops before its end.

    Notes
    -----
    The flywheel has J = ΔE/(δ ω²), as R. L. Norton derives it in *Design of Machinery*. ΔE is the
    greatest difference of the integral of the effort less its mean over the turned angle, of the
    motion at constant speed. Where inertias vary, errors are of order δ.
    """
    import xarray as xr

    lines = _lines(mechanism, motors)
    if fluctuation is not None and not 0.0 < fluctuation < 1.0:
        raise ValueError(f"fluctuation must be between 0 and 1, found {fluctuation:g}")
    period, notes = _cycle(mechanism)
    end = max(mechanism.simulation.end, period)
    times = np.linspace(end - period, end, INTERVALS + 1)
    if not mechanism.prescribed:
        raise ValueError("nothing is driven; expected a drive")
    solution = simulate(mechanism, times=times, outputs=["drive_effort"])
    effort, speed = solution.data["drive_effort"].to_numpy(), _speeds(solution)
    names = [str(name) for name in solution.data["drive"].values]

    def columns_of(every: int) -> list[dict[str, float]]:
        """Numbers of all drives by some of the samples."""
        return [
            _column(times[::every], effort[::every, k], speed[::every, k], fluctuation,
                    lines.get(name), mechanism.twisting(name))
            for k, name in enumerate(names)
        ]  # fmt: skip

    columns, coarse = columns_of(1), columns_of(2)
    rough = {
        f"{key} of {name}": abs(fine[key] - half[key]) / abs(fine[key])
        for name, fine, half in zip(names, columns, coarse, strict=True)
        for key in ("effort_peak", "effort_rms", "flywheel")
        if abs(fine[key] - half[key]) > ROUGH * abs(fine[key])
    }
    if rough:
        share = f"{100 * max(rough.values()):.1g} %"
        notes.append(f"{', '.join(rough)}: jumps or peaks in the cycle, good to about {share}")
    notes += [note for note in solution.notes if "actuators" in note]
    turning = [mechanism.twisting(name) for name in names]
    variables = {
        key: ("drive", np.array([column[key] for column in columns]),
              {"units": _units(unit, turning), "long_name": words})
        for key, (unit, words) in COLUMNS.items()
    }  # fmt: skip
    series = {
        "effort": (("time", "drive"), effort, {"units": _units("N m", turning)}),
        "speed": (("time", "drive"), speed, {"units": _units("rad/s", turning)}),
    }
    about: dict[str, Any] = {"name": mechanism.name, "source": mechanism.file_name}
    about |= {"cycle": period, "warning": "; ".join(notes)}
    for name, line in lines.items():
        about[f"motor_{name}"] = [line.stall, line.no_load, line.gear_ratio]
    coordinates = {
        "drive": np.array(names, dtype=object),
        "turns": ("drive", np.array(turning)),
        "time": times,
    }
    return xr.Dataset(variables | series, coordinates, about)


COLUMNS = {
    "effort_peak": ("N m", "largest magnitude of the effort"),
    "effort_rms": ("N m", "root mean square of the effort"),
    "effort_mean": ("N m", "mean effort"),
    "speed_peak": ("rad/s", "largest magnitude of the speed"),
    "power_peak": ("W", "largest power"),
    "power_mean": ("W", "mean power"),
    "energy_given": ("J", "energy given in a cycle"),
    "energy_returned": ("J", "energy returned in a cycle"),
    "energy_fluctuation": ("J", "fluctuation of energy"),
    "flywheel": ("kg m^2", "inertia of a flywheel"),
    "margin": ("1", "least ratio of available to needed effort"),
    "margin_time": ("s", "when that is"),
}
"""Variable → its unit, of drives that turn, and its name."""

PUSHED = {"N m": "N", "rad/s": "m/s"}


def _units(unit: str, turning: Sequence[bool]) -> str:
    own = [unit if turns else PUSHED.get(unit, unit) for turns in turning]
    return " or ".join(dict.fromkeys(own))


def _cycle(mechanism: Mechanism) -> tuple[float, list[str]]:
    try:
        return common_period(mechanism), []
    except NoPeriodError as reason:
        end = mechanism.simulation.end
        return end, [f"the cycle is the whole run of {end:g} s: {reason}"]


def _speeds(solution: Solution) -> Floats:
    """Of all drives or actuators, shape (samples, drives)."""
    model = solution.system.model
    nodes = [own.rate(model.velocities) for own in model.actuators]
    nodes = nodes or [model.known_rates[name] for name in model.topology.driven]
    parts = [evaluate_nodes(piece.direct(), nodes) for piece in solution.motion.pieces]
    return np.concatenate(parts, axis=1).T


def _column(
    time: Floats,
    effort: Floats,
    speed: Floats,
    fluctuation: float | None,
    line: MotorLine | None,
    turns: bool,
) -> dict[str, float]:
    """Numbers of one drive."""
    cycle, power = time[-1] - time[0], effort * speed
    mean = float(np.trapezoid(speed, time)) / cycle
    result = {
        "effort_peak": float(np.abs(effort).max()),
        "effort_rms": math.sqrt(float(np.trapezoid(effort**2, time)) / cycle),
        "effort_mean": float(np.trapezoid(effort, time)) / cycle,
        "speed_peak": float(np.abs(speed).max()),
        "power_peak": float(power.max()),
        "power_mean": float(np.trapezoid(power, time)) / cycle,
        "energy_given": float(np.trapezoid(np.maximum(power, 0.0), time)),
        "energy_returned": float(np.trapezoid(np.maximum(-power, 0.0), time)),
    }
    result |= dict.fromkeys(("energy_fluctuation", "flywheel", "margin", "margin_time"), math.nan)
    if turns and np.ptp(speed) <= STEADY * abs(mean):
        excess = (effort - result["effort_mean"]) * mean
        steps = 0.5 * (excess[1:] + excess[:-1]) * np.diff(time)
        result["energy_fluctuation"] = float(np.ptp(np.append(0.0, np.cumsum(steps))))
        if fluctuation is not None:
            result["flywheel"] = result["energy_fluctuation"] / (fluctuation * mean**2)
    if line is not None:
        least, most = line.least_and_most(speed)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(effort >= 0.0, most / effort, least / effort)
        ratio = np.where(effort == 0.0, np.inf, ratio)
        place = int(np.argmin(ratio))
        result |= {"margin": float(ratio[place]), "margin_time": float(time[place])}
    return result


def _lines(
    mechanism: Mechanism, motors: Mapping[str, MotorLine] | Sequence[str]
) -> dict[str, MotorLine]:
    names = [*mechanism.actuations] or [*mechanism.prescribed]
    pairs = (
        list(motors.items()) if isinstance(motors, Mapping)
        else [(text.partition("=")[0].strip(), text.partition("=")[2]) for text in motors]
    )  # fmt: skip
    result: dict[str, MotorLine] = {}
    for name, given in pairs:
        if name not in names:
            near = suggestion(name, names) or f"; expected one of {listed(names)}"
            raise ValueError(f"motors: unknown drive {name!r}{near}")
        twists = mechanism.twisting(name)
        line = given if isinstance(given, MotorLine) else _read(name, given, twists)
        if not min(line.stall, line.no_load, line.gear_ratio) > 0.0:
            raise ValueError(f"motors: {name}: expected numbers > 0, found {line}")
        result[name] = line
    return result


def _read(name: str, text: str, twists: bool) -> MotorLine:
    parts = [part.strip() for part in text.split(",")]
    if not 2 <= len(parts) <= 3:
        raise ValueError(
            f"motors: expected a motor such as '{name}=30 N m, 1500 rpm' or with the ratio of a "
            f"gear, found {text!r}"
        )
    dimensions = (TORQUE if twists else FORCE, ANGULAR_SPEED if twists else SPEED, NUMBER)
    try:
        numbers = [
            parse_quantity(part, dimension, Bound.POSITIVE)
            for part, dimension in zip(parts, dimensions, strict=False)
        ]
    except QuantityError as error:
        raise ValueError(f"motors: {name}: {error}") from None
    return MotorLine(*numbers)
