"""Make the figures of docs/contact_guides.md: python docs/figures_contact_guides.py."""

from __future__ import annotations

import re
from functools import partial

import linkages
from linkages.plots.figures import write_figure
from linkages.plots.motion.clearance_orbit import SHOWN, orbit_figure, state_figure
from make.accuracy import ROOT, STATIC, write_small


def main() -> None:
    """Solve the mechanism of the page, and draw what its block does."""
    page = (ROOT / "docs" / "contact_guides.md").read_text(encoding="utf-8")
    found = re.search(r"```yaml\n(# slider-crank-play\.yaml\n.*?)```", page, re.DOTALL)
    assert found is not None
    solution = linkages.simulate(linkages.loads(found[1]), samples=2001, outputs=list(SHOWN))
    for name, figure, write in (
        ("path.png", orbit_figure, partial(write_small, colours=256)),
        ("state.svg", state_figure, write_figure),
    ):
        drawn = figure(solution.data, solution.mechanism)
        assert drawn is not None
        write(drawn, STATIC / f"contact-guides-{name}")


if __name__ == "__main__":
    main()
