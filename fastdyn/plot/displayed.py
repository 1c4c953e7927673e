"""The display of results in sessions: a line of text; in a notebook a table and a picture."""

import base64
import html
import io

from .needed import needed

DPI = 80  # some 40 kB a picture


class Displayed:
    """An object whose `str` is a headline, or a table below a headline, and that has `plot`."""

    def __repr__(self):
        return f"<{type(self).__name__}: {str(self).splitlines()[0].strip()}>"

    def _repr_html_(self):
        return display(self)


def display(shown, **options):
    """The text of an object, and a small picture from its ``plot(**options)``, as HTML.

    There is no picture if matplotlib is missing, or if there is nothing to draw.
    """
    text = html.escape(str(shown))
    return f'<pre style="overflow-x: auto">{text}</pre>{picture(lambda: shown.plot(**options))}'


def table(title, rows, head=()):
    """Rows of cells under a title, and under a row of names if there are any, as HTML."""
    if not any(row[-1] for row in rows):
        rows = [row[:-1] for row in rows]
        head = head[:-1]
    lines = [_row("td", row) for row in rows]
    if head and lines:
        lines.insert(0, _row("th", head))
    return f"<b>{html.escape(title)}</b><table>{''.join(lines)}</table>"


def _row(kind, cells):
    style = ' style="text-align: left"'
    made = (f"<{kind}{style}>{html.escape(str(cell))}</{kind}>" for cell in cells)
    return f"<tr>{''.join(made)}</tr>"


def picture(draw, width=36):
    """A picture of the figure of ``draw()``, `width` letters wide, as HTML; "" without one."""
    try:
        pyplot = needed("matplotlib.pyplot")
        figure = draw()
    except (ModuleNotFoundError, ValueError):
        return ""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=DPI)
    pyplot.close(figure)
    data = base64.b64encode(image.getvalue()).decode()
    return f'<img style="width: {width}em; max-width: 100%" src="data:image/png;base64,{data}">'
