"""Change points: passed on request as inertia would have it, and nothing else is."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk
from solution_mechanisms import derivative, mechanism

import linkages
from linkages import IncompleteError
from linkages.kernel.dyads import LEAST_MARGIN

CRANK, GROUND, SPEED = 0.04, 0.1, 6.0
BARS = """\
bars:
  crank: {joints: [O2, A], length: 0.04, mass: 0.2}
  coupler: {joints: [A, B], length: 0.1, mass: 0.5, center: [0.04, 0.01], inertia: 6e-4}
  rocker: {joints: [O4, B], length: 0.04, mass: 0.3}
"""
PARALLELOGRAM = f"gravity: [0, -9.81]\njoints: {{O2: [0, 0], O4: [0.1, 0]}}\n{BARS}"
DRIVEN = "drives: {crank: {angle: 0.5, speed: 6}}"
FREE = "free: {crank: {angle: 0.5, speed: 30}}"
LEFT = "assembly: {B: left}"
IN_LINE = (np.pi - 0.5) / SPEED


def place(data, joint):
    return data.joint_position.sel(joint=joint).to_numpy()


# -- driven ----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def driven():
    """Two turns; samples 200 and 600 lie exactly at change points, others within round-off."""
    found = mechanism(PARALLELOGRAM, DRIVEN, LEFT)
    return linkages.simulate(
        found, end=10 * IN_LINE, samples=2001, change_points="pass", outputs="all"
    )


def test_driven_parallelogram_stays_one(driven):
    """Exactly: θ_rocker = θ_crank, the coupler is level, and derivatives are those of a circle."""
    data = driven.data
    angle = 0.5 + SPEED * data.time.to_numpy()
    for bar in ("crank", "rocker"):
        assert data.bar_angle.sel(bar=bar).to_numpy() == pytest.approx(angle, abs=1e-10)
        # ε/m³ of the nearest sample that is evaluated, m = 0.015
        assert data.bar_speed.sel(bar=bar).to_numpy() == pytest.approx(SPEED, abs=1e-9)
        assert data.bar_acceleration.sel(bar=bar).to_numpy() == pytest.approx(0, abs=1e-6)
    assert data.bar_angle.sel(bar="coupler").to_numpy() == pytest.approx(0, abs=1e-11)
    ratio = data.mechanical_advantage.sel(drive="crank", bar="rocker").to_numpy()
    assert ratio == pytest.approx(1, abs=1e-9)
    between = np.abs(np.remainder(angle + np.pi, 2 * np.pi) - np.pi)
    # of the coupler's direction and the rocker's, which the cosine takes for 1 below 1e-8
    assert np.pi - data.transmission_angle.to_numpy()[:, 0] == pytest.approx(
        np.pi - between, abs=1e-7
    )
    assert place(data, "B") - place(data, "A") == pytest.approx(
        np.tile([GROUND, 0], (2001, 1)), abs=1e-12
    )
    assert float(data.closure_residual.max()) <= 1e-13


def test_samples_at_change_points_are_there(driven):
    """The sample times hold the change points to a rounding; the motion has all of them."""
    data = driven.data
    times = [(k * np.pi - 0.5) / SPEED for k in range(1, 9)]
    assert np.abs(data.time.to_numpy() - times[0]).min() < 1e-15
    assert data.sizes["time"] == 2001
    for name in data.data_vars:
        if "advantage" not in name:
            assert np.isfinite(data[name]).all(), name
    notes = [note for note in driven.notes if "change point" in note]
    assert len(notes) == len(times)
    for note, time in zip(notes, times, strict=True):
        assert float(note.split()[3]) == pytest.approx(time, abs=1e-5)
        assert "block 0 (RRR dyad of coupler and rocker)" in note


def test_efforts_and_reactions_go_on_smoothly(driven):
    """What a circle of points needs: no sample sticks out, neither at a change point nor beside."""
    data = driven.data
    angle = 0.5 + SPEED * data.time.to_numpy()
    # Only weight does work: P = g·Σ m·y', with all masses on circles of the crank's radius (the
    # coupler's whole mass, half of the others'): effort = g cos θ·r·(m_c/2 + m + m_r/2)
    expected = 9.81 * np.cos(angle) * CRANK * (0.5 * 0.2 + 0.5 + 0.5 * 0.3)
    assert data.drive_effort.to_numpy()[:, 0] == pytest.approx(expected, abs=1e-8)
    spacing = data.time.to_numpy()[1]
    for joint in ("A", "B"):
        acceleration = data.joint_acceleration.sel(joint=joint).to_numpy()
        wanted = -(SPEED**2) * CRANK * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        assert acceleration == pytest.approx(wanted, abs=1e-7)
        velocity = data.joint_velocity.sel(joint=joint).to_numpy()
        assert derivative(velocity, spacing) == pytest.approx(wanted[4:-4], abs=1e-6)
    energy = (data.kinetic_energy + data.potential_energy).to_numpy()
    assert derivative(energy, spacing) == pytest.approx(data.drive_power.to_numpy()[4:-4], abs=1e-6)
    assert float(np.abs(data.energy_residual).max()) < 1e-9


def test_reactions_at_a_change_point():
    """Weight along the line of the ground pins: in line, nothing pushes the rocker aside.

    Moments about A on the coupler and about O4 on the rocker, whose points go round:
    F_y = m_c/d·c·ω²·r·sin θ and F_x = F_y·cot θ − m_r·g/2. (With weight across, the rocker is held
    by a force that grows without bound, as 1/sin θ.)
    """
    text = PARALLELOGRAM.replace("[0, -9.81]", "[9.81, 0]").replace("[0.04, 0.01]", "0.04")
    data = linkages.simulate(
        mechanism(text, DRIVEN, LEFT), end=10 * IN_LINE, samples=2001, change_points="pass",
        outputs="all",
    ).data  # fmt: skip
    angle = 0.5 + SPEED * data.time.to_numpy()
    pull = 0.5 / GROUND * 0.04 * SPEED**2 * CRANK
    expected = np.stack([pull * np.cos(angle) - 0.5 * 0.3 * 9.81, pull * np.sin(angle)], axis=1)
    found = data.joint_reaction.sel(joint="B").to_numpy()
    # ε/m³ of accelerations, over m once more: m = 0.015
    assert found == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("samples", [2, 3, 7, 1000])
def test_driven_passing_does_not_depend_on_samples(samples):
    found = mechanism(PARALLELOGRAM, DRIVEN, LEFT)
    data = linkages.simulate(found, end=3.0, samples=samples, change_points="pass").data
    assert data.sizes["time"] == samples
    turned = data.bar_angle.sel(bar="rocker") - data.bar_angle.sel(bar="crank")
    # whole turns between samples are not counted, the place is what it is
    assert np.sin(0.5 * turned.to_numpy()) == pytest.approx(0, abs=1e-10)


def test_backward_in_time():
    found = mechanism(PARALLELOGRAM, DRIVEN, LEFT)
    data = linkages.simulate(found, end=-3.0, samples=601, change_points="pass").data
    angle = 0.5 + SPEED * data.time.to_numpy()
    assert data.bar_angle.sel(bar="rocker").to_numpy() == pytest.approx(angle, abs=1e-10)


def test_stop_says_what_to_do():
    found = mechanism(PARALLELOGRAM, DRIVEN, LEFT)
    for arguments in ({}, {"change_points": "stop"}):
        with pytest.raises(IncompleteError) as caught:
            linkages.simulate(found, end=3.0, samples=301, **arguments)
        assert caught.value.time == pytest.approx(IN_LINE, abs=2 * LEAST_MARGIN / SPEED)
        for words in ("joint B", "block 0", "coupler and rocker are in line", "singular"):
            assert words in str(caught.value)


def test_what_the_file_says_is_done():
    text = (PARALLELOGRAM, DRIVEN, LEFT)
    passing = mechanism(*text, "simulate: {end: 3, samples: 31, change_points: pass}")
    assert linkages.simulate(passing).completed
    with pytest.raises(IncompleteError):
        linkages.simulate(passing, change_points="stop")


def test_only_pass_and_stop_are_known():
    found = mechanism(PARALLELOGRAM, DRIVEN, LEFT)
    with pytest.raises(ValueError, match="'pass' or 'stop', found 'go'"):
        linkages.simulate(found, change_points="go")


# -- what is no change point -----------------------------------------------------------------


def dead_point(gap, motion):
    """Stretched links that miss by `gap`: the crank stops √(2·0.14·gap/0.004) short of the line."""
    return mechanism(
        "joints: {O2: [0, 0], O4: [0.1, 0]}\n"
        "bars:\n  crank: {joints: [O2, A], length: 0.04, mass: 1, inertia: 100}\n"
        "  coupler: {joints: [A, B], length: 0.08}\n"
        f"  rocker: {{joints: [O4, B], length: {0.06 - gap!r}}}\n",
        f"{motion}: {{crank: {{angle: 0.5, speed: 1}}}}",
        LEFT,
    )


@pytest.mark.parametrize("motion", ["free", "drives"])
@pytest.mark.parametrize("gap", [1e-4, 1e-6, 1e-8, 1e-9])
def test_dead_point_is_never_passed(gap, motion):
    limit = np.arccos((CRANK**2 + GROUND**2 - (0.14 - gap) ** 2) / (2 * CRANK * GROUND)) - 0.5
    for passing in ("pass", "stop"):
        with pytest.raises(IncompleteError) as caught:
            linkages.simulate(dead_point(gap, motion), end=6.0, samples=601, change_points=passing)
        assert caught.value.time == pytest.approx(limit, abs=1e-4)


@pytest.mark.parametrize("motion", ["free", "drives"])
@pytest.mark.parametrize("miss", [1e-4, 1e-6, 1e-8, 1e-9])
def test_passing_beside_a_change_point_keeps_the_mode(miss, motion):
    """Links a little longer than it takes: they are never in line, B stays on its side of A–O4."""
    data = linkages.simulate(
        dead_point(-miss, motion), end=6.0, samples=601, change_points="pass"
    ).data
    ground = np.array([GROUND, 0.0])
    along, across = ground - place(data, "A"), place(data, "B") - place(data, "A")
    assert (along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0] > 0).all()


@pytest.mark.parametrize("motion", ["free", "drives"])
def test_exact_change_point_of_the_same_links_is_passed(motion):
    """What the two tests above stay clear of: with no gap, B goes over to the other side."""
    solution = linkages.simulate(
        dead_point(0.0, motion), end=5.0, samples=501, change_points="pass"
    )
    data = solution.data
    ground = np.array([GROUND, 0.0])
    along, across = ground - place(data, "A"), place(data, "B") - place(data, "A")
    side = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    before = data.time.to_numpy() < np.pi - 0.5
    assert (side[before] > 0).all()
    assert (side[~before] < 0).all()
    assert len([note for note in solution.notes if "change point" in note]) == 1


# -- free ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def turning():
    """A free parallelogram, crank and rocker massless: a pendulum of the coupler's mass turning."""
    text = PARALLELOGRAM.replace("mass: 0.2", "mass: 0").replace("mass: 0.3", "mass: 0")
    return linkages.simulate(
        mechanism(text, FREE, LEFT), end=2.0, samples=2001, rtol=1e-12, outputs="all"
    )


