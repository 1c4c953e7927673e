"""The layout of a page: the motion, the widgets, the other figures, as the width allows."""

from typing import Any

import panel as pn

WIDTH = 270  # of a widget
SIDE = WIDTH + 30
PHONE, NARROW = 640, 1000  # pixels below which a page has one column, and two
STALE = {"opacity": "0.3", "filter": "grayscale(1)"}  # the look of curves that no longer hold
FRESH = {"opacity": "1", "filter": "none"}
VIEWPORT = """{% block preamble %}
<meta name="viewport" content="width=device-width, initial-scale=1">
{% endblock %}"""
STYLE = f"""
:host {{
  display: grid; align-items: start; gap: 4px 12px;
  grid-template: "side said said" auto "side motion others" auto "side numbers others" 1fr
    / {SIDE}px minmax(0, 5fr) minmax(0, 4fr);
}}
.side {{ grid-area: side; overflow: hidden auto; max-height: 100vh; }}
.said {{ grid-area: said; }} .motion {{ grid-area: motion; }} .numbers {{ grid-area: numbers; }}
.others {{ grid-area: others; }}
@media (max-width: {NARROW}px) {{
  :host {{
    grid-template: "side said" auto "side motion" auto "side others" auto "side numbers" 1fr
      / {SIDE}px minmax(0, 1fr);
  }}
}}
@media (max-width: {PHONE}px) {{
  :host {{
    grid-template: "said" auto "motion" auto "side" auto "others" auto "numbers" auto
      / minmax(0, 1fr);
  }}
  .side {{ max-height: none; justify-self: center; }}
}}
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
