"""Points that drives move, and actuators that make the motion: against closed forms, and forwards.

A motion found backwards is made forwards again, by tables of the angles that were found. Their
splines over 400 samples differ from the motion by about 1e-6 of its size, away from the ends.
"""

import json

import numpy as np
import pytest

import linkages
from linkages.equations import derive
from linkages.errors import InputError
from linkages.topology.topology import build_topology

RADIUS, OMEGA = 0.1, 2 * np.pi
ARM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  upper: {joints: [O, A], length: 0.4, mass: 2}
  fore: {joints: [A, P], length: 0.3, mass: 1}
"""
CIRCLE = "P: {x: 0.4 + 0.1*cos(2*pi*t), y: 0.2 + 0.1*sin(2*pi*t)}"
MOTORS = "actuators: {shoulder: {bar: upper}, elbow: {bars: [upper, fore]}}\n"
INVERSE = f"{ARM}drives: {{{CIRCLE}}}\n{MOTORS}assembly: {{A: left}}\nsimulate: {{samples: 401}}\n"


def textbook(t):
    """Angles, speeds, accelerations and torques of the arm, each (samples, 2).

    Inverse kinematics and dynamics of a planar arm of two links: J. J. Craig, Introduction to
    Robotics, 3rd ed., sections 4.4, 5.6 and 6.7.
    """
    l1, l2, m1, m2, g = 0.4, 0.3, 2.0, 1.0, 9.81
    i1, i2, r1, r2 = m1 * l1**2 / 12, m2 * l2**2 / 12, l1 / 2, l2 / 2
    turn = OMEGA * t
    x, y = 0.4 + RADIUS * np.cos(turn), 0.2 + RADIUS * np.sin(turn)
    v = RADIUS * OMEGA * np.array([-np.sin(turn), np.cos(turn)]).T
    a = -RADIUS * OMEGA**2 * np.array([np.cos(turn), np.sin(turn)]).T
    q2 = -np.arccos((x * x + y * y - l1 * l1 - l2 * l2) / (2 * l1 * l2))
    q1 = np.arctan2(y, x) - np.arctan2(l2 * np.sin(q2), l1 + l2 * np.cos(q2))
    both = q1 + q2

    def jacobian(first, last):
        return np.array([[first[0] + last[0], last[0]], [first[1] + last[1], last[1]]])

    first = np.array([-l1 * np.sin(q1), l1 * np.cos(q1)])
    last = np.array([-l2 * np.sin(both), l2 * np.cos(both)])
    j = jacobian(first, last).transpose(2, 0, 1)
    rates = np.linalg.solve(j, v[..., None])[..., 0]
    w1, w12 = rates[:, 0], rates.sum(axis=1)
    pull1 = -l1 * w1 * np.array([np.cos(q1), np.sin(q1)])
    pull2 = -l2 * w12 * np.array([np.cos(both), np.sin(both)])
    turned = jacobian(pull1, pull2).transpose(2, 0, 1)
    bias = (turned @ rates[..., None])[..., 0]
    accelerations = np.linalg.solve(j, (a - bias)[..., None])[..., 0]
    m11 = m1 * r1**2 + i1 + m2 * (l1**2 + r2**2 + 2 * l1 * r2 * np.cos(q2)) + i2
    m12 = m2 * (r2**2 + l1 * r2 * np.cos(q2)) + i2
    h = m2 * l1 * r2 * np.sin(q2)
    own, other = rates.T
    weight2 = m2 * g * r2 * np.cos(both)
    weight1 = (m1 * r1 + m2 * l1) * g * np.cos(q1) + weight2
    a1, a2 = accelerations.T
    torque1 = m11 * a1 + m12 * a2 - h * (2 * own * other + other**2) + weight1
    torque2 = m12 * a1 + (m2 * r2**2 + i2) * a2 + h * own**2 + weight2
    return np.array([q1, q2]).T, rates, accelerations, np.array([torque1, torque2]).T


def test_an_arm_follows_a_circle_as_textbooks_say():
    data = linkages.simulate(linkages.loads(INVERSE)).data
    angles, speeds, accelerations, torques = textbook(data.time.values)
    # round-off of a dozen operations on numbers of this size
    assert np.abs(data.rotary_actuator_angle.values - angles).max() < 1e-14
    assert np.abs(data.rotary_actuator_speed.values - speeds).max() < 1e-13
    assert np.abs(data.rotary_actuator_acceleration.values - accelerations).max() < 1e-12
    assert np.abs(data.drive_effort.values - torques).max() < 1e-12
    assert np.abs(data.actuator_power.values - torques * speeds).max() < 1e-11
    assert [*data.drive.values] == ["shoulder", "elbow"]
    # the sine of the angle between the ways in which each actuator alone moves: with the other
    # at rest the tip moves across its distance from O, or from A
    tip = data.joint_position.sel(joint="P").values
    elbow = data.joint_position.sel(joint="A").values
    sides = tip, tip - elbow
    cross = sides[0][:, 0] * sides[1][:, 1] - sides[0][:, 1] * sides[1][:, 0]
    sine = cross / np.prod([np.hypot(*side.T) for side in sides], axis=0)
    assert np.abs(data.dexterity.values[:, 0] - sine).max() < 1e-14


def test_reactions_carry_weights_and_inertia():
    """Torques between bodies add no force: that of the ground is all that moves the arm."""
    made = linkages.loads(INVERSE)
    data = linkages.simulate(made, outputs=["joint_reaction", "shaking_force"]).data
    weight = np.array([0.0, 3.0 * 9.81])
    expected = weight - data.shaking_force.values[:, 0]
    assert np.abs(data.joint_reaction.sel(joint="O").values - expected).max() < 1e-12
    assert "pin_reaction" not in data


def table(data, name):
    rows = data.rotary_actuator_angle.sel(rotary_actuator=name).values
    return {"law": {"table": {"times": data.time.values.tolist(), "values": rows.tolist()}}}


FIVE_BAR = """
gravity: [0, -9.81]
joints: {O: [0, 0], D: [0.6, 0]}
bars:
  crank1: {joints: [O, A], length: 0.2, mass: 0.2}
  arm1:   {joints: [A, B], length: 0.45, mass: 0.6}
  arm2:   {joints: [C, B], length: 0.45, mass: 0.6}
  crank2: {joints: [D, C], length: 0.2, mass: 0.2}
