"""Loops are printed where they are needed, and kept as machine code."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from linkages.solvers.loops import scalar_stages as loaded

LOOP = "linkages.solvers.loops.{}"
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
        assert not writes("step_loop", name, str(tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("loop", "method"), [("step_loop", "rk4"), ("collocation_steps", "gauss8")]
)
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


def test_threads_that_need_a_loop_at_the_same_time_get_the_same(monkeypatch):
    """Code that only one of them kept would be freed while another runs it."""
    made = []

    class Slow(loaded.MachineCode):
        def __init__(self, text):
            time.sleep(0.05)
            super().__init__(text)
            made.append(self)

    monkeypatch.setattr(loaded, "MachineCode", Slow)
    one = loaded.Loaded("linkages.solvers.loops.scalar_stages", "repeat")
    with ThreadPoolExecutor(8) as pool:
        addresses = set(pool.map(lambda _: one.address, range(8)))
    assert len(made) == 1
    assert addresses == {made[0].address("repeat")}
