"""Loops write themselves where they are needed, and are kept as machine code."""

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


def test_a_motion_that_nothing_watches_needs_no_loop(tmp_path):
    """Also where whole turns of dependent angles are counted, as in the five-bar."""
    for name in ("ninebar", "five-bar-free"):
        assert not writes("adaptive", name, str(tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize(("loop", "method"), [("fixed", "rk4"), ("implicit", "gauss8")])
def test_only_the_first_run_on_a_machine_writes_its_loop(loop, method, tmp_path):
    folder, options = str(tmp_path), {"method": method, "step": 1e-3}
    assert writes(loop, "ninebar", folder, **options)
    assert not writes(loop, "ninebar", folder, **options)
    # another mechanism has another kernel, but the same loops
    assert not writes(loop, "double-pendulum", folder, **options)
