"""Definitions with one thing changed at random: a value, a key, or one of them gone."""

import copy
from typing import Any

import numpy as np

VALUES = (
    None, "", "x", "-3", "2 mm", "3 rad", "t", "pi/2", "1/0", "left", "ground", True, 0, -1, 1.5,
    [], [1], [1, 2], ["a", "b"], {}, {"x": 1}, {"harmonic": {"amplitude": 1, "frequency": 2}},
)  # fmt: skip
KEYS = ("mass", "angle", "speed", "position", "law", "joints", "points", "lenght", "a/b", "bars")


def spoiled(definition: dict[str, Any], generator: np.random.Generator) -> dict[str, Any]:
    """A copy with one change at a random place; it may still be right."""
    found = copy.deepcopy(definition)
    container: Any = found
    while True:
        keys = list(container) if isinstance(container, dict) else list(range(len(container)))
        key = keys[generator.integers(len(keys))]
        inner = container[key]
        if not (isinstance(inner, dict | list) and inner) or generator.random() < 0.15:
            break
        container = inner
    kind = generator.integers(4)
    if kind == 0:
        del container[key]
    elif kind == 1 and isinstance(container, dict):
        container[KEYS[generator.integers(len(KEYS))]] = container.pop(key)
    else:
        container[key] = copy.deepcopy(VALUES[generator.integers(len(VALUES))])
    return found
