"""Side thrust and moment of guides: textbook closed forms, and efforts that hold the guides."""

import numpy as np
import pytest

import linkages

CRANK = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.3}
  rod: {joints: [A, B], length: 0.2ROD}
sliders: {piston: {joint: B, through: O, angle: ANGLE, mass: 0.8}}
drives: {crank: {angle: 0.3, speed: 150}}
loads: [{slider: piston, force: "-500 - 300*sin(40*t)"}]
simulate: {end: 0.1, samples: 301}
"""
WANTED = ["guide_reaction", "guide_moment", "joint_reaction", "slider_acceleration",
          "slider_position", "joint_position", "bar_angle", "drive_effort"]  # fmt: skip


def run(text):
    return linkages.simulate(linkages.loads(text), outputs=WANTED).data


@pytest.mark.parametrize("angle", ["0", "90 deg", "35 deg"])
def test_the_thrust_of_a_piston_on_a_massless_rod_is_its_force_times_the_tangent(angle):
    """N = P tan φ with the thrust of the rod along the axis, P = m a − F. R. L. Norton, *Design of
    Machinery*, chapter 13 (piston sidewall forces)."""
    data = run(CRANK.replace("ROD", "").replace("ANGLE", angle))
    acceleration = data.slider_acceleration.values[:, 0]
    force = 0.8 * acceleration + 500 + 300 * np.sin(40 * data.time.values)
    axis = np.radians(float(angle.removesuffix(" deg")))
    lean = data.bar_angle.sel(bar="rod").values - axis
    # the rod pushes the pin along itself with P/cos φ: the wall pushes back across the axis
    expected = -force * np.tan(lean)
    found = data.guide_reaction.values[:, 0]
    assert np.abs(found - expected).max() < 1e-11 * np.abs(expected).max()
    # a rod without mass turns nothing about the pin in the middle of the block
    assert np.abs(data.guide_moment.values).max() < 1e-12


HELD = """
gravity: [0, -9.81]
joints: {O: [0, 0], G: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.05, mass: 0.3}
  rod: {joints: [A, B], length: 0.2, mass: 0.4}
sliders:
  rail: {joint: R, through: O, angle: 90 deg}
  piston: {joint: B, on: rail, through: R, angle: -90 deg, mass: 0.8}
drives: {crank: {angle: 0.3, speed: 150}, rail: {position: 0, speed: 0}}
simulate: {end: 0.1, samples: 301}
"""


def test_thrust_is_the_effort_of_a_drive_that_holds_the_guide_across():
    """By virtual work, of equations that know no reactions."""
    fixed = CRANK.replace("ROD", ", mass: 0.4").replace("ANGLE", "0")
    fixed = fixed[: fixed.index("loads:")] + "simulate: {end: 0.1, samples: 301}\n"
    one = run(f"gravity: [0, -9.81]\n{fixed}")
    other = run(HELD)
    found = one.guide_reaction.values[:, 0]
    held = other.drive_effort.sel(drive="rail").values
    assert np.abs(found).max() > 100
    assert np.abs(found - held).max() < 1e-10 * np.abs(found).max()
    # the guide on the rail: along its own axis turned by a right angle, which is the ground's y
    thrust = other.guide_reaction.sel(slider="piston").values
    assert np.abs(thrust - found).max() < 1e-10 * np.abs(found).max()


TOOL = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.1, -0.2]}
bars:
  arm: {points: {O: [0, 0], E: [0.4, 0]}, mass: 1, center: [0.2, 0], inertia: 0.02}
  tool: {points: {B: [0, 0], T: [0.05, 0.3]}, mass: 2, center: [0.02, 0.15], inertia: 0.03}
sliders: {ram: {joint: B, on: arm, through: O, mass: 1.5, inertia: 0.004}}
welds: {B: {bars: [arm, tool], angle: 90 deg}}
drives: {arm: {law: 0.3*sin(3*t)}, ram: {law: 0.2 + 0.1*cos(5*t)}}
loads: [{joint: T, force: [30, -20]}]
simulate: {end: 2, samples: 401}
"""


def test_the_moment_of_a_guide_carries_what_is_fixed_to_its_slider():
    """The arm that carries the guide is held by a drive: its torque is thrust, moment and arm."""
    data = run(TOOL)
    t = data.time.values
    angle, spin = 0.3 * np.sin(3 * t), -2.7 * np.sin(3 * t)
    position = data.slider_position.values[:, 0]
    # about O: weight and inertia of the arm, and what the ram does to it
    own = (0.02 + 1 * 0.2**2) * spin + 9.81 * 0.2 * np.cos(angle)
    thrust, moment = data.guide_reaction.values[:, 0], data.guide_moment.values[:, 0]
    torque = own + thrust * position + moment
    found = data.drive_effort.sel(drive="arm").values
    assert np.abs(moment).max() > 1.0
    assert np.abs(found - torque).max() < 1e-12 * np.abs(found).max() + 1e-12


def test_moment_and_thrust_of_an_overhung_load_at_rest():
    """A lever of 0.3 m on a slider: force and moment of statics, and the weight of all of it."""
    data = run("""
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {lever: {joints: [B, T], length: 0.3, mass: 2}}
sliders: {ram: {joint: B, through: O, mass: 1}}
welds: {B: {bars: [ground, lever], angle: 0}}
drives: {ram: {position: 0.1, speed: 0.2}}
loads: [{joint: T, force: [0, -50]}]
""")
    # at constant speed: 50 N and 3 kg to be carried, 50 N at 0.3 m and 2 kg at 0.15 m
    assert np.abs(data.guide_reaction.values - (50 + 3 * 9.81)).max() < 1e-12
    assert np.abs(data.guide_moment.values - (50 * 0.3 + 2 * 9.81 * 0.15)).max() < 1e-12


def test_thrust_is_differentiated_measured_and_compiled():
    made = linkages.loads(CRANK.replace("ROD", ", mass: 0.4").replace("ANGLE", "0"))
    path, step = "bars.rod.length", 1e-6
    found = linkages.sensitivities(made, "guide_reaction", [path]).guide_reaction.values[..., 0]
    ends = [
        linkages.simulate(made.with_values({path: 0.2 + s}), outputs=["guide_reaction"]).data
        for s in (step, -step)
    ]
    difference = (ends[0].guide_reaction.values - ends[1].guide_reaction.values) / (2 * step)
    # round-off of 1 kN over 1 µm
    assert np.abs(found - difference).max() < 1e-5 * np.abs(difference).max()
    swept = linkages.sweep(made, {path: [0.2, 0.3]}, "max(abs(piston.guide_reaction))")
    dense = linkages.simulate(made, outputs=["guide_reaction"]).maxima
    peak = next(abs(row["value"]) for row in dense if row["variable"] == "guide_reaction")
    first = float(np.ravel(swept["max(abs(piston.guide_reaction))"])[0])
    assert first == pytest.approx(peak, rel=1e-9)
