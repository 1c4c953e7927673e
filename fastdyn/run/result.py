"""What a solve returns: OdeResult, OdeSolution, and the sentences for each status."""

import numpy as np

from fastdyn.kernels.state.record import (
    EVENT,
    NON_FINITE,
    NOT_CONVERGED,
    RTOL,
    STEP_TOO_SMALL,
    K,
    Y,
)

SUCCESS = "The solver successfully reached the end of the integration interval."
TERMINATED = "A termination event occurred."
TOO_SMALL = "Required step size is less than spacing between numbers."
BLOWN_UP = 1e8  # growth over the initial state that is called a blow-up


class OdeResult(dict):
    """A dict with attribute access, with SciPy's fields and a few more.

    Attributes
    ----------
    t : ndarray, shape (n_points,)
    y : ndarray, shape (n, n_points)
    sol : OdeSolution or None
    t_events, y_events : list of ndarray or None
    nfev, njev, nlu : int
    status : int
        0 the end was reached, 1 a terminal event, -1 failure, -2 interrupted.
    message : str
    success : bool
    n_accepted, n_rejected : int
        Steps (of our methods).
    """

    def __getattr__(self, name):
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name, value):
        self[name] = value

    def __delattr__(self, name):
        del self[name]

    def __dir__(self):
        return [*super().__dir__(), *self]

    def __repr__(self):
        width = max(map(len, self), default=0)
        lines = []
        for name, value in self.items():
            text = repr(value).replace("\n", "\n" + " " * (width + 2))
            lines.append(f"{name:>{width}}: {text}")
        return "\n".join(lines)

    def plot(self, **options):
        """Draw the components against time; of a system, its figure."""
        from fastdyn.plot.solution import plot

        return plot(self, **options)


def outcome(status, state, work, problem):
    """SciPy's status and a message that says why the kernels stopped before the end."""
    s = state[0]
    if status == EVENT:
        return 1, TERMINATED
    t = f"t = {s['t']:.10g}"
    if status == STEP_TOO_SMALL:
        return -1, f"{TOO_SMALL} {_why(s, work, problem, t)}"
    bad = np.flatnonzero(~np.isfinite(work[K + problem.method.last]))
    if status == NON_FINITE and s["n_accepted"] == 0 and bad.size:
        return -1, f"`fun` returned nan or inf at the start, {t} (component {bad[0]})."
    if status == NOT_CONVERGED:
        return -1, (
            f"The equations of the implicit step from {t} do not converge: reduce `step`, or take "
            "Radau or BDF if the problem is stiff."
        )
    if status == NON_FINITE:
        return -1, (
            f"The state is not finite after {t}: the solution blows up there, or the steps are "
            "too long for it; reduce `step`."
        )
    return -1, (
        f"`max_steps={problem.max_steps:g}` was reached at {t}, "
        f"{abs(s['t'] - problem.t0) / abs(problem.tf - problem.t0):.1%} of the way: raise "
        "`max_steps`, loosen `rtol` and `atol`, or take Radau or BDF if the problem is stiff."
    )


def _why(s, work, problem, t):
    """Why an adaptive run came to a stop."""
    if problem.h_max < 16 * np.spacing(abs(float(s["t"]))):
        return f"At {t}, `max_step={problem.h_max:g}` is no step."
    if not np.isfinite(s["error"]):
        return f"`fun` returns nan or inf just after {t}."
    rate = work[K + problem.method.last]
    growth = np.abs(work[Y]).max() / max(np.abs(problem.y0).max(), 1e-300)
    if growth > BLOWN_UP:
        return f"The solution blows up at {t}: it has grown {growth:.1e}-fold."
    return (
        f"At {t} no step is short enough for the tolerance: the solution has a singularity or a "
        f"jump there (largest derivative {np.abs(rate).max():.1e}), or "
        f"rtol = {work[RTOL].max():.1e} is too loose to have kept it away from one."
    )
