"""Names of joints that move along with them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import matplotlib.patheffects as effects
from matplotlib.axes import Axes
from matplotlib.text import Text
from matplotlib.transforms import ScaledTranslation

from linkages.plots.style import BLACK

BESIDE = (5.0, 5.0)
"""Points to the right of and above a joint."""


class Names:
    """Names beside joints, white around so that lines below do not disturb.

    Parameters
    ----------
    ax
        Where the joints are.
    joints
        Their names; those of points beside a pin, such as ``C.r1``, are left out.
    """

    def __init__(self, ax: Axes, joints: Iterable[str]) -> None:
        figure = ax.get_figure(root=True)
        assert figure is not None
        x, y = (beside / 72.0 for beside in BESIDE)
        place = ax.transData + ScaledTranslation(x, y, figure.dpi_scale_trans)
        around = effects.withStroke(linewidth=2.5, foreground="white")
        self._texts: dict[str, Text] = {}
        for joint in joints:
            if "." not in joint:
                text = ax.text(0, 0, joint, transform=place, color=BLACK, fontsize=9, zorder=9)
                text.set_path_effects([around])
                text.set_animated(True)
                self._texts[joint] = text

    def shown(self, positions: Mapping[str, tuple[float, float]]) -> list[Text]:
        """Names of the joints that have places, there."""
        found = [name for name in self._texts if name in positions]
        for name in found:
            self._texts[name].set_position(positions[name])
        return [self._texts[name] for name in found]
