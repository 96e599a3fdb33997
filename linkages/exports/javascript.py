"""JavaScript: equations, an integrator, and how both follow from numbers of the definition file."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.exports import Subject


def javascript(subject: Subject) -> Mapping[str, str]:
    """Write a module without imports that exports the equations and an adaptive integrator.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import javascript_module

    return {f"{subject.name}.js": javascript_module(subject.system, options=subject.simulation)}


EXPORT = javascript
