"""The result of a stochastic solve."""

from typing import Any, NamedTuple

import numpy as np


class Paths:
    """Paths of a stochastic differential equation.

    Attributes
    ----------
    t : ndarray, shape (n_times,)
        Times of output.
    y : ndarray, shape (M, n, n_times), or (n, n_times) for a single path, or None
        The states; None with `reduce`.
    y_end : ndarray, shape (M, n) or (n,)
        The states at the end.
    reduced : dict of str to ndarray
        What `reduce` asked for, with the times as the last axis.
    t_events : ndarray, shape (n_events, M) or (n_events,), or None
        The time of the first passage of each path through each event, NaN without one.
    success : ndarray of bool, shape (M,), or bool
        Whether the state at the end is finite.
    message : str
    method, calculus, noise : str
        The method taken, the integral, and the kind of the noise: "additive" (independent of the
        state), "unmixed" (components do not mix, or one source), "general", or None if a function
        that runs in Python leaves this open.
    step : float
        The size of the steps.
    n_steps : int
        Steps of each path.
    nfev : int
        Evaluations of the drift for each path.
    width : int
        Paths in the lanes of a vector; 1 if each runs alone, for the `reason`.
    reason : str
    key : int
        What the random numbers depend on, besides the numbers of path, source and step.
    """

    def __init__(self, solved, single):
        self._solved = solved
        self._single = single
        facts = solved.facts
        self.t = solved.t
        self.reduced = solved.reduced
        self.method = facts.method
        self.calculus = facts.calculus
        self.noise = facts.noise
        self.step = facts.step
        self.n_steps = facts.n_steps
        self.nfev = facts.nfev
        self.width = facts.width
        self.reason = facts.reason
        self.key = facts.key
        finite = np.isfinite(solved.y_end).all(axis=0)
        lost = int((~finite).sum())
        self.message = (
            "All paths reached the end."
            if not lost
            else f"{lost} of {len(finite)} paths left the finite numbers: try a smaller `step`."
        )
        y = None if solved.y is None else solved.y.transpose(2, 1, 0)
        self.y: Any = y if y is None or not single else y[0]
        self.y_end = solved.y_end[:, 0] if single else solved.y_end.T
        self.success: Any = bool(finite[0]) if single else finite
        times = solved.passages
        self.t_events: Any = times if times is None or not single else times[:, 0]

    def brownian(self):
        """The Brownian motion of each source at the times of output, from 0 at the start.

        Returns
        -------
        ndarray, shape (M, m, n_times), or (m, n_times) for a single path
            W of each of the m sources of noise, in the order of the columns of the diffusion.
        """
        w = self._solved.brownian().transpose(2, 1, 0)
        return w[0] if self._single else w

    def __repr__(self):
        n_paths = 1 if self._single else len(self.y_end)
        n = self.y_end.shape[-1]
        lanes = f"{self.width} lanes" if self.width > 1 else f"one by one: {self.reason}"
        return (
            f"Paths({n_paths} of {n} components, {self.method}, {self.calculus}, "
            f"{self.n_steps} steps of {self.step:.6g}, {lanes}): {self.message}"
        )


class Taken(NamedTuple):
    """How paths were computed."""

    method: str
    calculus: str
    noise: Any
    step: float
    n_steps: int
    nfev: int
    width: int
    reason: str
    key: int


class SolvedPaths(NamedTuple):
    """What a solve leaves: times; states (n_times, n, M) or None, (n, M); reductions; passages."""

    t: np.ndarray
    y: Any
    y_end: np.ndarray
    reduced: dict
    passages: Any
    facts: Taken
    brownian: Any
