"""Attractors that are found without a hint, and the shares of their basins."""

import numpy as np
import pytest
from attractor_systems import ANGLE, SPEED, V, X, duffing, impacts, oscillator, pendulum
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from scipy.stats import beta

import linkages
from linkages.attractors.basins import share
from linkages.errors import InputError, Interrupted
from linkages.sweeps.running import Threads

PLANE = f"{ANGLE}=-150deg:210deg:8", f"{SPEED}=-10:10:8"
IMPACT_PLANE = f"{X}=-3:0.9:8", f"{V}=-3:3:8"


def kinds(data):
    return data.kind.to_numpy().tolist()


def points(data, number):
    rows = data.points.sel(attractor=number).to_numpy()
    return rows[np.isfinite(rows).all(axis=1)]


def test_a_pendulum_with_constant_torque_rests_or_turns():
    """The published share of rest is 15 %; the states follow from sin φ = 1/2 and SciPy."""
    data = linkages.basins(pendulum(), *PLANE, draws=400)
    assert kinds(data) == ["fixed point", "periodic"]
    assert points(data, 1) == pytest.approx(np.array([[np.pi / 6, 0.0]]), abs=2e-4)
    low, high = data.low.to_numpy(), data.high.to_numpy()
    assert low[0] < 0.15 < high[0]
    assert low[1] < 0.85 < high[1]
    assert data.turns.to_numpy().ravel().tolist() == [0, 1]

    def rates(_, z):
        return [z[1], 0.5 - 0.1 * z[1] - np.sin(z[0])]

    def once(_, z):
        return z[0] - 2 * np.pi

    once.terminal = True
    speed = 5.0
    for _ in range(80):
        run = solve_ivp(rates, (0, 10), [0.0, speed], events=once, rtol=1e-10, atol=1e-10)
        speed, period = run.y[1, -1], run.t[-1]
    ((angle, found),) = points(data, 2)
    # what is left of the way is 1e-5 of the range of the speed, 20 rad/s, at most
    assert (angle, found) == pytest.approx((0.0, speed), abs=2e-4)
    assert float(data.period[1]) == pytest.approx(period, rel=1e-5)


def knocking(amplitude, omega=1.2, c=0.1, e=0.8, d=1.0):
    """The state at t = 0 of the motion with an impact in each period, in closed form."""
    response = amplitude / (1 - omega**2 + 1j * c * omega)
    root = -c / 2 + 1j * np.sqrt(1 - c * c / 4)

    def free(t, since, x, v):
        """Homogeneous part and response, from a state on."""
        forced = response * np.exp(1j * omega * since)
        x0, v0 = x - forced.real, v - (1j * omega * forced).real
        b = x0 + 1j * (x0 * root.real - v0) / root.imag
        own = b * np.exp(root * (t - since))
        forced = response * np.exp(1j * omega * t)
        return np.array([own.real + forced.real, (root * own).real + (1j * omega * forced).real])

    period = 2 * np.pi / omega

    def closes(unknown):
        start, v = unknown
        x_end, v_end = free(start + period, start, d, -e * v)
        return x_end - d, v_end - v

    start, v = fsolve(closes, (1.0, 1.0), xtol=1e-13)
    return free(period, start, d, -e * v), v


def test_silent_and_knocking_motion_are_found_without_a_hint():
    """Between the fold, 0.1517, and grazing, 0.4561; both in closed form."""
    data = linkages.basins(impacts(), *IMPACT_PLANE, draws=100)
    assert kinds(data) == ["periodic", "periodic"]
    assert data.period.to_numpy() == pytest.approx(2 * np.pi / 1.2)
    assert data.touches.to_numpy().ravel().tolist() == [0, 1]
    silent = 0.3 / (1 - 1.44 + 0.12j)
    assert points(data, 1)[0] == pytest.approx([silent.real, (1.2j * silent).real], abs=1e-4)
    state, rate = knocking(0.3)
    assert rate > 0
    assert points(data, 2)[0] == pytest.approx(state, abs=1e-4)


@pytest.mark.parametrize(("amplitude", "touches"), [(0.15, [0]), (0.46, [1])])
def test_only_one_is_left_beyond_the_fold_and_beyond_grazing(amplitude, touches):
    data = linkages.basins(impacts(A=amplitude), *IMPACT_PLANE, draws=0, periods=4000)
    assert data.touches.to_numpy().ravel().tolist() == touches


PUBLISHED = [
    (1, -0.21, 0.02),
    (1, 1.05, 0.77),
    (2, -0.67, 0.02),
    (2, -0.46, 0.30),
    (3, -0.43, 0.12),
]


def test_the_five_cycles_of_duffings_oscillator():
    """Published starts of x'' + 0.08 x' + x³ = 0.2 cos t, which are near."""
    data = linkages.basins(duffing(), f"{X}=-1:1.2:24", f"{V}=-1:1:24", draws=0)
    assert data.cycle.to_numpy().tolist() == [1, 1, 2, 2, 3]
    nearest = []
    for _, *start in PUBLISHED:
        away = [np.abs(points(data, n) - start).max(axis=1).min() for n in range(1, 6)]
        nearest.append(int(np.argmin(away)))
        assert min(away) < 0.03
    assert sorted(nearest) == [0, 1, 2, 3, 4]


