"""Every mechanism in the library loads, can be checked and runs; a wheel carries them all."""

import importlib.util
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import linkages
from linkages.kernel.system import System
from linkages.reading.document import read
from linkages.reading.locate import find, shipped
from linkages.topology.jacobian import numerical_mobility

ROOT = Path(__file__).parents[2]


def test_library_is_the_folder_of_the_project():
    assert sorted(path.name for path in shipped().values()) == sorted(
        path.name for path in (ROOT / "mechanisms").iterdir()
    )


@pytest.mark.parametrize("name", shipped())
def test_mechanism(name):
    path = shipped()[name]
    assert find(name) == find(f"{name}.yaml") == path

    comment = path.read_text(encoding="utf-8").split("\n\n")[0]
    assert all(line.startswith("#") for line in comment.splitlines())
    assert "Source:" in comment or "textbook" in comment or "Lengths:" in comment

    document = read(path)
    assert document.content["name"]
    assert "simulate" in document.content
    mechanism = linkages.load(name)
    assert mechanism.name == document.content["name"]

    system = System(mechanism)
    assert system.mechanism == mechanism  # every free coordinate is named
    assert not system.assumed  # and so is every assembly mode
    assert system.topology.mobility == numerical_mobility(system.jacobian)
    assert all(condition < 100 for condition in system.conditions)

    data = linkages.simulate(mechanism, outputs="all").data
    assert float(data.time[-1]) == mechanism.simulation.end
    assert data.sizes["time"] == mechanism.simulation.samples
    assert all(np.isfinite(values).all() for values in data.data_vars.values())
    assert float(data.closure_residual.max()) <= 1e-13  # The project's promise
    # Tolerances of files are 1e-10 or better; driven motions balance to round-off.
    moved = float(data.kinetic_energy.max() + np.ptp(data.potential_energy.to_numpy()))
    assert float(np.abs(data.energy_residual).max()) < 1e-9 * moved


@pytest.mark.slow
def test_wheel_carries_the_library(tmp_path):
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps"]
    if importlib.util.find_spec("hatchling"):
        command.append("--no-build-isolation")
    done = subprocess.run(
        [*command, "--wheel-dir", str(tmp_path), str(ROOT)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode and "hatchling" in done.stderr and "No matching distribution" in done.stderr:
        pytest.skip("hatchling is not installed and cannot be fetched")
    assert done.returncode == 0, done.stderr
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        for path in shipped().values():
            assert archive.read(f"linkages/mechanisms/{path.name}") == path.read_bytes()
        assert "linkages/cli/main.py" in names
        assert not any(name.startswith("tests/") for name in names)
        archive.extractall(tmp_path / "site")
    # Found there, by name, by a package that has no source tree beside it.
    script = "import linkages.reading.locate as l; print(*(str(p) for p in l.shipped().values()))"
    found = subprocess.run(
        [sys.executable, "-c", script],
        cwd=tmp_path / "site",
        env={"PYTHONPATH": str(tmp_path / "site")},
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    assert [Path(path).parent for path in found] == (
        [tmp_path / "site" / "linkages" / "mechanisms"] * len(shipped())
    )
