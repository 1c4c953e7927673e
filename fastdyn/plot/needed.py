"""matplotlib and tqdm: only figures and progress bars need them, a solve does not."""

import importlib
from typing import Any


def needed(name, purpose="Figures need") -> Any:
    """
    A module of a library that only `purpose` takes, imported when asked for.

    Raises
    ------
    ModuleNotFoundError
        Without the library, with a sentence that says how to install it.
    """
    library = name.partition(".")[0]
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != library:
            raise  # the library is there, and lacks something itself
        sentence = f"{purpose} {library}: python -m pip install {library}"
        raise ModuleNotFoundError(sentence, name=library) from None
