"""Orbits and equilibria without contact: pendulums, oscillators, a truss."""

import json

import numpy as np
import pytest
from orbit_mechanisms import REFERENCE, driven_pendulum, pendulum, points, slider, truss
from scipy.special import ellipk

import linkages
from linkages.errors import ComputationError
from linkages.options.option import OptionError
from linkages.orbits.follow import follow
from linkages.orbits.orbit import orbit


def test_pendulum_loses_its_symmetry_and_doubles_its_period():
    """First doubling with 30 digits; both asymmetric orbits double at the same torque."""
    data = follow(
        driven_pendulum(), {"parameters.g": (1.0, 1.07)}, switch=True, longest=2, points=80
    )
    known = float(REFERENCE["driven_pendulum"]["doubling_of_period_1"]["g"])
    assert points(data, "period doubling") == pytest.approx([known, known], rel=1e-10)
    (broken,) = points(data, "symmetry breaking")
    assert broken == pytest.approx(1.00431948, abs=1e-8)
    branches = json.loads(data.attrs["branches"])
    assert [branch["periods"] for branch in branches].count(2) == 2
    assert [branch["parent"] for branch in branches].count("SB1") == 2


def test_doubled_orbit_takes_over_the_stability():
    data = follow(
        driven_pendulum(), {"parameters.g": (1.06, 1.07)}, switch=True, longest=2, points=40
    )
    value, stable = data["value"].to_numpy()[:, 0], data["stable"].to_numpy() == 1
    known = float(REFERENCE["driven_pendulum"]["doubling_of_period_1"]["g"])
    single = np.isclose(data["period"], 3 * np.pi) & (data.kind == "")
    twice = np.isclose(data["period"], 6 * np.pi) & (data.kind == "")
    assert (stable[single] == (value[single] < known)).all()
    assert twice.any()
    assert stable[twice].all()


def test_limit_cycle_begins_at_a_hopf_point():
    """Van der Pol: Hopf point at μ = 0, amplitude 2√μ and period 2π(1 + μ²/16) for small μ."""
    force = "-mass.position + mu*mass.velocity - mass.position**2*mass.velocity"
    data = follow(
        slider(force, "mu: -0.5"), {"parameters.mu": (-1.0, 0.3)}, switch=True, points=120
    )
    assert points(data, "hopf") == pytest.approx([0.0], abs=1e-12)
    mu, period = data["value"].to_numpy()[:, 0], data["period"].to_numpy()
    cycle = np.isfinite(period) & (mu < 0.1)
    assert cycle.sum() > 5
    np.testing.assert_allclose(period[cycle], 2 * np.pi * (1 + mu[cycle] ** 2 / 16), rtol=2e-4)
    assert (data["stable"].to_numpy()[cycle & (data.kind == "").to_numpy()] == 1).all()


def test_torus_and_resonances():
    """Neimark–Sacker locus of a forced oscillator: the determinant is one along all of it."""
    force = "-mass.position + 0.3*mass.velocity*(1 - mass.position**2) + F*cos(w*t)"
    mechanism = slider(force, "F: 2.0, w: 1.2")
    data = follow(
        mechanism,
        {"parameters.F": (0.1, 3.0)},
        locus="NS1",
        other={"parameters.w": (0.8, 2.0)},
        points=60,
    )
    spectrum = data["spectrum"].to_numpy() @ [1, 1j]
    np.testing.assert_allclose(np.prod(spectrum, axis=1), 1.0, rtol=1e-9)
    kinds = {str(kind): k for k, kind in enumerate(data.kind.to_numpy()) if kind}
    assert np.angle(spectrum[kinds["resonance 1:4"], 0]) == pytest.approx(np.pi / 2, abs=1e-9)
    assert spectrum[kinds["resonance 1:1"]] == pytest.approx([1.0, 1.0], abs=1e-4)


def test_truss_snaps_through():
    """Folds where (b² + y²)^(3/2) = L₀ b²; P(y) = 2 k y (L₀/√(b² + y²) − 1)."""
    data = follow(truss(), {"parameters.load": (-0.3, 0.3)})
    height = np.sqrt(1.2 ** (2 / 3) - 1)
    load = 2 * height * (1.2 / np.hypot(1, height) - 1)
    assert points(data, "fold") == pytest.approx([load, -load], rel=1e-11)
    place = data["state"].sel(coordinate="apex.position").to_numpy()
    np.testing.assert_allclose(
        data["value"].to_numpy()[:, 0], 2 * place * (1.2 / np.hypot(1, place) - 1), atol=1e-10
    )
    assert np.isnan(data["period"]).all()


def test_pendulum_with_torque_turns_over():
    """Equilibrium sin φ = m ends at m = 1; its eigenvalues are those of φ″ + c φ′ + cos φ."""
    data = follow(pendulum(0.5), {"parameters.m": (0.2, 1.2)})
    assert points(data, "fold") == pytest.approx([1.0], rel=1e-12)
    torque = data["value"].to_numpy()[:, 0]
    value = data["spectrum"].to_numpy() @ [1, 1j]
    slope = np.sqrt(np.maximum(1 - torque**2, 0.0))
    rows = data["stable"].to_numpy() == 1
    exact = -0.05 + np.sqrt(0.0025 - slope[rows].astype(complex))
    np.testing.assert_allclose(np.abs(value[rows, 0] - exact).max(), 0.0, atol=1e-6)


def test_rotation_without_drives():
    """Its multipliers are 1 and, by Liouville's theorem, e^(−c T)."""
    data = orbit(pendulum(0.5, speed=3.0))
    period = data.attrs["period"]
    values = data["multiplier"].sel(part="real").to_numpy()
    assert values == pytest.approx([1.0, np.exp(-0.1 * period)], rel=1e-9)
    assert data.attrs["stable"] == 1
    assert data.attrs["periods"] == 0


