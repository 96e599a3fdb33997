"""NetCDF 4: an attribute for each name."""

from __future__ import annotations

import io
import json


def put(content: bytes, text: str) -> bytes:
    """Write the entries of a JSON object as attributes."""
    import h5netcdf

    memory = io.BytesIO(content)
    with h5netcdf.File(memory, "a") as file:
        file.attrs.update(json.loads(text))
    return memory.getvalue()


def taken(content: bytes) -> str | None:
    """All attributes that are texts, as a JSON object."""
    import h5py

    try:
        with h5py.File(io.BytesIO(content), "r") as file:
            found = {name: value for name, value in file.attrs.items() if isinstance(value, str)}
    except OSError:  # another kind of file, or a damaged one
        return None
    return json.dumps(found, ensure_ascii=False)
