"""C99: equations, integrators and a program that prints a motion."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.exports import Subject


def c(subject: Subject) -> Mapping[str, str]:
    """Write a header and a program in C99 that needs nothing but the standard library.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import c_files

    return c_files(subject.system, subject.name, subject.simulation)


EXPORT = c
