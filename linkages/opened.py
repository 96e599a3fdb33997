"""Results that were written to disk, read again, and computed again."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from inspect import Parameter, signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.analyses import analyses, options_of_analysis
from linkages.components.mechanisms.definition import loads
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import InputError, Problem
from linkages.options.option import asked_in
from linkages.reading.wording import listed
from linkages.stamps import read_origin

if TYPE_CHECKING:
    import xarray as xr

ENDING = ".nc"

MOST_PER_BYTE = 20
"""Bytes of data per byte of a file. Ours are not compressed; other programs may do that."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Opened:
    """Results of an analysis, with everything that is needed to compute them again.

    Parameters
    ----------
    file
        The NetCDF file that they stand in.
    data
        What it has: labelled arrays in SI, with ``units`` and ``long_name``.
    definition
        Of the mechanism, as YAML text with all values put in.
    options
        How it was computed: the `simulate` section, and over it `arguments`.
    arguments
        What the analysis was given; nothing of where it ran, and nothing that it does not take.
    analysis
        Its name, such as ``"simulate"``.
    version
        Of this package, when it was computed.
    command
        What was typed; empty where Python called.
    notes
        What could not be computed, or was assumed.
    complete
        Whether the analysis came to its end.
    """

    file: Path
    data: xr.Dataset
    definition: str
    options: Mapping[str, Any]
    arguments: Mapping[str, Any]
    analysis: str
    version: str
    command: str
    notes: tuple[str, ...]
    complete: bool

    def __repr__(self) -> str:
        return f"Opened({str(self.file)!r}, {self.analysis} of {self.mechanism.name!r})"

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism as it was computed."""
        return loads(self.definition)

    def compute(self) -> Any:
        """Compute it again.

        Returns
        -------
        What the function of that name returns, such as a `Solution` of `linkages.simulate`. With
        the same version, on the same machine, its numbers are the same to the last bit.

        Raises
        ------
        InputError
            If the file is part of the results of another analysis, which has no function here, or
            does not store all that this function needs.
        """
        function = self._function()
        known = signature(function).parameters
        said = self.arguments.items()
        given: dict[str, Any] = {n: v for n, v in said if n in known and v is not None}
        needed = [name for name, each in known.items() if each.default is Parameter.empty][1:]
        missing = [name for name in needed if name not in (*given, "results")]
        if missing:
            message = f"{self.analysis} needs {', '.join(missing)}; the file stores none"
            problem = Problem(path="origin.arguments", message=message)
            raise InputError(str(self.file), [problem])
        if "results" in known:  # what it was computed from stands beside them
            given["results"] = self.data
        return function(self.mechanism, **given)

    def _function(self) -> Callable[..., Any]:
        if self.analysis in ANALYSES:
            module, name = ANALYSES[self.analysis].split(":")
            return getattr(import_module(module), name)
        others = {name.replace("_", "-"): analysis for name, analysis in analyses().items()}
        if self.analysis in others:
            return others[self.analysis]
        known = listed(sorted([*ANALYSES, *others]))
        again = f"; it was computed by `{self.command}`" if self.command else ""
        message = f"{self.analysis!r} is not computed again; expected one of {known}{again}"
        raise InputError(str(self.file), [Problem(message=message)])


ANALYSES = {
    "simulate": "linkages.solution.simulate:simulate",
    "poincare": "linkages.chaos.sections:poincare",
    "lyapunov": "linkages.chaos.lyapunov:lyapunov",
    "orbit": "linkages.orbits.orbit:orbit",
    "follow": "linkages.orbits.follow:follow",
    "equilibrium": "linkages.equilibria.equilibrium:equilibrium",
    "wear": "linkages.tribology.cycle_jumps:wear",
    "bifurcation": "linkages.attractors.hysteresis:diagram_asked",
    "map": "linkages.chaos.maps:chaos_map",
    "basins": "linkages.attractors.basins:basins",
    "sweep": "linkages.sweeps.sweep:sweep_asked",
    "sensitivity": "linkages.design.sensitivities:sensitivity_asked",
    "optimise": "linkages.design.optimise:optimise",
    "fit": "linkages.design.fit:fit_asked",
    "tolerance": "linkages.design.tolerance:tolerance",
    "workspace": "linkages.design.workspace:workspace",
    "duty": "linkages.design.duty:duty",
}
"""Name of a file of results → the function of this package that computes them."""


def open(path: str | Path) -> Opened:  # noqa: A001
    """Open results that were saved.

    Parameters
    ----------
    path
        A NetCDF file, or a folder with results: of `simulate` if there are several.

    Raises
    ------
    InputError
        If there is no such file, or it does not say what it was computed from.

    Examples
    --------
    >>> import linkages, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = linkages.simulate(linkages.load("pendulum"), end=1.0).save(folder)
    ...     opened = linkages.open(folder)
    >>> opened.mechanism == linkages.load("pendulum")
    True
    >>> opened.compute().data.bar_angle.equals(opened.data.bar_angle)
    True
    """
    import xarray as xr

    if not isinstance(path, str | Path):
        raise TypeError(f"path must be a file or a folder, found {path!r}")
    file = _file(Path(path))
    try:
        _require_own_data(file)
        with xr.open_dataset(file, engine="h5netcdf", phony_dims="access") as stored:
            _require_size(stored.nbytes, file)
            data = stored.load()
    except InputError:
        raise
    except Exception as error:  # HDF5 and its readers raise whatever comes for a damaged file
        raise InputError(str(file), [Problem(message=f"cannot be read: {error}")]) from None
    origin = None
    if "options" in data.attrs:
        texts = {name: value for name, value in data.attrs.items() if isinstance(value, str)}
        origin = read_origin(json.dumps(texts), str(file))
    if origin is None:
        message = "does not say what it was computed from; expected results of this package"
        raise InputError(str(file), [Problem(message=message)])
    analysis = origin.analysis or origin.verb or file.stem
    return Opened(
        file=file,
        data=data,
        definition=origin.definition,
        options=origin.options,
        arguments=asked_in(origin.arguments, str(file), _options_of(analysis)),
        analysis=analysis,
        version=origin.version,
        command=origin.command,
        notes=tuple(origin.notes),
        complete=origin.complete == "yes",
    )


def _require_own_data(file: Path) -> None:
    """Refuse HDF5 files that take data from other files, as links, raw storage or virtual sets."""
    import h5py

    with h5py.File(file, "r") as opened:
        for name in opened:
            link = opened.get(name, getlink=True)
            result = opened[name] if isinstance(link, h5py.HardLink) else None
            if result is None or (
                isinstance(result, h5py.Dataset) and (result.external or result.is_virtual)
            ):
                message = f"{name!r} is in another file; expected results that linkages wrote"
                raise InputError(str(file), [Problem(message=message)])


def _require_size(size: int, file: Path) -> None:
    """Refuse a file that says to have far more data than it has bytes."""
    if size > MOST_PER_BYTE * file.stat().st_size:
        message = f"is damaged: {file.stat().st_size} bytes are to hold {size} bytes of data"
        raise InputError(str(file), [Problem(message=message)])


def _options_of(analysis: str) -> list[str]:
    """Options of an analysis that describes them itself."""
    return [] if analysis in ANALYSES else options_of_analysis(analysis)


def _file(path: Path) -> Path:
    if path.is_file():
        return path
    if not path.is_dir():
        message = "no such file or folder; expected results of this package"
        raise InputError(str(path), [Problem(message=message)])
    result = sorted(path.glob(f"*{ENDING}"))
    wanted = [file for file in result if file.stem == "simulate"] or result
    if len(wanted) == 1:
        return wanted[0]
    names = listed([file.name for file in result]) if result else "none"
    message = f"expected a folder with one file of results, found {names}"
    raise InputError(str(path), [Problem(message=message)])
