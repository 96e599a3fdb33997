"""Text to values by the core schema of YAML 1.2, which editors follow; the loader keeps texts."""

import re

import yaml

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS = {"": None, "~": None, "null": None, "true": True, "false": False}


def values(text):
    return _value(yaml.compose(text, Loader=yaml.SafeLoader))


def _value(node):
    if isinstance(node, yaml.MappingNode):
        return {key.value: _value(value) for key, value in node.value}
    if isinstance(node, yaml.SequenceNode):
        return [_value(value) for value in node.value]
    if node.style or node.value.lower() not in _WORDS:
        return node.value if node.style else _number(node.value)
    return _WORDS[node.value.lower()]


def _number(text):
    if _INTEGER.fullmatch(text):
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text
