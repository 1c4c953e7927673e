"""Compares a solution with the function itself, called in Python."""

import numpy as np

MOST = 8  # points
ASIDE = 1e-3  # share by which a state is moved, to see how large the terms of a residual are
SMALL = 1e-3  # residuals, in those of a moved state


@np.errstate(all="ignore")
def check_with_function(fun, args, found, jumps=()):
    """Raise ValueError if the solution is none of ``fun(t, y, yp) = 0`` at some of its times.

    At the times `jumps` the solution has one side, and the function the other.
    """
    random = np.random.default_rng(1)
    at = np.flatnonzero(~np.isin(found.t, jumps))
    for i in at[np.unique(np.linspace(0, len(at) - 1, MOST).astype(int))] if len(at) else ():
        t = float(found.t[i])
        y = found.y[:, i]
        yp = np.nan_to_num(found.yp[:, i])
        try:
            residual = np.abs(np.asarray(fun(t, y.copy(), yp.copy(), *args), float))
            moved = [
                np.abs(np.asarray(fun(t, *_moved(random, y, yp), *args), float)) for _ in range(3)
            ]
        except (ArithmeticError, ValueError):  # as where a state is moved out of a domain
            continue
        wrong = residual > SMALL * np.max(moved, axis=0)
        if (wrong & (residual > np.finfo(float).eps * max(np.abs(y).max(), 1.0))).any():
            raise ValueError(
                f"at t = {t:.6g}, equations {', '.join(map(str, np.flatnonzero(wrong)))} do not "
                "hold when the function is called in Python: it is not the same at all states, or "
                "depends on what changes."
            )


def _moved(random, y, yp):
    sizes = [ASIDE * (np.abs(each) + np.abs(each).max() * ASIDE) for each in (y, yp)]
    return [
        each + size * random.uniform(-1, 1, len(each))
        for each, size in zip((y, yp), sizes, strict=True)
    ]
