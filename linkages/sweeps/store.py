"""Answers on disk, chunk by chunk: what is there is whole, and belongs to this sweep.

A store is a folder::

    manifest.json       what is asked: definition, version, question, number of points, chunk size
    points.npy          numbers of all points, written before the first is computed
    chunks/000000000    header, all variables of a chunk, CRC: one renaming commits it
    result.nc           the dataset, when all chunks are there

A file appears whole under its name or not at all, and is never changed. Chunks that are not whole
are computed again.
"""

from __future__ import annotations

import errno
import io
import json
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.reading.wording import shown
from linkages.sweeps.answers import Arrays, Code, Question

if TYPE_CHECKING:
    import xarray as xr

FORMAT = 1
MAGIC = b"linkages sweep chunk\n"
MANIFEST, POINTS, CHUNKS, RESULT, LOCK = (
    "manifest.json", "points.npy", "chunks", "result.nc", "lock",
)  # fmt: skip
PART = ".part"

_NO_SPACE = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
_MOST_CHUNKS, _LARGEST = 512, 64

Span = tuple[int, int]


class SweepStore:
    """An open store; `stored` makes one."""

    def __init__(self, folder: Path, chunk: int, count: int) -> None:
        self.folder, self.chunk, self.count = folder, chunk, count

    def read(self, spans: Iterable[Span]) -> Iterator[tuple[Span, Arrays]]:
        """Chunks that are there and whole."""
        for span in spans:
            found = _read_chunk(self._path(span), span)
            if found is not None:
                yield span, found

    def write(self, span: Span, part: Arrays) -> None:
        """Keep a chunk.

        Raises
        ------
        ComputationError
            If there is no space left; what was stored before is intact.
        """
        self._put(self._path(span), _packed(span, part))

    def finish(self, data: xr.Dataset) -> None:
        """Write the dataset of all points."""
        from linkages.solution.files import netcdf_bytes

        self._put(self.folder / RESULT, netcdf_bytes(data))

    def _path(self, span: Span) -> Path:
        return self.folder / CHUNKS / f"{span[0]:09d}"

    def _put(self, path: Path, content: bytes | memoryview) -> None:
        try:
            put(path, content)
        except OSError as error:
            if error.errno not in _NO_SPACE:
                raise
            done = status(self.folder)["done"]
            parts = (self.count - done) / self.chunk if path.name != RESULT else 1.0
            more = len(content) * max(1.0, parts)
            raise ComputationError(
                f"{self.folder}: no space left to write {path.name}; {done} of {self.count} points "
                f"are stored, about {more:.3g} bytes more are needed. Make room: the same command "
                "goes on from there",
                time=None,
            ) from None


@contextmanager
def stored(
    folder: str | Path | None, mechanism: Mechanism, question: Question, chunk: int | None = None
) -> Iterator[SweepStore | None]:
    """Open or begin the store of a question; None without a folder.

    Parameters
    ----------
    folder
        Where.
    mechanism, question
        What is asked.
    chunk
        Points that are kept together; as the question has it if not given.

    Raises
    ------
    InputError
        If the folder holds something else, or somebody else writes there.
    """
    if folder is None:
        yield None
        return
    place = Path(folder)
    if place.exists() and not place.is_dir():
        raise _refused(place, "expected a folder for the store, found a file")
    if place.is_dir() and any(place.iterdir()) and not (place / MANIFEST).exists():
        strange = [p.name for p in place.iterdir() if p.name not in (LOCK, POINTS, CHUNKS)]
        if any(not name.endswith(PART) for name in strange):
            raise _refused(place, "expected a store or an empty folder, found other files")
    (place / CHUNKS).mkdir(parents=True, exist_ok=True)
    with _locked(place):
        _remove_leftovers(place)
        kept = _begun(place, mechanism, question, chunk)
        yield SweepStore(place, kept, question.count)