loads: [{joint: B, force: [3, -2]}]
MORE
simulate: {end: 2, samples: 401}
"""
RUBBING = "friction: [{joint: A, coefficient: 0.2, radius: 20 mm, slip_speed: 0.01}]\n"
CRANKS = "actuators: {left: {bar: crank1}, right: {bar: crank2}}\nassembly: {A: left, C: right}\n"
MIDDLE = slice(10, -10)
"""Natural splines have no curvature at their ends."""


@pytest.mark.parametrize("more", ["", RUBBING],
                         ids=["smooth", "rubbing"])  # fmt: skip
@pytest.mark.parametrize(
    "drive",
    [
        "{x: 0.3 + 0.05*cos(3*t), y: 0.4 + 0.05*sin(3*t)}",
        "{waypoints: [[0.2, 0.35], [0.3, 0.3], [0.4, 0.4]], closed: true, progress: 0.5*t}",
    ],
    ids=["laws", "path"],
)
def test_what_is_found_backwards_goes_forwards(drive, more):
    frame = FIVE_BAR.replace("MORE", more)
    wanted = ["drive_effort", "joint_position", "joint_reaction", "rotary_actuator_angle",
              "mechanical_advantage"]  # fmt: skip
    back = linkages.simulate(
        linkages.loads(f"{frame}drives: {{B: {drive}}}\n{CRANKS}"), outputs=wanted
    ).data
    tables = {"crank1": table(back, "left"), "crank2": table(back, "right")}
    made = linkages.loads(f"{frame}drives: {json.dumps(tables)}\nassembly: {{B: left}}\n")
    forward = linkages.simulate(made, outputs=["drive_effort", "joint_position", "joint_reaction",
                                               "mechanical_advantage"]).data  # fmt: skip
    apart = np.abs(forward.joint_position.values - back.joint_position.values)
    assert apart[MIDDLE].max() < 1e-6
    for name in ("drive_effort", "joint_reaction"):
        one, other = back[name].values[MIDDLE], forward[name].values[MIDDLE]
        # friction is 4e-3 of the torques; the third derivatives of a path jump at its points
        assert np.abs(one - other).max() < (1e-5 if "x:" in drive else 1e-3) * np.abs(one).max()
    one, other = (d.mechanical_advantage.values[MIDDLE] for d in (back, forward))
    sound = np.isfinite(one) & np.isfinite(other) & (np.abs(one) < 1e3)
    assert sound.sum() > 1000
    assert np.abs(one[sound] / other[sound] - 1.0).max() < 1e-4


def test_a_wrist_turns_the_hand_as_it_should():
    """Motors between bodies, against motors between each body and the ground."""
    text = f"""
{ARM.replace("P]", "W]")}  hand: {{joints: [W, P], length: 0.1, mass: 0.3}}
MORE
assembly: {{A: left}}
simulate: {{samples: 401}}
"""
    motors = MOTORS.replace("}}", "}, wrist: {bars: [fore, hand]}}")
    path = "{waypoints: [[0.3, 0.2], [0.5, 0.2]], progress: {rise: polynomial, to: 1, duration: 1}}"
    drives = f"drives: {{P: {path}, hand: {{law: -0.5*t + 0.2*sin(3*t)}}}}\n"
    back = linkages.simulate(linkages.loads(text.replace("MORE", drives + motors))).data
    angles = back.rotary_actuator_angle.values
    assert np.abs(np.cumsum(angles, axis=1) - back.bar_angle.values).max() < 1e-14
    assert np.abs(back.joint_position.sel(joint="P", axis="y").values - 0.2).max() < 1e-15
    times = back.time.values.tolist()
    tables = {
        name: {
            "law": {
                "table": {"times": times, "values": back.bar_angle.sel(bar=name).values.tolist()}
            }
        }
        for name in ("upper", "fore", "hand")
    }
    made = linkages.loads(text.replace("MORE", f"drives: {json.dumps(tables)}").replace(
        "assembly: {A: left}", ""))  # fmt: skip
    forward = linkages.simulate(made, outputs=["drive_effort"]).data.drive_effort
    shoulder, elbow, wrist = back.drive_effort.values.T
    expected = np.array([shoulder - elbow, elbow - wrist, wrist]).T
    apart = np.abs(forward.sel(drive=["upper", "fore", "hand"]).values - expected)[MIDDLE]
    assert apart.max() < 1e-3 * np.abs(expected).max()


EXCAVATOR = """
gravity: [0, -9.81]
joints: {O: [0, 0], F: [0.2, -0.3]}
bars:
  boom: {points: {O: [0,0], A: [2,0], K: [0.8, 0.1], L: [1.2, 0.3]}, mass: 50, center: [1, 0],
         inertia: 17}
  stick: {points: {A: [0, 0], M: [-0.3, 0.1], P: [1.2, 0]}, mass: 25, center: [0.6, 0], inertia: 3}
