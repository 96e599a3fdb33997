"""Stops that pull: damping in tension and adhesion, against closed forms and balances."""

import numpy as np
import pytest
from component_reading import complaints

import linkages

FREE = """
joints: {O: [0, 0]}
sliders: {m: {joint: P, through: O, angle: 0, mass: 2}}
"""
OUTPUTS = ["slider_position", "slider_velocity", "spring_force", "energy_residual"]


def run(text, end, outputs=("slider_position", "stop_force"), samples=11):
    return linkages.simulate(linkages.loads(text), end=end, samples=samples, outputs=list(outputs))


@pytest.mark.parametrize("pulls", [True, False])
def test_damping_in_tension(pulls):
    """Half a damped swing, or as much of it as pushes."""
    stiffness, damping, mass = 5000.0, 60.0, 2.0
    keys = f"stiffness: {stiffness}, damping: {damping}, pulls: {str(pulls).lower()}"
    text = FREE + f"stops: [{{slider: m, upper: 0, {keys}}}]\n"
    data = run(text + "free: {m: {position: -0.1, speed: 1}}\n", 0.5, OUTPUTS, 501).data
    decay, rate = damping / (2 * mass), np.sqrt(stiffness / mass - (damping / (2 * mass)) ** 2)
    # k d + c d' = 0 where tan(ω t) = −2 δ ω m / (k − …): the angle of the force against d
    angle = np.pi if pulls else np.pi - np.arctan2(damping * rate, stiffness - damping * decay)
    time = angle / rate
    left = np.exp(-decay * time) * (np.cos(angle) - decay / rate * np.sin(angle))
    assert data.slider_velocity.to_numpy()[-1, 0] == pytest.approx(left, abs=1e-8)
    # springs are positive where they pull: with the axis here
    assert (data.spring_force.max().item() > 1.0) == pulls
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8  # of 1 J


def test_adhesion_of_a_rigid_stop():
    """5 N − 20 N/s·t reaches −7 N at 0.6 s; then the block moves off."""
    text = FREE + (
        "stops: [{slider: m, upper: 0, restitution: 0.4, adhesion: 7}]\n"
        "loads: [{slider: m, force: 5 - 20*t}]\nfree: {m: {position: 0}}\n"
    )
    solution = run(text, 1.0)
    assert solution.motion.changes["stops[0].upper: press"].time == pytest.approx([0.6], abs=1e-12)
    late = np.maximum(solution.data.time.to_numpy() - 0.6, 0.0)
    moved = (-7 * late**2 / 2 - 20 * late**3 / 6) / 2
    assert solution.data.slider_position.to_numpy()[:, 0] == pytest.approx(moved, abs=1e-12)
    force = solution.data.stop_force.to_numpy()[:6, 0]
    assert force == pytest.approx(5 - 20 * solution.data.time.to_numpy()[:6], abs=1e-12)
    found = linkages.sensitivities(
        linkages.loads(text), "final(m.position)", ["stops[0].adhesion"], end=1.0
    )
    # −(F τ²/2 + 20 τ³/6)/2 with τ = 1 − (5 + F)/20
    assert found["final(m.position)"].item() == pytest.approx(7 * 0.4 / 40, rel=1e-8)


def test_a_stop_holds_for_long():
    """1000 s under a steady pull below the adhesion, and the same of two bars."""
    text = """
joints: {O: [0, 0]}
bars: {arm: {joints: [O, P], length: 1, mass: 1}}
gravity: [0, -10]
stops: [{bars: [ground, arm], upper: 0, restitution: 0, adhesion: 5.1 N m}]
free: {arm: {angle: 0}}
"""
    solution = run(text, 1000.0, ("bar_angle", "stop_torque"))
    assert abs(solution.data.bar_angle.to_numpy()).max() < 1e-9
    assert solution.data.stop_torque.to_numpy()[:, 0] == pytest.approx(-5.0, rel=1e-9)
    weak = run(text.replace("5.1", "4.9"), 0.1, ("bar_angle", "stop_torque"))
    assert weak.data.bar_angle.to_numpy()[-1, 0] < -0.05


