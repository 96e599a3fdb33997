"""States of the kernel, and mechanisms of all kinds, live in the folder of its tests."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "tests/kernel"))
