"""Sensitivities of delay equations: by arguments, by delays, by the history; what is refused."""

from math import factorial

import numpy as np
import pytest

from fastdyn.delays import solve_dde

TENFOLD = 10.0  # largest error over the tolerance times the size of the solution


def terms(t, a, tau):
    """The terms of y' = -a y(t - tau), y = 1 before, and their derivatives by a and tau."""
    found = [(1.0, 0.0, 0.0)]
    k = 1
    while t - (k - 1) * tau > 0:
        u = t - (k - 1) * tau
        term = (-a) ** k * u**k / factorial(k)
        found.append((term, k * term / a, -(k - 1) * k * term / u))
        k += 1
    return np.array(found)


def decaying(t, y, past, a, tau):
    return [-a * past(t - tau)[0]]


@pytest.mark.parametrize("method", ["Vern7", "Vern9"])
@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11])
def test_derivatives_of_a_piecewise_polynomial(method, rtol):
    """y is linear in the history, so that the derivative by the history c is y / c."""
    a, tau, c = 1.3, 0.9, 2.0
    times = np.linspace(0.1, 6, 30)
    found = solve_dde(
        decaying, (0, 6), [c], method, times, args=(a, tau), rtol=rtol, atol=rtol,
        sensitivity=["a", "tau", "history"],
    )  # fmt: skip
    exact = np.array([terms(t, a, tau).sum(axis=0) for t in times]).T
    sizes = np.array([np.abs(terms(t, a, tau)).sum(axis=0).max() for t in times])
    for name, wanted in zip(("a", "tau"), c * exact[1:], strict=True):
        error = np.abs(found.sensitivity[name][0] - wanted)
        assert (error < 3 * TENFOLD * rtol * c * sizes).all(), (name, (error / sizes).max() / rtol)
    assert np.abs(found.sensitivity["history"][0, 0] - exact[0]).max() < TENFOLD * rtol
    assert np.abs(found.y[0] - c * exact[0]).max() < TENFOLD * rtol * c


def differences(solve, at, h):
    """The derivative of ``solve(x)`` by a formula of order 4, and a bound of its error."""

    def slope(h):
        return (
            8 * (solve(at + h) - solve(at - h)) - solve(at + 2 * h) + solve(at - 2 * h)
        ) / (12 * h)  # fmt: skip

    near = slope(h / 2)
    return near, np.abs(slope(h) - near) + 1e-9


def governed(t, y, past, gain, base, swing, late):
    """A delay of the state, and one of the time, which depend on arguments."""
    p = past(t - base - swing * np.tanh(y[0]) ** 2)
    q = past(t - late * (1.2 + np.sin(t)))
    return [y[1] - 0.3 * p[0], -gain * np.sin(q[0]) - 0.1 * p[1]]


def waving(t, gain, base, swing, late):
    return [0.5 * np.cos(gain * t), late * np.sin(t)]


def test_derivatives_by_delays_of_the_state_and_a_history_with_arguments():
    names = "gain", "base", "swing", "late"
    args = [1.1, 0.5, 0.4, 0.6]
    found = solve_dde(
        governed, (0, 5), waving, args=args, rtol=1e-9, atol=1e-10, sensitivity="args",
        t_eval=[1.0, 3.0, 5.0],
    )  # fmt: skip
    for i, name in enumerate(names):

        def solve(x, i=i):
            varied = [*args[:i], x, *args[i + 1 :]]
            return solve_dde(
                governed, (0, 5), waving, "Vern9", [1.0, 3.0, 5.0], args=varied, rtol=1e-12,
                atol=1e-13,
            ).y  # fmt: skip

        exact, bound = differences(solve, args[i], 4e-3)
        error = np.abs(found.sensitivity[name] - exact)
        assert (error < bound + 1e2 * 1e-9 * (1 + np.abs(exact))).all(), (name, error)


def nested(t, y, past, rate, tau):
    """The delay is itself a state of the past."""
    return [-rate * past(t - tau * (1.0 + past(t - tau)[0] ** 2))[0]]


def test_a_delay_that_the_past_decides():
    found = solve_dde(nested, (0, 4), [0.8], args=(1.0, 0.7), rtol=1e-9, atol=1e-10,
                      sensitivity=["tau", "history"], t_eval=[4.0])  # fmt: skip
    for name, at, solve in (
        ("tau", 0.7, lambda x: _end(0.8, x)), ("history", 0.8, lambda x: _end(x, 0.7))
    ):  # fmt: skip
        exact, bound = differences(solve, at, 4e-3)
        assert abs(found.sensitivity[name].ravel()[-1] - exact) < bound + 1e-7


def _end(start, tau):
    return solve_dde(
        nested, (0, 4), [start], "Vern9", args=(1.0, tau), rtol=1e-12, atol=1e-13
    ).y[0, -1]  # fmt: skip


def test_more_components_than_are_written_out():
    """A ring of five cells, each following its neighbour: 5 + 10 numbers, and 5 + 25."""

    def ring(t, y, past, rate, tau):
        p = past(t - tau)
        return [rate * np.tanh(p[i - 1]) - y[i] for i in range(5)]

    start = np.linspace(0.2, 1.0, 5)

    def end(rate, tau, start=start):
        return solve_dde(
            ring, (0, 3), start, "Vern9", args=(rate, tau), rtol=1e-12, atol=1e-13
        ).y[:, -1]  # fmt: skip

    found = solve_dde(ring, (0, 3), start, args=(1.5, 0.7), rtol=1e-9, atol=1e-10,
                      sensitivity=["args", "history"])  # fmt: skip
    by_rate, bound = differences(lambda x: end(x, 0.7), 1.5, 4e-3)
    assert (np.abs(found.sensitivity["rate"][:, -1] - by_rate) < bound + 1e-7).all()
    by_tau, bound = differences(lambda x: end(1.5, x), 0.7, 4e-3)
    assert (np.abs(found.sensitivity["tau"][:, -1] - by_tau) < bound + 1e-7).all()
    for k in range(5):
        by_start, bound = differences(
            lambda x, k=k: end(1.5, 0.7, np.r_[start[:k], x, start[k + 1 :]]), start[k], 4e-3
        )
        error = np.abs(found.sensitivity["history"][:, k, -1] - by_start)
        assert (error < bound + 1e-7).all()


