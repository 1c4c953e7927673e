"""A Fit as a table of its parameters, with what the reader must know."""

import numpy as np

SHOWN = 6  # digits of a value
AT_BOUND = 1e-3  # distance from a bound, in standard errors and in sizes of start and bounds
ROUGH = 0.1  # standard deviations: an error of the solver above is reported
BETTER = 0.1  # a fall of the sum of squares that is another optimum, not rounding
UNLIKELY = 1e-4  # p-value below which the values do not look like the model with its noise


def table(fit):
    """A Fit as a table of its parameters, with what the reader must know."""
    n_values = fit._model.n_values
    n_records = len(fit._model.records)
    p = "" if fit.p_value is None else f", p = {fit.p_value:.2g}"
    p += "" if fit.aic is None else f", AIC = {fit.aic:.6g}"
    head = (
        f"{len(fit.names)} parameters from {n_values} values of {n_records} "
        f"record{'s' * (n_records > 1)}, chi2 = {fit.chi2:.4g} for {fit.dof} degrees of freedom{p}"
    )
    width = max(9, *map(len, fit.names))
    kind = "profile" if fit.curved else "interval"
    rows = [f"{'':{width}}  {'value':>12}  {'error':>9}  {percent(fit.level)} {kind}"]
    for name, value, error, (low, high) in zip(
        fit.names, fit.x, fit.errors, fit.intervals, strict=True
    ):
        shown, *ends = (digits(each, error) for each in (value, low, high))
        rows.append(f"{name:{width}}  {shown:>12}  {error:9.2g}  {' to '.join(ends)}")
    return "\n".join([head, *rows, *_remarks(fit)])


def percent(level):
    """A confidence in words: 95%, 99.7%."""
    return f"{100 * level:.6g}%"


def digits(value, error):
    """A value with the digits that its error leaves, at least SHOWN; all of an exact value."""
    if not (np.isfinite(value) and np.isfinite(error) and error > 0 and value):
        return f"{value:.{SHOWN}g}"
    known = int(np.floor(np.log10(abs(value)))) - int(np.floor(np.log10(error))) + 2
    return f"{value:.{min(max(known, SHOWN), 17)}g}"


def _starts(fit):
    """Where y0 is, in a sentence."""
    records = fit._model.records
    every = [f"{fit.t0(k):.6g}" for k in range(len(records))]
    own = "" if len(set(every)) == 1 else " of the records"
    shown = dict.fromkeys(every) if len(set(every)) == 1 else every
    return f"y0{own} is the state at t0 = {', '.join(shown)}."


def _remarks(fit):
    found = [_starts(fit)]
    found += [f"estimated noise of {name}: {value:.3g}" for name, value in fit.noise.items()]
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
