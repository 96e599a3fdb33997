"""Results of analyses on disk: NetCDF, CSV and figures."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.chaos.sections.free_states import PAIRS
from linkages.reading.replacing import replaced
from linkages.solution.files import save_netcdf

__all__ = ["free_columns", "save_figures", "save_netcdf", "save_table"]

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def save_table(columns: Mapping[str, Any], path: Path) -> None:
    """Write a CSV file with a column per entry; all digits, nothing for nan.

    Parameters
    ----------
    columns
        Head → values, shape (rows,) each.
    path
        Where to.
    """
    with replaced(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        rows = zip(*(np.asarray(column).tolist() for column in columns.values()), strict=True)
        writer.writerows(["" if cell != cell else cell for cell in row] for row in rows)


def save_figures(
    figures: Mapping[str, Figure | None],
    folder: Path,
    format: str = "png",  # noqa: A002
) -> None:
    """Write the figures that there are as ``<name>.png``, or ``.svg``, or ``.pdf``."""
    from linkages.plots.figures import write_figure

    for name, figure in figures.items():
        if figure is not None:
            write_figure(figure, folder / f"{name}.{format}")


def free_columns(data: xr.Dataset) -> dict[str, Any]:
    """Head → series of every free coordinate and its rate, flattened over all other dimensions."""
    columns: dict[str, Any] = {}
    for name, array in data.data_vars.items():
        dim = str(array.dims[-1])
        if "crossing" not in array.dims or dim not in PAIRS:
            continue
        for element in data[dim].values:
            series = array.sel({dim: element}).to_numpy().ravel()
            columns[f"{name}[{element}] ({array.attrs['units']})"] = series
    return columns
