"""Other roads to the same results, and the generator of N four-bars, live in other folders."""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path += [
    str(ROOT / folder) for folder in ("tests/oracle", "tests/kernel", "tests/contact", "docs")
]
