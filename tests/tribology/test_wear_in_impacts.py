"""Wear in rigid impacts: the work of the normal impulse along the slip, against closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad
from worn_mechanisms import RADIUS, SIZE, WEIGHT, WIDTH, block, rotor

import linkages
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.contact_episodes import behind, sliding_in_impacts
from linkages.solution.evaluation import evaluate_nodes
from linkages.solution.march import March
from linkages.tribology.worn_joints import BINS

WORK, DISTANCE = "clearance_sliding_work", "clearance_sliding_distance"
LOST = "clearance_friction_dissipation"
RATE = 1e-13

BALL = """
joints: {{O: [0, 0]}}
bars: {{ball: {{joints: [O, P], length: 0.1, mass: 0.25, center: {center}, inertia: 1e-4}}}}
free: {{ball: {{angle: 0.3, speed: {spin}}}}}
clearances:
  gap: {{joint: O, bar: ball, size: 1 mm, rate: [0.1, {across}], pin_radius: 9 mm, width: 10 mm,
        contact: restitution, restitution: 0.5, wear: {{bearing: {{wear_rate: 1e-13}}}}, {law}}}
"""


def ball(law="friction: 0", spin=-5.0, center=0, across=0.0):
    """A ring on a pin of the ground."""
    return linkages.loads(BALL.format(law=law, spin=spin, center=center, across=across))


def end_of(mechanism, end, outputs=(WORK, DISTANCE), **how):
    data = linkages.simulate(mechanism, end=end, samples=11, outputs=[*outputs], **how).data
    return data.isel(time=-1)


def test_one_impact_without_friction():
    """V = k/H |v| P with P = (1 + e) m d′ and v = (R + c) ω; it takes no time, and no way."""
    found = end_of(ball(), 0.0101, (WORK, DISTANCE, "wear_volume")).sel(clearance="gap")
    work = 1.5 * 0.25 * 0.1 * 0.01 * 5.0
    assert float(found[WORK]) == pytest.approx(work, rel=1e-12)
    assert float(found.wear_volume.sel(side="bearing")) == pytest.approx(RATE * work, rel=1e-12)
    assert float(found[DISTANCE]) == 0.0


@pytest.mark.parametrize(("spin", "slips"), [(-5.0, True), (-1.0, False)], ids=["slips", "grips"])
def test_one_impact_with_friction(spin, slips):
    """∫ |v| dP of a slip that falls by μ W_tt P, and ends at 0 within the impact or does not."""
    found = end_of(ball("friction: 0.2", spin), 0.0101).sel(clearance="gap")
    slip, whole = 0.01 * -spin, 1.5 * 0.25 * 0.1
    slows = 0.2 * (1 / 0.25 + 0.01**2 / 1e-4)
    impulse = min(whole, slip / slows)
    assert (impulse == whole) is slips
    work, _ = quad(lambda p: slip - slows * p, 0.0, impulse)
    assert float(found[WORK]) == pytest.approx(work, rel=1e-11)


PUMP = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 0.04, mass: 0.8, center: 0.01}}
  rod: {{joints: [A, B], length: 0.14, mass: 0.5, center: 0.07}}
sliders: {{piston: {{joint: B, through: O, mass: 0.4}}}}
drives: {{crank: {{angle: 0, speed: 600 rpm}}}}
loads: [{{slider: piston, force: {force}}}]
assembly: {{B: [0.18, 0]}}
clearances:
  gap: &gap {{joint: A, bar: rod, size: 0.1 mm, pin_radius: 12 mm, width: 25 mm, restitution: 0.6,
             contact: restitution, friction: 0.1, wear: {{bearing: {{wear_rate: 1e-15}}}}}}
{more}
"""
TWO = (
    "  other: {joint: B, bar: rod, size: 0.1 mm, pin_radius: 12 mm, width: 25 mm, friction: 0.1,\n"
    "          contact: restitution, restitution: 0.6, wear: {bearing: {wear_rate: 1e-15}}}"
)


def pump(force="-200", more="", **values):
    """A slider-crank that knocks."""
    text = PUMP.format(force=force, more=more).replace("&gap ", "")
    return linkages.loads(text).with_values({f"clearances.gap.{k}": v for k, v in values.items()})


@pytest.mark.parametrize(
    ("mechanism", "many"),
    [
        (pump(), 1),
        (pump(impact="poisson"), 1),
        (pump(impact="moreau"), 1),
        (pump('"-100*sin(120*t)"', "friction: [{joint: B, torque: 2}]"), 1),
        (pump(more=TWO), 2),
        (ball("friction: 0.2", -2.0, 0.05, 0.03), 1),
        (ball("friction: 0.2, impact: poisson", -2.0, 0.05, 0.03), 1),
    ],
    ids=["newton", "poisson", "moreau", "dry-friction-that-sticks", "two", "rod", "rod-poisson"],
)
def test_archard_and_coulomb_dissipate_alike(mechanism, many):
    """W = E/μ through impacts, slip and sticking, also where impacts are shared."""
    found = end_of(mechanism, 0.15, (WORK, LOST, "touches"), rtol=1e-9)
    friction = 0.1 if many == 2 or "crank" in mechanism.bodies else 0.2
    assert (found.touches.to_numpy()[:many] > 5).all()
    assert found[WORK].to_numpy() == pytest.approx(found[LOST].to_numpy() / friction, rel=1e-9)
    assert (found[WORK] > 0.0).all()


