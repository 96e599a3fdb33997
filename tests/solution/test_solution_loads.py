"""Springs, dampers, gears, driven sliders and laws of time: energies, efforts, angles, forces."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from solution_mechanisms import FOUR_BAR, SLIDER_CRANK, derivative, mechanism

import linkages

FREE_FOUR_BAR = FOUR_BAR.replace("drives: {crank: {angle: 0.7, speed: 6}}", "")


def balanced(data, spacing, limit=1e-7):
    """d(T + V)/dt = P_drive + P_load, the left side by differences of order 8."""
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    power = (data.drive_power + data.load_power).to_numpy()[4:-4]
    return np.abs(derivative(energy, spacing) - power).max() < limit * max(
        1e-3, np.abs(power).max()
    )


# -- laws of time ----------------------------------------------------------------------------

LAWS = {
    "formula": "0.7 + 0.8*sin(9*t) + 3*t**2",
    "rise": "{rise: cycloidal, from: 0.7, to: 3, begin: -1, duration: 3}",
    "polynomial": "{rise: polynomial, from: 0.7, to: 200 deg, begin: -0.1, duration: 2}",
    "harmonic": "{harmonic: {mean: 1, amplitude: 30 deg, frequency: 2 Hz, phase: 20 deg}}",
    "tanh": "2 + tanh(4*t - 2) + exp(-t)",
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("text", [FOUR_BAR, SLIDER_CRANK], ids=["four-bar", "slider-crank"])
def test_effort_of_a_drive_by_a_law(text, law):
    """Efforts do the work: power is the rate of energy, and effort times speed."""
    start = text.index("drives:")
    given = text[:start] + f"drives: {{crank: {{law: {law}}}}}" + text[text.index("\n", start) :]
    spacing = 1e-3
    data = linkages.simulate(mechanism(given), end=1.0, samples=1001, outputs="all").data
    speed = data.bar_speed.sel(bar="crank")
    assert np.allclose(data.drive_effort[:, 0] * speed, data.drive_power, rtol=1e-12, atol=1e-12)
    assert balanced(data, spacing)
    scale = float(data.kinetic_energy.max()) + float(np.ptp(data.potential_energy.to_numpy())) + 30
    assert float(np.abs(data.energy_residual).max()) < 1e-10 * scale
    for values, rates in (("bar_angle", "bar_speed"), ("bar_speed", "bar_acceleration")):
        wanted = data[rates].to_numpy()[4:-4]
        found = derivative(data[values].to_numpy(), spacing)
        assert np.abs(found - wanted).max() < 1e-6 * max(1.0, np.abs(wanted).max())


def test_law_of_a_load():
    """A torque that turns with time: its work is part of the balance, an impulse of the motion.

    A bar about its centre feels nothing else: θ̈ = 3·sin(5t)/J.
    """
    found = mechanism(
        "joints: {O: [0, 0]}\nbars: {bar: {joints: [O, P], length: 1, mass: 2, center: 0, "
        "inertia: 0.4}}\nfree: {bar: {angle: 0.2, speed: 0}}\n"
        "loads: [{bar: bar, torque: 3*sin(5*t)}]\n"
    )
    data = linkages.simulate(found, end=3.0, samples=301, rtol=1e-12, outputs="all").data
    time = data.time.to_numpy()
    angle = 0.2 + 3 / 0.4 / 5 * (time - np.sin(5 * time) / 5)
    assert data.bar_angle.to_numpy()[:, 0] == pytest.approx(angle, abs=1e-10)
    assert float(np.abs(data.energy_residual).max()) < 1e-10


def test_law_backward_in_time():
    """A law is a function of t, also before 0."""
    found = mechanism(FOUR_BAR.replace("{angle: 0.7, speed: 6}", "{law: 0.7 + 2*t + 0.3*sin(5*t)}"))
    data = linkages.simulate(found, end=-1.0, samples=101, outputs="all").data
    time = data.time.to_numpy()
    angle = 0.7 + 2 * time + 0.3 * np.sin(5 * time)
    assert data.bar_angle.sel(bar="crank").to_numpy() == pytest.approx(angle, abs=1e-14)
    assert float(np.abs(data.energy_residual).max()) < 1e-11


# -- a drive of a slider ---------------------------------------------------------------------

PISTON = SLIDER_CRANK.replace(
    "drives: {crank: {angle: 0.3, speed: 50}}",
    "drives: {piston: {law: 0.14 + 0.03*sin(8*t)}}",
).replace("assembly: {B: [0.18, 0]}", "assembly: {A: [0, 0.04]}")


def test_driven_slider():
    """The crank's angle from the law of cosines, the force from the rate of energy."""
    spacing = 2e-3
    data = linkages.simulate(mechanism(PISTON), end=2.0, samples=1001, outputs="all").data
    position = 0.14 + 0.03 * np.sin(8 * data.time.to_numpy())
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(position, abs=1e-15)
    cosine = (position**2 + 0.04**2 - 0.14**2) / (2 * position * 0.04)
    crank = data.bar_angle.sel(bar="crank").to_numpy()
    assert crank == pytest.approx(np.arccos(cosine), abs=1e-13)
    assert data.drive_effort.attrs["units"] == "N"
    velocity = data.slider_velocity.to_numpy()[:, 0]
    assert data.drive_power.to_numpy() == pytest.approx(
        data.drive_effort.to_numpy()[:, 0] * velocity, abs=1e-12
    )
    assert balanced(data, spacing)
    assert float(np.abs(data.energy_residual).max()) < 1e-11


