"""The layout of a page: the motion, the widgets, the other figures, as the width allows."""

from typing import Any

import panel as pn

from .grid import PHONE, SIDE, WIDTH, grid

STALE = {"opacity": "0.3", "filter": "grayscale(1)"}  # the look of curves that no longer hold
FRESH = {"opacity": "1", "filter": "none"}
VIEWPORT = """{% block preamble %}
<meta name="viewport" content="width=device-width, initial-scale=1">
{% endblock %}"""
STYLE = f"""
{grid(":host")}
.side {{ overflow: hidden auto; max-height: 100vh; }}
@media (max-width: {PHONE}px) {{ .side {{ max-height: none; justify-self: center; }} }}
"""


def page(widgets, said, motion, panes, numbers):
    """
    A page of all parts.

    Parameters
    ----------
    widgets : list
        The widgets at the side.
    said : list
        What is said above the figures.
    motion : list
        The moving picture, and the button below.
    panes : list
        The other figures.
    numbers : Panel object
        The table of numbers.
    """
    for one in widgets:
        if isinstance(one, pn.widgets.Widget):
            one.width = WIDTH
    parts = {
        "side": pn.Column(*widgets, width=SIDE),
        "said": _wide(*said),
        "motion": _wide(*motion),
        "others": _wide(*panes),
        "numbers": _wide(numbers),
    }
    for area, part in parts.items():
        part.css_classes = [area]
    return pn.Column(*parts.values(), sizing_mode="stretch_width", stylesheets=[STYLE])


def _wide(*parts) -> Any:
    return pn.Column(*parts, sizing_mode="stretch_width")
