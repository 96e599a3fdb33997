"""Numbers of terms: those that stay arguments of kernels whatever their value, and shared ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from linkages.components.contributed.terms import Parameter, Path
from linkages.reading.document import Document


def keeping(item: Any, kept: Callable[[Parameter], bool | None]) -> Any:
    """A term (or several) in which some numbers are no structure."""
    return changed(item, lambda number: replace(number, kept=True) if kept(number) else number)


def valued(item: Any, values: Mapping[Path, float]) -> Any:
    """A term (or several) in which the numbers that formulas share have their values."""

    def with_value(number: Parameter) -> Parameter:
        if number.path in values:
            return replace(number, value=values[number.path])
        return number

    return changed(item, with_value)


def changed(item: Any, change: Callable[[Parameter], Parameter]) -> Any:
    """A term (or several) with something done to all of its numbers."""
    match item:
        case Parameter():
            return change(item)
        case tuple():
            return tuple(changed(part, change) for part in item)
        case Mapping():
            return {name: changed(part, change) for name, part in item.items()}
        case _ if is_dataclass(item) and not isinstance(item, type):
            own = {field.name: changed(getattr(item, field.name), change) for field in fields(item)}
            return replace(item, **own)
    return item


def depends(asked: Path, component: Path, definition: Document, parameter: Parameter) -> bool:
    """Whether a number may change with one that is asked for.

    Parameters
    ----------
    asked
        A path of the definition.
    component
        Where a component stands.
    definition
        What it does not say of a component follows from what it says.
    parameter
        A number of the component.
    """
    if not parameter.path or asked[: len(component)] != component:
        return False
    own = parameter.path[: len(asked)] == asked
    return own or definition.value(parameter.path) is None
