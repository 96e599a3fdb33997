"""FMU: units of the Functional Mock-up Interface, for model exchange and co-simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from linkages.exports import Subject


def fmu(
    subject: Subject, *, fmi: str = "3.0", inputs: Sequence[str] = ()
) -> Mapping[str, str | bytes]:
    """Write a unit with its source, and compiled for this machine where a C compiler is found.

    Parameters
    ----------
    subject
        What is exported.
    fmi
        Version of the interface, ``"3.0"`` or ``"2.0"``.
    inputs
        Forces and torques that another program gives, such as ``"crank.torque"``,
        ``"P.x force"`` or ``"loads[0]"``, and accelerations of drives beyond their laws,
        ``"crank.acceleration"``. If not given, the forces on free coordinates and along the loads
        of the definition.

    Raises OptionError for an unknown version or input.
    """
    from linkages.exports.writers.functional_mockup import fmu_files

    content, note = fmu_files(subject, fmi, inputs)
    if note:
        subject.notes.append(note)
    return content


EXPORT = fmu
