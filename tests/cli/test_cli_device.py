"""``--device cuda`` on the command line: without a graphics processor, and on a stand-in."""

import pytest
import xarray as xr
from stand_in_driver import installed

from linkages.kernel.code import cuda
from linkages.kernel.code.cuda import Device, DeviceError
from linkages.solvers import device_motions as accelerated

SWEEP = (
    "sweep", "ninebar", "--measure", "final(r1.angle)", "--vary",
    "bars.link2.mass=1:2:3", "--set", "simulate.end=0.01", "--set", "simulate.samples=3",
    "--no-figures",
)  # fmt: skip
MAP = (
    "map", "ninebar", "--x", "clearances.r1.angle=0:1:2", "--y", "clearances.r1.speed=0:1:2",
    "--periods", "4", "--rtol", "1e-5", "--no-figures",
)  # fmt: skip
DIAGRAM = (
    "bifurcation", "ninebar", "--vary", "clearances.r1.size=0.1mm:0.2mm:2", "--periods", "1",
    "--skip", "0", "--rtol", "1e-6", "--no-figures",
)  # fmt: skip
COMMANDS = pytest.mark.parametrize(
    ("command", "name"), [(SWEEP, "sweep"), (MAP, "map"), (DIAGRAM, "bifurcation")]
)


@COMMANDS
def test_a_machine_without_a_driver(command, name, cli, monkeypatch):
    """One sentence, nothing computed, no file."""

    monkeypatch.setattr(cuda, "_LIBRARY", "libcuda_of_nobody.so.1")
    monkeypatch.setattr(cuda, "_driver", cuda._driver.__wrapped__)
    found = cli(*command, "--device", "cuda")
    assert found.code == 1
    assert found.err.splitlines()[-1] == (
        "no driver of an NVIDIA graphics processor was found (libcuda_of_nobody.so.1); expected a "
        "machine that has one, or a computation on the CPU"
    )
    assert not any(path.endswith(f"{name}.nc") for path in found.files)
    with pytest.raises(DeviceError, match="no driver"):
        Device()


@pytest.mark.slow
@COMMANDS
def test_the_file_is_that_of_the_cpu(command, name, cli, monkeypatch):
    monkeypatch.setattr(accelerated, "FEWEST", 2)
    driver = installed(monkeypatch)
    data = {}
    for device in ("cpu", "cuda"):
        assert not driver.calls["cuLaunchKernel"]
        found = cli(*command, "--device", device, "--cores", "2", "--out", device)
        assert found.code == 0
        data[device] = xr.load_dataset(f"{device}/{name}.nc", engine="h5netcdf")
    assert driver.calls["cuLaunchKernel"]
    for variable in data["cpu"].data_vars:
        assert data["cuda"][variable].identical(data["cpu"][variable])


def test_what_is_computed_on_the_cpu_only(cli):
    found = cli(
        "sweep", "slider-crank", "--measure", "max(abs(crank.effort))", "--vary",
        "bars.rod.length=30mm:150mm:3", "--device", "cuda",
    )  # fmt: skip
    assert found.code == 2
    assert "--device: 1 problem" in found.err
    assert "a motion that drives determine is computed on the CPU only; expected 'cpu'" in found.err


def test_other_words(cli):
    found = cli(*SWEEP, "--device", "opencl")
    assert found.code == 2
    assert all(word in found.err for word in ("--device", "'opencl'", "'cpu'", "'cuda'"))
