"""Joint reactions: equilibrium of every body, textbook closed forms, a second method."""

import numpy as np
import pytest
from solution_mechanisms import FOUR_BAR, derivative, mechanism

import linkages
from linkages.plots import charts

SPACING = 2e-3


def components(data, name, joint):
    """Shape (samples, 2) as complex numbers x + iy."""
    x, y = data[name].sel(joint=joint).to_numpy().T
    return x + 1j * y


def cross(a, b):
    return (np.conj(a) * b).imag


@pytest.fixture(scope="module")
def four_bar():
    return linkages.simulate(mechanism(FOUR_BAR), end=1.2, samples=601, outputs="all").data


# bar: first joint, second joint, length, centre, mass, inertia, pins with the sign of what acts
# on this bar (the reaction is what the first body at the joint exerts on the second)
BODIES = {
    "crank": ("O2", "A", 0.04, 0.01 + 0.004j, 0.15, 3e-5, {"O2": 1, "A": -1}),
    "coupler": ("A", "B", 0.12, 0.05 + 0.02j, 0.45, 7e-4, {"A": 1, "B": -1}),
    "rocker": ("O4", "B", 0.08, 0.04, 0.3, 2e-4, {"O4": 1, "B": 1}),
}


@pytest.mark.parametrize("bar", BODIES)
def test_every_bar_obeys_newton_and_euler(four_bar, bar):
    """Accelerations by differentiating the positions of the joints, and nothing else."""
    first, second, length, centre, mass, inertia, pins = BODIES[bar]
    start, end = (components(four_bar, "joint_position", joint) for joint in (first, second))
    direction = (end - start) / length
    place = start + centre * direction
    acceleration = derivative(place, SPACING, 2)
    spin = derivative(np.unwrap(np.angle(direction)), SPACING, 2)
    inner = slice(4, -4)
    force, moment = -9.81j * mass + 0 * acceleration, 0.0
    for joint, sign in pins.items():
        reaction = sign * components(four_bar, "joint_reaction", joint)[inner]
        arm = (components(four_bar, "joint_position", joint) - place)[inner]
        force = force + reaction
        moment = moment + cross(arm, reaction)
    if bar == "crank":
        moment = moment + four_bar.drive_effort[inner, 0].to_numpy()
    # Second differences of order 8 at 2 ms lose digits to round-off: 1e-17 m/(4e-6 s²) = 3e-12.
    scale = np.abs(components(four_bar, "joint_reaction", "A")).max()
    assert np.abs(force - mass * acceleration).max() < 1e-8 * scale
    assert np.abs(moment - inertia * spin).max() < 1e-8 * scale * length


def test_slider_crank_closed_form():
    """Massless rod, no gravity: it carries P/cos φ, P = m·ẍ − F, and the crank needs the moment
    of P and P·tan φ about its pin (any textbook; x = r cos θ + √(l² − r² sin² θ)).
    """
    r, rod, m, load, speed = 0.04, 0.14, 0.4, -200.0, 157.0
    data = linkages.simulate(
        mechanism(
            "joints: {O: [0, 0]}\n"
            f"bars:\n  crank: {{joints: [O, A], length: {r}}}\n"
            f"  rod: {{joints: [A, B], length: {rod}}}\n"
            f"sliders: {{piston: {{joint: B, through: O, mass: {m}}}}}\n"
            f"drives: {{crank: {{angle: 0.2, speed: {speed}}}}}\nassembly: {{B: [0.17, 0]}}\n"
            f"loads: [{{slider: piston, force: {load}}}]\n"
        ),
        end=0.08, samples=401, outputs="all",
    ).data  # fmt: skip
    angle = 0.2 + speed * data.time.to_numpy()
    along = np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    position = r * np.cos(angle) + along
    change = -(r**2) * np.sin(angle) * np.cos(angle) / along
    velocity = speed * (-r * np.sin(angle) + change)
    acceleration = speed**2 * (-r * np.cos(angle) - (r**2 * np.cos(2 * angle) + change**2) / along)
    push = m * acceleration - load
    tangent = -r * np.sin(angle) / along
    # Some roundings at an angle of up to 13 rad.
    close = {"rtol": 0, "atol": 1e-12}
    assert np.allclose(data.slider_position[:, 0], position, **close)
    assert np.allclose(data.slider_velocity[:, 0] / speed, velocity / speed, **close)
    assert np.allclose(data.slider_acceleration[:, 0] / speed**2, acceleration / speed**2, **close)
    # The crank pushes the rod with (P, P tan φ), the ground the crank with the same.
    expected = push * (1 + 1j * tangent)
    for joint in ("O", "A", "B"):
        found = components(data, "joint_reaction", joint)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(push).max()
    effort = r * push * (np.cos(angle) * tangent - np.sin(angle))
    assert np.allclose(data.drive_effort[:, 0] / push.max(), effort / push.max(), **close)
    # and by virtual work: effort·ω = (m·ẍ − F)·ẋ
    power = (data.drive_effort[:, 0] * speed).to_numpy()
    assert np.abs(power - push * velocity).max() < 1e-12 * np.abs(push * velocity).max()


