import os
import subprocess
import sys

import matplotlib
import pytest
from matplotlib.figure import Figure
from plot_data import press, press_data

from linkages.plots import save_figures, write_figure
from linkages.plots.figures import OF_ALL


def test_all_figures_are_written(tmp_path):
    written = save_figures(press_data(), press(), tmp_path / "new" / "folder")
    # nothing drives its slider, and its contact is never lost
    missing = {"drive_force", "clearance_orbit", "clearance_state"}
    names = [name for name in OF_ALL if name not in missing]
    assert [path.name for path in written] == [f"{name}.png" for name in names]
    assert sorted(os.listdir(tmp_path / "new" / "folder")) == sorted(p.name for p in written)


def test_only_what_the_data_allow(tmp_path):
    data = press_data()[["slider_position", "drive_effort"]]
    written = save_figures(data, press(), tmp_path)
    assert [path.stem for path in written] == ["slider_position", "drive_effort"]
    assert save_figures(press_data().isel(time=slice(0)), press(), tmp_path) == []


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
