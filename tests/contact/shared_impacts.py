"""Impacts that several contacts of one body share, in absolute coordinates, by trying every case.

A contact parts, holds, or slips to either side behind the impact. Each of the 4ⁿ cases is a linear
system; the one that obeys Newton's law across the walls and Coulomb's along them is the answer.
"""

from itertools import product

import numpy as np

CASES = ("part", "hold", "up", "down")
ROUND_OFF = 1e-9


def impact(inertia, normals, tangents, friction, restitution, velocity, closing=1e-3):
    """Velocities behind an impact of contacts that all touch.

    Parameters
    ----------
    inertia
        Diagonal of the body's inertia, shape (3,).
    normals, tangents
        Rows: derivatives of indentations and slips by velocities, shape (n, 3).
    friction, restitution
        Shape (n,).
    velocity
        Before, shape (3,).
    closing
        Rebounds below it close a contact.
    """
    rates = normals @ velocity
    wanted = np.where(rates > 0, -restitution * rates, 0.0)
    whole = solved(inertia, normals, tangents, friction, velocity,
                   np.where(wanted < -closing, wanted, 0.0))  # fmt: skip
    plastic = solved(inertia, normals, tangents, friction, velocity, 0.0 * wanted)
    energy = [np.sum(inertia * v**2) for v in (velocity, plastic, whole)]
    if energy[2] <= energy[0]:
        return whole, "whole"
    more = whole - plastic
    parts = np.roots([np.sum(inertia * more**2), 2 * np.sum(inertia * more * plastic),
                      energy[1] - energy[0]])  # fmt: skip
    return plastic + parts.max() * more, "limited"


def solved(inertia, normals, tangents, friction, velocity, wanted):
    """Velocities behind, where contacts that press have the wanted rates."""
    count, scale = len(normals), np.abs(velocity).max() * np.abs(normals).max()
    directions = np.concatenate([-normals, tangents])
    found = []
    for case in product(CASES, repeat=count):
        matrix, right = np.eye(2 * count), np.zeros(2 * count)
        moved = directions @ (directions / inertia).T
        before = directions @ velocity
        for k, kind in enumerate(case):
            if kind != "part":
                matrix[k], right[k] = moved[k], -wanted[k] - before[k]
            if kind == "hold":
                matrix[count + k], right[count + k] = moved[count + k], -before[count + k]
            elif kind != "part":
                matrix[count + k, k] = friction[k] * (1 if kind == "up" else -1)
        impulses = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
        behind = velocity + impulses @ directions / inertia
        rates, slips = normals @ behind, tangents @ behind
        push, along = impulses[:count], impulses[count:]
        slack = ROUND_OFF * np.abs(impulses).max(initial=1e-300)
        fits = (
            np.abs(matrix @ impulses - right).max() < ROUND_OFF * scale
            and (push >= -slack).all()
            and (rates <= wanted + ROUND_OFF * scale).all()
            and (np.abs(along) <= friction * push + slack).all()
            and all(
                slip * (1 if kind == "up" else -1) >= -ROUND_OFF * scale
                for kind, slip in zip(case, slips, strict=True)
                if kind in ("up", "down")
            )
        )
        if fits:
            found.append(behind)
    assert found, "no case fits"
    spread = np.ptp(found, axis=0).max()
    assert spread <= 1e-6 * scale, "several cases fit"
    return found[0]
