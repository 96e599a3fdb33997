"""Result files are data from anywhere: they decide what is computed, and nothing else."""

import inspect
import json
import socket
import struct
import threading
from importlib import import_module
from inspect import signature
from itertools import chain

import h5py
import numpy as np
import pytest
import xarray as xr

import linkages
from linkages.cli.commands import PANELS
from linkages.opened import ANALYSES
from linkages.options.option import PLACES, Asked
from linkages.stamps import FORMATS, stamp

PENDULUM = """
gravity: [0, -9.81]
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1 ± 0.01, mass: 1}}
free: {rod: {angle: 1}}
simulate: {end: 0.05, samples: 3, rtol: 1e-6}
"""


@pytest.fixture
def forged(tmp_path):
    """Write a NetCDF file that says of its origin what somebody likes."""

    def write(**origin):
        path = tmp_path / "forged.nc"
        texts = {"definition": PENDULUM, "options": "{}", **origin}
        xr.Dataset({"x": ("t", np.arange(3.0))}, attrs=texts).to_netcdf(path, engine="h5netcdf")
        return path

    return write


@pytest.fixture
def listener():
    """A server that notes who connects."""
    server, connections = socket.create_server(("127.0.0.1", 0)), []

    def accept():
        while True:
            try:
                connections.append(server.accept())
            except OSError:
                return

    threading.Thread(target=accept, daemon=True).start()
    yield f"tcp://127.0.0.1:{server.getsockname()[1]}", connections
    server.close()
    for connection, _ in connections:
        connection.close()


WITHOUT_RESULTS = ("new", "schema", "import", "list")
COMPUTING = [c for c in chain(*PANELS.values()) if c.__name__ not in WITHOUT_RESULTS]


@pytest.mark.parametrize("command", COMPUTING, ids=lambda command: command.__name__)
def test_each_flag_describes_the_computation_or_where_it_runs(command):
    names = set(inspect.signature(command).parameters)
    assert names <= set(Asked.model_fields) | PLACES


def test_no_argument_that_is_taken_from_a_file_says_where_to_compute():
    assert not set(Asked.model_fields) & PLACES
    for place in ANALYSES.values():
        module, name = place.split(":")
        parameters = set(signature(getattr(import_module(module), name)).parameters)
        assert parameters - {"mechanism"} <= set(Asked.model_fields) | PLACES


def test_a_sweep_of_a_file_does_not_connect_to_a_scheduler_that_the_file_names(
    forged, listener, tmp_path, cli
):
    address, connections = listener
    said = {
        "measure": ["max(kinetic_energy)"],
        "vary": ["gravity[1]=-9:-10:2"],
        "scheduler": address,
        "store": "there",
        "device": "cuda",
        "cores": 1,
    }
    path = forged(verb="sweep", arguments=json.dumps(said))
    found = cli("sweep", str(path), "--out", str(tmp_path / "out"), "--no-figures")
    assert found.code == 0
    assert "2 points" in found.out
    assert connections == []
    assert not list(tmp_path.rglob("there"))


@pytest.mark.slow_except("python")
@pytest.mark.parametrize("how", ["command", "python"])
def test_nor_do_tolerances_of_a_file(how, forged, listener, tmp_path, cli):
    address, connections = listener
    said = {"of": ["max(kinetic_energy)"], "draws": 100, "scheduler": address, "store": "there"}
    path = forged(verb="tolerance", analysis="tolerance", arguments=json.dumps(said))
    if how == "command":
        words = ["tolerance", str(path), "--of", "max(kinetic_energy)", "--draws", "100"]
        assert cli(*words, "--out", str(tmp_path / "out"), "--no-figures").code == 0
    else:
        opened = linkages.open(path)
        assert opened.arguments.keys() == {"of", "draws"}
        opened.compute()
    assert connections == []
    assert not list(tmp_path.rglob("there"))


def test_results_do_not_store_where_they_were_computed(tmp_path, cli):
    (tmp_path / "pendulum.yaml").write_text(PENDULUM, encoding="utf-8")
    words = ["sweep", str(tmp_path / "pendulum.yaml"), "--measure", "max(kinetic_energy)"]
    words += ["--vary", "gravity[1]=-9:-10:2", "--store", str(tmp_path / "kept"), "--cores", "1"]
    assert cli(*words, "--out", str(tmp_path), "--no-figures").code == 0
    with xr.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as data:
        for entry in ("options", "arguments"):
            assert not json.loads(data.attrs[entry]).keys() & PLACES


def test_a_report_is_written_in_the_formats_of_the_command_alone(forged, tmp_path, cli):
    path = forged(verb="simulate", arguments=json.dumps({"reports": ["/../../x"]}))
    says = "origin.arguments: reports has no value a list of 1"
    cli.refused("simulate", str(path), "--out", str(tmp_path / "out"), "--no-figures", says=says)


