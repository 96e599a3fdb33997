"""Python: equations, outputs and a program that prints a motion, without this package."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.exports import Subject


def python(subject: Subject) -> Mapping[str, str]:
    """Write a module that needs nothing but NumPy, and SciPy for its adaptive method.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import python_module

    return {f"{subject.name}.py": python_module(subject.system, subject.simulation)}


EXPORT = python