def _begun(place: Path, mechanism: Mechanism, question: Question, wanted: int | None) -> int:
    """Compare the store with what is asked, or write that down; returns the chunk size."""
    numbers = np.ascontiguousarray(question.numbers(), dtype="<f8")
    own = {
        "format": FORMAT,
        "version": f"linkages {version('linkages')}",
        "definition": mechanism.to_yaml(),
        "count": question.count,
        "question": json.loads(json.dumps(question.described, default=str)),
        "numbers of points (checksum)": zlib.crc32(numbers.tobytes()),
    }
    path = place / MANIFEST
    if path.exists():
        try:
            there = json.loads(path.read_text(encoding="utf-8"))
            chunk = int(there.pop("chunk"))
        except (ValueError, KeyError) as error:
            raise _refused(place, f"{MANIFEST} cannot be read: {error}") from None
        different = _difference(there, own)
        if different:
            raise _refused(
                place,
                f"holds another sweep: {different}; expected the same sweep, or another folder",
            )
        return chunk
    fewest, most = question.together
    usual = max(fewest, min(max(most, _LARGEST), question.count // _MOST_CHUNKS))
    chunk = wanted or usual
    buffer = io.BytesIO()
    np.save(buffer, numbers)
    store = SweepStore(place, chunk, question.count)
    store._put(place / POINTS, buffer.getvalue())
    text = json.dumps({**own, "chunk": chunk}, indent=1, ensure_ascii=False)
    store._put(path, text.encode())
    return chunk


def _difference(there: Any, here: Any, name: str = "") -> str:
    """The first entry that differs, as a clause; empty if none does."""
    if isinstance(there, Mapping) and isinstance(here, Mapping):
        for key in dict.fromkeys([*here, *there]):
            inner = f"{name}: {key}" if name and name != "question" else str(key)
            found = _difference(there.get(key), here.get(key), inner)
            if found:
                return found
        return ""
    if there == here:
        return ""
    if isinstance(there, str) and isinstance(here, str) and "\n" in there + here:
        lines = zip(there.splitlines(), here.splitlines(), strict=False)
        pair = next(((a, b) for a, b in lines if a != b), ("", ""))
        there, here = (text.strip() for text in pair)
    return f"{name} is {shown(str(there))} there and {shown(str(here))} here"


def status(folder: str | Path) -> dict[str, Any]:
    """What a store holds: points, how many are done, and what became of them.

    Raises
    ------
    InputError
        If it is no store.
    """
    place = Path(folder)
    try:
        manifest = json.loads((place / MANIFEST).read_text(encoding="utf-8"))
        count, chunk = int(manifest["count"]), int(manifest["chunk"])
    except (OSError, ValueError, KeyError, TypeError):
        raise _refused(place, f"expected the store of a sweep, with a {MANIFEST}") from None
    spans = [(at, min(at + chunk, count)) for at in range(0, count, chunk)]
    outcomes = np.zeros(len(Code), dtype=int)
    reasons: Counter[str] = Counter()
    for _, part in SweepStore(place, chunk, count).read(spans):
        outcomes += np.bincount(part["outcome"], minlength=len(Code))
        reasons.update(part["reason"][part["reason"] != ""].tolist())
    done = int(outcomes.sum())
    return {
        "store": str(place),
        "version": manifest.get("version"),
        "points": count,
        "done": done,
        "left": count - done,
        "finished": (place / RESULT).exists(),
        "outcomes": {code.words: int(outcomes[code]) for code in Code if outcomes[code]},
        "reasons": dict(reasons.most_common()),
    }


def put(path: Path, content: bytes | memoryview) -> None:
    """Write a file that appears whole under its name, and stays there when power is lost."""
    part = path.with_name(path.name + PART)
    try:
        with part.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException:
        with suppress(OSError):
            part.unlink()
        raise
    if os.name == "posix":
        handle = os.open(path.parent, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def _packed(span: Span, part: Arrays) -> bytes:
    """Magic, length of the header, header, arrays, CRC of all that."""
    arrays = {name: np.ascontiguousarray(array) for name, array in part.items()}
    header = json.dumps(
        {
            "span": span,
            "arrays": [[name, a.dtype.str, list(a.shape)] for name, a in arrays.items()],
        }
    ).encode()
    body = b"".join(a.tobytes() for a in arrays.values())
    content = MAGIC + struct.pack("<Q", len(header)) + header + body
    return content + struct.pack("<I", zlib.crc32(content))


def _read_chunk(path: Path, span: Span) -> Arrays | None:
    """A chunk; None if it is not there, or not whole."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    if not content.startswith(MAGIC) or len(content) < len(MAGIC) + 12:
        return None
    if zlib.crc32(content[:-4]) != struct.unpack("<I", content[-4:])[0]:
        return None
    start = len(MAGIC) + 8
    (size,) = struct.unpack("<Q", content[len(MAGIC) : start])
    header = json.loads(content[start : start + size])
    if tuple(header["span"]) != span:
        return None
    found: Arrays = {}
    at = start + size
    for name, dtype, shape in header["arrays"]:
        length = int(np.prod(shape)) * np.dtype(dtype).itemsize
        found[name] = np.frombuffer(content[at : at + length], dtype=dtype).reshape(shape).copy()
        at += length
    return found


def _remove_leftovers(place: Path) -> None:
    """Remove what a process that was killed had begun to write."""
    for folder in (place, place / CHUNKS):
        for path in folder.glob(f"*{PART}"):
            path.unlink(missing_ok=True)


@contextmanager
def _locked(place: Path) -> Iterator[None]:
    """Keep others from writing into a folder; the system lets go when the process ends."""
    with (place / LOCK).open("a+b") as file:
        try:
            if os.name == "nt":
                import msvcrt

                msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)  # type: ignore[attr-defined]
            else:
                import fcntl

                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise _refused(place, "another process writes into this store") from None
        yield


def _refused(place: Path, message: str) -> InputError:
    return InputError(str(place), [Problem(message=message)])
