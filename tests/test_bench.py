"""The benchmarks measure what they say: stored end states, adapters, interpolation."""

import numpy as np
import pytest

import fastdyn
from bench import rivals
from bench.problems import WORK, error, reference
from bench.report.equal_error import at_error
from bench.report.which_method import front


@pytest.mark.parametrize("problem", WORK, ids=lambda problem: problem.name)
def test_stored_end_state(problem):
    """At the tightest tolerance DOP853 comes close; Arenstorf's orbit magnifies errors the most."""
    fun = problem.fun
    result = fastdyn.solve_ivp(
        fun, problem.t_span, problem.y0, "DOP853", rtol=1e-13, atol=1e-13, args=problem.args
    )
    assert error(result.y[:, -1], reference(problem)) < 1e-8


@pytest.mark.slow
def test_adapters():
    """Each solver comes within some thousand tolerances of the pendulum's end state."""
    problem = next(p for p in WORK if p.name == "pendulum, swinging")
    for name, prepare in rivals.solvers(problem).items():
        assert error(prepare(1e-9)(), reference(problem)) < 5e-6, name
        with_times = prepare(1e-9, np.linspace(*problem.t_span, 5))
        if with_times is not None:
            assert error(with_times(), reference(problem)) < 5e-6, name


def test_time_at_an_error():
    """Straight in logarithms, nothing beyond what was reached, never more than a better one."""
    points = [(1e-2, 1.0), (1e-4, 10.0), (1e-5, 5.0), (None, 2.0)]
    assert at_error(points, 1e-6) is None
    assert at_error(points, 1e-1) == 1.0
    assert at_error(points, 1e-5) == pytest.approx(5.0)
    assert at_error(points, 10**-3.5) == pytest.approx(5.0**0.5)


def test_a_line_of_the_figure():
    """What another point beats in both error and time is not drawn."""
    points = [(1e-5, 5.0), (1e-4, 10.0), (1e-2, 1.0), (1e-3, 5.0)]
    assert front(points) == [(1e-2, 1.0), (1e-5, 5.0)]
