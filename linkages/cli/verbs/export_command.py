"""``export``: a mechanism as files for other programs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.markup import escape

from linkages.cli.requests import Request
from linkages.exports import Subject, files_of, written
from linkages.reports.report import Notes, Report


def run(request: Request, to: str, **own: Any) -> int:
    """Write a file in a format, as `linkages.export` does; returns the exit code."""
    request = replace(request, verb=f"export-{to}")  # each format has files of its own
    options = {name: value for name, value in own.items() if value is not None}
    with request.computing(f"exporting to {escape(to)}:"):
        subject = Subject(request.mechanism, Path(request.file).stem, None, request.given)
        files = files_of(subject, to, options)
    with request.publishing() as place:
        written(files, place.folder)
    sizes = [path.stat().st_size for path in place.files]
    report = Report(
        name=f"{request.mechanism.name} as {to}",
        parts=[Notes(subject.notes)],
        data={"format": to, "bytes": sum(sizes), "notes": subject.notes},
    )
    return request.report(report, place.files)
