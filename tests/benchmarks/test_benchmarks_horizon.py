"""How long a motion can be predicted: found by comparison, told, and shown in figures."""

import json

import numpy as np
import pytest

import linkages
from linkages.cli.main import main
from linkages.plots.figures import FIGURES
from linkages.plots.motion.curves import TEXT
from linkages.plots.motion.time_figures import draw
from linkages.plots.panels import panels

THROWN = """\
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars:
  upper: {joints: [O, P], length: 1, mass: 1, center: 1, inertia: 0}
  lower: {joints: [P, Q], length: 1, mass: 1, center: 1, inertia: 0}
free: {upper: {angle: 0.4, speed: 0}, lower: {angle: 0.9, speed: 0}}
"""
CHAOTIC = {"clearances.r1.angle": np.pi / 2}


def horizon_of(end, given=None, **settings):
    solution = linkages.simulate(
        linkages.load("ninebar", set=given or {}),
        end=end,
        samples=round(500 * end) + 1,
        outputs=["clearance_angle"],
        **settings,
    )
    return solution.horizon


@pytest.mark.parametrize("method", ["dop853", "vern9"])
def test_regular_motion_is_predictable_throughout(method):
    horizon = horizon_of(2.0, method=method)
    assert horizon.whole
    assert horizon.time == 2.0
    # 1e-10 per step over 1e4 steps, in units of an amplitude of some radians
    assert horizon.error < 1e-5


@pytest.fixture(scope="module")
def chaotic():
    """Horizons over 20 s of a start from which the clearance link turns over and back."""
    return {rtol: horizon_of(20.0, CHAOTIC, rtol=rtol) for rtol in (1e-6, 1e-8, 1e-10)}


@pytest.mark.slow
def test_chaotic_motion_has_a_horizon(chaotic):
    horizon = chaotic[1e-8]
    assert not horizon.whole
    assert 0.1 < horizon.time < 20.0
    assert horizon.error > 5e-4


@pytest.mark.slow
def test_tighter_tolerance_reaches_further(chaotic):
    times = [chaotic[rtol].time for rtol in (1e-6, 1e-8, 1e-10)]
    assert times[0] < times[1] < times[2]


def test_errors_of_a_chaotic_motion_grow_exponentially():
    """A double pendulum thrown from above: a factor of a hundred buys some time more.

    With errors that grow as exp(λt) that is ln(100)/λ, here about 2 s; the errors of a regular
    swing grow as t², and the same factor would multiply the time by ten.
    """
    mechanism = linkages.loads(THROWN)
    times = []
    for rtol in (1e-6, 1e-8, 1e-10, 1e-12):
        solution = linkages.simulate(
            mechanism, end=60.0, samples=6001, rtol=rtol, outputs=["bar_angle"]
        )
        assert not solution.horizon.whole
        times.append(solution.horizon.time)
    gains = np.diff(times)
    assert (gains > 0.3).all()
    assert (gains < 6).all()


@pytest.mark.slow
def test_horizon_is_where_a_still_tighter_run_says(chaotic):
    """Until the horizon of 1e-8 the run agrees with one at 1e-13 to three digits."""
    runs = [
        linkages.simulate(
            linkages.load("ninebar", set=CHAOTIC),
            end=20.0,
            samples=10_001,
            rtol=rtol,
            outputs=["clearance_angle"],
        ).data
        for rtol in (1e-8, 1e-13)
    ]
    apart = np.abs(runs[0].clearance_angle - runs[1].clearance_angle).to_numpy()[:, 0]
    time = runs[0].time.to_numpy()
    until = chaotic[1e-8].time
    amplitude = 0.5 * np.ptp(runs[1].clearance_angle.to_numpy())
    # The comparison run itself is off by about a hundredth of what is compared.
    assert apart[time <= until].max() <= 1e-3 * amplitude
    assert apart[time > until].max() > 1e-4 * amplitude


def test_fixed_steps_are_compared_with_half_of_them():
    coarse = horizon_of(2.0, method="rk4", step=5e-4)
    fine = horizon_of(2.0, method="rk4", step=1e-5)
    assert not coarse.whole
    assert coarse.time < 0.5
    assert fine.whole


def test_nothing_to_compare_where_nothing_is_integrated():
    assert linkages.simulate(linkages.load("slider-crank")).horizon is None
    assert linkages.simulate(linkages.load("ninebar-ideal")).horizon is None


def test_tightest_tolerance_has_nothing_tighter():
    from linkages.solvers.integration import LEAST_RTOL

    assert horizon_of(0.02, rtol=LEAST_RTOL) is None


def test_horizon_of_a_run_that_was_cut_short():
    """Compared up to where both got: the end of what there is."""
    found = linkages.simulate(
        linkages.load("ninebar", set={"assembly.E": "left"}), samples=2001, throw=False
    )
    assert not found.completed
    assert found.horizon is not None
    assert found.horizon.time <= found.motion.stop_time


