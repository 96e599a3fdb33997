"""Isoperiodic planes, and curves over two parameters on top of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import ArrayLike, NDArray

from linkages.chaos.strobed_motion import Regime
from linkages.orbits.loci import locus_values
from linkages.plots.chaos.diagrams import MAP_HEIGHT, OUTLINE, draw_cells
from linkages.plots.layout import axes_for, chart
from linkages.plots.style import DASHES, DEGREES, PALE, figure_of, name_of, set_title, styled
from linkages.spec.units import unit

if TYPE_CHECKING:
    import xarray as xr

SINGLE = 8  # periods with colours of their own; longer ones share one

# Neighbours in a cascade (1, 2, 4, 8) and frequent windows (3, 5, 6) differ in lightness as well.
PERIODS = (
    "#D6EAF8", "#5DADE2", "#F5B041", "#1F5FA8", "#58B368", "#C0392B", "#B7A5D9", "#0B2545",
    "#7D5A2F",
)  # fmt: skip
CHAOTIC, UNDECIDED, FAILED = "#3A3A3A", "#FFF36B", PALE
LINE, HALO = "#E6007E", "#FFFFFF"

Curves = Mapping[str, tuple[ArrayLike, ArrayLike]]
"""Label → x and y along a curve, in the units of the plane's coordinates."""


def classes(data: xr.Dataset) -> NDArray[np.int64]:
    """What each point is drawn as: its period, or −1 chaotic, −2 undecided, −3 not computed."""
    regime = data["regime"].transpose("y", "x").to_numpy()
    period = np.nan_to_num(data["indicator"].transpose("y", "x").to_numpy())
    others = {Regime.CHAOTIC: -1, Regime.UNDECIDED: -2, Regime.NOT_COMPUTED: -3}
    result = np.minimum(period, SINGLE + 1).astype(np.int64)
    for code, number in others.items():
        result[regime == code] = number
    return result


def class_looks() -> dict[int, tuple[str, str]]:
    """Number of a class → its colour and its words, in the order of the legend."""
    numbered = {number: (colour, f"period {number}") for number, colour in enumerate(PERIODS, 1)}
    numbered[SINGLE + 1] = (PERIODS[-1], f"period {SINGLE + 1} or more")
    others = {-1: (CHAOTIC, "chaotic"), -2: (UNDECIDED, "undecided"), -3: (FAILED, "not computed")}
    return numbered | others


@chart
def period_map(
    data: xr.Dataset, ax: Axes | None = None, *, curves: Curves | Sequence[xr.Dataset] = ()
) -> Axes:
    """The isoperiodic plane of `linkages.chaos_map` with the indicator ``"period"``.

    `curves`: What is drawn on top: loci of `linkages.follow` over the same parameters, or label → x
    and y along a curve, shape (n,) each, in the units of the coordinates of `data`. Nan ends a part
    of a curve.
    """
    own, ax = ax is None, axes_for(ax, MAP_HEIGHT)
    numbers, looks = classes(data), class_looks()
    order = np.array([*looks])
    places = np.argsort(order)
    cells = places[np.searchsorted(order[places], numbers)]
    colours = ListedColormap([colour for colour, _ in looks.values()])
    draw_cells(ax, data, cells.astype(float), colours, Normalize(-0.5, len(looks) - 0.5))
    entries: list[Patch | Line2D] = [
        Patch(facecolor=colour, label=words, **OUTLINE)
        for number, (colour, words) in looks.items()
        if (numbers == number).any()
    ]
    lines = curves if isinstance(curves, Mapping) else locus_curves(data, curves)
    entries += draw_curves(ax, data, lines)
    beside: dict[str, Any] = {
        "loc": "upper left",
        "bbox_to_anchor": (1.02, 1.0),
        "borderaxespad": 0.0,
    }
    ax.legend(handles=entries, handlelength=1.6, labelspacing=0.45, **(beside if own else {}))
    set_title(ax, name_of(data))
    return ax


def locus_curves(data: xr.Dataset, loci: Iterable[xr.Dataset]) -> Curves:
    """Loci that `linkages.follow` has found in the parameters of a plane, in its units, by kind.

    Raises ValueError if one is no locus, or one of other parameters.
    """
    paths = [str(data.attrs[dim]) for dim in ("x", "y")]
    units = [str(data[path].attrs["units"]) for path in paths]
    scales = [unit(each).scale if each else 1.0 for each in units]
    result: dict[str, NDArray[np.float64]] = {}
    for locus in loci:
        kind, values = locus_values(locus, paths)
        parts = [values / scales, np.full((1, 2), np.nan)]
        result[kind] = np.concatenate([result.get(kind, np.empty((0, 2))), *parts])
    return {kind: (values[:, 0], values[:, 1]) for kind, values in result.items()}


def draw_curves(ax: Axes, data: xr.Dataset, curves: Curves) -> list[Line2D]:
    """Draw curves over a plane, each in its dashes, within the limits that it has."""
    across, up = (_factor(data, dim) for dim in ("x", "y"))
    result: list[Line2D] = []
    for index, (label, (x, y)) in enumerate(curves.items()):
        dashes = DASHES[index % len(DASHES)]
        along = across * np.asarray(x, dtype=float), up * np.asarray(y, dtype=float)
        kept: dict[str, Any] = {"scalex": False, "scaley": False}
        ax.plot(*along, color=HALO, linewidth=2.6, **kept)
        look: dict[str, Any] = {"linewidth": 1.2, "linestyle": dashes, "label": label}
        result += ax.plot(*along, color=LINE, **look, **kept)
    return result


def _factor(data: xr.Dataset, dim: str) -> float:
    """What values of an axis are multiplied with where they are drawn."""
    return DEGREES if data[data.attrs[dim]].attrs.get("units") == "rad" else 1.0


@styled
def period_figure(data: xr.Dataset, curves: Sequence[xr.Dataset] = ()) -> Figure | None:
    """The plane with its legend; None where it would be of one colour."""
    return (
        figure_of(period_map(data, curves=curves))
        if curves or len(np.unique(classes(data))) > 1
        else None
    )
