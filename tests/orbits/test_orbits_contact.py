"""Orbits of mechanisms with contact: doublings, multipliers, modes at nodes."""

import numpy as np
import pytest
from orbit_mechanisms import contact_slider_crank, impact_oscillator, points, random_four_bar

import linkages
from linkages.errors import ComputationError, InputError
from linkages.options.run import RunOptions
from linkages.orbits.equations import Orbit, multipliers, solve
from linkages.orbits.follow import follow
from linkages.orbits.orbit import orbit
from linkages.orbits.search import found_from
from linkages.orbits.shooting import Ray, Shooting

DOUBLINGS = [0.11931518, 0.11871144, 0.11861602, 0.11859687, 0.11859280, 0.11859194, 0.11859175]
"""In millimetres: docs/contact_published.md, by Newton's method and bisection on a multiplier."""


@pytest.mark.parametrize(
    "longest", [2, pytest.param(64, marks=[pytest.mark.slow])], ids=["two", "seven"]
)
def test_route_of_period_doublings(longest):
    data = follow(
        contact_slider_crank(),
        ["clearances.gap.size=0.12mm:0.1185mm"],
        skip=300,
        switch=True,
        longest=longest,
        unstable=False,
    )
    found = [round(1e3 * value, 8) for value in points(data, "period doubling")]
    assert found == DOUBLINGS[: len(found)]
    assert len(found) == int(np.log2(longest)) + 1


@pytest.mark.parametrize("mechanism", [impact_oscillator(), contact_slider_crank()])
def test_monodromy_against_central_differences(mechanism):
    shooting = Shooting(mechanism, (), RunOptions(rtol=1e-12))
    places = np.zeros(0)
    found = found_from(shooting, places, shooting.initial(places), periods=None, skip=300)
    problem, unknowns = found.problem, found.solution.unknowns
    exact = problem.evaluate(unknowns, places, found.solution.at).shots[0].by_state
    step = 1e-5 * shooting.scale
    moved = [
        problem.shots(unknowns + s * np.diag(step)[k], places, tangents=False)[0].end
        for k in range(shooting.size)
        for s in (1.0, -1.0)
    ]
    slopes = (np.array(moved[::2]) - np.array(moved[1::2])).T / (2 * step)
    size = np.abs(exact * shooting.scale / shooting.scale[:, None]).max()
    apart = (exact - slopes) * shooting.scale / shooting.scale[:, None]
    assert np.abs(apart).max() < 1e-6 * max(size, 1.0)


SEEDS = [seed for seed in range(16) if seed not in (8, 14)]
"""The two that are left out chatter: no orbit closes."""


@pytest.mark.slow_except("1", "3")
@pytest.mark.parametrize("seed", SEEDS, ids=str)
def test_random_four_bars(seed):
    """Orbits close to 1e-11 of their amplitudes; multipliers are those of central differences."""
    shooting = Shooting(random_four_bar(seed), (), RunOptions(rtol=1e-12))
    places = np.zeros(0)
    found = found_from(shooting, places, shooting.initial(places), periods=None, skip=8, longest=2)
    problem, unknowns, near = found.problem, found.solution.unknowns, found.solution.at
    assert problem.nodes == 1
    at = problem.evaluate(unknowns, places, near)
    assert np.abs(at.residual / problem.scale).max() < 1e-11

    def slopes(part):
        step = part * np.diag(shooting.scale)
        ends = [
            problem.shots(unknowns + sign * step[k], places, near, tangents=False)[0].end
            for k in range(shooting.size)
            for sign in (1.0, -1.0)
        ]
        return (np.array(ends[::2]) - np.array(ends[1::2])).T / (2 * part * shooting.scale)

    # of fourth order; errors of motions are 1e-12 of the amplitudes, over this step 3e-8
    differences = (4 * slopes(3e-5) - slopes(6e-5)) / 3
    scaled = differences * shooting.scale / shooting.scale[:, None]
    spectrum = np.linalg.eigvals(scaled)
    largest = max(1.0, float(np.abs(spectrum).max()))
    for value in at.spectrum:
        assert np.abs(spectrum - value).min() < 1e-6 * largest


