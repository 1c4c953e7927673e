"""A prepared solver with other spans and times, and with `adjoint`: as solve_ivp."""

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp

TIGHT = {"rtol": 1e-6, "atol": 1e-9}
START = [1.0, 0.0]


def driven(t, y, u, k):
    return [y[1], -k * y[0] + u * np.cos(t)]


def assert_same(found, other):
    assert np.array_equal(found.t, other.t) and np.array_equal(found.y, other.y)
    assert found.nfev == other.nfev


def test_constant_steps_and_the_way_back_in_time():
    solver = prepare(driven, (0, 1), START, "RK4", args=(0.5, 2.0), step=0.1)
    back = prepare(driven, (0, 1), START, "Tsit5", args=(0.5, 2.0), **TIGHT)
    for end in (2.0, -1.0, 0.35, 1.0):
        given = {"args": (0.5, 2.0)}
        other = solve_ivp(driven, (0.3, end), START, "RK4", step=0.1, **given)
        assert_same(solver(t_span=(0.3, end)), other)
        other = solve_ivp(driven, [0.3, end], START, "Tsit5", **given, **TIGHT)
        assert_same(back(t_span=[0.3, end]), other)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"t_span": (1.0, 1.0)}, "must not be empty"),
        ({"t_span": 3.0}, "t_span"),
        ({"t_eval": [0.1, 0.2, 0.3]}, "must have 5 times, as when it was prepared"),
        ({"t_span": (3.0, 4.0)}, "not within"),
        ({"y0": [1.0], "t_span": (3.0, 4.0)}, "2 real numbers"),
    ],
)
def test_what_a_prepared_solver_refuses(given, said):
    solver = prepare(driven, (0, 1), START, t_eval=np.linspace(0, 1, 5), args=(0.5, 2.0))
    with pytest.raises((ValueError, TypeError), match=said):
        solver(**given)
    bare = prepare(driven, (0, 1), START, args=(0.5, 2.0))
    with pytest.raises(ValueError, match="needs a solver that is prepared with `t_eval`"):
        bare(t_eval=[0.5])


def test_what_has_no_adjoint_is_refused_when_it_is_prepared():
    with pytest.raises(ValueError, match="adjoint"):
        prepare(driven, (0, 1), START, "BDF", args=(0.5, 2.0), adjoint="u")
    solver = prepare(driven, (0, 1), START, "Tsit5", args=(0.5, 2.0), adjoint="u")
    with pytest.raises(ValueError, match="no sensitivities"):
        solver.many([START, START])
