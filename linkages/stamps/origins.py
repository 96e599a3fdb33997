"""The origin of results, as a model that what a file contains is validated with."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, Json, JsonValue, ValidationError

from linkages.errors import InputError, Problem

LONGEST = 10_000_000
"""Characters of a definition; of everything else, a tenth."""

_Text = Annotated[str, Field(max_length=LONGEST // 10)]
_Texts = Annotated[list[_Text], Field(max_length=100_000)]
_Object = Annotated[dict[str, JsonValue], Field(max_length=1_000)]

_EXPECTED = {
    "arguments": "a JSON object",
    "options": "a JSON object",
    "changes": "a JSON list of texts",
    "notes": "a JSON list of texts",
    "definition": f"a text of at most {LONGEST // 10**6} million characters",
}


class Origin(BaseModel):
    """What results were computed from. Entries of other names are left out.

    Parameters
    ----------
    definition
        YAML text with all values put in.
    changes
        The assignments that made it out of its file.
    options, arguments
        How it was computed, and what of that was given. They describe the computation; `asked_in`
        of `linkages.options.option` selects what a new one takes over.
    verb, analysis
        The command, and the analysis in the file.
    command
        What was typed; empty where Python called.
    version
        Of this package.
    notes
        Remarks on the results.
    complete
        ``yes`` if the analysis came to its end.
    """

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore")

    definition: Annotated[str, Field(max_length=LONGEST)]
    changes: Json[_Texts] = Field(default_factory=list)
    options: Json[_Object] = Field(default_factory=dict)
    arguments: Json[_Object] = Field(default_factory=dict)
    verb: _Text | None = None
    analysis: _Text | None = None
    command: _Text = ""
    version: _Text = ""
    notes: Json[_Texts] = Field(default_factory=list)
    complete: _Text = "yes"


class _Any(BaseModel):
    """Whether there is an origin at all."""

    definition: JsonValue = None


def read_origin(text: str, source: str) -> Origin | None:
    """Validate a JSON text; None if it has no definition.

    Raises
    ------
    InputError
        Names each entry that is not what it should be; its content is not repeated.
    """
    try:
        if _Any.model_validate_json(text).definition is None:
            return None
        return Origin.model_validate_json(text)
    except ValidationError as error:
        names = dict.fromkeys(
            str(found["loc"][0]) if found["loc"] else "" for found in error.errors()
        )
        problems = [
            Problem(path=f"origin.{name}" if name else "origin", message=_message(name))
            for name in names
        ]
        raise InputError(source, problems) from None


def _message(name: str) -> str:
    expected = _EXPECTED.get(name, "a text") if name else "a JSON object of texts"
    return f"expected {expected}; the file is damaged, or linkages did not write it"
