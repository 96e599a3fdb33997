"""What the docstring of a model says of its fields: the one place where they are described."""

from __future__ import annotations

import inspect
import re
from functools import cache
from typing import Any, get_origin

_PARAMETERS = re.compile(r"\nParameters\n-+\n(.*?)(?=\n\n\w|\Z)", re.DOTALL)
_FIELD = re.compile(r"^(\w[\w, ]*)\n((?:[ ]+.*\n?|\n)+)", re.MULTILINE)


def summary(model: Any) -> str:
    """Return the first sentence of the docstring of a class, which may be a generic one."""
    return _line(_docstring(model).partition("\n\n")[0])


@cache
def field_texts(model: Any) -> dict[str, str]:
    """Return what a docstring says of each field, by the name of the field in Python."""
    found = _PARAMETERS.search(_docstring(model))
    if found is None:
        return {}
    return {
        name: _line(text) for names, text in _FIELD.findall(found[1]) for name in names.split(", ")
    }


def _line(text: str) -> str:
    return " ".join(text.replace("``", "`").split())


def _docstring(model: Any) -> str:
    return inspect.cleandoc((get_origin(model) or model).__doc__ or "")
