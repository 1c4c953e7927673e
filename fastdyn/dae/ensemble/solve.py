"""solve_dae_ensemble: many trajectories of F(t, y, y') = 0."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from fastdyn.compile.bind import or_in_python
from fastdyn.ensemble import reductions
from fastdyn.ensemble.plan import ORDERED, SIMD
from fastdyn.ensemble.reductions import Fold
from fastdyn.ensemble.solve import solved
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.table import ONE_BY_ONE
from fastdyn.problem.schedules import Schedule, listed
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from ..functions import named
from ..index import HighIndexError, not_reduced
from ..problem import check_options
from ..solve import LARGEST
from . import reduced, residuals
from .guesses import first_given, guesses_of

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        State,
        Times,
        TimeSpan,
    )

    from .trajectories import DaeTrajectories

ELSEWHERE = ("client", "store", "block")  # of solve_ensemble


@shown_when_wrong(threads=kinds.number, progress=kinds.flag)
@filled("solve_dae_ensemble")
def solve_dae_ensemble(
    F: Function,
    t_span: TimeSpan,
    y0: State,
    yp0: State | None = None,
    args: Args = (),
    *,
    method: str | None = None,
    t_eval: Times | None = None,
    events: Functions | None = None,
    given: Any = None,
    reduce: str | Fold | Sequence[str | Fold] | None = None,
    threads: int | None = None,
    progress: bool = False,
    simd: bool | Literal["auto"] = "auto",
    **options: Any,
) -> DaeTrajectories:
    """Solve F(t, y, y') = 0 for many starts and parameters at once, with compiled code.

    Parameters
    ----------
    F, t_span, method, t_eval, events, given
        As in `solve_dae`: `given` says what of each start is held.  The index of the first
        trajectory with a start, as far as it is above 1, is that of all.
    y0, yp0 : array_like, shape (M, n) or (n,)
        The states and derivatives at the start, or guesses, as in `solve_dae`; one row a
        trajectory, or one for all.
    args : tuple
        As in `solve_ensemble`: each argument is a number, or a 1-D array of M numbers, one a
        trajectory; an array that all trajectories share is given as ``Shared(array)``.
    reduce : str, Fold or sequence of them, optional
        As in `solve_ensemble`, but for "mean" and "rms"; at a higher index "final" and
        "first_event".
    threads, progress, simd
        As in `solve_ensemble`.  Trajectories of BDF run one by one, those behind an index reduction
        in vectors.
    **options
        {options}, as in `solve_dae`.

    Returns
    -------
    DaeTrajectories
        `Trajectories` with `yp`, `yp_end`, `yp_events` and `index`.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and if no trajectory has a consistent start.

    Notes
    -----
    By BDF, each trajectory has the bits of `solve_dae`; behind an index reduction it equals that
    of `solve_dae` but for rounding.  A trajectory without a consistent start fails alone, and its
    ``message(i)`` is the sentence of `solve_dae`.  Starts are computed in Python, by BDF one by
    one, which takes some 1.5 ms each; the trajectories are solved on all threads.

    Examples
    --------
    >>> def circuit(t, y, yp, R):
    ...     return [R * yp[0] + y[0] - y[1], y[0] + y[1] - math.sin(t)]
    >>> R = np.linspace(0.5, 2.0, 1000)
    >>> result = solve_dae_ensemble(circuit, (0, 10), [0.0, 0.0], args=(R,), rtol=1e-6)
    """
    for name in ELSEWHERE:
        if name in options:
            raise TypeError(
                f"an ensemble of DAEs takes no `{name}`: it runs on the threads of this process."
            )
    check_options(options, "solve_dae_ensemble")
    if simd not in SIMD:
        raise ValueError(f"`simd={simd!r}` is unknown; choose from auto, True, False.")
    if any(isinstance(event, Schedule) for event in listed(events, {}) or ()):
        raise ValueError(f"`solve_dae_ensemble` has no schedules: {ONE_BY_ONE}.")
    guesses = guesses_of(y0, yp0, args)
    asked = first_given(F, t_span, guesses, yp0 is not None, t_eval, events, given, options)
    if asked.t0 == asked.tf:
        raise ValueError("`t_span` must not be empty.")
    wanted = reductions.wanted(reduce, events)
    how = (threads, progress, options)
    if method not in (None, "BDF"):
        return _reduced(asked, guesses, wanted, method, simd, how)
    if simd is True:
        raise ValueError(f"`simd=True`: {residuals.REASON}.")
    wanted = _of_both(wanted, asked.n)
    try:
        return or_in_python(lambda: _solved(residuals.planned(asked, guesses, wanted), how))
    except HighIndexError as found:
        if method is not None or asked.n > LARGEST:
            raise
        reason = found
    try:
        return _reduced(asked, guesses, wanted, "DOP853", simd, how)
    except ValueError as why:
        raise not_reduced(reason, why) from None


def _solved(planned, how):
    ensemble, kind = planned
    threads, progress, options = how
    return solved(ensemble, kind, threads, progress, options=options)


def _reduced(asked, guesses, wanted, method, simd, how):
    """The trajectories of reduced states."""
    for item in wanted:
        if item not in ORDERED:
            raise ValueError(
                f"`reduce={reductions.name_of(item)!r}` is for equations of index 0 and 1; at a "
                'higher index there are "final" and "first_event".'
            )
    done = or_in_python(lambda: _solved(reduced.planned(asked, guesses, wanted, method, simd), how))
    done.settle()
    return done


def _of_both(wanted, n):
    """The reductions of [y, y'], whose Folds are functions of y."""
    for name in reductions.MOMENTS:
        if name in wanted:
            raise ValueError(
                f"`reduce={name!r}` is for `solve_ensemble`: give F a further component with the "
                "equation of its integral, yp[k] - y[i]."
            )
    return tuple([_of_vector(item, n) if isinstance(item, Fold) else item for item in wanted])


def _of_vector(fold, n):
    function = fold.function

    def of_both(value, t, both, *args):
        return function(value, t, both[:n], *args)

    return fold._replace(function=named(of_both, function))
