"""Motions with modes, sections and several tangents, side by side and alone: equal in all bits."""

import gc
import re
from functools import partial

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution import many
from linkages.solution.guards import parse_section
from linkages.solution.march import March
from linkages.solution.motion import Motion, Renormalised
from linkages.solvers.lanes import integrate_many
from linkages.solvers.trajectory import ChangeLog

ENGINE = """
joints: {{O: [0, 0]}}
bars:
  crank: {{joints: [O, A], length: 50 mm, mass: 0.3, inertia: 1e-4}}
  rod:   {{joints: [A, B], length: 120 mm, mass: 0.2, inertia: 3e-4}}
sliders: {{piston: {{joint: B, through: O, angle: 0, mass: 0.15}}}}
clearances: {{gap: {{joint: B, bar: rod, size: {size:g} mm, {law}}}}}
drives: {{crank: {{angle: 0, speed: 3000 rpm}}}}
assembly: {{B: [0.17, 0]}}
"""
PENDULUM = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: 0.1, mass: 0.5, center: 0.05, inertia: 4e-4}}}}
free: {{arm: {{angle: -40 deg}}}}
clearances:
  gap: {{joint: O, bar: arm, size: {size:g} mm, contact: kelvin-voigt, stiffness: 1e6, damping: 200,
        pin_radius: 9 mm, offset: [0, -{size:g} mm], {law}}}
"""
ARM = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars: {{arm: {{joints: [O, P], length: {size:g}, mass: 1.2}}}}
free: {{arm: {{angle: 60 deg, speed: 0}}}}
stops: [{{bars: [ground, arm], lower: -30 deg, upper: 90 deg, {law}}}]
"""
GAPS, LENGTHS = (0.1, 0.2, 0.3, 0.4, 0.5), (0.4, 0.5, 0.6, 0.7, 0.8)
STICKY = "friction_law: coulomb, friction: 0.2"
HERTZ = "contact: hunt-crossley-constant, stiffness: 2e9"
PINS = "pin_radius: 8 mm, friction_law: coulomb, friction: 0.05"
CASES = {
    "damped": (ENGINE, GAPS, f"{HERTZ}, dissipation: 1.5", 0.04),
    "remembering": (
        ENGINE, GAPS,
        "contact: lankarani-nikravesh, stiffness: 2e9, restitution: 0.8, least_rate: 1 mm/s", 0.04,
    ),
    "rubbing": (
        ENGINE, GAPS,
        f"{HERTZ}, dissipation: 1.5, {PINS}", 0.04,
    ),
    "rigid": (ENGINE, GAPS, "contact: restitution, restitution: 0.6", 0.04),
    "sticking": (PENDULUM, GAPS, f"{STICKY}, static: 0.3, stribeck_speed: 5 mm/s", 0.5),
    "stopped": (ARM, LENGTHS, "restitution: 0.6", 2.0),
}  # fmt: skip


def marches(text, sizes, law, tangents, counting=False):
    systems = [System(linkages.loads(text.format(size=size, law=law))) for size in sizes]
    run = RunOptions(rtol=1e-8)
    return [March(system, run, tangents=tangents, counting=counting) for system in systems]


def require_equal(found, alone):
    """Whether two motions are equal in everything."""
    assert isinstance(found, Motion), found
    assert (found.failure, found.stop_time, found.cost) == (
        alone.failure, alone.stop_time, alone.cost,
    )  # fmt: skip
    for one, other in zip(found.pieces, alone.pieces, strict=True):
        for name in ("time", "state", "turns", "acceleration", "held"):
            assert np.array_equal(getattr(one, name), getattr(other, name)), name
        for name, angles in one.counted.items():
            assert np.array_equal(angles, other.counted[name])
    for name, changed in found.changes.items():
        assert changed.count == alone.changes[name].count
        for one, other in zip(changed.pieces, alone.changes[name].pieces, strict=True):
            assert np.array_equal(one.time, other.time)
            assert np.array_equal(one.state, other.state)


def require_same(text, sizes, law, times, *, tangents=0, section=None, counting=False):
    """Motions alone, in company, and fewer of them in another order; returns those alone."""
    guards = []
    if section is not None:
        guards = [parse_section(marches(text, sizes[:1], law, 0)[0].system, section).guard(0)]

    def moved(chosen, together):
        own = marches(text, [sizes[k] for k in chosen], law, tangents, counting)
        grown = [Renormalised() for _ in chosen] if tangents else None
        if together:
            found = many.march_many(own, times, guards=guards, renormalised=grown)
        else:
            each = grown or [None for _ in chosen]
            found = [
                march.advance(times, guards=guards, renormalised=own)
                for march, own in zip(own, each, strict=True)
            ]
        return found, grown

    alone, expected = moved(range(len(sizes)), False)
    for order in ([0, 1, 2, 3, 4], [4, 1, 3]):
        found, grown = moved(order, True)
        for place, (k, motion) in enumerate(zip(order, found, strict=True)):
            require_equal(motion, alone[k])
            if tangents:
                assert np.array_equal(grown[place].lengths, expected[k].lengths)
                assert np.array_equal(grown[place].tangents, expected[k].tangents)
            if guards:
                one, other = (m.crossings[guards[0].name] for m in (motion, alone[k]))
                assert np.array_equal(one.time, other.time)
                assert np.array_equal(one.state, other.state)
    return alone


