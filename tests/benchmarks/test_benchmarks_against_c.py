"""The hand-written C program and the generated kernel compute the same motion."""

from __future__ import annotations

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

import linkages
from linkages.kernel.system import System
from linkages.solution.plan import build_flow
from linkages.solvers.integration import integrate

sys.path.insert(0, str(Path(__file__).parent))

from against_c import START, compile_c


def test_c_program_and_kernel_agree(tmp_path):
    program = compile_c(tmp_path)
    if program is None:
        pytest.skip("no C compiler on this machine")
    steps, end = 40_000, 0.5
    command = [str(program), str(steps), str(end)]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    system = System(linkages.load("ninebar.yaml", set=START))
    found = integrate(build_flow(system), system.state, [0.0, end], method="rk4", step=end / steps)
    # Both make the same steps; round-off of 4e4 steps is amplified by the motion (about 100-fold).
    assert found.unwrapped[-1, 0] == pytest.approx(float(output[0]), abs=1e-9)
    assert found.state[-1, 1] == pytest.approx(float(output[1]), abs=1e-6)


@pytest.mark.slow
def test_memory_does_not_grow_with_the_number_of_steps():
    resource = pytest.importorskip("resource", reason="peak memory is read from POSIX")
    del resource
    code = textwrap.dedent("""
        import resource
        import linkages
        mechanism = linkages.load("ninebar.yaml")
        def peak(steps):
            linkages.simulate(mechanism, end=2.0, samples=11, method="rk4", step=2.0 / steps,
                              outputs=["clearance_angle"])
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        first = peak(1_000)
        print(peak(2_000_000) - first)
    """)
    command = [sys.executable, "-c", code]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    # One byte a step would be 2 MB; ru_maxrss counts kilobytes (bytes on macOS).
    assert int(output) <= (1 << 20 if sys.platform == "darwin" else 1 << 10)
