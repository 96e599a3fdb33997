"""Units of the Functional Mock-up Interface, run by FMPy."""

from __future__ import annotations

import atexit
import shutil
from contextlib import contextmanager
from functools import cache
from tempfile import mkdtemp

import fmpy
import numpy as np
from exported_states import PASSING, SWITCHED, kernel, system
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave

import linkages
from linkages.kernel.outputs import VARIABLES
from linkages.solution.series import data_series

ROOT = mkdtemp(prefix="linkages-units-")
atexit.register(shutil.rmtree, ROOT, ignore_errors=True)
KINDS = {
    ("3.0", "exchange"): FMU3Model,
    ("3.0", "steps"): FMU3Slave,
    ("2.0", "exchange"): FMU2Model,
    ("2.0", "steps"): FMU2Slave,
}


@cache
def written(name, version="3.0", inputs=()):
    """The path of a unit of a shipped mechanism or a scene."""
    return export(system(name).mechanism, version, inputs)


@cache
def unit_of(text, version="3.0", inputs=()):
    """The path of a unit of a definition."""
    return export(linkages.loads(text), version, inputs)


def export(mechanism, version="3.0", inputs=()):
    """The path of a unit."""
    folder = mkdtemp(dir=ROOT)
    (path,) = linkages.export(mechanism, "fmu", folder, name="unit", fmi=version, inputs=inputs)
    return path


@cache
def unpacked(path):
    """Description and folder of a unit."""
    return fmpy.read_model_description(str(path)), fmpy.extract(
        str(path), unzipdir=str(path.with_suffix(""))
    )


@contextmanager
def instance(path, kind="steps", messages=None):
    """An instance before its initialization; messages are kept in a list."""
    description, folder = unpacked(path)
    own = description.coSimulation if kind == "steps" else description.modelExchange
    made = KINDS[description.fmiVersion, kind](
        guid=description.guid, unzipDirectory=folder, modelIdentifier=own.modelIdentifier
    )
    said = [] if messages is None else messages

    def log(*given):
        said.append(b" ".join(part for part in given if isinstance(part, bytes)).decode())

    if description.fmiVersion == "2.0":
        from fmpy.fmi2 import defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(log)
        callbacks.allocateMemory = defaultCallbacks.allocateMemory
        callbacks.freeMemory = defaultCallbacks.freeMemory
        made.instantiate(callbacks=callbacks)
    else:
        made.instantiate(logMessage=log)
    try:
        yield made
    finally:
        made.freeInstance()


def references(path):
    """Name → value reference."""
    return {v.name: v.valueReference for v in unpacked(path)[0].modelVariables}


def get(made, names, path):
    """Values of variables."""
    known = references(path)
    read = made.getFloat64 if hasattr(made, "getFloat64") else made.getReal
    return np.array(read([known[name] for name in names]))


def put(made, values, path):
    """Set variables by their names."""
    known = references(path)
    write = made.setFloat64 if hasattr(made, "setFloat64") else made.setReal
    write([known[name] for name in values], [*values.values()])


def start(made, values=None, path=None, **options):
    """Initialize an instance with numbers and inputs."""
    put(made, values or {}, path)
    if hasattr(made, "setupExperiment"):
        made.setupExperiment(**options)
        made.enterInitializationMode()
    else:
        made.enterInitializationMode(**options)
    made.exitInitializationMode()


def channel(path, causality):
    """Names of the variables of a causality."""
    return [v.name for v in unpacked(path)[0].modelVariables if v.causality == causality]


def end_of(name):
    """For how long a mechanism is followed."""
    if name in PASSING:
        return PASSING[name][1]
    return SWITCHED.get(name) or min(system(name).mechanism.simulation.end, 0.3)


def differences(name, table, times):
    """Variable → largest difference from `simulate`, in units of the largest value or of one.

    Left out is what grows without bound at change points.
    """
    own = [
        q
        for q in kernel(name).quantities
        if not (VARIABLES[q.variable].unbounded or VARIABLES[q.variable].reciprocal)
        and q.name in table.dtype.names
    ]
    outputs = sorted({q.variable for q in own})
    data = linkages.simulate(system(name).mechanism, times=times, rtol=1e-12, outputs=outputs).data
    series = data_series(data)
    result = {}
    for q in own:
        expected = series[q.name].of(data).values
        difference = table[q.name][: len(times)] - expected
        if VARIABLES[q.variable].angle:
            difference = np.remainder(difference + np.pi, 2 * np.pi) - np.pi
        error = np.abs(difference).max() / max(1.0, np.abs(expected).max())
        result[q.variable] = max(result.get(q.variable, 0.0), error)
    return result
