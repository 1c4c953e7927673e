"""The long-horizon study: the drift of invariants over many steps, in constant memory."""

from __future__ import annotations

import inspect
import math
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fastdyn.compile.bind import bind, or_in_python
from fastdyn.compile.mode import DERIVATIVE, EVENT
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.state.record import FINISHED, RAISED
from fastdyn.planets.run import NAME as WISDOM_HOLMAN
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options.docstrings import filled
from fastdyn.problem.options.names import refuse_unknown
from fastdyn.problem.options.table import OPTIONS, refused_by
from fastdyn.problem.second_order_and_pairs import (
    Pair,
    bind_equations,
    check_pair,
    mode_for,
    pair_of,
    probe_equations,
)
from fastdyn.run.checkpoint import Checkpoint, fingerprint
from fastdyn.run.functions.followed import keep_true
from fastdyn.run.laid_out import raise_kept
from fastdyn.run.loop import announce, time_bar
from fastdyn.words import kinds
from fastdyn.words.calls import shown_when_wrong

from .methods import LOOKS, method_of, study_of
from .rounding import BINS, NO_TOLERANCE, neighbour, of_rounding, steps_compared
from .study import Study
from .survey import Steps, Survey

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Path, State


LENGTHS = ("step", "n_steps", "t_end", "periods", "steps_per_period")  # of a run, by its options


@filled()
@shown_when_wrong(
    "The state of a function is `y0=`, the end `t_end=` and what is followed `invariants=`: "
    "energy_drift(fun, method, y0=y0, t_end=100.0, step=0.1, invariants={'energy': energy}).",
    checkpoint=kinds.path,
    progress=kinds.flag,
    rounding=kinds.flag,
    rtol=kinds.number,
)
def energy_drift(
    system: Any,
    method: str = "Gauss16",
    *,
    step: float | None = None,
    n_steps: float | None = None,
    t_end: float | None = None,
    periods: float | None = None,
    steps_per_period: float | None = None,
    period: float | None = None,
    samples: int = 1000,
    every: int | None = None,
    y0: State | None = None,
    invariants: Mapping[str, Callable[..., Any]] | None = None,
    args: Args | None = None,
    checkpoint: Path | None = None,
    progress: bool = False,
    rounding: bool = True,
    corrector: int | None = None,
    **options: Any,
) -> Study:
    """
    Follow invariants through a long run.

    Parameters
    ----------
    system : System, callable or pair of callables
        A system, whose invariants are followed; or ``fun(t, y, *args)`` with `y0` and
        `invariants`; or ``(velocity, force)`` as in `solve_separable`, with y = [q, p].
    method : str
        Any compiled method; for `Planets`, also "WisdomHolman".
    step, steps_per_period : float, optional
        Size of the constant steps, or the number of steps in a period.  Adaptive methods take
        `rtol` and `atol` instead.
    n_steps, t_end, periods : float, optional
        Length of the run: number of constant steps, time, or periods of the system.
    period : float, optional
        Length of a period; a system knows its period.
    samples : int
        Number of bins of which mean, minimum and maximum are kept.
    every : int, optional
        Number of steps between two evaluations of the invariants: 1, and for WisdomHolman, whose
        outputs take long, so many that there are ten evaluations in a bin.
    y0 : array_like, shape (n,)
        Initial state of a function.
    invariants : dict of str to callable
        Functions ``(t, y, *args)`` that the exact motion keeps constant.
    args : tuple
        Further arguments of the functions.
    checkpoint : str or path, optional
        A file, written every few seconds, from which a stopped run goes on, bit for bit.
    progress : bool
        Show a progress bar.
    rounding : bool
        Estimate how much of the drift is rounding, by two shorter runs from starts that differ in
        the last place: a tenth of the work of a long study.
    corrector : int, optional
        Order of the corrector of WisdomHolman, 17 by default: see `Planets.solve`.
    **options
        `rtol` (default {rtol of energy_drift}), `atol` (default a thousandth of `rtol` times the
        largest component of `y0`), `max_step`, `first_step` of the adaptive methods, `compile`.

    Returns
    -------
    Study

    Raises
    ------
    ValueError, TypeError
        As `solve_ivp`; for a run without length; for a checkpoint of another run.
    OSError
        Before the run, if the checkpoint cannot be written.  A disk that becomes full later gives a
        warning.
    KeyboardInterrupt
        On Ctrl-C, after writing the checkpoint if there is one.

    Notes
    -----
    Changes are relative to the value at the start, or absolute if that value is zero.  Constant
    steps are never shortened: the run ends with the step that reaches its end.
    """
    refuse_unknown("`energy_drift`", options, OPTIONS.keys() | OWN)
    for name in refused_by("energy_drift"):
        if options.get(name) is not None:
            raise TypeError(f"`energy_drift` takes no `{name}`: solve_ivp does.")
    lengths = {
        "step": step, "n_steps": n_steps, "t_end": t_end, "periods": periods, "period": period,
        "steps_per_period": steps_per_period,
    }  # fmt: skip
    for name, value in lengths.items():
        if value is not None:
            kinds.number(name, value)
    if every is not None:
        kinds.whole("every", every)
    kinds.whole("samples", samples)
    kinds.flag("progress", progress)
    kinds.flag("rounding", rounding)
    run = _Run(system, method, y0, invariants, args, period)
    length = run.length(step, n_steps, t_end, periods, steps_per_period)
    if length[0] is not None:
        options["step"] = length[0]
    if (every is not None and every < 1) or samples < 1:
        raise ValueError("`every` and `samples` must be whole numbers of at least 1.")
    if run.method.error_order:
        given = {name: value for name, value in options.items() if value is not None}
        options = tolerances(run.y0, given.get("rtol", OPTIONS["rtol"].of["energy_drift"])) | given
    if corrector is not None:
        if run.method.name != WISDOM_HOLMAN:
            raise TypeError(f"`corrector` is for {WISDOM_HOLMAN}; {run.method.name} has none.")
        options["corrector"] = corrector
    given = (length[1], options, int(samples), every, checkpoint, progress)

    def followed():
        study = run.follow(*given)
        if rounding and not study.message:
            run.estimate_rounding(study, options, every)
        return study

    return or_in_python(followed)


