"""Small mechanisms that random ones led to, against the absolute formulation at t = 0."""

import pytest
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from kernel_values import at_start, disagreements, state_at

import linkages
from linkages.components.mechanisms.definition import load
from linkages.kernel.system import choose_free
from linkages.reading.document import shipped

YOKE = """\
joints: {O: [0, 0], C: [1, 0]}
bars:
  crank: {joints: [O, A], length: 0.3, mass: 1}
  b2: {joints: [P, Q], length: 0.7, mass: 1}
  b3: {joints: [C, Q], length: 0.7, mass: 1}
sliders:
  yoke: {joint: Y, through: O, angle: 0, mass: 1}
  pin: {joint: A, on: yoke, through: Y, angle: 90 deg, mass: 1, points: {P: [0.1, 0.1]}}
drives: {crank: {angle: 0.5, speed: 1}}
assembly: {Q: [0.6, 0.6]}
"""
LEG = "  b3: {joints: [C, Q], length: 0.7, mass: 1}\n"
CASES = {
    # the block at A is placed before the displacements of yoke and block are known
    "a dyad on a corner of a block in a yoke": YOKE,
    "a driven bar on a corner of a block in a yoke": YOKE.replace(LEG, "")
    .replace("drives: {", "drives: {b2: {angle: 0.2, speed: 1}, ")
    .replace("assembly: {Q: [0.6, 0.6]}\n", ""),
    "a yoke held at a pin on the ground": """\
joints: {O: [0.5, 0], G: [0, 0]}
bars: {crank: {joints: [G, J], length: 0.5, mass: 1}}
sliders:
  s1: {joint: A, through: G, angle: 0, mass: 1}
  s2: {joint: O, on: s1, through: [0.5, 0], angle: 90 deg, mass: 1}
drives: {crank: {angle: 0.3, speed: 1}}
""",
}


def check(mechanism, tolerance):
    mechanism = choose_free(mechanism)
    found = at_start(mechanism)
    model = AbsoluteModel(mechanism)
    expected = outputs(model, model.solve(state_at(model, found, 0.0)))
    assert not disagreements(found, expected, tolerance)


@pytest.mark.parametrize("case", CASES)
def test_special_case(case):
    check(linkages.loads(CASES[case]), 1e-12)


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return", "pendulum")
@pytest.mark.parametrize(
    "name", [name for name in shipped() if not (load(name).contacts or load(name).ends)]
)
def test_shipped_mechanisms(name):
    """Contact has an independent formulation of its own, in tests/contact.

    Some have redundant constraints, or masses that move little: a thousand more roundings."""
    check(load(name), 1e-9)


@pytest.mark.parametrize("angle", [1.0, 4.0, -10.0])
def test_whole_turns_of_a_torsional_spring_count(angle):
    """A bar that is wound up by more than half a turn: θ̈ = −k θ/J with J = m L²/3."""
    mechanism = linkages.loads(
        "joints: {O: [0, 0]}\nbars: {bar: {joints: [O, P], length: 1, mass: 3}}\n"
        f"free: {{bar: {{angle: {angle}}}}}\nsprings: [{{bar: bar, stiffness: 2}}]\n"
    )
    acceleration = at_start(mechanism)["bar_acceleration"]["bar"]
    assert acceleration == pytest.approx(-2 * angle, rel=1e-12)