@pytest.fixture(scope="module")
def ninebar():
    return linkages.simulate(
        linkages.load("ninebar"), end=0.2, samples=401, rtol=1e-11, outputs="all"
    ).data


def test_clearance_force_is_the_reaction_at_its_pin(ninebar):
    """The link carries no moment and has no mass: both pins of it feel the same force along it."""
    angle = ninebar.clearance_angle[:, 0].to_numpy()
    tension = ninebar.clearance_force[:, 0].to_numpy() * np.exp(1j * angle)
    scale = np.abs(tension).max()
    # crank 4 pulls the link's end C towards itself, link 3 pulls the other end
    at_pin = components(ninebar, "joint_reaction", "C")
    at_bar = components(ninebar, "joint_reaction", "C.r1")
    # The transverse part is what the integrated acceleration leaves: M·r·(error of α̈ ≈ 1e-5).
    assert np.abs(at_pin + tension).max() < 1e-9 * scale
    assert np.abs(at_bar - tension).max() < 1e-9 * scale


def test_nine_bar_as_a_whole(ninebar):
    """Along x no guide acts: the pins on the ground and the weight accelerate all masses."""
    bars = {
        ("O", "A"): 0.985, ("A", "B"): 2.836, ("C.r1", "B"): 3.051, ("D", "C"): 0.361,
        ("O", "E"): 2.701, ("E", "B"): 1.993, ("E", "F"): 2.701, ("F", "F"): 4.288,
    }  # fmt: skip
    change = sum(
        mass * 0.5 * sum(components(ninebar, "joint_acceleration", joint).real for joint in ends)
        for ends, mass in bars.items()
    )
    ground = sum(components(ninebar, "joint_reaction", joint).real for joint in ("O", "D"))
    weight = 9.81 * sum(bars.values())
    assert np.abs(ground + weight - change).max() < 1e-11 * np.abs(ground).max()


def test_efforts_follow_from_moments_about_the_ground_pins(ninebar):
    """Crank 4: I about D, weight at mid-length, the pin force at C; nothing else acts on it."""
    place, origin = (components(ninebar, "joint_position", joint) for joint in ("C", "D"))
    arm = place - origin
    on_link = components(ninebar, "joint_reaction", "C")
    # constant speed, so no moment of inertia; what the crank exerts acts back on it
    moment = cross(arm, -on_link) + cross(arm / 2, 9.81 * 0.361 + 0j)
    effort = ninebar.drive_effort.sel(drive="crank4").to_numpy()
    assert np.abs(effort + moment).max() < 1e-10 * np.abs(effort).max()


