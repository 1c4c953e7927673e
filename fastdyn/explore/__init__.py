"""
Systems explored with sliders, on a page in the browser or in a notebook.

`exploration` holds the choices and the results, and needs no browser. Only `page`, `figures` and
`serve` import Panel and Bokeh.
"""

NEEDED = (
    "Sliders are shown by Panel, which is not installed: "
    'python -m pip install "fastdyn[explore]" installs it.'
)


def explore(system):
    """
    A system with sliders, as a Panel object that a notebook shows.

    Parameters
    ----------
    system : System
        The sliders begin at the values of this system.

    Raises
    ------
    ImportError
        If Panel is not installed.
    """
    from .sources import of_system

    return page_of()(of_system(system)).panel()


def page_of():
    """The class of pages; without Panel, an ImportError says what to install."""
    try:
        import panel as _panel  # noqa: F401
    except ImportError:
        raise ImportError(NEEDED) from None
    from .page import Page

    return Page
