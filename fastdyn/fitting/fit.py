"""fit: parameters of equations of motion from measured data."""

import numpy as np

from fastdyn.compile.sentences import told_once
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .model import model_of
from .motion import options_of
from .result import Fit
from .search import search
from .starts import starts_of

MAX_NFEV = 200


@shown_when_wrong(differences=kinds.flag, progress=kinds.flag)
def fit(
    fun, records, starts=1, max_nfev=MAX_NFEV, level=0.95, differences=False, progress=False,
    **options,
):  # fmt: skip
    """Fit the `Free` numbers of records by maximum likelihood.

    Residuals and their exact derivatives come from one solve of each record;
    `scipy.optimize.least_squares` minimises the sum of the squares.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, *args)``, as of `solve_ivp`.
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
    **options
        Of `solve_ivp`; by default method="DOP853", rtol=1e-8, atol=1e-10, max_steps=100_000.

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
    max_nfev, level = _count(max_nfev), _level(level)
    options = options_of(options)
    model = model_of(fun, records, options, bool(differences))
    trials = starts_of(starts, model.parameters)
    with told_once():
        found = search(model, trials, options, max_nfev, progress)
    return Fit(model, found, level)


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
