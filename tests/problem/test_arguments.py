"""Arguments: SciPy's exceptions where SciPy raises; the sentences are rows of `tests/slips`."""

import warnings

import numpy as np
import pytest
import scipy.integrate
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import fastdyn
from support.motions import satellite

EPS = float(np.finfo(float).eps)


def linear(t, y):
    return -0.5 * y + 0.2 * y[::-1] + 0.1 * t


def late_nan(t, y):
    return [np.nan if t > 0.5 else 1.0]


def nan_in_second(t, y):
    return [1.0, np.nan * y[0]]


def square(t, y):
    return y**2


def base(**changes):
    return {"fun": linear, "t_span": (0, 1), "y0": [1.0, 2.0]} | changes


def event_with(**attributes):
    def event(t, y):
        return y[0]

    vars(event).update(attributes)
    return event


AS_SCIPY = {
    "t_span": [(0, 1, 2), (0,), 3.0, ("a", 1), (0, 1j)],
    "y0": [1.0, [[1.0]], [np.nan, 1.0], [1.0, np.inf]],
    "t_eval": [[[0.5]], [0.5, 2.0], [-0.5], [0.5, 0.2], [0.5, 0.5]],
    "max_step": [0, -1.0],
    "first_step": [0, -1, 2],
    "atol": [-1, [1e-6, -1], [1e-6] * 3],
    "args": [3, (1, 2)],
    "fun": [None],
    "events": [event_with(terminal=x) for x in (1.5, -1, np.nan)] + [event_with(direction="up")],
}


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("name", AS_SCIPY)
def test_errors_are_scipys(name):
    for value in AS_SCIPY[name]:
        with pytest.raises(Exception) as theirs:
            scipy.integrate.solve_ivp(**base(**{name: value}))
        with pytest.raises(Exception) as ours:
            fastdyn.solve_ivp(**base(**{name: value}))
        assert ours.type is theirs.type
        assert str(theirs.value).split() == str(ours.value).split()  # the same but for blanks


@pytest.mark.parametrize("method", ["a method", 3, dict])
def test_an_unknown_method_is_scipys_exception_and_a_list_of_ours(method):
    with pytest.raises(ValueError, match="`method` must be one of"):
        scipy.integrate.solve_ivp(**base(method=method))
    with pytest.raises(ValueError, match=r"`method` must be one of auto, RK23, .*OdeSolver class"):
        fastdyn.solve_ivp(**base(method=method))


@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853", "Vern9", "ode45", "RK4", "Radau"])
def test_nan_at_the_start_is_a_failure_that_says_so(method):
    options = {"step": 0.1} if method == "RK4" else {}
    r = fastdyn.solve_ivp(nan_in_second, (0, 1), [1.0, 1.0], method, **options)
    assert (r.status, r.success, r.t[-1]) == (-1, False, 0)
    assert "nan or inf at the start, t = 0" in r.message


def to_one(t, y):
    return [1.0 if y[0] < 1.0 else -1.0]


def test_failures_say_why_and_where():
    r = fastdyn.solve_ivp(late_nan, (0, 1), [0.0])
    assert r.status == -1 and "returns nan or inf at all times after t = 0.5" in r.message
    r = fastdyn.solve_ivp(square, (0, 2), [1.0], rtol=1e-8)
    assert r.status == -1 and f"blows up at t = {r.t[-1]:.10g}" in r.message
    r = fastdyn.solve_ivp(to_one, (0, 3), [0.0], "Radau", rtol=1e-12, atol=1e-17)
    assert r.status == -1 and "a jump there" in r.message and "grown" not in r.message
    assert abs(r.t[-1] - 1) < 1e-8 * r.n_accepted
    r = fastdyn.solve_ivp(square, (0, 2), [1.0], "RK4", step=0.01)
    assert r.status == -1 and f"not finite after t = {r.t[-1]:.10g}" in r.message
    r = fastdyn.solve_ivp(linear, (0, 10), [1.0, 2.0], max_steps=3)
    assert (r.status, r.n_accepted, len(r.t)) == (-1, 3, 4)
    share = f"{r.t[-1] / 10:.1%} of the way"
    assert f"`max_steps=3` was reached at t = {r.t[-1]:.10g}, {share}" in r.message


