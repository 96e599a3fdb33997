"""Scripts of the pages stand beside them."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[2] / "docs"))
