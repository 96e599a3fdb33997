"""Bytes of a definition file to text, and text to rows of cells, with the place of a problem."""

from __future__ import annotations

import codecs
import csv
import re

from linkages.errors import InputError, Problem

# What YAML 1.2 calls printable; everything else (control characters, lone surrogates) is refused
# here, with a place, rather than by the YAML scanner without one.
_NOT_TEXT = re.compile("[^\t\n\r\x20-\x7e\x85\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def decode(data: str | bytes, source: str) -> str:
    """Return the text of a UTF-8 file, without its byte order mark.

    Raises
    ------
    InputError
        Names line and byte offset of the first byte or character that is not text.
    """
    text = data.removeprefix("\ufeff") if isinstance(data, str) else _from_utf8(data, source)
    if bad := _NOT_TEXT.search(text):
        before = text[: bad.start()]
        code = ord(bad.group())
        found = f"byte 0x{code:02x}" if code < 0x80 else f"character U+{code:04X}"
        offset = len(before.encode(errors="surrogatepass"))
        if isinstance(data, bytes) and data.startswith(codecs.BOM_UTF8):
            offset += len(codecs.BOM_UTF8)
        raise InputError(source, [_not_text(found, offset, before)])
    return text


def csv_rows(text: str, source: str) -> list[tuple[int, list[str]]]:
    """Line numbers, from 1, and cells of a table, without empty lines and those that begin with #.

    Cells are separated by semicolons or tabs if the first line has any, otherwise by commas.

    Raises
    ------
    InputError
        For a cell that is too long.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    first = lines[0][1] if lines else ""
    separator = next((mark for mark in ";\t" if mark in first), ",")
    rows = []
    for number, line in lines:
        try:
            rows.append((number, next(csv.reader([line], delimiter=separator))))
        except csv.Error:  # the one error of a single line
            message = f"a cell is longer than {csv.field_size_limit()} characters"
            raise InputError(source, [Problem(message=message, line=number, column=1)]) from None
    return rows


def _from_utf8(data: bytes, source: str) -> str:
    try:
        return data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8")
        found = f"byte 0x{data[error.start]:02x}"
        raise InputError(source, [_not_text(found, error.start, before)]) from None


def _not_text(found: str, offset: int, before: str) -> Problem:
    message = f"{found} at byte offset {offset} is not text; expected a YAML file in UTF-8"
    line = len(re.findall("\r\n|\r|\n", before)) + 1
    column = len(re.split("[\r\n]", before)[-1].removeprefix("\ufeff")) + 1
    return Problem(message=message, line=line, column=column)
