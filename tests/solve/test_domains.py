"""`domain`: equations that are defined in a part of the space of states only."""

import math
import warnings

import numpy as np
import pytest

from fastdyn import CompileWarning, Stepper, prepare, solve_ensemble, solve_ivp

EXPLICIT = ("RK23", "RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "ode45", "ode23")
IMPLICIT = ("Radau", "BDF", "LSODA", "Rodas5P")
LEFT = -3


def root(t, y, k):
    return [-2.0 * k * math.sqrt(y[0])]  # y = (1 - k t)^2, and y = 0 from t = 1 / k on


def positive(t, y, k=1.0):
    return y[0] > 0


@pytest.mark.parametrize("method", EXPLICIT + IMPLICIT)
def test_the_run_ends_where_the_domain_ends(method):
    tolerances = {"rtol": 1e-8, "atol": 1e-10}
    found = solve_ivp(root, (0, 5), [1.0], method, args=(1.0,), domain=positive, **tolerances)
    assert found.status == LEFT and not found.success
    assert "leaves `domain` at t = " in found.message
    assert found.t[-1] == pytest.approx(1.0, abs=1e-4)
    assert 0.0 < found.y.min() < 1e-9
    assert found.nfev < 2500


@pytest.mark.parametrize("method", EXPLICIT + IMPLICIT)
def test_the_border_is_found_to_rounding(method):
    """A border that the solution crosses at a slope: y = 1 - t, whose logarithm is taken."""

    def slope(t, y):
        return [-1.0 + 0.0 * math.log(y[0])]

    found = solve_ivp(slope, (0, 5), [1.0], method, domain=lambda t, y: y[0])
    assert found.status == LEFT
    assert found.t[-1] == pytest.approx(1.0, abs=1e-9 if method == "Radau" else 1e-12)
    assert found.y[0, -1] > 0.0


class Careful:
    """A function that is called in Python only, and fails outside of the domain."""

    def __init__(self):
        self.calls, self.states = 0, []

    def __call__(self, t, y):
        self.calls += 1
        self.states.append(float(y[0]))
        return [-math.sqrt(y[0])]


@pytest.mark.parametrize("method", ("RK45", "Vern9", "ode45", "Radau", "BDF", "Rodas5P"))
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_function_in_python_is_never_called_outside(method):
    fun = Careful()
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = solve_ivp(fun, (0, 5), [1.0], method, domain=lambda t, y: y[0] > 0)
    assert found.status == LEFT
    assert min(fun.states) > 0.0
    assert fun.calls < 1500


@pytest.mark.parametrize("method", ("RK45", "BDF"))
def test_a_domain_of_the_time_and_backwards(method):
    found = solve_ivp(
        lambda t, y: [1.0 / math.sqrt(t)], (1.0, -1.0), [2.0], method, domain=lambda t, y: t,
        rtol=1e-6,
    )  # fmt: skip
    assert found.status == LEFT
    assert 0.0 < found.t[-1] < 1e-10
    assert found.y[0, -1] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    "domain",
    (
        lambda t, y: y[0] > 0 and y[1] > 0,
        lambda t, y: np.all(y > 0),
        lambda t, y: (y[0] > 0) & (y[1] > 0),
        lambda t, y: min(y[0], y[1]),
        lambda t, y: np.min(y),
        lambda t, y: bool(y[0] > 0),
    ),
)
def test_what_a_domain_may_return(domain):
    def fun(t, y):
        return [-math.sqrt(y[0]), -y[1]]

    found = solve_ivp(fun, (0, 5), [1.0, 1.0], domain=domain)
    assert found.status == LEFT and found.t[-1] == pytest.approx(2.0, abs=1e-2)


def test_a_solution_inside_is_that_without_a_domain():
    def fun(t, y):
        return [y[1], -y[0]]

    for method in EXPLICIT + IMPLICIT:
        plain = solve_ivp(fun, (0, 10), [1.0, 0.0], method)
        found = solve_ivp(fun, (0, 10), [1.0, 0.0], method, domain=lambda t, y: 9 - y @ y)
        assert found.status == 0
        assert np.array_equal(found.t, plain.t) and np.array_equal(found.y, plain.y), method


def test_long_states():
    n = 200

    def drain(t, y):
        return -np.sqrt(y) * np.linspace(0.5, 1.0, n)

    found = solve_ivp(drain, (0, 5), np.ones(n), domain=lambda t, y: np.all(y > 0))
    assert found.status == LEFT and found.t[-1] == pytest.approx(2.0, abs=1e-2)


def test_events_before_the_border_and_times():
    def half(t, y, k):
        return y[0] - 0.25

    times = np.linspace(0.0, 2.0, 9)
    found = solve_ivp(
        root, (0, 2), [1.0], args=(1.0,), events=half, t_eval=times, domain=positive,
        dense_output=True, rtol=1e-8,
    )  # fmt: skip
    assert found.t_events[0] == pytest.approx([0.5], abs=1e-6)
    assert found.t.tolist() == times[:4].tolist() or found.t.tolist() == times[:5].tolist()
    assert found.sol(0.3)[0] == pytest.approx(0.49, abs=1e-6)


