"""What an interactive session displays: a line of text; in a notebook a table and a picture."""

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
    return f"<pre>{html.escape(str(shown))}</pre>{_picture(shown, options)}"


def _picture(shown, options):
    try:
        pyplot = needed("matplotlib.pyplot")
        figure = shown.plot(**options)
    except (ModuleNotFoundError, ValueError):
        return ""
    image = io.BytesIO()
    figure.savefig(image, format="png", dpi=DPI)
    pyplot.close(figure)
    data = base64.b64encode(image.getvalue()).decode()
    return f'<img style="width: 36em; max-width: 100%" src="data:image/png;base64,{data}">'