def test_driven_slider_stops_at_its_dead_centre():
    text = PISTON.replace("0.14 + 0.03*sin(8*t)", "0.14 + 0.1*t")
    with pytest.raises(linkages.IncompleteError) as caught:
        linkages.simulate(mechanism(text), end=1.0)
    assert caught.value.time == pytest.approx(0.4, abs=1e-6)
    assert "crank and rod are in line" in str(caught.value)


def test_driven_slider_and_driven_crank_need_the_same_power():
    """The slider moved as a driven crank moves it: the force does what the torque did."""
    crank = SLIDER_CRANK.replace("speed: 50", "speed: 5")
    law = "0.04*cos(0.3 + 5*t) + sqrt(0.14**2 - (0.04*sin(0.3 + 5*t))**2)"
    piston = SLIDER_CRANK.replace("crank: {angle: 0.3, speed: 50}", f"piston: {{law: {law}}}")
    piston = piston.replace("B: [0.18, 0]", "A: [0.04, 0.01]")
    first, second = (
        linkages.simulate(mechanism(text), end=0.5, samples=101, outputs="all").data
        for text in (crank, piston)
    )
    assert second.drive_power.to_numpy() == pytest.approx(first.drive_power.to_numpy(), abs=1e-9)
    for joint in ("A", "B"):
        assert second.joint_position.sel(joint=joint).to_numpy() == pytest.approx(
            first.joint_position.sel(joint=joint).to_numpy(), abs=1e-12
        )


# -- gears -----------------------------------------------------------------------------------

GEARED = """\
gravity: [0, -9.81]
joints: {O: [0, 0], C: [0.2, 0]}
bars:
  pinion: {joints: [O, P], length: 0.05, mass: 0.3}
  wheel: {joints: [C, Q], length: 0.12, mass: 0.8}
"""


@pytest.mark.parametrize("ratio", ["-7/22", "-0.318", "sqrt", "22/7"])
def test_gear_over_many_turns(ratio):
    """Whole turns count: after a hundred turns the wheel is where the ratio says, to a rounding."""
    value = 0.414213562373095 if ratio == "sqrt" else eval(ratio)
    text = (
        GEARED
        + f"gears: [{{bars: [pinion, wheel], ratio: {value!r}, angle: 0.3}}]\n"
        + "drives: {pinion: {angle: 1, speed: 63}}\n"
    )
    data = linkages.simulate(mechanism(text), end=10.0, samples=4001, outputs="all").data
    pinion = 1 + 63 * data.time.to_numpy()
    assert data.bar_angle.sel(bar="pinion").to_numpy() == pytest.approx(pinion, abs=1e-12)
    wheel = value * pinion + 0.3
    assert data.bar_angle.sel(bar="wheel").to_numpy() == pytest.approx(wheel, abs=1e-11)
    # against the weights of both, each half its length from its pin
    effort = 9.81 * (0.3 * 0.025 * np.cos(pinion) + value * 0.8 * 0.06 * np.cos(wheel))
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(effort, abs=1e-10)
    assert float(np.abs(data.energy_residual).max()) < 1e-10