def test_the_satellite_that_falls_into_the_planet_is_a_failure():
    """At the default tolerance the computed orbit spirals in, and SciPy stops at the same time."""
    ours, theirs = (
        solve(satellite, (0, 100), [1, 0, 0, 1], rtol=1e-3)
        for solve in (fastdyn.solve_ivp, scipy.integrate.solve_ivp)
    )
    assert ours.status == theirs.status == -1 and ours.t[-1] < 90
    assert ours.message.startswith(theirs.message) and "rtol = 1.0e-03 is too loose" in ours.message


@pytest.mark.parametrize("given_", [{"rtol": 1e-16}, {"foo": 1}, {"rtol": [1e-3, 0.0], "foo": 1}])
def test_warnings_are_scipys_at_the_callers_line(given_):
    seen = []
    for solve in (scipy.integrate.solve_ivp, fastdyn.solve_ivp):
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            solve(linear, (0, 1), [1.0, 2.0], **given_)
        seen.append(sorted(str(w.message) for w in caught))
    assert seen[0] == seen[1]
    assert {w.filename for w in caught} == {__file__}


def test_an_adaptive_option_has_no_effect_on_constant_steps():
    with pytest.warns(UserWarning, match="no effect.*`rtol`"):
        fastdyn.solve_ivp(linear, (0, 1), [1.0, 2.0], "RK4", step=0.1, rtol=1e-6)


numbers = st.floats(-3, 3).map(lambda x: round(x, 3))


def counts(r):
    return r.status, r.nfev, len(r.t), list(map(len, r.t_events)), r.sol is None


def values(r, t):
    """All that a run computes: outputs, events, dense output at t."""
    parts = [r.t, np.ravel(r.y), *r.t_events, *map(np.ravel, r.y_events)]
    return np.concatenate(parts if r.sol is None else [*parts, r.sol(t).ravel()])


@pytest.mark.hunt
@settings(max_examples=100, deadline=None, derandomize=True)
@given(
    y0=st.lists(numbers, min_size=1, max_size=20),
    start=numbers,
    length=st.floats(0.1, 5).flatmap(lambda x: st.sampled_from([x, -x])),
    points=st.one_of(st.none(), st.lists(st.floats(0, 1), max_size=8, unique=True)),
    level=numbers,
    attributes=st.sampled_from([{}, {"terminal": True}, {"terminal": 2}, {"direction": -1}]),
    options=st.fixed_dictionaries(
        {
            "method": st.sampled_from(["RK23", "RK45", "DOP853"]),
            "rtol": st.sampled_from([1e-2, 1e-4, 1e-9]),
            "dense_output": st.booleans(),
        },
        optional={"max_step": st.just(0.2), "first_step": st.just(0.01), "atol": st.just(1e-9)},
    ),
)
def test_any_valid_call_gives_scipys_answer(y0, start, length, points, level, attributes, options):
    """As near as SciPy is to itself when the initial state changes in its last digits."""

    def crossing(t, y, level=level):
        return y[0] - level

    vars(crossing).update(attributes)
    t_span, y0 = (start, start + length), np.array(y0)
    if "atol" in options:
        options["atol"] = options["atol"] * np.arange(1, len(y0) + 1)
    if points is not None:
        t_eval = np.unique(np.clip(start + length * np.array(points), *sorted(t_span)))
        options["t_eval"] = t_eval if length > 0 else t_eval[::-1]
    given_ = options | {"events": crossing}
    theirs, *nearby = (
        scipy.integrate.solve_ivp(linear, t_span, y0 + k * EPS, **given_) for k in (0, -2, 2, 4)
    )
    assume(all(counts(r) == counts(theirs) for r in nearby))
    ours = fastdyn.solve_ivp(linear, t_span, y0, **given_)
    assert counts(ours) == counts(theirs)
    t = np.linspace(theirs.sol.t_min, theirs.sol.t_max, 11) if theirs.sol else None
    expected = values(theirs, t)
    spread = max(np.abs(values(r, t) - expected).max(initial=0) for r in nearby)
    allowed = spread + EPS * np.abs(expected).max(initial=10)
    assert np.abs(values(ours, t) - expected).max(initial=0) <= 20 * allowed
