"""Motions that cannot go on: found, told and cut there, however coarse the samples are."""

import numpy as np
import pytest
from scipy.optimize import brentq
from solution_mechanisms import mechanism

import linkages
from linkages import IncompleteError
from linkages.errors import InputError
from linkages.kernel.dyads import LEAST_MARGIN


def four_bar(crank, coupler, rocker, ground, *, angle=0.5, speed=1.0, side="left", mass=0.0):
    crank, coupler, rocker, angle = map(float, (crank, coupler, rocker, angle))
    return mechanism(
        f"joints: {{O2: [0, 0], O4: [{ground!r}, 0]}}\n"
        f"bars:\n  crank: {{joints: [O2, A], length: {crank!r}}}\n"
        f"  coupler: {{joints: [A, B], length: {coupler!r}}}\n"
        f"  rocker: {{joints: [O4, B], length: {rocker!r}, mass: {mass!r}}}\n"
        f"drives: {{crank: {{angle: {angle!r}, speed: {speed!r}}}}}\nassembly: {{B: {side}}}\n"
    )


def slider_crank(crank, rod, *, angle=0.1, speed=1.0):
    return mechanism(
        f"joints: {{O: [0, 0]}}\nbars:\n  crank: {{joints: [O, A], length: {crank!r}}}\n"
        f"  rod: {{joints: [A, B], length: {rod!r}, mass: 1}}\n"
        f"sliders: {{piston: {{joint: B, through: O}}}}\n"
        f"drives: {{crank: {{angle: {angle!r}, speed: {speed!r}}}}}\nassembly: {{B: [1, 0]}}\n"
    )


def stop_of(found, **arguments):
    with pytest.raises(IncompleteError) as caught:
        linkages.simulate(found, **arguments)
    return caught.value


def angle_at(distance, crank, ground):
    """Crank angle at which its pin is that far from the other ground pin (law of cosines)."""
    return np.arccos((crank**2 + ground**2 - distance**2) / (2 * crank * ground))


@pytest.mark.parametrize("speed", [1.0, -3.0])
@pytest.mark.parametrize("samples", [2, 7, 1001])
@pytest.mark.parametrize(
    ("lengths", "distance", "outwards"),
    [((0.06, 0.07, 0.05, 0.1), 0.07 + 0.05, 1), ((0.09, 0.2, 0.05, 0.1), 0.2 - 0.05, -1)],
    ids=["stretched", "folded"],
)
def test_four_bar_whose_crank_cannot_turn_fully(lengths, distance, outwards, samples, speed):
    """Coupler and rocker stretched out, reached from within, or folded, reached from without."""
    direction = np.sign(speed)
    limit = outwards * direction * angle_at(distance, lengths[0], lengths[3])
    expected = 0.4 / abs(speed)
    found = four_bar(*lengths, angle=limit - 0.4 * direction, speed=speed)
    error = stop_of(found, end=2.0, samples=samples)
    # Bisected to the last digit of time; the angle itself is rounded at 1e-16 of some radians,
    # and the law of cosines costs another digit.
    assert error.time == pytest.approx(expected, abs=1e-14)
    for words in ("joint B", "block 0", "coupler and rocker are in line"):
        assert words in str(error)
    assert f"t = {error.time:.9g} s" in str(error)
    assert error.exit_code == 1
    time = error.solution.data.time.to_numpy()
    wanted = np.linspace(0, 2, samples)
    assert np.array_equal(time, wanted[wanted < error.time])
    assert np.isfinite(error.solution.data.bar_angle).all()
    assert error.solution.completed is False


@pytest.mark.parametrize("rod", [0.05, 0.0999])
def test_rod_shorter_than_the_crank(rod):
    """It reaches the axis until sin θ = rod/crank."""
    limit = np.arcsin(rod / 0.1)
    error = stop_of(slider_crank(0.1, rod), end=7.0, samples=8)
    assert error.time == pytest.approx(limit - 0.1, abs=1e-12)
    for words in ("joint B", "rod is perpendicular to the axis of piston"):
        assert words in str(error)