def test_conservative_orbit_has_the_energy_of_the_start():
    """T = 4 K(sin²(φ₀/2)) for an amplitude of 60°."""
    data = orbit(pendulum(0.0, angle=-30, damping=0.0), skip=0)
    assert data.attrs["period"] == pytest.approx(4 * ellipk(0.25), rel=1e-11)
    assert "energy is conserved" in data.attrs["reason"]
    assert data.attrs["stable"] == 0


def test_conservative_family_is_not_followed():
    with pytest.raises(ComputationError, match="form a family"):
        follow(pendulum(0.0, angle=-30, damping=0.0), {"bars.rod.mass": (0.5, 2.0)}, skip=0)


@pytest.mark.slow
def test_coexisting_cycles():
    """x″ + 0.08 x′ + x³ = 0.2 cos t has five (Y. Ueda): each start leads to its own."""
    starts = [(-0.21, 0.02), (1.05, 0.77), (-0.67, 0.02), (-0.46, 0.30), (-0.43, 0.12)]
    found = []
    for position, speed in starts:
        mechanism = slider(
            "-0.08*mass.velocity - mass.position**3 + F*cos(t)", "F: 0.2", position, speed
        )
        data = orbit(mechanism)
        assert data.attrs["stable"]
        found.append((data.attrs["periods"], *np.round(data["state"].to_numpy(), 6)))
    assert len(set(found)) == 5


def test_random_starts_need_no_long_transient():
    """Few periods left out, and orbits of one period alone, are a short search, not a wrong one."""
    mechanism = slider("-0.8*mass.velocity - mass.position + 0.2*cos(t)", "F: 0")
    data = orbit(mechanism, starts=2, skip=2, longest=1)
    # amplitude F/(c ω) at resonance
    assert np.hypot(*data["state"].to_numpy().ravel()) == pytest.approx(0.25, rel=1e-8)


def test_branches_of_coexisting_cycles():
    """Random starts find the five of the Duffing oscillator at F = 0.2, and follow each once."""
    mechanism = slider("-0.08*mass.velocity - mass.position**3 + F*cos(t)", "F: 0.2", rtol="1e-10")
    data = follow(mechanism, {"parameters.F": (0.18, 0.22)}, starts=80, switch=True, longest=4)
    place = data["value"].to_numpy()[:, 0]
    branches = json.loads(data.attrs["branches"])
    periods = [
        branch["periods"]
        for number, branch in enumerate(branches)
        if len(set(place[data["branch"].to_numpy() == number] > 0.2)) == 2
    ]
    assert sorted(periods) == [1, 1, 2, 2, 3]
    # branches of four periods end at a doubling of those of two, the same in all digits
    assert [branch["periods"] for branch in branches].count(4) == 2
    doublings = np.array(data["label"])[data["kind"] == "period doubling"]
    values = place[data["kind"] == "period doubling"]
    assert {label: np.ptp(values[doublings == label]) < 1e-13 for label in doublings[:2]} == {
        "PD1": True, "PD2": True,
    }  # fmt: skip


def test_random_starts_need_a_rhythm():
    with pytest.raises(OptionError, match="random starts need drives or loads"):
        follow(pendulum(1.2), {"parameters.m": (1.0, 1.4)}, starts=3)


@pytest.mark.slow
def test_conservative_press_is_reached_through_damped_ones():
    """The nine-bar conserves energy: multipliers on the unit circle, and the motion returns."""
    mechanism = linkages.load("ninebar")
    data = orbit(mechanism)
    values = data["multiplier"].to_numpy() @ [1, 1j]
    np.testing.assert_allclose(np.abs(values), 1.0, atol=1e-8)
    angle, speed = data["state"].to_numpy()
    again = mechanism.with_values({"clearances.r1.angle": angle, "clearances.r1.speed": speed})
    motion = linkages.simulate(again, end=4.0, samples=3, rtol=1e-12).data
    np.testing.assert_allclose(motion["clearance_angle"], angle, atol=1e-8)
    np.testing.assert_allclose(motion["clearance_speed"], speed, atol=1e-7)


def test_pitchfork_of_equilibria():
    """x″ = r x − x³ − 0.2 x′: three equilibria, 0 and ±√r, meet at r = 0."""
    mechanism = slider("r*mass.position - mass.position**3 - 0.2*mass.velocity", "r: -0.5", 0.0)
    data = follow(mechanism, {"parameters.r": (-1.0, 1.0)}, switch=True)
    assert points(data, "branch point") == pytest.approx([0.0], abs=1e-12)
    value, place = data["value"].to_numpy()[:, 0], data["state"].to_numpy()[:, 0]
    np.testing.assert_allclose(value * place - place**3, 0.0, atol=1e-10)
    assert place.min() == pytest.approx(-1.0, abs=1e-9)
    assert place.max() == pytest.approx(1.0, abs=1e-9)


def test_interrupted_branches_are_kept():
    """Points so far are those of the uninterrupted run, in the same order."""
    told = []

    def stop(line):
        told.append(line)
        if len(told) == 8:
            raise KeyboardInterrupt

    vary = {"parameters.load": (-0.3, 0.3)}
    with pytest.raises(linkages.Interrupted) as end:
        follow(truss(), vary, watch=stop)
    kept = end.value.kept["follow"]
    assert kept.sizes["point"] == 9  # the first one is not told
    assert json.loads(kept.attrs["branches"])[0]["ends"][0]["reason"] == "interrupted"
    whole = follow(truss(), vary)["value"].to_numpy()[:, 0].tolist()
    assert set(kept["value"].to_numpy()[:, 0].tolist()) <= set(whole)
