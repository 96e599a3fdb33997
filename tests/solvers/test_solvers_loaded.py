"""Compiled loops: kept as machine code, which needs no compiler."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

RUN = """
import sys
import linkages

linkages.simulate(linkages.load("{}"), times=[0.0, 0.01])
print("numba" in sys.modules)
"""


def needs_numba(mechanism: str, folder: str) -> bool:
    run = [sys.executable, "-c", RUN.format(mechanism)]
    environment = os.environ | {"LINKAGES_CACHE_DIR": folder}
    found = subprocess.run(run, env=environment, capture_output=True, text=True, check=True)
    return {"True": True, "False": False}[found.stdout.strip()]


@pytest.mark.slow
def test_only_the_first_run_on_a_machine_imports_numba(tmp_path):
    folder = str(tmp_path)
    assert needs_numba("ninebar", folder)
    assert not needs_numba("ninebar", folder)
    # another mechanism has another kernel, but the same loops
    assert not needs_numba("double-pendulum", folder)
