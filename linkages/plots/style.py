"""The look of all figures: colours, fonts, panels, legends, and how quantities are labelled."""

from __future__ import annotations

import logging
import math
import re
import textwrap
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, fontManager, get_font
from matplotlib.rcsetup import cycler
from matplotlib.text import Text
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import ArrayLike, NDArray

from linkages.kernel.outputs import VARIABLES
from linkages.reading.paths import dotted, split
from linkages.solution.series import Series, element_name

if TYPE_CHECKING:
    import xarray as xr

LOGGER = logging.getLogger(__name__)

# Okabe & Ito (2008), without their yellow, which is too light for a line on white; two more.
PALETTE = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
    "#000000",
    "#7A4B9A",
    "#8C6D31",
)
# Five line styles against nine colours: 45 different lines, told apart in black and white too.
DASHES: tuple[Any, ...] = (
    "-",
    (0, (5, 1.6)),
    (0, (1.2, 1.2)),
    (0, (7, 1.5, 1.2, 1.5)),
    (0, (3, 1)),
)

BLACK, GREY, PALE = "#1A1A1A", "#8A8A8A", "#D9D9D9"
DRIVEN, FREE, PASSIVE, CLEARANCE = "#D55E00", "#0072B2", "#4D5B66", "#B0006A"
LOAD = "#7A4B9A"

FALLBACKS = (
    "Noto Sans CJK SC", "Noto Sans CJK JP", "Noto Sans CJK KR", "Noto Sans SC", "Microsoft YaHei",
    "PingFang SC", "Hiragino Sans", "Apple SD Gothic Neo", "Malgun Gothic", "WenQuanYi Micro Hei",
    "Arial Unicode MS",
)  # fmt: skip
"""Fonts for characters that DejaVu Sans does not have."""

WIDTH = 704 / 96
"""Inches of all figures: 704 pixels of a page, on which letters have the size that they say."""

LEFT, RIGHT, TOP, BOTTOM = 0.78, 0.18, 0.34, 0.5
"""Inches beside pictures of the plane, whose size must be known before anything is drawn."""

SINGLE = 3.6  # inches: height of a diagram that stands alone
TEXT = 8.5  # points of all letters: 11 pixels of a page
LINE = 0.165  # inches of a line of a legend or a title
_OWN = {
    "figure.dpi": 144,
    "savefig.dpi": "figure",
    "font.size": TEXT,
    "axes.titlesize": TEXT,
    "axes.titlelocation": "left",
    "axes.titlepad": 5.0,
    "axes.titley": 1.0,  # else every tick label is measured twice for a place that is known
    "axes.labelsize": TEXT,
    "axes.linewidth": 0.7,
    "axes.formatter.useoffset": False,
    "axes.prop_cycle": cycler(color=PALETTE),
    "text.parse_math": False,  # names are text, whatever signs they have
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.labelsize": TEXT,
    "ytick.labelsize": TEXT,
    "legend.fontsize": TEXT,
    "legend.frameon": False,
    "legend.handlelength": 2.4,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 1.1,
    "hatch.linewidth": 0.5,
    "figure.constrained_layout.h_pad": 0.06,
    "figure.constrained_layout.w_pad": 0.08,
    "agg.path.chunksize": 20_000,
    "pdf.fonttype": 42,
    "svg.hashsalt": "linkages",
}


@cache
def _settings() -> dict[Any, Any]:
    groups = {key.split(".")[0] for key in _OWN} | {"path", "patch", "mathtext", "hatch"}
    defaults = matplotlib.rcParamsDefault.items()
    installed = {font.name for font in fontManager.ttflist}
    own = _OWN | {"font.family": ["DejaVu Sans", *(f for f in FALLBACKS if f in installed)]}
    return {key: value for key, value in defaults if key.split(".")[0] in groups} | own


def note_missing_glyphs(figure: Figure) -> None:
    """Log, once in a process, which characters of a figure no font of this machine has."""
    characters = {c for text in figure.findobj(Text) for c in text.get_text() if c.isprintable()}
    missing = sorted(c for c in characters if not _drawable(c))
    if missing and not _said:
        _said.update(missing)
        LOGGER.warning(
            "figures show boxes for %s: no font that was found has these characters; expected one "
            "of: %s",
            "".join(missing),
            ", ".join(FALLBACKS),
        )


_said: set[str] = set()


@cache
def _drawable(character: str) -> bool:
    families = _settings()["font.family"]
    return any(get_font(findfont(f)).get_char_index(ord(character)) for f in families)


@contextmanager
def style() -> Iterator[None]:
    """Draw and save in the style of the project, whatever the user's own settings are."""
    with matplotlib.rc_context(_settings()), warnings.catch_warnings():
        # `note_missing_glyphs` says it once
        warnings.filterwarnings("ignore", r"Glyph \d+ .* missing from", UserWarning)
        yield


