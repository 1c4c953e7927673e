"""Spans without end: the run ends, whatever the solution does."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn.kernels.methods import METHODS
from fastdyn.problem.step_options import LATEST

ADAPTIVE = [name for name, method in METHODS.items() if method.error_order]
SOLUTIONS = {
    "at rest": (lambda t, y: [0.0 * y[0]], [1.0]),
    "as the time": (lambda t, y: [y[0] / (1.0 + t)], [1.0]),
}


@pytest.mark.parametrize("name", ADAPTIVE)
@pytest.mark.parametrize("what", SOLUTIONS)
def test_a_solution_that_steps_cannot_follow_for_ever_ends(name, what):
    fun, y0 = SOLUTIONS[what]
    found = fastdyn.solve_ivp(fun, (0.0, math.inf), y0, name, t_eval=[], max_steps=10_000)
    assert found.status in (0, -1) and found.nfev < 1e5


def test_members_at_rest_end():
    fun, y0 = SOLUTIONS["at rest"]
    found = fastdyn.solve_ensemble(fun, (0.0, math.inf), [y0] * 9, max_steps=10_000)
    assert np.all(found.status == 0) and np.all(found.t_end == LATEST)


@pytest.mark.parametrize("span", [(0.0, 1e308), (-1e308, 0.0), (-9e307, math.inf)])
def test_times_whose_distance_may_be_no_number_are_refused(span):
    with pytest.raises(ValueError, match="must lie within"):
        fastdyn.solve_ivp(lambda t, y: [0.0 * y[0]], span, [1.0])
