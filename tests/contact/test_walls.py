"""Points and rounds at straight and circular walls, against closed forms and other integrations."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tangent_differences import check

import linkages

G = 9.81
RIGID = "contact: restitution, restitution: 0.5"
ELASTIC = "contact: hunt-crossley-constant, stiffness: 1e6 N/m^1.5, dissipation: 0.5 s/m"
RUBS = "friction: 0.3, slip: 0.1"


def floating(
    contacts, *, at=(0.0, 0.5, 0.0), moving=(0.0, 0.0, 0.0), gravity=-G, guides="", more="", free=""
):
    """A body of 2 kg that nothing holds: its centre C is 0.1 m from A, and 0.3 m from B."""
    (x, y, angle), (vx, vy, spin) = at, moving
    return f"""
gravity: [0, {gravity}]
joints: {{O: [0, 0]}}
sliders:
  x: {{joint: X, through: O, angle: 0}}
  y: {{joint: C, on: x, through: [0, 0], angle: 90 deg}}{guides}
bars:
  body: {{points: {{C: [0, 0], A: [-0.1, 0], B: [0.3, 0]}}, mass: 2, inertia: 0.01, center: [0, 0]}}
{more}
free:
  x: {{position: {x!r}, speed: {vx!r}}}
  y: {{position: {y!r}, speed: {vy!r}}}
  body: {{angle: {angle!r}, speed: {spin!r}}}{free}
contacts:
  {contacts}