def test_slip_that_turns_round_within_an_impact_without_a_path():
    """Moreau's law: slip is linear from −v to v⁺, and the energy of friction says nothing of it."""
    mechanism = ball("friction: 0.2, impact: moreau", -2.0, 0.05, 0.03)
    motion = linkages.simulate(mechanism, end=0.15, outputs=[WORK]).motion
    model = motion.pieces[0].system.model
    (contact,) = model.walls.contacts
    turned = 0
    for piece, (work,), (impulse,) in sliding_in_impacts(motion):
        slip = [contact.gap.slip(model.velocities)]
        (first,), (last,) = (evaluate_nodes(p, slip) for p in (piece, behind(piece, contact)))
        for a, b, p, found in zip(first, last, impulse, work, strict=True):
            if a * b < -1e-12:
                mean, _ = quad(lambda x, a=a, b=b: abs(a + x * (b - a)), 0, 1, points=[a / (a - b)])
                assert found == pytest.approx(p * mean, rel=1e-9)
                turned += 1
    assert turned


def test_impacts_of_a_mechanism_without_friction():
    """The mean of slips before and behind each impact, times its impulse."""
    mechanism = pump(friction=0)
    solution = linkages.simulate(mechanism, end=0.1, outputs=[WORK, "clearance_sliding_power"])
    motion = solution.motion
    model = motion.pieces[0].system.model
    (contact,) = model.walls.contacts
    ((piece, (work,), (impulse,)),) = sliding_in_impacts(motion)
    nodes = [contact.gap.slip(model.velocities), contact.speed]
    before, after = evaluate_nodes(piece, nodes), evaluate_nodes(behind(piece, contact), nodes)
    assert len(work) > 3
    assert (before[0] * after[0] > 0.0).all()
    assert work == pytest.approx(impulse * 0.5 * np.abs(before[0] + after[0]), rel=1e-12)
    # what is left is slip while the contact is closed
    found, times = solution.data[WORK][:, 0], solution.data.time
    closed = linkages.measure(solution, "mean(gap.sliding_power)") * float(times[-1])
    assert float(found[-1]) == pytest.approx(work.sum() + closed, rel=1e-6)
    assert (np.diff(found) >= 0.0).all()


def test_a_block_that_bounces_in_its_guide():
    """Corners slip alike: the work of an impact is all impulse times the speed of the block."""
    content = block().definition.content["clearances"]["play"]
    play = {k: v for k, v in content.items() if k not in ("stiffness", "dissipation")}
    play |= {"contact": "restitution", "restitution": 0.5, "offset": 5e-5}
    mechanism = block().with_values({"clearances.play": play})
    motion = linkages.simulate(mechanism, end=0.05, outputs=[WORK], rtol=1e-10).motion
    hits = 0
    for piece, work, impulses in sliding_in_impacts(motion):
        speed = np.abs(0.05 * 20 * np.cos(20 * piece.time))
        # corners also turn about the middle of the block, slower by the size over its length
        assert work.sum(axis=0) == pytest.approx(impulses.sum(axis=0) * speed, rel=1e-3)
        hits += len(piece.time)
    assert hits > 5


LINK = """
gravity: [0, -9.81]
joints: {G: [0, 0]}
sliders: {block: {joint: B, through: G, angle: 0, mass: 0.7}}
bars: {arm: {joints: [B, P], length: 0.2, mass: 0.5, center: 0.1, inertia: 1e-3}}
clearances:
  gap: {joint: B, bar: arm, size: 10 mm, angle: -80 deg, speed: 3, pin_radius: 12 mm, width: 25 mm,
        wear: {bearing: {wear_rate: 1e-15}}}
stops: [{slider: block, upper: 0.05, restitution: 0.6}]
free: {block: {position: 0, speed: 1}, arm: {angle: -100 deg, speed: 8}}
"""


def test_a_massless_link_while_its_slider_hits_a_stop():
    """The impulse of the link is what changes the momentum of the arm, along the link alone."""
    mechanism = linkages.loads(LINK)
    motion = linkages.simulate(mechanism, end=0.3, outputs=[WORK], rtol=1e-10).motion
    model = motion.pieces[0].system.model
    (stop,) = model.walls.contacts
    ((piece, (work,), (impulse,)),) = sliding_in_impacts(motion)
    ends = [model.velocities.joints[name] for name in ("B.gap", "P")]
    turning = [model.velocities.turning(name) for name in ("gap", "arm")]
    nodes = [value for end in ends for value in (end.x, end.y)] + turning
    before, after = evaluate_nodes(piece, nodes), evaluate_nodes(behind(piece, stop), nodes)
    way = evaluate_nodes(piece, [model.positions.angle("gap")])[0]
    change = 0.5 * 0.5 * (after[:2] + after[2:4] - before[:2] - before[2:4])
    along = np.array([np.cos(way), np.sin(way)])
    assert len(work) > 2
    # round-off of momenta of 1 N s
    assert impulse == pytest.approx(-(change * along).sum(axis=0), abs=1e-13)
    assert change == pytest.approx(-impulse * along, abs=1e-13)
    slips = [0.01 * u[4] - 0.022 * u[5] for u in (before, after)]
    same = slips[0] * slips[1] > 0.0
    assert same.any()
    expected = np.abs(impulse) * 0.5 * np.abs(slips[0] + slips[1])
    assert work[same] == pytest.approx(expected[same], rel=1e-9)


