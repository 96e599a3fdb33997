"""Printed equations: what they look like, and that what they say is true."""

import ast
import json
import keyword
import subprocess
import sys

import numpy as np
import pytest
from lagrange_mechanisms import MORE_MECHANISMS
from matplotlib.mathtext import MathTextParser
from printed_modules import equations_of, topology_of

from linkages.equations import derive, render
from linkages.equations.expressions import Notation
from linkages.equations.rendering import WIDTH, escaped, symbol_latex, symbol_text

SLIDER_CRANK = """
name: Slider-crank
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 0.3, mass: 1}, rod: {joints: [A, B], length: 0.8}}
sliders: {piston: {joint: B, through: O, mass: 2}}
drives: {crank: {angle: 0.5, speed: 10}}
loads: [{slider: piston, force: -40}]
"""

AWKWARD = (
    """
name: '50% of $names_ & {others} ''''''"""
    + '"""'
    + """ \\'
gravity: [1, -9.81]
joints: {lambda: [0, 0.1], sin: [1, 0]}
bars:
  link 2: {joints: [lambda, α], length: 0.3, mass: 1}
  link-2: {joints: [α, β], length: 0.8, mass: 1, center: [0.3, 0.1]}
  link_2: {joints: [sin, β], length: 0.9, mass: 1}
  import: {points: {β: [0.1, 0], 2: [0.5, 0], x: [0.1, 0.2]}, mass: 1, center: [0, 0], inertia: 1}
  "11": {joints: [2, 11], length: 0.7, mass: 0.1}
sliders:
  Ω-кулиса: {joint: 11, through: [0, 0.3], angle: 0.2, mass: 1}
clearances:
  pi: {joint: β, bar: link_2, size: 1 cm}
drives: {link 2: {angle: 0, speed: 3}}
free: {import: {angle: 1.1}}
"""
)

SLIDER_CRANK_TEXT = """\
Slider-crank

Coordinates
  q_1 = θ_crank = ω_crank·t + θ_crank,0   (driven)
  θ_rod   (dependent, from the loop closed at B)
  s_piston   (dependent, from the loop closed at B)

Closure, loop by loop
  L_crank∠θ_crank + L_rod∠θ_rod = s_piston   (at B)
  Φ_1 = L_crank·cos(θ_crank) + L_rod·cos(θ_rod) − s_piston = 0
  Φ_2 = L_crank·sin(θ_crank) + L_rod·sin(θ_rod) = 0

Centres of mass
  X_crank = c_crank∠θ_crank
  X_piston = s_piston

Kinetic energy
  T = Σ ½ m |Ẋ|² + ½ J θ̇² = ½ Σ a_uv u̇ v̇
  a_crank,crank = J_crank + c_crank²·m_crank
  a_piston,piston = m_piston

Potential energy
  V = −c_crank·g_y·m_crank·sin(θ_crank)

Velocity coefficients, loop by loop
  u̇ = Σ_i K_u,i q̇_i  with  K_u,i = ∂u/∂q_i
  K_rod,1 = −L_crank·cos(θ_crank)/(L_rod·cos(θ_rod))
  K_piston,1 = −L_crank·sin(θ_crank − θ_rod)/cos(θ_rod)

Inertia terms
  J_ij = Σ a_uv K_u,i K_v,j
  J_11 = K_piston,1²·a_piston,piston + a_crank,crank

Lagrange's equations
  Σ_j J_ij q̈_j + Σ_jk (∂J_ij/∂q_k − ½ ∂J_jk/∂q_i) q̇_j q̇_k + ∂V/∂q_i = Q_i
  ∂V/∂q_1 = −c_crank·g_y·m_crank·cos(θ_crank)
  Q_1 = F_1·K_piston,1 + M_crank
"""


EVERYTHING = """
name: Everything
joints: {O: [0, 0], C: [0.5, 0.1]}
bars:
  crank: {joints: [O, A], length: 0.15, mass: 0.5}
  lever: {joints: [C, B], length: 0.55, mass: 1.1}
  arm: {joints: [B, T], length: 0.2}
sliders: {block: {joint: A, on: lever, angle: 0.1}}
welds: {B: {bars: [lever, arm], angle: 90 deg}}
masses: {T: 0.3}
drives: {crank: {law: "0.5 + sin(2*t)**3"}}
loads:
  - {joint: T, force: [3, "2*t"]}
  - {bar: lever, torque: {rise: cycloidal, to: 3, duration: 2}}
  - {slider: block, force: {table: {times: [0, 1, 3], values: [1, 2, 0]}}}
springs: [{between: [O, T], stiffness: 100, length: 0.3, damping: 2}, {bar: arm, stiffness: 4}]
dampers: [{slider: block, damping: 3}]
"""