def test_rod_as_long_as_the_crank_is_a_change_point():
    """At θ = 90° both lie across the axis: the piston stands on O and may go on or stay."""
    error = stop_of(slider_crank(0.1, 0.1), end=7.0, samples=8)
    # The margin is cos θ.
    assert error.time == pytest.approx(np.pi / 2 - 0.1, abs=LEAST_MARGIN)
    assert "singular" in str(error)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("samples", [2, 3, 50])
def test_gap_much_shorter_than_the_sample_spacing(gap, samples):
    """Stretched links that miss by `gap`: out of reach for √(2·0.14·gap/0.004) rad around 180°."""
    crank, ground = 0.04, 0.1
    found = four_bar(crank, 0.08, crank + ground - 0.08 - gap, ground)
    error = stop_of(found, end=6.0, samples=samples)
    coupler, rocker = 0.08, crank + ground - 0.08 - gap
    limit = angle_at(coupler + rocker, crank, ground)
    # The margin (the sine of the angle between the links) may end the motion before they part.
    cosine = np.sqrt(1 - LEAST_MARGIN**2)
    singular = angle_at(
        np.sqrt(coupler**2 + rocker**2 + 2 * coupler * rocker * cosine), crank, ground
    )
    # arccos near −1 loses digits: some roundings of the cosine over what is left to 180°.
    slack = 4e-15 / (np.pi - limit)
    assert singular - slack <= error.time + 0.5 <= limit + slack
    assert "joint B" in str(error)


def test_gap_between_samples_of_a_fast_drive():
    """A hundred turns between two samples."""
    found = four_bar(0.04, 0.08, 0.06 - 1e-9, 0.1, speed=100 * 2 * np.pi)
    error = stop_of(found, end=1.0, samples=2)
    assert error.time < (np.pi - 0.5) / (100 * 2 * np.pi)


@pytest.mark.parametrize("samples", [2, 1001])
@pytest.mark.parametrize(
    ("angle", "speed", "expected"),
    [(0.5, 1.0, np.pi - 0.5), (0.5, -1.0, 0.5), (3.5, 1.0, 2 * np.pi - 3.5)],
)
def test_parallelogram_passes_no_change_point(angle, speed, expected, samples):
    """All four bars are in line at 0° and 180°: from there it may go on as an antiparallelogram."""
    side = "left" if np.sin(angle) > 0 else "right"
    found = four_bar(0.04, 0.1, 0.04, 0.1, angle=angle, speed=speed, side=side)
    error = stop_of(found, end=6.0, samples=samples)
    # The margin is the sine of the angle that is left.
    assert error.time == pytest.approx(expected, abs=LEAST_MARGIN)
    for words in ("joint B", "coupler and rocker are in line", "singular"):
        assert words in str(error)
    assert (error.solution.data.time < error.time).all()


def test_parallelogram_from_its_change_point(tmp_path):
    error = stop_of(four_bar(0.04, 0.1, 0.04, 0.1, angle=0.0), end=1.0, samples=3)
    assert error.time == 0.0
    assert "singular" in str(error)
    assert error.solution.data.sizes["time"] == 0
    assert error.solution.maxima == []
    netcdf, text = error.solution.save(tmp_path)
    assert netcdf.is_file()
    assert len(text.read_text().splitlines()) == 1  # the heads


@pytest.mark.parametrize("samples", [2, 361])
def test_close_to_a_change_point_is_passed(samples):
    """Least margin 1e-3, in closed form: |sin| of the angle of coupler and rocker when the crank
    is in line with the ground; the side of B stays what it was.
    """
    crank, coupler, ground = 0.04, 0.1, 0.1
    rocker = brentq(lambda r: least_margin(crank, coupler, r, ground) - 1e-3, 0.04, 0.05)
    found = four_bar(crank, coupler, rocker, ground)
    data = linkages.simulate(found, end=2 * np.pi, samples=samples).data
    assert data.sizes["time"] == samples
    a, b, o = (data.joint_position.sel(joint=joint).to_numpy() for joint in ("A", "B", "O4"))
    cross = (o - a)[:, 0] * (b - a)[:, 1] - (o - a)[:, 1] * (b - a)[:, 0]
    assert (cross > 0).all()
    assert float(data.closure_residual.max()) <= 1e-13


