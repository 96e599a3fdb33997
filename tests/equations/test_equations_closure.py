"""Vector loops against the paper's Eq. 1 and against loops written by hand."""

import pytest
import sympy as sp
from printed_modules import equations_of

from linkages.equations.expressions import Polar, components

NINE_BAR = """
joints: {O: [0, 0], D: [1.1, 0]}
bars:
  crank1: {joints: [O, A], length: 0.3}
  link2: {joints: [A, B], length: 0.893}
  link3: {joints: [C, B], length: 0.962}
  crank4: {joints: [D, C], length: 0.1}
  rocker6: {joints: [O, E], length: 0.85}
  link7: {joints: [E, B], length: 0.623}
  link8: {joints: [E, F], length: 0.85}
sliders: {slider9: {joint: F, through: O}}
clearances: {r1: {joint: C, bar: link3, size: 0.15 mm}}
drives: {crank1: {angle: 0.5, speed: -pi}, crank4: {angle: 1, speed: pi}}
"""


def written(terms):
    return [(str(term.length), str(term.angle)) for term in terms]


def test_nine_bar_is_the_papers_first_equation():
    first, second, third = equations_of(NINE_BAR).loops
    own = [("L_crank1", "theta_crank1"), ("L_link2", "theta_link2")]
    assert written(first.left) == own
    assert written(first.right) == [
        ("x_D", "0"),
        ("L_crank4", "theta_crank4"),
        ("r_r1", "alpha_r1"),
        ("L_link3", "theta_link3"),
    ]
    assert written(second.left) == own
    assert written(second.right) == [("L_rocker6", "theta_rocker6"), ("L_link7", "theta_link7")]
    assert written(third.left) == [("L_rocker6", "theta_rocker6"), ("L_link8", "theta_link8")]
    assert written(third.right) == [("s_slider9", "0")]
    assert [loop.apex for loop in (first, second, third)] == ["B", "E", "F"]


def test_residual_is_left_minus_right():
    loop = equations_of(NINE_BAR).loops[2]
    angle, other, way = sp.symbols("theta_rocker6 theta_link8 s_slider9", real=True)
    length, other_length = sp.symbols("L_rocker6 L_link8", real=True)
    assert loop.residual == (
        length * sp.cos(angle) + other_length * sp.cos(other) - way,
        length * sp.sin(angle) + other_length * sp.sin(other),
    )


def test_bar_defined_the_other_way_round_changes_sides():
    turned = NINE_BAR.replace("joints: [E, B]", "joints: [B, E]")
    loop = equations_of(turned).loops[1]
    assert written(loop.left)[-1] == ("L_link7", "theta_link7")
    assert written(loop.right) == [("L_rocker6", "theta_rocker6")]


def test_common_leading_steps_cancel():
    # A four-bar on the end of a driven bar: the bar that carries both sides drops out.
    loop = equations_of("""
joints: {O: [0.3, 0.1]}
bars:
  base: {points: {O: [0, 0], P: [1, 0], Q: [1, 0.5]}}
  first: {joints: [P, A], length: 0.3}
  second: {joints: [A, B], length: 0.8}
  third: {joints: [Q, B], length: 0.6}
drives: {base: {angle: 0, speed: 1}, first: {angle: 1, speed: 1}}
""").loops[0]
    symbols = {symbol.name for value in loop.residual for symbol in value.free_symbols}
    assert not symbols & {"x_O", "y_O"}
    base = [(str(t.length), str(t.angle)) for t in loop.terms if "base" in str(t.angle)]
    assert base == [("x_base_P - x_base_Q", "theta_base"), ("-y_base_Q", "theta_base + pi/2")]


@pytest.mark.parametrize(
    ("angle", "expected"), [("0", "0"), ("-90 deg", "3*pi/2"), ("0.3", "phi_s")]
)
def test_axis_angle_is_structure_at_right_angles(angle, expected):
    loop = equations_of(f"""
joints: {{O: [0, 0]}}
bars: {{crank: {{joints: [O, A], length: 0.3}}, rod: {{joints: [A, B], length: 0.8}}}}
sliders: {{s: {{joint: B, through: [0.2, 0], angle: {angle}}}}}
drives: {{crank: {{angle: 0, speed: 1}}}}
""").loops[0]
    assert ("s_s", expected) in written(loop.right)
    assert ("x_s_0", "0") in written(loop.right)  # apart from the displacement on a horizontal axis


