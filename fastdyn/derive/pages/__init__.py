"""
Blackboards: each file derives one system, in the order in which a lecturer would write it.

``page("double_pendulum")`` is the `Model` of one of them; its last lines say what is asked for.
"""

import importlib
import pkgutil

from fastdyn.words.near import did_you_mean

PAGES = tuple(sorted(one.name for one in pkgutil.iter_modules(__path__)))


def page(name):
    """
    The `Model` on a page.

    Raises
    ------
    ValueError
        For a page that there is not.
    """
    if name not in PAGES:
        advice = did_you_mean(name, PAGES, form='"{}"') or f"choose from {', '.join(PAGES)}."
        raise ValueError(f"No page is called {name!r}; {advice}")
    return importlib.import_module(f"{__name__}.{name}").board
