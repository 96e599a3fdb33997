"""Sections, exponents and sweeps of motions whose modes change."""

import math

import numpy as np
import pytest
from scipy.linalg import expm
from switched_blocks import (
    block,
    floor,
    forced_impacts,
    forced_wall,
    forces_by_nodes,
    remembering_floor,
)

import linkages
from linkages.chaos.continuation import end_of
from linkages.chaos.volume_contraction import Volumes
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.march import March

GAP = 0.01


@pytest.fixture(autouse=True)
def _forces():
    with forces_by_nodes():
        yield


@pytest.fixture(scope="module")
def impacting():
    """One impact in each period of 0.5 s."""
    return block(forced_impacts, 0.0, 0.0, "2*sin(4*pi*t)")


def test_exponents_across_impacts(impacting):
    """Multipliers of the periodic motion are eigenvalues of exp(A T) S, with S of its impact."""
    march = March(System(impacting), RunOptions(rtol=1e-12))
    motion = march.advance(np.array([50.0]))
    (piece,) = motion.changes["wall: impact"].pieces
    time, speed = piece.time[-1], piece.state[1, -1]
    assert np.diff(piece.time[-5:]) == pytest.approx(0.5, abs=1e-8)
    outside, e = 2 * math.sin(4 * math.pi * time), 0.7
    before, behind = (-100 * GAP - 0.5 * v + outside for v in (speed, -e * speed))
    across = np.array([[-e, 0.0], [(behind + e * before) / speed, -e]])
    free = np.array([[0.0, 1.0], [-100.0, -0.5]])
    multipliers = np.abs(np.linalg.eigvals(expm(0.5 * free) @ across))
    found = linkages.lyapunov(impacting, skip=100, periods=400)
    # mean of 400 periods: transients of tangents, of ln 10 or so, are divided by 200 s
    expected = np.sort(np.log(multipliers) / 0.5)[::-1]
    assert found.exponent.to_numpy() == pytest.approx(expected, abs=0.02)
    assert not found.sizes.get("invariant")  # impacts shrink volumes beside what loads say


def test_section_at_touches():
    mechanism = block(forced_wall, 0.0, 0.0, "4*sin(2*pi*t)")
    (name,) = System(mechanism).topology.free
    points = linkages.poincare(
        mechanism, section=f"{name}.position={GAP}", direction="up", skip=6, periods=6, rtol=1e-11
    )
    motion = March(System(mechanism), RunOptions(rtol=1e-11)).advance(np.array([10.0]))
    touches = motion.changes["wall: touch"]
    expected = touches.time[touches.rises][6:12]
    assert points.time.to_numpy() == pytest.approx(expected, abs=1e-9)
    assert points.slider_position.to_numpy() == pytest.approx(GAP, abs=1e-14)


def test_sweep_carries_modes(impacting):
    """At nearly equal values a sweep goes on where it was, on the periodic motion."""
    (name,) = System(impacting).topology.free
    found = linkages.bifurcation(
        impacting, vary=f"sliders.{name}.mass=1:1.000001:2", skip=100, periods=3
    )
    one = linkages.poincare(impacting, skip=100, periods=3).slider_velocity.to_numpy()
    assert found.slider_velocity.size == 6
    assert found.slider_velocity.to_numpy() == pytest.approx(one[0, 0], abs=1e-6)


def test_ends_carry_what_is_remembered():
    mechanism = block(remembering_floor, 1.0, 0.3)
    system = System(mechanism)
    motion = March(system, RunOptions(rtol=1e-11)).advance(np.array([0.487]))
    end = end_of(system, motion)
    assert end.held["mode floor: touch"] == 1.0
    # v² = v₀² + 2 g h at the touch
    assert end.held["memory floor: touch"] == pytest.approx(math.sqrt(0.09 + 2 * 9.81), rel=1e-9)
    names = system.model.switches.names
    assert end.system(mechanism).held == pytest.approx([end.held[name] for name in names])


def test_what_volumes_say():
    bouncing = Volumes(System(block(floor, 1.0, 0.0)))
    assert bouncing.autonomous
    assert bouncing.conservative
    assert bouncing.told
    forced = Volumes(System(block(forced_impacts, 0.0, 0.0, "2*sin(4*pi*t)")))
    assert not forced.autonomous
    assert not forced.conservative
    assert not forced.told
    # a damper that acts while the block touches
    damped = Volumes(System(block(forced_wall, 0.0, 0.0, "4*sin(2*pi*t)")))
    assert not damped.told
    assert not damped.conservative
