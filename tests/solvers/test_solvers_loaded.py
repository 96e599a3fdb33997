"""Compiled loops: compiled where they are needed, and kept as machine code."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

RUN = """
import sys
import linkages

linkages.simulate(linkages.load("{}"), times=[0.0, 0.01], **{})
print("numba" in sys.modules)
"""


def needs_numba(mechanism: str, folder: str, **options: object) -> bool:
    run = [sys.executable, "-c", RUN.format(mechanism, options)]
    environment = os.environ | {"LINKAGES_CACHE_DIR": folder}
    found = subprocess.run(run, env=environment, capture_output=True, text=True, check=True)
    return {"True": True, "False": False}[found.stdout.strip()]


def test_a_motion_that_nothing_watches_needs_no_loop(tmp_path):
    """Also where whole turns of dependent angles are counted, as in the five-bar."""
    for name in ("ninebar", "five-bar-free"):
        assert not needs_numba(name, str(tmp_path))


@pytest.mark.slow
def test_only_the_first_run_on_a_machine_imports_numba(tmp_path):
    folder, options = str(tmp_path), {"method": "rk4", "step": 1e-3}
    assert needs_numba("ninebar", folder, **options)
    assert not needs_numba("ninebar", folder, **options)
    # another mechanism has another kernel, but the same loops
    assert not needs_numba("double-pendulum", folder, **options)
