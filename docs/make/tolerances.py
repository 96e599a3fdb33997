"""Make the figure of docs/tolerances.md.

    python docs/figures_tolerances.py

The definition is that of the page. Files go to docs/_static and are committed.
"""

from __future__ import annotations

import re

import linkages
from linkages.plots.study_figures import tolerance_figure
from make.accuracy import STATIC, write_small

PAGE = STATIC.parent / "tolerances.md"
MEASURE = "max(sqrt(error(P.x position)**2 + error(P.y position)**2))"


def main() -> None:
    """Draw the error of the coupler point."""
    text = re.search(r"```yaml\n(# jig.yaml.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert text is not None
    data = linkages.tolerance(linkages.loads(text[1]), MEASURE, limits=f"{MEASURE} < 0.15 mm")
    figure = tolerance_figure(data, MEASURE)
    assert figure is not None
    write_small(figure, STATIC / "tolerances.png")


if __name__ == "__main__":
    main()
