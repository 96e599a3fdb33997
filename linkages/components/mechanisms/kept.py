"""Numbers that stay arguments of kernels whatever their value, for sensitivities are asked for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

from linkages.components.contributed.terms import Parameter, Path
from linkages.reading.document import Document


def keeping(item: Any, kept: Callable[[Parameter], bool | None]) -> Any:
    """A term (or several) in which some numbers are no structure."""
    match item:
        case Parameter():
            return replace(item, kept=True) if kept(item) else item
        case tuple():
            return tuple(keeping(part, kept) for part in item)
        case Mapping():
            return {name: keeping(part, kept) for name, part in item.items()}
        case _ if is_dataclass(item) and not isinstance(item, type):
            own = {field.name: keeping(getattr(item, field.name), kept) for field in fields(item)}
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