def test_impacts_are_the_same_and_the_last_one_holds():
    """Bounces under a pull of 1 N away from the stop: none comes back but the slow ones, glued."""
    text = FREE + "stops: [{slider: m, upper: 0, restitution: 0.5, least_rate: 0.1 KEY}]\n"
    text += "loads: [{slider: m, force: -1}]\nfree: {m: {position: -0.1, speed: SPEED}}\n"
    glued = text.replace(" KEY", ", adhesion: 2")
    plain = text.replace(" KEY", "")
    fast = [run(one.replace("SPEED", "1.0"), 1.0).data for one in (glued, plain)]
    assert np.array_equal(*(data.slider_position for data in fast))
    slow = [run(one.replace("SPEED", "0.35"), 2.0).data for one in (glued, plain)]
    assert slow[0].slider_position.to_numpy()[-1, 0] == pytest.approx(0.0, abs=1e-10)
    assert slow[0].stop_force.to_numpy()[-1, 0] == pytest.approx(-1.0, abs=1e-9)
    assert slow[1].slider_position.to_numpy()[-1, 0] < -0.1


def test_adhesion_of_a_spring():
    """Elastic: the speed returns; the energy has its minimum −F²/(2 k); the pull is F at d = 0."""
    text = FREE + "stops: [{slider: m, upper: 0, stiffness: 5000, adhesion: 7}]\n"
    outputs = [*OUTPUTS, "potential_energy"]
    free = "free: {m: {position: -0.1, speed: 0.5}}\n"
    data = run(text + free, 0.5, outputs, 20001).data
    assert data.slider_velocity.to_numpy()[-1, 0] == pytest.approx(-0.5, abs=1e-9)
    assert data.potential_energy.min().item() == pytest.approx(-(7**2) / 10000, rel=1e-3)
    assert data.spring_force.max().item() == pytest.approx(7, abs=0.1)  # between samples
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
    rest = linkages.equilibrium(linkages.loads(text + free + "gravity: [2, 0]\n"))
    assert rest["state"].to_numpy()[0, 0] == pytest.approx((7 + 4) / 5000, rel=1e-9)


@pytest.mark.parametrize(("adhesion", "positions"), [(15, [-0.2]), (25, [-0.2, 0.0])])
def test_equilibria_that_adhesion_holds(adhesion, positions):
    """A spring of 100 N/m carries 20 N at −0.2 m; at the stop all of it is adhesion."""
    text = FREE.replace("angle: 0", "angle: 90 deg") + (
        "gravity: [0, -10]\n"
        f"stops: [{{slider: m, upper: 0, restitution: 0.4, adhesion: {adhesion}}}]\n"
        "springs: [{slider: m, stiffness: 100, position: 0}]\nfree: {m: {position: -0.1}}\n"
    )
    rest = linkages.equilibrium(linkages.loads(text))
    assert rest["state"].to_numpy()[:, 0] == pytest.approx(positions, abs=1e-9)
    assert rest["stable"].to_numpy().tolist() == [1] * len(positions)


def test_two_glued_blocks_share_a_pull():
    """Stops act together: of two blocks in line, the weaker one lets go first."""
    text = """
joints: {O: [0, 0]}
sliders:
  a: {joint: P, through: O, angle: 0, mass: 1}
  b: {joint: Q, through: O, angle: 0, mass: 1}
springs: [{between: [P, Q], stiffness: 1e3, length: 0.1}]
stops:
  - {slider: a, lower: 0, restitution: 0, adhesion: 3}
  - {slider: b, lower: 0.1, restitution: 0, adhesion: 9}
loads: [{slider: b, force: 10*t}]
free: {a: {position: 0}, b: {position: 0.1}}
"""
    changes = run(text, 1.3).motion.changes
    assert changes["stops[1].lower: press"].time == pytest.approx([0.9], abs=1e-9)
    # afterwards b pulls a: k x − … reaches 3 N
    assert 0.9 < changes["stops[0].lower: press"].time[0] < 1.1


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            "stiffness: 1e4, pulls: true",
            "pulls: without 'damping' a spring that is pressed in does",
        ),
        ("restitution: 0.5, pulls: true", "pulls: a stop with 'restitution' has none"),
        ("restitution: 0.5, adhesion: -1", "adhesion: expected a force >= 0"),
        ("restitution: 0.5, adhesion: 1 N*m", "adhesion: expected a force >= 0"),
    ],
)
def test_bad_input(entry, message):
    text = FREE + f"stops: [{{slider: m, upper: 0, {entry}}}]\nfree: {{m: {{position: -1}}}}\n"
    found = complaints(text)
    assert any(message in each for each in found), found
