"""The content of a document as text again."""

from __future__ import annotations

from typing import Any

import yaml

from linkages.reading.document import Document
from linkages.reading.nodes import is_null

_TEXT = "tag:yaml.org,2002:str"


class _Dumper(yaml.SafeDumper):
    """Writes all scalars without tags, for the reader takes them for texts, and without anchors."""

    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012

    def ignore_aliases(self, data: Any) -> bool:  # noqa: ARG002
        """What stands at two places is written twice."""
        return True


def _text(dumper: _Dumper, value: str) -> yaml.Node:
    quoted = is_null(value) or value == "<<"  # mean something else without quotes
    return dumper.represent_scalar(_TEXT, value, style="'" if quoted else None)


def _number(dumper: _Dumper, value: object) -> yaml.Node:
    """Values that Python code put in; `repr` has all digits."""
    return dumper.represent_scalar(_TEXT, "null" if value is None else repr(value))


_Dumper.add_representer(str, _text)
for _kind in (int, float, bool, type(None)):
    _Dumper.add_representer(_kind, _number)


def as_yaml(document: Document) -> str:
    """The definition with all values put in, as YAML that is read as the same content.

    Comments are lost.
    """
    return yaml.dump(
        document.content,
        Dumper=_Dumper,
        default_flow_style=None,  # innermost lists and mappings on one line
        sort_keys=False,
        allow_unicode=True,
        width=100,
    )