styled = style()
"""Decorator: run a function that draws a figure inside `style`."""


def line_style(index: int) -> dict[str, Any]:
    """Colour and dashes of the line with this number."""
    return {"color": PALETTE[index % len(PALETTE)], "linestyle": DASHES[index % len(DASHES)]}


def letters(inches: float, size: float = TEXT) -> int:
    """How many letters so many inches hold, roughly, at a font size in points."""
    return max(12, int(inches * 72.0 / (0.58 * size)))


def filled(text: str, inches: float, size: float = TEXT) -> str:
    """Text in as many lines as its room needs, none of it cut."""
    return textwrap.fill(text, letters(inches, size))


def width_of(ax: Axes) -> float:
    """Inches from the left to the right of axes, roughly where their layout is still to come."""
    figure = figure_of(ax)
    return float(ax.bbox.width / figure.dpi) * (1.12 if figure.get_layout_engine() else 1.0)


def set_title(ax: Axes, text: str, note: str = "") -> None:
    """Say what axes show, in lines that they have room for, and at the right a note about it."""
    shown = filled(text, width_of(ax) - len(note) * TEXT * 0.56 / 72.0)
    ax.set_title(shown)
    make_room(ax, shown)
    if note:
        ax.set_title(note, loc="right", color="0.35")


def set_heading(figure: Figure, text: str) -> None:
    """Say above all panels what a figure shows."""
    shown = filled(text, figure.get_figwidth())
    if isinstance(figure, Page):
        figure.set_figheight(figure.get_figheight() + LINE * (1 + shown.count("\n")))
    width, height = figure.get_size_inches()
    place: dict[str, Any] = {"x": 0.08 / width, "ha": "left", "va": "top"}
    if figure.get_layout_engine() is None:  # which knows its height otherwise
        place["y"] = 1 - 0.06 / height
    figure.suptitle(shown, fontsize=TEXT, weight="bold", **place)


def make_room(ax: Axes, text: str) -> None:
    """Make a page of panels higher by the lines above axes for which it has no room yet."""
    figure, place = figure_of(ax), ax.get_subplotspec()
    if isinstance(figure, Page) and place is not None:
        figure.reserve(place.rowspan.start, text.count("\n"))


def title(heading: str, name: str) -> str:
    """What is shown, after whose it is; either may be empty."""
    return ": ".join(filter(None, (heading, name)))


def name_of(data: xr.Dataset) -> str:
    """Of the mechanism that data belong to."""
    return str(data.attrs.get("name", ""))


class Page(Figure):
    """Panels that Matplotlib lays out; what is written above a row makes the page higher."""

    def __init__(self, height: float, width: float = WIDTH) -> None:
        super().__init__(figsize=(width, height), layout="constrained")
        self._lines: dict[int, int] = {}

    def reserve(self, row: int, lines: int) -> None:
        """Make room for lines above a row of panels, besides the first one."""
        more = lines - self._lines.get(row, 0)
        if more > 0:
            self._lines[row] = lines
            self.set_figheight(self.get_figheight() + LINE * more)


