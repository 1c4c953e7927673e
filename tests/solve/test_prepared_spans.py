"""A prepared solver with other spans and times, and with `adjoint`: as solve_ivp."""

import pickle

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp

TIGHT = {"rtol": 1e-6, "atol": 1e-9}
START = [1.0, 0.0]


def driven(t, y, u, k):
    return [y[1], -k * y[0] + u * np.cos(t)]


def rises(t, y, u, k):
    return y[0]


def kicks(t, y, u, k):
    return [y[0] + 0.1, y[1]]


OPTIONS = {
    "steps": {},
    "times": {"t_eval": np.linspace(0, 1, 5)},
    "dense": {"dense_output": True},
    "sensitivity": {"sensitivity": ("u", "y0")},
    "events": {"events": rises},
    "adjoint": {"adjoint": ("y0", "u"), "t_eval": np.linspace(0, 1, 5)},
    "adjoint of all steps": {"adjoint": "u"},
    "breakpoints": {"breakpoints": [0.4, 1.4]},
    "every": {"every": 0.3, "on_event": kicks},
    "longest step": {"max_step": 0.07},
}


def assert_same(found, other):
    assert np.array_equal(found.t, other.t) and np.array_equal(found.y, other.y)
    assert found.nfev == other.nfev
    if "sensitivity" in other:
        for name, values in other.sensitivity.items():
            assert np.array_equal(found.sensitivity[name], values)
    if "vjp" in other:
        g = np.ones(found.y.shape)
        ours, theirs = found.vjp(g), other.vjp(g)
        assert all(np.allclose(ours[name], theirs[name], rtol=1e-12) for name in theirs)


@pytest.mark.parametrize("method", ["Tsit5", "DOP853", "RK45", "Rodas5P"])
@pytest.mark.parametrize("name", OPTIONS)
def test_other_spans(method, name):
    """Spans move on, as in a controller, and come back to the first."""
    options = OPTIONS[name]
    solver = prepare(driven, (0, 1), START, method, args=(0.5, 2.0), **options, **TIGHT)
    for i in range(7):
        t0, args, y0 = (0.0, 0.3 * i, 1.0)[i % 3], (0.3 * i, 2.0), [1.0 + i, 0.1]
        span, how = (t0, t0 + 1.0), dict(options)
        times = np.linspace(t0, t0 + 1, 5) if "t_eval" in options else None
        if times is not None:
            how["t_eval"] = times
        found = solver(y0, args, span, times)
        assert_same(found, solve_ivp(driven, span, y0, method, args=args, **how, **TIGHT))
        if i % 2:
            found = solver(y0, args)
            other = solve_ivp(driven, (0, 1), y0, method, args=args, **options, **TIGHT)
            assert_same(found, other)


def test_constant_steps_and_the_way_back_in_time():
    solver = prepare(driven, (0, 1), START, "RK4", args=(0.5, 2.0), step=0.1)
    back = prepare(driven, (0, 1), START, "Tsit5", args=(0.5, 2.0), **TIGHT)
    for end in (2.0, -1.0, 0.35, 1.0):
        given = {"args": (0.5, 2.0)}
        other = solve_ivp(driven, (0.3, end), START, "RK4", step=0.1, **given)
        assert_same(solver(t_span=(0.3, end)), other)
        other = solve_ivp(driven, [0.3, end], START, "Tsit5", **given, **TIGHT)
        assert_same(back(t_span=[0.3, end]), other)


def test_spans_with_discrete_states():
    def held(t, y, d):
        return [d[0] - y[0]]

    def sampled(t, y, d):
        return y, [0.9 * d[0]]

    how = {"every": 0.3, "on_event": sampled}
    solver = prepare(held, (0, 1), [1.0], discrete=[0.5], **how)
    found = solver([2.0], discrete=[0.1], t_span=(3.0, 5.0))
    other = solve_ivp(held, (3.0, 5.0), [2.0], discrete=[0.1], **how)
    assert np.array_equal(found.y, other.y) and found.t[0] == 3.0


def test_copies_take_spans_and_adjoint():
    times = np.linspace(0, 1, 3)
    solver = prepare(driven, (0, 1), START, "Tsit5", times, args=(0.5, 2.0), adjoint="u")
    again = pickle.loads(pickle.dumps(solver))
    found = [s(t_span=(1, 2), t_eval=times + 1).vjp(np.ones((2, 3)))["u"] for s in (solver, again)]
    assert found[0] == found[1]


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