def test_parts_of_an_orbit_have_the_same_multipliers():
    """The cyclic matrix of three parts has the eigenvalues of their product."""
    mechanism = impact_oscillator()
    shooting = Shooting(
        mechanism, (Ray(("parameters.A",), (0.9,), (1.1,)),), RunOptions(rtol=1e-12)
    )
    places = np.array([0.5])
    found = found_from(shooting, places, shooting.initial(places), periods=1, skip=50)
    state = found.problem.state(found.solution.unknowns)
    period = shooting.period(places)
    phase, states = found.problem.phase, [state]
    for node in range(2):
        start = (phase + node / 3) * period
        states.append(shooting.shoot(places, states[-1], period / 3, start=start).end)
    parts = Orbit(shooting, 1, 3, phase=phase)
    other = solve(parts, np.concatenate(states), places)
    np.testing.assert_allclose(other.at.spectrum, found.solution.at.spectrum, rtol=1e-10)


def test_small_multipliers_survive_beside_large_ones():
    """Products lose what differs by more than 16 digits; the cyclic matrix does not."""
    rng = np.random.default_rng(3)
    bases = [np.linalg.qr(rng.normal(size=(2, 2)))[0] for _ in range(4)]
    sizes = np.diag([1e5, 1e-6])
    parts = [bases[(k + 1) % 4] @ sizes @ bases[k].T for k in range(4)]
    values, _ = multipliers(parts, np.ones(2))
    # each part has entries that differ by 11 digits, which leaves five
    np.testing.assert_allclose(values, [1e20, 1e-24], rtol=1e-4)


def test_law_that_remembers_is_refused():
    text = contact_slider_crank().to_yaml()
    text = text.replace("hunt-crossley-constant", "lankarani-nikravesh")
    text = text.replace("dissipation: 0.5 s/m", "restitution: 0.9")
    with pytest.raises(InputError, match="remembers the rate at which contact began"):
        orbit(linkages.loads(text))


def friction_oscillator(amplitude):
    """A mass on a spring with dry friction of 1 N, pushed at half its natural frequency."""
    return linkages.loads(f"""
gravity: [0, 0]
parameters: {{A: {amplitude}}}
joints: {{O: [0, 0]}}
sliders: {{mass: {{joint: P, through: O, angle: 0, mass: 1}}}}
springs: [{{slider: mass, stiffness: 1, damping: 0.05, position: 0}}]
loads: [{{slider: mass, force: A*cos(t/2)}}]
friction: [{{slider: mass, force: 1.0}}]
free: {{mass: {{position: 0, speed: 0}}}}
simulate: {{end: 20, rtol: 1e-10}}
""")


def test_start_of_sticking():
    """Simulations beside the located amplitude: the mass rests for a while below it only."""
    data = follow(friction_oscillator(4.0), {"parameters.A": (2.5, 5.0)}, points=80)
    (start,) = points(data, "sticking")
    period = 4 * np.pi
    for amplitude, rests in ((start - 0.02, True), (start + 0.02, False)):
        motion = linkages.simulate(
            friction_oscillator(amplitude), end=40 * period, samples=40 * 500 + 1
        )
        speed = np.abs(motion.data["slider_velocity"].to_numpy()[-1000:, 0])
        assert bool((speed < 1e-12).sum() > 2) is rests
    at_zero = data["spectrum"].to_numpy()[data["value"].to_numpy()[:, 0] < start - 1e-3, :, 0]
    assert np.abs(at_zero[:, 1]).max() < 1e-12  # sticking takes a direction away


def test_equilibria_with_dry_friction_are_refused():
    text = friction_oscillator(1.0).to_yaml().replace("A*cos(t/2)", "0")
    with pytest.raises(ComputationError, match="equilibria form intervals"):
        follow(linkages.loads(text), {"springs[0].stiffness": (0.5, 2.0)})
