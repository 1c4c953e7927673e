"""OutputFcn: a function of the user that sees the solution while it is made."""

import numpy as np


class OutputFunction:
    """
    Calls ``function(t, y, flag)`` as MATLAB does, and notes whether the function stopped the run.

    At the start, the flag is "init", t has the ends of the span, and y is the state, shape (n,).
    After each step with output, the flag is "", t has shape (k,), and y has shape (n, k). At the
    end, the flag is "done", and t and y are empty. The function stops the run by returning true
    after a step.

    Parameters
    ----------
    function : callable
    chosen : array_like of int or None
        OutputSel, the components for the function, counted from 0.
    times : ndarray
        The times of `tspan`. More than two times are the times of output; with two times, every
        step gives output.
    refine : int
    """

    def __init__(self, function, chosen, times, refine):
        self.function = function
        self.times = times
        self.refine = refine
        self.chosen = slice(None) if chosen is None else np.asarray(chosen, int)

    def begin(self, y0):
        """Before the first step."""
        self.function(self.times[[0, -1]], y0[self.chosen], "init")

    def step(self, solver):
        """After a step of a Stepper; whether to stop."""
        t_old = solver.t_old
        t = solver.t
        if len(self.times) > 2:
            passed = (self.times - t_old) * (t - self.times)
            t_out = self.times[(passed >= 0.0) & (self.times != t_old)]
        else:
            t_out = t_old + (t - t_old) * np.arange(1, self.refine + 1) / self.refine
            t_out[-1] = t
        if not len(t_out):
            return False
        y = solver.interpolate(t_out)
        y[:, t_out == t] = solver.y[:, None]
        return bool(self.function(t_out, y[self.chosen], ""))

    def end(self):
        """After the last step."""
        self.function(np.empty(0), np.empty(0), "done")
