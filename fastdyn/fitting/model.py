"""All records as one problem of least squares: residuals of unit variance, and their slopes."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.ensemble.labels import argument_labels
from fastdyn.problem import schedules
from fastdyn.solve.differentiable.trees import apart
from fastdyn.words.kinds import refuse

from .descent import scaled
from .free import Parameters, has_free
from .motion import HISTORY, Failed, FittedMotion
from .noise import LOG_2PI, Poisson, Unknown
from .record import Record
from .robust import MAD

RECORDS = (
    "a Record, or a sequence of Records: fit(fun, Record(t, values, y0, args)), with Free(start) "
    "in place of each number of y0 and args that is sought"
)
LEAST_NOISE = 1e-12  # of an estimated deviation, relative to the largest value


class Residuals(NamedTuple):
    """Residuals at coordinates x, their Jacobian, and rows whose square is Fisher's information.

    `chi2` is the sum of the squares, or of losses: the deviance, with priors.
    """

    x: np.ndarray
    r: np.ndarray
    jac: np.ndarray
    information: np.ndarray
    chi2: float


class Model:
    """The records, their motions and noises.

    Attributes
    ----------
    parameters : free.Parameters
    motions : list of motion.FittedMotion
    n_trials : int
        Evaluations of residuals so far, one solve of each record.
    best, before : Residuals or None
        The best trial with the present noise, and the end of the last search.
    n_failed, failure : int, str
        Trials whose motion failed, and the message of the last.

    Trial values x are coordinates of the search: see `free.Parameters`.
    """

    def __init__(self, fun, records, options, differences, loss=None, system=None):
        self.fun, self.records, self.parameters = fun, records, Parameters()
        self.differences = differences
        self.loss = loss
        self.system = system
        many = len(records) > 1
        placed = []
        for k, record in enumerate(records):
            given = (None, *record.args) if HISTORY in options else record.args  # behind `past`
            labels = [label.name for label in argument_labels(fun, given, system)]
            labels = labels[len(given) - len(record.args) :]
            held = apart(record.args, has_free, labels=labels)
            mark = f" of {name_of_record(record, k)}" if many else ""
            given = record.y0, held, record.t0, ["y0", *held.names], mark, float(record.t.min())
            placed.append(self.parameters.places(*given))
        self.parameters.close()
        self.motions = [
            FittedMotion(places.apart.function(fun), places, self.parameters,
                   _of_leaves(options, places.apart), differences)
            for places in placed
        ]  # fmt: skip
        self.observations = [
            record.observation.of(places.apart)
            for record, places in zip(records, placed, strict=True)
        ]
        self.priors = np.flatnonzero(np.isfinite(self.parameters.deviation))
        self.groups = self._groups()
        self._start_noise()
        self.best: Any = None
        self.before: Any = None
        self._last: Any = None
        self.n_trials = 0
        self.n_failed = 0
        self.failure = ""
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
        own = {group: f"{name_of(group)}{self._mark(group)}" for group in found}
        self.names_of_noise = own
        return {
            group: ([n for n, *_ in each], np.concatenate([rows for _, rows, _ in each]),
                    np.concatenate([data for *_, data in each]))
            for group, each in found.items()
        }  # fmt: skip

    def _mark(self, group):
        """The words for a group of noise of one record."""
        at = [k for k, record in enumerate(self.records) if record is group[-1]]
        return f" of {name_of_record(self.records[at[0]], at[0])}" if at else ""

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
                    f"The noise of {self.names_of_noise[group]} cannot be estimated from "
                    f"{len(rows)} values beside {len(found.x)} parameters: give `noise`."
                )
            if self.loss is None:
                factor = np.sqrt((found.r[rows] ** 2).sum() / freedom)
            else:  # outliers do not count
                factor = np.median(np.abs(found.r[rows])) / MAD * np.sqrt(len(rows) / freedom)
            old = noises[0].deviation
            new = max(old * factor, LEAST_NOISE * (np.abs(data).max(initial=0.0) or 1.0))
            change = max(change, abs(new / old - 1))
            for noise in noises:
                noise.deviation = new
        self._last = self.best = None
        return change

    def deviations(self):
        """The estimated standard deviations of unknown noise, by group."""
        return {
            self.names_of_noise[group]: float(noises[0].deviation)
            for group, (noises, *_) in self.groups.items()
        }

    def log_likelihood(self, r):
        """The logarithm of the likelihood with residuals r, largest over unknown noise."""
        total = 0.0
        begin = 0
        for record in self.records:
            for noise, data in zip(record.noise, record.data, strict=True):
                if not isinstance(noise, Unknown):
                    total += noise.log_likelihood(r[begin : begin + len(data)], data)
                begin += len(data)
        for noises, rows, _ in self.groups.values():
            variance = noises[0].deviation ** 2 * (r[rows] ** 2).mean()
            total -= 0.5 * len(rows) * (LOG_2PI + np.log(variance) + 1.0)
        return float(total)

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
        p = self.parameters
        parts = []
        at = p.values(x)
        slopes = p.slopes(at)
        for k in range(len(self.records)):
            parts.append(self._of_record(k, at))
        if len(self.priors):
            rows = np.zeros((len(self.priors), len(x)))
            rows[np.arange(len(rows)), self.priors] = 1.0 / p.deviation[self.priors]
            parts.append((((at - p.mean) / p.deviation)[self.priors], rows, rows))
        r, jac, information = (np.concatenate(each) for each in zip(*parts, strict=True))
        found = Residuals(x.copy(), r, jac * slopes, information * slopes, self.total(r))
        if not (np.isfinite(found.r).all() and np.isfinite(found.jac).all()):
            raise Failed("what is observed, or its derivative, is not finite")
        return found

    def total(self, r):
        """The sum of the squares, or of the losses, of residuals."""
        return float(r @ r) if self.loss is None else self.loss.total(r)

    def note_failure(self, reason):
        """Count a trial that has no residuals."""
        self.n_failed, self.failure = self.n_failed + 1, str(reason)

    def _of_record(self, k, x):
        record = self.records[k]
        motion = self.motions[k]
        y, slopes = motion.slopes(x, record.times)
        try:
            model, by_x = self.observations[k].slopes(record.times, y, slopes, motion.places, x)
        except ArithmeticError as error:
            raise Failed(f"{type(error).__name__}: {error}") from error
        r, slope, information = record.residuals(model)
        rows, columns = record.places
        own = by_x[rows, :, columns]
        return r, own * slope[:, None], own * information[:, None]

    def chi2(self, x):
        """The sum of squares at x, without derivatives; inf if a motion fails."""
        of_records = [self.trial(k, x) for k in range(len(self.records))]
        return sum(of_records) + self.of_priors(x)

    def trial(self, k, x, y=None):
        """The sum of squares of record k at x, with its states y, if they are known, or inf."""
        record = self.records[k]
        motion = self.motions[k]
        at = self.parameters.values(x)
        try:
            states = motion.states(at, record.times) if y is None else y
            model = self.observations[k].values(record.times, states, motion.places.at(at)[1])
            found = self.total(record.residuals(model)[0])
        except (Failed, ArithmeticError):
            return np.inf
        return found if np.isfinite(found) else np.inf

    def of_priors(self, x):
        """The sum of squares of the priors."""
        p = self.parameters
        at = self.parameters.values(x)
        return float((((at - p.mean) / p.deviation)[self.priors] ** 2).sum())


def name_of(group):
    """A group of noise in words."""
    kind, what, *_ = group
    if kind == "y":
        return f"y[{what}]"
    if kind == "row":
        return f"the row {what} of `observed`"
    name = getattr(kind, "__name__", "<")
    return f"{'observed' if name.startswith('<') else name}[{what}]"


def name_of_record(record, k):
    """Record k in words."""
    return record.name or f"record {k}"


def _of_leaves(options, held):
    """Options whose events take the leaves of the arguments."""
    if not any(held.trees):
        return options
    for name, value in options.items():
        if name != "events" and any(map(callable, value if isinstance(value, list) else [value])):
            raise TypeError(
                f"`{name}` is a function, and the arguments of a Record are a dict, a NamedTuple "
                "or a dataclass with Free: give numbers, lists and arrays."
            )
    events = options.get("events")
    if events is None:
        return options
    return {**options, "events": [held.event(event) for event in schedules.listed(events, {})]}


def records_of(records):
    """A list of Records."""
    given = [records] if isinstance(records, Record) else records
    try:
        given = list(given)
    except TypeError:
        given = [None]
    if not given or not all(isinstance(record, Record) for record in given):
        refuse("records", RECORDS, records)
    return given


def model_of(fun, records, options, differences, loss=None):
    """The Model of checked arguments of `fit`."""
    if isinstance(fun, type) and hasattr(fun, "rhs"):
        raise TypeError(f"give a system, {fun.__name__}(), not its class.")
    system = fun if hasattr(fun, "rhs") else None
    if system is None and not callable(fun):
        raise TypeError(f"`fun` must be a function of (t, y, *args), or a system; got {fun!r}.")
    given: Any = records_of(records)
    if system is not None:
        given = [record.of(system) for record in given]
        fun = system.rhs
        if system.breakpoints is not None:
            options = {"breakpoints": system.breakpoints, **options}
    for record in given:
        if record.y0 is None or isinstance(record.args, dict):
            raise TypeError(
                "A Record without `y0`, or with a dict as `args`, is for a system: "
                "`fit(system, record)`. For a function, give `y0`, and `args=({...},)`."
            )
    model = Model(fun, given, options, differences, loss, system)
    if loss is not None and (len(model.priors) or any(_counts(record) for record in given)):
        raise ValueError("`loss` is for normal noise without priors.")
    n = model.n_values + len(model.priors)
    needed = len(model.parameters.names)
    if model.groups and n <= needed:
        raise ValueError(
            f"{n} values cannot determine {needed} parameters and the noise: give `noise`, priors, "
            "or more values."
        )
    return model


def _counts(record):
    return any(isinstance(noise, Poisson) for noise in record.noise)