def test_pendulum_pulls_at_its_pin():
    """Released at rest 90° from the vertical, a point mass pulls with 3 m g at the bottom."""
    rod = mechanism(
        "gravity: [0, -9.81]\njoints: {O: [0, 0]}\n"
        "bars: {rod: {joints: [O, P], length: 0.7, mass: 2, center: 0.7, inertia: 0}}\n"
        "free: {rod: {angle: 0}}\n"
    )
    data = linkages.simulate(rod, end=2.0, samples=2001, rtol=1e-11, outputs="all").data
    angle = data.bar_angle[:, 0].to_numpy()
    # from the energy: m L θ̇² = −2 m g sin θ, and the weight along the rod once more
    expected = 3 * 2 * 9.81 * np.sin(angle) * np.exp(1j * angle)
    found = components(data, "joint_reaction", "O")
    assert np.abs(found - expected).max() < 1e-8
    assert np.abs(components(data, "joint_reaction", "P")).max() == 0.0


def test_what_hangs_on_a_ground_pin_hangs_on_the_ground():
    """A vertical rod held at O; a spring from O to elsewhere pulls at the ground, not the rod."""
    text = """\
joints: {O: [0, 0], G: [0, 0], S: [0.3, 0]}
gravity: [0, -10]
bars: {rod: {joints: [O, A], length: 0.2, mass: 1}, other: {joints: [S, B], length: 0.2}}
drives: {rod: {angle: -90 deg, speed: 0}, other: {angle: 0, speed: 0}}
"""
    for anchor in "OG":
        spring = f"springs: [{{between: [{anchor}, B], stiffness: 100, length: 0.1}}]"
        data = linkages.simulate(mechanism(text, spring), end=1.0, samples=2, outputs="all").data
        assert data.joint_reaction.sel(joint="O").to_numpy() == pytest.approx(
            np.array([[0, 10], [0, 10]]), abs=1e-12
        )
        # the other end pulls the second rod, which its own pin holds
        assert data.joint_reaction.sel(joint="S").to_numpy() == pytest.approx(
            np.array([[40, 0], [40, 0]]), abs=1e-12
        )


BUCKET = """
gravity: [0, -9.81]
joints: {H: [0, 0], I: [-350 mm, 60 mm], C: [-1500 mm, 350 mm]}
bars:
  idler:  {joints: [I, K], length: 400 mm, mass: 12}
  bucket: {points: {H: [0, 0], L: [-100 mm, 330 mm], T: [1100 mm, 0]}, mass: 350,
           center: [450 mm, 150 mm], inertia: 60}
  link:   {joints: [K, L], length: 380 mm, mass: 14}
  barrel: {joints: [C, E], length: 700 mm, mass: 25}
sliders: {ram: {joint: K, on: barrel, mass: 18}}
masses: {K: 5}
loads: [{joint: T, on: bucket, force: [0, -30 kN]}, {joint: K, force: [2 kN, 1 kN]}]
drives: {ram: {law: {rise: modified-sine, from: 1.10, to: 1.55, duration: 4 s}}}
assembly: {K: [-400 mm, 450 mm], L: [-50 mm, 340 mm]}
simulate: {end: 4, samples: 41}
"""


def test_every_body_at_a_shared_pin_has_its_force():
    """Equilibrium of each body by itself, from forces at its other end and accelerations.

    The load and the mass at K belong to the idler, the first body there: its own end has neither.
    """
    solution = linkages.simulate(
        linkages.loads(BUCKET), outputs=["joint_acceleration", "joint_reaction"]
    )
    data, g = solution.data, -9.81j
    moved = {j: components(data, "joint_acceleration", j) for j in "ICKLE"}
    at = {joint: components(data, "joint_reaction", joint) for joint in "IKCL"}
    pins = {str(n): data.pin_reaction.sel(pin=n).to_numpy() @ [1, 1j] for n in data.pin.values}
    assert [*pins] == ["K.idler", "K.link", "K.ram"]
    held = (2 + 1j) * 1e3 - 5 * (moved["K"] - g)  # of load and mass at K
    idler = 12 * (0.5 * (moved["I"] + moved["K"]) - g) - at["I"] - held
    link = 14 * (0.5 * (moved["L"] + moved["K"]) - g) - at["L"]
    cylinder = 25 * (0.5 * (moved["C"] + moved["E"]) - g) + 18 * (moved["K"] - g) - at["C"]
    size = np.abs(cylinder).max()
    for name, force in (("K.idler", idler), ("K.link", link), ("K.ram", cylinder)):
        assert np.abs(pins[name] - force).max() < 1e-11 * size, name
    assert np.abs(sum(pins.values())).max() < 1e-13 * size
    assert np.array_equal(-pins["K.idler"], at["K"])
    assert any("three bodies or more meet at K: pin_reaction has" in n for n in solution.notes)


