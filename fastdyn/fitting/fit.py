"""fit: parameters of equations of motion from measured data."""

import numpy as np

from fastdyn.compile.sentences import told_once, warn
from fastdyn.problem.options.docstrings import filled
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .free import has_free
from .model import model_of, records_of
from .motion import options_of
from .result import Fit
from .robust import loss_of
from .search import search
from .starts import starts_of

MAX_NFEV = 200


@filled()
@shown_when_wrong(differences=kinds.flag, progress=kinds.flag)
def fit(
    fun, records, starts=1, max_nfev=MAX_NFEV, level=0.95, differences=False, progress=False,
    loss="linear", f_scale=1.0, **options,
):  # fmt: skip
    """Fit the `Free` numbers of records by maximum likelihood.

    Residuals and their exact derivatives come from one solve of each record;
    `scipy.optimize.least_squares` minimises the sum of the squares.

    Parameters
    ----------
    fun : callable or System
        ``fun(t, y, *args)``, as of `solve_ivp`; or a system, whose start and parameters the records
        take where they give none.
    records : Record or sequence of Record
        Measured data, with `Free` in place of the numbers that are sought. One Free in several
        records is one parameter.
    starts : int or array_like, shape (m, n_parameters)
        Number of starts, or values to start from beside those of the Free. More than one are
        screened by an ensemble of solves; the best four, and the start of the Free, are refined.
        Starts lie within the bounds, evenly in the logarithm where these are positive and far
        apart; without bounds, around the start of the Free.
    max_nfev : int
        Most trials from one start.
    level : float
        Confidence of intervals and bands.
    differences : bool
        Take central differences of solves instead of exact derivatives, for functions that cannot
        be traced or differentiated, or that jump.
    progress : bool
        Show trials and sum of squares on stderr.
    loss : str or callable
        As of `least_squares`: "soft_l1", "huber", "cauchy", "arctan", or a function, so that
        outliers count less. Normal noise that is unknown is then estimated by the median of the
        residuals; errors are those of M-estimates, and there is no likelihood.
    f_scale : float
        The residual, in standard deviations, at which `loss` turns away from the square.
    **options
        Of `solve_ivp`; by default method="Vern9", rtol={rtol of fit}, atol={atol of fit},
        max_steps=100_000.  With history="constant", `fun` is that of a delay equation, ``fun(t, y,
        past, *args)``, and `y0` of a record is the state up to its start; the options are those of
        `solve_dde`.

    Returns
    -------
    Fit
        After Ctrl-C, with the best values so far.

    Raises
    ------
    ValueError
        If the motion fails at all starts, if there is nothing to fit, if `fun` has no derivatives.
    TypeError
        For wrong arguments.

    Examples
    --------
    >>> def decay(t, y, rate):
    ...     return [-rate * y[0]]
    >>> times, amounts = [0.0, 1.0, 2.0, 3.0], [1.02, 0.59, 0.38, 0.21]
    >>> found = fit(decay, Record(times, amounts, [Free(1.0)], (Free(1.0, low=0),), noise=0.02))
    >>> print(found.values["rate"], found.errors)
    """
    records = records_of(records)
    max_nfev = _count(max_nfev)
    level = _level(level)
    options = options_of(options)
    loss = loss_of(loss, f_scale)
    model = model_of(fun, records, options, bool(differences), loss)
    trials = starts_of(starts, model.parameters)
    for record in model.records:
        _tell_start(record)
    with told_once():
        found = search(model, trials, max_nfev, progress)
    return Fit(model, found, level)


def _tell_start(record):
    """Warn of a known state at a first time that is not 0, where nobody said when it was."""
    if record.began or has_free(record.y0) or not record.t0 > 0:
        return
    warn(
        f"`y0` is taken as the state at the first time, t0 = {record.t0:g}. If it is the state at "
        f"t = 0, give `t0=0` to the Record; else `t0={record.t0:g}` says the same without a "
        "warning."
    )


def _count(value):
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < 1:
        raise ValueError(f"`max_nfev` must be a whole number, at least 1; got {value!r}.")
    return int(value)


def _level(value):
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise TypeError(f"`level` must be a number between 0 and 1; got {value!r}.")
    if not 0 < value < 1:
        raise ValueError(f"`level` must be between 0 and 1; got {value!r}.")
    return float(value)
