"""Followers that leave their cams, against closed forms, ideal cams, walls and SciPy."""

import math
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq, minimize_scalar
from tangent_differences import check

import linkages

G, MASS, STIFFNESS, RELAXED, OFFSET, HEIGHT = 9.81, 0.5, 3000.0, 0.03, 0.05, 0.01
RIGID = "contact: restitution, restitution: 0.5"
ELASTIC = "contact: hunt-crossley-constant, stiffness: 1e8 N/m^1.5, dissipation: 0.3 s/m"
SIZED = "base_radius: 0.03"


def harmonic(angle):
    """Lift and two derivatives."""
    return (HEIGHT * (1 - np.cos(angle)), HEIGHT * np.sin(angle), HEIGHT * np.cos(angle))


def cycloidal(angle):
    """A rise of 2·HEIGHT over half a turn, and the return."""
    u = np.mod(angle, 2 * np.pi) / np.pi
    sign = np.where(u > 1, -1.0, 1.0)
    share = np.where(u > 1, 2 - u, u)
    lift = share - np.sin(2 * np.pi * share) / (2 * np.pi)
    slope = sign * (1 - np.cos(2 * np.pi * share)) / np.pi
    bend = 2 * np.sin(2 * np.pi * share) / np.pi
    return tuple(2 * HEIGHT * np.asarray(value) for value in (lift, slope, bend))


def table(lift, count=721):
    angles = np.linspace(0.0, 2 * np.pi, count)
    lifts = lift(angles)[0]
    lifts[-1] = lifts[0]
    return angles, lifts


def valve(
    law=RIGID, *, lift=harmonic, count=721, cam=SIZED, speed=60.0, start=0.0, known="driven",
    at=None, moving=None, spring=STIFFNESS, more="", gravity=G,
):  # fmt: skip
    """A valve under a spring on a cam; without a `law` it never leaves it."""
    angles, lifts = (", ".join(f"{v:.17g}" for v in values) for values in table(lift, count))
    law = f", {law}" if law else ""
    spline = CubicSpline(*table(lift, count), bc_type="periodic")
    at = OFFSET + float(spline(start)) if at is None else at
    moving = speed * float(spline(start, 1)) if moving is None else moving
    free = {"valve": f"{{position: {at!r}, speed: {moving!r}}}"} if law else {}
    turning = f"{{angle: {start!r}, speed: {speed!r}}}"
    drives = f"drives: {{cam: {turning}}}" if known == "driven" else ""
    if not drives:
        free["cam"] = turning
    entries = ", ".join(f"{name}: {state}" for name, state in free.items())
    return f"""
gravity: [0, {-gravity!r}]
joints: {{O: [0, 0]}}
bars: {{cam: {{points: {{O: [0, 0], P: [0.02, 0]}}, mass: 1, center: [0, 0], inertia: 0.01}}}}
sliders: {{valve: {{joint: V, through: O, angle: 90 deg, mass: {MASS}}}}}
cams:
  - {{slider: valve, bar: cam, angles: [{angles}], lifts: [{lifts}], offset: {OFFSET}, {cam}{law}}}
springs: [{{slider: valve, stiffness: {spring!r}, position: {RELAXED}}}]
{drives}
{f"free: {{{entries}}}" if entries else ""}
{more}
"""


def pressing(angle, speed, lift=harmonic):
    """Force along the guide that keeps the valve on the cam, a positive one presses."""
    place, _, bend = lift(angle)
    return MASS * (bend * speed**2 + G) + STIFFNESS * (OFFSET + place - RELAXED)


CRITICAL = math.sqrt((MASS * G + STIFFNESS * (OFFSET - RELAXED + 2 * HEIGHT)) / (MASS * HEIGHT))


def critical(lift):
    """The lowest speed at which a cam throws the valve off."""

    def square(angle):
        place, _, bend = lift(angle)
        return -(MASS * G + STIFFNESS * (OFFSET - RELAXED + place)) / (MASS * bend)

    return math.sqrt(minimize_scalar(square, (1.7, 2.4), options={"xtol": 1e-12}).fun)


