"""Friction that follows reactions: closed forms, absolute coordinates, jams, tangents, messages."""

import numpy as np
import pytest
from component_reading import complaints, component
from scipy.optimize import fsolve

import linkages
from linkages.components.dry_friction import JournalFriction, PressedGuideFriction

SPINNING = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, A], length: 1, mass: 2, center: 0.5, inertia: 0.3}}
free: {rod: {angle: 0.4, speed: 12}}
friction:
  - {joint: O, coefficient: 0.25, radius: RADIUS, slip_speed: 1e-3}
"""
ENGINE = """
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 1, center: 0.03, inertia: 0.004}
  rod: {joints: [A, B], length: 0.3, mass: 0.5, center: [0.1, 0.02], inertia: 0.003}
sliders: {piston: {joint: B, through: O, angle: 0, mass: 0.4}}
gravity: [0, -9.81]
assembly: {B: [0.4, 0]}
loads: [{slider: piston, force: -30}]
free: {crank: {angle: 0.5, speed: 20}}
friction:
"""
SLIPS = {
    "guide": "  - {slider: piston, coefficient: 0.3, slip_speed: 0.01}\n",
    "O": "  - {joint: O, coefficient: 0.2, radius: 30 mm, slip_speed: 0.1}\n",
    "A": "  - {joint: A, coefficient: 0.2, radius: 20 mm, slip_speed: 0.1}\n",
    "B": "  - {joint: B, coefficient: 0.25, radius: 20 mm, slip_speed: 0.1}\n",
}


def test_same_from_yaml_and_python():
    made = JournalFriction(index=0, joint="O", coefficient=0.2, radius=0.03, slip_speed=0.1)
    assert component(ENGINE + SLIPS["O"], "friction", 0) == made
    guide = PressedGuideFriction(index=0, slider="piston", coefficient=0.3, slip_speed=0.01)
    assert component(ENGINE + SLIPS["guide"], "friction", 0) == guide


def test_a_rod_that_spins_down():
    """J ω' = -μ R m c √(ω⁴ + ω'²), so ω' = -k ω² and ω = ω0/(1 + k ω0 t), without gravity."""
    data = linkages.simulate(
        linkages.loads(SPINNING.replace("RADIUS", "0.2")),
        end=3.0, samples=13, outputs=["bar_speed", "joint_reaction", "energy_residual"],
    ).data  # fmt: skip
    inertia, lever = 0.3 + 2 * 0.25, 0.25 * 0.2 * 2 * 0.5
    rate = lever / np.sqrt(inertia**2 - lever**2)
    speed = data.bar_speed.to_numpy()[:, 0]
    assert speed == pytest.approx(12 / (1 + rate * 12 * data.time.to_numpy()), rel=1e-9)
    reaction = np.hypot(*data.joint_reaction.sel(joint="O").to_numpy().T)
    assert reaction == pytest.approx(speed**2 * np.sqrt(1 + rate**2), rel=1e-8)  # m c is 1 kg m
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8  # of 58 J


def by_absolute_coordinates(names, angle, speed):
    """Accelerations and reactions of `ENGINE`: Newton and Euler for three bodies, by fsolve."""
    other = np.arcsin(-np.sin(angle) / 3)
    rate = -0.1 * speed * np.cos(angle) / (0.3 * np.cos(other))
    slide = -0.1 * speed * np.sin(angle) - 0.3 * rate * np.sin(other)
    smooth = {
        "guide": 0.3 * np.tanh(slide / 0.01),
        "O": 0.006 * np.tanh(speed / 0.1),
        "A": 0.004 * np.tanh((rate - speed) / 0.1),
        "B": 0.005 * np.tanh(-rate / 0.1),
    }
    smooth = {name: factor if name in names else 0.0 for name, factor in smooth.items()}

    def along(turned, length, lateral=0.0):
        return np.array([
            length * np.cos(turned) - lateral * np.sin(turned),
            length * np.sin(turned) + lateral * np.cos(turned),
        ])  # fmt: skip

    def moved(turned, rate, acceleration, length, lateral=0.0):
        arm = along(turned, length, lateral)
        return acceleration * np.array([-arm[1], arm[0]]) - rate**2 * arm

    def cross(a, b):
        return a[0] * b[1] - a[1] * b[0]

    def missing(unknown):
        turn, swing, push, *forces, normal = unknown
        pin, crank_rod, rod_piston = np.reshape(forces, (3, 2))  # on crank, rod, piston
        weight = np.array([0, -9.81])
        torque = {
            "O": -smooth["O"] * np.hypot(*pin),
            "A": -smooth["A"] * np.hypot(*crank_rod),  # on the rod
            "B": -smooth["B"] * np.hypot(*rod_piston),  # on the piston, none of whose turns
        }
        crank = moved(angle, speed, turn, 0.03)
        end = moved(angle, speed, turn, 0.1)
        rod = end + moved(other, rate, swing, 0.1, 0.02)
        tip = end + moved(other, rate, swing, 0.3)
        first = 1.0 * (crank - weight) - pin + crank_rod
        to_pin, to_end = -along(angle, 0.03), along(angle, 0.07)
        turning = 0.004 * turn - cross(to_pin, pin) - cross(to_end, -crank_rod)
        second = 0.5 * (rod - weight) - crank_rod + rod_piston
        back, ahead = -along(other, 0.1, 0.02), along(other, 0.2, -0.02)
        swinging = 0.003 * swing - cross(back, crank_rod) - cross(ahead, -rod_piston)
        drag = -smooth["guide"] * abs(normal)
        third = 0.4 * (np.array([push, 0]) - weight) - rod_piston - [drag - 30, normal]
        return [
            *first, turning - torque["O"] + torque["A"],
            *second, swinging - torque["A"] + torque["B"],
            *third, *(tip - [push, 0]),
        ]  # fmt: skip

    found, details, *_ = fsolve(missing, np.zeros(10), full_output=True, xtol=1e-13)
    # its own status depends on the version: at round-off no further step is an improvement
    assert np.abs(details["fvec"]).max() < 1e-12 * np.abs(found).max()
    return found


