"""``plot``: outputs of one or several motions over each other; and what `phase` refuses."""

import csv
import json

import numpy as np
import pytest

SPEEDS = "drives.crank.speed=60rpm,120rpm"


def columns(path):
    with path.open(newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, zip(*rows, strict=True), strict=True))


def numbers(column):
    return np.array([float(cell) for cell in column if cell])


def test_series_of_several_values_over_a_coordinate(cli, tmp_path):
    """A rocker's angle is that of its crank whatever the speed; its speed follows the crank's."""
    result = cli(
        "plot", "four-bar", "--y", "rocker.angle", "--y", "rocker.speed",
        "--against", "crank.angle", "--vary", SPEEDS,
    )  # fmt: skip
    assert (result.code, result.err) == (0, "")
    name = "plot_rocker.angle_rocker.speed_over-crank.angle"
    assert {f"results/four-bar/{name}.{end}" for end in ("png", "csv")} <= {*result.files}
    found = columns(tmp_path / f"results/four-bar/{name}.csv")
    slow, fast = (f", speed of crank = {speed} rpm" for speed in (60, 120))
    crank, angle, speed = (
        [numbers(found[f"{head}{whose}"]) for whose in (slow, fast)]
        for head in (
            "angle of crank (rad)", "angle of rocker (rad)", "angular speed of rocker (rad/s)"
        )
    )  # fmt: skip
    # the same function of the crank's angle, by lines through samples 0.003 rad apart
    np.testing.assert_allclose(angle[0], np.interp(crank[0], crank[1], angle[1]), atol=1e-5)
    np.testing.assert_allclose(2 * speed[0], np.interp(crank[0], crank[1], speed[1]), atol=1e-3)


def test_a_difference_is_that_of_the_motions(cli, tmp_path):
    """Over the crank's angle a rocker at twice the speed differs by the speed of the first."""
    how = ("--y", "rocker.speed", "--against", "crank.angle", "--vary", SPEEDS, "--no-figures")
    assert cli("plot", "four-bar", *how).code == 0
    assert cli("plot", "four-bar", *how, "--difference").code == 0
    folder = tmp_path / "results/four-bar"
    whole = columns(folder / "plot_rocker.speed_over-crank.angle.csv")
    less = columns(folder / "plot_rocker.speed_over-crank.angle_difference.csv")
    angle, found = (numbers(less[head]) for head in less if not head.startswith("time"))
    slow = ", speed of crank = 60 rpm"
    own = [numbers(whole[f"{head}{slow}"])
           for head in ("angle of crank (rad)", "angular speed of rocker (rad/s)")]  # fmt: skip
    np.testing.assert_allclose(found, np.interp(angle, *own), atol=1e-3)


@pytest.mark.slow
def test_saved_runs_and_files_lie_over_each_other(cli, tmp_path):
    """Those of a folder are computed again as they were."""
    fast = ("--set", "drives.crank.speed=90 rpm", "--end", "0.5")
    assert cli("simulate", "four-bar", *fast, "--no-figures", "--out", "fast").code == 0
    result = cli("plot", "four-bar", "fast/simulate.nc", "--y", "rocker.angle", "--json")
    content = json.loads(result.out)
    assert [row["of"] for row in content["series"]] == [
        "speed of crank = 60 rpm", "speed of crank = 90 rpm",
    ]  # fmt: skip
    found = columns(tmp_path / "results/four-bar/plot_rocker.angle.csv")
    times = [numbers(column) for head, column in found.items() if head.startswith("time")]
    assert [time[-1] for time in times] == [1.0, 0.5]
    cli.refused("plot", "fast/simulate.nc", "--y", "B.speed", "--out", "o", says="B has no 'speed'")
    assert cli("plot", "fast/simulate.nc", "--y", "B.velocity", "--out", "o").code == 0


def test_reactions_in_a_polar_diagram(cli, tmp_path):
    """At each instant the components of the resultant are those that simulate gives."""
    result = cli("plot", "slider-crank", "--y", "B.reaction", "--polar")
    assert result.code == 0
    found = columns(tmp_path / "results/slider-crank/plot_B.reaction_polar.csv")
    x, y = (numbers(column) for head, column in found.items() if not head.startswith("time"))
    arguments = ("--outputs", "joint_reaction", "--no-figures", "--json")
    rows = json.loads(cli("simulate", "slider-crank", *arguments).out)["maxima"]
    (largest,) = [row["value"] for row in rows if row["element"] == "B"]
    assert np.hypot(x, y).max() == pytest.approx(largest, rel=1e-5)


def test_each_plot_has_files_of_its_own(cli, tmp_path):
    """Other series leave the files of earlier ones alone; the same ones take their place."""
    for name in ("rocker.angle", "rocker.speed", "rocker.angle"):
        assert cli("plot", "four-bar", "--y", name, "--no-figures").code == 0
        assert cli("phase", "four-bar", "--x", "crank.angle", "--y", name, "--no-figures").code == 0
    files = {path.name for path in (tmp_path / "results/four-bar").iterdir() if path.is_file()}
    assert files == {
        *(f"plot_rocker.{name}.csv" for name in ("angle", "speed")),
        *(f"phase_crank.angle_rocker.{n}.{e}" for n in ("angle", "speed") for e in ("nc", "csv")),
    }


def test_formulas_are_drawn_as_series_are(cli, tmp_path):
    """A drive at constant speed: the integral of its speed is its angle from the start."""
    turned = "cumulative(crank.speed)"
    result = cli("plot", "four-bar", "--y", turned, "--y", "crank.angle - 1 rad + 1 rad*2/2")
    assert (result.code, result.err) == (0, "")
    assert "cumulative(crank.speed)" in result.out
    (table,) = (tmp_path / "results/four-bar").glob("*.csv")
    found = columns(table)
    own, angle = (numbers(found[head]) for head in found if head != "time (s)")
    np.testing.assert_allclose(own, angle - angle[0], atol=1e-9)
    cli.refused("plot", "four-bar", "--y", "cumulative(crank.sped)", says="crank has no 'sped'")
    cli.refused("plot", "four-bar", "--polar", "--y", "2*crank.angle", says="has no direction")