@pytest.mark.parametrize("samples", [2, 5, 2001])
def test_free_gears_over_many_turns(samples):
    """One free angle and its follower against the textbook equation, whatever the samples are."""
    ratio = -0.318
    text = (
        GEARED
        + f"gears: [{{bars: [pinion, wheel], ratio: {ratio}, angle: 0.3}}]\n"
        + "free: {pinion: {angle: 1, speed: 60}}\n"
    )
    data = linkages.simulate(
        mechanism(text), end=5.0, samples=samples, rtol=1e-12, outputs="all"
    ).data
    inertia = 0.3 * 0.05**2 / 3 + ratio**2 * 0.8 * 0.12**2 / 3

    def rates(_, y):
        wheel = ratio * y[0] + 0.3
        weight = 0.3 * 0.025 * np.cos(y[0]) + ratio * 0.8 * 0.06 * np.cos(wheel)
        return [y[1], -9.81 * weight / inertia]

    exact = solve_ivp(
        rates, (0, 5), [1, 60], "DOP853", t_eval=data.time.to_numpy(), rtol=1e-12, atol=1e-12
    ).y
    pinion = data.bar_angle.sel(bar="pinion").to_numpy()
    # some hundred turns; both integrations at 1e-12
    assert pinion == pytest.approx(exact[0], abs=1e-7)
    assert pinion[-1] > 100
    wheel = data.bar_angle.sel(bar="wheel").to_numpy()
    assert wheel == pytest.approx(ratio * pinion + 0.3, abs=1e-11)
    assert float(np.abs(data.energy_residual).max()) < 1e-9


def test_geared_five_bar_closes_over_many_turns():
    """Both cranks of a five-bar linkage geared with a ratio that never comes back."""
    text = """\
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  one: {joints: [O, A], length: 0.2, mass: 0.2}
  two: {joints: [A, B], length: 0.6, mass: 0.6}
  three: {joints: [C, B], length: 0.6, mass: 0.6}
  four: {joints: [D, C], length: 0.2, mass: 0.2}
gears: [{bars: [one, four], ratio: -1.618033988749895, angle: 1}]
drives: {one: {angle: 0.5, speed: 40}}
assembly: {B: right}
"""
    spacing = 1e-3
    data = linkages.simulate(mechanism(text), end=4.0, samples=4001, outputs="all").data
    one = 0.5 + 40 * data.time.to_numpy()
    four = data.bar_angle.sel(bar="four").to_numpy()
    assert four == pytest.approx(1 - 1.618033988749895 * one, abs=1e-11)
    assert float(data.closure_residual.max()) <= 1e-13
    assert float(np.abs(data.energy_residual).max()) < 1e-8
    assert balanced(data, spacing, 1e-5)  # differences of order 8 at up to 65 rad/s


# -- springs and dampers ---------------------------------------------------------------------


def test_torsional_spring_over_several_turns():
    """Wound up by three turns: θ = θ₀ cos(ωt), ω² = k/J, with whole turns counted."""
    found = mechanism(
        "joints: {O: [0, 0]}\nbars: {bar: {joints: [O, P], length: 1, mass: 2, center: 0, "
        "inertia: 0.4}}\nfree: {bar: {angle: 20, speed: 0}}\n"
        "springs: [{bar: bar, stiffness: 5, angle: 0.5}]\n"
    )
    data = linkages.simulate(found, end=4.0, samples=401, rtol=1e-12, outputs="all").data
    omega = np.sqrt(5 / 0.4)
    angle = data.bar_angle.to_numpy()[:, 0]
    exact = 0.5 + 19.5 * np.cos(omega * data.time.to_numpy())
    assert angle == pytest.approx(exact, abs=1e-9)
    stored = data.potential_energy.to_numpy()
    assert stored == pytest.approx(0.5 * 5 * (angle - 0.5) ** 2, rel=1e-12, abs=1e-10)
    assert float(np.abs(data.energy_residual).max()) < 1e-11 * stored[0]


def test_torsional_spring_wound_up_by_a_motion():
    """A fast bar winds its spring by several turns and is thrown back: exact sine throughout."""
    found = mechanism(
        "joints: {O: [0, 0]}\nbars: {bar: {joints: [O, P], length: 1, mass: 2, center: 0, "
        "inertia: 0.4}}\nfree: {bar: {angle: 0.5, speed: 80}}\n"
        "springs: [{bar: bar, stiffness: 5, angle: 0.5}]\n"
    )
    data = linkages.simulate(found, end=4.0, samples=401, rtol=1e-12, outputs="all").data
    omega = np.sqrt(5 / 0.4)
    exact = 0.5 + 80 / omega * np.sin(omega * data.time.to_numpy())
    angle = data.bar_angle.to_numpy()[:, 0]
    assert np.ptp(angle) > 6 * 2 * np.pi
    assert angle == pytest.approx(exact, abs=1e-8)
    assert float(np.abs(data.energy_residual).max()) < 1e-8  # of 1280 J


