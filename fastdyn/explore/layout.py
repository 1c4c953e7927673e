"""The layout of a page: the widgets at the left, the figures at the right."""

from typing import Any

import panel as pn

WIDTH = 270  # of a widget
SIDE = WIDTH + 30
COLUMNS = "repeat(auto-fit, minmax(max(350px, 40%), 1fr))"  # two, or one on a narrow page
SCROLLED: Any = {"overflow": "hidden auto", "max-height": "100vh"}


def page(widgets, trouble, panes, numbers):
    """
    A page of all parts.

    Parameters
    ----------
    widgets, panes : list
        The widgets at the side, and the figures.
    trouble, numbers : Panel objects
        The parts above and below the figures.
    """
    for one in widgets:
        if isinstance(one, pn.widgets.Widget):
            one.width = WIDTH
    if len(panes) % 2:
        panes[-1].styles = {"grid-column": "1 / -1"}  # a row of its own
    side = pn.Column(*widgets, width=SIDE, styles=SCROLLED)
    shown = pn.Column(trouble, _grid(COLUMNS, *panes), numbers, sizing_mode="stretch_width")
    return _grid(f"{SIDE}px minmax(350px, 1fr)", side, shown)


def _grid(columns, *parts):
    """A grid of parts, with columns in CSS's notation."""
    styles: Any = {"display": "grid", "grid-template-columns": columns, "align-items": "start"}
    return pn.Column(*parts, sizing_mode="stretch_width", styles=styles)