@pytest.mark.slow
@pytest.mark.parametrize("lift", [harmonic, cycloidal])
def test_speed_of_the_first_lift_off(lift):
    """N = m (s″ω² + g) + k (x − x₀); the spline's s″ errs by 1/12 of the square of the spacing."""
    bound = CRITICAL if lift is harmonic else critical(lift)
    kept, thrown = (
        linkages.simulate(
            linkages.loads(valve(lift=lift, speed=share * bound, count=2881)),
            end=0.05,
            samples=11,
        )
        for share in (1 - 1e-5, 1 + 1e-5)
    )
    assert kept.notes == ("contact cams[0]: contact throughout",)
    assert not len(kept.motion.changes["cams[0]: press"].time)
    assert len(thrown.motion.changes["cams[0]: press"].time)


def test_it_is_said_how_much_of_the_time_a_follower_flies():
    mechanism = linkages.loads(valve(speed=1.2 * CRITICAL, count=73))
    found = linkages.simulate(mechanism, end=0.5, samples=5001, outputs=["clearance_indentation"])
    (note,) = (text for text in found.notes if "touches at" in text)
    share = 100 * float(np.mean(found.data.clearance_indentation < -1e-8))
    assert float(re.search(r"(\d+)% free", note)[1]) == pytest.approx(share, abs=1.0)


@pytest.mark.slow_except("cycloidal")
@pytest.mark.parametrize("lift", [harmonic, cycloidal])
def test_place_of_lift_off_flight_and_landing(lift):
    """It leaves where N = 0, swings about −g m/k + x₀, and lands where it meets the cam again."""
    speed = 1.3 * critical(lift) if lift is cycloidal else 1.3 * CRITICAL
    text = valve(RIGID.replace("0.5", "0"), lift=lift, speed=speed, count=2881)
    changes = linkages.simulate(linkages.loads(text), end=0.05, samples=11).motion.changes
    presses, touches = changes["cams[0]: press"], changes["cams[0]: touch"]
    begin = 1.7 if lift is cycloidal else 1.0
    angle = brentq(lambda a: pressing(a, speed, lift), begin, 2.4 if lift is cycloidal else 3.0)
    assert speed * presses.time[0] == pytest.approx(angle, rel=2e-6)
    place, slope, _ = lift(angle)
    rate, rest = math.sqrt(STIFFNESS / MASS), RELAXED - MASS * G / STIFFNESS
    leaves = angle / speed

    def apart(time):
        away = OFFSET + place - rest
        turned = rate * (time - leaves)
        flown = rest + away * math.cos(turned) + speed * slope / rate * math.sin(turned)
        return flown - OFFSET - lift(speed * time)[0]

    lands = brentq(apart, leaves + 0.3 / speed, leaves + 5.5 / speed, xtol=1e-15)
    rises = touches.time[touches.rises]
    # a late lift-off shows to second order: N falls from 0
    assert rises[rises > leaves][0] == pytest.approx(lands, rel=1e-8)


@pytest.mark.slow
def test_a_valve_without_spring_flies_in_a_parabola():
    """It leaves where s″ω² = −g, and an impact throws it back with e times the closing speed."""
    speed = 60.0
    text = valve(spring=0.0, speed=speed, start=1.0, count=2881)
    found = linkages.simulate(
        linkages.loads(text), end=0.15, outputs=["slider_velocity"], samples=1001
    )
    changes = found.motion.changes
    leaves, touch = changes["cams[0]: press"].time[0], changes["cams[0]: touch"]
    angle = math.acos(-G / (HEIGHT * speed**2))
    assert 1.0 + speed * leaves == pytest.approx(angle, rel=2e-6)
    place, slope, _ = harmonic(angle)

    def flown(time):
        return OFFSET + place + speed * slope * time - 0.5 * G * time**2

    def apart(time):
        return flown(time) - OFFSET - harmonic(angle + speed * time)[0]

    later = np.linspace(0.02, 1.0, 4000)
    first = later[np.flatnonzero([apart(t) < 0 for t in later])[0]]
    lands = brentq(apart, first - 0.01, first, xtol=1e-15)
    hit = touch.time[touch.rises]
    # a late lift-off shows to second order: both fall with g there
    assert hit[hit > leaves][0] == pytest.approx((angle - 1.0) / speed + lands, rel=1e-8)
    falling = speed * slope - G * lands
    rising = speed * harmonic(angle + speed * lands)[1]
    behind = rising + 0.5 * (rising - falling)
    at = float(hit[hit > leaves][0])
    data = found.data
    after = (data.time > at + 1e-6) & (data.time < at + 2e-3)
    speeds, times = data.slider_velocity.values[:, 0][after], data.time.values[after]
    assert speeds == pytest.approx(behind - G * (times - at), rel=1e-7)


