"""All that a page carries, put together."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.exports.kernels.javascript import javascript_module
from linkages.kernel.outputs import VARIABLES
from linkages.kernel.system import System
from linkages.options.run import SimulationOptions
from linkages.plots.films import insets, journals
from linkages.plots.mechanism.palette import DARK, LIGHT
from linkages.plots.prefixes import scale_for
from linkages.plots.style import PALETTE
from linkages.solution.options import options_of
from linkages.solution.origin import origin_of
from linkages.solution.remarks.stops import COULD_PASS
from linkages.solution.values.series import system_series
from linkages.viewer.described import described
from linkages.viewer.drawn import drawn
from linkages.viewer.frames import chosen
from linkages.viewer.ideal import ideal_module
from linkages.viewer.packed import Packed
from linkages.viewer.page import page
from linkages.viewer.recorded import recorded
from linkages.viewer.template import template

if TYPE_CHECKING:
    import xarray as xr

SAID = ("end", "samples", "method", "rtol", "atol", "step")
"""Options that a page names; it carries all of them."""

PEAKS = [0.0, *(10.0**power for power in range(-18, 13))]
"""Sizes from which another prefix may be customary."""


def written(
    mechanism: Mechanism,
    data: xr.Dataset,
    options: Mapping[str, Any],
    notes: Sequence[str],
    failure: object,
) -> str:
    """The text of the page.

    Parameters
    ----------
    mechanism, data
        What moves, and its motion.
    options, notes, failure
        How it was computed, what is to be said of it, and why it stopped, if it did.
    """
    system, packed = System(mechanism), Packed()
    origin = origin_of(mechanism, options)
    content = {
        "mechanism": described(system),
        "summary": _summary(system),
        "motion": recorded(data, system, packed),
        **drawn(data.isel(time=chosen(data)), mechanism),
        "notes": [*notes, *([f"The motion stopped {failure}"] if failure is not None else [])],
        "stopped": None if failure is None else _without_options(str(failure)),
        "how": _how(origin),
        "origin": origin,
        "scales": _scales(data),
        "rates": {name: found.rate for name, found in VARIABLES.items() if found.rate},
        "palette": {"light": dict(LIGHT), "dark": dict(DARK)},
        "lines": {"light": list(PALETTE), "dark": [_paler(colour) for colour in PALETTE]},
        "series": _known(system, [str(name) for name in data.data_vars]),
        "tolerances": _tolerances(mechanism, options),
        "template": template(mechanism),
        "file": f"{Path(mechanism.source).stem or 'mechanism'}.yaml",
        "glass": {"pin": journals.PIN, "hole": journals.HOLE, "wall": journals.WALL,
                  "reach": insets.REACH, "longest": insets.LONGEST},
    }  # fmt: skip
    given = {name: value for name, value in options.items() if name == "change_points"}
    passing = options_of(SimulationOptions, mechanism, given)
    models = {
        "model": _without_options(javascript_module(system, passing)),
        "ideal": _without_options(ideal_module(system, passing)),
    }
    return page({**content, "numbers": packed.text()}, models)


def _known(system: System, outputs: list[str]) -> dict[str, dict[str, Any]]:
    """Name of a series → what a page knows of it beside its values, of some outputs."""
    found = {}
    for name, series in system_series(system).items():
        if series.variable not in outputs or VARIABLES[series.variable].flags:
            continue
        variable = VARIABLES[series.variable]
        units, label = variable.described(system.model)
        found[name] = {"variable": series.variable, "place": list(series.place.values()),
                       "unit": units, "label": label, "angle": variable.angle,
                       "smooth": variable.smooth, "compared": variable.compared}  # fmt: skip
    return found


def _tolerances(mechanism: Mechanism, options: Mapping[str, Any]) -> dict[str, float]:
    """How exactly a page computes motions: as this one, and all of a state as its finest part."""
    said = {**asdict(options_of(SimulationOptions, mechanism, {})), **options}
    rtol, atol = said["rtol"], said["atol"]
    if atol is None:
        atol = rtol * min([1.0, *(contact.size.value for contact in mechanism.contacts)])
    return {"rtol": rtol, "atol": atol}


def _paler(colour: str) -> str:
    """A colour of lines on white as it is seen as well on dark paper; black becomes pale grey."""
    share = 0.85 if colour == "#000000" else 0.35
    parts = [int(colour[at : at + 2], 16) for at in (1, 3, 5)]
    return "#" + "".join(f"{round(part + share * (255 - part)):02X}" for part in parts)


def _without_options(text: str) -> str:
    """Reasons of stops without what only the file's author can change."""
    return text.replace(f" ({COULD_PASS})", "")


def _summary(system: System) -> str:
    """Mobility and what is driven and free, in a line."""
    topology = system.topology
    moved = [
        f"{word} {', '.join(names)}"
        for word, names in (("driven:", topology.driven), ("free:", topology.free))
        if names
    ]
    return "; ".join([f"Mobility {topology.mobility}", *moved])


def _how(origin: dict[str, str]) -> str:
    """By which version, with which options."""
    options = json.loads(origin["options"])
    said = [f"{name} {options[name]}" for name in SAID if options.get(name) is not None]
    return f"Computed by {origin['version']}: {', '.join(said)}."


def _scales(data: xr.Dataset) -> dict[str, list[tuple[float, float, str]]]:
    """Unit → from which size values are shown times what, in which unit."""
    units = {"s", "m", "N", "N m"} | {
        str(array.attrs["units"]) for array in data.data_vars.values()
    }
    found = {}
    for unit in sorted(units):
        steps: list[tuple[float, float, str]] = []
        for peak in PEAKS:
            scale = scale_for(peak, unit)
            if not steps or steps[-1][1:] != (scale.factor, scale.units):
                steps.append((peak, scale.factor, scale.units))
        found[unit] = steps
    return found