def least_margin(crank, coupler, rocker, ground):
    margins = []
    for gap in (ground - crank, ground + crank):
        cosine = (coupler**2 + rocker**2 - gap**2) / (2 * coupler * rocker)
        margins.append(np.sqrt(max(0.0, 1 - cosine**2)))
    return min(margins)


def folding_time():
    """When E, left of O→B, comes to stand over the ground pin O; the press without clearance."""

    def height(time):
        a = 0.3 * np.exp(1j * (np.radians(15) - np.pi * time))
        c = 1.1 + 0.1 * np.exp(1j * (np.radians(150) + np.pi * time))
        b = apex(a, c, 0.893, 0.962)
        return apex(0.0, b, 0.85, 0.623).real

    return brentq(height, 1.5, 1.6, xtol=1e-14)


def apex(p, q, first, second):
    """The point left of p→q at two distances."""
    gap = abs(q - p)
    along = (gap**2 + first**2 - second**2) / (2 * gap)
    return p + (q - p) / gap * (along + 1j * np.sqrt(first**2 - along**2))


def test_press_folded_onto_itself():
    """With E on the left, bars 6 and 8 fold onto each other where E crosses x = 0."""
    press = linkages.load("ninebar-ideal", set={"assembly.E": "left"})
    error = stop_of(press)
    # The margin is |cos θ8|, and link 8 crosses at some 0.8 rad/s.
    assert error.time == pytest.approx(folding_time(), abs=2 * LEAST_MARGIN)
    for words in ("joint F", "block 2", "link8 is perpendicular to the axis of slider9"):
        assert words in str(error)
    assert error.solution.data.sizes["time"] == np.ceil(error.time / 1e-3)


def test_press_with_clearance_folded_onto_itself():
    press = linkages.load("ninebar", set={"assembly.E": "left"})
    error = stop_of(press)
    # B strays by about the clearance over the speed at which E crosses: 1.5e-4 m/(0.7 m/s).
    assert error.time == pytest.approx(folding_time(), abs=4e-4)
    for words in ("joint F", "block 2", "link8 is perpendicular to the axis of slider9", "Change"):
        assert words in str(error)
    data = error.solution.data
    assert 0 < error.time - float(data.time[-1]) <= 1e-3
    assert all(np.isfinite(values).all() for values in data.data_vars.values())


def test_free_motion_into_a_position_that_cannot_be_passed():
    """Nothing drives: a heavy crank runs up to where coupler and rocker are stretched out."""
    found = mechanism(
        "joints: {O2: [0, 0], O4: [0.1, 0]}\n"
        "bars:\n  crank: {joints: [O2, A], length: 0.06, mass: 1}\n"
        "  coupler: {joints: [A, B], length: 0.07}\n"
        "  rocker: {joints: [O4, B], length: 0.05}\n"
        "free: {crank: {angle: 0.5, speed: 2}}\nassembly: {B: left}\n"
    )
    error = stop_of(found, end=2.0, samples=201)
    # The other bars have no mass, so the crank turns at constant speed. With the rocker free in its
    # place there, less and less of that mass moves with what is free, and its speed has no bound.
    assert error.time == pytest.approx((angle_at(0.12, 0.06, 0.1) - 0.5) / 2, abs=1e-8)
    for words in (f"at t = {error.time:.9g} s", "Look for a force that grows without bound"):
        assert words in str(error)
    assert any("crank was exchanged for rocker" in note for note in error.solution.notes)
    assert float(np.abs(error.solution.data.bar_speed.sel(bar="crank") - 2).max()) < 1e-6


def test_free_motion_turns_back_where_it_cannot_be_passed():
    """The same with a rocker that has mass: it throws itself over, and the crank turns back."""
    found = mechanism(
        "joints: {O2: [0, 0], O4: [0.1, 0]}\n"
        "bars:\n  crank: {joints: [O2, A], length: 0.06, mass: 1}\n"
        "  coupler: {joints: [A, B], length: 0.07}\n"
        "  rocker: {joints: [O4, B], length: 0.05, mass: 0.1}\n"
        "free: {crank: {angle: 0.5, speed: 2}}\nassembly: {B: left}\n"
    )
    data = linkages.simulate(found, end=2.0, samples=2001, rtol=1e-11, outputs="all").data
    angle = data.bar_angle.sel(bar="crank").to_numpy()
    limit = angle_at(0.12, 0.06, 0.1)
    assert limit - 1e-4 < angle.max() <= limit + 1e-12
    assert data.bar_speed.sel(bar="crank")[-1] != 2
    assert (np.diff(angle) < 0).any()
    energy = data.kinetic_energy.to_numpy()
    assert energy == pytest.approx(energy[0], rel=1e-8)