def test_axis_on_a_moving_body_turns_with_it():
    equations = equations_of("""
joints: {O: [0, 0], P: [0, -0.5]}
bars: {crank: {joints: [O, A], length: 0.2}, lever: {joints: [P, B], length: 0.9}}
sliders: {block: {joint: A, on: lever, through: [0.1, 0], angle: 0.3}}
drives: {crank: {angle: 0, speed: 1}}
""")
    (loop,) = equations.loops
    assert written(loop.left) == [("L_crank", "theta_crank")]
    assert written(loop.right) == [
        ("y_P", "pi/2"),
        ("x_block_0", "theta_lever"),
        ("s_block", "phi_block + theta_lever"),
    ]
    assert loop.apex == "the axis of block"
    assert [unknown.name for unknown in loop.unknowns] == ["theta_lever", "s_block"]


def test_points_of_a_block_lie_beside_its_joint():
    loop = equations_of("""
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.2}, rod: {joints: [A, B], length: 0.9}}
sliders: {block: {joint: C, through: O, points: {B: [0.1, 0.05]}}}
masses: {C: 1}
drives: {crank: {angle: 0, speed: 1}}
""").loops[0]
    assert written(loop.right) == [("y_block_B", "pi/2"), ("x_block_B", "0"), ("s_block", "0")]


def test_welded_and_geared_bodies_have_no_coordinate():
    equations = equations_of("""
joints: {O: [0, 0], P: [1, 0], Q: [0, 1]}
bars:
  crank: {joints: [O, A], length: 0.2}
  rod: {joints: [A, B], length: 0.9}
  arm: {joints: [B, C], length: 0.1}
  lever: {joints: [P, C], length: 0.5}
  wheel: {points: {Q: [0, 0], W: [0.1, 0]}, mass: 1, center: [0, 0], inertia: 1}
welds: {B: {bars: [rod, arm], angle: 90 deg}}
gears: [{bars: [lever, wheel], ratio: -2, angle: 0.1}]
drives: {crank: {angle: 0, speed: 1}}
""")
    names = [coordinate.name for coordinate in equations.coordinates]
    assert names == ["theta_crank", "theta_rod", "theta_lever"]
    rod, lever, ratio, start = sp.symbols("theta_rod theta_lever i_1 phi_1", real=True)
    assert [d.value for d in equations.followers] == [rod + sp.pi / 2, ratio * lever + start]
    (loop,) = equations.loops
    assert ("L_arm", "theta_rod + pi/2") in written(loop.terms)
    inertia = equations.lagrange.masses[lever, lever].value
    assert sp.simplify(inertia - ratio**2 * sp.Symbol("J_wheel", real=True)) == 0


def test_groups_of_several_loops_share_their_unknowns():
    equations = equations_of("""
joints: {O: [0, 0], C: [1, 0.1], D: [0.4, 0.9]}
bars:
  crank: {joints: [O, A], length: 0.1}
  one: {joints: [A, E], length: 0.4}
  two: {joints: [C, F], length: 0.4}
  three: {joints: [D, G], length: 0.4}
  plate: {points: {E: [0, 0], F: [0.4, 0], G: [0.2, 0.2]}}
drives: {crank: {angle: 0, speed: 1}}
""")
    (block,) = equations.blocks
    assert len(block.loops) == 2
    assert len(block.unknowns) == 4
    assert block.surplus == 0
    (coefficients,) = equations.lagrange.blocks
    system = coefficients.system
    assert system.matrix.shape == (4, 4)
    assert system.coefficients.shape == (4, 1)
    unknowns = sp.Matrix(block.unknowns)
    assert sp.simplify(system.matrix - sp.Matrix(equations.closure).jacobian(unknowns)) == sp.zeros(
        4
    )


def test_pendulum_has_no_loops():
    equations = equations_of("""
joints: {O: [0, 0]}
bars: {bar: {joints: [O, tip], length: 1, mass: 1}}
free: {bar: {angle: 0}}
""")
    assert equations.loops == ()
    assert equations.closure == ()


def test_derivative_of_a_polar_vector():
    angle, length, both = sp.symbols("angle length both", real=True)
    vector = Polar(length + 2 * both, angle - both)
    for coordinate in (angle, length, both):
        derived = components(vector.derivative(coordinate))
        direct = [sp.diff(value, coordinate) for value in vector.components]
        assert all(sp.simplify(a - b) == 0 for a, b in zip(derived, direct, strict=True))
