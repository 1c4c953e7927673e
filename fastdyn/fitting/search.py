"""The search for the least sum of squares, from one start or several."""

import sys
from typing import Any, NamedTuple

import numpy as np

from fastdyn.plot.needed import progress_bar

from .descent import descend
from .motion import Failed
from .starts import best_first

ROUNDS = 50  # most estimates of unknown noise
STEADY = 1e-4  # relative change of a deviation below which it is known
INTERRUPTED = "Interrupted by Ctrl-C: these are the best values so far."


class Found(NamedTuple):
    """The end of a search: Residuals at the best values, and what became of it."""

    residuals: Any
    success: bool
    message: str


def search(model, trials, max_nfev, progress):
    """Refine the best of the trials; Ctrl-C ends the search with the best values so far."""
    with progress_bar(progress, desc="fit", unit=" trials", file=sys.stderr) as bar:
        if bar is not None:
            model.watch = lambda: _show(bar, model)
        try:
            success, message = _searched(model, trials, max_nfev)
        except KeyboardInterrupt:
            model.watch = None
            known = model.best or model.before
            if known is None:
                raise
            if model.groups:
                model.take_noise(known)
            return Found(model.residuals(known.x), False, INTERRUPTED)
        finally:
            model.watch = None
    return Found(model.residuals(model.before.x), success, message)


def _searched(model, trials, max_nfev):
    for motion in model.motions:
        motion.probe(model.parameters.values(trials[0]))
    ends = []
    for k, x in enumerate(best_first(model, trials)):
        try:
            end = _refined(model, x, max_nfev)
        except Failed as reason:
            if k or len(trials) > 1:
                model.note_failure(reason)
                continue
            raise _of_start(model, x, reason) from reason.__cause__
        ends.append((2.0 * end.cost, end))
    if not ends:
        raise ValueError(f"The motion fails at all {len(trials)} starts: {model.failure}")
    end = min(ends, key=lambda each: each[0])[1]
    for _ in range(ROUNDS):
        model.before = model.residuals(end.x)
        if not model.groups:
            return end.status > 0, _said(model, end)
        change = model.take_noise(model.before)
        if change < STEADY or (model.one_noise and model.loss is None):
            return end.status > 0, _said(model, end)
        end = _refined(model, end.x, max_nfev)
    return False, f"The estimates of the noise did not settle in {ROUNDS} rounds."


def _said(model, end):
    failed = f" {model.n_failed} trials failed, the last: {model.failure}" if model.n_failed else ""
    return end.message + failed


def _of_start(model, x, reason):
    values = ", ".join(f"{n} = {v:g}" for n, v in _named(model, x))
    said = f"The fit cannot start at {values}: {reason}"
    if not model.differences and np.isfinite(model.chi2(x)):
        said += (
            " The motion itself is solved there: `differences=True` takes differences of solves "
            "instead of derivatives."
        )
    return ValueError(said)


def _refined(model, start, max_nfev):
    """The end of the way down from a start; Failed if the motion fails there."""
    p = model.parameters

    def evaluate(x):
        found = model.residuals(x)
        return found.r, found.jac

    given = {"max_nfev": max_nfev, "longest": p.longest, **of_loss(model)}
    return descend(evaluate, start, p.lowest, p.highest, model.note_failure, **given)


def of_loss(model):
    """Options of `least_squares` for the loss of a model."""
    return {} if model.loss is None else {"loss": model.loss, "f_scale": model.loss.scale}


def _named(model, x):
    """Pairs of the names and the values of the parameters at coordinates x."""
    return zip(model.parameters.names, model.parameters.values(x), strict=True)


def _show(bar, model):
    bar.update()
    if model.best is not None:
        bar.set_postfix_str(f"chi2 = {model.best.chi2:.6g}")
