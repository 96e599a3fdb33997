"""Runs of shipped mechanisms, and what the tests of this folder read from them."""

import json
from functools import cache
from pathlib import Path

import numpy as np

import linkages
from linkages.reading.document import shipped

DATA = Path(__file__).parents[1] / "data"
TURN = 2 * np.pi


def reference(name: str) -> dict:
    return json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))


@cache
def whole_run(name: str):
    """A mechanism of the library, to its own end at its own tolerance, with all outputs."""
    return linkages.simulate(linkages.load(name), outputs="all")


def results(name: str, overrides=None, **options):
    """Results of a mechanism of the library that is run in another way."""
    return linkages.simulate(linkages.load(name, set=overrides), **options).data


def edited(name: str, **replacements: str):
    """A mechanism of the library with parts of its text replaced, wherever they stand."""
    text = shipped()[name].read_text(encoding="utf-8")
    for old, new in replacements.items():
        assert old in text
        text = text.replace(old, new)
    return linkages.loads(text)


def place(data, joint: str) -> np.ndarray:
    """Position of a joint, shape (2, times)."""
    return data.joint_position.sel(joint=joint).to_numpy().T


def column(data, variable: str, label: str) -> np.ndarray:
    """A variable of one bar, slider or drive, shape (times,)."""
    values = data[variable]
    (dimension,) = set(values.dims) - {"time"}
    return values.sel({dimension: label}).to_numpy()


def unit(angle) -> np.ndarray:
    """Unit vector(s) at an angle, shape (2, …)."""
    return np.array([np.cos(angle), np.sin(angle)])


def meeting(first, second, from_first, from_second, side) -> np.ndarray:
    """Where two circles meet, left (+1) or right (−1) of the line between their centres."""
    line = second - first
    distance = np.hypot(*line)
    along = (distance**2 + from_first**2 - from_second**2) / (2 * distance)
    across = side * np.sqrt(from_first**2 - along**2)
    return first + (along * line + across * np.array([-line[1], line[0]])) / distance