def test_events_have_states_and_sensitivities_of_the_interpolant():
    def low(t, y, past, a, tau):
        return y[0]

    found = solve_dde(
        decaying, (0, 4), [1.0], args=(1.3, 0.9), events=low, sensitivity="tau", rtol=1e-8,
        atol=1e-10, dense_output=True,
    )  # fmt: skip
    assert len(found.t_events[0]) > 0 and found.y_events[0].shape == (len(found.t_events[0]), 1)
    np.testing.assert_allclose(found.sol(found.t), found.y, rtol=0, atol=1e-14)


def jumping(t, y, past, tau):
    return [-past(t - tau)[0] if y[0] > 0 else 1.0]


def reading(t, y, past, rate):
    return [-rate * past.derivative(t - 1.0)[0]]


@pytest.mark.parametrize(
    ("fun", "history", "args", "more", "said"),
    [
        (decaying, [1.0], (1.0, 1.0), {"sensitivity": "y0"}, "name 'history' for a constant one"),
        (decaying, [1.0], (1.0, 1.0), {"sensitivity": "b"}, "choose from 'history', 'args', 'a'"),
        (decaying, np.cos, (1.0, 1.0), {"sensitivity": "history"}, "is for a constant history"),
        (decaying, [1.0], (1.0, 1.0), {"sensitivity": "a", "jumps": [-0.5]}, "and `jumps` do not"),
        (
            decaying, [1.0], (1.0, 1.0),
            {"sensitivity": "a", "at": [0.5], "on_event": lambda t, y, past, *args: 2 * y},
            "and `on_event` do not",
        ),
        (decaying, [1.0], (1.0, 1.0), {"sensitivity": "tau", "method": "Tsit5"}, "from auto, Vern"),
        (
            decaying, lambda t: [1.0 if t > -0.5 else 2.0], (1.0, 1.0), {"sensitivity": "tau"},
            "needs a smooth history",
        ),
        (jumping, [1.0], (1.0,), {"sensitivity": "tau"}, "where `fun` decides by the state"),
        (reading, [1.0], (0.5,), {"sensitivity": "rate"}, "not computed for neutral"),
    ],
)  # fmt: skip
def test_what_is_not_computed_is_refused(fun, history, args, more, said):
    with pytest.raises(ValueError, match=said):
        solve_dde(fun, (0, 2), history, args=args, **more)


def test_an_earlier_result_has_no_derivatives_as_a_history():
    first = solve_dde(decaying, (0, 1), [1.0], args=(1.0, 1.0), dense_output=True)
    with pytest.raises(ValueError, match="an earlier result does not know"):
        solve_dde(decaying, (1, 2), first, args=(1.0, 1.0), sensitivity="tau")


def test_wrong_derivatives_are_found_along_the_solution(monkeypatch):
    """Python moves the past along the directions, too, so that differences show S of the past."""

    def wrong(graph, traced, columns, n):
        outputs = right(graph, traced, columns, n)
        return [*outputs[:n], *(graph.mul(graph.const(1.1), node) for node in outputs[n:])]

    from fastdyn.compile.derivatives import sensitivities

    right = sensitivities.outputs_of_past
    monkeypatch.setattr(sensitivities, "outputs_of_past", wrong)

    def fun(t, y, past, rate):
        return [-rate * past(t - 1.0)[0] * (1.0 + 0.1 * y[0])]

    with pytest.raises(ValueError, match="derivative along a vector"):
        solve_dde(fun, (0, 4), [1.0], args=(0.7,), sensitivity=["rate", "history"])


def level(t, y, past, a, tau):
    return y[0] - 0.3 * a


def meets(t, y, past, a, tau):
    return y[0] - 0.5 * past(t - 1.0)[0]


@pytest.mark.parametrize("terminal", [False, True])
def test_times_of_events_have_derivatives(terminal):
    """Beside differences; None for an event whose function reads the past, and moves with it."""
    tight = {"rtol": 1e-11, "atol": 1e-12}

    def crosses(t, y, past, a, tau):
        return level(t, y, past, a, tau)

    crosses.terminal = terminal
    events = [crosses, meets]
    given = decaying, (0, 6)
    found = solve_dde(
        *given, [1.0], args=(1.1, 0.7), events=events, sensitivity=["a", "tau", "history"], **tight
    )
    own, late = found.event_sensitivity
    assert late is None and len(found.t_events[1]) > 0

    def at(a, tau, start):
        return solve_dde(*given, [start], args=(a, tau), events=events, **tight).t_events[0]

    values = [1.1, 0.7, 1.0]
    for i, name in enumerate(("a", "tau", "history")):

        def solve(x, i=i):
            return at(*[*values[:i], x, *values[i + 1 :]])

        wanted, error = differences(solve, values[i], 1e-3)
        assert (np.abs(own.t[name] - wanted) < error + 1e-7).all(), name
    assert np.abs(own.y["a"][0] - 0.3).max() < 1e-9  # y is 0.3 a there
