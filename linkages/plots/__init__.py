"""Figures of a solution: motion and errors over time, phase diagrams, drawings, traces; films.

`charts` has a function for each figure, which returns matplotlib axes.

Nothing here uses pyplot: figures are plain objects and nobody's settings are changed.
"""

from linkages.plots import charts
from linkages.plots.figures import FIGURES, save_figures, write_figure

__all__ = ["FIGURES", "charts", "save_figures", "write_figure"]
