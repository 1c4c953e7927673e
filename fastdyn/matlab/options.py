"""odeset and odeget: the options of MATLAB's solvers, by MATLAB's names.

Names and meanings: MathWorks, reference page of odeset.
"""

import contextlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from fastdyn.problem.options.table import OPTIONS
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong, takes
from fastdyn.words.near import did_you_mean

OTHERS = (  # that are no options of fastdyn's solvers
    "BDF", "Events", "InitialSlope", "InitialY", "JConstant", "Jumps", "MassSingular", "MaxOrder",
    "MStateDependence", "MvPattern", "NormControl", "OutputFcn", "OutputSel", "Refine", "Stats",
    "Vectorized",
)  # fmt: skip
OF_SOLVERS = [option.matlab for option in OPTIONS.values() if option.matlab]
NAMES = (*sorted([*OTHERS, *OF_SOLVERS], key=str.lower),)
OF_EACH = ("rtol", "atol", "max_step", "first_step")  # that each solver of fastdyn takes
POSITIVE = ("InitialStep", "MaxStep", "MinStep", "Refine", "RelTol")
SWITCHES = ("BDF", "JConstant", "NormControl", "Stats", "Vectorized")
# The forms of functions; those of `dde23` are first.
FUNCTIONS = {"Events": ("t, y, Z", "t, y"), "OutputFcn": ("t, y, flag",)}


class Options(dict):
    """The options that are set, by MATLAB's names; also as attributes, ``options.RelTol``.

    An option that is not set is None.  Without options, the text lists all.
    """

    def __repr__(self):
        if not self:
            return f"odeset(), no option is set. There are: {', '.join(NAMES)}."
        return f"odeset({', '.join(f'{name}={value!r}' for name, value in self.items())})"

    def __getattr__(self, name):
        try:
            return self.get(full_name(name))
        except ValueError as error:
            raise AttributeError(str(error)) from None

    def __setattr__(self, name, value):
        _update(self, [(name, value)])


def chosen(options) -> dict[str, Any]:
    """The options that each solver takes, by fastdyn's names, as far as they are set."""
    names = {name: OPTIONS[name].matlab for name in OF_EACH}
    return {name: options[matlabs] for name, matlabs in names.items() if matlabs in options}


def odeset(*given, **named) -> Options:
    """
    Options of `ode45` and the other solvers, as MATLAB's odeset makes them.

    Parameters
    ----------
    *given
        Alternating names and values, ``odeset('RelTol', 1e-5, 'MaxStep', 0.1)``. One or more
        earlier Options may come first; later values replace earlier values. A name may be
        abbreviated if the abbreviation is unique, in upper or lower case. None or an empty list
        resets an option.
    **named
        Options as keywords.

    Returns
    -------
    Options
        A dict, with the names in full.

    Raises
    ------
    ValueError, TypeError
        For unknown or ambiguous names, names without a value, and values that make no sense.
    """
    options = Options()
    words = list(given)
    while words and not isinstance(words[0], str):
        older = words.pop(0)
        if not isinstance(older, Mapping):
            raise TypeError(f"odeset takes names and values, or older options; got {older!r}.")
        _update(options, older.items())
    if len(words) % 2:
        raise ValueError(f"odeset takes names and values in turns; {words[-1]!r} has no partner.")
    _update(options, zip(words[::2], words[1::2], strict=True))
    _update(options, named.items())
    return options


@shown_when_wrong(name=kinds.text)
def odeget(options, name, default=None) -> Any:
    """The value of an option, as MATLAB's odeget.

    Parameters
    ----------
    options : Options or dict
    name : str
        A name as in `odeset`.
    default : optional
        The result if the option is not set.

    Raises
    ------
    ValueError
        For an unknown or ambiguous name.
    """
    check_options(options)
    return odeset(options or {}).get(full_name(name), default)


def check_options(options):
    """Refuse what cannot be options: neither a dict nor empty."""
    if options is not None and not isinstance(options, Mapping) and np.size(options):
        kinds.refuse("options", "what `odeset(...)` returns, or a dict", options)


def full_name(name):
    """The name of an option that `name` stands for."""
    if not isinstance(name, str):
        raise TypeError(f"the name of an option is a string; got {name!r}.")
    lower = name.strip().lower()
    known = {one.lower(): one for one in NAMES}
    if lower in known:
        return known[lower]
    begin = [one for key, one in known.items() if lower and key.startswith(lower)]
    if len(begin) == 1:
        return begin[0]
    if begin:
        raise ValueError(f"the option '{name}' is ambiguous: {', '.join(begin)} begin so.")
    advice = did_you_mean(name, NAMES, form="{}", alike=0.5)
    advice = advice or f"choose from {', '.join(NAMES)}."
    raise ValueError(f"there is no option '{name}'; {advice}")


def _update(options, pairs):
    for name, value in pairs:
        name = full_name(name)
        if value is None or (np.ndim(value) > 0 and np.size(value) == 0):
            options.pop(name, None)
        else:
            options[name] = _checked(name, value)


def _checked(name, value):
    """The value of an option; raises a sentence if the option cannot have this value."""
    if name in POSITIVE:
        number = _numbers(name, value)
        if number.size != 1 or not number > 0:
            raise ValueError(f"{name} must be one positive number; got {value!r}.")
        if name == "Refine" and number != np.rint(number):
            raise ValueError(f"Refine must be a whole number; got {value!r}.")
        return int(number.item()) if name == "Refine" else number.item()
    if name == "AbsTol":
        numbers = _numbers(name, value)
        if not (numbers > 0).all():
            raise ValueError(f"AbsTol must be positive; got {value!r}.")
        return numbers.item() if numbers.size == 1 else numbers.ravel()
    if name in SWITCHES:
        state = {"on": True, "off": False}.get(value.lower(), value) if _is_text(value) else value
        if not isinstance(state, bool):
            raise ValueError(f"{name} must be 'on' or 'off'; got {value!r}.")
        return state
    if name in FUNCTIONS:
        if not callable(value):
            raise TypeError(f"{name} must be a function; got {value!r}.")
        _takes_one(name, value, FUNCTIONS[name])
    return value


def _takes_one(name, function, forms):
    """Raise TypeError, about the last form, if a function takes none of the forms."""
    for form in forms[:-1]:
        with contextlib.suppress(TypeError):
            return takes(name, function, form)
    return takes(name, function, forms[-1])


def _is_text(value):
    return isinstance(value, str)


def _numbers(name, value):
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number; got {value!r}.") from None
