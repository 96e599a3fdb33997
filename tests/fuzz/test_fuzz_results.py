"""Result files and stores changed at random: read, or refused with words; nothing else.

`python -m pytest -m long tests/fuzz/test_fuzz_results.py` changes each of them a hundred times as
often.
"""

import copy
import io
import json
import random
import struct
import sys
import zipfile
import zlib

import numpy as np
import pytest
import xarray as xr
from PIL import Image
from pypdf import PdfWriter

import linkages
from linkages.cli.requests import arguments_in
from linkages.errors import InputError
from linkages.solution.files import netcdf_bytes
from linkages.stamps import FORMATS, stamp
from linkages.sweeps import store as stores
from linkages.sweeps.engine import OWN, Answer, Code, Field, stacked

resource = pytest.importorskip("resource", reason="POSIX")

QUICK, LONG = 12, 1200
"""Changed files of each kind."""

MOST_MEMORY = 400
"""MiB that all files of a kind together may take more than was taken before."""

DEFINITION = """
joints: {O: [0, 0]}
bars: {rod: {joints: [O, P], length: 1, mass: 1}}
free: {rod: {angle: 1}}
"""
ORIGIN = {
    "definition": DEFINITION,
    "changes": '["bars.rod.length=1"]',
    "options": '{"end": 0.1}',
    "arguments": '{"end": 0.1, "samples": 3, "measure": ["max(rod.angle)"], '
    '"state": {"rod": {"angle": 1.0}}, "outputs": null}',
    "verb": "sweep",
    "analysis": "sweep",
    "command": "python -m linkages sweep x.yaml",
    "version": "linkages 1",
    "notes": "[]",
    "complete": "yes",
}
VALUES = (
    None, True, 0, -1, 1.5, 10**30, 1e308, "", "x", "[", "[1]", "{}", "null", "\x1b[31m", "\ud83e",
    "__class__", "../x", "/etc/passwd", "tcp://127.0.0.1:1", [], {}, [[]], ["x"] * 1000, {"x": []},
    "[" * 50_000, '{"a":' * 5000,
)  # fmt: skip


def _pdf():
    writer, stream = PdfWriter(), io.BytesIO()
    writer.add_blank_page(100, 100)
    writer.write(stream)
    return stream.getvalue()


def _picture(kind):
    stream = io.BytesIO()
    first, *others = (Image.new("RGB", (4, 4), colour) for colour in ("red", "green"))
    several = {} if kind == "png" else {"save_all": True, "append_images": others}
    first.save(stream, format=kind, **several)
    return stream.getvalue()


def _unit():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    return stream.getvalue()


CONTENTS = {
    ".nc": lambda: bytes(netcdf_bytes(xr.Dataset({"x": ("t", np.arange(3.0))}))),
    ".pdf": _pdf,
    ".png": lambda: _picture("png"),
    ".gif": lambda: _picture("gif"),
    ".webp": lambda: _picture("webp"),
    ".mp4": lambda: struct.pack(">I", 16) + b"ftypisom\0\0\2\0",
    ".fmu": _unit,
    ".svg": lambda: b"<svg>\n</svg>\n",
    ".html": lambda: b"<html><head></head></html>\n",
    ".json": lambda: b'{"verdict": "periodic"}',
    ".dxf": lambda: b"  0\nSECTION\n  0\nENDSEC\n  0\nEOF\n",
    ".xml": lambda: b"<mujoco/>\n",
}