@pytest.mark.slow_except("('*',)")
@pytest.mark.parametrize(
    "names", [("guide",), ("O",), ("A",), ("B",), ("O", "guide"), ("guide", "O", "A", "B")], ids=str
)
def test_against_absolute_coordinates(names):
    mechanism = linkages.loads(ENGINE + "".join(SLIPS[name] for name in names))
    rhs = linkages.compile(mechanism)
    for angle, speed in ((0.5, 20.0), (2.0, -7.0), (4.0, 1.5), (5.5, 60.0)):
        turn, _, _, *forces, normal = by_absolute_coordinates(names, angle, speed)
        state = np.array([angle, speed])
        # digits of fsolve with 10 unknowns up to 1e3
        assert rhs(0.0, state)[1] == pytest.approx(turn, rel=1e-7)
        outputs = ["joint_reaction", "spring_force" if "guide" in names else "bar_angle"]
        data = rhs.outputs(outputs, 0.0, state)
        sizes = np.hypot(*data.joint_reaction.to_numpy()[0].T)
        assert sizes == pytest.approx(np.hypot(*np.reshape(forces, (3, 2)).T), rel=1e-6)
        if "guide" in names:
            assert abs(data.spring_force.item()) == pytest.approx(0.3 * abs(normal), rel=1e-6)


@pytest.mark.slow
def test_energy_and_methods():
    mechanism = linkages.loads(ENGINE + "".join(SLIPS.values()))
    outputs = ["bar_speed", "energy_residual"]
    ends = []
    for method, step in (("dop853", None), ("tsit5", None), ("rk4", 2e-5)):
        data = linkages.simulate(
            mechanism, end=0.1, samples=5, method=method, step=step, outputs=outputs
        ).data
        assert abs(data.energy_residual.to_numpy()).max() < 1e-8  # of 3 J
        ends.append(data.bar_speed.to_numpy()[-1])
    assert ends[1] == pytest.approx(ends[0], abs=1e-7)
    assert ends[2] == pytest.approx(ends[0], abs=1e-6)
    journals = linkages.loads(ENGINE + SLIPS["O"] + SLIPS["A"])
    one, other = (
        linkages.simulate(journals, end=0.05, samples=3, method=method, rtol=1e-9).data.bar_speed
        for method in ("radau", "dop853")
    )
    assert one.to_numpy() == pytest.approx(other.to_numpy(), abs=1e-5)


@pytest.mark.slow
def test_tangents_against_neighbours():
    rhs = linkages.compile(linkages.loads(ENGINE + "".join(SLIPS.values())))
    end = rhs.flow(tangents=2, rtol=1e-12, atol=1e-12).advance(rhs.state, 0.0, 0.05)
    flow, step = rhs.flow(rtol=1e-12, atol=1e-12), 1e-6
    for column, unit in enumerate(np.eye(2)):
        ahead, back = (flow.advance(rhs.state + s * unit, 0.0, 0.05).y for s in (step, -step))
        slope = (ahead - back) / (2 * step)
        assert end.tangents[:, column] == pytest.approx(slope, rel=1e-4, abs=1e-4)


def test_a_drive_feels_it():
    """Nothing is integrated: the effort of the drive is that of Newton and Euler, as reactions."""
    text = (ENGINE + SLIPS["guide"] + SLIPS["A"]).replace(
        "free: {crank: {angle: 0.5, speed: 20}}", "drives: {crank: {angle: 0.5, speed: 20}}"
    )
    outputs = ["drive_effort", "drive_power", "load_power", "energy_residual", "spring_force"]
    data = linkages.simulate(linkages.loads(text), end=0.6, samples=301, outputs=outputs).data
    assert abs(data.energy_residual.to_numpy()).max() < 1e-6
    assert abs(data.spring_force.to_numpy()).max() > 1


