"""The benchmark of sections and exponents runs; it asserts no times."""

import json
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_it_prints_a_ratio_for_every_analysis():
    script = Path(__file__).with_name("analyses.py")
    command = [sys.executable, str(script), "--json", "2"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    found = json.loads(output)
    assert list(found) == [
        "stroboscopic section", "geometric section", "largest exponent", "both exponents",
    ]  # fmt: skip
    assert all(ratio > 0 for ratio in found.values())
