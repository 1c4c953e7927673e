"""Numba's settings, without an import of Numba: most processes change no setting."""

import os
import sys

# Settings that code depends on, with Numba's own values, which hold unless the user sets others.
DEFAULTS = {
    "OPT": 3,
    "BOUNDSCHECK": None,
    "DEBUG_TYPEINFER": 0,
    "LOOP_VECTORIZE": 1,
    "SLP_VECTORIZE": 0,
    "CPU_NAME": None,
    "CPU_FEATURES": None,
}
ELSEWHERE = ("NUMBA_CACHE_DIR", "NUMBA_NUM_THREADS", "NUMBA_THREADING_LAYER")  # no effect on code
FILE = ".numba_config.yaml"  # read by Numba where a process starts


def chosen():
    """Numba's configuration if it may differ from the defaults; else None.

    The configuration comes from Numba if Numba is imported already, or if any setting is set.
    """
    found = sys.modules.get("numba.core.config")
    if found is None and any(k.startswith("NUMBA_") and k not in ELSEWHERE for k in os.environ):
        import numba  # waits for an import in another thread; a submodule's does not
        from numba.core import config as found
    if found is None and os.path.isfile(FILE):
        import numba  # noqa: F401  # waits for an import in another thread; a submodule's does not
        from numba.core import config as found
    return found


def setting(name):
    """The value of a setting; None for a setting that is off by default."""
    return getattr(chosen(), name, DEFAULTS.get(name))


def settings():
    """The values of all settings that code depends on, by name."""
    config = chosen()
    return {name: getattr(config, name, value) for name, value in DEFAULTS.items()}


def changed(now=None):
    """(name, value as text) of each setting that the user changed; `now` are the `settings`."""
    found = (now or settings()).items()
    # The text of OPT is a number, or a number in the name of a class of Numba's.
    texts = ((name, str(value), DEFAULTS[name]) for name, value in found)
    return tuple((name, text) for name, text, v in texts if text not in (str(v), f"_OptLevel({v})"))


DISABLED = bool(setting("DISABLE_JIT"))  # the user wants all functions to run in Python