def changed_bytes(chance, content):
    """A file that is cut, or in which a few bytes are others, left out or repeated."""
    found = bytearray(content)
    for _ in range(chance.randint(1, 4)):
        at, length = chance.randrange(len(found) + 1), chance.randint(1, 40)
        kind = chance.randrange(5)
        if kind == 0:
            del found[at:]
        elif kind == 1:
            del found[at : at + length]
        elif kind == 2:
            found[at:at] = found[at : at + length]
        elif kind == 3:
            found[at : at + 4] = chance.choice((b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff"))
        elif at < len(found):
            found[at] = chance.randrange(256)
    return bytes(found)


def changed_json(chance, content):
    """A JSON object in which entries, at any depth, are others or missing."""
    found = json.loads(json.dumps(content))
    for _ in range(chance.randint(1, 3)):
        holder = found
        while isinstance(holder, dict | list) and holder:
            key = chance.choice([*holder]) if isinstance(holder, dict) else 0
            if not isinstance(holder[key], dict | list) or chance.random() < 0.3:
                holder[key] = copy.deepcopy(chance.choice(VALUES))
                break
            holder = holder[key]
    return found


def refused_or_read(read, *given):
    """Whether something is refused with words; InputError is the one way to do that."""
    words = ""
    try:
        read(*given)
    except InputError as error:
        words = str(error)
    assert "\x1b" not in words
    return bool(words)


def read_results(path):
    arguments_in(str(path), "sweep", ())
    linkages.load(path)
    if path.suffix == ".nc":
        linkages.open(path)


def most_memory():
    """Of this process, in MiB."""
    unit = 1024**2 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


@pytest.fixture
def quiet(capfd, caplog):
    """Nothing that other libraries say reaches the user, and memory is bounded."""
    before = most_memory()
    yield
    assert capfd.readouterr() == ("", "")
    assert not [record.message for record in caplog.records if record.levelname != "INFO"]
    assert most_memory() - before < MOST_MEMORY


def judge_results(kind, count, tmp_path):
    path = tmp_path / f"x{kind}"
    whole = CONTENTS.get(kind, lambda: b"x = 1\n")()
    path.write_bytes(whole)
    stamp(path, ORIGIN)
    seed, refused = path.read_bytes(), 0
    assert not refused_or_read(read_results, path)
    for number in range(count):
        chance = random.Random(f"{kind} {number}")
        if number % 3:
            path.write_bytes(changed_bytes(chance, seed))
        else:
            path.write_bytes(whole)
            texts = {
                name: value if isinstance(value, str) else json.dumps(value)
                for name, value in changed_json(chance, ORIGIN).items()
            }
            if chance.random() < 0.5:
                texts["arguments"] = json.dumps(
                    changed_json(chance, json.loads(ORIGIN["arguments"]))
                )
            try:
                stamp(path, texts)
            except (ValueError, OSError):
                continue  # not in this format
        refused += refused_or_read(read_results, path)
    return refused


@pytest.mark.usefixtures("quiet")
@pytest.mark.parametrize("kind", sorted(FORMATS))
def test_changed_results(kind, tmp_path):
    assert judge_results(kind, QUICK, tmp_path) > 0


@pytest.mark.long
@pytest.mark.usefixtures("quiet")
@pytest.mark.parametrize("kind", sorted(FORMATS))
def test_many_changed_results(kind, tmp_path):
    assert judge_results(kind, LONG, tmp_path) > LONG // 10


def make_store(folder):
    """A store with two chunks of four points; returns its manifest."""
    (folder / stores.CHUNKS).mkdir(parents=True, exist_ok=True)
    manifest = {"format": 1, "version": "linkages 1", "definition": DEFINITION, "count": 8}
    manifest |= {"chunk": 4, "question": {"measures": {"x": "max(x)"}, "shape": [8]}}
    (folder / stores.MANIFEST).write_text(json.dumps(manifest), encoding="utf-8")
    fields = {"max(x)": Field(), "orbit": Field(shape=(3,)), "word": Field("U")}
    answers = [
        Answer({"max(x)": 1.0, "orbit": np.ones(3), "word": "ab"}),
        Answer({}, Code.STOPPED, "it stopped", 0.5, 10),
    ]
    for at in (0, 4):
        part = stacked(fields, answers * 2)
        path = folder / stores.CHUNKS / f"{at:09d}"
        path.write_bytes(stores._packed((at, at + 4), part))
    return manifest


def judge_stores(count, folder):
    refused = 0
    for number in range(count):
        chance = random.Random(number)
        manifest = make_store(folder)
        path, kind = folder / stores.MANIFEST, number % 4
        if kind == 0:
            path.write_bytes(changed_bytes(chance, path.read_bytes()))
        elif kind == 1:
            path.write_text(json.dumps(changed_json(chance, manifest)), encoding="utf-8")
        else:
            path = folder / stores.CHUNKS / "000000004"
            path.write_bytes(changed_chunk(chance, path.read_bytes(), in_header=kind == 2))
        refused += refused_or_read(stores.status, folder)
    return refused


def changed_chunk(chance, content, *, in_header):
    """A chunk with a right CRC, whatever else is in it: everybody can compute one."""
    at = len(stores.MAGIC)
    (size,) = struct.unpack("<Q", content[at : at + 8])
    header, data = content[at + 8 : at + 8 + size], content[at + 8 + size : -4]
    if in_header:
        header = json.dumps(changed_json(chance, json.loads(header))).encode()
        found = stores.MAGIC + struct.pack("<Q", len(header)) + header + data
    else:
        found = stores.MAGIC + changed_bytes(chance, content[at:-4])
    return found + struct.pack("<I", zlib.crc32(found))


@pytest.mark.usefixtures("quiet")
def test_changed_stores(tmp_path):
    make_store(tmp_path)
    assert stores.status(tmp_path)["done"] == 8
    assert set(OWN) <= set(dict(stores.SweepStore(tmp_path, 4, 8).read([(0, 4)], {}))[0, 4])
    assert judge_stores(40 * QUICK, tmp_path) > 10 * QUICK


@pytest.mark.long
@pytest.mark.usefixtures("quiet")
def test_many_changed_stores(tmp_path):
    assert judge_stores(20 * LONG, tmp_path) > 5 * LONG
