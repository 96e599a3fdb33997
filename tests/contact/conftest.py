"""The other formulation reads mechanisms with helpers that live in another folder."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parents[1] / "oracle"))