SHAPES = {
    "without a size": "roller_radius: 0",
    "knife edge": "base_radius: 0.03",
    "roller": "base_radius: 0.03, roller_radius: 0.01, eccentricity: 4 mm",
    "flat": "base_radius: 0.03, flat: true",
}
RESULTS = ("slider_position", "slider_velocity", "slider_acceleration", "bar_angle",
           "joint_reaction", "guide_reaction", "guide_moment", "kinetic_energy")  # fmt: skip


@pytest.mark.parametrize("known", ["driven", "free"])
@pytest.mark.parametrize("shape", SHAPES)
def test_without_lift_off_it_is_the_ideal_cam(shape, known):
    """A closed contact settles where steps leave it, as they do at the corners of s″."""
    how = {"cam": SHAPES[shape], "known": known, "start": 0.4, "count": 25}
    ideal, rigid = (
        linkages.simulate(
            linkages.loads(valve(law, **how)), end=0.25, samples=101, outputs="all", rtol=1e-13
        ).data
        for law in ("", RIGID)
    )
    sized = "pressure_angle" in ideal
    assert sized == (shape in ("knife edge", "roller"))
    names = [*RESULTS, *(["drive_effort"] if known == "driven" else [])]
    limit = 1e-9 if known == "driven" else 1e-8  # of the acceleration of two bodies
    for name in [*names, *(["pressure_angle"] if sized else [])]:
        scale = max(1.0, float(np.abs(ideal[name]).max()))
        assert np.asarray(rigid[name]) == pytest.approx(np.asarray(ideal[name]), abs=limit * scale)
    force = MASS * (rigid.slider_acceleration + G) + STIFFNESS * (rigid.slider_position - RELAXED)
    assert np.asarray(rigid.clearance_force)[:, 0] == pytest.approx(np.asarray(force)[:, 0])


@pytest.mark.slow_except("roller-ideal", "flat-contact")
@pytest.mark.parametrize("law", ["", RIGID], ids=["ideal", "contact"])
@pytest.mark.parametrize("shape", SHAPES)
def test_forces_on_pivot_and_guide(shape, law):
    """Newton's and Euler's laws of cam and valve, with the point of contact in the plane."""
    text = valve(law, cam=SHAPES[shape], start=0.4)
    data = linkages.simulate(linkages.loads(text), end=0.1, samples=21, outputs="all").data
    angle = data.bar_angle.values[:, 0]
    lift, slope, _ = harmonic(angle)
    position, pull = data.slider_position.values[:, 0], data.slider_acceleration.values[:, 0]
    along = MASS * (pull + G) + STIFFNESS * (position - RELAXED)
    zero = np.zeros_like(along)
    if shape == "flat":
        point, aside = np.stack([slope, 0.03 + lift], axis=1), zero
    elif shape == "without a size":
        point, aside = np.stack([zero, position], axis=1), zero
    else:
        away, radius = (0.004, 0.04) if shape == "roller" else (0.0, 0.03)
        height = math.sqrt(radius**2 - away**2) + lift
        point, aside = np.stack([zero, height], axis=1), -along * (slope - away) / height
    force = np.stack([aside, along], axis=1)  # of the cam on the valve
    # of the ground on the cam: what the valve pushes it with, and its weight
    expected = force + np.array([0.0, G])
    limit = 1e-6 * np.abs(along).max()  # of a spline's slope
    assert data.joint_reaction.sel(joint="O").values == pytest.approx(expected, abs=limit)
    # across the guide, to its left
    assert data.guide_reaction.values[:, 0] == pytest.approx(aside, abs=limit)
    arm = point - np.stack([zero, position], axis=1)
    moment = arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
    assert data.guide_moment.values[:, 0] == pytest.approx(-moment, abs=limit)
    effort = data.drive_effort.values[:, 0]
    assert effort == pytest.approx(along * slope, abs=limit)


