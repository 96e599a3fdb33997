"""Fits against known numbers, covariances in closed form, and chance."""

import numpy as np
import pytest

import linkages
from linkages.design.measurements import measured_of

ROCKER = {"bars.crank.length": ("30 mm", "50 mm"), "bars.rocker.length": ("70 mm", "90 mm")}
TRUE = {"bars.crank.length": "38 mm", "bars.rocker.length": "83 mm"}
TIMES = np.linspace(0, 1, 61)

TURNED = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {crank: {joints: [O, A], length: 200 mm, mass: 3}}
masses: {A: 2 kg}
drives: {crank: {angle: 0.3, speed: 5}}
simulate: {end: 1, samples: 51}
"""


def traced(noise=0.0, seed=1):
    """Where the coupler point of a four-bar with other lengths goes, in mm."""
    true = linkages.load("four-bar", set=TRUE)
    data = linkages.simulate(true, times=TIMES, outputs=["joint_position"]).data
    place = data.joint_position.sel(joint="P").to_numpy()
    place = place + noise * np.random.default_rng(seed).normal(size=place.shape)
    return {"time (s)": TIMES, "P.x position [mm]": 1e3 * place[:, 0], "P.y position": place[:, 1]}


def test_a_fit_to_what_has_no_noise_is_exact():
    found = linkages.fit(linkages.load("four-bar"), traced(), ROCKER)
    numbers = found.data.number.sel(state="fit").to_numpy()
    # columns in mm were rounded to 1e-17 m, sensitivities are about one
    assert numbers == pytest.approx([0.038, 0.083], rel=1e-12)
    assert linkages.loads(found.text).components == found.mechanism.components
    assert "# third point P" in found.text  # comments of the file are kept


def test_numbers_and_chi_square_are_within_chance():
    """Five fits with two numbers each: pulls and chi-square as statistics say, at fixed seeds."""
    sigma = 1e-4
    pulls, squares = [], []
    for seed in range(5):
        found = linkages.fit(
            linkages.load("four-bar"), traced(sigma, seed), ROCKER,
            sigma={"P.x position": "0.1 mm", "P.y position": sigma},
        )  # fmt: skip
        data = found.data
        off = data.number.sel(state="fit").to_numpy() - [0.038, 0.083]
        pulls += [*(off / data.standard_error.to_numpy())]
        squares.append(data.attrs["chi_square"])
        assert data.attrs["degrees_of_freedom"] == 2 * 61 - 2
        assert 0.001 < data.attrs["probability"] < 0.999
    # ten pulls of a normal distribution; chi-square has the mean f and the variance 2 f
    assert np.abs(pulls).max() < 3.5
    assert 0.3 < np.std(pulls) < 1.8
    assert np.mean(squares) == pytest.approx(120, abs=4 * np.sqrt(2 * 120 / 5))


def effort(mass):
    """Of a crank with a point mass at its end: the moment of its weight."""
    return 9.81 * 0.2 * (3 / 2 + mass) * np.cos(0.3 + 5 * TIMES)


@pytest.mark.parametrize("known", [True, False])
def test_the_covariance_of_a_linear_model_is_in_closed_form(known):
    sigma = np.linspace(0.5, 2, 61)
    noise = sigma * np.random.default_rng(3).normal(size=61)
    measured = {"t (s)": TIMES, "crank.effort (N m)": effort(1.3) + noise}
    if known:
        measured["sigma crank.effort"] = sigma
    else:
        measured["weight crank.effort"] = 7 / sigma**2
    found = linkages.fit(linkages.loads(TURNED), measured, {"masses.A": ("0.1 kg", "9 kg")}).data
    row = 9.81 * 0.2 * np.cos(0.3 + 5 * TIMES) / sigma
    variance = 1 / (row @ row)
    expected = 1.3 + variance * (row @ (noise / sigma))
    rest = noise / sigma - row * (expected - 1.3)
    if not known:
        variance *= rest @ rest / 60
    # lengths and masses are round, and the model linear: round-off is what is left
    assert float(found.number[1, 0]) == pytest.approx(expected, rel=1e-9)
    assert float(found.covariance[0, 0]) == pytest.approx(variance, rel=1e-9)
    assert found.attrs["sigma_known"] == known
    assert np.isnan(found.attrs["probability"]) != known


def test_what_cannot_be_told_apart_is_said():
    """Half the mass of the bar does what a mass at its end does."""
    measured = {"t": TIMES, "crank.effort": effort(1.3)}
    vary = {"masses.A": (0.1, 9), "bars.crank.mass": (1, 9)}
    found = linkages.fit(linkages.loads(TURNED), measured, vary).data
    (note,) = found.attrs["notes"]
    assert "cannot be told apart" in note
    assert "masses.A by" in note
    assert np.isnan(found.standard_error.to_numpy()).all()
    masses = found.number.sel(state="fit").to_numpy()
    assert masses[0] + masses[1] / 2 == pytest.approx(1.3 + 1.5, rel=1e-9)


def test_numbers_that_change_nothing_and_bounds_are_said():
    measured = {"t": TIMES, "crank.effort": effort(1.3)}
    found = linkages.fit(linkages.loads(TURNED), measured, {"masses.A": (0.1, 1.0)}).data
    assert found.attrs["notes"] == ["masses.A is at its bound"]
    still = {"t": TIMES, "crank.angle": 0.3 + 5 * TIMES}
    found = linkages.fit(linkages.loads(TURNED), still, {"masses.A": (0.1, 3.0)}).data
    assert found.attrs["notes"] == ["masses.A changes nothing that was measured"]


def test_a_free_motion_is_fitted_and_gaps_are_left_out():
    """A pendulum with friction: what integrates has derivatives, too."""
    damped = {"dampers": [{"joint": "O", "damping": 0.03}]}
    times = np.linspace(0, 3, 121)
    true = linkages.simulate(linkages.load("pendulum", set=damped), times=times).data
    angle = true.bar_angle.sel(bar="rod").to_numpy()
    angle[10:20] = np.nan
    other = linkages.load("pendulum", set={"dampers": [{"joint": "O", "damping": 0.02}]})
    found = linkages.fit(
        other, {"t": times, "rod.angle": angle}, {"dampers[0].damping": (0.001, 0.1)}
    )
    # two integrations with other steps, at a tolerance of 1e-10
    assert float(found.data.number[1, 0]) == pytest.approx(0.03, rel=1e-7)
    assert found.data.attrs["values"] == 111


def test_ctrl_c_keeps_the_best_so_far():
    def watch(done, _best):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(linkages.Interrupted, match="after 2 runs") as caught:
        linkages.fit(linkages.load("four-bar"), traced(), ROCKER, watch=watch)
    assert caught.value.kept["fit"].attrs["interrupted"] == 1


MOVED = {"t": TIMES, "P.x position": TIMES}


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        ({"P.x position": TIMES}, "no column of times"),
        ({"t": TIMES}, "no column of an output"),
        ({"t": TIMES, "P.z position": TIMES}, "did you mean"),
        ({"t": TIMES, "P.x position (kg)": TIMES}, "is in m, found 'kg'"),
        ({"t": TIMES, "P.x position (mmm)": TIMES}, "mmm"),
        ({"t": TIMES, "P.x position": TIMES[:3]}, "as many numbers as times"),
        ({"t": TIMES[::-1], "P.x position": TIMES}, "later than the one before"),
        ({**MOVED, "rocker.angle": TIMES}, "different units"),
        ({**MOVED, "P.y position": TIMES, "sigma P.x position": TIMES + 1}, "P.y position"),
        ({**MOVED, "sigma P.x position": TIMES - 1}, "above zero"),
        ({**MOVED, "sigma Q (m)": TIMES}, "Q was not measured"),
        ({**MOVED, "P.x position (m)": TIMES}, "there twice"),
    ],
)  # fmt: skip
def test_bad_measurements_are_one_clear_message(measured, words):
    with pytest.raises(linkages.InputError, match="1 problem") as caught:
        measured_of(linkages.load("four-bar"), measured, None)
    assert words in str(caught.value)


def test_a_file_says_its_line(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("# trial 3\ntime (s);P.x position (mm)\n0;1\n0.1;\n0.2;a\n", encoding="utf-8")
    with pytest.raises(linkages.InputError, match=r"line 5, column 2.*found 'a'"):
        linkages.fit(linkages.load("four-bar"), path, ROCKER)
    path.write_text("t,P.x position\n0,1,2\n", encoding="utf-8")
    with pytest.raises(linkages.InputError, match=r"line 2.*expected 2 cells, found 3"):
        linkages.fit(linkages.load("four-bar"), path, ROCKER)
    path.write_text("t,crank.angle\n0," + "1" * 131_073, encoding="utf-8")
    with pytest.raises(linkages.InputError, match=r"line 2.*a cell is longer than 131072"):
        linkages.fit(linkages.load("four-bar"), path, ROCKER)
    with pytest.raises(ValueError, match=r"measured until 1 s"):
        linkages.fit(linkages.load("four-bar"), traced(), ROCKER, end=0.5)
