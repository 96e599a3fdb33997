"""SI prefixes that keep the numbers on an axis between 0.1 and 999."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

DEGREES = 180.0 / np.pi

_SYMBOLS = {9: "G", 6: "M", 3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p", -15: "f"}
# Which powers of ten are customary: nobody writes kilometres or kiloradians here.
_CUSTOMARY = {
    "m": (0, -3, -6, -9, -12, -15),
    "s": (0, -3, -6, -9),
    "rad": (0, -3, -6),
    "N": (6, 3, 0, -3, -6),
    "J": (9, 6, 3, 0, -3, -6, -9),
    "W": (9, 6, 3, 0, -3, -6, -9),
    "Hz": (9, 6, 3, 0, -3),
}
_UNIT = re.compile(r"([A-Za-z]+)((?:[·/][A-Za-z]+[²³]?)*)")


@dataclass(frozen=True)
class Scale:
    """How SI values are shown: multiplied by ``factor``, in ``units``."""

    factor: float
    units: str

    def label(self, quantity: str) -> str:
        """Axis label: the quantity, and its units in brackets where it has any."""
        return f"{quantity} [{self.units}]" if self.units else quantity

    def text(self, value: float) -> str:
        """An SI value as shown, with four significant digits and its units."""
        shown = f"{value * self.factor:.4g}"
        if "e+0" in shown:
            shown = f"{float(shown):.0f}"  # as ticks have it
        space = "" if self.units == "°" else " "
        return f"{shown.replace('-', '−')}{space}{self.units}".rstrip()


def scale_of(values: ArrayLike, units: str) -> Scale:
    """The scale for values by the largest of their magnitudes.

    Parameters
    ----------
    values
        In SI units; values that are not finite are passed over.
    units
        Such as ``"m/s²"`` (or ``"m/s^2"``, and ``"N m"`` for N·m). The prefix goes to the
        first unit; units that are unknown get none.
    """
    return scale_for(largest_magnitude(values), units)


def axis_scale(values: ArrayLike, units: str) -> Scale:
    """The scale of an axis: like `scale_of`, but angles are shown in degrees."""
    return Scale(DEGREES, "°") if units == "rad" else scale_of(values, units)


def scale_for(peak: float, units: str) -> Scale:
    """The scale for values up to `peak`; like `scale_of`."""
    shown = units.replace("**", "^").replace("^2", "²").replace("^3", "³")
    shown = shown.replace("*", "·").replace(" ", "·")
    if shown in ("", "1"):
        return Scale(1.0, "")
    match = _UNIT.fullmatch(shown)
    powers = _CUSTOMARY.get(match.group(1), (0,)) if match else (0,)
    power = _power(peak, powers)
    return Scale(10.0**-power, _SYMBOLS[power] + shown)


def _power(peak: float, powers: tuple[int, ...]) -> int:
    """The power of ten of the prefix; `powers` go down."""
    if peak == 0.0 or 0.1 <= peak < 1000.0:
        return 0
    return next((power for power in powers if peak >= 10.0**power), powers[-1])


def largest_magnitude(values: ArrayLike) -> float:
    """The largest magnitude among finite values, 0 if there are none."""
    array: NDArray[np.float64] = np.abs(np.asarray(values, dtype=float))
    return float(np.max(array, initial=0.0, where=np.isfinite(array)))


def nice_below(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 2.0, 5.0]) * power
    return float(steps[steps <= value * (1 + 1e-9)].max(initial=power))