def test_mechanism_at_rest_is_predictable():
    """A pendulum that hangs still: what is compared is round-off, in units of round-off."""
    hanging = THROWN.replace("angle: 0.4", "angle: -pi/2").replace("angle: 0.9", "angle: -pi/2")
    mechanism = linkages.loads(hanging)
    assert linkages.simulate(mechanism, end=5.0, samples=11).horizon.whole


def test_step_of_which_half_diverges_has_a_horizon():
    """One step of 50 ms, after which the clearance turns at 1e15 rad/s; halves of it diverge."""
    solution = linkages.simulate(
        linkages.load("ninebar"), end=0.05, samples=2, method="rk4", step=0.05
    )
    assert solution.horizon is not None
    assert not solution.horizon.whole


# -- figures ---------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def solution():
    return linkages.simulate(linkages.load("ninebar"), end=0.1, samples=101)


def shades(data, name):
    figure = FIGURES[name](data, solution_mechanism)
    return [text.get_text() for text in figure.axes[0].texts if text.get_text() == TEXT]


solution_mechanism = linkages.load("ninebar")
TIMES = ["slider_position", "slider_velocity_error", "drive_effort", "clearance_force"]


@pytest.mark.parametrize("name", TIMES)
def test_time_figure_is_shaded_beyond_the_horizon(solution, name):
    shaded = solution.data.assign_attrs(horizon=0.04)
    assert shades(shaded, name) == ["not predictable"]
    assert shades(solution.data, name) == []


@pytest.mark.parametrize("until", [0.04, 0.098])
def test_shade_reaches_from_the_horizon_to_the_end(solution, until):
    figure, (ax,) = panels(1, 1, 2.0)
    plain, _ = len(ax.patches), draw(ax, solution.data, "slider_position")
    figure, (ax,) = panels(1, 1, 2.0)
    draw(ax, solution.data.assign_attrs(horizon=until), "slider_position")
    (patch,) = ax.patches[plain:]
    edges = patch.get_x(), patch.get_x() + patch.get_width()
    scale = ax.get_xlim()[1] / 0.1
    assert edges == pytest.approx((until * scale, 0.1 * scale))
    # the words stay within the axes
    figure.canvas.draw()
    (words,) = [text for text in ax.texts if text.get_text() == TEXT]
    box, frame = words.get_window_extent(), ax.get_window_extent()
    assert frame.x0 <= box.x0
    assert box.x1 <= frame.x1


# -- the command line ------------------------------------------------------------------------


SHORT = ("--set", "simulate.end=0.05", "--set", "simulate.samples=51", "--no-figures")
COARSE = ("--set", "simulate.method=rk4", "--set", "simulate.step=1e-3")


@pytest.mark.slow
def test_horizon_in_json(cli):
    result = cli("simulate", "ninebar", *SHORT, "--json")
    assert result.code == 0
    assert json.loads(result.out)["horizon"] == pytest.approx(
        {"time": 0.05, "whole": True, "error": 0.0}, abs=1e-5
    )


@pytest.mark.slow
def test_no_horizon_without_verifying(cli):
    result = cli("simulate", "ninebar", *SHORT, "--no-verify", "--json")
    assert (result.code, json.loads(result.out)["horizon"]) == (0, None)
    result = cli("simulate", "ninebar", *SHORT, *COARSE, "--json")
    assert (result.code, json.loads(result.out)["horizon"]) == (0, None)


@pytest.mark.slow
def test_horizon_of_fixed_steps_on_request(cli, tmp_path):
    import xarray as xr

    result = cli("simulate", "ninebar", *SHORT, *COARSE, "--verify")
    assert result.code == 0
    assert "predictable to t = " in " ".join(result.out.split())
    with xr.open_dataset(tmp_path / "results" / "ninebar" / "simulate.nc") as data:
        assert 0 <= float(data.attrs["horizon"]) < 0.05


def test_driven_mechanism_says_nothing_of_a_horizon(cli):
    result = cli("simulate", "slider-crank", "--no-figures", "--json")
    assert (result.code, json.loads(result.out)["horizon"]) == (0, None)


@pytest.mark.slow_except("vern9-True")
@pytest.mark.parametrize(
    ("method", "verified"), [("dop853", True), ("vern9", True), ("tsit5", False)]
)
def test_runs_are_verified_unasked_where_that_is_cheap(
    method, verified, capsys, monkeypatch, tmp_path
):
    """A hundredth of the tolerance costs an order-5 method 2.5 times the run, 3.5 in all."""
    monkeypatch.chdir(tmp_path)
    argv = ["linkages", "simulate", "ninebar.yaml", "--no-figures", "--set", "simulate.end=0.01"]
    monkeypatch.setattr("sys.argv", [*argv, "--set", f"simulate.method={method}"])
    with pytest.raises(SystemExit) as stopped:
        main()
    assert stopped.value.code in (0, None)
    assert ("predictable" in capsys.readouterr().out) is verified
