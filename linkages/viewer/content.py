"""The page of a motion, and its content."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import asdict, replace
from functools import cache
from html import escape
from importlib.resources import files
from itertools import combinations
from math import dist
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, assert_never

from linkages.chaos.common_period import NoPeriodError, common_period
from linkages.components.contributed.load_measures import (
    BodyAxis,
    Coordinate,
    Distance,
    Measure,
    Slide,
    Turn,
)
from linkages.components.contributed.terms import GUIDED, UNSEEN, Body, Parameter
from linkages.components.mechanisms.mechanism import Mechanism
from linkages.components.transmissions import Cam, Gear, Rack
from linkages.exports.writers.source_code import javascript_module
from linkages.kernel.number_effects import written
from linkages.kernel.outputs import VARIABLES, coordinate_of
from linkages.kernel.system import System
from linkages.opened import Opened
from linkages.options.run import SimulationOptions
from linkages.plots.films import insets
from linkages.plots.films.insets import HOLE, PIN, WALL
from linkages.plots.mechanism.inked_shapes import DARK, LIGHT
from linkages.plots.mechanism.roles import clearance_ends
from linkages.plots.style import PALETTE, path_words, scale_for
from linkages.reading.output_files import replaced
from linkages.reading.overrides import as_yaml
from linkages.reading.paths import split
from linkages.reports import pages as notebook
from linkages.solution.files import origin_of
from linkages.solution.run_options import options_of
from linkages.solution.series import system_series
from linkages.solution.simulate import simulate
from linkages.solution.solution import Solution
from linkages.solution.stop_messages import COULD_PASS
from linkages.viewer.recorded import (
    Packed,
    chosen,
    deflated,
    dense,
    drawn,
    ideal_module,
    recorded,
    wanted,
)

if TYPE_CHECKING:
    import xarray as xr


ACTING = {"force": "load_force", "torque": "load_torque", "spring": "spring_force",
          "torsional_spring": "torsional_spring_torque"}  # fmt: skip
"""Kind of a load → the output that says how much it exerts."""


def described(system: System) -> dict[str, Any]:
    """What a page must know of a mechanism besides its motion."""
    mechanism, topology = system.mechanism, system.topology
    return {
        "name": mechanism.name,
        "mobility": topology.mobility,
        "driven": [_coordinate(system, name) for name in topology.driven],
        "free": [_coordinate(system, name) for name in topology.free],
        "state": _state(system),
        "period": _period(mechanism),
        "ground": sorted(mechanism.ground),
        "bodies": _bodies(mechanism),
        "clearances": _clearances(mechanism),
        "loads": _loads(system),
        "outlines": _outlines(mechanism),
    }


def _outlines(mechanism: Mechanism) -> list[str]:
    """Shapes that stay those of the file, whatever numbers are changed."""
    kinds = {"pitch circles": (Gear, Rack), "outlines of cams": (Cam,)}
    return [
        name
        for name, kind in kinds.items()
        if any(isinstance(part, kind) for part in mechanism.components)
    ]


def _coordinate(system: System, body: str) -> str:
    """The name of the series that is the coordinate of a body, or of a driven point."""
    if system.mechanism.bodies[body].kind == GUIDED:
        joint, _, axis = body.rpartition(".")
        return f"{joint}.{axis} position"
    return _coordinates(system, body)[0]


def _coordinates(system: System, body: str) -> tuple[str, str | None]:
    """The series that are the coordinate of a body and its rate.

    Offsets of a journal are those of its clearance, which pages have anyway.
    """
    known = {
        (series.variable, ".".join(series.place.values())): series.name
        for series in system_series(system).values()
    }
    variable = coordinate_of(system.mechanism.bodies[body].kind)
    if ("clearance_offset", body) in known:
        variable = "clearance_offset"
    return known[(variable, body)], known.get((VARIABLES[variable].rate, body))


def _series(system: System) -> dict[tuple[str, str], str]:
    """Output and element → name of the series, of outputs with one value for each element."""
    result = {}
    for series in system_series(system).values():
        if len(series.place) == 1:
            (element,) = series.place.values()
            result[(series.variable, element)] = series.name
    return result


def _state(system: System) -> list[str | None]:
    """Series that are the coordinates of a state, then their rates; None for internal states."""
    bodies = system.mechanism.bodies
    pairs = [
        _coordinates(system, name) if name in bodies else (None, None)
        for name in system.layout.coordinates
    ]
    return [*(name for name, _ in pairs), *(rate for _, rate in pairs)]


def _period(mechanism: Mechanism) -> float | None:
    """Time after which all drives and loads repeat; None where nothing does."""
    try:
        return common_period(mechanism)
    except NoPeriodError:
        return None


Given: TypeAlias = tuple[float, str]
"""A number and the path of the parameter that it is, by which a page knows it when it changes."""


def _given(number: Parameter) -> Given:
    return number.value, ".".join(map(str, number.path))


def _bodies(mechanism: Mechanism) -> list[dict[str, Any]]:
    """Bodies with the joints by which they are gripped, and how it is told how they are turned."""
    return [
        {
            "name": name,
            "joints": [] if body.kind in UNSEEN else list(body.points),
            "guide": _guide(mechanism, body),
            "pair": _pair(body),
            "follows": _follows(mechanism, name),
        }
        for name, body in mechanism.bodies.items()
    ]


def _guide(mechanism: Mechanism, body: Body) -> dict[str, Any] | None:
    """The axis of a slider: its direction and where it begins, from a joint of what carries it."""
    if body.guide is None:
        return None
    guide, carrier = body.guide, mechanism.bodies.get(body.guide.body or "")
    joint, own = next(iter(carrier.points.items()), (None, None)) if carrier else (None, None)
    origin = None if isinstance(guide.origin, str) else [_given(number) for number in guide.origin]
    return {
        "body": guide.body,
        "angle": _given(guide.angle),
        "origin": origin,
        "joint": joint,
        "own": own and [_given(number) for number in own],
    }


def _pair(body: Body) -> dict[str, Any] | None:
    """The two joints of a body that are farthest apart, and where they are in its own frame."""
    own = {name: (x.value, y.value) for name, (x, y) in body.points.items()}
    pairs = [(dist(own[a], own[b]), a, b) for a, b in combinations(own, 2)]
    far, first, second = max(pairs, default=(0.0, "", ""))
    if body.guide is not None or not far:
        return None
    places = [[_given(number) for number in body.points[joint]] for joint in (first, second)]
    return {"joints": [first, second], "places": places}


def _follows(mechanism: Mechanism, name: str) -> dict[str, Any] | None:
    """The weld or gear that says how a body follows others."""
    for relation in mechanism.relations:
        if relation.body == name and mechanism.bodies[name].rotates:
            parts = [(other, _given(ratio)) for other, ratio in relation.parts]
            return {"offset": _given(relation.offset), "parts": parts}
    return None


def _clearances(mechanism: Mechanism) -> list[dict[str, Any]]:
    """Journals and bearings: the joint, the centre of the bearing, the radial clearance."""
    result = []
    for hole, joint in clearance_ends(mechanism).items():
        name = hole.removeprefix(f"{joint}.")
        own = next(own for own in mechanism.clearances if own.name == name)
        result.append({"name": name, "joint": joint, "bearing": hole, "size": own.size,
                      "force": f"{name}.force"})  # fmt: skip
    return result


def _loads(system: System) -> list[dict[str, Any]]:
    """Loads with what they act along, and the series that says how much."""
    known, model = _series(system), system.model
    result = []
    for load in model.loads:
        series = known.get((ACTING[load.dimension], load.label))
        where = _acting(system.mechanism, load.load.measure)
        if series is not None and where is not None:
            result.append({"series": series, **where})
    return result


def _acting(mechanism: Mechanism, measure: Measure) -> dict[str, Any] | None:
    """Where a load acts and which way; None where the joints of a body do not tell."""
    match measure:
        case Distance(first, second):
            return {"kind": "between", "joints": [first, second]}
        case Coordinate(joint, axis):
            return {"kind": "fixed", "joint": joint, "axis": axis}
        case BodyAxis(joint, body, axis):
            return {"kind": "turning", "joint": joint, "body": body, "axis": axis}
        case Slide(body):
            guide, points = mechanism.bodies[body].guide, mechanism.bodies[body].points
            if guide is None or not points:
                return None
            return {"kind": "along", "joint": next(iter(points)), "body": body}
        case Turn(body):
            points = mechanism.bodies[body].points
            pivots = [joint for joint in points if joint in mechanism.ground] or [*points]
            return {"kind": "about", "joint": pivots[0]} if pivots else None
        case _:
            assert_never(measure)


def template(mechanism: Mechanism) -> list[Any]:
    """The definition as YAML, in parts.

    Returns: texts, and between them ``{"path", "words", "text"}`` of the numbers that the
    definition writes and that have an effect; all texts together are the definition as it is.
    """
    definition = mechanism.definition
    content = {"name": mechanism.name, **deepcopy(dict(definition.content))}
    content["name"] = mechanism.name
    kept: list[tuple[str, Any]] = []
    for number in written(mechanism):
        steps = split(number.path) or ()
        text = definition.value(steps)
        if isinstance(text, str | int | float) and _put(content, steps, f"number{len(kept)}gap"):
            kept.append((number.path, text))
    parts: list[Any] = []
    for place, text in enumerate(re.split(r"number(\d+)gap", _yaml(mechanism, content))):
        if place % 2:
            path, own = kept[int(text)]
            text = own if isinstance(own, str) else repr(own)
            parts.append({"path": path, "words": path_words(path), "text": text})
        else:
            parts.append(text)
    return parts


def _put(content: Any, steps: tuple[str | int, ...], value: str) -> bool:
    """Replace what stands at a path; whether there is such a place."""
    if not steps or not isinstance(content, dict | list):
        return False
    place: Any = steps[0]
    if len(steps) > 1:
        return _put(content[place], steps[1:], value)
    content[place] = value
    return True


def _yaml(mechanism: Mechanism, content: dict[str, Any]) -> str:
    return as_yaml(replace(mechanism.definition, content=content))


SCRIPTS = (
    "content.js", "units.js", "motion.js", "scene.js", "pace.js", "camera.js",
    "look.js", "shapes.js", "words.js", "arrows.js", "glass.js", "ghost.js", "stage.js", "grip.js",
    "axes.js", "plot.js", "panels.js", "values.js", "player.js", "tabs.js", "hands.js", "live.js",
    "plane.js", "kinematics.js", "numbers.js", "change.js", "edit.js", "svg.js", "export.js",
    "compare.js", "share.js", "main.js",
)  # fmt: skip
"""In the order in which the page reads them, which it does deflated."""

_EXPORT = re.compile(r"^export ", re.MULTILINE)
"""Browsers start no modules beside a page that was opened from a disk, but scripts."""

_PLACE = re.compile(r"\{\{(\w+)\}\}")


def page(content: dict[str, Any], models: Mapping[str, str]) -> str:
    """The whole file."""
    beside = [*(_named(*item) for item in models.items()), _asset("worker.js")]
    parts = {
        "title": escape(str(content["mechanism"]["name"])),
        "style": _asset("style.css"),
        "content": _json(content),
        "worker": deflated("\n".join(_EXPORT.sub("", text) for text in beside).encode()),
        "program": _program(),
        "script": _asset("unpack.js"),
    }
    return _PLACE.sub(lambda found: parts[found[1]], _asset("page.html"))


@cache
def _program() -> str:
    """The scripts of every page."""
    return deflated("\n".join(['"use strict";', *map(_asset, SCRIPTS)]).encode())


def _named(name: str, module: str) -> str:
    """A module in a scope of its own, and its model under a name."""
    if not module:
        return f"const {name} = null;"
    return f"const {name} = (() => {{\n{module}\nreturn model;\n}})();"


def _json(content: dict[str, Any]) -> str:
    """JSON that cannot end the element that it stands in."""
    text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


@cache
def _asset(name: str) -> str:
    return files("linkages.viewer").joinpath("assets", name).read_text(encoding="utf-8")


SAID = ("end", "samples", "method", "rtol", "atol", "step")
"""Options that a page names; it carries all of them."""

PEAKS = [0.0, *(10.0**power for power in range(-18, 13))]
"""Sizes from which another prefix may be customary."""


def page_content(
    mechanism: Mechanism,
    data: xr.Dataset,
    options: Mapping[str, Any],
    notes: Sequence[str],
    failure: object,
    plane: Callable[[Packed], dict[str, Any]] | None = None,
) -> str:
    """The text of the page.

    `plane`: what a page of a plane has of its points, with its numbers among the others.
    """
    system, packed = System(mechanism), Packed()
    origin = origin_of(mechanism, options)
    shown = described(system)
    content = {
        "mechanism": shown,
        "summary": _summary(system),
        "motion": recorded(data, system, packed, shown["state"], shown["period"]),
        **drawn(data.isel(time=chosen(data)), mechanism),
        "notes": [*notes, *([f"The motion stopped {failure}"] if failure is not None else [])],
        "stopped": None if failure is None else _without_options(str(failure)),
        "how": _how(origin),
        "origin": origin,
        "scales": _scales(data),
        "rates": {name: item.rate for name, item in VARIABLES.items() if item.rate},
        "palette": {"light": dict(LIGHT), "dark": dict(DARK)},
        "lines": {"light": list(PALETTE), "dark": [_paler(colour) for colour in PALETTE]},
        "series": _known(system, [str(name) for name in data.data_vars]),
        "tolerances": _tolerances(mechanism, options),
        "template": template(mechanism),
        "file": f"{Path(mechanism.source).stem or 'mechanism'}.yaml",
        "glass": {"pin": PIN, "hole": HOLE, "wall": WALL,
                  "reach": insets.REACH, "longest": insets.LONGEST},
        "plane": None if plane is None else plane(packed),
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
    result = {}
    for name, series in system_series(system).items():
        if series.variable not in outputs or VARIABLES[series.variable].flags:
            continue
        variable = VARIABLES[series.variable]
        units, label = variable.described(system.model)
        result[name] = {"variable": series.variable, "place": list(series.place.values()),
                       "unit": units, "label": label, "words": series.words(label),
                       "angle": variable.angle,
                       "smooth": variable.smooth, "compared": variable.compared}  # fmt: skip
    return result


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
    return f"M{notebook.moved_by(system.topology)[1:]}"


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
    result = {}
    for unit in sorted(units):
        steps: list[tuple[float, float, str]] = []
        for peak in PEAKS:
            scale = scale_for(peak, unit)
            if not steps or steps[-1][1:] != (scale.factor, scale.units):
                steps.append((peak, scale.factor, scale.units))
        result[unit] = steps
    return result


Source: TypeAlias = Solution | Mechanism | Opened


def view(source: Source, path: str | Path | None = None) -> Path:
    """Write one HTML file that shows a motion: no network, no server, nothing beside it.

    Parameters
    ----------
    source
        A solution; a mechanism, which is simulated as its definition says; or results that
        `linkages.open` found.
    path
        Of the file; default: the name of the definition file, ending in ``.html``, in the current
        directory.

    Returns
    -------
    Where the file is.

    Raises
    ------
    ValueError
        If results do not say where joints are.
    """
    text = html(source)
    mechanism = source if isinstance(source, Mechanism) else source.mechanism
    stem = Path(mechanism.source).stem or "mechanism"
    file = Path(f"{stem}.html") if path is None else Path(path)
    with replaced(file) as temporary:
        temporary.write_text(text, encoding="utf-8")
    return file


def html(source: Source) -> str:
    """The text of the file that `view` writes."""
    match source:
        case Solution():
            options, notes = source.options, source.notes
            return page_content(
                source.mechanism, dense(source), options, notes, source.motion.failure
            )
        case Mechanism():
            outputs = wanted(System(source))
            return html(simulate(source, outputs=outputs, throw=False))
        case Opened():
            return page_content(source.mechanism, source.data, source.arguments, source.notes, None)
        case _:
            expected = "a solution, a mechanism or opened results"
            raise TypeError(f"expected {expected}, found {source!r}")


HEIGHT = 760
"""Pixels of the frame."""


def solution_html(solution: Solution) -> str:
    """The page of a motion, in a frame that lets nothing out, and the table of largest values.

    The table alone where there are no two samples of where joints are.
    """
    text = notebook.solution_html(solution)
    if "joint_position" not in solution.data or solution.data.sizes["time"] < 2:
        return text
    name = escape(solution.mechanism.name)
    frame = (
        f'<iframe title="{name}" sandbox="allow-scripts allow-downloads" '
        f'style="width:100%;height:{HEIGHT}px;border:0" srcdoc="{escape(html(solution))}"></iframe>'
    )
    return f"{frame}\n{text}"
