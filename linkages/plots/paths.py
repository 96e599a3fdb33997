"""Paths of a definition in words, as axes and legends have them."""

from __future__ import annotations

from linkages.reading.paths import dotted, split


def path_words(path: str) -> str:
    """A dotted path in words: ``drives.crank.speed`` is the speed of crank.

    A path that leads to an entry of a section, or is none, stays as it is written.
    """
    match split(path):
        case ("clearances", str(name), "size"):
            return f"radial clearance {name}"
        case ("clearances", str(name), str(key)):
            return f"{_spaced(key)} of clearance {name}"
        case ("gravity", int(index)):
            return f"gravity along {'xy'[index]}"
        case ("masses", name):
            return f"mass at {name}"
        case (str(section), int(index), *between, str(key)):
            return f"{_spaced(key)} of {dotted((section, index, *between))}"
        case (_, str(name), *between, str(key)):
            return f"{_spaced(key)} of {dotted((name, *between))}"
        case ("simulate", str(key)):
            return _spaced(key)
        case _:
            return path


def _spaced(key: str) -> str:
    return key.replace("_", " ")
