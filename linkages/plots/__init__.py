"""Figures of a solution: motion and errors over time, phase diagrams, drawings, traces.

Nothing here uses pyplot: figures are plain objects and nobody's settings are changed.
"""

from linkages.plots.figures import FIGURES, save_figures, write_figure

__all__ = ["FIGURES", "save_figures", "write_figure"]
