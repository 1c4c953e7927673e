"""Figures at slide size.  Matplotlib is imported when the first figure is drawn, not before."""

from .solution import (
    components,
    curve,
    drift,
    exact_curve,
    invariants,
    plane,
    plot,
    relative_changes,
)
from .style import COLOURS, column, legend, own_legend, pictures_and_panels, save, slides

__all__ = [
    "COLOURS", "column", "components", "curve", "drift", "exact_curve", "invariants", "legend",
    "own_legend", "pictures_and_panels", "plane", "plot", "relative_changes", "save", "slides",
]  # fmt: skip
