"""Systems of one's own, such as ordinary differential equations and maps, stand with the pages."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "docs"))
sys.path.append(str(Path(__file__).parents[1] / "solution"))
