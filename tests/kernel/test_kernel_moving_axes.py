"""Sliders on axes that move, against closed forms of textbook mechanisms."""

import numpy as np
import pytest
from kernel_motion import difference
from linkage_models import refusal, system_of, values

TIMES = np.linspace(0, 1.1, 23)


def with_derivatives(f, times=TIMES):
    """A function of time, its rate and acceleration by differences of eighth order."""
    step = 4e-3
    rate = [difference(lambda h, t=t: f(t + h), step) for t in times]
    second = [
        difference(lambda h, t=t: difference(lambda k, h=h, t=t: f(t + h + k), step), step)
        for t in times
    ]
    return np.array([f(t) for t in times]), np.array(rate), np.array(second)


def check(of, names, f, index=0, scale=1.0):
    """A coordinate and its derivatives; with rates up to 10/s differences keep ten digits."""
    value, rate, second = with_derivatives(f)
    found = [values(of, name, TIMES)[index] for name in names]
    assert found[0] == pytest.approx(value, abs=5e-15 * scale)
    assert found[1] == pytest.approx(rate, abs=1e-10 * scale)
    assert found[2] == pytest.approx(second, abs=1e-7 * scale)
    closure = values(of, "closure_residual", TIMES)
    assert np.abs(closure).max() < 4e-15


BAR = ("bar_angle", "bar_speed", "bar_acceleration")
SLIDER = ("slider_position", "slider_velocity", "slider_acceleration")

QUICK_RETURN = """
joints: {O: [0, 0], P: [0, 0.1]}
bars:
  crank: {joints: [P, A], length: 0.05}
  arm: {joints: [O, B], length: 0.25}
sliders: {block: {joint: A, on: arm, through: THROUGH, angle: ANGLE}}
drives: {crank: {angle: 0.2, speed: 3}}
"""


def pin(t):
    """The crank's pin A in complex notation."""
    return 0.1j + 0.05 * np.exp(1j * (0.2 + 3 * t))


@pytest.mark.parametrize(("hint", "side"), [("[0, 1]", 1), ("[0, -1]", -1)])
def test_quick_return(hint, side):
    """The arm points to A, or away from it: θ = arg A, s = ±|A|."""
    text = QUICK_RETURN.replace("THROUGH", "O").replace("ANGLE", "0")
    of = system_of(text + f"assembly: {{B: {hint}}}")
    assert of.topology.solved_blocks[0].kind == "RPR"
    assert of.assembly.sides == {0: side}
    check(of, BAR, lambda t: np.angle(side * pin(t)), index=1)
    check(of, SLIDER, lambda t: side * abs(pin(t)))


@pytest.mark.parametrize("e", [0.02, -0.03])
@pytest.mark.parametrize("turned", [0.0, 90.0, 25.0, 180.0])
@pytest.mark.parametrize("ahead", [0.0, 0.04])
def test_offset_quick_return(e, turned, ahead):
    """The axis passes the arm's pin at the distance e: s = √(|A|² − e²) seen along the axis.

    Displacements count from a point that lies ahead of the foot of the perpendicular.
    """
    direction = np.exp(1j * np.radians(turned))
    offset = (e * 1j + ahead) * direction
    x, y = float(offset.real), float(offset.imag)
    text = QUICK_RETURN.replace("THROUGH", f"[{x!r}, {y!r}]").replace("ANGLE", f"{turned} deg")
    of = system_of(text)
    assert of.assembly.assumed == (0,)  # forward, unless told otherwise

    def forward(t):
        return np.sqrt(abs(pin(t)) ** 2 - e * e)

    check(of, SLIDER, lambda t: forward(t) - ahead)
    # A = (e i + s) times both directions
    check(of, BAR, lambda t: np.angle(pin(t) / ((forward(t) + e * 1j) * direction)), index=1)


def test_an_axis_that_passes_too_far_from_the_pin():
    text = QUICK_RETURN.replace("THROUGH", "[0, 0.2]").replace("ANGLE", "0")
    message = refusal(text)
    assert "the axis of block on arm cannot reach its pin" in message
    assert "expected at least 0.2 m" in message


HYDRAULIC = """
joints: {O: [0, 0], C: [0.6, -0.1]}
bars:
  boom: {joints: [O, A], length: 0.8}
  barrel: {joints: [C, T], length: 0.4}
sliders: {rod: {joint: A, on: barrel, through: T}}
drives: {rod: {law: "0.35 + 0.1*sin(2*t)"}}
"""


@pytest.mark.parametrize(("word", "side"), [("[0.3, 0.7]", 1), ("[0.3, -0.7]", -1)])
def test_a_hydraulic_cylinder(word, side):
    """A drive of the slider: boom and cylinder are two links, one of them of given length."""
    of = system_of(HYDRAULIC + f"assembly: {{A: {word}}}")
    (block,) = of.topology.solved_blocks
    assert (block.kind, {*block.unknowns}) == ("RRR", {"boom", "barrel"})

    def boom(t):
        length, foot = 0.75 + 0.1 * np.sin(2 * t), 0.6 - 0.1j
        cosine = (0.64 + abs(foot) ** 2 - length**2) / (1.6 * abs(foot))
        return np.angle(foot) + side * np.arccos(cosine)

    check(of, BAR, boom)
    check(of, BAR, lambda t: np.angle(0.8 * np.exp(1j * boom(t)) - 0.6 + 0.1j), index=1)
    check(of, SLIDER, lambda t: 0.35 + 0.1 * np.sin(2 * t))


