"""Answers on disk, chunk by chunk: what is there is whole, and belongs to this sweep.

A store is a folder::

    manifest.json       what is asked: definition, version, question, number of points, chunk size
    points.npy          numbers of all points, written before the first is computed
    chunks/000000000    header, all variables of a chunk, CRC: one renaming commits it
    result.nc           the dataset, when all chunks are there

A file appears whole under its name or not at all, and is never changed. Chunks that are not whole
are computed again. A folder may come from anywhere: what is read of it is validated, with limits.
"""

from __future__ import annotations

import errno
import io
import json
import math
import os
import struct
import zlib
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, JsonValue, ValidationError
from pydantic import Field as Limited

from linkages.components.mechanisms.mechanism import Mechanism
from linkages.errors import ComputationError, InputError, Problem
from linkages.reading.wording import shown
from linkages.sweeps.axes import MOST_POINTS
from linkages.sweeps.engine import (
    OWN,
    Answer,
    Arrays,
    Code,
    Field,
    Question,
    Successive,
    stacked,
)

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

MAX_MANIFEST, MAX_HEADER, MAX_TEXTS = 32 * 1024**2, 1024**2, 256 * 1024**2
"""Bytes of a manifest, of the header of a chunk, and of all texts of one kind in a chunk."""

_BLOCK = 1024**2

Span = tuple[int, int]

_Name = Annotated[str, Limited(max_length=10_000)]
_Text = Annotated[str, Limited(max_length=MAX_MANIFEST)]
_Length = Annotated[int, Limited(ge=0, le=2**48)]
_Shape = Annotated[list[_Length], Limited(min_length=1, max_length=8)]
_Dtype = Annotated[str, Limited(pattern=r"^[<>=|]?([fi][1248]|U[1-9][0-9]{0,8})$")]


class _Manifest(BaseModel):
    """What is read of a manifest; what else it contains is compared with what is asked."""

    model_config = ConfigDict(strict=True)

    version: Annotated[str, Limited(max_length=1000)]
    definition: _Text
    question: dict[_Name, JsonValue]
    count: Annotated[int, Limited(ge=0, le=MOST_POINTS)]
    chunk: Annotated[int, Limited(ge=1, le=MOST_POINTS)]


class _Header(BaseModel):
    """What a chunk contains: name, type and shape of each array, in the order of their bytes."""

    model_config = ConfigDict(strict=True, extra="forbid")

    span: Annotated[list[_Length], Limited(min_length=2, max_length=2)]
    arrays: Annotated[list[tuple[_Name, _Dtype, _Shape]], Limited(max_length=10_000)]


class SweepStore:
    """An open store; `stored` makes one."""

    def __init__(self, folder: Path, chunk: int, count: int) -> None:
        self.folder, self.chunk, self.count = folder, chunk, count

    def read(
        self, spans: Iterable[Span], fields: Mapping[str, Field]
    ) -> Iterator[tuple[Span, Arrays]]:
        """`OWN` and other fields of the chunks that are there and whole."""
        wanted = OWN | dict(fields)
        for span in spans:
            try:
                result = _read_chunk(self._path(span), span, wanted)
            except ValueError as error:
                raise self.damaged(span, str(error)) from None
            if result is not None:
                yield span, result

    def damaged(self, span: Span, what: str) -> InputError:
        """A chunk that this package did not write in this place."""
        message = f"{what}; remove this file to compute its points again"
        return _refused(self._path(span), message)

    def write(self, span: Span, part: Arrays) -> None:
        """Store a chunk; ComputationError if there is no space left, with stored chunks intact."""
        self._put(self._path(span), _packed(span, part))

    def finish(self, data: xr.Dataset) -> None:
        """Write the dataset of all points."""
        from linkages.solution.files import netcdf_bytes

        self._put(self.folder / RESULT, netcdf_bytes(data))

    def _path(self, span: Span) -> Path:
        return self.folder / CHUNKS / f"{span[0]:09d}"

    def _put(self, path: Path, content: bytes) -> None:
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

    Chunks have `chunk` points, else as many as the question says. Raises InputError if the folder
    holds something else, or another process writes there.
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


class InOrder:
    """Results that follow from each other, kept one by one; none are without a store."""

    def __init__(self, store: SweepStore | None) -> None:
        self.store, self._count = store, 0

    def next(self, fields: Mapping[str, Field]) -> dict[str, Any] | None:
        """The next result, and `OWN` of it; None if it is not there."""
        self._count += 1
        for _, part in () if self.store is None else self.store.read([self._span], fields):
            return {name: array[0] for name, array in part.items()}
        return None

    def keep(self, fields: Mapping[str, Field], answer: Answer) -> None:
        """Keep the result that was asked for last."""
        if self.store is not None:
            self.store.write(self._span, stacked(fields, [answer]))

    @property
    def _span(self) -> Span:
        return self._count - 1, self._count

    def finish(self, data: xr.Dataset) -> None:
        """As `SweepStore.finish`."""
        if self.store is not None:
            self.store.finish(data)


@contextmanager
def in_order(
    folder: str | Path | None, mechanism: Mechanism, kind: str, about: Mapping[str, Any]
) -> Iterator[InOrder]:
    """Open or begin the store of results that follow from each other, as `stored` does it."""
    with stored(folder, mechanism, Successive(kind, about), 1) as kept:
        yield InOrder(kept)


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
        _, there = _read_manifest(place)
        chunk = int(there.pop("chunk"))
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
            result = _difference(there.get(key), here.get(key), inner)
            if result:
                return result
        return ""
    if there == here:
        return ""
    if isinstance(there, str) and isinstance(here, str) and "\n" in there + here:
        lines = zip(there.splitlines(), here.splitlines(), strict=False)
        pair = next(((a, b) for a, b in lines if a != b), ("", ""))
        there, here = (text.strip() for text in pair)
    return f"{name} is {shown(str(there))} there and {shown(str(here))} here"


