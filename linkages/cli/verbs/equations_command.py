"""``equations``: the equations of a mechanism, printed."""

from __future__ import annotations

from linkages.cli.requests import Request, mechanism_from
from linkages.cli.terminal import print_json
from linkages.equations import FORMATS, derive, render
from linkages.errors import InputError, Problem
from linkages.kernel.system import System, choose_free
from linkages.reading.wording import suggestion
from linkages.topology.topology import build_topology


def run(request: Request, form: str) -> int:
    """Print closure, energies and Lagrange's equations; returns the exit code."""
    if form not in FORMATS:
        near = suggestion(form, FORMATS) or f"; expected one of: {', '.join(FORMATS)}"
        message = f"unknown format {form!r}{near}"
        raise InputError("--format", [Problem(message=message)])
    mechanism = mechanism_from(request.file, request.assignments, request.tables_from)
    topology = build_topology(choose_free(mechanism))
    if topology.redundant:  # positions tell which blocks have to be solved together
        topology = System(topology.mechanism).topology
    text = render(derive(topology), form)
    if request.json:
        print_json({"mechanism": topology.mechanism.name, "format": form, "equations": text})
    else:
        print(text)
    return 0