def figure_of(ax: Axes) -> Figure:
    """The figure that has axes."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return figure


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
MANY = 1e4  # values of a unit without a prefix from which on a power of ten is taken out of them
RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

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
        space = "" if self.units == "°" else "·" if self.units.startswith("10") else " "
        return f"{shown.replace('-', '−')}{space}{self.units}".rstrip()


ChosenUnit = Callable[[str], tuple[str, float] | None]
"""A unit of SI → the unit that a user wants instead and the factor to it; None for a default."""

_chosen: ContextVar[ChosenUnit] = ContextVar("chosen", default=lambda _: None)


@contextmanager
def shown_in(chosen: ChosenUnit) -> Iterator[None]:
    """Draw in the units that a user wants, where they are any, instead of prefixes and degrees."""
    before = _chosen.set(chosen)
    try:
        yield
    finally:
        _chosen.reset(before)


def scale_of(values: ArrayLike, units: str) -> Scale:
    """The scale for values by the largest of their magnitudes.

    `values`: in SI units; values that are not finite are passed over.
    `units`: such as ``"m/s²"`` (or ``"m/s^2"``, and ``"N m"`` for N·m). The prefix goes to the
    first unit; units that are unknown get none.
    """
    return scale_for(largest_magnitude(values), units)


def axis_scale(values: ArrayLike, units: str) -> Scale:
    """The scale of an axis: like `scale_of`, but angles are shown in degrees.

    Of large values that have no customary prefix a power of ten stands before the units.
    """
    if units == "rad" and _chosen.get()(units) is None:
        return Scale(DEGREES, "°")
    scale, peak = scale_of(values, units), largest_magnitude(values)
    if scale.factor != 1.0 or peak < MANY or not scale.units or _chosen.get()(units):
        return scale
    power = 3 * int(np.log10(peak) // 3)
    return Scale(10.0**-power, f"10{str(power).translate(RAISED)} {scale.units}")


def scale_for(peak: float, units: str) -> Scale:
    """The scale for values up to `peak`; like `scale_of`."""
    if units in ("", "1"):
        return Scale(1.0, "")
    chosen, factor = _chosen.get()(units) or (units, 0.0)
    shown = "°" if chosen in ("deg", "degree", "degrees") else chosen.replace("**", "^")
    shown = shown.replace("^2", "²").replace("^3", "³").replace("*", "·").replace(" ", "·")
    if factor:
        return Scale(factor, shown)
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


def show_powers(axis: Axis) -> None:
    """Ticks of a logarithmic axis at powers of ten."""
    axis.set_major_locator(LogLocator(numticks=9))
    axis.set_major_formatter(
        lambda value, _: f"10{str(round(math.log10(value))).translate(RAISED)}"
    )
    axis.set_minor_formatter(NullFormatter())


def nice_below(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** np.floor(np.log10(value))
    steps = np.array([1.0, 2.0, 5.0]) * power
    return float(steps[steps <= value * (1 + 1e-9)].max(initial=power))


@cache
def _quantities() -> dict[str, list[tuple[str, dict[str, str]]]]:
    """Quantity of a name → variables that have it, with an element for each dimension."""
    result: dict[str, list[tuple[str, dict[str, str]]]] = {}
    for variable, item in VARIABLES.items():
        for axis in ("x", "y", None) if "axis" in item.dims else (None,):
            place = {dim: axis or "" if dim == "axis" else "?" for dim in item.dims}
            place = {dim: label for dim, label in place.items() if label}
            quantity = element_name(variable, place).rpartition(".")[2]
            result.setdefault(quantity.replace(" ", "_"), []).append((variable, place))
    return result


def series_words(name: str, units: str = "") -> str:
    """What figures call a series: ``crank.effort`` is the driving torque of crank.

    `units`: tell torques from forces of drives. A quantity that several outputs have keeps its own
    word, as in the velocity of P. What is no series stays as it is written.
    """
    element, _, quantity = name.rpartition(".")
    known = _quantities().get(quantity.replace(" ", "_"), [])
    if not known or "[" in element or element.startswith("parameters"):
        return name
    known = [item for item in known if VARIABLES[item[0]].units == units] or known
    variable, place = known[0]
    item = VARIABLES[variable]
    words = item.pushed[1] if item.pushed and item.pushed[0] == units else item.long_name
    if len({VARIABLES[other].long_name for other, _ in known}) > 1:
        words = quantity.replace("_", " ").removeprefix(f"{place.get('axis', '')} ")
    dims = [dim for dim in place if dim != "axis"] if element else []
    parts = element.rsplit(".", len(dims) - 1) if dims else []
    axis = {"axis": place["axis"]} if "axis" in place else {}
    return Series(name, variable, dict(zip(dims, parts, strict=False)) | axis).words(words)


_NAME = re.compile(r"[^\W\d]\w*(?:\[\d+\])?(?:\.(?:[xy] )?[^\W\d]\w*)*(?!\w*\()")


def measure_words(text: str, units: str = "") -> str:
    """A measure with its series in words: ``max(driving torque of crank)``."""
    return _NAME.sub(lambda match: series_words(match.group(), units), text)


def path_words(path: str) -> str:
    """A dotted path in words: ``drives.crank.speed`` is the speed of crank.

    A path that leads to an entry of a section, or is none, stays as it is written.
    """
    match split(path):
        case ("clearances", str(name), "size"):
            return f"radial clearance {name}"
        case ("clearances", str(name), str(key)):
            return f"{_spaced(key)} of clearance {name}"
        case ("gravity", int(index)):
            return f"gravity along {'xy'[index]}"
        case ("joints", str(name), (0 | 1) as index):
            return f"{'xy'[index]} of joint {name}"
        case (_, str(name), "points", str(joint), (0 | 1) as index):
            return f"{'xy'[index]} of {joint} on {name}"
        case (_, str(name), str(key), (0 | 1) as index):
            return f"{'xy'[index]} of {_spaced(key)} of {name}"
        case ("parameters", str(name)):
            return f"parameter {name}"
        case ("masses", name):
            return f"mass at {name}"
        case (str(section), int(index), *between, str(key)):
            return f"{_spaced(key)} of {dotted((section, index, *between))}"
        case (_, str(name), *between, str(key)):
            return f"{_spaced(key)} of {dotted((name, *between))}"
        case ("simulate", str(key)):
            return _spaced(key)
        case _:
            return path


def _spaced(key: str) -> str:
    return key.replace("_", " ")
