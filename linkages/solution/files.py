"""Datasets on disk, and the origin of results."""

from __future__ import annotations

import csv
import io
import json
import platform
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.options.option import stored
from linkages.reading.output_files import replaced
from linkages.solution.series import LabelledArrays

if TYPE_CHECKING:
    import xarray as xr


def save_arrays(arrays: LabelledArrays, folder: Path, stem: str) -> list[Path]:
    """Write series of a motion as NetCDF 4 and as CSV with a column per series."""
    netcdf, text = folder / f"{stem}.nc", folder / f"{stem}.csv"
    content = _netcdf_of(arrays)
    with replaced(netcdf) as temporary:
        temporary.write_bytes(content)
    save_columns({f"{head} ({units})": values for head, units, values in series_of(arrays)}, text)
    return [netcdf, text]


def save_events(times: Mapping[str, NDArray[np.float64]], path: Path) -> Path:
    """Write when events happen as CSV, in the order of time; all digits."""
    rows = sorted((time, name) for name, item in times.items() for time in item.tolist())
    columns = {"time (s)": [time for time, _ in rows], "event": [name for _, name in rows]}
    save_columns(columns, path)
    return path


def save_netcdf(data: xr.Dataset, path: Path) -> Path:
    """Write a dataset as NetCDF 4: into memory first, for HDF5 does not survive a full disk."""
    content = netcdf_bytes(data)
    with replaced(path) as temporary:
        temporary.write_bytes(content)
    return path


def netcdf_bytes(data: xr.Dataset) -> bytes:
    """A dataset as NetCDF 4: equal datasets have equal bytes."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    memory = io.BytesIO()
    with closing(H5NetCDFStore(h5netcdf.File(memory, "w"))) as store:
        data.dump_to_store(store)
    return memory.getvalue()


def _netcdf_of(arrays: LabelledArrays) -> bytes:
    """The bytes that `netcdf_bytes` makes of the dataset of these arrays, without xarray."""
    import h5netcdf
    import h5py

    memory = io.BytesIO()
    with h5netcdf.File(memory, "w") as file:
        file.attrs.update(arrays.attrs)
        parts = {**arrays.variables, **arrays.coordinates}
        for dims, array, _ in parts.values():
            file.dimensions.update(
                (d, n) for d, n in zip(dims, array.shape, strict=True) if d not in file.dimensions
            )
        for name, (dims, array, attrs) in parts.items():
            text, number = array.dtype == object, array.dtype.kind == "f"
            variable = file.create_variable(
                name,
                dims,
                h5py.special_dtype(vlen=str) if text else array.dtype,
                fillvalue=np.nan if number else None,
            )
            variable.attrs.update(attrs)
            variable[...] = array
    return memory.getvalue()


def series_of(arrays: LabelledArrays) -> Iterator[tuple[str, str, NDArray[np.float64]]]:
    """``variable[element]``, units and values of each series; time first."""
    yield "time", "s", arrays.coordinates["time"][1]
    for name, (dims, array, attrs) in arrays.variables.items():
        labels = [arrays.coordinates[dim][1] for dim in dims[1:]]
        values = array.astype(float)
        for place in np.ndindex(*values.shape[1:]):
            element = ".".join(str(names[i]) for names, i in zip(labels, place, strict=True))
            head = f"{name}[{element}]" if element else str(name)
            yield head, str(attrs["units"]), values[:, *place]


def save_columns(columns: Mapping[Any, Any], path: Path, *, blank: bool = False) -> None:
    """Write columns as CSV with all digits; if that is wanted, with blanks for nan."""
    with replaced(path) as temporary, temporary.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        arrays = [np.asarray(column) for column in columns.values()]
        rows: Iterable[Iterable[Any]]
        if arrays and all(array.dtype == np.float64 for array in arrays):
            rows = np.stack(arrays, axis=1).tolist()  # a tenth faster than columns one by one
        else:
            rows = zip(*(array.tolist() for array in arrays), strict=True)
        if blank:
            rows = (["" if cell != cell else cell for cell in row] for row in rows)
        writer.writerows(rows)


DEFINITION = "definition"


def origin_of(mechanism: Mechanism, options: Mapping[str, Any]) -> dict[str, str]:
    """Attributes from which results can be computed again: text, and JSON of what is structured.

    They are ``version``, ``libraries``, ``options`` and, of these, the ``arguments`` that were
    given, ``definition`` with all values put in, and ``changes``, the assignments that made it out
    of its file. Places where a computation runs are left out; of paths, names are kept.
    """
    how = stored(options)
    said = {name: value for name, value in how.items() if value is not None}
    return {
        "version": f"linkages {version('linkages')}",
        "libraries": ", ".join(
            [f"Python {platform.python_version()}", *(f"{n} {version(n)}" for n in _LIBRARIES)]
        ),
        "options": json.dumps(how, default=_text, ensure_ascii=False),
        "arguments": json.dumps(said, default=_text, ensure_ascii=False),
        "changes": json.dumps(mechanism.changes, ensure_ascii=False),
        DEFINITION: mechanism.to_yaml(),
    }


_LIBRARIES = ("numpy", "scipy", "llvmlite")
"""Those that numbers may depend on."""


def _text(value: object) -> str:
    return value.name if isinstance(value, Path) else str(value)
