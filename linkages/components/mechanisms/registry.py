"""Sections of a definition file, and the components that stand in them: found by themselves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from inspect import isclass
from typing import Any

from linkages.components.contributed.component import Component, Section
from linkages.discovery import modules_of, plugged
from linkages.spec.annotations import fields

GROUP = "linkages.components"
"""Entry points that name components, and the folder of those of this package."""

_SECTIONS: dict[str, Section] = {
    "gravity": Section("value", "[9.81, 0]", field="acceleration"),
    "joints": Section("mapping", "O: [0, 0]", field="position"),
    "bars": Section("mapping", "crank: {joints: [O, A], length: 0.3}"),
    "sliders": Section("mapping", "piston: {joint: B, through: O}"),
    "clearances": Section("mapping", "r1: {joint: A, bar: rod, size: 0.1 mm}"),
    "masses": Section("mapping", "A: 2 kg", field="mass"),
    "welds": Section("mapping", "A: {bars: [crank, rod], angle: 30 deg}"),
    "gears": Section("list", "{bars: [crank, rod], ratio: -2}"),
    "drives": Section("mapping", "crank: {angle: 0, speed: 60 rpm}"),
    "free": Section("mapping", "crank: {angle: 0.1, speed: 0}"),
    "assembly": Section("mapping", "B: left", field="where"),
    "loads": Section("list", "{slider: piston, force: -100}"),
    "springs": Section("list", "{between: [O, B], stiffness: 4530, length: 0.08}"),
    "dampers": Section("list", "{joint: A, damping: 0.1}"),
    "simulate": Section("value", "{end: 2, samples: 2001}"),
}
"""In the order in which components are kept; whatever opens another one comes behind."""

_REGISTERED: list[type[Component]] = []


class Known:
    """A section, and the components that its entries may be.

    Parameters
    ----------
    section
        How it is read.
    models
        Its components: the one that no key tells first.
    """

    def __init__(self, section: Section, models: tuple[type[Component], ...]) -> None:
        self.form, self.example, self.field = section.form, section.example, section.field
        self.given, self.models = section.given, models
        self.for_sliders = next((model for model in models if model.names_slider), None)

    def choose(self, entry: object) -> type[Component]:
        """The component that describes an entry.

        Of those whose key it has, the one that has most of its keys.
        """
        keys = entry if isinstance(entry, dict) else {}
        told: list[Any] = [
            model for model in self.models if model.told_by and model.told_by in keys
        ]
        most: Any = max(told, key=lambda m: len(keys.keys() & fields(m).keys()), default=None)
        return self.models[0] if most is None else most


class _Sections(Mapping[str, Known]):
    """All sections by their names; components are looked for when they are first asked for."""

    def __getitem__(self, name: str) -> Known:
        return _known()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(_known())

    def __len__(self) -> int:
        return len(_known())


SECTIONS: Mapping[str, Known] = _Sections()


def components() -> dict[str, type[Component]]:
    """All components by the names of their classes."""
    return {model.__name__: model for known in _known().values() for model in known.models}


def register(model: type[Component]) -> None:
    """Add a component to those that definitions may have.

    One of the same name that was registered before is replaced.

    Raises
    ------
    TypeError, ValueError
        If it is none, or does not go together with those of its section.
    """
    if not (isclass(model) and issubclass(model, Component) and hasattr(model, "section")):
        raise TypeError(f"expected a component with a section, found {model!r}")
    before = list(_REGISTERED)
    _REGISTERED[:] = [*(old for old in before if old.__name__ != model.__name__), model]
    _known.cache_clear()
    try:
        _known()
    except ValueError:
        _REGISTERED[:] = before
        _known.cache_clear()
        raise


def unregister(name: str) -> None:
    """Take away a component that was registered; KeyError if none of that name was."""
    kept = [model for model in _REGISTERED if model.__name__ != name]
    if len(kept) == len(_REGISTERED):
        raise KeyError(name)
    _REGISTERED[:] = kept
    _known.cache_clear()


@cache
def _known() -> dict[str, Known]:
    found: list[Any] = []
    for module in modules_of(GROUP):
        own = (value for value in vars(module).values() if isclass(value))
        found += [value for value in own if value.__module__ == module.__name__]
    models = [m for m in found if issubclass(m, Component) and "section" in vars(m)]
    models += [model for _, model in plugged(GROUP)] + _REGISTERED
    opened = dict(sorted((m.section, m.opens) for m in models if m.opens is not None))
    return {
        name: Known(section, _models(name, [m for m in models if m.section == name]))
        for name, section in {**_SECTIONS, **opened}.items()
    }


def _models(section: str, models: list[type[Component]]) -> tuple[type[Component], ...]:
    """Those of a section, the one that no key tells first."""
    keys = [model.told_by for model in models]
    if keys.count("") != 1 or len(set(keys)) < len(keys):
        names = ", ".join(f"{model.__name__} ({model.told_by!r})" for model in models)
        raise ValueError(
            f"section {section!r}: expected one component that no key tells, and another key for "
            f"each of the others; found {names}"
        )
    return tuple(sorted(models, key=lambda model: model.told_by != ""))
