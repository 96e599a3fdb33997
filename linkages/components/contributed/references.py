"""Names of joints and bodies that a component uses."""

from __future__ import annotations

from dataclasses import dataclass

from linkages.components.contributed.terms import Path


@dataclass(frozen=True)
class References:
    """Names that a component uses: each must be declared by another component.

    Parameters
    ----------
    joints, ground, moving
        Paths and names of joints: any, of the ground, not of the ground.
    bodies
        Paths, names and the kinds of bodies that are expected.
    points
        Paths, bodies, and joints that these must have.
    meeting
        Paths, bodies, and joints at which these must turn, as they are or with a slider that they
        carry; the body may be ``"ground"``.
    carried
        Paths, sliders, and what must carry their axes: a body, or None for the ground.
    """

    joints: tuple[tuple[Path, str], ...] = ()
    ground: tuple[tuple[Path, str], ...] = ()
    moving: tuple[tuple[Path, str], ...] = ()
    bodies: tuple[tuple[Path, str, tuple[str, ...]], ...] = ()
    points: tuple[tuple[Path, str, str], ...] = ()
    meeting: tuple[tuple[Path, str, str], ...] = ()
    carried: tuple[tuple[Path, str, str | None], ...] = ()
