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
    """Return what docstrings say of each field, by its name in Python: of the class, or a base.

    Of a function, what its docstring says of its parameters.
    """
    texts: dict[str, str] = {}
    documented = [model] if inspect.isfunction(model) else reversed(_class(model).__mro__)
    for kind in documented:
        text = kind.__doc__ if kind is model else vars(kind).get("__doc__")
        found = _PARAMETERS.search(inspect.cleandoc(text or ""))
        for names, text in [] if found is None else _FIELD.findall(found[1]):
            texts |= dict.fromkeys(names.split(", "), _line(text))
    return texts


def _line(text: str) -> str:
    return " ".join(text.replace("``", "`").split())


def _docstring(model: Any) -> str:
    return inspect.cleandoc(_class(model).__doc__ or "")


def _class(model: Any) -> type:
    found: type = get_origin(model) or model
    return found