drives: {P: {x: 2 + 0.3*sin(t), y: -0.5 + 0.2*cos(t)}}
assembly: {A: left}
simulate: {end: 2, samples: 401}
"""


def test_forces_of_cylinders_leave_nothing_to_do_at_the_point():
    """As loads in the place of actuators they make the motion: the drive of the point is idle."""
    cylinders = "actuators: {lift: {between: [F, K]}, crowd: {between: [L, M]}}\n"
    found = linkages.simulate(linkages.loads(EXCAVATOR + cylinders)).data
    times = found.time.values.tolist()
    loads = [
        {"between": ends, "force": {"table": {"times": times, "interpolation": "spline",
         "values": found.drive_effort.sel(drive=name).values.tolist()}}}
        for name, ends in (("lift", ["F", "K"]), ("crowd", ["L", "M"]))
    ]  # fmt: skip
    idle = linkages.simulate(linkages.loads(f"{EXCAVATOR}loads: {json.dumps(loads)}\n")).data
    # at samples the tables have the very forces: what is left is round-off of 3 kN
    assert np.abs(idle.drive_effort.values).max() < 1e-10
    assert [*idle.drive.values] == ["P.x", "P.y"]
    places = found.joint_position
    lengths = np.linalg.norm(places.sel(joint="K").values - places.sel(joint="F").values, axis=1)
    assert np.abs(found.linear_actuator_position.values[:, 0] - lengths).max() < 1e-14
    power = (found.drive_effort.values * found.linear_actuator_velocity.values).sum(axis=1)
    assert np.abs(found.actuator_power.values.sum(axis=1) - power).max() < 1e-10


def test_a_drive_of_a_point_without_actuators_pushes_there():
    """A mass on a massless arm: the force at its point is m (a − g), whatever the arm does."""
    made = linkages.loads("""
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 0.4}, fore: {joints: [A, P], length: 0.3}}
masses: {P: 2}
drives: {P: {x: 0.4 + 0.1*cos(3*t), y: 0.2*t}}
assembly: {A: left}
""")
    data = linkages.simulate(made).data
    t = data.time.values
    expected = np.array([-2 * 0.1 * 9 * np.cos(3 * t), np.full_like(t, 2 * 9.81)]).T
    assert np.abs(data.drive_effort.values - expected).max() < 1e-13


def test_a_height_alone_moves_a_four_bar():
    """One law for one coordinate: the other one follows, and so does the crank."""
    made = linkages.loads("""