def test_a_rotor_that_bounces_and_rests_wears_as_one_that_rests():
    """All impulses together carry its weight: work is m g (R + c) ω t."""
    mechanism = rotor("contact: restitution, restitution: 0.5, offset: [0, -0.05 mm]")
    found = end_of(mechanism, 0.5, (WORK, "touches")).isel(clearance=0)
    assert found.touches.item() > 2
    assert float(found[WORK]) == pytest.approx(WEIGHT * (RADIUS + SIZE) * 200.0 * 0.5, rel=1e-9)


def test_cycle_jumps_of_a_rigid_contact():
    """The bearing grows under a constant load as by a stiff one without an indentation."""
    mechanism = rotor("contact: restitution, restitution: 0.5, offset: [0, -0.1 mm]")
    how = {"revolutions": 10**6, "accuracy": 1e-3, "skip": 0, "rtol": 1e-9, "longest": 32}
    data = linkages.wear(mechanism, **how)
    end = data.isel(jump=-1, clearance=0)

    def bearing(work):
        return math.sqrt((RADIUS + SIZE) ** 2 + RATE * work / (math.pi * WIDTH))

    found = float(end["size"])
    last = math.pi * WIDTH * ((RADIUS + found) ** 2 - (RADIUS + SIZE) ** 2) / RATE
    revolutions, _ = quad(lambda w: 1 / (WEIGHT * 2 * math.pi * bearing(w)), 0, last)
    assert revolutions == pytest.approx(1e6, rel=1e-3)


def test_cycle_jumps_through_impacts():
    """Depth over the angle has all the volume, of impacts as well; half the jumps confirm."""
    data = linkages.wear(pump(), revolutions=10**6, accuracy=0.1, longest=64, confirm=True)
    end, width = data.isel(jump=-1, clearance=0), 2 * math.pi / BINS
    volume = float(end["volume"].sel(side="bearing"))
    depth = float(end["depth"].sel(side="bearing").sum()) * width * 0.0121 * 0.025
    assert depth == pytest.approx(volume, rel=1e-9)
    assert data.attrs["difference"][0] <= float(end["error"])


@pytest.mark.slow
def test_more_impacts_than_are_recorded(monkeypatch):
    """A motion says so; wear computes a few revolutions at once."""
    monkeypatch.setattr("linkages.solvers.trajectory.CAPACITY", 40)
    monkeypatch.setattr("linkages.tribology.steady_work.KEPT", 10)
    with pytest.raises(linkages.ComputationError, match="are recorded; expected a shorter motion"):
        end_of(pump(), 2.0)
    data = linkages.wear(pump(), revolutions=1, accuracy=0.5, longest=32, rtol=1e-6)
    assert data.attrs["ended"] == "revolutions"


def test_a_dip_within_errors_of_steps_opens_no_contact():
    """Errors of a loose tolerance move a journal that is pressed as far as it counts as touching.

    The indentation came back before the time at which it was located, so that neither mode fitted.
    """
    mechanism = pump(restitution=0.6, size=1.66952e-4, friction=0)
    solution = linkages.simulate(mechanism, end=0.06, rtol=1e-3, outputs=["touches"])
    touch = solution.motion.changes["gap: touch"]
    assert solution.time[-1] == 0.06
    assert touch.rises.all()
    assert solution.motion.pieces[-1].held[:2, -1].tolist() == [1.0, 1.0]  # touches and presses


@pytest.mark.parametrize("span", [1e-9, 1e-8, 1e-6, 1e-5, 1e-2])
def test_a_journal_that_closes_as_far_as_it_counts_as_touching(span):
    """What is watched is round-off there for a while: no step is short enough to resolve it.

    A motion of the worn pump after ten million revolutions.
    """
    size = 0.0005256612866556862
    offset = [-0.0004794522206125793, 0.0002155117193431031]
    rates = [-0.011154758705536142, -0.02481616242282695]
    begin = 9.386209542829885
    system = System(pump(size=size)).at(begin, np.array([*offset, *rates]))
    motion = March(system, RunOptions(rtol=1e-10)).advance(np.array([begin + span]))
    assert motion.failure is None
    touch = motion.changes["gap: touch"]
    assert touch.rises[0]
    if span <= 1e-5:
        assert touch.count == 1
        assert np.hypot(*motion.pieces[-1].state[:2, -1]) == pytest.approx(size, rel=2e-7)
