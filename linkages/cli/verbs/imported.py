"""``import``: a definition file from a share link of another program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from linkages.cli.loading import require_folder
from linkages.cli.terminal import console, print_json
from linkages.errors import InputError, Problem
from linkages.reading.overrides import parse_assignment
from linkages.spec.conversion import QuantityError, parse_quantity
from linkages.spec.dimensions import LENGTH, Bound


def run_import(
    link: str,
    out: Path,
    masses: bool,
    mass_per_length: float,
    clearance: Sequence[str],
    force: bool,
    json: bool,
) -> int:
    """Write a definition file; returns the exit code."""
    from linkages.bridges.pmks import from_pmks

    if out.exists() and not force:
        raise InputError("import", [Problem(message=f"{out} exists; --force replaces it")])
    require_folder(out.parent)
    try:
        mechanism = from_pmks(
            link, masses=masses and not mass_per_length, mass_per_length=mass_per_length,
            clearances=dict(map(_clearance, clearance)),
        )  # fmt: skip
    except ValueError as error:
        raise InputError("import", [Problem(message=str(error))]) from None
    mechanism.save(out)
    if json:
        print_json({"mechanism": mechanism.name, "files": [str(out)]})
        return 0
    screen = console()
    screen.print(f"wrote {out}: {mechanism!r}", markup=False, soft_wrap=True)
    screen.print(f"next: python -m linkages check {out}", markup=False, soft_wrap=True)
    return 0


def _clearance(text: str) -> tuple[str, float]:
    joint, size = parse_assignment(text)
    try:
        return joint, parse_quantity(size, LENGTH, Bound.POSITIVE)
    except QuantityError as error:
        raise InputError("--clearance", [Problem(message=f"{joint}: {error}")]) from None
