"""what a solution holds, how large it is, and how it is saved."""

import copy
import json
import pickle
import re
import subprocess
import sys
import tracemalloc

import numpy as np
import pytest
import xarray as xr
from solution_mechanisms import FOUR_BAR, SLIDER_CRANK, mechanism

import linkages
from linkages.components.mechanisms.definition import from_document
from linkages.reading.document import parse
from linkages.solution import files
from linkages.solution.series import LabelledArrays

UNITS = {
    "bar_angle": ("rad", ("bar",)),
    "bar_speed": ("rad/s", ("bar",)),
    "bar_acceleration": ("rad/s^2", ("bar",)),
    "slider_position": ("m", ("slider",)),
    "slider_velocity": ("m/s", ("slider",)),
    "slider_acceleration": ("m/s^2", ("slider",)),
    "slider_position_error": ("m", ("slider",)),
    "slider_velocity_error": ("m/s", ("slider",)),
    "slider_acceleration_error": ("m/s^2", ("slider",)),
    "clearance_angle": ("rad", ("clearance",)),
    "clearance_speed": ("rad/s", ("clearance",)),
    "clearance_acceleration": ("rad/s^2", ("clearance",)),
    "clearance_force": ("N", ("clearance",)),
    "joint_position": ("m", ("joint", "axis")),
    "joint_velocity": ("m/s", ("joint", "axis")),
    "joint_acceleration": ("m/s^2", ("joint", "axis")),
    "joint_reaction": ("N", ("joint", "axis")),
    "pin_reaction": ("N", ("pin", "axis")),
    "transmission_angle": ("rad", ("dyad",)),
    "mechanical_advantage": ("1", ("drive", "bar")),
    "slider_mechanical_advantage": ("1/m", ("drive", "slider")),
    "drive_effort": ("N m", ("drive",)),
    "kinetic_energy": ("J", ()),
    "potential_energy": ("J", ()),
    "drive_power": ("W", ()),
    "energy_residual": ("J", ()),
    "closure_residual": ("m", ()),
}
ON_REQUEST = {"joint_reaction", "pin_reaction", "kinetic_energy", "potential_energy",
              "drive_power", "load_power", "energy_residual", "transmission_angle",
              "mechanical_advantage", "slider_mechanical_advantage"}  # fmt: skip


@pytest.fixture(scope="module")
def press():
    return linkages.load("ninebar")


@pytest.fixture(scope="module")
def everything(press):
    return linkages.simulate(press, end=0.02, samples=21, outputs="all")


def test_contract_of_dimensions_and_units(everything):
    data = everything.data
    for name, (units, dims) in UNITS.items():
        assert data[name].dims == ("time", *dims), name
        assert data[name].attrs["units"] == units, name
        assert data[name].attrs["long_name"]
        assert data[name].dtype == np.float64
    assert set(UNITS) <= set(data.data_vars)
    assert data.time.attrs["units"] == "s"
    assert np.array_equal(data.time, np.linspace(0, 0.02, 21))
    assert {dim: list(data[dim].to_numpy()) for dim in data.dims if dim != "time"} == {
        "bar": ["crank1", "link2", "link3", "crank4", "rocker6", "link7", "link8"],
        "slider": ["slider9"],
        "clearance": ["r1"],
        "joint": ["O", "D", "A", "B", "C.r1", "C", "E", "F"],
        "pin": [
            "O.ground",
            "O.crank1",
            "O.rocker6",
            "B.link2",
            "B.link3",
            "B.link7",
            "E.rocker6",
            "E.link7",
            "E.link8",
        ],
        "axis": ["x", "y"],
        "dyad": ["B", "E", "slider9"],
        "drive": ["crank1", "crank4"],
        "frame": ["ground"],
    }


def test_default_outputs_are_kinematics_and_efforts(press):
    data = linkages.simulate(press, end=0.02, samples=21).data
    assert set(data.data_vars) == set(UNITS) - ON_REQUEST


@pytest.mark.parametrize(
    ("outputs", "present"),
    [
        (["drive_effort"], ["drive_effort"]),
        (["joint_reaction", "bar_angle"], ["joint_reaction", "pin_reaction", "bar_angle"]),
        ("slider_position", ["slider_position"]),
        (["slider_velocity_error"], ["slider_velocity_error"]),
        (["energy_residual"], ["energy_residual"]),
        (["bar_angle", "bar_angle"], ["bar_angle"]),
        ([], []),
    ],
)
def test_only_what_is_asked_for(press, everything, outputs, present):
    data = linkages.simulate(press, end=0.02, samples=21, outputs=outputs).data
    assert list(data.data_vars) == present
    # One more integrand changes the steps, and the rest by the tolerance.
    for name in present:
        scale = float(np.abs(everything.data[name]).max())
        assert np.allclose(data[name], everything.data[name], rtol=0, atol=1e-6 * scale + 1e-11)