TRAMMEL = """
joints: {O: [0, 0]}
bars: {rod: {joints: [A, B], length: 0.5, mass: 0.2}}
sliders:
  block: {joint: A, through: O, angle: 0, mass: 1}
  ram: {joint: B, through: O, angle: 90 deg, mass: 5}
gravity: [0, -9.81]
assembly: {B: [0, 0.3]}
free: {block: {position: POSITION, speed: 0.5}}
friction: [{slider: block, coefficient: 1.2, slip_speed: 0.01}]
"""


def test_jams():
    """A ram on a steep strut: the block slides until the strut is too steep, and locks at once."""
    with pytest.raises(linkages.InputError, match=r"friction\[0\].*it jams.*self-locking"):
        linkages.simulate(linkages.loads(SPINNING.replace("RADIUS", "3.5")))
    flat = linkages.loads(TRAMMEL.replace("POSITION", "0.45"))
    linkages.simulate(flat, end=0.01, samples=3)
    inward = linkages.loads(TRAMMEL.replace("POSITION", "0.45").replace("speed: 0.5", "speed: -9"))
    with pytest.raises(linkages.IncompleteError, match=r"friction\[0\] \(it jams") as stopped:
        linkages.simulate(inward, end=1.0, samples=101)
    assert 0 < stopped.value.time < 0.1


@pytest.mark.parametrize(
    ("entry", "found"),
    [
        ("joint: O, coefficient: -0.1, radius: 0.1, slip_speed: 1", "expected a number >= 0"),
        ("joint: O, coefficient: 0.1, radius: 0, slip_speed: 1", "expected a length > 0"),
        ("joint: O, coefficient: 0.1, radius: 0.1", "missing key 'slip_speed'"),
        ("slider: piston, coefficient: 0.1", "missing key 'slip_speed'"),
        ("joint: B, bars: [crank, rod], coefficient: 0.1, radius: 0.1, slip_speed: 1", "'B'"),
    ],
)
def test_wrong_entries(entry, found):
    assert found in complaints(f"{ENGINE}  - {{{entry}}}\n")[0]


def test_redundant_constraints_have_no_reaction():
    text = """
joints: {O: [0, 0], D: [0.1, 0], E: [0.2, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.5}
  middle: {joints: [D, M], length: 0.04, mass: 0.5}
  rocker: {joints: [E, B], length: 0.04, mass: 0.5}
  coupler:
    {points: {A: [0, 0], M: [0.1, 0], B: [0.2, 0]}, mass: 1, center: [0.1, 0], inertia: 0.01}
assembly: {A: [0.02, 0.034], B: [0.22, 0.034], M: [0.12, 0.034]}
free: {crank: {angle: 60 deg, speed: 6}}
friction: [{joint: O, coefficient: 0.1, radius: 10 mm, slip_speed: 0.1}]
"""
    with pytest.raises(linkages.InputError, match="rigid bodies do not determine the reaction"):
        linkages.simulate(linkages.loads(text))


@pytest.mark.parametrize(
    ("clearance", "found"),
    [
        ("{joint: A, bar: rod, size: 0.1 mm}", "clearance 'gap' opens 'A'; expected 'friction'"),
        (
            "{joint: B, bar: rod, size: 0.1 mm, contact: restitution, restitution: 0.8}",
            "impacts of 'gap' have impulses, which friction under a reaction does not follow; "
            "expected a 'contact' with a stiffness, such as 'kelvin-voigt' there",
        ),
    ],
)
def test_clearances_that_leave_no_reaction(clearance, found):
    assert found in complaints(f"{ENGINE}{SLIPS['A']}clearances: {{gap: {clearance}}}\n")[0]


def test_beside_a_stop():
    """The remedy that the message names is accepted."""
    stop = "stops: [{slider: piston, upper: 0.5 m, restitution: 0.5}]\n"
    (found,) = complaints(ENGINE + SLIPS["A"] + stop)
    assert "expected 'stiffness' (and 'damping') in place of 'restitution' there" in found
    linkages.loads(ENGINE + SLIPS["A"] + stop.replace("restitution: 0.5", "stiffness: 1e6"))


@pytest.mark.parametrize("contact", ["", ", contact: hertz, stiffness: 2e9"])
def test_beside_a_clearance(contact):
    """Reactions feel links and contacts elsewhere; torque and reaction as Newton and Euler say."""
    gap = f"clearances: {{gap: {{joint: A, bar: rod, size: 0.1 mm{contact}}}}}\n"
    mechanism = linkages.loads(ENGINE + SLIPS["O"] + gap)
    outputs = ["joint_reaction", "torsional_spring_torque", "bar_speed", "energy_residual"]
    data = linkages.simulate(mechanism, end=0.01, samples=11, outputs=outputs).data
    reaction = np.hypot(*data.joint_reaction.sel(joint="O").to_numpy().T)
    slip = np.tanh(data.bar_speed.sel(bar="crank").to_numpy() / 0.1)
    torque = data.torsional_spring_torque.sel(torsional_spring="friction[0]").to_numpy()
    assert torque == pytest.approx(-0.2 * 0.03 * reaction * slip, rel=1e-8)
    assert abs(data.energy_residual.to_numpy()).max() < 1e-8