BAD_TEXTS = ["[1]", "5", '"abc"', "null", "[" * 100_000, '{"definition": 5}']
BAD_ENTRIES = [
    {"changes": "oops"},
    {"changes": "5"},
    {"changes": "[1]"},
    {"changes": "[" * 100_000},
    {"arguments": "oops"},
    {"arguments": "[1]"},
    {"options": "x"},
    {"options": "3"},
    {"notes": "5"},
]
BAD_ARGUMENTS = [
    {"outputs": [1]},
    {"samples": "x"},
    {"samples": -3},
    {"end": [1]},
    {"rtol": {}},
    {"method": 5},
    {"measure": [5]},
    {"units": 5},
]


PNG = b"\x89PNG\r\n\x1a\n"
BOX = bytes.fromhex("5a1d0c5e8f0b4c6e9b9e3d6a7c2f4e10")


def _svg(text):
    return f'<svg xmlns="x"><metadata id="linkages-origin">{text}</metadata></svg>\n'


@pytest.mark.slow_except("*-5")
@pytest.mark.parametrize("text", BAD_TEXTS, ids=lambda text: text[:20])
@pytest.mark.parametrize("kind", [".svg", ".html", ".c", ".py", ".xml", ".dxf", ".json", ".png"])
def test_a_damaged_origin_is_one_clear_problem(kind, text, tmp_path, cli):
    path = tmp_path / f"x{kind}"
    element = '<script type="application/json" id="linkages-origin">{}</script>'
    chunk = b"iTXtlinkages\0\0\0\0\0" + text.encode()
    content = {
        ".svg": _svg(text),
        ".html": element.format(text),
        ".c": f"/* linkages-origin: {text} */\n",
        ".py": f"# linkages-origin: {text}\n",
        ".xml": f"<!-- linkages-origin: {text} -->\n",
        ".dxf": f"999\nlinkages-origin {text}\n",
        ".json": f'{{"origin": {text}}}',
        ".png": b"\x89PNG\r\n\x1a\n" + struct.pack(">I", len(chunk) - 4) + chunk + b"crc.",
    }[kind]
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    found = cli("check", str(path))
    assert found.code == 2
    first, *others = found.err.splitlines()
    assert str(path) in first
    assert len(others) <= 2


@pytest.mark.parametrize("entry", BAD_ENTRIES, ids=str)
def test_a_damaged_entry_is_named(entry, forged, cli):
    path = forged(**entry)
    found = cli("check", str(path))
    assert found.code == 2
    (name,) = entry
    assert f"origin.{name}: expected a JSON" in found.err
    with pytest.raises(linkages.InputError, match=f"origin.{name}"):
        linkages.open(path)


@pytest.mark.parametrize("arguments", BAD_ARGUMENTS, ids=str)
def test_arguments_of_a_wrong_kind_are_refused(arguments, forged, tmp_path, cli):
    path = forged(verb="simulate", analysis="simulate", arguments=json.dumps(arguments))
    says = "origin.arguments"
    cli.refused("simulate", str(path), "--out", str(tmp_path / "out"), "--no-figures", says=says)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("x.gif", b"GIF89a!\xfe\x09linkages:\xffa"),
        ("x.gif", b"GIF89a!\xfe\x09linkages:\x02\xff\xfe\x00;"),
        ("x.webp", b"RIFF\x10\0\0\0WEBPLNKG\x02\0\0\0\xff\xfe"),
        ("x.mp4", bytes.fromhex("000000016d6f6f76")),
        ("x.mp4", struct.pack(">I", 26) + b"uuid" + BOX + b"\xff\xfe"),
        ("x.png", PNG + struct.pack(">I", 16) + b"iTXtlinkages\0\0\0\0\0\xff\xfe\xffcrc."),
        ("x.fmu", b"not an archive"),
        ("x.pdf", b"not a document"),
        ("x.pdf", b"%PDF-1.4\n1 0 obj\n<<"),
        ("x.nc", b"\x89HDF\r\n\x1a\n" + b"\0" * 200),
        ("x.nc", b"not a file of results"),
    ],
)  # fmt: skip
def test_a_damaged_file_is_one_clear_problem(name, content, tmp_path, cli):
    (tmp_path / name).write_bytes(content)
    found = cli("check", str(tmp_path / name))
    assert found.code == 2
    assert name in found.err
    assert len(found.err.splitlines()) <= 2


@pytest.mark.parametrize("kind", sorted(FORMATS))
def test_a_file_of_gigabytes_is_not_read(kind, tmp_path, cli):
    path = tmp_path / f"x{kind}"
    with path.open("wb") as file:
        file.truncate(6 * 1024**3)  # sparse: it takes no place
    cli.refused("check", str(path), says=str(path))