def test_a_limit_cycle_that_nothing_drives():
    """Van der Pol's for μ = 1 has the period 6.6632868593 and the amplitude 2.00862."""
    data = linkages.basins(oscillator("(1 - x**2)*v - x"), f"{X}=-3:3:4", f"{V}=-3:3:4", draws=0)
    assert kinds(data) == ["periodic"]
    assert float(data.period[0]) == pytest.approx(6.6632868593, rel=1e-5)
    assert points(data, 1)[0] == pytest.approx([2.00862, 0.0], abs=2e-4)


def test_a_driven_limit_cycle_off_resonance_is_quasi_periodic():
    data = linkages.basins(
        oscillator("0.3*(1 - x**2)*v - x + 0.3*cos(1.8*t)"),
        f"{X}=-2:2:2", f"{V}=-2:2:2", draws=0, periods=300,
    )  # fmt: skip
    assert kinds(data) == ["quasi-periodic"]
    assert np.isnan(data.period).all()


def test_chaos_is_no_cycle():
    """Ueda's oscillator, y'' + 0.05 y' + y³ = 7.5 cos t: Y. Ueda, J. Stat. Phys. 20 (1979) 181."""
    data = linkages.basins(
        oscillator("7.5*cos(t) - x**3 - 0.05*v"), f"{X}=2:3:2", f"{V}=1:2:2", draws=0, periods=200
    )
    assert kinds(data) == ["chaotic"]


def test_a_start_on_an_unstable_state_is_undecided():
    """Upright a pendulum stays where it is, and no neighbour does."""
    standing = linkages.loads("""
gravity: [1, 0]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
dampers: [{joint: O, damping: 0.5}]
free: {rod: {angle: 0, speed: 0}}
simulate: {end: 20}
""")
    data = linkages.basins(standing, f"{ANGLE}=0deg:180deg:2", f"{SPEED}=0:1:2", draws=0)
    assert kinds(data) == ["fixed point", "undecided"]
    assert data.basin.to_numpy().tolist() == [[1, 2], [1, 1]]
    assert "1 start end on an unstable" in data.attrs["warning"]


def test_dry_friction_has_a_family_of_states_at_rest():
    block = linkages.loads("""
joints: {O: [0, 0]}
sliders: {block: {joint: B, through: O, mass: 1}}
loads: [{slider: block, force: "-5*sign(block.speed)"}]
free: {block: {position: 0, speed: 0}}
simulate: {end: 5}
""")
    data = linkages.basins(block, f"{X}=0:1:8", f"{V}=-3:3:8", draws=0)
    assert kinds(data) == ["fixed point"]
    assert data.family.to_numpy().tolist() == [1]


# -- shares ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("found", "draws"), [(0, 50), (3, 50), (25, 50), (50, 50)])
def test_intervals_are_quantiles_of_beta_distributions(found, draws):
    """As Clopper and Pearson have them."""
    result = share(found, draws)
    low = beta.ppf(0.025, found, draws - found + 1) if found else 0.0
    high = beta.ppf(0.975, found + 1, draws - found) if found < draws else 1.0
    assert (result.low, result.high) == pytest.approx((low, high), rel=1e-12)
    assert result.fraction == found / draws


def test_without_draws_nothing_is_said_of_shares():
    data = linkages.basins(impacts(), *IMPACT_PLANE, draws=0)
    assert np.isnan(data.fraction).all()
    assert data.sizes["draw"] == 0


def test_more_draws_do_not_change_the_first_ones():
    few, more = (linkages.basins(impacts(), *IMPACT_PLANE, draws=n, seed=2) for n in (10, 30))
    assert (few.draw_basin.to_numpy() == more.draw_basin.to_numpy()[:10]).all()
    assert (few[f"drawn {X}"].to_numpy() == more[f"drawn {X}"].to_numpy()[:10]).all()
    other = linkages.basins(impacts(), *IMPACT_PLANE, draws=10, seed=3)
    assert (few[f"drawn {X}"].to_numpy() != other[f"drawn {X}"].to_numpy()).all()


def test_a_box_has_more_sides_than_a_plane():
    """Two uncoupled blocks: the second one's start matters for draws only."""
    two = linkages.loads("""
joints: {O: [0, 0], Q: [0, 1]}
sliders: {one: {joint: B, through: O, mass: 1}, other: {joint: C, through: Q, mass: 1}}
loads:
  - {slider: one, force: one.position - one.position**3 - one.speed}
  - {slider: other, force: other.position - other.position**3 - other.speed}
free: {one: {position: 0.5, speed: 0}, other: {position: 0.5, speed: 0}}
simulate: {end: 10}
""")
    plane = "free.one.position=-2:2:4", "free.one.speed=-1:1:2"
    assert linkages.basins(two, *plane, draws=0).sizes["attractor"] == 2
    data = linkages.basins(two, *plane, also="free.other.position=-2:2:2", draws=40)
    assert data.sizes["attractor"] == 4
    assert sorted(np.unique(data.basin)) != [1, 2, 3, 4]