def test_free_parallelogram_turns_like_a_pendulum(turning):
    """All points of the coupler move on circles of the crank's radius: ½ r² θ̇² + g r sin θ."""
    data = turning.data
    angle = data.bar_angle.sel(bar="crank").to_numpy()
    assert data.bar_angle.sel(bar="rocker").to_numpy() == pytest.approx(angle, abs=1e-10)
    assert data.bar_angle.sel(bar="coupler").to_numpy() == pytest.approx(0, abs=1e-10)
    assert np.abs(np.diff(angle)).max() < 0.05  # turns are counted over all pieces
    speed = data.bar_speed.sel(bar="crank").to_numpy()
    energy = 0.5 * CRANK**2 * speed**2 + 9.81 * CRANK * np.sin(angle)
    assert energy == pytest.approx(energy[0], rel=1e-9)
    # period of a turning pendulum: T = 4 K(m)/ω_top-to-bottom, m = 4 g r/(r² θ̇_bottom²)
    bottom = np.sqrt(2 * (energy[0] + 9.81 * CRANK)) / CRANK
    modulus = 4 * 9.81 / (CRANK * bottom**2)
    period = 4 / bottom * ellipk(modulus)
    turns = (angle[-1] - angle[0]) / (2 * np.pi)
    whole = int(turns)
    crossed = np.interp(angle[0] + 2 * np.pi * whole, angle, data.time.to_numpy())
    # linear interpolation over 1 ms of a motion that accelerates by some 250 rad/s²
    assert crossed == pytest.approx(whole * period, abs=1e-5)
    assert len([note for note in turning.notes if "change point" in note]) == int(
        np.floor(angle[-1] / np.pi)
    )


