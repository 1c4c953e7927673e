"""Repeated calls of `solve_ivp` with `domain`, `nonnegative`, `jac` and `error_estimate`.

What these options hold is read at each call, as `fun` is.
"""

import math

import numpy as np
import pytest
import scipy.sparse

from fastdyn import prepare, solve_ivp
from fastdyn.run import again
from fastdyn.run.functions.compared import MOST_SEARCHES
from fastdyn.solve.error_estimate import Estimated
from fastdyn.solve.keys import hashable, rest_of
from support.repeated import CALLS, assert_first, is_plain, plain, warm, was_ready

SPAN, START = (0.0, 1.0), [1.0, 0.1]
IMPLICIT = ("Radau", "BDF", "LSODA", "Rodas5P")

pytestmark = [
    pytest.mark.usefixtures("nothing_known"),
    pytest.mark.filterwarnings("ignore:`jac` is not the Jacobian"),
]


def driven(t, y, k):
    return [y[1], -k * y[0]]


def slope(t, y, k):
    return [[0.0, 1.0], [-k, 0.0]]


def within(t, y, k):
    return y[1] > -10.0 * k


def falls(t, y, k):
    return y[0] - 0.8


def turned(t, y, k):
    return [y[0], -0.5 * y[1]]


def shrunk(t, y, k):
    return [0.9 * y[0], y[1]]


MATRIX = np.array([[0.0, 1.0], [-2.0, 0.0]])
OPTIONS = {
    "nonnegative": {"nonnegative": [0]},
    "all": {"nonnegative": True, "dense_output": True},
    "bools": {"nonnegative": np.array([True, False])},
    "actions": {"nonnegative": [0], "events": falls, "on_event": [turned, shrunk], "every": 0.3},
    "domain": {"domain": within},
    "a domain without": {"domain": None},
    "projected": {"domain": within, "project": shrunk, "events": falls},
    "columns": {"domain": within, "vectorized": True},
    "implicit": {"domain": within, "nonnegative": [0], "method": "Radau", "t_eval": [0.5, 1.0]},
    "kept with jac": {"domain": within, "nonnegative": [0], "method": "BDF", "jac": slope},
    "kept with a matrix": {"nonnegative": [0], "method": "Rodas5P", "jac": MATRIX},
    "jac": {"jac": slope, "method": "Radau"},
    "jac and events": {"jac": slope, "method": "BDF", "events": [falls, falls]},
    "jac of LSODA": {"jac": slope, "method": "LSODA", "on_event": turned, "events": falls},
    "jac and a mass": {"jac": slope, "mass": np.diag([2.0, 0.5]), "method": "Rodas5P"},
    "matrix": {"jac": MATRIX, "method": "Radau", "events": falls},
    "rows": {"jac": MATRIX.tolist(), "method": "BDF"},
    "differences": {"jac": "2-point", "method": "Radau"},
    "derivatives": {"jac": slope, "method": "Radau", "sensitivity": "k"},
    "the choice": {"domain": within, "method": "auto"},
    "tolerances": {"rtol": np.array([1e-5, 1e-6]), "atol": [1e-8, 1e-9]},
    "tolerances of a series": {"rtol": [1e-5, 1e-6], "atol": [1e-8, 1e-9], "method": "Taylor"},
    "tolerances and derivatives": {"rtol": [1e-5, 1e-6], "sensitivity": "k"},
    "diagonals": {"lband": 1, "uband": 1, "min_step": 1e-9, "method": "LSODA"},
}


