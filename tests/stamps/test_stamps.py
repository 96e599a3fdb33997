"""Texts in files of results: they are read back, and programs that show files pass over them."""

import io
import json
import struct
import xml.etree.ElementTree as ElementTree
import zipfile

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from PIL import Image
from pypdf import PdfReader

from linkages.reading.document import read
from linkages.solution.files import netcdf_bytes
from linkages.stamps import FORMATS, stamp, stamped

DEFINITION = 'name: "Ünïcode <b> & ]]> </script> ; 中"\nbars: {}\n' + "# long\n" * 300
ORIGIN = {"definition": DEFINITION, "options": '{"end": 0.1}', "version": "linkages 1"}


def _figure(kind):
    figure, stream = Figure(), io.BytesIO()
    figure.add_axes((0.1, 0.1, 0.8, 0.8)).plot([0, 1], [1, 0])
    figure.savefig(stream, format=kind)
    return stream.getvalue()


def _film(kind):
    stream = io.BytesIO()
    first, *others = (Image.new("RGB", (8, 8), colour) for colour in ("red", "green", "blue"))
    first.save(stream, format=kind, save_all=True, append_images=others, duration=40)
    return stream.getvalue()


def _dxf():
    ezdxf = pytest.importorskip("ezdxf")
    document, stream = ezdxf.new("R2010"), io.StringIO()
    document.modelspace().add_circle((1.0, 2.0), 3.0)
    document.write(stream)
    return document.encode(stream.getvalue())


def _mp4():
    boxes = ((b"ftyp", b"isom\0\0\2\0isom"), (b"mdat", b"frames"), (b"moov", b"tables"))
    return b"".join(struct.pack(">I", 8 + len(data)) + kind + data for kind, data in boxes)


def _fmu():
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    return stream.getvalue()


CONTENTS = {
    ".nc": lambda: bytes(netcdf_bytes(xr.Dataset({"x": ("t", np.arange(3.0))}))),
    ".png": lambda: _figure("png"),
    ".svg": lambda: _figure("svg"),
    ".pdf": lambda: _figure("pdf"),
    ".html": lambda: b"<!DOCTYPE html>\n<html>\n<head>\n<title>x</title>\n</head>\n</html>\n",
    ".json": lambda: b'{"verdict": "periodic"}',
    ".dxf": _dxf,
    ".gif": lambda: _film("gif"),
    ".webp": lambda: _film("webp"),
    ".mp4": _mp4,
    ".fmu": _fmu,
    ".c": lambda: b"int x;\n",
    ".h": lambda: b"extern int x;\n",
    ".js": lambda: b"const x = 1;\n",
    ".py": lambda: b"x = 1\n",
    ".xml": lambda: b"<mujoco/>\n",
}


@pytest.fixture(params=sorted(FORMATS))
def file(request, tmp_path):
    path = tmp_path / f"result{request.param}"
    path.write_bytes(CONTENTS[request.param]())
    return path


def _is_origin(found):
    return (found.definition, found.version) == (DEFINITION, "linkages 1") and found.options == {
        "end": 0.1
    }


def test_what_is_written_is_read_again_and_takes_the_place_of_what_was_before(file):
    assert stamped(file) is None
    assert stamp(file, ORIGIN | {"definition": "earlier text"})
    assert stamp(file, ORIGIN)
    assert _is_origin(stamped(file))
    assert b"earlier text" not in file.read_bytes() or file.suffix == ".nc"


def test_a_file_of_results_defines_a_mechanism(file):
    stamp(file, ORIGIN | {"changes": '["bars.a.length=2"]'})
    document = read(file)
    assert document.content["name"].startswith("Ünïcode")
    assert document.changes == ("bars.a.length=2",)


def test_drawings_read_as_before(tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    path = tmp_path / "x.dxf"
    path.write_bytes(_dxf())
    stamp(path, ORIGIN)
    (circle,) = ezdxf.readfile(path).modelspace()
    assert (tuple(circle.dxf.center), circle.dxf.radius) == ((1.0, 2.0, 0.0), 3.0)
    assert max(map(len, path.read_text(encoding="ascii").splitlines())) < 255
    # as another program may have written it
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n").replace(b"999\r", b"  999\r"))
    assert _is_origin(stamped(path))


@pytest.mark.parametrize("kind", [".png", ".gif", ".webp"])
def test_pictures_look_as_before(kind, tmp_path):
    path = tmp_path / f"x{kind}"
    path.write_bytes(CONTENTS[kind]())

    def frames():
        with Image.open(path) as image:
            found = []
            for index in range(getattr(image, "n_frames", 1)):
                image.seek(index)
                found.append(image.convert("RGB").tobytes())
            return found

    before = frames()
    stamp(path, ORIGIN)
    assert frames() == before


def test_documents_stay_well_formed(tmp_path):
    drawing, data = tmp_path / "x.svg", tmp_path / "x.json"
    drawing.write_bytes(CONTENTS[".svg"]())
    data.write_bytes(CONTENTS[".json"]())
    for path in (drawing, data):
        stamp(path, ORIGIN)
    texts = [node.text for node in ElementTree.parse(drawing).iter() if node.get("id")]
    assert json.dumps(ORIGIN, ensure_ascii=False) in texts
    assert json.loads(data.read_text(encoding="utf-8"))["verdict"] == "periodic"


def test_pages_of_a_document_stay(tmp_path):
    path = tmp_path / "x.pdf"
    path.write_bytes(CONTENTS[".pdf"]())
    (before,) = PdfReader(path).pages
    drawn = before.get_contents().get_data()
    stamp(path, ORIGIN)
    (after,) = PdfReader(path).pages
    assert after.get_contents().get_data() == drawn != b""
    assert after.mediabox == before.mediabox


def test_tables_hold_nothing(tmp_path):
    (tmp_path / "x.csv").write_text("a,b\n")
    assert not stamp(tmp_path / "x.csv", ORIGIN)
    assert stamped(tmp_path / "x.csv") is None
    assert (tmp_path / "x.csv").read_text() == "a,b\n"


def test_the_encoding_of_a_page_is_said_where_browsers_look_for_it(tmp_path):
    """Within the first 1024 bytes (HTML Living Standard, section 4.2.5.4)."""
    path = tmp_path / "x.html"
    path.write_text('<html>\n<head>\n<meta charset="utf-8">\n</head>\n<body>°</body>\n</html>\n')
    stamp(path, ORIGIN | {"definition": "name: x\n" * 1000})
    assert b'<meta charset="utf-8">' in path.read_bytes()[:1024]
    assert stamped(path).definition == "name: x\n" * 1000