def test_mechanism_has_only_what_it_is_made_of():
    data = linkages.simulate(mechanism(FOUR_BAR), end=0.1, samples=3, outputs="all").data
    assert not [name for name in data if name.startswith(("slider", "clearance"))]
    assert {"slider", "clearance"}.isdisjoint(data.dims)


def test_unknown_and_absent_outputs(press):
    with pytest.raises(ValueError, match="unknown output 'bar_angel'; did you mean 'bar_angle'"):
        linkages.simulate(press, outputs=["bar_angel"])
    with pytest.raises(ValueError, match="this mechanism has no slider_position"):
        linkages.simulate(mechanism(FOUR_BAR), outputs=["slider_position"])


@pytest.mark.parametrize("name", ["guide_force", "joint_reactoin", "pin_reaction", "drive_efort"])
def test_outputs_in_messages_are_those_of_the_mechanism(name):
    """A block alone has neither bars nor drives, and no joint that bodies share."""
    block = linkages.loads("""
sliders: {block: {joint: P, through: [0, 0], mass: 2}}
free: {block: {position: 0, speed: 1}}
simulate: {end: 1, samples: 3}
""")
    own = [*linkages.simulate(block, outputs="all").data.data_vars]
    for refused in (
        lambda: linkages.simulate(block, outputs=name),
        lambda: linkages.sensitivities(block, name, "sliders.block.mass"),
    ):
        with pytest.raises(ValueError, match=name) as refusal:
            refused()
        names = re.split(r"'; did you mean '|; expected(?: one such as|:) ", str(refusal.value))[1]
        assert set(names.rstrip("?").replace("'", "").split(", ")) <= set(own)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"end": 0.0}, "end must be a time in seconds other than 0, found 0"),
        ({"end": float("nan")}, "end must be a time"),
        ({"end": float("inf")}, "end must be a time"),
        ({"samples": 1}, "samples must be at least 2"),
        ({"samples": 10**12}, "at most"),
        ({"rtol": 1e-30}, "rtol must be from"),
        ({"rtol": float("nan")}, "rtol must be a number > 0"),
        ({"atol": 0.0}, "atol must be a number > 0"),
        ({"method": "rk4", "step": -1.0}, "step must be"),
        ({"method": "rk4", "step": 0.0}, "step must be"),
        ({"method": "rk4", "step": 1e-300}, "needs more than"),
        ({"max_steps": 0}, "max_steps must be"),
    ],
)
def test_arguments_that_make_no_sense(press, arguments, message):
    with pytest.raises(ValueError, match=message):
        linkages.simulate(press, **arguments)


def test_arguments_come_before_the_file():
    found = mechanism(FOUR_BAR, "simulate: {end: 0.5, samples: 6}")
    assert np.array_equal(linkages.simulate(found).data.time, np.linspace(0, 0.5, 6))
    assert np.array_equal(linkages.simulate(found, end=1, samples=3).data.time, [0, 0.5, 1])


def test_maxima(everything):
    for row in everything.maxima:
        if row["variable"].endswith("residual"):
            continue  # noise
        series = everything.data[row["variable"]]
        if row["element"] in everything.data.pin:  # the largest of several bodies at a joint
            series = everything.data["pin_reaction"]
        if row["element"]:
            series = series.sel({series.dims[1]: row["element"]})
        values = np.abs(series.to_numpy())
        if series.dims[-1] == "axis":
            values = np.linalg.norm(values, axis=-1)
        # located between samples: samples of a few degrees may miss a few per cent of a peak
        # to round-off, which compiled functions and NumPy do not share, of differences of numbers
        # that are ten times larger
        assert values.max() * (1 - 1e-11) <= abs(row["value"]) <= values.max() * 1.1
        assert row["units"] == series.attrs["units"]


def test_size_follows_samples_not_steps(press):
    """Some 10 000 steps, three samples: only these are kept."""
    solution = linkages.simulate(press, end=2.0, samples=3)
    assert solution.motion.cost["steps"] > 5000
    (piece,) = solution.motion.pieces
    for array in (piece.time, piece.state, piece.turns, piece.acceleration):
        assert array.shape[-1] == 3
        assert array.base is None or array.base.size < 100
    assert solution.data.nbytes < 10_000


@pytest.mark.slow
def test_memory_of_a_driven_motion_does_not_grow_with_its_length():
    """Ten and a thousand turns, three samples: a degree at a time is looked at in chunks."""

    def peak(turns):
        found = mechanism(SLIDER_CRANK)
        tracemalloc.start()
        linkages.simulate(found, end=turns * 2 * np.pi / 50, samples=3)
        try:
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(1)  # imports
    assert peak(1000) < 4 * peak(10)


