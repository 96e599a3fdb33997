"""What is known of exponents holds where they are right, and says so loudly where they are not."""

from dataclasses import replace

import numpy as np
import pytest
from chaos_systems import exponents_of

import linkages
from linkages.chaos.deviation_vectors import LinkageTangents
from linkages.chaos.exponents import Invariant, lyapunov_spectrum
from linkages.chaos.lyapunov import certificate, certified, samples_within
from linkages.chaos.volume_contraction import Volumes
from linkages.kernel.system import System
from linkages.options.run import RunOptions
from linkages.solution.motion import Piece

DOUBLE = """\
name: Double pendulum
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {upper: {joints: [O, A], length: 1, mass: 1}, lower: {joints: [A, B], length: 1, mass: 1}}
free: {upper: {angle: 80 deg}, lower: {angle: 85 deg}}
simulate: {end: 1, rtol: 1e-9}
"""
DAMPED = "dampers: [{joint: O, damping: 0.3}, {joint: A, damping: 0.2}]\n"
DRIVEN = 'loads: [{bar: upper, torque: "20*cos(2*pi*t)"}]\n'

ROLLER = """\
name: Crank against a sliding mass
joints: {O: [0, 0]}
bars:
  crank: {joints: [O, A], length: 0.04, mass: 0.8}
  rod: {joints: [A, B], length: 0.14, mass: 0.5}
sliders: {piston: {joint: B, through: O, mass: 0.4}}
dampers: [{slider: piston, damping: 3}]
assembly: {A: [0.02, 0.034], B: [0.156, 0]}
loads: [{bar: crank, torque: "0.1*cos(7*t)"}]
free: {crank: {angle: 60 deg, speed: 20}}
simulate: {end: 0.5, rtol: 1e-9}
"""


def built(*texts):
    return linkages.loads("".join(texts))


def named(exponents):
    return {found.name: found for found in exponents.certificate}


@pytest.mark.parametrize("text", [DOUBLE + DAMPED + DRIVEN, DOUBLE + DAMPED, ROLLER])
def test_sum_is_that_of_inertia_and_damping(text):
    """Two roads to the same number: the variational equations, and ln det M with damping.

    Steps err by 1e-6 of tangents' lengths (a sum over the run is better than that); the mean
    damping by the trapezoidal rule over 64 states a period.
    """
    found = exponents_of(built(text), periods=30, skip=2, interval=0.5)
    (total,) = (i for i in found.certificate if i.name == "sum of all exponents")
    assert total.holds
    assert total.expected < -0.05  # it is about damping
    assert total.found == pytest.approx(total.expected, abs=3e-5 * abs(found.values).max())


def test_mean_damping_of_a_slider_against_its_closed_form():
    """One coordinate: the rate is d (∂x/∂θ)² / M(θ), with x(θ) and M = 2 T / θ'² in closed form."""
    mechanism = built(ROLLER)
    system = System(mechanism)
    angles = np.linspace(0, 2 * np.pi, 50)
    piece = Piece(
        system=system,
        time=np.zeros(50),
        state=np.array([angles, np.full(50, 3.0)]),
        turns=np.zeros((1, 50)),
        acceleration=np.zeros((1, 50)),
    )
    found = Volumes(system).damping_rates(piece)[:, 0, 0]
    r, length = 0.04, 0.14
    along = np.sqrt(length**2 - (r * np.sin(angles)) ** 2)
    slope = -r * np.sin(angles) - r**2 * np.sin(angles) * np.cos(angles) / along
    turn = -r * np.cos(angles) / along  # of the rod, whose sine is −r sin θ / l
    middle = [-r * np.sin(angles) - 0.5 * length * (-r * np.sin(angles) / length) * turn,
              r * np.cos(angles) + 0.5 * along * turn]  # fmt: skip
    mass = (
        0.8 * r**2 / 3
        + 0.5 * (middle[0] ** 2 + middle[1] ** 2)
        + 0.5 * length**2 / 12 * turn**2
        + 0.4 * slope**2
    )
    assert found == pytest.approx(3 * slope**2 / mass, rel=1e-12)
    grown = Volumes(system).logarithm(piece)
    assert grown == pytest.approx(np.log(mass), abs=1e-12)


def test_conservative_flow_has_pairs_and_two_zeros():
    found = exponents_of(built(DOUBLE), periods=120, interval=1.0)
    rows = named(found)
    assert list(rows) == ["sum of all exponents", "sum of exponents 1 and 4",
                          "sum of exponents 2 and 3", "exponent 2", "exponent 3"]  # fmt: skip
    assert all(row.holds for row in rows.values())
    assert found.values[0] > 0.5  # chaotic, so that nothing holds by being small
    assert all(row.tolerance < 0.7 * found.values[0] for row in rows.values())


def test_driven_and_damped_motions_have_neither():
    names = list(named(exponents_of(built(DOUBLE, DAMPED, DRIVEN), periods=30)))
    assert names == ["sum of all exponents"]
    driven = list(named(exponents_of(built(DOUBLE, DRIVEN), periods=30)))
    pairs = ["sum of exponents 1 and 4", "sum of exponents 2 and 3"]
    assert driven == ["sum of all exponents", *pairs]