@pytest.mark.slow_except("guide-contact", "pivot-ideal")
@pytest.mark.parametrize("law", ["", ELASTIC], ids=["ideal", "contact"])
@pytest.mark.parametrize("place", ["pivot", "guide"])
def test_friction_in_bearings_of_cam_and_valve(place, law):
    """It follows N/cos φ at the pivot, less the weight of the cam, and N tan φ in the guide."""
    rubs = {
        "pivot": "{joint: O, coefficient: 0.1, radius: 0.01, slip_speed: 1e-9}",
        "guide": "{slider: valve, coefficient: 0.2, slip_speed: 1e-5}",
    }
    text = valve(
        law, cam="base_radius: 0.03, roller_radius: 0.01", speed=30.0, start=0.4,
        more=f"friction: [{rubs[place]}]",
    )  # fmt: skip
    data = linkages.simulate(linkages.loads(text), end=0.2, samples=201, outputs="all").data
    slope, moving = harmonic(data.bar_angle.values[:, 0])[1], data.slider_velocity.values[:, 0]
    pull, position = data.slider_acceleration.values[:, 0], data.slider_position.values[:, 0]
    force = MASS * (pull + G) + STIFFNESS * (position - RELAXED)
    leaning = np.tan(data.pressure_angle.values[:, 0])
    lost = 0.0
    if place == "pivot":
        lost = 0.1 * 0.01 * np.hypot(force * leaning, force + G)
    else:
        force = force / (1 - 0.2 * np.abs(leaning) * np.tanh(moving / 1e-5))
    expected = force * slope + lost
    limit = 1e-6 * np.abs(expected).max()
    assert data.drive_effort.values[:, 0] == pytest.approx(expected, abs=limit)


CASES = {
    "rigid": RIGID,
    "elastic": f"{ELASTIC}, size: 1 mm",
    "rigid, rubs": f"{RIGID}, friction: 0.3",
    "elastic, rubs": f"{ELASTIC}, friction: 0.3, slip: 0.1",
}


@pytest.mark.slow_except("rigid, rubs-free", "elastic-driven")
@pytest.mark.parametrize("known", ["driven", "free"])
@pytest.mark.parametrize("law", CASES.values(), ids=CASES)
def test_a_flat_face_on_an_eccentric_circle_is_a_wall_on_a_round(law, known):
    """The lift is e sin θ; a spline with 2000 knots errs by e h⁴/384, its impacts by more."""
    away, radius, speed, start, end = 8e-3, 20e-3, 130.0, -1.5, 0.12
    angles = np.linspace(0.0, 2 * np.pi, 2001)
    lifts = away * np.sin(angles)
    lifts[-1] = lifts[0]
    states = {"cam": f"{{angle: {start}, speed: {speed}}}"}
    sections = {"drives": dict(states), "free": {}} if known == "driven" else {"free": states}
    sections["free"]["valve"] = "{position: 0.013, speed: 0}"
    begin = "\n".join(
        f"{name}: {{{', '.join(f'{k}: {v}' for k, v in own.items())}}}"
        for name, own in sections.items()
    )
    base = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0], T: [0, 0.12]}}