EVERYTHING_LINES = """\
  q_1 = θ_crank = p_crank,1 + sin(p_crank,2·t)³   (driven)
  q̇_1 = 3·p_crank,2·sin(p_crank,2·t)²·cos(p_crank,2·t)
  θ_lever   (dependent, from the loop closed at the axis of block)
  θ_arm = θ_lever + π/2   (by a relation)
  f_1(t)   (monotone cubics (pchip) through 3 points: loads[2].force.table)
  L_crank∠θ_crank = x_C + y_C∠90° + s_block∠(φ_block + θ_lever)   (at the axis of block)
  X_T = x_C + y_C∠90° + L_lever∠θ_lever + L_arm∠(θ_lever + 90°)
  D_O,T = |x_C + y_C∠90° + L_lever∠θ_lever + L_arm∠(θ_lever + 90°)|
  V = k_1·(D_O,T − L_1)²/2 + k_2·(θ_lever + π/2)²/2
  K_lever,1 = L_crank·cos(φ_block − θ_crank + θ_lever)/s_block
"""


@pytest.fixture(scope="module")
def awkward():
    return equations_of(AWKWARD)


def test_text_of_a_slider_crank():
    assert render(equations_of(SLIDER_CRANK), "text") == SLIDER_CRANK_TEXT


def test_text_is_the_default_and_folded(awkward):
    text = render(awkward)
    assert text == render(awkward, "text")
    assert max(map(len, text.splitlines())) <= WIDTH
    assert "θ_{link 2}" in text
    assert "θ_{link-2}" in text
    assert "L_link_2∠θ_link_2" in text
    assert "e_{link-2}∠(θ_{link-2} + 90°)" in text
    assert "− x_import,β∠θ_import" in text


def test_text_of_what_other_components_add():
    text = render(equations_of(EVERYTHING), "text")
    assert set(EVERYTHING_LINES.splitlines()) <= set(text.splitlines())
    forces = " ".join(text.split("Q_1 = ")[1].split())
    assert "K_block,1·(−b_1·ṡ_block + f_1(t))" in forces
    assert "M_2,to·[1 if −1 + t/M_2,duration ≥ 0, else [" in forces
    assert "− F_1,x·sin(θ_lever)" in forces
    assert "Ḋ_O,T·d_1·" in forces


def test_text_of_a_group_of_loops():
    text = render(derive(topology_of(MORE_MECHANISMS["class-three"])), "text")
    assert "Φ_z K = −Φ_q   (4 equations for 4 unknowns per coordinate)" in text
    assert "θ_leg1   (dependent, from the loops closed at F and G)" in text
    assert "= L_crank·sin(θ_crank)" in text
    text = render(derive(topology_of(MORE_MECHANISMS["parallelogram-free"])), "text")
    assert "(2 equations for 1 unknown per coordinate; 1 of them redundant: least squares)" in text


@pytest.mark.slow_except(
    "quick-return", "scotch-yoke", "cylinder-cycloidal", "crossed-sliders", "fixed-sun", "rack"
)
@pytest.mark.parametrize("name", MORE_MECHANISMS)
def test_all_kinds_are_printed(name):
    equations = derive(topology_of(MORE_MECHANISMS[name]))
    text = render(equations, "text")
    assert max(map(len, text.splitlines())) <= WIDTH + 20  # where nothing can be folded
    looks = set(map(symbol_text, equations.symbols.notations.values()))
    assert len(looks) == len(equations.symbols.notations)
    latex = render(equations, "latex")
    assert latex.count("{") == latex.count("}")
    for environment in ("align*", "cases"):
        begun = latex.count(rf"\begin{{{environment}}}")
        assert begun == latex.count(rf"\end{{{environment}}}")
    for unprinted in ("Select", "Spline", "**", "Piecewise"):
        assert unprinted not in text
        assert unprinted not in latex
    tree = ast.parse(render(equations, "python"))
    assert [n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)] == ["numpy"]


def test_identifiers_are_valid_and_unique(awkward):
    symbols = list(awkward.symbols.notations)
    names = [symbol.name for symbol in symbols]
    assert len(set(names)) == len(names)
    assert all(name.isidentifier() and name.isascii() for name in names)
    assert not any(map(keyword.iskeyword, names))


def test_looks_are_unique_in_text_and_latex(awkward):
    for write in (symbol_text, symbol_latex):
        looks = [write(notation) for notation in awkward.symbols.notations.values()]
        assert len(set(looks)) == len(looks)


