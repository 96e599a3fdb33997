import os
import subprocess
import sys
from functools import cache

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from plot_data import press, press_data

from linkages.plots import save_figures, style, write_figure
from linkages.plots.figures import OF_ALL
from linkages.plots.study_figures import convergence


def test_all_figures_are_written(tmp_path):
    written = save_figures(press_data(), press(), tmp_path / "new" / "folder")
    # nothing drives its slider, and its contact is never lost
    missing = {"drive_force", "clearance_orbit", "clearance_state"}
    missing |= {name for name in OF_ALL if "actuator" in name}
    names = [name for name in OF_ALL if name not in missing]
    assert [path.name for path in written] == [f"{name}.png" for name in names]
    assert sorted(os.listdir(tmp_path / "new" / "folder")) == sorted(p.name for p in written)


def test_only_what_the_data_allow(tmp_path):
    data = press_data()[["slider_position", "drive_effort"]]
    written = save_figures(data, press(), tmp_path)
    assert [path.stem for path in written] == ["slider_position", "drive_effort"]
    assert save_figures(press_data().isel(time=slice(0)), press(), tmp_path) == []


@pytest.mark.slow_except("png")
@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_same_data_give_the_same_bytes(tmp_path, kind):
    names = ["mechanism", "phase", "drive_effort"]
    first, second = (
        save_figures(press_data(), press(), tmp_path / folder, kind, names) for folder in "ab"
    )
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def test_a_users_own_settings_change_nothing(tmp_path):
    (plain,) = save_figures(press_data(), press(), tmp_path / "a", names=["phase"])
    own = {"font.size": 20, "lines.linewidth": 5, "axes.facecolor": "black", "savefig.dpi": 30}
    with matplotlib.rc_context(own):
        (other,) = save_figures(press_data(), press(), tmp_path / "b", names=["phase"])
        assert matplotlib.rcParams["font.size"] == 20
    assert plain.read_bytes() == other.read_bytes()


def test_a_failure_leaves_nothing_behind(tmp_path):
    class Broken(Figure):
        def savefig(self, fname, **_):
            with open(fname, "wb") as file:
                file.write(b"half a figure")
            raise OSError("disk full")

    path = tmp_path / "phase.png"
    path.write_bytes(b"an older figure")
    with pytest.raises(OSError, match="disk full"):
        write_figure(Broken(), path)
    assert os.listdir(tmp_path) == ["phase.png"]
    assert path.read_bytes() == b"an older figure"


def test_unknown_format_or_name(tmp_path):
    with pytest.raises(ValueError, match="unknown format 'bmp'; expected one of: png, pdf, svg"):
        save_figures(press_data(), press(), tmp_path, "bmp")
    with pytest.raises(ValueError, match="unknown figure 'phases'; expected one of: mechanism,"):
        save_figures(press_data(), press(), tmp_path, names=["phases"])
    assert os.listdir(tmp_path) == []


def test_pyplot_is_never_imported():
    # It costs a third of a second and keeps every figure alive.
    program = (
        "import sys, tempfile, pathlib\n"
        "from plot_data import press, press_data\n"
        "from linkages.plots import save_figures\n"
        "with tempfile.TemporaryDirectory() as folder:\n"
        "    assert save_figures(press_data(), press(), pathlib.Path(folder))\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
    )
    path = os.pathsep.join(sys.path)
    environment = {**os.environ, "PYTHONPATH": path}
    subprocess.run([sys.executable, "-c", program], check=True, env=environment)


@pytest.mark.parametrize("values", [[0.08, 0.0725, 0.0724, 0.0724], [0.0724693331] * 4])
def test_the_convergence_of_a_search_shows_every_run(values):
    """Whole numbers of runs, labels within the figure, and runs that miss a constraint."""
    values = np.array(values) + 1e-12 * np.arange(4)
    best = np.where(np.arange(4) < 2, np.nan, values)
    violation = np.array([1e-2, 1e-5, 0.0, 0.0])
    about = {"units": "m", "long_name": "stroke(piston.position)"}
    data = xr.Dataset(
        {"history": ("run", best, about), "history_value": ("run", values),
         "history_violation": ("run", violation), "value": ("state", values[[0, -1]])},
        attrs={"name": "Slider-crank"},
    )  # fmt: skip
    figure = convergence(data)
    figure.draw_without_rendering()
    (ax,) = figure.axes
    missed = next(line for line in ax.lines if line.get_label() == "constraints not met")
    assert missed.get_xdata().tolist() == [1, 2]
    low, high = ax.get_ylim()
    assert all(low < 1e3 * value < high for value in values)
    assert high - low > 9 * abs(values).max()
    assert [text.get_text() for text in ax.get_xticklabels()][1:-1] == ["1", "2", "3", "4"]
    assert ax.get_ylabel() == "stroke(position of piston) [mm]"
    whole = figure.bbox
    for text in (ax.yaxis.label, ax.xaxis.label, *ax.get_yticklabels()):
        box = text.get_window_extent()
        assert whole.x0 <= box.x0
        assert box.x1 <= whole.x1
        assert box.y0 >= whole.y0


@pytest.mark.slow
def test_characters_without_a_glyph_are_said_once(tmp_path, monkeypatch, caplog):
    """Warnings are errors here; fonts beside that of Matplotlib are taken away."""
    monkeypatch.setattr(style, "FALLBACKS", ())
    monkeypatch.setattr(style, "_said", set())
    for cached in (style._settings, style._drawable):
        monkeypatch.setattr(style, cached.__name__, cache(cached.__wrapped__))
    figure = Figure()
    figure.add_subplot().set_title("曲柄 crank 한글")
    for name in ("a.png", "b.svg", "c.pdf"):
        write_figure(figure, tmp_path / name)
    (said,) = caplog.messages
    assert "figures show boxes for 曲柄글한: no font that was found has these" in said