# -- what must not matter --------------------------------------------------------------------


def same(one, other):
    return one.drop_attrs().identical(other.drop_attrs())


def test_results_do_not_depend_on_workers_and_chunks(monkeypatch):
    data = linkages.basins(impacts(), *IMPACT_PLANE, draws=20, executor=Threads(1))
    assert same(data, linkages.basins(impacts(), *IMPACT_PLANE, draws=20, executor=Threads(2)))
    monkeypatch.setattr("linkages.attractors.starts.SIDE_BY_SIDE", (3, 3))
    assert same(data, linkages.basins(impacts(), *IMPACT_PLANE, draws=20, executor=Threads(2)))


def test_numbers_do_not_depend_on_the_order_of_starts():
    """Ranges that run backward have the same attractors, with the same numbers."""
    data = linkages.basins(impacts(), *IMPACT_PLANE, draws=0)
    back = linkages.basins(impacts(), f"{X}=0.9:-3:8", f"{V}=3:-3:8", draws=0)
    # ends of a range agree with the other's to round-off only, so neither do points in all bits
    assert back.points.to_numpy() == pytest.approx(data.points.to_numpy(), abs=1e-4)
    assert (back.basin.to_numpy()[::-1, ::-1] == data.basin.to_numpy()).all()


class Interrupting(Threads):
    """Presses Ctrl-C after a chunk."""

    def run(self, task, points):
        yield next(iter(super().run(task, points)))
        raise KeyboardInterrupt


def test_a_store_goes_on_and_ends_the_same(tmp_path):
    data = linkages.basins(impacts(), *IMPACT_PLANE, draws=20)
    place = tmp_path / "study"
    with pytest.raises(Interrupted) as caught:
        linkages.basins(impacts(), *IMPACT_PLANE, draws=20, store=place, executor=Interrupting(2))
    kept = caught.value.kept["basins"]
    assert (kept.basin.to_numpy() == -1).any()
    assert (kept.basin.to_numpy() > 0).any()
    assert same(data, linkages.basins(impacts(), *IMPACT_PLANE, draws=20, store=place))


def test_a_parameter_may_be_an_axis():
    """Silent motion for all amplitudes below grazing, one attractor; knocking above the fold."""
    data = linkages.basins(impacts(), "parameters.A=0.05:0.35:7", f"{X}=-3:0.9:6", draws=40)
    assert kinds(data) == ["periodic", "periodic"]
    basin = data.basin.to_numpy()
    assert (basin[:, :3] == 1).all()  # 0.05, 0.1 and 0.15 are below the fold
    assert (basin[:, -1] == 2).any()


# -- bad input -------------------------------------------------------------------------------


BEATING = oscillator("cos(t) + cos(1.41421356237*t) - x - v")


@pytest.mark.parametrize(
    ("mechanism", "axes", "error", "message"),
    [
        ("pendulum", (ANGLE, SPEED), InputError, "nothing dissipates"),
        ("four-bar", ("bars.crank.mass", "gravity[0]"), InputError, "nothing is free to move"),
        (BEATING, (X, V), ValueError, "no common multiple"),
        (impacts(), ("free.block.positon", V), InputError, "did you mean 'position'"),
    ],
    ids=["conservative", "driven", "beating", "misspelt"],
)
def test_mechanisms_without_attractors_to_look_for(mechanism, axes, error, message):
    mechanism = linkages.load(mechanism) if isinstance(mechanism, str) else mechanism
    with pytest.raises(error, match=message):
        linkages.basins(mechanism, *(f"{axis}=0:1:2" for axis in axes))


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"draws": -1}, "draws must be at least 0, found -1"),
        ({"periods": 10}, "expected at least 64 periods, found 10"),
        ({"settled": 0.5}, "settled must be at most 0.01, found 0.5"),
        ({"also": f"{X}=0:1:2"}, "varied by two ranges"),
        ({"also": "parameters.A=0.1:0.2:2"}, "parameters.A is no initial state"),
    ],
)
def test_arguments_that_make_no_sense(given, message):
    with pytest.raises(ValueError, match=message):
        linkages.basins(impacts(), *IMPACT_PLANE, **given)


def test_starts_that_cannot_be_used_are_named_and_no_part_of_shares():
    """A mass of zero or less is none."""
    data = linkages.basins(impacts(), "sliders.block.mass=-1:1:2", f"{X}=-1:0:2", draws=20, seed=1)
    assert (data.basin.to_numpy()[:, 0] == -1).all()
    assert all("mass" in text for text in data.reason.to_numpy()[:, 0])
    started = int((data.draw_basin > 0).sum())
    assert 0 < started < 20
    assert int(data.found.sum()) == started