def test_free_motion_balances_through_change_points(turning):
    data = turning.data
    # rtol 1e-12 per step, 1e-10 per change point
    assert float(np.abs(data.energy_residual).max()) < 1e-9 * float(data.kinetic_energy.max())
    assert float(data.closure_residual.max()) <= 1e-13
    for name in ("joint_reaction", "bar_acceleration", "joint_acceleration"):
        assert np.isfinite(data[name]).all()


@pytest.mark.slow
def test_samples_do_not_change_a_motion_through_change_points(turning):
    text = PARALLELOGRAM.replace("mass: 0.2", "mass: 0").replace("mass: 0.3", "mass: 0")
    for samples in (3, 5, 101):
        data = linkages.simulate(
            mechanism(text, FREE, LEFT), end=2.0, samples=samples, rtol=1e-12
        ).data
        dense = turning.data.isel(time=slice(None, None, 2000 // (samples - 1)))
        for joint in ("A", "B"):
            # where runs are cut depends on the last digits; steps err by 1e-12
            assert place(data, joint) == pytest.approx(place(dense, joint), abs=1e-10)


@pytest.mark.slow_except("dop853", "gauss8")
@pytest.mark.parametrize("method", ["dop853", "vern9", "tsit5", "rk4", "gauss8"])
def test_every_method_passes(method):
    step = {"rk4": 1e-4, "gauss8": 1e-3}.get(method)
    data = linkages.simulate(
        mechanism(PARALLELOGRAM, FREE, LEFT), end=1.0, samples=51, method=method, step=step
    ).data
    turned = data.bar_angle.sel(bar="rocker") - data.bar_angle.sel(bar="crank")
    assert turned.to_numpy() == pytest.approx(0, abs=1e-8)


def test_free_motion_stops_on_request():
    with pytest.raises(IncompleteError) as caught:
        linkages.simulate(
            mechanism(PARALLELOGRAM, FREE, LEFT), end=1.0, samples=101, change_points="stop"
        )
    for words in ("coupler and rocker are in line", "singular", "Change a length"):
        assert words in str(caught.value)


def test_through_and_back():
    """Past one change point, and back from there: the start comes back."""
    forth = linkages.simulate(mechanism(PARALLELOGRAM, FREE, LEFT), end=0.15, samples=3, rtol=1e-12)
    assert len([note for note in forth.notes if "change point" in note]) == 1
    end = forth.data.isel(time=-1)
    angle, speed = (float(end[n].sel(bar="crank")) for n in ("bar_angle", "bar_speed"))
    back = linkages.simulate(
        mechanism(
            PARALLELOGRAM,
            f"free: {{crank: {{angle: {angle!r}, speed: {speed!r}}}}}",
            f"assembly: {{B: [{GROUND + CRANK * np.cos(angle)}, {CRANK * np.sin(angle)}]}}",
        ),
        end=-0.15, samples=3, rtol=1e-12,
    ).data  # fmt: skip
    assert float(back.bar_angle.sel(bar="crank")[-1]) == pytest.approx(0.5, abs=1e-9)
    assert float(back.bar_speed.sel(bar="crank")[-1]) == pytest.approx(30, abs=1e-7)
    assert place(back, "B")[-1] == pytest.approx(place(forth.data, "B")[0], abs=1e-10)


def test_antiparallelogram_stays_one():
    """Crossed at the start, crossed at the end: its own change points are passed as well.

    Its bars turn against each other: tan(φ/2) = −(d + r)/(d − r)·tan(θ/2) (any textbook).
    """
    solution = linkages.simulate(
        mechanism(PARALLELOGRAM, DRIVEN, "assembly: {B: right}"),
        end=1.4, samples=281, change_points="pass",
    )  # fmt: skip
    data = solution.data
    crank, rocker = (data.bar_angle.sel(bar=b).to_numpy() for b in ("crank", "rocker"))
    ratio = (GROUND + CRANK) / (GROUND - CRANK)
    expected = 2 * np.arctan2(-ratio * np.sin(crank / 2), np.cos(crank / 2))
    # the rocker turns 7/3 times as fast at one of its change points, ε/m³ at m = 0.015
    assert np.sin(0.5 * (rocker - expected)) == pytest.approx(0, abs=1e-9)
    assert crank[-1] > 2 * np.pi
    assert len([note for note in solution.notes if "change point" in note]) == 2


# -- the press -------------------------------------------------------------------------------


def test_press_folded_onto_itself_goes_on():
    """Bars 6 and 8 are equally long, and F stands on O: it stays there while E turns about it.

    Without the change of mode it would leave O when E has crossed x = 0, by twice the way of E.
    """
    press = linkages.load("ninebar-ideal", set={"assembly.E": "left"})
    solution = linkages.simulate(press, change_points="pass", outputs="all")
    data = solution.data
    assert len([note for note in solution.notes if "change point" in note]) == 2
    across = place(data, "E")[:, 0]
    assert across.max() > 0.05 > -0.02 > across.min()
    # ε/m² of a position at the nearest sample that is evaluated, m = 0.004
    assert data.slider_position.to_numpy() == pytest.approx(0, abs=1e-10)
    assert data.slider_velocity.to_numpy() == pytest.approx(0, abs=1e-9)
    # quadrature of a power that is interpolated across change points
    assert float(np.abs(data.energy_residual).max()) < 1e-7
    assert not np.isnan(data.mechanical_advantage).any()


def test_press_with_clearance_goes_on_at_a_tolerance_that_can_be_kept():
    """The clearance swings some times within a step across: less is known than at rtol 1e-10."""
    press = linkages.load("ninebar", set={"assembly.E": "left"})
    data = linkages.simulate(
        press, end=1.6, samples=1601, change_points="pass", rtol=1e-5, outputs="all"
    ).data
    assert data.slider_position.to_numpy() == pytest.approx(0, abs=1e-9)
    assert place(data, "E")[-1, 0] > 0.02
    assert float(np.abs(data.energy_residual).max()) < 1e-3


def test_the_same_run_gives_the_same_bits():
    """What is interpolated at a change point must not depend on what ran before."""
    first, again = (
        linkages.simulate(mechanism(PARALLELOGRAM, FREE, LEFT), end=0.5, samples=101)
        for _ in range(2)
    )
    assert any("change point" in note for note in first.notes)
    assert again.data.equals(first.data)


def test_a_motion_that_turns_back_beside_a_change_point_goes_on():
    """Where the margins of two blocks are about to fall at once, each stopped it for the other.

    Against the parallelograms as one pendulum: three posts with m·L²/3 and the weight at half
    length, two links that move with their ends; θ'' = (torque - 3.5 m·g·L·cos θ)/(3 m·L²).
    The motion is integrated to 1e-11, and the change points are passed at 1e-10.
    """
    torque = {"bar": "post0", "torque": "10*t - exp(t)"}
    mechanism = linkages.load("n-four-bar").with_values({"loads": [torque]})
    data = linkages.simulate(mechanism, end=3.0, samples=31).data
    time = data.time.to_numpy()

    def pendulum(t, state):
        pull = 10 * t - np.exp(t) - 3.5 * 9.81 * np.cos(state[0])
        return [state[1], pull / 3]

    exact = solve_ivp(
        pendulum, (0.0, 3.0), [np.pi / 2, -1.0], "DOP853", time, rtol=1e-12, atol=1e-12
    )
    for post in ("post0", "post1", "post2"):
        angle = data.bar_angle.sel(bar=post).to_numpy()
        assert angle == pytest.approx(exact.y[0], abs=1e-8)
