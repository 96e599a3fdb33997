"""Signatures and docstrings of public functions, from the options that they take."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from typing import Any, TypeVar

from linkages.options.given import Option, options_in
from linkages.options.run import RunOptions

Function = TypeVar("Function", bound=Callable[..., Any])

_ENTRY = "    options\n        As `{}` describes them.\n"


def takes(kind: type[RunOptions]) -> Callable[[Function], Function]:
    """Let `help` and the pages show the options of a function as its keyword arguments.

    Parameters
    ----------
    kind
        What its ``**options`` are: their texts take the place of that entry of its docstring.
    """

    def shown(function: Function) -> Function:
        options = options_in(kind)
        signature: Any = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        given = [
            inspect.Parameter(
                option.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=option.default,
                annotation=option.value | None if option.default is None else option.value,
            )
            for option in options
        ]
        made: Any = function
        made.__signature__ = signature.replace(parameters=[*own, *given])
        texts = "".join(textwrap.indent(_entry(option), "    ") for option in options)
        made.__doc__ = (made.__doc__ or "").replace(_ENTRY.format(kind.__name__), texts)
        return function

    return shown


def _entry(option: Option) -> str:
    default = f" Default: simulate.{option.name} of the definition." if option.of_file else ""
    text = textwrap.fill(option.text + default, 92)
    return f"{option.name}\n{textwrap.indent(text, '    ')}\n"
