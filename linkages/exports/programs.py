"""Programs and models for others: C99, JavaScript, Python, units of the FMI, and MuJoCo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from linkages.exports import Subject


def c(subject: Subject) -> Mapping[str, str]:
    """Write a header and a program in C99 that needs nothing but the standard library.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import c_files

    return c_files(subject.system, subject.name, subject.simulation)


def javascript(subject: Subject) -> Mapping[str, str]:
    """Write a module without imports that exports the equations and an adaptive integrator.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import javascript_module

    return {f"{subject.name}.js": javascript_module(subject.system, options=subject.simulation)}


def python(subject: Subject) -> Mapping[str, str]:
    """Write a module that needs nothing but NumPy, and SciPy for its adaptive method.

    `subject`: what is exported.
    """
    from linkages.exports.writers.source_code import python_module

    return {f"{subject.name}.py": python_module(subject.system, subject.simulation)}


def mjcf(subject: Subject) -> Mapping[str, str]:
    """Write a model of MuJoCo; its keyframe ``start`` has the speeds at t = 0.

    `subject`: what is exported.
    Raises InputError with everything that MuJoCo cannot express.
    """
    from linkages.exports.writers.mujoco import massless, mjcf_text

    if note := massless(subject.system):
        subject.notes.append(note)
    return {f"{subject.name}.xml": mjcf_text(subject.system)}


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


EXPORTS = (c, fmu, javascript, mjcf, python)