def test_equal_looks_are_told_apart():
    # J_11 is the inertia of the bar called 11 and the first of the reduced inertia terms.
    text = render(equations_of(AWKWARD), "text")
    assert "J_{11'} = " in text


@pytest.mark.slow_except("slider-crank")
@pytest.mark.parametrize("text", [SLIDER_CRANK, AWKWARD], ids=["slider-crank", "awkward"])
def test_latex_is_well_formed(text):
    latex = render(equations_of(text), "latex")
    body = latex.replace(r"\{", "").replace(r"\}", "").replace(r"\_", "")
    assert body.count("{") == body.count("}")
    assert latex.count(r"\begin{align*}") == latex.count(r"\end{align*}") > 0
    parser = MathTextParser("path")
    for block in latex.split(r"\begin{align*}")[1:]:
        for row in block.split(r"\end{align*}")[0].split(r"\\"):
            formula, _, _ = row.partition("&&")
            unaligned = formula.replace("&", " ").replace(r"\text", r"\mathrm").strip()
            unaligned = unaligned.replace(r"\left(", "(").replace(r"\right)", ")")  # folded sums
            parser.parse(f"${unaligned}$")


def test_latex_escapes_what_means_something():
    assert escaped(r"50%_{\$&#^~}") == (
        r"50\%\_\{\textbackslash{}\$\&\#\textasciicircum{}\textasciitilde{}\}"
    )
    assert symbol_latex(Notation("theta", ("a_b",), 2)) == r"\ddot{\theta}_{\text{a\_b}}"


def test_dots_are_single_characters_where_unicode_has_them():
    assert symbol_text(Notation("s", ("a",), 1)) == "ṡ_a"
    assert symbol_text(Notation("t")) == "t"


def test_python_module_contains_no_name_outside_comments(awkward):
    source = render(awkward, "python")
    tree = ast.parse(source)
    constants = [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant)]
    texts = [value for value in constants if isinstance(value, str)]
    assert not any("link 2" in text or "names_" in text for text in texts)
    imported = [n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)]
    assert imported == ["numpy"]


@pytest.mark.slow
def test_python_module_runs_alone_and_is_right(awkward, tmp_path):
    """In a process of its own that has NumPy and neither SymPy nor this package."""
    path = tmp_path / "awkward.py"
    path.write_text(render(awkward, "python"), encoding="utf-8")
    rng = np.random.default_rng(3)
    q, dq = rng.normal(size=(2, len(awkward.coordinates)))
    script = f"""
import json, sys
sys.modules["sympy"] = sys.modules["linkages"] = None
sys.path.insert(0, {str(tmp_path)!r})
import awkward as m
q, dq = {q.tolist()}, {dq.tolist()}
print(json.dumps([
    m.closure(q).tolist(), m.closure_jacobian(q).tolist(), m.potential_gradient(q).tolist(),
    float(m.kinetic_energy(q, dq)), float(m.potential_energy(q)),
    float(m.potential_energy(q, {{**m.PARAMETERS, "g_x": 0.0, "g_y": 0.0}})),
    m.drives(2.0).tolist(), m.inertia(q).shape[0],
]))
"""
    command = [sys.executable, "-I", "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    closure, jacobian, gradient, kinetic, potential, weightless, driven, size = json.loads(
        done.stdout
    )

    numbers = awkward.symbols.values | dict(zip(awkward.coordinates, q, strict=True))
    rates = dict(zip(awkward.symbols.rates.values(), dq, strict=True))
    expected = [float(value.subs(numbers)) for value in awkward.closure]
    np.testing.assert_allclose(closure, expected, rtol=1e-12, atol=1e-14)
    slopes = [
        [float(v.diff(c).subs(numbers)) for c in awkward.coordinates] for v in awkward.closure
    ]
    np.testing.assert_allclose(jacobian, slopes, rtol=1e-12, atol=1e-14)
    forces = [float(awkward.potential_energy.diff(c).subs(numbers)) for c in awkward.coordinates]
    np.testing.assert_allclose(gradient, forces, rtol=1e-12, atol=1e-14)
    assert kinetic == pytest.approx(float(awkward.kinetic_energy.subs(numbers | rates)), rel=1e-12)
    assert potential == pytest.approx(float(awkward.potential_energy.subs(numbers)), rel=1e-12)
    assert weightless == 0.0
    assert driven == [6.0]
    assert size == len(awkward.driven) + len(awkward.free)


def test_unknown_format_is_refused():
    with pytest.raises(ValueError, match="expected one of: text, latex, python"):
        render(equations_of(SLIDER_CRANK), "html")


def test_importing_the_package_does_not_import_sympy():
    code = "import sys, linkages.equations; sys.exit('sympy' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)
