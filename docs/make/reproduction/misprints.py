"""The paper's formulas as printed and as derived, as SymPy expressions.

`J` is any symmetric 3×3 inertia matrix over q = (θ1, θ4, α), `V` any potential energy.
"""

from __future__ import annotations

import sympy as sp

t = sp.Symbol("t", real=True)
q = sp.symbols("q1:4", real=True)
rate = sp.symbols("dq1:4", real=True)
acceleration = sp.symbols("ddq1:4", real=True)
J = sp.Matrix(3, 3, lambda i, j: sp.Function(f"J{min(i, j) + 1}{max(i, j) + 1}")(*q))
V = sp.Function("V")(*q)


def derived_row(index: int) -> sp.Expr:
    """d/dt ∂L/∂q̇ − ∂L/∂q of row 0, 1 or 2, from the energies alone (Eq. 4 without Q)."""
    lagrangian = sum(J[i, j] * rate[i] * rate[j] for i in range(3) for j in range(3)) / 2 - V
    momentum = sp.diff(lagrangian, rate[index])
    total = sum(
        sp.diff(momentum, q[k]) * rate[k] + sp.diff(momentum, rate[k]) * acceleration[k]
        for k in range(3)
    )
    return sp.expand(total - sp.diff(lagrangian, q[index]))


def coefficient(expression: sp.Expr, first: int, second: int) -> sp.Expr:
    """The factor of q̇_first q̇_second."""
    monomial = rate[first] * rate[second]
    return sp.Poly(sp.expand(expression), *rate, *acceleration).coeff_monomial(monomial)


def printed_cross_term() -> sp.Expr:
    """Eq. 8, first row, factor of q̇2 q̇3: its last term has J33 where J23 belongs."""
    return J[0, 1].diff(q[2]) + J[0, 2].diff(q[1]) - J[2, 2].diff(q[0])


def corrected_cross_term() -> sp.Expr:
    return J[0, 1].diff(q[2]) + J[0, 2].diff(q[1]) - J[1, 2].diff(q[0])


def first_row(cross_term: sp.Expr) -> sp.Expr:
    """Eq. 8, first row: every factor as in the derivation but the one of q̇2 q̇3."""
    derived = derived_row(0)
    return derived + (cross_term - coefficient(derived, 1, 2)) * rate[1] * rate[2]


def solved_clearance_row() -> sp.Expr:
    """The third row solved for α̈ with both cranks at constant speed."""
    row = derived_row(2).subs({acceleration[0]: 0, acceleration[1]: 0})
    (found,) = sp.solve(row, acceleration[2])
    return found


def clearance_equation(*, printed: bool) -> sp.Expr:
    """Eq. 10: α̈ = ∓(A0 + Σ A_jk q̇_j q̇_k), as printed or corrected.

    Printed are A33 with ∂J11/∂q3, A0 without its divisor, and a sign that is lost.
    """
    j33 = J[2, 2]
    a0 = V.diff(q[2]) if printed else V.diff(q[2]) / j33
    a33 = sp.Rational(1, 2) * (J[0, 0] if printed else j33).diff(q[2]) / j33
    total = a0 + a33 * rate[2] ** 2
    total += sum(
        (J[2, i].diff(q[i]) - J[i, i].diff(q[2]) / 2) / j33 * rate[i] ** 2 for i in range(2)
    )
    total += (
        (J[0, 2].diff(q[1]) + J[1, 2].diff(q[0]) - J[0, 1].diff(q[2])) / j33 * rate[0] * rate[1]
    )
    total += sum(j33.diff(q[i]) / j33 * rate[i] * rate[2] for i in range(2))
    return total if printed else -total


def pivoted_energy() -> tuple[sp.Expr, sp.Expr]:
    """Energy of a bar on a fixed pivot, as Eq. 3 prints it for bodies 1, 4, 6, and in full.

    Symbols m, L, J of the bar; its centre of mass at mid-length, J about it.
    """
    m, length, inertia, angle = sp.symbols("m L J theta", positive=True)
    speed = sp.Symbol("omega", real=True)
    centre = sp.Matrix([sp.cos(angle), sp.sin(angle)]) * length / 2
    velocity = centre.diff(angle) * speed
    printed = inertia * speed**2 / 2
    return printed, sp.simplify(printed + m * velocity.dot(velocity) / 2)


PIVOTED = {"crank1": "A", "crank4": "C", "rocker6": "E"}
"""Bodies whose translation Eq. 3 leaves out, and their free ends."""


def energy_as_printed(mechanism) -> dict[str, object]:
    """Overrides that leave the translation of bodies 1, 4 and 6 out of the kinetic energy.

    They lose their mass and keep inertia and weight: half a weight at the free end does the same
    work as the whole weight at mid-length.
    """
    changes: dict[str, object] = {}
    loads = []
    gravity = 9.81
    for name, joint in PIVOTED.items():
        mass = mechanism.bodies[name].mass.value
        changes[f"bars.{name}.mass"] = 0
        loads.append({"joint": joint, "force": [0.5 * mass * gravity, 0]})
    return {**changes, "loads": loads}
