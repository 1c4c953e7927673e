"""Figures at slide size.  Matplotlib is imported when the first figure is drawn, not before."""

from .solution import (
    COLOURS,
    column,
    components,
    curve,
    drift,
    exact_curve,
    invariants,
    legend,
    pictures_and_panels,
    plane,
    plot,
    relative_changes,
    save,
    slides,
)

__all__ = [
    "COLOURS", "column", "components", "curve", "drift", "exact_curve", "invariants", "legend",
    "pictures_and_panels", "plane", "plot", "relative_changes", "save", "slides",
]  # fmt: skip
