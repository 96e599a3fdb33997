"""Results on disk: written under a temporary name, then renamed."""

from __future__ import annotations

import csv
import io
import logging
import math
import os
import platform
import re
import shutil
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

LOGGER = logging.getLogger(__name__)

HOST = re.sub(r"[^A-Za-z0-9.]", "", platform.node()) or "host"
_TEMPORARY = re.compile(r"\.linkages-([A-Za-z0-9.]+)-(\d+)-\w+(\.\w+)?")
ABANDONED = 86_400.0
"""Age in seconds from which on a temporary file is nobody's, whoever made it."""


@contextmanager
def replaced(path: Path) -> Iterator[Path]:
    """A temporary path beside `path` that takes its place if all goes well."""
    path.parent.mkdir(parents=True, exist_ok=True)
    remove_leftovers(path.parent)
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=prefix(), suffix=path.suffix)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        temporary.replace(path)
        if not any(part.startswith(".linkages") for part in path.parent.parts):
            LOGGER.info("wrote %s", path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def prefix() -> str:
    """Begins the name of what is temporary, and says whose it is."""
    return f".linkages-{HOST}-{os.getpid()}-"


def remove_leftovers(folder: Path) -> None:
    """Remove the temporary files and folders of processes that were killed."""
    for path in folder.iterdir():
        match = _TEMPORARY.fullmatch(path.name)
        if match is None or not _abandoned(path, match[1], int(match[2])):
            continue
        LOGGER.info("removing what a process that was killed has left: %s", path)
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink(missing_ok=True)


def _abandoned(path: Path, host: str, process: int) -> bool:
    """Whether the process that made a temporary file is gone."""
    if os.name == "posix" and host == HOST:
        try:
            os.kill(process, 0)  # on Windows that would end it
        except ProcessLookupError:
            return True
        except OSError:
            return False  # somebody else's
    try:
        return time.time() - path.stat().st_mtime > ABANDONED
    except FileNotFoundError:
        return False


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
    save_netcdf(data, netcdf)
    with replaced(text) as temporary:
        _write_table(data, temporary)
    return [netcdf, text]


def save_netcdf(data: xr.Dataset, path: Path) -> Path:
    """Write a dataset as NetCDF 4: into memory first, for HDF5 does not survive a full disk."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    memory = io.BytesIO()
    with closing(H5NetCDFStore(h5netcdf.File(memory, "w"))) as store:
        data.dump_to_store(store)
    with replaced(path) as temporary:
        temporary.write_bytes(memory.getbuffer())
    return path


def stamp(path: Path, attributes: Mapping[str, str]) -> None:
    """Write more attributes into a NetCDF file."""
    import h5netcdf

    memory = io.BytesIO(path.read_bytes())
    with h5netcdf.File(memory, "a") as file:
        file.attrs.update(attributes)
    with replaced(path) as temporary:
        temporary.write_bytes(memory.getbuffer())


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
