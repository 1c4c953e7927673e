"""Arguments: SciPy's exceptions where SciPy raises, a sentence where SciPy hangs or lies."""

import warnings

import numpy as np
import pytest
import scipy.integrate
from hypothesis import given, settings
from hypothesis import strategies as st

import fastdyn

MATRIX = np.array([[0.0, 1.0], [-1.0, -0.1]])


def linear(t, y):
    return -0.5 * y


def late_nan(t, y):
    return [np.nan if t > 0.5 else 1.0]


def square(t, y):
    return y**2


def base(**changes):
    return {"fun": linear, "t_span": (0, 1), "y0": [1.0, 2.0]} | changes


def typed(terminal):
    def event(t, y):
        return y[0]

    event.terminal = terminal
    return event


AS_SCIPY = [
    {"t_span": (0, 1, 2)},
    {"y0": 1.0},
    {"y0": [[1.0]]},
    {"y0": [np.nan, 1.0]},
    {"t_eval": [[0.5]]},
    {"t_eval": [0.5, 2.0]},
    {"t_eval": [0.5, 0.2]},
    {"t_eval": [0.5, 0.5]},
    {"max_step": 0},
    {"first_step": -1},
    {"first_step": 2},
    {"atol": -1},
    {"atol": [1e-6] * 3},
    {"args": 3},
    {"events": typed(1.5)},
    {"events": typed(-1)},
    {"y0": [1j, 1.0], "method": "LSODA"},
]


@pytest.mark.parametrize("changes", AS_SCIPY, ids=lambda changes: "-".join(changes))
def test_errors_are_scipys(changes):
    with pytest.raises(Exception) as theirs:
        scipy.integrate.solve_ivp(**base(**changes))
    with pytest.raises(theirs.type) as ours:
        fastdyn.solve_ivp(**base(**changes))
    assert str(theirs.value)[:40] in str(ours.value)


BEYOND_SCIPY = {
    "unknown": ({"method": "RK54"}, "must be one of RK23"),
    "NaN rtol": ({"rtol": np.nan}, "NaN"),
    "NaN atol": ({"atol": np.nan}, "NaN"),
    "NaN in atol": ({"atol": [1e-6, np.nan]}, "NaN"),
    "NaN t_span": ({"t_span": (0, np.nan)}, "NaN"),
    "endless": ({"t_span": (0, np.inf)}, "terminal event"),
    "NaN t_eval": ({"t_eval": [0.1, np.nan]}, "NaN"),
    "no tolerance": ({"atol": 0.0, "y0": [1.0, 0.0]}, "positive `atol`"),
    "no step": ({"method": "RK4"}, "`step`"),
    "bad step": ({"method": "RK4", "step": -1}, "positive"),
    "odd state": ({"method": "VelocityVerlet", "step": 0.1, "y0": [1.0]}, "[q, v]"),
    "not [q, v]": ({"method": "VelocityVerlet", "step": 0.1}, "not v"),
    "bad tier": ({"tier": "fast"}, "pointer"),
    "max_steps": ({"max_steps": 0}, "at least 1"),
    "too long": ({"fun": lambda t, y: [1.0, 2.0, 3.0]}, "3 values for a state of 2"),
    "too short": ({"fun": lambda t, y: [1.0]}, "1 values for a state of 2"),
    "scalar": ({"fun": lambda t, y: 1.0}, "1 values for a state of 2"),
    "None": ({"fun": lambda t, y: None}, "returned NoneType"),
    "text": ({"fun": lambda t, y: ["a", "b"]}, "must return 2 numbers"),
    "complex": ({"fun": lambda t, y: [1j, 2.0]}, "complex"),
}


@pytest.mark.parametrize(("changes", "words"), BEYOND_SCIPY.values(), ids=BEYOND_SCIPY)
def test_what_makes_scipy_hang_or_lie_is_a_sentence(changes, words):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.CompileWarning)
        with pytest.raises((ValueError, TypeError)) as caught:
            fastdyn.solve_ivp(**base(**changes))
    assert words in str(caught.value)


def test_velocity_dependent_force_is_refused():
    def damped(t, y):
        return [y[1], -y[0] - 0.1 * y[1]]

    with pytest.raises(ValueError, match="depends on the velocity"):
        fastdyn.solve_ivp(damped, (0, 1), [1.0, 0.0], "VelocityVerlet", step=0.1)


@pytest.mark.parametrize("method", ["RK45", "ode45", "RK4", "Radau"])
def test_nan_at_the_start_is_a_failure_that_says_so(method):
    options = {"step": 0.1} if method == "RK4" else {}
    r = fastdyn.solve_ivp(lambda t, y: [np.nan], (0, 1), [1.0], method, **options)
    assert r.status == -1 and not r.success and "nan or inf at the start" in r.message


def test_failures_say_why():
    r = fastdyn.solve_ivp(late_nan, (0, 1), [0.0])
    assert r.status == -1 and "returns nan or inf just after t = 0.5" in r.message
    r = fastdyn.solve_ivp(square, (0, 2), [1.0], rtol=1e-8)
    assert r.status == -1 and "blows up at t = 1" in r.message
    r = fastdyn.solve_ivp(square, (0, 2), [1.0], "RK4", step=0.01)
    assert r.status == -1 and "not finite after t = 1.0" in r.message


@pytest.mark.parametrize("method", ["RK45", "RK4"])
def test_unused_options_are_warned_of_at_the_callers_line(method):
    options = {"step": 0.1} if method == "RK4" else {}
    with pytest.warns(UserWarning, match="no effect.*`foo`") as caught:
        fastdyn.solve_ivp(linear, (0, 1), [1.0], method, foo=1, **options)
    assert caught[0].filename == __file__


numbers = st.floats(-3, 3).map(lambda x: round(x, 3))


@settings(max_examples=60, deadline=None)
@given(
    y0=st.lists(numbers, min_size=1, max_size=20),
    start=numbers,
    length=st.floats(0.1, 5).flatmap(lambda x: st.sampled_from([x, -x])),
    rtol=st.sampled_from([1e-2, 1e-4, 1e-9]),
    method=st.sampled_from(["RK23", "RK45", "DOP853"]),
    points=st.one_of(st.none(), st.lists(st.floats(0, 1), max_size=8, unique=True)),
    level=numbers,
    terminal=st.sampled_from([False, True, 2]),
    dense=st.booleans(),
)
def test_any_valid_call_gives_scipys_answer(
    y0, start, length, rtol, method, points, level, terminal, dense
):
    def crossing(t, y, level=level):
        return y[0] - level

    crossing.terminal = terminal
    t_span = (start, start + length)
    t_eval = None
    if points is not None:
        t_eval = np.unique(np.clip(start + length * np.array(points), *sorted(t_span)))
        t_eval = t_eval if length > 0 else t_eval[::-1]
    given_ = {"method": method, "t_eval": t_eval, "events": crossing, "dense_output": dense}
    ours = fastdyn.solve_ivp(linear, t_span, y0, rtol=rtol, **given_)
    theirs = scipy.integrate.solve_ivp(linear, t_span, y0, rtol=rtol, **given_)
    assert (ours.status, ours.nfev, len(ours.t)) == (theirs.status, theirs.nfev, len(theirs.t))
    assert list(theirs) == list(ours)[: len(theirs)]
    if len(theirs.t):
        np.testing.assert_allclose(ours.t, theirs.t, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(ours.y, theirs.y, rtol=1e-7, atol=1e-9)
    for a, b in zip(ours.t_events, theirs.t_events, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-9)
    for a, b in zip(ours.y_events, theirs.y_events, strict=True):
        assert a.shape == b.shape
