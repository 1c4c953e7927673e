"""Arguments for compiled methods only: a real state, and a span that is not empty."""

from . import mass, validate


def checked(who, refused, method, t_span, y0, options, otherwise=""):
    """The method, the ends of the span and the initial state, for `prepare` and `Stepper`.

    Parameters
    ----------
    who : str
        The name of the solver; `otherwise` is the alternative.  Both are for messages.
    refused : sequence of str
        Options that the solver does not take.
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
    for name in refused:
        if name in options:
            raise TypeError(f"{who} takes no `{name}`.")
    if ours is None or y0.dtype.kind == "c" or y0.size == 0 or t0 == tf:
        raise ValueError(
            f"{who} takes one of fastdyn's methods, a real state and a span that is not "
            f"empty{otherwise}."
        )
    mass.refuse(options, ours, y0)
    return ours, t0, tf, y0