PRELOADED = """\
joints: {O: [0, 0], C: [0.1, 0]}
bars:
  crank: {joints: [O, A], length: 40 mm, mass: 0.15}
  coupler: {joints: [A, B], length: 120 mm, mass: 0.45}
  rocker: {joints: [C, B], length: 80 mm, mass: 0.3}
"""


@pytest.mark.parametrize("turns", [0.0, -0.53, 1.0, -7.0])
@pytest.mark.parametrize("free", ["crank", "rocker"])
def test_torsional_spring_on_a_bar_that_follows_others_can_be_wound_up(turns, free):
    """Its angle without torque counts as given, whatever turns the rocker."""
    spring = f"springs: [{{bar: rocker, stiffness: 0.5, angle: {turns * 2 * np.pi!r}}}]"
    start = {"crank": np.pi / 4, "rocker": 1.0275955164581885}[free]
    places = "assembly: {A: [0.028, 0.028], B: [0.141, 0.069]}"
    found = mechanism(PRELOADED, places, spring, f"free: {{{free}: {{angle: {start!r}}}}}")
    solution = linkages.simulate(found, end=1e-3, samples=2, outputs="all")
    angle = float(solution.data.bar_angle.sel(bar="rocker")[0])
    assert angle == pytest.approx(1.0275955164581885)
    stored = 0.25 * (angle - turns * 2 * np.pi) ** 2
    assert float(solution.data.potential_energy[0]) == pytest.approx(stored, rel=1e-12)
    wound = [note for note in solution.notes if "starts wound by" in note]
    assert len(wound) == (free == "crank" and abs(turns) > 0.4)


def test_torsional_spring_between_bars_either_side_of_a_half_turn():
    """However the mechanism is turned, the angle between coupler and rocker is the same."""
    spring = "springs: [{between_bars: [coupler, rocker], stiffness: 0.5, angle: -200 deg}]"

    def turned(angle):
        pin = f"[{0.1 * np.cos(angle)}, {0.1 * np.sin(angle)}]"
        free = f"free: {{crank: {{angle: {np.pi / 4 + angle}}}}}"
        found = mechanism(PRELOADED.replace("[0.1, 0]", pin), "assembly: {B: left}", spring, free)
        return linkages.simulate(found, end=1e-3, samples=2, outputs="all").data.isel(time=0)

    plain, across = turned(0.0), turned(np.radians(140))
    coupler, rocker = (float(across.bar_angle.sel(bar=bar)) for bar in ("coupler", "rocker"))
    assert rocker < -np.pi / 2 < np.pi / 2 < coupler
    assert float(across.potential_energy) == pytest.approx(float(plain.potential_energy))
    assert float(plain.potential_energy) > 0.25 * np.pi**2  # wound by more than half a turn


@pytest.mark.parametrize("driven", [True, False])
def test_torsional_spring_between_bars_that_turn_over(driven):
    """A double pendulum whose joint is wound up: the spring sees whole turns of the difference."""
    rest = "drives: {upper: {angle: 0.3, speed: 3}}\nfree: {lower: {angle: 0.3, speed: 40}}\n"
    free = "free: {upper: {angle: 0.3, speed: -10}, lower: {angle: 0.3, speed: 60}}\n"
    found = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\nbars:\n"
        "  upper: {joints: [O, P], length: 0.5, mass: 1}\n"
        "  lower: {joints: [P, Q], length: 0.4, mass: 1}\n"
        "springs: [{between_bars: [upper, lower], stiffness: 0.05, angle: 0, damping: 1e-3}]\n"
        + (rest if driven else free)
    )
    spacing = 1e-3
    data = linkages.simulate(found, end=2.0, samples=2001, rtol=1e-12, outputs="all").data
    difference = (data.bar_angle.sel(bar="lower") - data.bar_angle.sel(bar="upper")).to_numpy()
    assert np.ptp(difference) > 2 * np.pi
    stored = 0.5 * 0.05 * difference**2
    places = data.joint_position
    heights = 0.5 * places.sel(joint="P", axis="y") + 0.5 * (
        places.sel(joint="P", axis="y") + places.sel(joint="Q", axis="y")
    )
    expected = 9.81 * heights.to_numpy() + stored
    assert data.potential_energy.to_numpy() == pytest.approx(expected, abs=1e-10)
    # dense output of order 7 at up to 100 rad/s, differentiated
    assert balanced(data, spacing, 1e-5)
    assert float(np.abs(data.energy_residual).max()) < 1e-8
    assert float(data.load_power.max()) <= 0  # dampers only take