def test_attributes_of_a_file_are_not_read_without_limit(tmp_path, cli):
    path = tmp_path / "x.nc"
    with h5py.File(path, "w") as file:
        file.attrs["definition"] = PENDULUM
        for place in range(80):
            file.attrs[f"a{place}"] = "x" * 1_000_000
    cli.refused("check", str(path), says="damaged")


def test_data_that_a_file_only_says_to_have_is_not_allocated(tmp_path):
    path = tmp_path / "x.nc"
    with h5py.File(path, "w") as file:
        file.attrs["definition"], file.attrs["options"] = PENDULUM, "{}"
        file.create_dataset("x", shape=(10**11,), chunks=(1024,), dtype="f8")
    with pytest.raises(linkages.InputError, match="is damaged"):
        linkages.open(path)


def test_what_is_stamped_is_validated_when_it_is_read(tmp_path):
    path = tmp_path / "x.svg"
    path.write_text("<svg></svg>", encoding="utf-8")
    stamp(path, {"definition": PENDULUM, "changes": '["x"]', "anything": "else"})
    assert linkages.load(path).name


@pytest.mark.parametrize(
    ("analysis", "arguments", "expected"),
    [
        ("simulate", {"samples": 10**12}, "samples must be at least 2 and at most 10000000"),
        ("poincare", {"periods": 10**12}, "periods must be a whole number > 0, at most 10000000"),
        ("lyapunov", {"skip": 10**30}, "skip must be a whole number >= 0, at most 10000000"),
        ("bifurcation", {"vary": ["gravity[1]=-9:-8:2"], "periods": 10**12}, "at most 10000000"),
        ("map", {"x": ["gravity[1]=-9:-8:9999"], "y": ["bars.rod.mass=1:2:9999"]}, "at most 1e"),
        ("sweep", {"measure": [], "vary": ["gravity[1]=-9:-8:9999999999"]}, "at most 1e"),
        ("tolerance", {"of": ["max(kinetic_energy)"], "draws": 10**12}, "at most 1e"),
        ("entropy", {"periods": 10**12}, "periods must be a whole number > 0, at most 10000000"),
        (
            "optimise",
            {"vary": ["bars.rod.mass=1:2"], "minimise": "max(kinetic_energy)", "starts": 10**12},
            "starts must be from 1 to 100000",
        ),
        ("fit", {"vary": ["bars.rod.mass=1:2"]}, "expected the measurements of a fit; 'series'"),
        ("sensitivity", {"of": None}, "sensitivity needs of, to; the file stores none"),
    ],
)  # fmt: skip
def test_a_file_cannot_ask_for_more_than_a_call_can(analysis, arguments, expected, forged):
    opened = linkages.open(forged(analysis=analysis, arguments=json.dumps(arguments)))
    with pytest.raises((ValueError, linkages.InputError), match=expected):
        opened.compute()


@pytest.mark.parametrize("how", ["raw", "virtual", "external", "soft"])
def test_results_take_no_data_from_other_files(how, tmp_path):
    secret = tmp_path / "secret"
    secret.write_bytes(b"private!" * 10)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = np.ones(10)
    path = tmp_path / "x.nc"
    with h5py.File(path, "w") as file:
        file.attrs["definition"], file.attrs["options"] = PENDULUM, "{}"
        if how == "raw":
            file.create_dataset("x", shape=(10,), dtype="f8", external=[(str(secret), 0, 80)])
        elif how == "virtual":
            layout = h5py.VirtualLayout(shape=(10,), dtype="f8")
            layout[:] = h5py.VirtualSource(tmp_path / "other.h5", "x", shape=(10,))
            file.create_virtual_dataset("x", layout)
        else:
            other = str(tmp_path / "other.h5")
            file["x"] = h5py.ExternalLink(other, "x") if how == "external" else h5py.SoftLink("/y")
    with pytest.raises(linkages.InputError, match="'x' is in another file"):
        linkages.open(path)


@pytest.mark.slow_except("dxf", "gif", "json")
@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("x.dxf", b" " * 1_000_000),
        ("x.gif", b"GIF89a!\xfe\x09linkages:" + (b"\xff" + b"x" * 255) * 20_000),
        ("x.svg", _svg("[" + "[]," * 11_200_000).encode()),
        ("x.json", b"[" + b"[]," * 11_200_000),
    ],
    ids=["dxf", "gif", "svg", "json"],
)
def test_work_and_memory_grow_with_the_size_of_a_file(name, content, tmp_path, cli):
    (tmp_path / name).write_bytes(content)
    assert cli("check", str(tmp_path / name)).code == 2