joints: {O: [0, 0], D: [0.4, 0]}
bars:
  crank: {joints: [O, A], length: 0.1, mass: 0.5}
  coupler: {points: {A: [0, 0], B: [0.35, 0], P: [0.2, 0.1]}, mass: 1, center: [0.17, 0.03],
            inertia: 0.01}
  rocker: {joints: [D, B], length: 0.25, mass: 0.6}
drives: {P: {y: 0.22 + 0.01*sin(5*t)}}
actuators: {motor: {bar: crank}}
assembly: {A: [0.05, 0.09], B: [0.35, 0.25]}
""")
    wanted = ["joint_position", "actuator_power", "kinetic_energy", "energy_residual"]
    data = linkages.simulate(made, outputs=wanted).data
    height = 0.22 + 0.01 * np.sin(5 * data.time.values)
    # a group without a closed form is integrated, and closed by Newton's method to round-off
    assert np.abs(data.joint_position.sel(joint="P", axis="y").values - height).max() < 1e-14
    change = np.gradient(data.kinetic_energy.values, data.time.values, edge_order=2)
    power = data.actuator_power.values[:, 0]
    # differences over a thousandth of a second
    assert np.abs(change - power)[1:-1].max() < 1e-3 * np.abs(power).max()


def test_a_place_where_actuators_cannot_hold_is_noted():
    """Both arms of length 0.45 m on cranks apart by 0.6 m: in line when the point is between them.

    The way of 0.42 m is done at an even speed, and the line is reached after 0.4 m of it.
    """
    text = FIVE_BAR.replace("MORE", "").replace("end: 2", "end: 1")
    drive = "drives: {B: {waypoints: [[0.3, 0.4], [0.3, -0.02]], progress: t}}\n"
    solution = linkages.simulate(linkages.loads(text + drive + CRANKS))
    (note,) = [note for note in solution.notes if "actuators" in note]
    assert note.startswith(f"at t = {0.4 / 0.42:.9g} s the actuators cannot hold")
    assert solution.completed
    before, after = solution.data.dexterity.values[[0, -1], 0]
    assert before > 0.5
    assert after < 0.0


def test_a_motion_ends_where_the_point_is_out_of_reach():
    made = linkages.loads(INVERSE.replace("0.4 + 0.1*cos(2*pi*t)", "0.6 + 0.2*t").replace(
        "0.2 + 0.1*sin(2*pi*t)", "0"))  # fmt: skip
    solution = linkages.simulate(made, throw=False)
    assert solution.motion.stop_time == pytest.approx(0.5, abs=1e-12)  # 0.7 m, the arm's length


ROPE = INVERSE.replace(
    "  fore:", "  rope: {joints: [P, Q], length: 0.3, mass: 0.2}\n  fore:"
).replace("assembly", "free: {rope: {angle: -90 deg}}\nassembly")


def test_what_hangs_on_the_point_swings_as_on_any_moving_pivot():
    """θ″ of a rod on a pivot: ((g − a) × l/2)·m over its inertia about the pivot."""
    wanted = ["bar_angle", "bar_acceleration", "energy_residual", "drive_effort", "joint_reaction"]
    data = linkages.simulate(linkages.loads(ROPE), outputs=wanted).data
    t, angle = data.time.values, data.bar_angle.sel(bar="rope").values
    ax, ay = -RADIUS * OMEGA**2 * np.array([np.cos(OMEGA * t), np.sin(OMEGA * t)])
    expected = 1.5 / 0.3 * (-np.cos(angle) * (9.81 + ay) + np.sin(angle) * ax)
    assert np.abs(data.bar_acceleration.sel(bar="rope").values - expected).max() < 1e-11
    # of 0.5 J, at a tolerance of 1e-10
    assert np.abs(data.energy_residual.values).max() < 1e-8
    # the motors have the rope to carry: its pull at P, by Newton's law for it alone
    pull = data.joint_reaction.sel(joint="P").values
    bare = linkages.simulate(linkages.loads(INVERSE)).data
    more = data.drive_effort.values - bare.drive_effort.values
    tip, elbow = (bare.joint_position.sel(joint=j).values for j in "PA")
    moments = [arm[:, 0] * pull[:, 1] - arm[:, 1] * pull[:, 0] for arm in (tip, tip - elbow)]
    assert np.abs(np.abs(more) - np.abs(np.array(moments).T)).max() < 1e-11


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        (", elbow: {bars: [upper, fore]}", "", "found 1 for 2 driven coordinates (P.x, P.y)"),
        ("assembly", "clearances: {r: {joint: A, bar: fore, size: 0.1 mm}}\nassembly",
         "actuators.shoulder: moves with the free coordinate 'r'"),
        ("{bars: [upper, fore]}", "{bars: [fore, upper]}, x: {bar: fore}",
         "found 3 for 2 driven coordinates"),
        ("{bars: [upper, fore]}", "{bars: [ground, upper]}",
         "actuators: cannot hold P.x, P.y at t = 0 s"),
        ("0.4 + 0.1", "0.9 + 0.1", "cannot meet at A"),
    ],
)  # fmt: skip
def test_refused(old, new, found):
    text = INVERSE.replace(old, new)
    assert text != INVERSE
    with pytest.raises(InputError, match="problem") as caught:
        linkages.simulate(linkages.loads(text))
    assert any(found in str(problem) for problem in caught.value.problems)


@pytest.mark.parametrize("asked", ["equilibrium", "linear equations"])
def test_positions_of_rest_are_refused(asked):
    with pytest.raises(InputError) as caught:
        linkages.equilibrium(linkages.loads(ROPE), moving=asked != "equilibrium")
    assert "not searched for with drives of points or actuators" in str(caught.value.problems[0])


def test_sensitivities_are_differences():
    made = linkages.loads(INVERSE)
    path, step = "bars.fore.length", 1e-6
    found = linkages.sensitivities(made, "drive_effort", [path]).drive_effort.values[..., 0]
    ends = [
        linkages.simulate(made.with_values({path: 0.3 + s}), outputs=["drive_effort"]).data
        for s in (step, -step)
    ]
    difference = (ends[0].drive_effort.values - ends[1].drive_effort.values) / (2 * step)
    # step² times a third derivative, and round-off over the step
    assert np.abs(found - difference).max() < 1e-7 * np.abs(difference).max()


@pytest.mark.parametrize("path", ["drives.P.waypoints.0.1", "drives.P.progress.duration"])
def test_a_curve_has_no_derivative_by_its_own_numbers(path):
    drive = (
        "P: {waypoints: [[0.3, 0.2], [0.5, 0.2]], progress: {rise: cycloidal, to: 1, duration: 1}}"
    )
    made = linkages.loads(INVERSE.replace(CIRCLE, drive))
    with pytest.raises(InputError) as caught:
        linkages.sensitivities(made, "drive_effort", [path])
    assert "no derivative is known" in str(caught.value.problems[0])


def test_symbolic_forces_are_those_of_the_motors():
    """By virtual work: the shoulder turns the upper arm, the elbow both against each other."""
    found = derive(build_topology(linkages.loads(INVERSE)))
    q, work = found.symbols.coordinates, found.forces
    shoulder, elbow = found.efforts.values()
    assert work[q["upper"]] == shoulder - elbow
    assert work[q["fore"]] == elbow
    assert q["P.x"] not in work
