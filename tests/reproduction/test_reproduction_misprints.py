"""Formulas of the paper as printed against those derived from the energies, symbolically."""

import pytest
import sympy as sp
from make.reproduction import misprints
from make.reproduction.misprints import J, V, q, rate

from linkages import load, simulate
from linkages.equations import derive
from linkages.topology.topology import build_topology


def test_first_row_of_eq_8_differs_in_one_derivative():
    derived = misprints.derived_row(0)
    assert sp.expand(misprints.first_row(misprints.corrected_cross_term()) - derived) == 0
    left = sp.expand(misprints.first_row(misprints.printed_cross_term()) - derived)
    wrong = (J[1, 2].diff(q[0]) - J[2, 2].diff(q[0])) * rate[1] * rate[2]
    assert sp.expand(left - wrong) == 0


def test_other_rows_have_the_pattern_of_the_first():
    """The factor of q̇j q̇k in row i is ∂Jij/∂qk + ∂Jik/∂qj − ∂Jjk/∂qi: no J33 for unlike j, k."""
    for i in range(3):
        row = misprints.derived_row(i)
        for j, k in ((0, 1), (0, 2), (1, 2)):
            expected = J[i, j].diff(q[k]) + J[i, k].diff(q[j]) - J[j, k].diff(q[i])
            assert sp.expand(misprints.coefficient(row, j, k) - expected) == 0


def test_corrected_eq_10_is_the_derived_one():
    difference = misprints.solved_clearance_row() - misprints.clearance_equation(printed=False)
    assert sp.simplify(difference) == 0


def test_eq_10_as_printed_differs_in_sign_and_two_terms():
    """Once the sign is turned, only A0 (without its divisor) and A33 (∂J11 for ∂J33) are left."""
    turned = -misprints.clearance_equation(printed=True)
    left = turned - misprints.solved_clearance_row()
    j33 = J[2, 2]
    a0 = V.diff(q[2]) / j33 - V.diff(q[2])
    a33 = (j33 - J[0, 0]).diff(q[2]) / (2 * j33)
    assert sp.simplify(left - a0 - a33 * rate[2] ** 2) == 0
    assert sp.simplify(turned + misprints.solved_clearance_row()) != 0


def test_eq_3_leaves_out_the_translation_of_a_bar_on_a_pivot():
    printed, whole = misprints.pivoted_energy()
    m, length = sp.symbols("m L", positive=True)
    speed = sp.Symbol("omega", real=True)
    assert sp.simplify(whole - printed - m * length**2 * speed**2 / 8) == 0


@pytest.mark.slow_except("crank1")
@pytest.mark.parametrize("body", misprints.PIVOTED)
def test_the_project_counts_that_translation(body):
    """T of the derived equations, by the angle of the body: J + m c² and no other mass."""
    equations = derive(build_topology(load("ninebar")))
    own = equations.symbols.coordinates[body]
    m, c, inertia = sp.symbols(f"m_{body} c_{body} J_{body}", real=True)
    alone = equations.kinetic_energy.subs(
        {s: 0 for s in equations.kinetic_energy.free_symbols
         if s.name.startswith(("m_", "J_")) and s not in (m, inertia)}
    )  # fmt: skip
    speed = equations.symbols.rates[own]
    assert sp.simplify(alone - (inertia + m * c**2) * speed**2 / 2) == 0


@pytest.mark.parametrize("angle", ["15 deg", "100 deg", "250 deg"])
def test_energy_as_printed_keeps_the_weights(angle):
    """With the cranks held, torques balance the weights alone: nothing may have changed."""
    held = {"drives.crank1.speed": 0, "drives.crank4.speed": 0, "drives.crank1.angle": angle}
    shipped = load("ninebar-ideal")
    torques = [
        simulate(load("ninebar-ideal", set={**held, **changes}), samples=2).data.drive_effort[0]
        for changes in ({}, misprints.energy_as_printed(shipped))
    ]
    assert torques[0].to_numpy() == pytest.approx(torques[1].to_numpy(), rel=1e-12)
