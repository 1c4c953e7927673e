"""matplotlib and tqdm: only figures and progress bars need them, a solve does not."""

import contextlib
import importlib
from typing import Any


def needed(name, purpose="Figures need") -> Any:
    """
    Import a module of an optional library, for `purpose`.

    Raises
    ------
    ModuleNotFoundError
        If the library is missing, with a sentence about its installation.
    """
    library = name.partition(".")[0]
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != library:
            raise  # the library is installed, but one of its own imports fails
        sentence = f"{purpose} {library}: python -m pip install {library}"
        raise ModuleNotFoundError(sentence, name=library) from None


def progress_bar(wanted, **options) -> Any:
    """A context with a bar of tqdm, which closes at the end; with None if it is not `wanted`."""
    if not wanted:
        return contextlib.nullcontext()
    return needed("tqdm.auto", "Progress bars need").tqdm(**options)