@pytest.mark.parametrize("name", OPTIONS)
def test_calls_are_plain(name):
    given = {"args": (2.0,), **OPTIONS[name]}
    for _ in range(MOST_SEARCHES // CALLS + 1):  # for sides of decisions that no state shows
        warm(solve_ivp, driven, SPAN, START, **given)
    assert is_plain(solve_ivp, driven, SPAN, START, **given)
    for scale in (1.0, 0.9, 1.1):
        call = given | {"args": (2.0 * scale,)}
        start = [scale, 0.1]
        found = solve_ivp(driven, SPAN, start, **call)
        assert_first(found, plain(driven, SPAN, start, **call))


def told(by, *given, **named):
    """The result of a solve, or its error."""
    try:
        return by(*given, **named)
    except (TypeError, ValueError) as error:
        return {"error": f"{type(error).__name__}: {error}"}


class Calls:
    """Calls of `solve_ivp` beside the same ones by the long way; `n_ready` were plain."""

    def __init__(self):
        self.n_ready = 0

    def __call__(self, fun, span, y0, **given):
        """The result of a call, or its error, which is that of a first one."""
        found = told(solve_ivp, fun, span, y0, **given)
        self.n_ready += was_ready(found)
        expected = told(plain, fun, span, y0, **given)
        if "error" in found or "error" in expected:
            assert found == expected
        else:
            assert_first(found, expected)
        return found


@pytest.fixture
def calls():
    return Calls()


@pytest.mark.parametrize("method", ["RK45", "Vern7", "Radau"])
def test_the_border_is_that_of_each_call(calls, method):
    def of(rate, low, level):
        def fun(t, y):
            return [-rate * np.sqrt(y[0]), -y[1]]

        def domain(t, y):
            return y[1] > low

        def event(t, y):
            return y[0] - level

        def jac(t, y):
            return [[-0.5 * rate / max(np.sqrt(y[0]), 1e-9), 0.0], [0.0, -1.0]]

        return fun, domain, event, jac

    n_left = n_refused = 0
    for i in range(14):
        fun, domain, event, jac = of(1.0 + 0.25 * (i % 5), 0.5 - 0.1 * (i % 4), 0.1 + i / 40)
        given = {"method": method, "nonnegative": [0], "domain": domain, "events": event}
        given["t_eval"] = [0.5, 1.0 + 0.1 * (i % 3)] if i % 2 else None
        if method == "Radau" and i % 3:
            given["jac"] = jac
        for y0 in (
            [0.1 * (i % 3), 1.0],
            [0.5, 0.9 + 0.1 * i],
            [-0.5, 1.0],
            [1.0, 0.0],
            [5.0 + i, 9.0],
        ):
            found = calls(fun, (0.0, 2.0), y0, **given)
            n_left += found.get("status") == -3
            n_refused += "error" in found
    assert n_left >= 10 and n_refused >= 28 and calls.n_ready > 9


def test_the_border_may_be_of_another_kind(calls):
    """A limit of another type, an array in the place of a number: as in a first call."""
    for limit in [-2.0] * CALLS + [-2, np.float64(-2.5), -3.0, np.array([-2.0]), None, "a", -2.0]:

        def domain(t, y, k, limit=limit):
            return y[1] > limit

        def closed(t, y, k, own=limit):
            return y[1] > own

        calls(driven, SPAN, START, args=(2.0,), domain=domain)
        calls(driven, SPAN, START, args=(2.0,), domain=closed, nonnegative=[0])


def test_components_that_change_in_place(calls):
    def fun(t, y):
        return [-1.0, -2.0]

    indices, bools, rows = np.array([0]), np.array([True, False]), [0]
    seen = set()
    for i in range(3 * CALLS):
        indices[0] = rows[0] = i % 2
        bools[:] = [i % 2, 1 - i % 2]
        for given in (indices, bools, rows, [*bools.tolist()]):
            found = calls(fun, SPAN, [0.5, 0.5], nonnegative=given)
            seen.add(tuple(found.y[:, -1] == 0.0))
    assert seen == {(True, False), (False, True)} and calls.n_ready > CALLS


@pytest.mark.parametrize("form", [tuple, list, np.array])
def test_bools_are_no_indices(calls, form):
    """True equals 1, and so does a hash of the two."""

    def fun(t, y):
        return [-1.0, -2.0]

    for _ in range(CALLS):
        for value, cut in (([True, False], [True, False]), ([1, 0], [True, True])):
            found = calls(fun, SPAN, [0.5, 0.5], nonnegative=form(value))
            assert (found.y[:, -1] == 0.0).tolist() == cut
    for _ in range(CALLS):
        for value, cut in ((True, [True, True]), (1, [False, True]), (False, [False, False])):
            found = calls(fun, SPAN, [0.5, 0.5], nonnegative=value)
            assert (found.y[:, -1] == 0.0).tolist() == cut
    assert calls.n_ready > CALLS


def test_starts_of_a_prepared_solver():
    """Each one outside is refused, on whichever way the solver would go."""
    kept = {"domain": within, "nonnegative": [0], "args": (2.0,)}
    solver = prepare(driven, SPAN, START, **kept)
    for i in range(2 * CALLS):
        span = {"t_span": (0.0, 1.0 + 0.1 * (i % 3))} if i >= CALLS else {}
        assert_first(solver(**span), plain(driven, span.get("t_span", SPAN), START, **kept))
        with pytest.raises(ValueError, match="`nonnegative` lists component 0"):
            solver([-0.5, 0.1], **span)
        with pytest.raises(ValueError, match="outside of `domain`"):
            solver([1.0, -20.0], **span)
        assert solver([1.0, -20.0], (2.5,), **span).success


def of_rate(rate, off):
    def fun(t, y):
        return [-rate * (y[0] - math.cos(t)), -y[1]]

    def jac(t, y):
        return [[off - rate, 0.0], [0.0, -1.0]]

    return fun, jac


@pytest.mark.parametrize("method", IMPLICIT)
def test_the_jacobian_is_that_of_each_call(calls, method):
    """Each Jacobian that is off gives other steps."""
    given = {"method": method, "rtol": 1e-6, "first_step": 0.01}
    counts = set()
    for i in range(2 * CALLS):
        fun, jac = of_rate(200.0 + 50.0 * (i % 3), 190.0 * (i % 4 == 3))
        found = calls(fun, (0.0, 3.0), START, jac=jac, **given)
        counts.add((i % 3, found.nfev, found.njev, found.nlu))
    assert len(counts) > 3 and calls.n_ready > 9


FACTOR, BY_ROWS = 200.0, False


def of_globals(t, y):
    if BY_ROWS:
        return np.array([[-FACTOR, 0.0], [0.0, -1.0]])
    return [[-FACTOR, 0.0], [0.0, -1.0]]


@pytest.mark.parametrize("method", IMPLICIT)
def test_a_jacobian_reads_globals_that_change(calls, method, monkeypatch):
    fun, _ = of_rate(200.0, 0.0)
    steps = set()
    for i in range(2 * CALLS):
        monkeypatch.setitem(globals(), "FACTOR", (200.0, 200.0, 20.0, 150)[i % 4])
        monkeypatch.setitem(globals(), "BY_ROWS", i % 5 == 4)
        found = calls(fun, (0.0, 3.0), START, method=method, rtol=1e-6, jac=of_globals)
        steps.add((found.nfev, found.nlu))
    assert len(steps) > 1 and calls.n_ready > 3


class Number:
    """A number that changes, while its hash stays."""

    def __init__(self, value):
        self.value = value

    def __float__(self):
        return float(self.value)


def rows_of(matrix):
    return [[Number(value) for value in row] for row in matrix]


@pytest.mark.parametrize("form", [np.array, np.ndarray.tolist, scipy.sparse.csr_array, rows_of])
def test_a_matrix_that_changes_in_place(calls, form):
    given = form(MATRIX.copy())
    steps = set()
    for i in range(3 * CALLS):
        value = (-2.0, -2.0, 90.0)[i % 3]
        if form is rows_of:
            given[1][0].value = value
        elif form is np.ndarray.tolist:
            given[1][0] = value
        else:
            given[1, 0] = value
        call = {"method": "Radau", "jac": given, "args": (2.0,), "rtol": 1e-6}
        steps.add(calls(driven, (0.0, 3.0), START, **call).nfev)
    assert len(steps) > 1
    assert (calls.n_ready > 9) == (form in (np.array, np.ndarray.tolist))


def test_a_jacobian_that_is_refused(calls):
    """A matrix of another size, a number in its place: with the words of a first call."""
    wrong = [lambda t, y, k: [[0.0, 1.0]], 3.0, [[1.0]], [[0.0, 1.0], [2.0]], "3-point"]
    for jac in [slope] * CALLS + wrong + [slope]:
        calls(driven, SPAN, START, args=(2.0,), method="Radau", jac=jac)


def test_derivatives_with_a_jacobian_and_events(calls):
    """The derivatives take no `jac`; functions of the state alone become those of a longer one."""
    given = {"method": "Radau", "jac": slope, "events": [falls, within], "sensitivity": "k"}
    solver = prepare(driven, SPAN, START, args=(2.0,), **given)
    for k in [2.0] * CALLS + [1.0, 3.0, 2.5]:
        found = calls(driven, SPAN, START, args=(k,), **given)
        assert_first(solver(args=(k,)), found)


ESTIMATES = {
    "steps": {},
    "times": {"t_eval": [0.0, 0.3, 0.7]},
    "one time": {"t_eval": [0.0]},
    "dense": {"dense_output": True, "atol": [1e-7, 1e-6]},
    "constant steps": {"method": "RK4", "step": 0.05},
    "series": {"method": "Taylor", "rtol": 1e-8},
    "implicit": {"method": "BDF", "jac": slope},
    "derivatives": {"sensitivity": "k", "events": falls},
    "kept": {"domain": within, "nonnegative": [0]},
    "projected": {"project": shrunk, "breakpoints": [0.4]},
    "the choice": {"method": "auto", "events": falls},
    "left out": {"first_step": 0.01, "max_steps": 100, "every": 0.3},
}


@pytest.mark.parametrize("name", ESTIMATES)
def test_estimates_are_those_of_a_first_call(calls, name):
    given = ESTIMATES[name] | {"error_estimate": True, "args": (2.0,)}
    warm(solve_ivp, driven, SPAN, START, **given)
    kinds = [entry.value for entry in again.calls.entries.values()]
    assert any(isinstance(kind, Estimated) for kind in kinds) and any(kind.idle for kind in kinds)
    for i in range(12):
        call = given | {"args": (2.0 + i % 3,)}
        start = np.array([1.0, 0.1 * (i % 4)])
        span = (0.1 * (i % 2), 1.0)
        if "t_eval" in call:
            call["t_eval"] = [span[0] + t for t in call["t_eval"][: 1 + i % 3]]
        found = calls(driven, span, start, **call)
        assert "error_estimate" in found
        without = {name: value for name, value in call.items() if name != "error_estimate"}
        assert "error_estimate" not in solve_ivp(driven, span, start, **without)
        assert "error_estimate" not in solve_ivp(driven, span, start, error_estimate=0, **without)


def test_an_estimate_takes_the_calls_own_options(calls):
    """Lists that change in place, functions with closures: both passes see the present ones."""
    rtol, times = [1e-5, 1e-5], [0.4]
    for i in range(3 * CALLS):
        rtol[1] = 10.0 ** (-4 - i % 3)
        times[0] = 0.3 + 0.1 * (i % 2)

        def project(t, y, by=1.0 - 1e-3 * (i % 4)):
            return [by * y[0], y[1]]

        def fun(t, y, k, low=0.2 * (i % 3)):
            return [y[1], -k * y[0] + low]

        def ends(t, y, k, at=0.6 + 0.1 * (i % 5)):
            return y[0] - at

        ends.terminal = True
        given = {"rtol": [*rtol] if i % 2 else rtol, "breakpoints": times, "events": ends}
        given["project"] = lambda t, y, k, own=project: own(t, y)
        calls(fun, (0.0, 2.0), START, args=(2.0,), error_estimate=True, **given)


def test_an_estimate_of_a_complex_state(calls):
    def fun(t, y, k):
        return [1j * k * y[0]]

    for i in range(2 * CALLS):
        given = {"args": (1.0 + i % 3,), "error_estimate": True}
        calls(fun, SPAN, [1.0 + 0.5j], **given)
        calls(fun, SPAN, [1.0], **given | {"args": (0.5j,)})


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_functions_in_python_are_called_as_often_as_in_a_first_call():
    """Each effect of the functions comes once a call; also where a call cannot be plain."""
    called = []

    def counted(t, y, k):
        called.append(t)
        return [-k * math.sqrt(y[0])]

    def domain(t, y, k):
        called.append(t)
        return y[0] > 0.0

    for given in ({"error_estimate": True}, {"domain": domain}, {"nonnegative": True}):
        warm(solve_ivp, counted, SPAN, [1.0], args=(1.0,), **given)
        for i in range(2 * CALLS):
            values = {"y0": [1.0 + i**2], "args": (1.0 if i % 2 else 1,)}
            counts = []
            for by in (solve_ivp, plain):
                called.clear()
                by(counted, SPAN, **values, **given)
                counts.append(len(called))
            assert counts[0] == counts[1]


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_each_jacobian_of_a_function_in_python_is_checked():
    def fun(t, y):
        return [-float(repr(float(y[0])))]

    for _ in range(2 * CALLS):
        with pytest.warns(UserWarning, match="`jac` is not the Jacobian"):
            solve_ivp(
                fun, SPAN, [1.0], "Radau", jac=lambda t, y: [[float(repr(3.0 + float(y[0])))]]
            )


def test_zeros_of_a_matrix_have_signs():
    keys = set()
    for zero in (0.0, -0.0):
        rows = [[zero, 1.0], [-2.0, 0.0]]
        for given in (rows, tuple(map(tuple, rows))):
            keys.add(hashable(rest_of(None, False, None, False, {"jac": given})[0]))
    assert len(keys) == 2


@pytest.mark.parametrize("method", ["RK45", "Vern7"])
@pytest.mark.parametrize("times", [[1, 2], np.array([0.5, 1.5], "f4")], ids=["whole", "short"])
def test_the_vjp_at_times_of_other_types(method, times):
    given = {"t_eval": times, "args": (2.0,), "adjoint": "y0", "compile": "shared"}
    first = plain(driven, (0.0, 2.0), START, method, **given)
    for _ in range(2 * CALLS):
        assert_first(solve_ivp(driven, (0.0, 2.0), START, method, **given), first)


def test_no_events_are_an_empty_list_with_derivatives():
    given = {"events": [], "args": (2.0,), "sensitivity": "k", "compile": "shared"}
    first = plain(driven, SPAN, START, **given)
    assert first.t_events == []
    for _ in range(CALLS):
        assert_first(solve_ivp(driven, SPAN, START, **given), first)