@pytest.mark.parametrize("angle", [90, 60])
def test_scotch_yoke(angle):
    """An upright slot gives an exact cosine; an inclined one adds its share of the sine."""
    of = system_of(f"""
joints: {{O: [0, 0]}}
bars: {{crank: {{joints: [O, A], length: 0.05}}}}
sliders:
  yoke: {{joint: Y, through: O}}
  pin: {{joint: A, on: yoke, through: Y, angle: {angle} deg}}
drives: {{crank: {{angle: 0.3, speed: 4}}}}
""")
    assert [b.kind for b in of.topology.solved_blocks] == ["PP"]
    slope = np.tan(np.radians(angle))

    def place(t):
        return 0.05 * np.exp(1j * (0.3 + 4 * t))

    check(of, SLIDER, lambda t: place(t).real - place(t).imag / slope)
    check(of, SLIDER, lambda t: place(t).imag / np.sin(np.radians(angle)), index=1)


ROTATING_GUIDE = """
joints: {O: [0, 0], C: [0.3, 0.1]}
bars:
  arm: {joints: [O, E], length: 0.5}
  link: {joints: [C, B], length: 0.6}
sliders: {block: {joint: B, on: arm, through: [0.05, 0.03], angle: 20 deg}}
drives: {arm: {angle: 0.2, speed: 3}}
"""


@pytest.mark.parametrize(("hint", "side"), [("[1, 0.5]", 1), ("[-1, -0.5]", -1)])
def test_a_link_and_a_slider_on_a_driven_arm(hint, side):
    """A circle and a line that turns: RRP on a moving axis, with Coriolis accelerations."""
    of = system_of(ROTATING_GUIDE + f"assembly: {{B: {hint}}}")
    (block,) = of.topology.solved_blocks
    assert (block.kind, block.unknowns) == ("RRP", ("link", "block"))

    def displacement(t):
        frame = np.exp(1j * (0.2 + 3 * t))
        relative = (0.3 + 0.1j - (0.05 + 0.03j) * frame) / (frame * np.exp(1j * np.radians(20)))
        return relative.real + side * np.sqrt(0.36 - relative.imag**2)

    def link(t):
        frame = np.exp(1j * (0.2 + 3 * t))
        axis = frame * np.exp(1j * np.radians(20))
        return np.angle((0.05 + 0.03j) * frame + displacement(t) * axis - 0.3 - 0.1j)

    check(of, SLIDER, displacement)
    found = values(of, "bar_angle", TIMES)[1]
    assert np.exp(1j * found) == pytest.approx(np.exp(1j * link(TIMES)), abs=1e-14)
    for below, above, tolerance in ((0, 1, 1e-9), (1, 2, 1e-8)):
        step = 4e-3
        for t in (0.1, 0.7):
            slope = difference(
                lambda h, t=t, n=BAR[below]: np.unwrap(values(of, n, [t, t + h])[1])[1], step
            )
            assert values(of, BAR[above], t)[1, 0] == pytest.approx(slope, abs=tolerance)


def test_points_of_a_block_turn_with_what_carries_it():
    text = ROTATING_GUIDE.replace("angle: 20 deg", "angle: 20 deg, points: {T: [0.1, 0.05]}")
    of = system_of(text)
    places = of.places()
    direction = np.exp(1j * (0.2 + np.radians(20)))
    (bx, by), (tx, ty) = places["B"], places["T"]
    assert (tx - bx) + 1j * (ty - by) == pytest.approx((0.1 + 0.05j) * direction, abs=1e-15)
    index = 2 * of.topology.joints.index("T")
    for name, other in (
        ("joint_position", "joint_velocity"),
        ("joint_velocity", "joint_acceleration"),
    ):
        slope = difference(lambda h, n=name: values(of, n, 0.3 + h)[index : index + 2, 0], 4e-3)
        found = values(of, other, 0.3)[index : index + 2, 0]
        assert found == pytest.approx(slope, abs=1e-9)


def test_effort_of_a_hydraulic_cylinder_by_virtual_work():
    """At rest the force times ṡ lifts the boom's weight: F ds = m g dy."""
    still = HYDRAULIC.replace('{law: "0.35 + 0.1*sin(2*t)"}', "{position: 0.35, speed: 0}")
    heavy = still.replace("length: 0.8", "length: 0.8, mass: 10")
    text = "gravity: [0, -9.81]\n" + heavy + "assembly: {A: [0.3, 0.7]}"
    of = system_of(text)

    def height(shift):
        moved = system_of(text.replace("position: 0.35", f"position: {0.35 + shift!r}"))
        return moved.places()["A"][1] / 2

    force = 10 * 9.81 * difference(height, 1e-3)
    assert values(of, "drive_effort")[0, 0] == pytest.approx(force, rel=1e-10)  # 1e-16/1e-3


def test_the_force_in_a_moving_guide_acts_on_both():
    """Between a driven rod and its free barrel: power is force times the rate of sliding."""
    text = HYDRAULIC.replace('drives: {rod: {law: "0.35 + 0.1*sin(2*t)"}}', "free: {rod: FREE}")
    text = text.replace("FREE", "{position: 0.35, speed: 0.2}").replace(
        "length: 0.8", "length: 0.8, mass: 10"
    )
    of = system_of(text + "loads: [{slider: rod, force: 7}]\nassembly: {A: [0.3, 0.7]}")
    without = system_of(text + "assembly: {A: [0.3, 0.7]}")
    (a,), (b,) = (s.evaluate(s.model.free_accelerations)[:, 0] for s in (of, without))
    (inertia,) = of.evaluate([of.model.mass_matrix[0][0]])[:, 0]
    assert inertia * (a - b) == pytest.approx(7.0, rel=1e-12)
    assert of.evaluate([of.model.load_power])[0, 0] == pytest.approx(7 * 0.2, rel=1e-15)