bars: {{cam: {{points: {{O: [0, 0], E: [{away}, 0]}}, mass: 1, center: [0, 0], inertia: 1e-3}}}}
sliders: {{valve: {{joint: V, through: O, angle: 90 deg, mass: 0.2}}}}
springs: [{{between: [V, T], stiffness: 500, length: 0.13}}]
{begin}
"""
    profile = f"angles: {angles.tolist()}, lifts: {lifts.tolist()}"
    cam = f"cams: [{{slider: valve, bar: cam, {profile}, base_radius: {radius}, flat: true"
    wall = f"wall: valve, through: V, angle: 90 deg, radius: {radius}"
    texts = (
        f"{base}{cam}, offset: {radius}, {law}}}]",
        f"{base}contacts: {{face: {{body: cam, points: [E], {wall}, {law}}}}}",
    )
    moved = ["slider_position", "bar_angle", "clearance_normal_dissipation",
             "clearance_friction_dissipation", "kinetic_energy"]  # fmt: skip
    forces = ["clearance_force", "joint_reaction", "guide_reaction"]
    forces += ["drive_effort"] if known == "driven" else []
    one, other = (
        linkages.simulate(
            linkages.loads(t), end=end, samples=61, outputs=[*moved, *forces], rtol=1e-12
        )
        for t in texts
    )
    changes = [m.motion.changes[f"{n}: touch"] for m, n in ((one, "cams[0]"), (other, "face"))]
    touches = [change.time[change.rises] for change in changes]
    assert len(touches[0]) >= 4
    assert touches[0] == pytest.approx(touches[1], abs=1e-8)
    for name in moved:
        scale = max(1.0, float(np.abs(other.data[name]).max()))
        pair = (np.asarray(found.data[name]) for found in (one, other))
        assert next(pair) == pytest.approx(next(pair), abs=1e-8 * scale)
    # forces follow the second derivative of the spline, which errs by its spacing
    for name in forces:
        pair = [found.data[name] for found in (one, other)]
        if "joint" in pair[0].dims:
            pair = [values.sel(joint="O") for values in pair]
        scale = float(np.abs(pair[1]).max())
        assert np.asarray(pair[0]) == pytest.approx(np.asarray(pair[1]), abs=1e-5 * scale + 1e-9)


def test_energy_of_an_elastic_impact():
    """A free cam and its valve keep their energy, whatever is exchanged in impacts."""
    text = valve(
        RIGID.replace("0.5", "1"), known="free", speed=1.5 * CRITICAL, count=181, moving=0.0
    )
    found = linkages.simulate(linkages.loads(text), end=0.3, samples=601, outputs="all", rtol=1e-11)
    data = found.data
    assert len(found.motion.changes["cams[0]: touch"].time) > 6
    total = data.kinetic_energy + data.potential_energy
    assert np.ptp(data.bar_speed.values) > 1.0
    assert np.asarray(total) == pytest.approx(float(total[0]), rel=1e-8)
    assert np.abs(data.energy_residual.values).max() < 1e-6


@pytest.mark.slow_except("0.3")
@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_against_an_independent_integration(friction):
    """Newton's and Euler's equations with SciPy's spline, through lift-off and landing."""
    speed, end, inertia = 1.4 * CRITICAL, 0.12, 0.01
    spline = CubicSpline(*table(harmonic, 361), bc_type="periodic")

    def rates(_, y):
        place, angle, moving, turning = y
        depth = OFFSET + float(spline(angle)) - place
        slope, force, torque = float(spline(angle, 1)), 0.0, 0.0
        if depth > 0.0:
            closing = slope * turning - moving
            force = max(1e8 * depth**1.5 * (1 + 0.3 * closing), 0.0)
            height = 0.03 + float(spline(angle))
            torque = -friction * math.tanh(turning * height / 0.05) * force * height
        pull = force - STIFFNESS * (place - RELAXED) - MASS * G
        return [moving, turning, pull / MASS, (torque - slope * force) / inertia]

    start = [OFFSET, 0.0, 0.0, speed]
    how = {"rtol": 1e-13, "atol": 1e-15, "max_step": 1e-4}
    expected = solve_ivp(rates, (0, end), start, "DOP853", **how).y[:, -1]
    rubs = f", friction: {friction}, slip: 0.05" if friction else ""
    text = valve(ELASTIC + rubs, cam=SHAPES["flat"], known="free", count=361, speed=speed)
    found = linkages.simulate(linkages.loads(text), end=end, rtol=1e-12, outputs="all")
    assert len(found.motion.changes["cams[0]: touch"].time) > 4
    data = found.data.isel(time=-1)
    names = ("slider_position", "bar_angle", "slider_velocity", "bar_speed")
    state = [float(data[name][0]) for name in names]
    state[1] += 2 * math.pi * round((expected[1] - state[1]) / (2 * math.pi))
    assert state == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("law", [RIGID, ELASTIC], ids=["rigid", "elastic"])
