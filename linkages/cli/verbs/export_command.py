"""``export``: a mechanism as files for other programs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape

from linkages.cli.requests import Request
from linkages.cli.terminal import print_notes
from linkages.exports import Subject, files_of, written


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

    def show(screen: Console) -> None:
        screen.print(f"[bold]{escape(request.mechanism.name)}[/bold] as {to}")
        print_notes(subject.notes, screen)

    content = {"format": to, "bytes": sum(sizes), "notes": subject.notes}
    return request.report(content, place.files, show)