@pytest.mark.slow_except("damped-8", "remembering-4", "rigid-4")
@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("case", CASES)
def test_modes_change_as_they_do_alone(case, lanes, monkeypatch):
    monkeypatch.setattr(many, "integrate_many", partial(integrate_many, lanes=lanes))
    text, sizes, law, end = CASES[case]
    alone = require_same(text, sizes, law, np.linspace(0.0, end, 12)[1:])
    assert max(sum(c.count for c in motion.changes.values()) for motion in alone) > 2


@pytest.mark.slow_except("1-stopped")
@pytest.mark.parametrize("case", ["damped", "rigid", "stopped"])
@pytest.mark.parametrize("tangents", [1, 2])
def test_tangents_cross_changes_as_they_do_alone(case, tangents):
    text, sizes, law, end = CASES[case]
    require_same(text, sizes, law, np.linspace(0.0, end, 12)[1:], tangents=tangents)


@pytest.mark.slow_except("False-rigid-*")
@pytest.mark.parametrize(
    ("case", "section"),
    [("damped", "gap.touch"), ("rigid", "gap.touch"), ("stopped", "arm.angle=-0.4")],
)
@pytest.mark.parametrize("counting", [False, True])
def test_sections_are_crossed_as_they_are_alone(case, section, counting):
    """Also where turns of dependent angles are counted."""
    text, sizes, law, end = CASES[case]
    times = np.linspace(0.0, end, 12)[1:]
    alone = require_same(text, sizes, law, times, section=section, counting=counting)
    assert max(len(m.crossings[next(iter(m.crossings))].time) for m in alone) > 1


def test_orthogonal_tangents_of_smooth_motions():
    text = """
gravity: [0, -9.81]
joints: {{O: [0, 0]}}
bars:
  upper: {{joints: [O, P], length: {size:g}, mass: 1}}
  lower: {{joints: [P, Q], length: 0.5, mass: {law}}}
free: {{upper: {{angle: 100 deg}}, lower: {{angle: 20 deg}}}}
"""
    alone = require_same(
        text, LENGTHS, "1", np.linspace(0.0, 4.0, 9)[1:], tangents=4, section="upper.angle=0"
    )
    assert all(motion.crossings[next(iter(motion.crossings))].time.size for motion in alone)


@pytest.mark.parametrize("tangents", [0, 1])
@pytest.mark.parametrize("case", ["damped", "rigid"])
def test_samples_of_motions_that_are_watched_are_taken_in_lanes(case, tangents, caplog):
    """Every step has samples here; few have a contact that closes or opens."""
    text, sizes, law, end = CASES[case]
    own = marches(text, sizes, law, tangents)
    grown = [Renormalised() for _ in own] if tangents else None
    caplog.set_level("INFO", logger="linkages.solvers.lanes")
    motions = many.march_many(own, np.linspace(0.0, end, 2000)[1:], renormalised=grown)
    (message,) = caplog.messages
    made, alone = (int(re.search(rf"(\d+) steps {w}", message)[1]) for w in ("tried", "alone"))
    changes = sum(changed.count for motion in motions for changed in motion.changes.values())
    assert alone <= 4 * changes + 10 < 0.1 * made, (message, changes)


def test_steps_behind_impacts_stay_in_lanes(caplog):
    """Only those with an impact, and the few whose trial was rejected, are finished alone."""
    text, sizes, law, end = CASES["stopped"]
    caplog.set_level("INFO", logger="linkages.solvers.lanes")
    motions = many.march_many(marches(text, sizes, law, 0), np.array([0.0, end]))
    impacts = sum(changed.count for motion in motions for changed in motion.changes.values())
    finished = sum(int(re.search(r"(\d+) steps alone", each)[1]) for each in caplog.messages)
    assert impacts <= finished < 1.3 * impacts


def test_memory_of_motions_is_freed_without_the_collector():
    """Records of changes have many rows: a chain of motions must not pile them up."""
    text, sizes, law, end = CASES["damped"]
    own = marches(text, sizes, law, 0)
    gc.collect()
    gc.disable()
    try:
        motions = many.march_many(own, np.array([0.0, end]))
        motions.append(own[0].advance(np.array([end, 2 * end])))
        del motions, own
        left = sum(isinstance(each, ChangeLog) for each in gc.get_objects())
    finally:
        gc.enable()
    assert left == 0