@pytest.mark.parametrize("damping", [0, 0.4])
def test_spring_and_damper_between_joints(damping):
    """A slider on a spring: the damped oscillator in closed form."""
    mass, stiffness = 0.4, 90.0
    found = mechanism(
        "joints: {O: [0, 0]}\nsliders: {block: {joint: B, through: O, mass: 0.4}}\n"
        "free: {block: {position: 0.5, speed: 0}}\n"
        f"springs: [{{between: [O, B], stiffness: 90, length: 0.3, damping: {damping}}}]\n"
    )
    data = linkages.simulate(found, end=2.0, samples=401, rtol=1e-12, outputs="all").data
    decay = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    time = data.time.to_numpy()
    exact = 0.3 + 0.2 * np.exp(-decay * time) * (
        np.cos(omega * time) + decay / omega * np.sin(omega * time)
    )
    assert data.slider_position.to_numpy()[:, 0] == pytest.approx(exact, abs=1e-10)
    velocity = data.slider_velocity.to_numpy()[:, 0]
    assert data.load_power.to_numpy() == pytest.approx(-damping * velocity**2, abs=1e-12)
    assert float(np.abs(data.energy_residual).max()) < 1e-10


DAMPERS = {
    "between": "{between: [O2, B], damping: 3}",
    "joint": "{joint: A, damping: 0.02}",
    "ground joint": "{joint: O4, damping: 0.02}",
    "bars": "{bars: [ground, coupler], damping: 0.03}",
    "joint and bars": "{joint: B, bars: [coupler, rocker], damping: 0.02}",
}


@pytest.mark.slow_except("joint", "ground joint")
@pytest.mark.parametrize("damper", DAMPERS.values(), ids=DAMPERS)
def test_every_damper_takes_what_the_motion_loses(damper):
    text = FREE_FOUR_BAR + f"free: {{crank: {{angle: 0.7, speed: 30}}}}\ndampers: [{damper}]\n"
    spacing = 5e-4
    data = linkages.simulate(mechanism(text), end=0.5, samples=1001, rtol=1e-12, outputs="all").data
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert energy[-1] < energy[0] - 1e-3
    assert (np.diff(energy) < 1e-12).all()
    assert balanced(data, spacing)
    assert float(np.abs(data.energy_residual).max()) < 1e-9


def test_driven_against_springs_and_dampers():
    text = FOUR_BAR + (
        "springs:\n  - {between: [O2, B], stiffness: 300, length: 0.1, damping: 2}\n"
        "  - {bar: rocker, stiffness: 2, angle: 1}\n"
        "  - {between_bars: [crank, coupler], stiffness: 0.5, angle: 0, damping: 0.01}\n"
    )
    data = linkages.simulate(mechanism(text), end=3.0, samples=3001, outputs="all").data
    assert balanced(data, 1e-3)
    # of 80 J in springs
    assert float(np.abs(data.energy_residual).max()) < 1e-9
    # the crank turns against the coupler: 2.9 turns are wound up
    assert float(data.potential_energy[-1]) > 0.5 * 0.5 * 15**2


# -- reactions -------------------------------------------------------------------------------


