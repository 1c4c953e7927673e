"""The grid of a page: the motion, the widgets, the other figures, as the width allows."""

WIDTH = 270  # of a widget
SIDE = WIDTH + 30
PHONE, NARROW = 640, 1000  # pixels below which a page has one column, and two


def grid(root):
    """The rules of CSS for the element with the selector `root` and its parts."""
    return f"""
{root} {{
  display: grid; align-items: start; gap: 4px 12px;
  grid-template: "side said said" auto "side motion others" auto "side numbers others" 1fr
    / {SIDE}px minmax(0, 5fr) minmax(0, 4fr);
}}
.side {{ grid-area: side; }}
.said {{ grid-area: said; }} .motion {{ grid-area: motion; }} .numbers {{ grid-area: numbers; }}
.others {{ grid-area: others; }}
@media (max-width: {NARROW}px) {{
  {root} {{
    grid-template: "side said" auto "side motion" auto "side others" auto "side numbers" 1fr
      / {SIDE}px minmax(0, 1fr);
  }}
}}
@media (max-width: {PHONE}px) {{
  {root} {{
    grid-template: "said" auto "motion" auto "side" auto "others" auto "numbers" auto
      / minmax(0, 1fr);
  }}
}}
"""
