"""``schema``: the JSON Schema of definition files, for editors and other programs."""

from __future__ import annotations

import sys

from linkages.cli.terminal import json_text


def run_schema() -> int:
    """Print the schema; returns the exit code."""
    unicode = (sys.stdout.encoding or "").lower().startswith("utf")
    print(schema_text(ascii_only=not unicode))
    return 0


def schema_text(ascii_only: bool = False) -> str:
    """The schema as text."""
    from linkages.components.mechanisms.schema import definition_schema

    return json_text(definition_schema(), ascii_only=ascii_only, indent=1)
