"""All records as one problem of least squares: residuals of unit variance, and their slopes."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.ensemble.labels import argument_labels
from fastdyn.words.kinds import refuse

from .descent import scaled
from .free import Parameters
from .motion import Failed, Motion
from .noise import Unknown
from .record import Record

LEAST_NOISE = 1e-12  # of an estimated deviation, relative to the largest value


class Residuals(NamedTuple):
    """Residuals at parameters x, their Jacobian, and rows whose square is Fisher's information."""

    x: np.ndarray
    r: np.ndarray
    jac: np.ndarray
    information: np.ndarray

    @property
    def chi2(self):
        """The sum of the squares: the deviance, with priors."""
        return float(self.r @ self.r)


class Model:
    """The records, their motions and noises.

    Attributes
    ----------
    parameters : free.Parameters
    motions : list of motion.Motion
    n_trials : int
        Evaluations of residuals so far, one solve of each record.
    best, before : Residuals or None
        The best trial with the present noise, and the end of the last search.
    n_failed, failure : int, str
        Trials whose motion failed, and the message of the last.
    """

    def __init__(self, fun, records, options, differences):
        self.fun, self.records, self.parameters = fun, records, Parameters()
        self.differences = differences
        many = len(records) > 1
        placed = []
        for k, record in enumerate(records):
            labels = ["y0", *(label.name for label in argument_labels(fun, record.args, None))]
            mark = f" of record {k}" if many else ""
            placed.append(self.parameters.places(record.y0, record.args, labels, mark))
        self.parameters.close()
        self.motions = [
            Motion(fun, places, self.parameters, record.t0, options, differences)
            for record, places in zip(records, placed, strict=True)
        ]
        self.priors = np.flatnonzero(np.isfinite(self.parameters.deviation))
        self.groups = self._groups()
        self._start_noise()
        self.best: Any = None
        self.before: Any = None
        self._last: Any = None
        self.n_trials, self.n_failed, self.failure = 0, 0, ""
        self.watch: Any = None  # called after each trial

    @property
    def n_values(self):
        """The number of values of all records."""
        return sum(int(record.there.sum()) for record in self.records)

    @property
    def one_noise(self):
        """Whether all residuals share one unknown deviation, which no parameter depends on."""
        rows = [rows for _, rows, _ in self.groups.values()]
        return len(rows) == 1 and len(rows[0]) == self.n_values and not len(self.priors)

    def _groups(self):
        """The rows of the residuals of each group of unknown noise, and its Unknowns."""
        found: dict = {}
        begin = 0
        for record in self.records:
            for noise, data in zip(record.noise, record.data, strict=True):
                rows = np.arange(begin, begin + len(data))
                begin += len(data)
                if isinstance(noise, Unknown):
                    found.setdefault(noise.group, []).append((noise, rows, data))
        return {
            group: ([n for n, *_ in each], np.concatenate([rows for _, rows, _ in each]),
                    np.concatenate([data for *_, data in each]))
            for group, each in found.items()
        }  # fmt: skip

    def _start_noise(self):
        for noises, _, data in self.groups.values():
            spread = float(np.std(data)) if len(data) else 0.0
            for noise in noises:
                noise.deviation = spread or float(np.abs(data).max(initial=0.0)) or 1.0

    def take_noise(self, found):
        """Estimate unknown noise from Residuals; the largest relative change.

        The sum of the squares of a group is divided by its values less the parameters that it
        determines, the trace of its part of the projection on the columns of the Jacobian.
        """
        u, s, _ = np.linalg.svd(scaled(found.jac)[0], full_matrices=False)
        leverage = (u[:, s > np.finfo(float).eps * max(u.shape) * s[0]] ** 2).sum(axis=1)
        change = 0.0
        for group, (noises, rows, data) in self.groups.items():
            freedom = len(rows) - leverage[rows].sum()
            if freedom < 0.5:
                raise ValueError(
                    f"The noise of {name_of(group)} cannot be estimated from {len(rows)} values "
                    f"beside {len(found.x)} parameters: give `noise`."
                )
            factor = np.sqrt((found.r[rows] ** 2).sum() / freedom)
            old = noises[0].deviation
            new = max(old * factor, LEAST_NOISE * (np.abs(data).max(initial=0.0) or 1.0))
            change = max(change, abs(new / old - 1))
            for noise in noises:
                noise.deviation = new
        self._last = self.best = None
        return change

    def deviations(self):
        """The estimated standard deviations of unknown noise, by group."""
        return {group: noises[0].deviation for group, (noises, *_) in self.groups.items()}

    def residuals(self, x):
        """The Residuals at x.

        Raises
        ------
        Failed
            If a motion fails, or a number is not finite.
        """
        if self._last is not None and np.array_equal(self._last.x, x):
            return self._last
        self.n_trials += 1
        self._last = found = self.residuals_anew(x)
        if self.best is None or found.chi2 < self.best.chi2:
            self.best = found
        if self.watch is not None:
            self.watch()
        return found

    def residuals_anew(self, x):
        """The Residuals at x, computed in any case."""
        parts = []
        for record, motion in zip(self.records, self.motions, strict=True):
            parts.append(self._of_record(record, motion, x))
        if len(self.priors):
            p, rows = self.parameters, np.zeros((len(self.priors), len(x)))
            rows[np.arange(len(rows)), self.priors] = 1.0 / p.deviation[self.priors]
            parts.append((((x - p.mean) / p.deviation)[self.priors], rows, rows))
        found = Residuals(x.copy(), *(np.concatenate(each) for each in zip(*parts, strict=True)))
        if not (np.isfinite(found.r).all() and np.isfinite(found.jac).all()):
            raise Failed("what is observed, or its derivative, is not finite")
        return found

    def note_failure(self, reason):
        """Count a trial that has no residuals."""
        self.n_failed, self.failure = self.n_failed + 1, str(reason)

    def _of_record(self, record, motion, x):
        y, slopes = motion.slopes(x, record.times)
        try:
            model, by_x = record.observation.slopes(record.times, y, slopes, motion.places, x)
        except ArithmeticError as error:
            raise Failed(f"{type(error).__name__}: {error}") from error
        r, slope, information = record.residuals(model)
        rows, columns = record.places
        own = by_x[rows, :, columns]
        return r, own * slope[:, None], own * information[:, None]

    def chi2(self, x):
        """The sum of squares at x, without derivatives; inf if a motion fails."""
        of_records = [
            self.trial(record, motion, x)
            for record, motion in zip(self.records, self.motions, strict=True)
        ]
        return sum(of_records) + self.of_priors(x)

    def trial(self, record, motion, x, y=None):
        """The sum of squares of one record at x, with its states y, if they are known, or inf."""
        try:
            states = motion.states(x, record.times) if y is None else y
            found = self._chi2_of(record, states, motion.places.at(x)[1])
        except (Failed, ArithmeticError):
            return np.inf
        return found if np.isfinite(found) else np.inf

    def _chi2_of(self, record, y, args):
        """The sum of squares of one record with states y."""
        r = record.residuals(record.observation.values(record.times, y, args))[0]
        return float(r @ r)

    def of_priors(self, x):
        """The sum of squares of the priors."""
        p = self.parameters
        return float((((x - p.mean) / p.deviation)[self.priors] ** 2).sum())


def name_of(group):
    """A group of noise in words."""
    kind, what = group
    if kind == "y":
        return f"y[{what}]"
    if kind == "row":
        return f"the row {what} of `observed`"
    name = getattr(kind, "__name__", "<")
    return f"{'observed' if name.startswith('<') else name}[{what}]"


def model_of(fun, records, options, differences):
    """The Model of checked arguments of `fit`."""
    if not callable(fun):
        raise TypeError(f"`fun` must be a function of (t, y, *args); got {fun!r}.")
    given = [records] if isinstance(records, Record) else records
    try:
        given = list(given)
    except TypeError:
        given = [None]
    if not given or not all(isinstance(record, Record) for record in given):
        refuse("records", "a Record, or a sequence of Records", records)
    model = Model(fun, given, options, differences)
    n, needed = model.n_values + len(model.priors), len(model.parameters.names)
    if model.groups and n <= needed:
        raise ValueError(
            f"{n} values cannot determine {needed} parameters and the noise: give `noise`, priors, "
            "or more values."
        )
    return model
