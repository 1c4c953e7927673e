"""Events in MATLAB's form: one function of ``[value, isterminal, direction]``."""

from typing import Any

import numpy as np

CHANGES = (
    "`isterminal` and `direction` of the event function change at t = {:.6g}; here they must be "
    "the same all along. Multiply `value` by what switches it off instead."
)


def event_functions(events, t0, y0):
    """
    One event function for each value, with SciPy's attributes; a further function ends the run when
    `isterminal` or `direction` change.

    Raises
    ------
    TypeError, ValueError
        If the function does not return three objects of equal length.
    """
    found = events(t0, y0.copy())
    if not isinstance(found, tuple | list) or len(found) != 3:
        raise TypeError(
            "the event function must return value, isterminal, direction, each a number or a list "
            f"of equal length; got {found!r}."
        )
    sizes = [np.size(part) for part in found]
    if len(set(sizes)) > 1 or any(np.ndim(part) > 1 for part in found):
        raise ValueError(
            f"value, isterminal and direction of the events must be of one length; got {sizes}."
        )
    terminal, direction = (np.atleast_1d(np.asarray(part, float)) for part in found[1:])
    if not np.isin(terminal, (0, 1)).all() or not np.isin(direction, (-1, 0, 1)).all():
        raise ValueError(
            f"isterminal must be 0 or 1, and direction -1, 0 or 1; got {found[1]!r}, {found[2]!r}."
        )
    listed = [np.ndim(part) > 0 for part in found]
    functions = [_component(events, i, listed[0]) for i in range(sizes[0])]
    for function, ends, sign in zip(functions, terminal, direction, strict=True):
        function.terminal, function.direction = int(ends), float(sign)
    functions.append(_unchanged(events, listed[1:], terminal.tolist(), direction.tolist()))
    return functions


def _component(events, i, listed) -> Any:
    if not listed:

        def value(t, y, *past):
            return events(t, y, *past)[0]

    else:

        def value(t, y, *past):
            return events(t, y, *past)[0][i]

    value.__name__ = f"event {i}"
    return value


def _unchanged(events, listed, terminal, direction) -> Any:
    """A function that is 1, or -1 when `isterminal` or `direction` have changed."""
    many_ends, many_signs = listed

    @_ending
    def unchanged(t, y, *past):
        _, ends, signs = events(t, y, *past)
        for i in range(len(terminal)):
            end = ends[i] if many_ends else ends
            sign = signs[i] if many_signs else signs
            if end != terminal[i] or sign != direction[i]:
                return -1.0
        return 1.0

    return unchanged


def _ending(function) -> Any:
    """A function whose first zero ends the run."""
    function.terminal = 1
    return function


def let_pass(functions, result):
    """Whether to solve again without a terminal event in the first step, which MATLAB ignores.

    Lets these events pass in the next solve.
    """
    if result.status != 1 or result.n_accepted != 1 or len(result.t_events[-1]):
        return False
    for function, times in zip(functions[:-1], result.t_events, strict=False):
        if function.terminal and len(times) >= function.terminal:
            function.terminal = len(times) + 1
    return True


def occurrences(result, events):
    """Times, states (a row each) and indices of the events, in their order in time.

    Raises
    ------
    ValueError
        If `isterminal` or `direction` have changed, or if the event function is zero at both ends
        of a step, which is a crossing by SciPy's rule and none by MATLAB's.
    """
    *found, changed = result.t_events
    if len(changed):
        raise ValueError(CHANGES.format(changed[0]))
    te = np.concatenate(found)
    ie = np.repeat(np.arange(len(found)), [len(times) for times in found])
    full = [states for states in result.y_events[:-1] if len(states)]
    ye = np.concatenate(full) if full else np.empty((0, len(result.y)))
    direction = 1.0 if result.t[-1] >= result.t[0] else -1.0
    order = np.argsort(direction * te, kind="stable")
    te = te[order]
    ye = ye[order]
    ie = ie[order]
    steps = np.searchsorted(direction * result.t, direction * te, side="left")
    for step, i in zip(steps, ie, strict=True):
        ends = [k for k in (step - 1, step) if 0 <= k < len(result.t)]
        values = [np.ravel(events(float(result.t[k]), result.y[:, k].copy())[0])[i] for k in ends]
        if len(ends) == 2 and values == [0.0, 0.0]:
            raise ValueError(
                f"event {i} is exactly zero over the whole step to t = {result.t[step]:.6g}: "
                "when it occurs is not defined. Let it be different from zero elsewhere."
            )
    return te, ye, ie