@pytest.mark.parametrize("known", ["driven", "free"])
def test_tangents(law, known):
    """Few knots: differences are taken of motions that cross them."""
    text = valve(law, known=known, speed=1.3 * CRITICAL, count=25, at=OFFSET + 2e-3, moving=0.0)
    check(text, 0.03, 1e-3)


def test_sensitivities_against_differences():
    paths = ["cams[0].lifts[12]", "cams[0].offset", "springs[0].stiffness"]
    text = valve(speed=1.3 * CRITICAL, count=25, at=OFFSET + 2e-3, moving=0.0)
    mechanism = linkages.loads(text)
    measure = "at(0.05, valve.position)"
    found = linkages.sensitivities(mechanism, measure, paths, end=0.06, rtol=1e-12)
    assert found[measure].max() > 0.01
    for path, slope in zip(paths, found[measure].values.tolist(), strict=True):
        value = float(found.parameter_value.sel(parameter=path))
        step = 1e-6 * value
        ends = [
            float(
                linkages.simulate(
                    mechanism.with_values({path: value + sign * step}),
                    times=[0.0, 0.05],
                    rtol=1e-12,
                ).data.slider_position[-1, 0]
            )
            for sign in (1, -1)
        ]
        assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-5)


def test_batches_have_the_bits_of_single_motions():
    text = valve(speed=1.3 * CRITICAL, count=25)
    path, values = "cams[0].restitution", np.linspace(0.2, 0.8, 12).tolist()
    swept = linkages.sweep(
        linkages.loads(text), {path: values}, measure=["at(0.05, valve.position)"], end=0.05
    )
    for found, value in zip(swept["at(0.05, valve.position)"], values, strict=True):
        single = text.replace("restitution: 0.5", f"restitution: {value!r}")
        data = linkages.simulate(linkages.loads(single), times=[0.0, 0.05]).data
        assert float(found) == float(data.slider_position[-1, 0])


@pytest.mark.parametrize("count", [3, 16], ids=["one by one", "together"])
def test_starts_within_the_cam_are_refused_at_points_of_sweeps(count):
    places = np.linspace(0.04, 0.06, count)
    found = linkages.sweep(
        linkages.loads(valve(count=25)), {"free.valve.position": places.tolist()},
        measure=["max(valve.position)"], end=0.02,
    )  # fmt: skip
    refused = np.array(["within the cam" in reason for reason in found["reason"].values])
    assert (refused == (places < OFFSET)).all()


WRONG = {
    "contact: restitution": "missing key 'restitution'",
    "contact: hertz": "missing key 'stiffness'",
    "contact: lubricated, viscosity: 1": "unknown key 'viscosity'",
    f"{RIGID}, friction: 0.2": "a roller or knife edge has none here",
    f"{RIGID}, flat: true, roller_radius: 1 mm": "a flat face has none",
    "contact: hertz, stiffness: 1e9 N/m^1.5, restitution: 0.5": "hertz has no 'restitution'",
    f"{RIGID.replace('0.5', '1.5')}": "at most 1, found 1.5",
    "contact: flores, stiffness: 1e9 N/m^1.5, restitution: 0": "expected a restitution > 0",
    "contact: none": "none",
    "restitution: 0.5": "expected 'contact' as well",
    "friction: 0.5": "expected 'contact' as well",
}


@pytest.mark.parametrize("entry", WRONG)
def test_wrong_entries(entry):
    with pytest.raises(linkages.InputError) as error:
        linkages.loads(valve(entry, count=25))
    assert WRONG[entry] in str(error.value)
    assert "cams[0]" in str(error.value)


