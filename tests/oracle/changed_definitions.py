"""The same mechanism under other names, in another order, in other units."""

import re
from typing import Any

import numpy as np
from random_mechanisms import Grown

TIME = re.compile(r"\bt\b")
Dimension = tuple[int, int, int]  # length, mass, time

NONE, LENGTH, MASS, INERTIA = (0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 1, 0)
FORCE, TORQUE, PER_TIME = (1, 1, -2), (2, 1, -2), (0, 0, -1)
KEYS: dict[str, dict[str, Dimension]] = {
    "bars": dict.fromkeys(("length", "points", "center"), LENGTH)
    | {"mass": MASS, "inertia": INERTIA},
    "sliders": {"through": LENGTH, "points": LENGTH, "mass": MASS, "inertia": INERTIA},
    "clearances": {"size": LENGTH, "speed": PER_TIME},
    "loads": {"force": FORCE, "torque": TORQUE},
}  # fmt: skip
WHOLE = {"joints": LENGTH, "assembly": LENGTH, "masses": MASS}
TURNING = {"speed": PER_TIME}
SLIDING = {"position": LENGTH, "speed": (1, 0, -1), "law": LENGTH}
SPRING = {"stiffness": (0, 1, -2), "length": LENGTH, "damping": (0, 1, -1)}
TORSION = {"stiffness": TORQUE, "damping": (2, 1, -1)}


def scaled(grown: Grown, length: float, mass: float, time: float) -> Grown:
    """The mechanism with all of its numbers in units that are smaller by these factors."""
    units = (length, mass, time)

    def entry(section: str, name: Any, value: Any) -> Any:
        if section in WHOLE:
            return _times(value, units, WHOLE[section])
        keys = KEYS.get(section, {})
        if section in ("drives", "free"):
            keys = SLIDING if name in grown.definition.get("sliders", {}) else TURNING
            keys = {"law": NONE, **keys}
        if section in ("springs", "dampers"):
            keys = SPRING if "between" in value or "slider" in value else TORSION
        return {key: _times(part, units, keys.get(key)) for key, part in value.items()}

    definition: dict[str, Any] = {}
    for section, content in grown.definition.items():
        if section == "gravity":
            definition[section] = _times(content, units, (1, 0, -2))
        elif isinstance(content, list):
            definition[section] = [entry(section, i, part) for i, part in enumerate(content)]
        else:
            definition[section] = {n: entry(section, n, part) for n, part in content.items()}
    places = {joint: length * place for joint, place in grown.places.items()}
    return Grown(definition, places, grown.angles)


def _times(value: Any, units: tuple[float, ...], dimension: Dimension | None) -> Any:
    if dimension is None or (isinstance(value, str) and not TIME.search(value)):
        return value  # a name, or a number without dimension
    factor = float(np.prod([unit**power for unit, power in zip(units, dimension, strict=True)]))
    if isinstance(value, dict) and "table" in value:
        scales = {"times": units[2], "values": factor}
        parts = {k: [scale * x for x in value["table"][k]] for k, scale in scales.items()}
        return {"table": {**value["table"], **parts}}
    if isinstance(value, dict):
        return {key: _times(part, units, dimension) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [_times(part, units, dimension) for part in value]
    if isinstance(value, str):
        return f"{factor!r}*({TIME.sub(f'(t/{units[2]!r})', value)})"
    return factor * value


def renamed(grown: Grown, generator: np.random.Generator) -> tuple[dict[str, str], Grown]:
    """Old name → new name, and the mechanism with these and all sections in another order."""
    given = grown.definition
    names = [name for name in grown.places if "." not in name]
    names += [n for section in ("bars", "sliders", "clearances") for n in given.get(section, {})]
    new = {name: f"{chr(ord('z') - i % 20)}{i}" for i, name in enumerate(names)}
    new |= {n: ".".join(new[part] for part in n.split(".")) for n in grown.places if "." in n}

    def replaced(value: Any) -> Any:
        if isinstance(value, dict):
            return {new.get(key, key): replaced(part) for key, part in value.items()}
        if isinstance(value, list | tuple):
            return [replaced(part) for part in value]
        return new.get(value, value) if isinstance(value, str) else value

    def mixed(content: Any) -> Any:
        entries = list(content.items()) if isinstance(content, dict) else content
        order = generator.permutation(len(entries))
        found = [entries[i] for i in order]
        return dict(found) if isinstance(content, dict) else found

    definition = {
        section: content if section == "gravity" else mixed(replaced(content))
        for section, content in given.items()
    }
    places = {new[joint]: place for joint, place in grown.places.items()}
    return new, Grown(definition, places, {new[n]: angle for n, angle in grown.angles.items()})
