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
from fastdyn.problem import validate
from fastdyn.problem.arguments import Arguments
from fastdyn.problem.options import kinds
from fastdyn.problem.options.calls import shown_when_wrong
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
from fastdyn.run.loop import announce, progress_bar
from fastdyn.run.outcome import outcome

from .study import Study
from .survey import Survey

if TYPE_CHECKING:
    from fastdyn.problem import argument_types as types


@shown_when_wrong(
    "The state of a function is `y0=`, the end `t_end=` and what is followed `invariants=`: "
    "energy_drift(fun, method, y0=y0, t_end=100.0, step=0.1, invariants={'energy': energy})."
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
    every: int = 1,
    y0: types.State | None = None,
    invariants: Mapping[str, Callable[..., Any]] | None = None,
    args: types.Arguments | None = None,
    checkpoint: types.Path | None = None,
    progress: bool = False,
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
        Any compiled method.
    step, steps_per_period : float, optional
        Size of the constant steps, or the number of steps in a period.  Adaptive methods take
        `rtol` and `atol` instead.
    n_steps, t_end, periods : float, optional
        Length of the run: number of constant steps, time, or periods of the system.
    period : float, optional
        Length of a period; a system knows its period.
    samples : int
        Number of bins of which mean, minimum and maximum are kept.
    every : int
        Number of steps between two evaluations of the invariants.
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
    **options
        `rtol`, `atol`, `max_step`, `first_step` of the adaptive methods, `compile`.

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
    kinds.whole("every", every)
    kinds.whole("samples", samples)
    kinds.flag("progress", progress)
    run = _Run(system, method, y0, invariants, args, period)
    length = run.length(step, n_steps, t_end, periods, steps_per_period)
    if length[0] is not None:
        options["step"] = length[0]
    if every < 1 or samples < 1:
        raise ValueError("`every` and `samples` must be whole numbers of at least 1.")
    given = (length[1], options, int(samples), int(every), checkpoint, progress)
    return or_in_python(lambda: run.follow(*given))


OWN = {*inspect.signature(energy_drift).parameters} - {"options"}


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
            self.fun, self.args = system.rhs, system.args
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
        self.method, self.period = validate.method_named(method), period
        if self.method is None:
            raise ValueError(f"`method={method!r}` is SciPy's; a drift study needs a compiled one.")
        self.y0 = validate.initial_state(self.y0)

    def length(self, step, n_steps, t_end, periods, steps_per_period):
        """(step or None, end of the run)."""
        if steps_per_period is not None:
            if step is not None:
                raise ValueError("give `step` or `steps_per_period`, not both.")
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

    def follow(self, t_end, options, samples, every, checkpoint, progress):
        """Run, and return the Study."""
        n = len(self.y0)
        asked = Arguments(
            fun=self.fun, t0=0.0, tf=t_end, y0=self.y0, t_eval=np.empty(0), args=self.args,
            options=options,
        )  # fmt: skip
        if isinstance(self.fun, Pair):
            check_pair(n, self.method)
            mode = DERIVATIVE
        else:
            mode = mode_for(asked, self.method)
        p = validate.problem(asked, self.method, mode)
        if p.jac is not None:
            raise TypeError("a drift study takes no `jac`: it is exact, or by differences.")
        probe_equations(p)
        bound = bind_equations(p)
        followed = [
            bind(f, self.args, EVENT, n, Near(0.0, t_end, self.y0))
            for f in self.invariants.values()
        ]
        for one in followed:
            evaluate(one.python, EVENT, 0.0, self.y0.copy())
        survey = Survey(p, bound, followed, samples, every)
        announce(survey.bounds)
        self._keep_true(survey.bounds, bound, followed, t_end)
        file = None
        if checkpoint is not None:
            header = {
                "method": p.method.name, "end of the run": t_end, "samples": samples,
                "every": every, "step": p.h, "tolerances": repr((p.rtol, p.atol, p.h_max)),
                "initial state": self.y0.tolist(),
                "functions": fingerprint(survey.bounds),
            }  # fmt: skip
            file = Checkpoint(checkpoint, header)
            survey.restore(file.load())
        bar = progress_bar(p) if progress else None
        began = time.perf_counter()
        try:
            status = survey.run(file, bar)
        except KeyboardInterrupt:
            if file is not None and file.save(survey.arrays()):
                raise KeyboardInterrupt(
                    f"stopped at t = {survey.t:.6g}; the same call with the same `checkpoint` "
                    "goes on from there"
                ) from None
            raise
        finally:
            if bar is not None:
                bar.close()
        if status == RAISED:
            raise_kept(survey.bounds, p)
        if file is not None:
            file.save(survey.arrays())
        seconds = time.perf_counter() - began
        message = "" if status == FINISHED else outcome(status, survey.state, survey.work, p)[1]
        return Study(
            self.system if not self.moved else None, p, list(self.invariants), survey, seconds,
            message,
        )  # fmt: skip
