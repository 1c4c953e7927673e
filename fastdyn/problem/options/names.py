"""Unknown names of options: refused, or warned of, with the name that may be meant."""

import warnings

from fastdyn.compile.sentences import levels_inside

from .near import did_you_mean
from .table import ALL_OPTIONS, OPTIONS

OTHER_WORDS = {  # names in other packages
    "solver": "method", "tspan": "t_span", "x0": "y0", "teval": "t_eval",
    **{word: o.name for o in ALL_OPTIONS for word in (*o.words.split(), o.matlab.lower()) if word},
}  # fmt: skip


def advice(name, known):
    """A question, "did you mean `rtol`?", or nothing."""
    return did_you_mean(name, known, OTHER_WORDS)


def _advice_on(names):
    """Questions for several names, to append to a sentence."""
    found = [(name, advice(name, OPTIONS)) for name in names if name not in OPTIONS]
    return "".join(f" `{name}`: {said}" for name, said in found if said)


def warn_unused(options, method):
    """Warn, as SciPy does, of options that the method does not use."""
    unused = [name for name in options if name not in OPTIONS or not OPTIONS[name].methods(method)]
    if unused:
        unused.sort()
        said = ", ".join(f"`{name}`" for name in unused)
        said = f"The following arguments have no effect for a chosen solver: {said}."
        warnings.warn(said + _advice_on(unused), stacklevel=levels_inside())


def refuse_unknown(who, given, known):
    """Raise TypeError for the first name that is not known."""
    for name in given:
        if name not in known:
            said = advice(name, known)
            raise TypeError(f"{who} takes no `{name}`{f'; {said}' if said else '.'}")