def status(folder: str | Path) -> dict[str, Any]:
    """What a store holds: points, how many are done, and what became of them."""
    place = Path(folder)
    manifest, _ = _read_manifest(place)
    count, chunk = manifest.count, manifest.chunk
    spans = ((at, min(at + chunk, count)) for at in range(0, count, chunk))
    outcomes = np.zeros(len(Code), dtype=int)
    reasons: Counter[str] = Counter()
    for _, part in SweepStore(place, chunk, count).read(spans, {}):
        outcomes += np.bincount(part["outcome"], minlength=len(Code))
        reasons.update(part["reason"][part["reason"] != ""].tolist())
    done = int(outcomes.sum())
    return {
        "store": str(place),
        "version": manifest.version,
        "points": count,
        "done": done,
        "left": count - done,
        "finished": (place / RESULT).exists(),
        "outcomes": {code.words: int(outcomes[code]) for code in Code if outcomes[code]},
        "reasons": dict(reasons.most_common()),
    }


def put(path: Path, content: bytes) -> None:
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


def _read_manifest(place: Path) -> tuple[_Manifest, dict[str, Any]]:
    """What a manifest says, and all of it."""
    path = place / MANIFEST
    try:
        if not path.is_file():
            raise _refused(place, f"expected the store of a sweep, with a {MANIFEST}")
        with path.open("rb") as file:
            content = file.read(MAX_MANIFEST + 1)
    except OSError as error:
        raise _refused(path, f"cannot be read: {error.strerror or error}") from None
    if len(content) > MAX_MANIFEST:
        raise _refused(path, f"larger than {MAX_MANIFEST // 1024**2} MiB; the file is damaged")
    try:
        return _Manifest.model_validate_json(content), json.loads(content)
    except ValidationError as error:
        places = dict.fromkeys(str(each["loc"][0]) for each in error.errors() if each["loc"])
        what = f"{', '.join(places)}: not as expected" if places else "expected a JSON object"
        raise _refused(path, f"{what}; the file is damaged, or linkages did not write it") from None


def _read_chunk(path: Path, span: Span, fields: Mapping[str, Field]) -> Arrays | None:
    """Arrays of a chunk; None if it is not there, or not whole."""
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:
            body = _whole(file)
            return None if body is None else _arrays(file, body, span, fields)
    except OSError:
        return None


def _whole(file: BinaryIO) -> int | None:
    """Bytes between the magic and the CRC of a chunk, where the file then is; None if damaged."""
    length = os.fstat(file.fileno()).st_size - len(MAGIC) - 4
    if length < 8 or file.read(len(MAGIC)) != MAGIC:
        return None
    result, left = zlib.crc32(MAGIC), length
    while left:
        block = file.read(min(_BLOCK, left))
        if not block:
            return None
        result, left = zlib.crc32(block, result), left - len(block)
    if file.read(4) != struct.pack("<I", result):
        return None
    file.seek(len(MAGIC))
    return length


def _arrays(file: BinaryIO, body: int, span: Span, fields: Mapping[str, Field]) -> Arrays:
    """Fields of a whole chunk, checked before anything is allocated."""
    (size,) = struct.unpack("<Q", file.read(8))
    if size > min(MAX_HEADER, body - 8):
        raise ValueError("has a header that is too long")
    try:
        header = _Header.model_validate_json(file.read(size))
    except ValidationError:
        raise ValueError("has a header that linkages did not write") from None
    if tuple(header.span) != span:
        other = " to ".join(map(str, header.span))
        raise ValueError(f"has points {other}, expected {span[0]} to {span[1]}")
    kinds = {name: (np.dtype(dtype), tuple(shape)) for name, dtype, shape in header.arrays}
    sizes = {name: math.prod(shape) * dtype.itemsize for name, (dtype, shape) in kinds.items()}
    if len(kinds) < len(header.arrays) or sum(sizes.values()) != body - 8 - size:
        raise ValueError("has a header that does not fit its data")
    for name, field in fields.items():
        wanted = np.dtype(field.dtype)
        dtype, shape = kinds.get(name, (None, ()))
        if (
            dtype is None
            or (dtype.kind, shape) != (wanted.kind, (span[1] - span[0], *field.shape))
            or (dtype.itemsize != wanted.itemsize if dtype.kind != "U" else sizes[name] > MAX_TEXTS)
        ):
            raise ValueError(f"{shown(name)} is missing, or of another type or shape")
    result: Arrays = {}
    for name, (dtype, shape) in kinds.items():
        if name in fields:
            array: NDArray[Any] = np.ndarray(shape, dtype, bytearray(file.read(sizes[name])))
            if dtype.kind == "U" and not _are_texts(array.view(f"{dtype.str[0]}u4")):
                raise ValueError(f"{shown(name)} has characters that no text has")
            result[name] = array
        else:
            file.seek(sizes[name], os.SEEK_CUR)
    outcome = result["outcome"]
    if ((outcome < 0) | (outcome >= len(Code))).any():
        raise ValueError("'outcome' has a code that there is not")
    return result


def _are_texts(codes: NDArray[np.uint32]) -> bool:
    """Whether code points are characters, and none of them controls a terminal."""
    control = (codes < 0x20) & ~np.isin(codes, (0, 9, 10)) | (codes > 0x7E) & (codes < 0xA0)
    none = (codes > 0x10FFFF) | (codes >= 0xD800) & (codes < 0xE000)
    return not (control | none).any()


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