def test_faces_that_slip_or_meet_hollows():
    with pytest.raises(linkages.InputError, match="speed of slip depends on it"):
        linkages.loads(valve(f"{RIGID}, friction: 0.1", cam="flat: true", count=25))
    # s + s″ = −2 h at the top of a harmonic lift twice as fast
    text = valve(cam="flat: true, base_radius: 4 mm", lift=lambda a: (harmonic(2 * a)[0], 0, 0))
    with pytest.raises(linkages.InputError, match=r"more than 0\.02 m: at 90° a flat face"):
        linkages.loads(text)


def test_what_a_cam_that_is_left_needs():
    text = valve(count=25)
    moved = "clearances: {c: {joint: O, bar: cam, size: 1 mm}}"
    with pytest.raises(linkages.InputError, match="clearance 'c' gives it room"):
        linkages.loads(text + moved)
    loose = "clearances: {g: {slider: valve, size: 1 mm, length: 0.05, height: 0.02, "
    loose += "contact: kelvin-voigt, stiffness: 1e6, damping: 10}}"
    with pytest.raises(linkages.InputError, match="clearance 'g' gives it room"):
        linkages.loads(text + loose)
    entry = re.search(r"  - {slider: valve, bar.*", text)[0]
    for second in (entry, entry.replace(f", {RIGID}", "")):
        with pytest.raises(linkages.InputError, match=r"lifts 'valve' already|is free"):
            linkages.loads(text.replace(entry, f"{entry}\n{second}"))
    arm = text.replace("bars: {", "bars: {arm: {joints: [O, P], length: 0.02}, ")
    arm = arm.replace(
        "cam: {points: {O: [0, 0], P: [0.02, 0]}", "cam: {points: {P: [0, 0], Q: [1, 0]}"
    )
    with pytest.raises(linkages.InputError, match="fixed pivots only"):
        linkages.loads(arm)
    with pytest.raises(linkages.InputError, match="valve"):  # nothing says where it is
        linkages.simulate(linkages.loads(re.sub("free: .*", "masses: {V: 1}", text)))


def test_a_start_within_the_cam():
    with pytest.raises(linkages.InputError, match=r"starts 0\.001 m within the cam"):
        linkages.simulate(linkages.loads(valve(count=25, at=OFFSET - 1e-3)), end=0.1)


def test_an_orbit_is_what_the_motion_settles_on():
    mechanism = linkages.loads(valve(RIGID.replace("0.5", "0.3"), speed=1.25 * CRITICAL, count=25))
    orbit = linkages.orbit(mechanism)
    assert orbit.attrs["stable"] == 1
    # the closed contact takes all deviations away
    assert np.abs(orbit.multiplier.values).max() < 1e-6
    period = 2 * math.pi / (1.25 * CRITICAL)
    assert orbit.attrs["period"] == pytest.approx(period, rel=1e-12)
    data = linkages.simulate(mechanism, times=[0.0, 30 * period]).data.isel(time=-1)
    settled = [float(data[name][0]) for name in ("slider_position", "slider_velocity")]
    assert orbit.state.values == pytest.approx(settled, abs=1e-7)


def test_exponents_of_an_elastic_contact():
    """Their sum is the mean divergence, −K dⁿ D/m where the force is K dⁿ (1 + D d′)."""
    mechanism = linkages.loads(valve(ELASTIC, speed=1.6 * CRITICAL, count=25))
    found = linkages.lyapunov(mechanism, periods=40, skip=5)
    period = 2 * math.pi / (1.6 * CRITICAL)
    times = np.linspace(5 * period, 45 * period, 200_001)
    data = linkages.simulate(
        mechanism, times=np.concatenate([[0.0], times]), outputs=["clearance_indentation"]
    ).data
    depth = np.maximum(data.clearance_indentation.values[1:, 0], 0.0)
    expected = -1e8 * 0.3 * float(np.mean(depth**1.5)) / MASS
    assert float(found.exponent.sum()) == pytest.approx(expected, rel=1e-3)
