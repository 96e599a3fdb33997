"""Figures and charts of wear."""

import numpy as np
import pytest
import xarray as xr

from linkages import charts
from linkages.plots.motion.wear_figures import life_figure, wear_figures, write_film

COUNT, BINS = np.array([0.0, 1e6, 3e6]), 360


def worn(depth=1e-5):
    """One journal whose bearing wears on the right, and a block."""
    angle = (np.arange(BINS) + 0.5) * 2 * np.pi / BINS
    profile = np.zeros((3, 2, 2, BINS))
    profile[:, 0, 1] = depth * COUNT[:, None] / COUNT[-1] * np.maximum(np.cos(angle), 0.0)
    of = ("jump", "clearance")
    data = {
        "revolutions": ("jump", COUNT),
        "size": (of, np.outer(COUNT, [1e-11, 2e-11]) + 1e-4),
        "error": (of, np.outer(COUNT, [1e-13, 1e-13])),
        "work": (of, np.full((3, 2), 2.0)),
        "work_error": (of, np.full((3, 2), 0.1)),
        "depth": ((*of, "side", "angle"), profile),
    }
    coords = {"clearance": ["gap", "play"], "side": ["journal", "bearing"], "angle": angle}
    return xr.Dataset(data, coords, {"name": "Engine"})


def lives(parameters=("bars.rod.mass", "loads[0].force"), uncertainty=5.0):
    count = len(parameters)
    return xr.Dataset(
        {
            "nominal": ((), 1e6),
            "relative": ("draw", np.array([0.9, 1.1, 1.0, np.inf])),
            "life_quantile": ("percent", np.array([3e5, 1e6, np.inf])),
            "ends": (("parameter", "end"), np.tile([1.1, 0.9], (count, 1))),
        },
        {"percent": [10, 50, 90], "parameter": np.array(parameters, dtype=object)},
        {"name": "Engine", "uncertainty": uncertainty},
    )


def test_sizes_have_bands_of_their_errors():
    ax = charts.wear(worn())
    assert ax.get_xlabel() == "millions of revolutions"
    assert ax.get_ylabel() == "radial clearance [µm]"
    line = ax.lines[0].get_xydata()
    assert line == pytest.approx(np.stack([COUNT * 1e-6, 100 + 10 * COUNT * 1e-6], axis=1))
    band = ax.collections[0].get_paths()[0].vertices
    assert band[:, 1].max() == pytest.approx(130.3)


def test_depth_is_drawn_to_its_own_scale():
    """The deepest point is 0.38 outside of a bearing's circle of 0.62, half as deep earlier."""
    ax = charts.wear_depth(worn(), "gap")
    x, y = ax.lines[0].get_xydata().T
    assert np.hypot(x, y).max() == pytest.approx(1.0, rel=1e-3)
    assert np.hypot(x, y).min() == pytest.approx(0.62)
    assert "deepest 10 µm, all around 3.183 µm" in [text.get_text() for text in ax.texts]
    with pytest.raises(ValueError, match="unknown clearance 'gab'; expected one of: gap, play"):
        charts.wear_depth(worn(), "gab")


def test_blocks_have_no_polar_figure():
    figures = wear_figures(worn())
    assert len(figures["wear_depth"].axes) == 2
    assert wear_figures(worn(0.0))["wear_depth"] is None


def test_life_without_tolerances_and_with():
    """Copies that live for ever are left out of curves, and their quantiles of dots."""
    ax = charts.life(lives())
    assert [text.get_text() for text in ax.texts] == ["P10", "P50"]
    assert len(life_figure(lives()).axes) == 2
    assert len(life_figure(lives((), 1.0)).axes) == 1


def test_a_film_of_blocks_alone(tmp_path):
    write_film(worn(0.0), tmp_path / "w.gif")
    assert (tmp_path / "w.gif").stat().st_size > 1000


def test_a_profile_is_drawn_over_revolutions():
    """Its first outline is the round bearing, its last one the widest."""
    data = worn()
    angle = data["angle"].to_numpy()
    profile = np.full((3, 2, BINS), 1e-4)
    profile[:, 0] = np.maximum(1e-4, np.array([1.0, 1.5, 2.5])[:, None] * 1e-4 * np.cos(angle))
    data["profile"] = (("jump", "clearance", "angle"), profile)
    ax = charts.wear_profile(data, "gap")
    first, *_, last = (line.get_xydata() for line in ax.lines if len(line.get_xydata()) > 2)
    assert np.hypot(*first.T) == pytest.approx(np.full(BINS + 1, 0.64), rel=1e-4)
    assert np.hypot(*last.T).max() == pytest.approx(1.0)
    assert "clearance of 100 µm to 250 µm" in [text.get_text() for text in ax.texts]
    assert len(wear_figures(data)["wear_profile"].axes) == 2
    with pytest.raises(ValueError, match="expected wear with feedback='profile'"):
        charts.wear_profile(worn())