ORIGIN = ("verb", "version", "libraries", "options", "arguments", "changes", "definition", "notes")


def test_netcdf_round_trip(everything, tmp_path):
    netcdf, text = everything.save(tmp_path / "a" / "b")
    assert (netcdf.name, text.name) == ("simulate.nc", "simulate.csv")
    with xr.open_dataset(netcdf, engine="h5netcdf") as found:
        origin = {name: found.attrs.pop(name) for name in ORIGIN}
        xr.testing.assert_identical(found.load(), everything.data)
    assert json.loads(origin["options"])["samples"] == 21
    document = parse(origin["definition"], "simulate.nc")
    assert from_document(document).components == everything.mechanism.components


def test_csv_has_all_digits_of_all_series(everything, tmp_path):
    _, text = everything.save(tmp_path)
    head, *rows = text.read_text(encoding="utf-8").splitlines()
    names = head.split(",")
    values = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    data = everything.data
    assert names[0] == "time (s)"
    assert values.shape == (21, 1 + sum(v.size // 21 for v in data.data_vars.values()))
    column = values[:, names.index("clearance_force[r1] (N)")]
    assert np.array_equal(column, data.clearance_force[:, 0])
    column = values[:, names.index("joint_reaction[C.r1.y] (N)")]
    assert np.array_equal(column, data.joint_reaction.sel(joint="C.r1", axis="y"))


@pytest.mark.slow_except("key")
@pytest.mark.parametrize("failure", [OSError("disk full"), KeyboardInterrupt()], ids=["os", "key"])
def test_failing_writer_leaves_the_old_file_and_nothing_else(
    everything, tmp_path, monkeypatch, failure
):
    everything.save(tmp_path)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}

    def broken(file, **_):
        file.write("half of a tab")
        raise failure

    monkeypatch.setattr(files.csv, "writer", broken)
    with pytest.raises(type(failure)):
        everything.save(tmp_path)
    after = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert after.keys() == before.keys() == {"simulate.nc", "simulate.csv"}
    assert after["simulate.csv"] == before["simulate.csv"]


def test_files_can_be_read_by_those_whom_the_umask_lets(everything, tmp_path):
    """Temporary files are private; what takes their place must not be."""
    probe = tmp_path / "probe"
    probe.touch()
    for path in everything.save(tmp_path / "results"):
        assert path.stat().st_mode == probe.stat().st_mode


def test_watch_sees_progress(press):
    seen = []
    linkages.simulate(press, end=0.02, samples=3, watch=seen.append)
    linkages.simulate(mechanism(FOUR_BAR), end=1.0, samples=3, watch=seen.append)
    assert seen
    assert all(0 <= fraction <= 1 for fraction in seen)
    assert seen[-1] == 1.0


@pytest.mark.slow_except("ninebar*")
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))])
@pytest.mark.parametrize(("name", "end"), [("ninebar", 0.01), ("four-bar", 1.0)])
def test_a_copy_of_a_solution_is_equal(copied, name, end):
    solution = linkages.simulate(
        linkages.load(name), end=end, samples=5, outputs="all", watch=lambda _: None
    )
    first = solution.maxima
    again = copied(solution)
    assert again.data.identical(solution.data)
    assert again.maxima == first
    assert again.system.topology == solution.system.topology
    measure = "max(kinetic_energy)"
    assert linkages.measure(again, measure) == linkages.measure(solution, measure)


@pytest.mark.parametrize("name", ["ninebar", "slider-crank-contact", "pendulum"])
def test_saving_without_xarray_writes_the_bytes_that_xarray_writes(name, tmp_path):
    solution = linkages.simulate(linkages.load(name), end=0.02, samples=5, outputs="all")
    untouched, _ = solution.save(tmp_path / "untouched")
    assert isinstance(vars(solution)["data"], LabelledArrays)
    with xr.open_dataset(untouched, engine="h5netcdf") as read:
        solution.data.attrs.update(read.attrs)
        assert read.identical(solution.data)
    assert untouched.read_bytes() == files.netcdf_bytes(solution.data)


def test_a_simulation_without_figures_imports_no_library_that_it_does_not_need(tmp_path):
    """Their imports take longer than the motion."""
    code = (
        "import sys; from linkages.__main__ import main\n"
        "late = {'xarray', 'pandas', 'pint', 'matplotlib', 'sympy', 'scipy.optimize'}\n"
        "try: main()\n"
        "finally: print(*late & {*sys.modules})"
    )
    command = ["simulate", "ninebar", "--no-figures", "--out", str(tmp_path)]
    run = subprocess.run(
        [sys.executable, "-c", code, *command], capture_output=True, text=True, check=True
    )
    assert run.stdout.splitlines()[-1] == ""
