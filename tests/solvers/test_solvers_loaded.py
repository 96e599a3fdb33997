"""Loops are printed where they are needed, and kept as machine code."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

LOOP = "linkages.solvers.loops.{}_steps"
RUN = """
import sys
import linkages

linkages.simulate(linkages.load("{}"), times=[0.0, 0.01], **{})
print("{}" in sys.modules)
"""


def writes(loop: str, mechanism: str, folder: str, **options: object) -> bool:
    run = [sys.executable, "-c", RUN.format(mechanism, options, LOOP.format(loop))]
    environment = os.environ | {"LINKAGES_CACHE_DIR": folder}
    found = subprocess.run(run, env=environment, capture_output=True, text=True, check=True)
    return {"True": True, "False": False}[found.stdout.strip()]


@pytest.mark.slow
def test_a_motion_that_nothing_watches_needs_no_loop(tmp_path):
    """Also where whole turns of dependent angles are counted, as in the five-bar."""
    for name in ("ninebar", "five-bar-free"):
        assert not writes("adaptive", name, str(tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize(("loop", "method"), [("fixed", "rk4"), ("implicit", "gauss8")])
def test_only_the_first_run_on_a_machine_compiles_its_loop(loop, method, tmp_path):
    options = {"method": method, "step": 1e-3}

    def kept(mechanism, folder):
        assert writes(loop, mechanism, str(tmp_path / folder), **options)
        files = [path for path in (tmp_path / folder).rglob("*") if path.is_file()]
        return {path.relative_to(tmp_path / folder): path.stat().st_mtime_ns for path in files}

    first = kept("ninebar", "one")
    assert first
    assert kept("ninebar", "one") == first
    # another mechanism has another kernel, but the same loops
    both, alone = kept("double-pendulum", "one"), kept("double-pendulum", "other")
    assert first.items() <= both.items()
    assert first.keys() & alone.keys()