"""


def moved(text, end, **how):
    """The motion, and its state at the end as x, y and θ, then their rates."""
    found = linkages.simulate(linkages.loads(text), end=end, **how)
    data = found.data.isel(time=-1)
    places = [float(data["slider_position"].sel(slider=s)) for s in ("x", "y")]
    rates = [float(data["slider_velocity"].sel(slider=s)) for s in ("x", "y")]
    turned = [float(data[name].sel(bar="body")) for name in ("bar_angle", "bar_speed")]
    return found, np.array([*places, turned[0], *rates, turned[1]])


def test_a_ball_bounces_and_comes_to_rest():
    """Touches at t₀ + 2 v₀/g·(e + e² + …), until they bounce with less than 1 mm/s."""
    floor = f"floor: {{body: body, points: [C], radius: 0.02, through: O, angle: 0, {RIGID}}}"
    found, end = moved(floating(floor), 3.0)
    times = found.motion.changes["floor: touch"].time
    fall, speed = math.sqrt(2 * 0.48 / G), math.sqrt(2 * 0.48 * G)
    count = math.ceil(math.log(1e-3 / speed, 0.5))
    flights = 2 * speed / G * 0.5 ** np.arange(1, count)
    assert times == pytest.approx(fall + np.cumsum([0.0, *flights]), abs=1e-10)
    assert end == pytest.approx([0, 0.02, 0, 0, 0, 0], abs=1e-11)
    force = found.data["clearance_force"].sel(clearance="floor").isel(time=-1)
    assert float(force) == pytest.approx(2 * G, rel=1e-9)
    assert "clearance_force" in found.data
    assert "slider_position_error" not in found.data  # no joint has clearance
    assert not any("did you mean" in note for note in found.notes)


@pytest.mark.parametrize("side", ["ground", "plate"])
@pytest.mark.parametrize("friction", [0.05, 0.4])
def test_a_disc_rolls_or_slides_down_a_slope(friction, side):
    """a = g sin α/(1 + J/(m r²)), or g (sin α − μ cos α) with the spin μ m g cos α r/J."""
    slope, radius, end = math.radians(-30), 0.05, 0.8
    start = -radius * math.sin(slope), radius * math.cos(slope)
    turned, more = 0.0, ""
    if side == "plate":  # a plate that is turned by 0.3 and stands still
        turned = 0.3
        more = "  plate: {points: {O: [0.2, 0.1], Q: [0, 0]}}\ndrives: {plate: {law: 0.3}}"
    wall = f"wall: {side}, through: O, angle: {slope - turned!r}"
    law = f"{RIGID}, friction: {friction}"
    slider = f"slope: {{body: body, points: [C], radius: {radius}, {wall}, {law}}}"
    _, state = moved(floating(slider, at=(*start, 0.0), more=more), end)
    normal, ratio = 2 * G * math.cos(slope), 0.01 / (2 * radius**2)
    if friction > math.tan(-slope) * ratio / (1 + ratio):
        pace = -G * math.sin(slope) / (1 + ratio)
        spin = -pace / radius
    else:
        pace = -G * math.sin(slope) - friction * normal / 2
        spin = -friction * normal * radius / 0.01
    way = np.array([math.cos(slope), math.sin(slope)])
    expected = [*(start + 0.5 * pace * end**2 * way), 0.5 * spin * end**2, *(pace * end * way)]
    assert state == pytest.approx([*expected, spin * end], abs=1e-8)


def test_a_bead_on_a_turning_wall():
    """Without friction r″ = Ω²r, and the wall presses with 2 m Ω r′."""
    rate, start, end = 3.0, 0.2, 0.5
    more = "  arm: {joints: [O, P], length: 1}\ndrives: {arm: {angle: 0, speed: 3}}"
    contact = f"arm: {{body: body, points: [C], wall: arm, through: O, angle: 0, {RIGID}}}"
    text = floating(contact, at=(start, 0, 0), moving=(0, rate * start, 0), gravity=0, more=more)
    found, state = moved(text.replace("arm: {body", "hit: {body"), end)
    reach, speed = start * math.cosh(rate * end), start * rate * math.sinh(rate * end)
    angle = rate * end
    assert state[:2] == pytest.approx(reach * np.array([math.cos(angle), math.sin(angle)]))
    force = float(found.data["clearance_force"].sel(clearance="hit").isel(time=-1))
    assert force == pytest.approx(2 * 2 * rate * speed, rel=1e-8)
    torque = float(found.data["drive_effort"].sel(drive="arm").isel(time=-1))
    assert torque == pytest.approx(force * reach, rel=1e-8)


def test_a_bead_leaves_a_sphere():
    """From a push v₀ at the top, where cos θ = 2/3 + v₀²/(3 g R)."""
    radius, push = 0.5, 0.4
    ball = f"ball: {{body: body, points: [C], through: O, circle: {radius}, {RIGID}}}"
    text = floating(ball, at=(0, radius, 0), moving=(push, 0, 0))
    found, _ = moved(text, 1.0, samples=2)
    (time,) = found.motion.changes["ball: press"].time
    _, state = moved(text, float(time))
    leaving = 2 / 3 + push**2 / (3 * G * radius)
    assert state[1] / radius == pytest.approx(leaving, abs=1e-8)
    assert math.hypot(*state[3:5]) == pytest.approx(math.sqrt(G * radius * leaving), rel=1e-8)


@pytest.mark.parametrize("friction", [0.0, 0.5], ids=["slides", "rolls"])
def test_a_disc_swings_in_a_ring(friction):
    """Like a pendulum of length R − r; where it rolls, with 1 + J/(m r²) times its inertia."""
    radius, ring, start = 0.05, 0.4, 0.3
    length = ring - radius
    at = (length * math.sin(start), -length * math.cos(start), 0.0)
    law = f"{RIGID}, friction: {friction}" if friction else RIGID
    inside = f"ring: {{body: body, points: [C], radius: {radius}, through: O, circle: {ring}"
    _, state = moved(floating(f"{inside}, inside: true, {law}}}", at=at), 1.3)
    slower = 1 + 0.01 / (2 * radius**2) if friction else 1.0

    def pendulum(_, y):
        return [y[1], -G / (length * slower) * math.sin(y[0])]

    angle, rate = solve_ivp(pendulum, (0, 1.3), [start, 0.0], rtol=1e-12, atol=1e-13).y[:, -1]
    assert math.atan2(state[0], -state[1]) == pytest.approx(angle, abs=1e-8)
    assert state[5] == pytest.approx(-rate * length / radius if friction else 0.0, abs=1e-7)


def test_a_flat_follower_lifts_off_its_cam():
    """Where spring and weight press with less than m e ω² sin θ."""
    speed, eccentricity, radius = 1200 * math.pi / 30, 8e-3, 20e-3
    text = f"""
