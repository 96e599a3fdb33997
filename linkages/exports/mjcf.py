"""MJCF: models of MuJoCo, with loops closed by constraints."""

from __future__ import annotations

from collections.abc import Mapping

from linkages.exports import Subject


def mjcf(subject: Subject) -> Mapping[str, str]:
    """Write a model of MuJoCo; its keyframe ``start`` has the speeds at t = 0.

    `subject`: what is exported.
    Raises InputError with everything that MuJoCo cannot express.
    """
    from linkages.exports.writers.mujoco import massless, mjcf_text

    if note := massless(subject.system):
        subject.notes.append(note)
    return {f"{subject.name}.xml": mjcf_text(subject.system)}


EXPORT = mjcf
