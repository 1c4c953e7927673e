"""Solves with `discrete`: the problem of the longer state, and the parts of its results."""

import numpy as np

from fastdyn.problem import discrete as of_longer
from fastdyn.problem import validate
from fastdyn.run.dense_output import PiecewisePolynomial
from fastdyn.run.result import OdeResult


class PreparedWithDiscrete:
    """A solver of one problem: ``solver(y0, args, discrete, t_span, t_eval)``, all optional.

    `prepare` with `discrete` makes the solver from the Prepared of the longer state, which begins
    with n components of y; see `fastdyn.solve.prepare.Prepared`.
    """

    def __init__(self, solver, start, n, again):
        self._solver = solver
        self._start = start
        self._n = n
        self._given = again
        self._m = len(start) - n

    def __repr__(self):
        return f"<Prepared with {self._m} discrete: {repr(self._solver).partition(': ')[2]}"

    def _repr_html_(self):
        return self._solver._repr_html_()

    def __reduce__(self):
        """Pickle the arguments of `prepare`: a copy is prepared anew."""
        return self._given

    def __call__(self, y0=None, args=None, discrete=None, t_span=None, t_eval=None):
        """Solve from `y0` and `discrete` with `args`; the defaults are those of `prepare`.

        `t_span` and `t_eval` are as of `Prepared`.
        """
        at = args, t_span, t_eval
        if y0 is None and discrete is None:
            return parted(self._solver(None, *at), self._n)
        y = self._start[: self._n]
        d = self._start[self._n :]
        parts = [y if y0 is None else _part("y0", y0, self._n)]
        parts += [d if discrete is None else _part("discrete", discrete, self._m)]
        return parted(self._solver(np.concatenate(parts), *at), self._n)

    def many(self, y0s=None, args=None, discrete=None):
        """Solve from many states, one after the other; see `Prepared.many`.

        Parameters
        ----------
        y0s : array_like, shape (k, n) or (n,)
        discrete : array_like, shape (k, m) or (m,)
            Initial and discrete states, or one state for all solves; by default as in `prepare`.
        args : tuple, optional

        Returns
        -------
        OdeResult
            Also with `discrete`, of shape (k, m), or (k, m, n_times) with `t_eval`.
        """
        n = self._n
        whole = self._start
        y0s = whole[:n] if y0s is None else y0s
        rows = of_longer.joined_rows(y0s, whole[n:] if discrete is None else discrete, n, self._m)
        result = OdeResult(self._solver.many(rows, args))
        result.y, result.discrete = result.y[:, :n], result.y[:, n:]
        return result


def _part(name, given, length):
    """One part of a longer state, checked."""
    part = validate.initial_state(given, name)
    if part.shape != (length,) or part.dtype.kind == "c":
        raise ValueError(f"`{name}` must be {length} real numbers, as when it was prepared.")
    return part


def with_discrete_phases(phases, asked):
    """The phases and the Arguments of the longer state, and the length n of its first part."""
    y0 = asked.y0
    d0 = of_longer.discrete_states(asked.discrete, y0, asked.options)
    n = len(y0)
    m = len(d0)
    longer = {}
    for name, phase in phases.items():
        options = {"method": asked.method, **asked.options, **phase.options}
        method = of_longer.method_for(options["method"])
        longer[name] = phase._replace(
            fun=of_longer.extended_function(phase.fun, n, m),
            event=of_longer.extended_event(phase.event, n),
            after=_after(name, phase.after, n, m),
            options=of_longer.extended_options(options, method, n, m),
        )
    events = [of_longer.extended_event(each, n) for each in asked.events]
    state = np.concatenate([y0, d0])
    return longer, asked._replace(y0=state, given_y0=state, events=events, discrete=None), n