gravity: [0, -9.81]
joints: {{O: [0, 0], T: [0, 0.12]}}
bars: {{cam: {{points: {{O: [0, 0], E: [{eccentricity}, 0]}}}}}}
sliders: {{valve: {{joint: V, through: O, angle: 90 deg, mass: 0.2}}}}
springs: [{{between: [V, T], stiffness: 500, length: 0.13}}]
drives: {{cam: {{angle: -90 deg, speed: {speed!r}}}}}
free: {{valve: {{position: {radius - eccentricity!r}, speed: 0}}}}
contacts:
  face: {{body: cam, points: [E], radius: {radius}, wall: valve, through: V, angle: 90 deg,
         {RIGID}}}
"""
    time = linkages.simulate(linkages.loads(text), end=0.03).motion.changes["face: press"].time[0]
    pressing = 500 * (0.01 + radius) + 0.2 * G
    lifts = pressing / (0.2 * eccentricity * speed**2 - 500 * eccentricity)
    assert math.sin(speed * time - math.pi / 2) == pytest.approx(lifts, rel=1e-9)


def test_a_stick_falls_and_slips():
    """Its foot holds until |F| = μ N, from N and F of a rod that turns about its end [1]_.

    .. [1] R. Cross, "The fall and bounce of pencils and other elongated objects", Am. J. Phys. 74
       (2006) 26.
    """
    half, lean, friction = 0.1, 0.2, 0.3
    inertia = 0.01 + 2 * half**2
    foot = f"foot: {{body: body, points: [A], through: O, angle: 0, {RIGID}, friction: {friction}}}"
    at = (half * math.sin(lean), half * math.cos(lean), math.pi / 2 - lean)
    found, _ = moved(floating(foot, at=at), 0.6, samples=2)
    slides = found.motion.changes["foot: slip"]
    time = float(slides.time[0])
    _, state = moved(floating(foot, at=at), time)
    turned = math.pi / 2 - state[2]
    rise = 2 * G * half / inertia * math.sin(turned)
    square = 2 * (2 * G * half / inertia) * (math.cos(lean) - math.cos(turned))
    assert state[5] ** 2 == pytest.approx(square, rel=1e-9)
    normal = 2 * (G - half * (rise * math.sin(turned) + square * math.cos(turned)))
    along = 2 * half * (rise * math.cos(turned) - square * math.sin(turned))
    assert abs(along) == pytest.approx(friction * normal, rel=1e-7)


def test_a_stick_comes_to_rest_flat():
    """Nothing says which of two points holds it: both forces together carry its weight."""
    floor = f"floor: {{body: body, points: [A, B], through: O, angle: 0, {RIGID}, friction: 0.3}}"
    found, state = moved(floating(floor, at=(0.0, 0.6, 1.0)), 3.0)
    assert state[1:] == pytest.approx(np.zeros(5), abs=1e-9)
    force = found.data["clearance_force"].isel(time=-1).sel(clearance=["floor.A", "floor.B"])
    assert np.asarray(force) == pytest.approx(2 * G * np.array([0.75, 0.25]), rel=1e-6)


def test_a_ball_comes_to_rest_in_a_groove():
    """Impacts at one wall part it from the other one, ever more slowly."""
    wall = "{{body: body, points: [C], radius: 0.02, through: O, angle: {} deg, {}}}"
    walls = f"right: {wall.format(45, RIGID)}\n  left: {wall.format(-40, RIGID)}"
    _, state = moved(floating(walls, at=(0.05, 0.2, 0.0)), 2.0)
    sides = np.radians([135.0, 50.0])
    normals = np.column_stack([np.cos(sides), np.sin(sides)])
    assert state[:2] == pytest.approx(np.linalg.solve(normals, [0.02, 0.02]), abs=1e-9)
    assert state[3:] == pytest.approx(np.zeros(3), abs=1e-9)


WALLS = {
    "straight": "angle: 0.4",
    "within a circle": "circle: 0.9, inside: true",
    "around a circle": "circle: 0.25",
}
STARTS = {
    "straight": ((0.1, 0.75, 0.4), (0.3, -1.0, 2.0)),
    "within a circle": ((0.0, -0.2, 0.4), (1.0, -1.0, 2.0)),
    "around a circle": ((0.05, 0.9, 0.4), (0.1, -1.0, 2.0)),
}


def independent(wall, start, end, *, radius, turning):
    """Newton's and Euler's equations of the body alone, the wall turning about O at a rate."""
    middle, stiffness, damping = np.array([0.3, 0.0]), 1e6, 0.5

    def rates(time, y):
        turn = 0.5 + turning * time
        place = complex(*y[:2]) + middle[0] * np.exp(1j * y[2])
        moving = complex(*y[3:5]) + 1j * y[5] * (place - complex(*y[:2]))
        corner = 0.2 * np.exp(1j * turn)
        arm = place - corner
        if wall == "straight":
            out = 1j * np.exp(1j * (turn + 0.4))
            depth = radius - (arm * out.conjugate()).real
        else:
            out = arm / abs(arm)
            depth = 0.25 + radius - abs(arm)
            if wall == "within a circle":
                out, depth = -out, abs(arm) - 0.9 + radius
        touch = place - radius * out
        passing = moving - 1j * y[5] * radius * out - 1j * turning * touch
        force = 0.0
        if depth > 0:
            closing = -(passing * out.conjugate()).real
            normal = max(stiffness * depth**1.5 * (1 + damping * closing), 0.0)
            along = out / 1j
            slip = (passing * along.conjugate()).real
            force = normal * out - 0.3 * math.tanh(slip / 0.1) * normal * along
        lever = touch - complex(*y[:2])
        force = complex(force)
        torque = (lever.conjugate() * force).imag
        return [*y[3:], force.real / 2, force.imag / 2 - G, torque / 0.01]

    how = {"rtol": 1e-13, "atol": 1e-14, "max_step": 1e-3}
    return solve_ivp(rates, (0, end), start, "DOP853", **how).y[:, -1]


@pytest.mark.parametrize("radius", [0.0, 0.04], ids=["point", "round"])
@pytest.mark.parametrize("wall", WALLS)
def test_against_an_independent_formulation(wall, radius):
    at, moving = STARTS[wall]
    more = "  arm: {joints: [O, P], length: 0.2}\ndrives: {arm: {angle: 0.5, speed: 1.5}}"
    law = f"{ELASTIC}, {RUBS}"
    tip = f"tip: {{body: body, points: [B], radius: {radius}, wall: arm, through: P, {WALLS[wall]}"
    text = floating(f"{tip}, {law}}}", at=at, moving=moving, more=more)
    found, state = moved(text, 0.8, rtol=1e-12)
    assert len(found.motion.changes["tip: touch"].time) >= 2
    expected = independent(wall, [*at, *moving], 0.8, radius=radius, turning=1.5)
    assert state == pytest.approx(expected, abs=2e-7)


@pytest.mark.parametrize("wall", WALLS)
def test_momentum_of_two_bodies(wall):
    """Nothing else acts: momentum and angular momentum stay, and energy is accounted for."""
    at, moving = STARTS[wall]
    tip = f"tip: {{body: body, points: [B], radius: 0.04, wall: plate, through: W, {WALLS[wall]}"
    plate = "points: {D: [0, 0], W: [0, 0.2], V: [0.2, 0]}, mass: 3, inertia: 0.2, center: [0, 0]"
    text = floating(
        f"{tip}, {ELASTIC}, {RUBS}}}", at=at, moving=moving, gravity=0,
        guides="""
  u: {joint: U, through: O, angle: 0}
  v: {joint: D, on: u, through: [0, 0], angle: 90 deg}""",
        more=f"  plate: {{{plate}}}",
        free="""
  u: {position: 0, speed: 0}
  v: {position: 0, speed: 0.5}
  plate: {angle: 0.2, speed: 1}""",
    )  # fmt: skip
    data = linkages.simulate(linkages.loads(text), end=1.0, samples=801, outputs="all").data
    assert float(data["clearance_force"].max()) > 10
    place, rate = (data[n].sel(joint=["C", "D"]) for n in ("joint_position", "joint_velocity"))
    masses, inertias = np.array([2.0, 3.0]), np.array([0.01, 0.2])
    place, rate = np.asarray(place), np.asarray(rate)
    momentum = np.einsum("j,tja->ta", masses, rate)
    spin = np.asarray(data["bar_speed"].sel(bar=["body", "plate"])) @ inertias
    spin += (place[..., 0] * rate[..., 1] - place[..., 1] * rate[..., 0]) @ masses
    assert np.ptp(momentum, axis=0) == pytest.approx([0, 0], abs=1e-9)
    assert np.ptp(spin) == pytest.approx(0, abs=1e-9)
    assert np.abs(data["energy_residual"]).max() < 1e-7


LAWS = {"elastic": f"{ELASTIC}, {RUBS}", "rigid": f"{RIGID}, friction: 0.2, least_rate: 0.2"}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("wall", WALLS)
def test_tangents(wall, law):
    at, moving = STARTS[wall]
    more = "  arm: {joints: [O, P], length: 0.2}\ndrives: {arm: {angle: 0.5, speed: 1.5}}"
    tip = f"tip: {{body: body, points: [B], radius: 0.04, wall: arm, through: P, {WALLS[wall]}"
    check(floating(f"{tip}, {law}}}", at=at, moving=moving, more=more), 0.45, 0.02)


def test_a_shaken_table_without_restitution():
    """A ball leaves where the table falls faster than it: A ω² sin φ = g; and it lands at rest."""
    size, rate = 0.01, 60.0
    more = f"""  table: {{points: {{T: [0, 0], U: [1, 0]}}}}