def test_a_motion_that_comes_to_rest_has_no_zero():
    found = exponents_of(built(DOUBLE, DAMPED), periods=60, interval=1.0)
    assert list(named(found)) == ["sum of all exponents"]


def test_a_motion_at_rest_has_no_zero():
    """What moves by round-off alone is as fast at the end as at the beginning."""
    damped = linkages.load("pendulum", set={"dampers": "[{joint: O, damping: 1 N m s/rad}]"})
    found = exponents_of(damped, periods=1200, skip=400, interval=0.4, rtol=1e-7)
    assert list(named(found)) == ["sum of all exponents"]


def test_one_rate_of_damping_shifts_pairs():
    """Two arms beside each other with equal inertia and dampers: momenta decay at one rate.

    Pairs are λ₁ + λ₄ and λ₂ + λ₃, each minus the rate d/J = 0.4 · 3 / (m l²) of a rod.
    """
    text = """\
name: Two arms
gravity: [0, -9.81]
joints: {O: [0, 0], P: [5, 0]}
bars: {one: {joints: [O, A], length: 1, mass: 1}, two: {joints: [P, B], length: 1, mass: 1}}
dampers: [{joint: O, damping: 0.4}, {joint: P, damping: 0.4}]
loads: [{bar: one, torque: "8*cos(5*t)"}, {bar: two, torque: "6*cos(5*t)"}]
free: {one: {angle: -60 deg}, two: {angle: -50 deg}}
simulate: {end: 1, rtol: 1e-9}
"""
    rows = named(exponents_of(built(text), periods=60, skip=20))
    for name in ("sum of exponents 1 and 4", "sum of exponents 2 and 3"):
        assert rows[name].expected == pytest.approx(-1.2, rel=1e-9)
        assert rows[name].holds
        assert rows[name].tolerance < 0.3
    several = text.replace("{joint: P, damping: 0.4}", "{joint: P, damping: 0.5}")
    assert list(named(exponents_of(built(several), periods=20))) == ["sum of all exponents"]


@pytest.mark.slow
def test_a_step_that_takes_energy_out_violates_the_certificate():
    """The paper's RK4 at 0.5 ms: the nine-bar has no friction, and yet volumes shrink."""
    changes = {"drives.crank1.angle": "15 deg", "drives.crank4.angle": "150 deg"}
    mechanism = linkages.load("ninebar", set={**changes, "simulate.step": 5e-4})
    data = linkages.lyapunov(mechanism, periods=40, method="rk4")
    assert data["found"][0] < data["expected"][0] - data["tolerance"][0]
    assert "The sum of all exponents must be" in data.attrs["warning"]
    precise = linkages.lyapunov(mechanism, periods=40, method="dop853")
    assert "must be" not in precise.attrs["warning"]
    assert float(precise["found"][0]) == pytest.approx(float(precise["expected"][0]), abs=1e-6)


def test_nothing_is_certified_without_the_whole_spectrum():
    found = exponents_of(built(DOUBLE), periods=20, interval=1.0, count=2)
    assert found.certificate == ()


def test_a_violated_invariant_leaves_no_verdict():
    right = Invariant(name="sum", reason="known", found=1.0, expected=1.2, tolerance=0.2001)
    wrong = replace(right, tolerance=0.19)
    unknown = replace(right, found=float("nan"))
    assert certified("chaotic", ["why"], [right]) == ("chaotic", ["why"])
    for bad in (wrong, unknown):
        verdict, reasons = certified("chaotic", ["why"], [right, bad])
        assert verdict == "undecided"
        assert "the exponents cannot be right" in reasons[0]
        assert reasons[1:] == ["why"]


def test_states_in_between_change_nothing_and_stay_few():
    """Samples come from the dense output, so that steps are the same to the last bit."""
    system = System(built(DOUBLE))
    plain, kept = (LinkageTangents(system, 4, parts=parts) for parts in (0, 16))
    grown = [np.concatenate([g.rates for g in t.grow(2, 0.25)]) for t in (plain, kept)]
    assert (grown[0] == grown[1]).all()
    assert (plain.state == kept.state).all()
    assert (plain.tangents == kept.tangents).all()
    passed = kept.motion
    assert passed.time == pytest.approx(np.linspace(0, 0.5, 33), abs=1e-15)
    assert passed.state[:, -1] == pytest.approx(kept.state, abs=1e-15)
    assert samples_within(100) == 16
    assert all(samples_within(n) * n <= max(2**20, 2 * n) for n in (10**4, 10**5, 10**6, 10**8))


def test_many_samples_only_where_damping_is_averaged():
    """The sum without damping follows from the ends of intervals, however they are sampled."""
    once = exponents_of(built(DOUBLE), periods=20, interval=1.0)
    system = System(built(DOUBLE))
    tangents = LinkageTangents(system, 4, RunOptions(rtol=1e-9), parts=16)
    again = lyapunov_spectrum(tangents, intervals=80, interval=0.25)
    (one, *_), (two, *_) = once.certificate, certificate(tangents, again, 0)
    assert (again.growth == once.growth).all()
    assert two.expected == pytest.approx(one.expected, rel=1e-12)