def test_the_largest_force_at_a_shared_pin_is_that_of_a_named_body():
    """The table has 490 kN on the eye of the cylinder, and not 321 kN on the idler."""
    bucket = linkages.loads(BUCKET)
    solution = linkages.simulate(bucket, outputs=["joint_reaction"])
    rows = {(row["variable"], row["element"]): row["value"] for row in solution.maxima}
    assert ("joint_reaction", "K") not in rows
    assert rows["joint_reaction", "K.ram"] == rows["pin_reaction", "K.ram"]
    names = ("K.idler", "K.link", "K.ram")
    assert rows["joint_reaction", "K.ram"] == max(rows["pin_reaction", name] for name in names)
    texts = [text.get_text() for text in charts.joint_reaction(solution).get_legend().get_texts()]
    assert [text for text in texts if text.startswith("K")] == ["K.ram"]
    measure = "max(sqrt(K.ram.x_reaction**2 + K.ram.y_reaction**2))"
    size = linkages.measure(solution, measure)
    assert size == pytest.approx(rows["pin_reaction", "K.ram"], rel=1e-9)
    swept = linkages.sweep(bucket, {"masses.K": [5.0, 6.0]}, measure)[measure]
    assert float(swept[0]) == pytest.approx(size, rel=1e-12)


def test_a_fixed_pivot_of_two_links_has_their_forces_and_that_on_the_ground():
    data = linkages.simulate(linkages.load("jansen"), samples=5, outputs=["joint_reaction"]).data
    pins = {str(n): data.pin_reaction.sel(pin=n).to_numpy() for n in data.pin.values}
    assert {"Z.ground", "Z.upper", "Z.c"} <= {*pins}
    total = data.joint_reaction.sel(joint="Z").to_numpy()
    assert np.array_equal(-pins["Z.ground"], total)
    assert pins["Z.upper"] + pins["Z.c"] == pytest.approx(total, rel=1e-12)


def test_a_clearance_at_a_shared_pin_has_the_name_of_its_bar():
    """Two rods on one crank pin, one of them with a clearance: it carries the force of its link."""
    data = linkages.simulate(
        linkages.loads(
            """
            joints: {O: [0, 0]}
            bars:
              crank:
                {points: {O: [0, 0], A: [40 mm, 0]}, mass: 2, center: [10 mm, 0], inertia: 2e-3}
              rod1: {joints: [A, B], length: 150 mm, mass: 0.4, center: 45 mm, inertia: 1.2e-3}
              rod2: {joints: [A, C], length: 150 mm, mass: 0.4, center: 45 mm, inertia: 1.2e-3}
            sliders:
              p1: {joint: B, through: O, angle: 135 deg, mass: 0.5}
              p2: {joint: C, through: O, angle: 45 deg, mass: 0.5}
            clearances: {play: {joint: A, bar: rod2, size: 0.05 mm}}
            drives: {crank: {angle: 0, speed: 3000 rpm}}
            assembly: {B: [-130 mm, 130 mm], C: [130 mm, 130 mm]}
            simulate: {end: 1 ms, samples: 11}
            """
        ),
        outputs=["joint_reaction", "clearance_force"],
    ).data
    assert list(data.pin.values) == ["A.crank", "A.rod1", "A.rod2"]
    size = np.abs(data.clearance_force.to_numpy()[:, 0])
    on_rod = np.hypot(*data.pin_reaction.sel(pin="A.rod2").to_numpy().T)
    through = np.hypot(*data.joint_reaction.sel(joint="A.play").to_numpy().T)
    assert on_rod == pytest.approx(size, rel=1e-9)
    assert on_rod == pytest.approx(through, rel=1e-9)
