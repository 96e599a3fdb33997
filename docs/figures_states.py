"""Make the figures of the pages on states and sampled controllers.

    python docs/figures_states.py

Everything is computed anew (seconds) and does not depend on the machine beyond round-off.
"""

from __future__ import annotations

import re

import numpy as np
from figures import ROOT, STATIC
from matplotlib.figure import Figure

import linkages
from linkages.plots.figures import write_figure
from linkages.plots.style import panels, styled


def on_page(page: str, name: str) -> str:
    """A whole definition of a page."""
    text = (ROOT / "docs" / "components" / page).read_text(encoding="utf-8")
    found = re.search(rf"^```yaml\n# {name}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found[1]


@styled
def boom() -> Figure:
    """Pressure and angle while a valve is open, and behind."""
    data = linkages.simulate(linkages.loads(on_page("state.md", "boom.yaml")), samples=3001).data
    figure, (upper, lower) = panels(2, 1, 1.5, top=0.1)
    time = data.time
    upper.plot(time, data.internal_state[:, 0] / 1e5)
    upper.set_ylabel("pressure (bar)")
    lower.plot(time, np.degrees(data.bar_angle.sel(bar="boom")))
    lower.set_ylabel("angle (°)")
    lower.set_xlabel("time (s)")
    return figure


def main() -> None:
    """Write all figures."""
    write_figure(boom(), STATIC / "state-boom.svg")


if __name__ == "__main__":
    main()