def test_hanging_chain():
    """Eight links between two pins, at rest: moments about every joint, Newton's polygon.

    The horizontal tension is the same everywhere, the vertical one falls by the weight of a link.
    """
    count, length, mass = 8, 0.1, 0.3
    # a chain in equilibrium: tan of the angle of link i from the vertical tension at its middle
    horizontal = 6.0
    vertical = mass * 9.81 * (np.arange(count) - (count - 1) / 2)
    slopes = np.arctan2(vertical, horizontal)
    steps = length * np.stack([np.cos(slopes), np.sin(slopes)], axis=1)
    places = np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])
    names = [f"J{i}" for i in range(count + 1)]
    bars = "".join(
        f"  link{i}: {{joints: [J{i}, J{i + 1}], length: {length}, mass: {mass}}}\n"
        for i in range(count)
    )
    free = ", ".join(
        f"link{i}: {{angle: {float(slopes[i])!r}, speed: 0}}" for i in range(count - 2)
    )
    hints = ", ".join(f"{n}: {p.tolist()}" for n, p in zip(names[1:-1], places[1:-1], strict=True))
    found = mechanism(
        f"gravity: [0, -9.81]\njoints: {{J0: [0, 0], J{count}: {places[-1].tolist()}}}\n"
        f"bars:\n{bars}free: {{{free}}}\nassembly: {{{hints}}}\n"
    )
    data = linkages.simulate(found, end=1e-3, samples=2, outputs="all").data
    assert float(np.abs(data.bar_acceleration[0]).max()) < 1e-9
    tension = horizontal, mass * 9.81 * (np.arange(count + 1) - count / 2)
    for i, name in enumerate(names):
        reaction = data.joint_reaction.sel(joint=name)[0].to_numpy()
        # what the first body exerts: the ground at both ends, the link before elsewhere
        sign = 1.0 if i == count else -1.0
        assert reaction == pytest.approx([sign * tension[0], sign * tension[1][i]], abs=1e-9)


def test_bodies_of_a_mechanism_with_springs_obey_newton():
    """A crank moves a block along an arm; a spring and a point mass hang at the arm's end."""
    text = """\
gravity: [0, -9.81]
joints: {O: [0, 0.3], C: [0, 0], S: [0.4, 0.5]}
bars:
  crank: {joints: [O, A], length: 0.12, mass: 0.4}
  arm: {joints: [C, P], length: 0.8, mass: 0.7}
  rod: {joints: [P, Q], length: 0.2, mass: 0.5}
sliders: {block: {joint: A, on: arm, through: C, mass: 0.2}}
masses: {P: 0.6}
springs: [{between: [S, P], stiffness: 40, length: 0.1, damping: 1}]
drives: {crank: {angle: 0.3, speed: 4}}
free: {rod: {angle: -90 deg, speed: 0}}
loads: [{joint: Q, force: [3, 0]}]
assembly: {A: [0.11, 0.33], P: [0.25, 0.76]}
"""
    spacing = 1e-3
    data = linkages.simulate(mechanism(text), end=1.5, samples=1501, rtol=1e-13, outputs="all").data
    inner = slice(4, -4)

    def place(joint):
        return data.joint_position.sel(joint=joint).to_numpy()

    def reaction(joint):
        return data.joint_reaction.sel(joint=joint).to_numpy()[inner]

    weight = np.array([0, -9.81])
    # the rod: pushed by the arm at P, by the load at Q; the mass at P belongs to the arm
    acceleration = derivative(0.5 * (place("P") + place("Q")), spacing, 2)
    force = reaction("P") + 0.5 * weight + np.array([3.0, 0.0])
    # Second differences of order 8 at 1 ms: 1e-16/1e-6; dense output joins to 1e-12
    assert force == pytest.approx(0.5 * acceleration, abs=1e-4)
    moment_arm = (place("P") - place("Q"))[inner] / 2
    other = -moment_arm
    spin = derivative(data.bar_angle.sel(bar="rod").to_numpy(), spacing, 2)
    push = reaction("P")
    moment = moment_arm[:, 0] * push[:, 1] - moment_arm[:, 1] * push[:, 0] - other[:, 1] * 3.0
    assert moment == pytest.approx(0.5 * 0.2**2 / 12 * spin, abs=1e-4)
    # all together: ground at O and C, spring at S
    total = sum(
        mass * derivative(where, spacing, 2)
        for mass, where in (
            (0.4, 0.5 * (place("O") + place("A"))),
            (0.7, 0.5 * (place("C") + place("P"))),
            (0.5, 0.5 * (place("P") + place("Q"))),
            (0.2, place("A")),
            (0.6, place("P")),
        )
    )
    gap = place("P") - place("S")
    length = np.hypot(*gap.T)
    rate = derivative(length, spacing)[:, None]
    unit = (gap / length[:, None])[inner]
    pull = -(40 * (length[inner, None] - 0.1) + rate) * unit
    outside = reaction("O") + reaction("C") + pull + 2.4 * weight + np.array([3.0, 0.0])
    assert outside == pytest.approx(total, abs=2e-4)
    assert float(np.abs(data.energy_residual).max()) < 1e-9
