"""Arguments for compiled methods only: a real state, and a span that is not empty."""

from . import mass, validate
from .options.table import refused_by

NAMES = {"prepare": "a prepared solver", "Stepper": "a Stepper"}  # in messages


def checked(who, method, t_span, y0, options, otherwise=""):
    """The method, the ends of the span and the initial state, for `prepare` and `Stepper`.

    Parameters
    ----------
    who : str
        "prepare" or "Stepper"; `otherwise` is the alternative, for messages.
    method, t_span, y0, options
        As in `solve_ivp`.

    Returns
    -------
    (Facts, float, float, ndarray of shape (n,))

    Raises
    ------
    ValueError, TypeError
    """
    ours, y0 = validate.method_named(method), validate.initial_state(y0)
    t0, tf = validate.time_span(t_span)
    for name in refused_by(who):
        if name in options:
            raise TypeError(f"{NAMES[who]} takes no `{name}`.")
    if ours is None or y0.dtype.kind == "c" or y0.size == 0 or t0 == tf:
        raise ValueError(
            f"{NAMES[who]} takes one of fastdyn's methods, a real state and a span that is not "
            f"empty{otherwise}."
        )
    mass.refuse(options, ours, y0)
    return ours, t0, tf, y0
