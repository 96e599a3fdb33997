"""``list``: the mechanisms that are shipped with the package."""

from __future__ import annotations

from linkages.cli.terminal import console, print_json, table
from linkages.reading.document import read
from linkages.reading.locate import shipped


def run_list(json: bool) -> int:
    """List the library with a line each; returns the exit code."""
    entries = {
        name: {"title": read(path).content.get("name"), "file": str(path)}
        for name, path in shipped().items()
    }
    if json:
        print_json({"mechanisms": entries})
        return 0
    rows = [[name, str(entry["title"])] for name, entry in entries.items()]
    console().print(table("Mechanisms shipped with the package", ["file", "what it is"], rows))
    return 0
