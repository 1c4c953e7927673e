"""Fit: the parameters that were found, how well, and what follows from them."""

from __future__ import annotations

import functools
from typing import NamedTuple

import numpy as np
from scipy.special import gammaincc, ndtri, stdtrit  # SciPy's `stats` takes a second to import

from fastdyn.problem.options.docstrings import filled

from . import profile
from .descent import scaled
from .model import name_of_record
from .motion import Failed, FittedMotion
from .table import percent, table

UNSEEN = 1e-4  # a direction that the data do not determine involves parameters with this share
CURVED = 1.5  # ratio of the true rise of the sum of squares to the linearised, or its inverse
TIGHTER = 100.0  # by which tolerances are divided to find the error of the solves
LEAST_RTOL = 3e-14
CHANGED = 1e-3  # relative change of the sum of squares that no rounding makes


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
        self._model = model
        self.level = level
        self.success = found.success
        self.message = found.message
        r = self._residuals = found.residuals
        self.names = list(model.parameters.names)
        self.chi2 = r.chi2
        self._at, self.x = r.x, model.parameters.values(r.x)
        self.dof = len(r.r) - len(self.x)
        self.n_trials = model.n_trials
        self.noise = model.deviations()
        self._linearise(r.information)

    def _linearise(self, information):
        """Covariance, errors, and the directions that are not determined."""
        own, lengths = scaled(information)
        _, s, v = np.linalg.svd(np.linalg.qr(own, mode="r"))  # v is square
        s = np.r_[s, np.zeros(len(v) - len(s))]
        first = self._model.motions[0]
        seen = s > max(first.accuracy, np.finfo(float).eps * max(own.shape)) * s[0]
        self._steps = v[seen] / s[seen, None] / lengths
        if self._model.loss is not None:
            self._steps *= np.sqrt(self._model.loss.variance(self._residuals.r, len(self.x)))
        scale = self._model.parameters.slopes(self.x)
        self._covariance = self._steps.T @ self._steps  # of the coordinates
        self.covariance = self._covariance * np.outer(scale, scale)
        self._errors = np.sqrt(np.diag(self._covariance))
        blind = v[~seen]
        self._errors[(np.abs(blind) > UNSEEN).any(axis=0)] = np.inf
        self.errors = self._errors * scale
        directions = blind / lengths
        self._blind = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        logs = zip(self.names, self._model.parameters.log, strict=True)
        names = [f"ln {name}" if log else name for name, log in logs]
        self.unseen = [
            {n: float(c) for n, c, share in zip(names, row, shares, strict=True)
             if abs(share) > UNSEEN}
            for row, shares in zip(self._blind, blind, strict=True)
        ]  # fmt: skip

    @property
    def quantile(self):
        """Of the normal distribution, or of Student's where the noise is estimated."""
        p = 0.5 + self.level / 2
        estimated = self._model.groups or self._model.loss is not None
        return float(stdtrit(self.dof, p) if estimated else ndtri(p))

    @property
    def log_likelihood(self):
        """The logarithm of the likelihood of the data, largest over unknown noise.

        Without priors; None with `loss`, which is no likelihood.
        """
        model = self._model
        return None if model.loss is not None else model.log_likelihood(self._residuals.r)

    @property
    def n_estimated(self):
        """The number of parameters and of unknown deviations."""
        return len(self.x) + len(self._model.groups)

    @property
    def aic(self):
        """Akaike's criterion, 2 n_estimated - 2 log_likelihood: of two models, the less."""
        return None if self.log_likelihood is None else 2 * (self.n_estimated - self.log_likelihood)

    @property
    def bic(self):
        """The Bayesian criterion of Schwarz, n_estimated ln(n_values) - 2 log_likelihood."""
        if self.log_likelihood is None:
            return None
        return float(self.n_estimated * np.log(self._model.n_values) - 2 * self.log_likelihood)

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
        if self._model.groups or self._model.loss is not None or self.dof < 1:
            return None
        return float(gammaincc(self.dof / 2, self.chi2 / 2))

    @functools.cached_property
    def departure(self):
        """How far the sum of squares is from the parabola of the linearised model.

        The largest ratio of its rise to that of the parabola, or the inverse, at the ends of the
        linearised intervals: some solves, when it is first asked for. None if the search did not
        end at an optimum, and with `loss`.
        """
        if not self.success or self._model.loss is not None:
            return None
        self._unchanged()
        known = np.isfinite(self._errors) & (self._errors > 0)
        steps = self._covariance[known] / self._errors[known, None]
        return profile.departure(self._model, self._at, steps, self.quantile)

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
        found = 0.0
        residuals = self.residuals
        for k, record in enumerate(self._model.records):
            exact = self._model.motions[k].tighter(TIGHTER, LEAST_RTOL)
            if exact is None:
                return None
            try:
                y = exact.states(self.x, record.times)
            except Failed:
                return np.inf
            args = exact.places.at(self.x)[1]
            values = self._model.observations[k].values(record.times, y, args)
            change = np.abs(record.residuals(values)[0] - residuals[k][record.there])
            found = max(found, float(change.max(initial=0.0)))
        return found

    def _unchanged(self):
        """Refuse to go on if the function has other values than in the fit."""
        now = self._model.residuals_anew(self._at).chi2
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
        p = self._model.parameters
        half = self.quantile * self._errors
        ends = [p.values(self._at + sign * half) for sign in (-1.0, 1.0)]
        return np.clip(np.stack(ends, axis=1), p.low[:, None], p.high[:, None])

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
            For an unknown name, and for a fit with `loss`.
        """
        i = self._index(name)
        p = self._model.parameters
        if self._model.loss is not None:
            raise ValueError("A fit with `loss` has no likelihood, and no profile.")
        self._unchanged()
        given = i, self._errors[i], self.chi2, self.quantile**2
        ends = profile.interval(self._model, self._at, *given)
        low, high = (float(p.values(np.where(np.arange(len(p.log)) == i, e, 0.0))[i]) for e in ends)
        return low, high

    def _index(self, name):
        if name not in self.names:
            raise ValueError(f"There is no parameter {name!r}; choose from {self.names}.")
        return self.names.index(name)

    def y0(self, record=0):
        """The initial state of a record with the fitted values."""
        return self._motion(record).places.at(self.x)[0]

    def args(self, record=0):
        """The arguments of a record with the fitted values."""
        places = self._motion(record).places
        return places.apart.whole(places.at(self.x)[1])

    def t0(self, record=0):
        """The time of the initial state of a record, with the fitted values."""
        return float(self._motion(record).places.begin(self.x))

    def _motion(self, record) -> FittedMotion:
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
        t0 = self.t0(record)
        t = np.atleast_1d(np.asarray(times, float))
        if t.ndim != 1 or not t.size or not np.isfinite(t).all() or (np.diff(t) <= 0).any():
            raise ValueError("`times` must be finite and increase.")
        if t[0] < t0 or t[-1] == t0:
            raise ValueError(f"`times` must not be before t0 = {t0:g}, and end after.")
        try:
            y, slopes = motion.slopes(self.x, t)
        except Failed as reason:
            raise ValueError(f"The motion cannot be predicted: {reason}") from reason
        if observed:
            own = self._model.observations[record]
            y, slopes = own.slopes(t, y, slopes, motion.places, self.x)
        slopes = slopes * self._model.parameters.slopes(self.x)[:, None]
        along = np.einsum("kp,ipt->kit", self._steps, slopes)
        band = self.quantile * np.sqrt((along**2).sum(axis=0))
        size = np.abs(slopes).max(axis=1) * motion.accuracy
        blind = np.abs(np.einsum("kp,ipt->kit", self._blind, slopes)) > size
        return Prediction(y, np.where(blind.any(axis=0), np.inf, band))

    @property
    def residuals(self):
        """The residuals of each record, in standard deviations, of the shape of its `values`."""
        found = []
        begin = 0
        for record in self._model.records:
            own = np.full(record.values.shape, np.nan)
            end = begin + int(record.there.sum())
            own[record.there] = self._residuals.r[begin:end]
            begin = end
            found.append(own)
        return found

    @filled()
    def plot(self, record=None, **options):
        """Draw values and fitted motions with their bands, and the residuals below.

        Parameters
        ----------
        record : int, optional
            One record; by default all, each in a colour of its own, those with as many series as
            the first.
        {figure}
        """
        from fastdyn.plot.fit import Drawn, fitted

        records = self._model.records
        residuals = self.residuals
        if record is not None:
            self._motion(record)
        drawn = []
        for k in range(len(records)) if record is None else [record]:
            own = records[k]
            if len(own.values) == len(records[0].values) or record is not None:
                t = np.linspace(self.t0(k), own.times[-1], 400)
                motion = self.predict(t, k, observed=True)
                name = name_of_record(own, k)
                drawn.append(Drawn(name, t, *motion, own.t, own.values, residuals[k]))
        level = f"{percent(self.level)} band of the motion{', linearised' if self.curved else ''}"
        return fitted(drawn, level, **options)

    def __repr__(self):
        return table(self)