@pytest.mark.slow_except("1e-09", "0.0")
@pytest.mark.parametrize("gap", [1e-6, 1e-9, 0.0])
def test_free_motion_over_a_gap_shorter_than_its_steps(gap):
    """A flywheel that nothing brakes: but for the links, steps could take whole radians."""
    found = mechanism(
        "joints: {O2: [0, 0], O4: [0.1, 0]}\n"
        "bars:\n  crank: {joints: [O2, A], length: 0.04, mass: 1, inertia: 100}\n"
        "  coupler: {joints: [A, B], length: 0.08}\n"
        f"  rocker: {{joints: [O4, B], length: {0.06 - gap!r}}}\n"
        "free: {crank: {angle: 0.5, speed: 1}}\nassembly: {B: left}\n"
    )
    error = stop_of(found, end=6.0, samples=7, change_points="stop")
    assert error.time == pytest.approx(angle_at(0.14 - gap, 0.04, 0.1) - 0.5, abs=1e-4)
    if gap:  # without a gap the links meet in a change point, which may be passed
        error = stop_of(found, end=6.0, samples=7, change_points="pass")
        assert error.time == pytest.approx(angle_at(0.14 - gap, 0.04, 0.1) - 0.5, abs=1e-4)


def test_without_throwing():
    solution = linkages.simulate(
        four_bar(0.06, 0.07, 0.05, 0.1), end=6.0, samples=61, throw=False, outputs="all"
    )
    assert not solution.completed
    assert solution.motion.stop_time == pytest.approx(angle_at(0.12, 0.06, 0.1) - 0.5, abs=1e-14)
    assert "joint B" in solution.motion.failure
    assert solution.data.sizes["time"] == len(solution.motion.time) > 10
    whole = linkages.simulate(
        four_bar(0.06, 0.07, 0.05, 0.1),
        end=float(solution.data.time[-1]),
        samples=solution.data.sizes["time"],
        outputs="all",
    )
    assert np.allclose(solution.data.drive_effort, whole.data.drive_effort, rtol=1e-9, atol=1e-15)


def test_steps_run_out():
    error = stop_of(linkages.load("ninebar"), end=2.0, samples=201, max_steps=1000)
    assert "Raise max_steps" in str(error)
    assert 0.05 < error.time < 0.5
    assert (error.solution.data.time <= error.time).all()


def test_coordinates_that_move_no_mass_together_are_named():
    """Both bars of a stretched pair move the mass at its end the same way, the third its own."""
    text = """
joints: {O: [0, 0], C: [5, 0]}
bars:
  one: {joints: [O, P], length: 1}
  two: {joints: [P, Q], length: 1}
  other: {joints: [C, R], length: 1, mass: 1}
masses: {Q: 1}
free: {other: {angle: 0}, one: {angle: 0}, two: {angle: 0}}
"""
    with pytest.raises(InputError, match="no mass moves with one and two at t = 0"):
        linkages.simulate(mechanism(text), end=1.0, samples=3)


def test_a_driven_cylinder_at_its_longest_is_named_by_its_pin():
    """Lever and barrel in line: 0.5 m and the distance of their ground joints; told to 1 ns."""
    boom = mechanism("""joints: {O: [0, 0], D: [0.4, -0.1]}
bars: {lever: {joints: [O, A], length: 0.5, mass: 3}, barrel: {joints: [D, E], length: 0.2}}
sliders: {rod: {joint: A, on: barrel}}
drives: {rod: {position: 0.3, speed: 0.7}}
assembly: {A: left}
""")
    stop = stop_of(boom, end=1.0, samples=11)
    time = (0.5 + np.hypot(0.4, 0.1) - 0.3) / 0.7
    assert f"at t = {time:.9g} s, joint A, block 0" in str(stop)