def tolerances(y0, rtol):
    """`rtol` and an `atol` that matters for components far smaller than the largest only."""
    return {"rtol": rtol, "atol": 1e-3 * rtol * (float(np.abs(y0).max(initial=0.0)) or 1.0)}


OWN = {*inspect.signature(energy_drift).parameters} - {"options"}


def length_of(system, method, options):
    """The end of the run that `energy_drift` would make with these options."""
    of_run, of_length = (
        {name: options.get(name) for name in names}
        for names in (("y0", "invariants", "args", "period"), LENGTHS)
    )
    return _Run(system, method, **of_run).length(**of_length)[1]


class _Run:
    """A study before it has a length."""

    def __init__(self, system, method, y0, invariants, args, period):
        self.method: Any
        self.fun: Any
        self.y0: Any
        if invariants is not None and not isinstance(invariants, Mapping):
            kinds.refuse("invariants", "a dict of names and functions", invariants)
        if isinstance(system, type):
            raise TypeError(
                f"give a system, {getattr(system, 'name', system.__name__)}(), not its class."
            )
        self.system = system if hasattr(system, "rhs") else None
        if self.system is not None:
            self.fun = system.rhs
            self.args = system.args
            self.y0 = system.initial_state() if y0 is None else y0
            self.moved = y0 is not None
            self.invariants = dict(system.invariants if invariants is None else invariants)
        else:
            for one in system if isinstance(system, tuple) else (system,):
                validate.function(one, "system")
            self.fun = pair_of(system) if isinstance(system, tuple) else system
            self.args = validate.extra_arguments(args)
            self.y0, self.invariants, self.moved = y0, dict(invariants or {}), True
            if y0 is None:
                raise TypeError("give `y0`, or a system, which has one.")
        if not self.invariants:
            raise ValueError("there are no `invariants` to follow.")
        self.method = method_of(system, method)
        self.period = period
        self.y0 = validate.initial_state(self.y0)

    def length(self, step, n_steps, t_end, periods, steps_per_period):
        """(step or None, end of the run)."""
        if steps_per_period is not None:
            if step is not None:
                raise ValueError("give `step` or `steps_per_period`, not both.")
            if not steps_per_period > 0:
                raise ValueError(f"`steps_per_period` must be positive; got {steps_per_period}.")
            step = self._period() / steps_per_period
        ends = [n_steps is not None, t_end is not None, periods is not None]
        if sum(ends) != 1:
            raise ValueError("give one of `n_steps`, `t_end` and `periods`: how long is the run?")
        if n_steps is not None:
            if step is None:
                raise ValueError("`n_steps` counts constant steps: give `step` too.")
            t_end = n_steps * step
        elif periods is not None:
            t_end = periods * self._period()
        return step, float(t_end)

    def _period(self):
        period = getattr(self.system, "period", None) if self.period is None else self.period
        if period is None or not 0.0 < period < math.inf:
            raise ValueError("there is no period to count in: give `period`, or times.")
        return period

    def _keep_true(self, bounds, bound, followed, t_end):
        """Have compiled functions read again what others may change that run in Python."""
        equations = self.fun if bound.pair else (self.fun,)
        functions = [*zip(bound.pair or (bound,), equations, strict=True)]
        functions += zip(followed, self.invariants.values(), strict=True)
        callbacks = [b.callback for b in bounds if b.callback is not None]
        keep_true(functions, self.args, Near(0.0, t_end, self.y0), callbacks)

    def _survey(self, y0, t_end, options, samples, every):
        """(problem, Survey) of a run, compiled."""
        if self.method.name == WISDOM_HOLMAN:
            steps = study_of(self.system, y0, t_end, options)
            every = every or max(1, int(t_end / steps.h / (LOOKS * samples)))
            return steps, Survey(steps, steps, self._followed(y0, t_end), samples, int(every))
        asked = Arguments(
            fun=self.fun, t0=0.0, tf=t_end, y0=y0, t_eval=np.empty(0), args=self.args,
            options=options,
        )  # fmt: skip
        if isinstance(self.fun, Pair):
            check_pair(len(y0), self.method)
            mode = DERIVATIVE
        else:
            mode = mode_for(asked, self.method)
        p = validate.problem(asked, self.method, mode)
        if p.jac is not None:
            raise TypeError(
                "a drift study takes no `jac`: its Jacobian is exact or by differences."
            )
        probe_equations(p)
        bound = bind_equations(p)
        followed = self._followed(y0, t_end)
        survey = Survey(p, Steps(p, bound), followed, samples, int(every or 1))
        self._keep_true(survey.bounds, bound, followed, t_end)
        return p, survey

    def _followed(self, y0, t_end):
        """The invariants, compiled."""
        followed = [
            bind(f, self.args, EVENT, len(y0), Near(0.0, t_end, y0))
            for f in self.invariants.values()
        ]
        for one in followed:
            evaluate(one.python, EVENT, 0.0, y0.copy())
        return followed

    def follow(self, t_end, options, samples, every, checkpoint, progress):
        """Run, and return the Study."""
        asked = time.perf_counter()
        p, survey = self._survey(self.y0, t_end, options, samples, every)
        announce(survey.bounds)
        file = None
        if checkpoint is not None:
            header = {
                "method": p.method.name, "end of the run": t_end, "samples": samples,
                "every": int(survey.record[0]["every"]), "step": p.h,
                "settings": repr(survey.steps.settings),
                "initial state": self.y0.tolist(),
                "functions": fingerprint(survey.bounds),
            }  # fmt: skip
            file = Checkpoint(checkpoint, header)
            survey.restore(file.load())
        began = time.perf_counter()
        with time_bar(progress, p) as bar:
            try:
                status = survey.run(file, bar)
            except KeyboardInterrupt:
                if file is not None and file.save(survey.arrays()):
                    raise KeyboardInterrupt(
                        f"stopped at t = {survey.t:.6g}; the same call with the same `checkpoint` "
                        "goes on from there"
                    ) from None
                raise
        if status == RAISED:
            raise_kept(survey.bounds, p)
        if file is not None:
            file.save(survey.arrays())
        times = (survey.seconds, began - asked)
        survey.steps.tell()
        message = "" if status == FINISHED else survey.steps.message(status)
        return Study(
            self.system if not self.moved else None, p, list(self.invariants), survey, times,
            message,
        )  # fmt: skip

    def estimate_rounding(self, study, options, every):
        """Set the `rounding` of the drifts of a study."""
        if study.rtol is not None and study.rtol > NO_TOLERANCE:
            return  # the error is that of the tolerance
        t_end = float(study.t[-1])
        compared = t_end * steps_compared(study.n_steps) / study.n_steps
        runs = []
        for y0 in (self.y0, neighbour(self.y0)):
            _, survey = self._survey(y0, compared, options, BINS, every)
            if survey.run(None, None) != FINISHED:
                return
            runs.append(survey.filled())
        n = min(len(t) for t, _, _ in runs)
        if n < 2:
            return
        states, changes = ([run[i][:n] for run in runs] for i in (1, 2))
        found = of_rounding(runs[0][0][:n], states, changes, t_end, study.rtol is None)
        for drift, size in zip(study.drifts.values(), found, strict=True):
            drift.rounding = float(size) / (abs(drift.start) or 1.0)
