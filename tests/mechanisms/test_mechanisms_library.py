"""Every mechanism in the library loads, can be checked and runs; a wheel carries them all.

A new file of mechanisms/ takes part by being there.
"""

import importlib.util
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from absolute_coordinates import AbsoluteModel
from absolute_outputs import outputs
from kernel_values import at_sample, disagreements, state_at
from library_runs import place, whole_run

import linkages
from linkages.kernel.system import System
from linkages.reading.document import find, read, shipped
from linkages.topology.topology import numerical_mobility

ROOT = Path(__file__).parents[2]
NAMES = list(shipped())
CLOSED = [
    name for name in NAMES if not linkages.load(name).contacts and name != "impact-oscillator"
]
"""Those that touch nothing on their way; test_mechanisms_contact is about the others."""


def test_library_is_the_folder_of_the_project():
    assert sorted(path.name for path in shipped().values()) == sorted(
        path.name for path in (ROOT / "mechanisms").glob("*.yaml")
    )


def test_every_mechanism_is_described():
    page = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    assert [name for name in NAMES if f"\n### {name}\n" not in page] == []


@pytest.mark.parametrize("name", NAMES)
def test_file(name):
    path = shipped()[name]
    assert find(name) == find(f"{name}.yaml") == path

    comment = path.read_text(encoding="utf-8").split("\n\n")[0]
    assert all(line.startswith("#") for line in comment.splitlines())
    assert re.search(r"\bSource( of the \w+)?[:,]", comment)
    assert "any textbook" not in comment

    document = read(path)
    assert document.content["name"]
    assert "simulate" in document.content
    assert linkages.load(name).name == document.content["name"]


@pytest.mark.parametrize("name", NAMES)
def test_assembly(name):
    mechanism = linkages.load(name)
    system = System(mechanism)
    assert system.mechanism == mechanism  # every free coordinate is named
    assert not system.assembly.assumed  # and so is every assembly mode
    assert system.topology.mobility == numerical_mobility(system.jacobian)
    assert all(condition < 100 for condition in system.conditions)


def size(data):
    """The largest coordinate of a joint in metres, at least one metre."""
    return max(1.0, float(np.abs(data.joint_position).max()))


@pytest.mark.slow_except(
    "four-bar",
    "five-bar-free",
    "ninebar",
    "quick-return",
    "slider-crank-contact",
    "class-three",
    "double-pendulum",
)
@pytest.mark.parametrize("name", NAMES)
def test_run(name):
    solution = whole_run(name)
    data, mechanism = solution.data, linkages.load(name)
    assert float(data.time[-1]) == mechanism.simulation.end
    assert data.sizes["time"] == mechanism.simulation.samples
    for variable, values in data.data_vars.items():
        # What a drive does not move, it moves with an infinite mechanical advantage.
        sound = ~np.isnan(values) if "advantage" in variable else np.isfinite(values)
        assert sound.all(), variable
    assert float(data.closure_residual.max()) <= 1e-13 * size(data)  # The project's promise
    # Tolerances of files are 1e-10 or better; driven motions balance to round-off.
    moved = float(data.kinetic_energy.max() + np.ptp(data.potential_energy.to_numpy()))
    assert float(np.abs(data.energy_residual).max()) < 1e-9 * moved


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return", "slider-crank", "scotch-yoke")
@pytest.mark.parametrize("name", NAMES)
def test_bodies_stay_rigid_and_sliders_on_their_axes(name):
    """From the places of the joints alone: nothing of the kernel's closure is used."""
    data, mechanism = whole_run(name).data, linkages.load(name)
    limit = 1e-13 * size(data)
    for joint, (x, y) in mechanism.ground.items():
        assert np.ptp(place(data, joint) - [[x.value], [y.value]]) <= limit
    for body in mechanism.bodies.values():
        joints = list(body.points)
        local = np.array([[x.value, y.value] for x, y in body.points.values()])
        for i, first in enumerate(joints):
            for j, second in enumerate(joints[:i]):
                found = np.hypot(*(place(data, second) - place(data, first)))
                expected = np.hypot(*(local[j] - local[i]))
                assert np.abs(found - expected).max() <= limit, (body.name, first, second)
        if body.points and body.guide is not None and body.guide.body is None:
            across = np.array([-np.sin(body.guide.angle.value), np.cos(body.guide.angle.value)])
            origin = np.array([value.value for value in body.guide.origin])
            off = across @ (place(data, joints[0]) - origin[:, None])
            assert np.abs(off).max() <= limit, body.name


@pytest.mark.slow_except("four-bar", "ninebar", "quick-return", "slider-crank")
@pytest.mark.parametrize("name", CLOSED)
def test_motion_against_absolute_coordinates(name):
    """Positions, velocities, accelerations, efforts and reactions at a few samples.

    The absolute formulation (tests/oracle) has three coordinates per body and multipliers. Both
    solve systems of condition numbers up to some 1e4 where a mechanism is near a dead position.
    """
    data = whole_run(name).data
    model = AbsoluteModel(linkages.load(name))
    for sample in np.linspace(0, data.sizes["time"] - 1, 8).astype(int)[:-1] + 1:
        values = at_sample(data, int(sample))
        expected = outputs(model, model.solve(state_at(model, values, float(data.time[sample]))))
        assert disagreements(values, expected, 1e-9) == {}, float(data.time[sample])


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
        assert "linkages/cli/templates/four-bar.yaml" in names
        assert "linkages/mechanisms/linkages.schema.json" in names
        assert not any(name.startswith("tests/") for name in names)
        archive.extractall(tmp_path / "site")
    # Found there, by name, by a package that has no source tree beside it.
    script = "import linkages.reading.document as l; print(*(str(p) for p in l.shipped().values()))"
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
