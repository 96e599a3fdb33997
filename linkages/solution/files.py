"""Results on disk: written under a temporary name, then renamed."""

from __future__ import annotations

import csv
import logging
import math
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

LOGGER = logging.getLogger(__name__)


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place if all goes well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
        LOGGER.info("wrote %s", path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def save_dataset(data: xr.Dataset, folder: Path, stem: str) -> list[Path]:
    """Write a dataset as NetCDF 4 and as CSV with a column per series.

    Parameters
    ----------
    data
        Its first dimension is time.
    folder
        Made if it does not exist.
    stem
        File name without ending.
    """
    netcdf, text = folder / f"{stem}.nc", folder / f"{stem}.csv"
    with replaced(netcdf) as temporary:
        data.to_netcdf(temporary, engine="h5netcdf")
    with replaced(text) as temporary:
        _write_table(data, temporary)
    return [netcdf, text]


def _write_table(data: xr.Dataset, path: Path) -> None:
    """One column per series, headed ``variable[element] (units)``; all digits."""
    heads = ["time (s)"]
    columns = [data["time"].to_numpy()[:, None]]
    for name, array in data.data_vars.items():
        labels = [data[dim].to_numpy() for dim in array.dims[1:]]
        for place in np.ndindex(*array.shape[1:]):
            element = ".".join(str(names[i]) for names, i in zip(labels, place, strict=True))
            head = f"{name}[{element}]" if element else str(name)
            heads.append(f"{head} ({array.attrs['units']})")
        # not −1: there may be no samples
        columns.append(array.to_numpy().reshape(array.sizes["time"], math.prod(array.shape[1:])))
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(np.concatenate(columns, axis=1).tolist())