drives: {{table: {{law: 0}}, lift: {{law: "{size} * sin({rate} * t)"}}}}"""
    wall = "floor: {body: body, points: [C], wall: table, through: T, angle: 0, "
    text = floating(
        f"{wall}contact: restitution, restitution: 0}}",
        at=(0, 0, 0), moving=(0, 0.6, 0), more=more,
        guides="\n  lift: {joint: T, through: O, angle: 90 deg}",
    )  # fmt: skip
    changes = linkages.simulate(linkages.loads(text), end=0.15).motion.changes
    presses, touches = changes["floor: press"], changes["floor: touch"]
    leaves = math.asin(G / (size * rate**2)) / rate
    assert presses.time[0] == pytest.approx(leaves, abs=1e-9)
    start = size * math.sin(rate * leaves), size * rate * math.cos(rate * leaves)

    def apart(time):
        flown = time - leaves
        return start[0] + start[1] * flown - 0.5 * G * flown**2 - size * math.sin(rate * time)

    lands = brentq(apart, leaves + 0.01, leaves + 0.12, xtol=1e-14)
    rises = touches.time[touches.rises]
    assert rises[rises > leaves][0] == pytest.approx(lands, abs=1e-9)


def test_batches_have_the_bits_of_single_motions():
    floor = f"floor: {{body: body, points: [A, B], through: O, angle: 0.1, {RIGID}}}"
    text = floating(floor, at=(0.0, 0.6, 1.0))
    values = np.linspace(0.2, 0.8, 12)
    path = "contacts.floor.restitution"
    swept = linkages.sweep(
        linkages.loads(text), {path: values.tolist()}, measure=["at(1 s, x.position)"], end=1.0
    )
    for found, value in zip(swept["at(1 s, x.position)"], values.tolist(), strict=True):
        _, state = moved(text.replace("restitution: 0.5", f"restitution: {value!r}"), 1.0)
        assert float(found) == state[0]


@pytest.mark.parametrize("count", [3, 16], ids=["one by one", "together"])
def test_starts_in_a_wall_are_refused_at_points_of_sweeps(count):
    floor = f"floor: {{body: body, points: [C], radius: 0.02, through: O, angle: 0, {RIGID}}}"
    places = np.linspace(-0.3, 0.3, count)
    vary = {"free.y.position": places.tolist()}
    found = linkages.sweep(
        linkages.loads(floating(floor)), vary, measure=["max(y.position)"], end=0.1
    )
    refused = np.array(["within the wall" in reason for reason in found["reason"].values])
    assert (refused == (places < 0.02)).all()
    assert (np.isnan(found["max(y.position)"].values) == refused).all()


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("points: [C], through: O", "missing key 'angle' or 'circle'"),
        ("points: [C], through: O, angle: 0, circle: 1", "expected one of the two"),
        ("points: [C], through: O, angle: 0, inside: true", "has no inside"),
        ("points: [C], radius: 2, through: O, circle: 1, inside: true", "found 2 m"),
        ("points: [], through: O, angle: 0", "one joint or more"),
        ("points: [C, C], through: O, angle: 0", "each once"),
        ("points: [Z], through: O, angle: 0", "unknown joint 'Z'"),
        ("points: [X], through: O, angle: 0", "has no joint 'X'"),
        ("points: [C], through: X, angle: 0", "unknown ground joint 'X'"),
        ("points: [C], wall: body, through: A, angle: 0", "another body"),
        ("points: [C], wall: bdy, through: A, angle: 0", "did you mean 'body'"),
        ("points: [C], through: O, angle: 180 deg", "within the wall"),
        ("points: [C], through: O, angle: 0, contact: flores, stiffness: 1, restitution: 0", "> 0"),
        ("points: [C], through: O, angle: 0, impact: moreau, slip: 1", "'slip'"),
    ],
)
def test_wrong_entries(entry, found):
    law = "" if "contact" in entry else f", {RIGID}"
    text = floating(f"hit: {{body: body, {entry}{law}}}")
    with pytest.raises(linkages.InputError) as error:
        linkages.simulate(linkages.loads(text), end=0.1)
    assert found in str(error.value)
    assert "contacts.hit" in str(error.value)


def test_walls_along_which_a_body_slips_alike():
    entry = "{{body: body, points: [{}], through: O, angle: 0, {}, friction: 0.3}}"
    text = floating(f"a: {entry.format('A', RIGID)}\n  b: {entry.format('B', RIGID)}")
    with pytest.raises(linkages.InputError, match="one entry with all 'points'"):
        linkages.loads(text)
    linkages.loads(text.replace(", friction: 0.3", ""))
    linkages.loads(text.replace("angle: 0, contact", "angle: 1, contact", 1))


def test_a_contact_is_not_called_like_a_clearance():
    entry = f"{{body: body, points: [A], through: O, angle: 0, {RIGID}}}"
    text = floating(f"hinge: {entry}", more="  arm: {joints: [B, D], length: 1, mass: 1}")
    text += "clearances: {hinge: {joint: B, bar: arm, size: 0.001}}\n"
    with pytest.raises(linkages.InputError, match="a clearance has this name"):
        linkages.loads(text.replace("free:", "free:\n  arm: {angle: 0}"))


def test_a_ball_that_rubs_in_a_groove_stops_with_a_reason():
    wall = "{{body: body, points: [C], radius: 0.02, through: O, angle: {} deg, {}, friction: 0.3}}"
    walls = f"right: {wall.format(45, RIGID)}\n  left: {wall.format(-40, RIGID)}"
    text = floating(walls, at=(0.05, 0.2, 0.0), moving=(0.0, 0.0, 20.0))
    text = text.replace("mass: 2, inertia: 0.01", "mass: 1, inertia: 1.6e-4")
    found = linkages.simulate(linkages.loads(text), end=2.0, throw=False)
    assert "no impulses under friction are found for all that touch at once" in found.motion.failure
    assert len(found.data.time) > 1
