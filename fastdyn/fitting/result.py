"""Fit: the parameters that were found, how well, and what follows from them."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincc, ndtri, stdtrit  # SciPy's `stats` takes a second to import

from . import profile
from .descent import scaled
from .model import name_of
from .motion import Failed, Motion

UNSEEN = 1e-4  # a direction that the data do not determine involves parameters with this share
CURVED = 1.5  # ratio of the true rise of the sum of squares to the linearised, or its inverse
TIGHTER = 100.0  # by which tolerances are divided to find the error of the solves
LEAST_RTOL = 3e-14
CHANGED = 1e-3  # relative change of the sum of squares that no rounding makes
BETTER = 0.1  # a fall of the sum of squares that is another optimum, not rounding
UNLIKELY = 1e-4  # p-value below which the values do not look like the model with its noise
SHOWN = 6  # digits of a value
AT_BOUND = 1e-3  # distance from a bound, in standard errors and in sizes of start and bounds
ROUGH = 0.1  # standard deviations: an error of the solver above is reported


class Prediction(NamedTuple):
    """Fitted values, and the half width of their confidence band, of one shape (n, n_times)."""

    y: np.ndarray
    band: np.ndarray


class Fit:
    """
    Fitted parameters.

    ``str(fit)`` is a table of them.

    Attributes
    ----------
    names : list of str
        The parameters; an array has a name for each of its numbers.
    x : ndarray, shape (n_parameters,)
        The fitted values, in the order of `names`.
    errors : ndarray, shape (n_parameters,)
        Standard errors; infinite where the data do not determine a parameter.
    covariance : ndarray, shape (n_parameters, n_parameters)
        Of the linearised model, without the directions that the data do not determine.
    chi2 : float
        The sum of the squares of the residuals over their standard deviations, deviances of counts,
        and priors.
    dof : int
        Values and priors less parameters.
    noise : dict
        Estimated standard deviation of each observed quantity whose noise is unknown.
    unseen : list of dict
        Directions that the data do not determine: the sum of squares does not change if the
        parameters move together in these proportions.
    success, message, n_trials
        Whether and how the search ended, and how often the records were solved.
    """

    def __init__(self, model, found, level):
        self._model, self.level = model, level
        self.success, self.message = found.success, found.message
        r = self._residuals = found.residuals
        self.names, self.x, self.chi2 = list(model.parameters.names), r.x, r.chi2
        self.dof = len(r.r) - len(self.x)
        self.n_trials = model.n_trials
        self.noise = {name_of(group): float(v) for group, v in model.deviations().items()}
        self._linearise(r.information)

    def _linearise(self, information):
        """Covariance, errors, and the directions that are not determined."""
        own, lengths = scaled(information)
        _, s, v = np.linalg.svd(np.linalg.qr(own, mode="r"))  # v is square
        s = np.r_[s, np.zeros(len(v) - len(s))]
        first = self._model.motions[0]
        seen = s > max(first.accuracy, np.finfo(float).eps * max(own.shape)) * s[0]
        self._steps = v[seen] / s[seen, None] / lengths
        self.covariance = self._steps.T @ self._steps
        self.errors = np.sqrt(np.diag(self.covariance))
        blind = v[~seen]
        self.errors[(np.abs(blind) > UNSEEN).any(axis=0)] = np.inf
        directions = blind / lengths
        self._blind = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self.unseen = [
            {n: float(c) for n, c, share in zip(self.names, row, shares, strict=True)
             if abs(share) > UNSEEN}
            for row, shares in zip(self._blind, blind, strict=True)
        ]  # fmt: skip

    @property
    def quantile(self):
        """Of the normal distribution, or of Student's where the noise is estimated."""
        p = 0.5 + self.level / 2
        return float(stdtrit(self.dof, p) if self._model.groups else ndtri(p))

    @property
    def values(self):
        """The fitted values by name."""
        return dict(zip(self.names, self.x.tolist(), strict=True))

    @property
    def correlations(self):
        """The correlations of the parameters; nan where an error is infinite or zero."""
        errors = np.where(np.isfinite(self.errors) & (self.errors > 0), self.errors, np.nan)
        return self.covariance / np.outer(errors, errors)

    @property
    def p_value(self):
        """How often noise alone gives a larger sum of squares; None where noise is estimated."""
        if self._model.groups or self.dof < 1:
            return None
        return float(gammaincc(self.dof / 2, self.chi2 / 2))

    @functools.cached_property
    def departure(self):
        """How far the sum of squares is from the parabola of the linearised model.

        The largest ratio of its rise to that of the parabola, or the inverse, at the ends of the
        linearised intervals: some solves, when it is first asked for. None if the search did not
        end at an optimum.
        """
        if not self.success:
            return None
        self._unchanged()
        known = np.isfinite(self.errors) & (self.errors > 0)
        steps = self.covariance[known] / self.errors[known, None]
        return profile.departure(self._model, self.x, steps, self.quantile)

    @property
    def curved(self):
        """Whether linearised intervals do not hold: `departure` is above 1.5."""
        return self.departure is not None and self.departure > CURVED

    @functools.cached_property
    def solver_error(self):
        """The largest error of the solves, in standard deviations of the values.

        From solves with tolerances a hundred times tighter; None for constant steps.
        """
        self._unchanged()
        found, residuals = 0.0, self.residuals
        for k, record in enumerate(self._model.records):
            exact = self._model.motions[k].tighter(TIGHTER, LEAST_RTOL)
            if exact is None:
                return None
            try:
                y = exact.states(self.x, record.times)
            except Failed:
                return np.inf
            values = record.observation.values(record.times, y, self.args(k))
            change = np.abs(record.residuals(values)[0] - residuals[k][record.there])
            found = max(found, float(change.max(initial=0.0)))
        return found

    def _unchanged(self):
        """Refuse to go on if the function has other values than in the fit."""
        now = self._model.residuals_anew(self.x).chi2
        if not abs(now - self.chi2) <= CHANGED * max(1.0, self.chi2):
            raise ValueError(
                f"The sum of squares was {self.chi2:.6g} in the fit and is {now:.6g} now: what the "
                "function reads from outside, or an array of its arguments, has changed."
            )

    @functools.cached_property
    def intervals(self):
        """Confidence intervals (low, high), shape (n_parameters, 2).

        The values plus and minus errors, within the bounds; by `profile` where the sum of squares
        is `curved`, which takes some hundred solves when they are first asked for. If the search
        did not end at an optimum, they mean little.
        """
        if self.curved:
            return np.array([self.profile(name) for name in self.names])
        p, half = self._model.parameters, self.quantile * self.errors
        ends = np.stack([self.x - half, self.x + half], axis=1)
        return np.clip(ends, p.low[:, None], p.high[:, None])

    def profile(self, name):
        """The interval of a parameter by profile likelihood.

        The other parameters are fitted anew at each trial value. The interval is right also where
        the sum of squares is no parabola. Estimated noise is kept.

        Parameters
        ----------
        name : str

        Returns
        -------
        low, high : float
            A bound of the parameter, or infinity, where no value is excluded.

        Raises
        ------
        ValueError
            For an unknown name.
        """
        i = self._index(name)
        self._unchanged()
        rise = self.quantile**2
        return profile.interval(self._model, self.x, i, self.errors[i], self.chi2, rise)

    def _index(self, name):
        if name not in self.names:
            raise ValueError(f"There is no parameter {name!r}; choose from {self.names}.")
        return self.names.index(name)

    def y0(self, record=0):
        """The initial state of a record with the fitted values."""
        return self._motion(record).places.at(self.x)[0]

    def args(self, record=0):
        """The arguments of a record with the fitted values."""
        return self._motion(record).places.at(self.x)[1]

    def _motion(self, record) -> Motion:
        n = len(self._model.motions)
        if isinstance(record, bool) or not isinstance(record, int | np.integer):
            raise TypeError(f"`record` must be a number; got {record!r}.")
        if not -n <= record < n:
            raise ValueError(f"`record` must be below {n}, the number of records; got {record}.")
        return self._model.motions[record]

    def predict(self, times, record=0, observed=False):
        """The fitted motion of a record, with a confidence band.

        Parameters
        ----------
        times : array_like, shape (n_times,)
            Increasing, not before `t0` of the record.
        record : int
        observed : bool
            Predict what was observed instead of the state.

        Returns
        -------
        Prediction
            ``y`` and ``band``, of shape (n, n_times). The band is that of the linearised model; it
            is infinite where the prediction depends on what the data do not determine. It is for
            the motion: a new measurement has its own noise, too.

        Raises
        ------
        ValueError
            For times that do not increase, and if the solve fails.
        """
        motion = self._motion(record)
        t = np.atleast_1d(np.asarray(times, float))
        if t.ndim != 1 or not t.size or not np.isfinite(t).all() or (np.diff(t) <= 0).any():
            raise ValueError("`times` must be finite and increase.")
        if t[0] < motion.t0 or t[-1] == motion.t0:
            raise ValueError(f"`times` must not be before t0 = {motion.t0:g}, and end after.")
        try:
            y, slopes = motion.slopes(self.x, t)
        except Failed as reason:
            raise ValueError(f"The motion cannot be predicted: {reason}") from reason
        if observed:
            own = self._model.records[record].observation
            y, slopes = own.slopes(t, y, slopes, motion.places, self.x)
        along = np.einsum("kp,ipt->kit", self._steps, slopes)
        band = self.quantile * np.sqrt((along**2).sum(axis=0))
        size = np.abs(slopes).max(axis=1) * motion.accuracy
        blind = np.abs(np.einsum("kp,ipt->kit", self._blind, slopes)) > size
        return Prediction(y, np.where(blind.any(axis=0), np.inf, band))

    @property
    def residuals(self):
        """The residuals of each record, in standard deviations, of the shape of its `values`."""
        found, begin = [], 0
        for record in self._model.records:
            own = np.full(record.values.shape, np.nan)
            end = begin + int(record.there.sum())
            own[record.there] = self._residuals.r[begin:end]
            begin = end
            found.append(own)
        return found

    def plot(self, record=0, **options):
        """Draw values and fitted motion with its band, and the residuals below.

        Parameters
        ----------
        record : int
        **options
            Options of ``matplotlib.pyplot.figure``, or `ax`: see `fastdyn.plot.plot`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from fastdyn.plot.fit import fitted

        motion, own = self._motion(record), self._model.records[record]
        t = np.linspace(motion.t0, own.times[-1], 400)
        given = own.t, own.values, self.residuals[record]
        return fitted(t, self.predict(t, record, observed=True), *given, self.level, **options)

    def __repr__(self):
        return table(self)


def table(fit):
    """A Fit as a table of its parameters, with what the reader must know."""
    n_values, n_records = fit._model.n_values, len(fit._model.records)
    p = "" if fit.p_value is None else f", p = {fit.p_value:.2g}"
    head = (
        f"{len(fit.names)} parameters from {n_values} values of {n_records} "
        f"record{'s' * (n_records > 1)}, chi2 = {fit.chi2:.4g} for {fit.dof} degrees of freedom{p}"
    )
    width = max(9, *map(len, fit.names))
    kind = "profile" if fit.curved else "interval"
    rows = [f"{'':{width}}  {'value':>12}  {'error':>9}  {fit.level:.0%} {kind}"]
    for name, value, error, (low, high) in zip(
        fit.names, fit.x, fit.errors, fit.intervals, strict=True
    ):
        shown, *ends = (digits(each, error) for each in (value, low, high))
        rows.append(f"{name:{width}}  {shown:>12}  {error:9.2g}  {' to '.join(ends)}")
    return "\n".join([head, *rows, *_remarks(fit)])


def digits(value, error):
    """A value with the digits that its error leaves, at least SHOWN; all of an exact value."""
    if not (np.isfinite(value) and np.isfinite(error) and error > 0 and value):
        return f"{value:.{SHOWN}g}"
    known = int(np.floor(np.log10(abs(value)))) - int(np.floor(np.log10(error))) + 2
    return f"{value:.{min(max(known, SHOWN), 17)}g}"


def _remarks(fit):
    found = [f"estimated noise of {name}: {value:.3g}" for name, value in fit.noise.items()]
    found += [
        "not determined by the data: " + ", ".join(f"{n} {c:+.3g}" for n, c in row.items())
        for row in fit.unseen
    ]
    if fit.curved:
        found.append(
            f"The sum of squares is far from a parabola (a factor of {fit.departure:.2g}): the "
            "errors do not hold, the intervals are by profile likelihood."
        )
    at = [name for name, low, high in zip(fit.names, *_at_bounds(fit), strict=True) if low or high]
    if at:
        found.append(f"At a bound: {', '.join(at)}.")
    if fit.solver_error is not None and fit.solver_error > ROUGH:
        found.append(
            f"Solves are in error by {fit.solver_error:.2g} standard deviations of a value: give "
            "smaller `rtol` and `atol`."
        )
    if fit.success and fit.p_value is not None and fit.p_value < UNLIKELY:
        found.append(
            "Noise alone hardly ever makes so large a sum of squares: a better optimum (`starts`), "
            "more noise, or other equations would be likelier."
        )
    best = fit._model.best
    if best.chi2 < fit.chi2 - BETTER:
        at = ", ".join(f"{n} = {v:.6g}" for n, v in zip(fit.names, best.x, strict=True))
        found.append(
            f"A profile met a smaller sum of squares, {best.chi2:.4g} at {at}: start there."
        )
    if not fit.success:
        found.append(f"{fit.message} Errors and intervals are for an optimum.")
    return found


def _at_bounds(fit):
    """Whether each value is at its lower, its upper bound."""
    p = fit._model.parameters
    bounds = [np.where(np.isfinite(each), np.abs(each), 0.0) for each in (p.low, p.high)]
    near = AT_BOUND * np.minimum(fit.errors, np.maximum(np.abs(p.start), np.maximum(*bounds)))
    return fit.x - p.low <= near, p.high - fit.x <= near