def test_prepared_solves_steppers_and_ensembles():
    args = (np.array([1.0, 2.0, 0.1]),)
    for method in ("RK45", "Rodas5P", "LSODA"):
        for simd in ("auto", False):
            many = solve_ensemble(
                root, (0, 5), [1.0], args=args, method=method, domain=positive, simd=simd
            )
            assert many.status.tolist() == [LEFT, LEFT, 0], (method, simd)
            assert many.t_end[:2] == pytest.approx([1.0, 0.5], abs=1e-2)
            assert "leaves `domain`" in many.message(0)
        solver = prepare(root, (0, 5), [1.0], method=method, args=(1.0,), domain=positive)
        assert solver().status == LEFT
        assert solver.many(args=args).status.tolist() == [LEFT, LEFT, 0]
        stepper = Stepper(root, 0.0, [1.0], 5.0, method=method, args=(1.0,), domain=positive)
        while stepper.status == "running":
            said = stepper.step()
        assert stepper.status == "failed" and "leaves `domain`" in said


def test_a_start_outside_in_an_ensemble():
    found = solve_ensemble(root, (0, 0.5), [[1.0], [-1.0]], args=(1.0,), domain=positive)
    assert found.status.tolist() == [0, -1]
    solver = prepare(root, (0, 0.5), [1.0], args=(1.0,), domain=positive)
    with pytest.raises(ValueError, match="outside of `domain`"):
        solver([-1.0])


def test_a_checkpoint(tmp_path):
    file = tmp_path / "run"
    first = solve_ivp(
        root, (0, 5), [1.0], args=(1.0,), domain=positive, checkpoint=file, max_steps=5
    )
    assert first.status == -1
    found = solve_ivp(root, (0, 5), [1.0], args=(1.0,), domain=positive, checkpoint=file)
    whole = solve_ivp(root, (0, 5), [1.0], args=(1.0,), domain=positive)
    assert np.array_equal(found.y, whole.y) and found.status == LEFT


def test_with_a_jacobian_and_vectorized():
    for jac in (lambda t, y: [[-0.5 / math.sqrt(y[0])]], "2-point", None):
        for method in ("Radau", "BDF", "Rodas5P"):
            given = {} if jac is None else {"jac": jac}
            found = solve_ivp(
                lambda t, y: [-math.sqrt(y[0])], (0, 5), [1.0], method, domain=positive, **given
            )
            assert found.status == LEFT, (jac, method)
            assert found.t[-1] == pytest.approx(2.0, abs=2e-2)
    found = solve_ivp(
        lambda t, y: -np.sqrt(y), (0, 5), [1.0], "BDF", vectorized=True, domain=positive
    )
    assert found.status == LEFT


def test_auto_ends_at_the_border_by_a_pair():
    for rtol in (1e-3, 1e-8, 1e-11):
        found = solve_ivp(root, (0, 5), [1.0], "auto", args=(1.0,), domain=positive, rtol=rtol)
        assert found.status == LEFT and found.method != "Taylor"


def raises(t, y):
    raise KeyError("no such state")


@pytest.mark.parametrize(
    ("options", "said"),
    (
        ({"domain": 3}, "`domain` must be a function"),
        ({"domain": lambda t, y: y > 0}, "must return True or False, or a number"),
        ({"domain": lambda t, y: "yes"}, "must return True or False, or a number"),
        ({"domain": lambda t, y: None}, "must return True or False, or a number"),
        ({"domain": raises}, "no such state"),
        ({"domain": lambda t, y: y[0] > 1}, "outside of `domain`"),
        ({"domain": lambda t, y: math.nan}, "outside of `domain`"),
        ({"domain": positive, "method": "Taylor"}, "Taylor does not take `domain`"),
        ({"domain": positive, "method": "RK4", "step": 0.1}, "RK4 does not take `domain`"),
        ({"domain": positive, "method": "Gauss4", "step": 0.1}, "Gauss4 does not take `domain`"),
        ({"domain": positive, "sensitivity": "y0"}, "`sensitivity` and `domain`"),
        ({"domain": positive, "y0": [1 + 0j, 1.0]}, "`domain`: for real states only"),
    ),
)
def test_refused(options, said):
    given = {"y0": [1.0, 1.0], **options}
    with pytest.raises((ValueError, TypeError, KeyError), match=said):
        solve_ivp(lambda t, y: -y, (0, 1), **given)


@pytest.mark.parametrize("width", [1e-2, 1e-5])
@pytest.mark.parametrize("method", ["RK45", "Vern9", "Radau"])
def test_a_wall_within_a_step_is_seen(method, width):
    def domain(t, y):
        return abs(y[0] - 7.123) - width

    found = solve_ivp(lambda t, y: [1.0], (0, 20), [0.0], method, domain=domain)
    assert found.status == LEFT
    assert found.t[-1] == pytest.approx(7.123 - width, abs=1e-8)


@pytest.mark.parametrize("method", ["RK45", "DOP853", "Vern9", "Radau", "BDF", "Rodas5P"])
def test_a_border_that_is_touched_within_a_step_is_seen(method):
    given = lambda t, y: [y[1], -y[0]], (0, 20), [1.0, 0.0], method
    found = solve_ivp(*given, domain=lambda t, y: y[0] + 1.0 - 1e-4, rtol=1e-4)
    assert found.status == LEFT and found.t[-1] == pytest.approx(math.pi, abs=0.05)
    apart = solve_ivp(*given, domain=lambda t, y: y[0] + 1.1, rtol=1e-4)
    assert apart.status == 0 and np.array_equal(apart.y, solve_ivp(*given, rtol=1e-4).y)


@pytest.mark.parametrize("kept", [{"domain": positive}, {"nonnegative": True}])
def test_a_warning_names_the_line_of_the_function(kept):
    def in_python(t, y, k):
        return [-float(repr(float(y[0])))]

    line = in_python.__code__.co_firstlineno
    with pytest.warns(CompileWarning, match=rf"in_python.*test_domains.py, line {line}\)"):
        solve_ivp(in_python, (0, 1), [1.0], args=(1.0,), **kept)
