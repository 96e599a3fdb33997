"""Run the notebooks of docs/notebooks and keep what they show; tests compare what they print.

Pages show the outputs that are stored, so that notebooks read on hosts of code as well.
"""

from __future__ import annotations

import base64
import io
import os
import tempfile
from pathlib import Path

import nbformat
from nbclient import NotebookClient
from PIL import Image

from make.registry import COLOURS, DOCS, makes_each

FOLDER = DOCS / "notebooks"
PICTURE = "image/png"
METADATA = {
    "kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"},
    "language_info": {"name": "python", "pygments_lexer": "ipython3"},
}


def notebooks() -> list[Path]:
    """All notebooks."""
    return sorted(FOLDER.glob("*.ipynb"))


def executed(path: Path) -> nbformat.NotebookNode:
    """A notebook with new outputs; an error in a cell is raised."""
    notebook = nbformat.read(path, as_version=4)
    os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"  # or the kernel warns about frozen modules
    with tempfile.TemporaryDirectory() as folder:
        context = {"metadata": {"path": folder}}
        client = NotebookClient(notebook, resources=context, timeout=300, record_timing=False)
        client.execute()
    return notebook


def printed(notebook: nbformat.NotebookNode) -> list[str]:
    """What its cells print or show as text, one text for each cell of code."""
    return [
        "".join(_text(output) for output in cell.outputs)
        for cell in notebook.cells
        if cell.cell_type == "code"
    ]


def _text(output: nbformat.NotebookNode) -> str:
    if output.output_type == "stream":
        return output.text
    data = output.get("data", {})
    return "" if PICTURE in data else data.get("text/plain", "") + "\n"


def keep(notebook: nbformat.NotebookNode, path: Path) -> None:
    """Write a notebook; its pictures get a palette of their own, at a fraction of the size."""
    notebook.metadata = METADATA
    for place, cell in enumerate(notebook.cells):
        cell.id = f"cell-{place}"
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if PICTURE in data:
                data[PICTURE] = _small(data[PICTURE])
                del data["text/plain"]
    nbformat.write(notebook, path)


def _small(picture: str) -> str:
    with Image.open(io.BytesIO(base64.b64decode(picture))) as image:
        written = io.BytesIO()
        image.convert("RGB").quantize(COLOURS).save(written, "png", optimize=True)
    return base64.b64encode(written.getvalue()).decode("ascii")


@makes_each({(f"../notebooks/{path.name}",): (path,) for path in notebooks()})
def run(path: Path) -> Path:
    """Run a notebook and keep it."""
    keep(executed(path), path)
    return path
