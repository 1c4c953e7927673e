"""
Systems explored with sliders, on a page in the browser or in a notebook.

What is chosen, solved and exported is in `exploration`, which needs no browser; only `page` and
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
        Its values are those at which the sliders begin.

    Raises
    ------
    ImportError
        Without Panel.
    """
    from .sources import of_system

    return page_of()(of_system(system)).panel()


def page_of():
    """The class of pages; ImportError that says what to install without Panel."""
    try:
        import panel as _panel  # noqa: F401
    except ImportError:
        raise ImportError(NEEDED) from None
    from .page import Page

    return Page