def _after(name, after, n, m):
    """The function between two phases, for the longer state."""

    def longer(t, z, *args):
        found = after(t, z[:n], z[n:], *args)
        parts = found[1:] if isinstance(found, tuple | list) and len(found) == 3 else ()
        if [np.size(part) for part in parts] != [n, m]:
            raise ValueError(
                f"with `discrete`, `after` of phase '{name}' must return (name, y, d), with {n} "
                f"and {m} numbers; got {found!r}."
            )
        return found[0], np.concatenate([np.ravel(part) for part in parts])

    return longer


def parted(whole, n):
    """The result with the first n components as the state, the others as discrete states."""
    result = OdeResult(whole)
    sol = whole.sol
    at_events = whole.y_events
    reached = len(whole.t) > 0  # without points, fields are lists
    result.y = whole.y[:n] if reached else whole.y
    result.discrete = whole.y[n:] if reached else whole.y
    if sol is not None:
        floors = None if sol.floors is None else sol.floors[:, :n]
        result.sol = PiecewisePolynomial(sol.ts, sol.polynomials[..., :n], sol.spans, floors)
    result.y_events = at_events and [y[:, :n] if y.size else y for y in at_events]
    result.discrete_events = at_events and [y[:, n:] if y.size else y for y in at_events]
    if "sensitivity" in whole:
        result.sensitivity = _of_parts({k: s[:n] for k, s in whole.sensitivity.items()}, n, 1)
    if whole.get("vjp") is not None:
        result["vjp"] = VjpOfParts(whole["vjp"], n, whole.y)
    if "event_sensitivity" in whole:
        result.event_sensitivity = [
            each and type(each)(
                _of_parts(each.t, n, 0), _of_parts({k: s[:n] for k, s in each.y.items()}, n, 1)
            )
            for each in whole.event_sensitivity
        ]  # fmt: skip
    return result


class VjpOfParts:
    """The `vjp` of a solve with discrete states.

    Parameters
    ----------
    vjp : callable
        That of the longer state.
    n : int
        The number of components of y.
    whole : ndarray, shape (n + m, n_points)
        The longer states.
    """

    def __init__(self, vjp, n, whole):
        self._vjp, self._n, self._shape = vjp, n, np.shape(whole)

    def __repr__(self):
        return repr(self._vjp)

    def __call__(self, g=None, t_events=None, y_events=None, discrete=None):
        """As `adjoint.vjp.Vjp`; `discrete` has the derivatives by the field of this name.

        The result has "discrete" beside "y0".
        """
        from .adjoint.events import checked  # imports Numba

        n = self._n
        whole = None
        if len(self._shape) < 2:  # a solve that failed at the start
            return self._vjp(g)
        (size, k) = self._shape
        if g is not None or discrete is not None or (t_events is None and y_events is None):
            whole = np.zeros((size, k))
            if g is not None or discrete is None:
                whole[:n] = checked("g", "y", g, (n, k))
            if discrete is not None:
                whole[n:] = checked("discrete", "discrete", discrete, (size - n, k))
        if isinstance(y_events, list | tuple):
            y_events = [self._longer(i, each) for i, each in enumerate(y_events)]
        return _of_parts(self._vjp(whole, t_events, y_events), n, 0)

    def _longer(self, i, rows):
        """Derivatives by states at an event, followed by zeros for the discrete states."""
        if rows is None:
            return None
        given = np.asarray(rows)
        if given.ndim != 2 or given.shape[1] != self._n:
            raise ValueError(
                f"`y_events[{i}]` has the derivatives by `y_events[{i}]` and so its shape, "
                f"(k, {self._n}) for k occurrences; got {given.shape}."
            )
        return np.hstack([given, np.zeros((len(given), self._shape[0] - self._n))])


def _of_parts(found, n, axis):
    """Derivatives by name, those with respect to the longer initial state in its two parts."""
    if "y0" not in found:
        return found
    y0, discrete = np.split(found["y0"], [n], axis=axis)
    return {**found, "y0": y0, "discrete": discrete}
