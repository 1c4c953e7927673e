"""What goes wrong in one trajectory is said of that one, as a single run would say it."""

import math
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

from fastdyn import prepare, solve_ensemble, solve_ivp
from fastdyn.ensemble import Fold

K = np.array([1.0, 2.0, 3.0, 4.0])


def by_root(t, y, k):
    return [-k / math.sqrt(y[0])]


def by_hand(t, y, k):
    if y[0] < 1.0 / k:
        raise ValueError(f"it is {y[0] < 0.2}, below 1 / {k}")
    return [-1.0]


def by_key(t, y, k):
    return [{"a": -1.0}["b" if y[0] < 1.0 / k else "a"]]


def by_division(t, y, k):
    return [-1.0 / (k - 2.0)]


def by_growth(t, y, k):
    return [math.exp(y[0] * 300.0 * k)]


@pytest.mark.few
@pytest.mark.parametrize("simd", ["auto", False])
@pytest.mark.parametrize("fun", [by_root, by_hand, by_key, by_division, by_growth])
@pytest.mark.parametrize("method", ["RK45", "Vern7", "RK4", "Rodas5P"])
def test_exceptions_are_those_of_single_runs(fun, method, simd):
    options = {"step": 0.01} if method == "RK4" else {}
    found = solve_ensemble(fun, (0, 2), [1.0], (K,), method, simd=simd, **options)
    for i, k in enumerate(K):
        said = None
        try:
            one = solve_ivp(fun, (0, 2), [1.0], method, args=(k,), **options)
        except Exception as error:
            said = f"Trajectory {i}: a function raised {type(error).__name__}: {error}"
        if said is None:
            assert found.status[i] == one.status, found.message(i)
        else:
            assert found.status[i] == -1 and said in found.message(i)
            assert found[i].message == found.message(i)


def handled(t, y, k):
    try:
        return [math.sqrt(k - y[0])]
    except ValueError:
        return [-1.0]


def handled_index(t, y, k):
    try:
        return [(1.0, 2.0, 3.0)[int(y[0])]]
    except IndexError:
        return [-k]


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("fun", [handled, handled_index])
@pytest.mark.parametrize("simd", ["auto", False])
def test_handlers_are_those_of_single_runs(fun, simd):
    found = solve_ensemble(fun, (0, 5), [0.0], (K,), simd=simd)
    single = [solve_ivp(fun, (0, 5), [0.0], args=(k,)) for k in K]
    assert found.success.all()
    assert np.allclose(found.y_end[:, 0], [one.y[0, -1] for one in single], rtol=1e-9)


@pytest.mark.parametrize("simd", ["auto", False])
@pytest.mark.parametrize("method", ["RK45", "Taylor", "VelocityVerlet", "Radau"])
def test_a_start_that_is_not_finite_fails_alone(method, simd):
    y0 = np.array([[np.nan, 0.0], [1.0, 0.0], [1.0, np.inf], [3.0, 1.0]])
    options = {"step": 0.01} if method == "VelocityVerlet" else {}

    def fun(t, y):
        return [y[1], -y[0]]

    found = solve_ensemble(fun, (0, 1), y0, method=method, simd=simd, **options)
    good = solve_ensemble(fun, (0, 1), y0[[1, 3]], method=method, simd=simd, **options)
    assert found.status.tolist() == [-1, 0, -1, 0]
    assert np.array_equal(found.y_end[[1, 3]], good.y_end)
    assert found.message(2) == (
        "Trajectory 2: component 1 of the initial state `y0` is not finite."
    )
    with pytest.raises(ValueError, match="trajectory 0 is not, nor"):
        solve_ensemble(fun, (0, 1), np.full((3, 2), np.nan))


def test_a_fold_that_raises():
    fold = Fold(lambda value, t, y: value + 1.0 / (1.0 - math.floor(t)), name="inverse")
    found = solve_ensemble(lambda t, y: [-y[0]], (0, 3), [[1.0], [2.0]], reduce=fold, max_step=0.1)
    assert (found.status == -1).all() and "raised" in found.message(1)


def test_processes_say_it_too():
    """By the numbers of the whole ensemble."""
    with ProcessPoolExecutor(1) as client:
        found = solve_ensemble(
            by_hand, (0, 2), [1.0], (np.linspace(0.6, 4.0, 6),), client=client, block=2
        )
    assert "Trajectory 5: a function raised ValueError: it is" in found.message(5)


def rotating(t, z, k):
    return [1j * k * z[0] - 0.1 * z[1], 0.1 * z[0] + 0.2j]


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["RK45", "DOP853", "Radau", "BDF", "Taylor"])
@pytest.mark.parametrize("many", [False, True])
def test_complex_states_are_solved_one_by_one(method, many):
    y0 = np.array([1.0 + 0.5j, 0.2j]) * (np.arange(1, 5)[:, None] if many else 1.0)
    times = np.linspace(0.0, 2.0, 5)
    given = {"rtol": 1e-6, "atol": 1e-8, "t_eval": times, "events": lambda t, z, k: z[0].real}
    found = solve_ensemble(rotating, (0, 2), y0, (K,), method, reduce="final", **given)
    assert found.success.all() and found.y.shape == (4, 2, 5) and found.method == method
    assert "complex" in found.reason and found.y0.dtype == complex
    for i, k in enumerate(K):
        start = y0[i] if many else y0
        one = solve_ivp(rotating, (0, 2), start, method, args=(k,), **given)
        assert np.allclose(found.y[i], one.y, rtol=1e-12)
        assert np.allclose(found.y_end[i], one.y[:, -1], rtol=1e-12)
        assert np.allclose(found.t_events[0][i], one.t_events[0], rtol=1e-10)
        assert np.allclose(found.y_events[0][i], one.y_events[0], rtol=1e-10)
        assert found.nfev[i] == one.nfev
    assert np.array_equal(found.reduced["final"], found.y_end)


def test_complex_states_in_processes():
    y0 = np.array([1.0 + 0.5j, 0.2j]) * np.arange(1, 7)[:, None]
    here = solve_ensemble(rotating, (0, 1), y0, (2.0,))
    with ProcessPoolExecutor(1) as client:
        there = solve_ensemble(rotating, (0, 1), y0, (2.0,), client=client, block=3)
    assert np.array_equal(here.y_end, there.y_end)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"reduce": "max"}, "`reduce='max'`"), ({"method": "Vern8"}, "unknown"),
        ({"method": "LSODA"}, "takes no complex states; "), ({"simd": True}, "complex states"),
        ({"on_event": lambda t, z: z, "events": lambda t, z: z[0].real}, "`on_event`"),
    ],
)  # fmt: skip
def test_what_complex_states_do_not_have(options, said):
    with pytest.raises(ValueError, match=said):
        solve_ensemble(lambda t, z: 1j * z, (0, 1), np.array([1.0 + 0j]), **options)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_complex_states_in_python():
    def in_python(t, z):
        return [1j * z[0] + 0 * len(str(z[0]))]

    y0 = np.array([[1.0 + 0j], [0.5j]])
    many = solve_ensemble(in_python, (0, 1), y0)
    each = [solve_ivp(in_python, (0, 1), one).y[:, -1] for one in y0]
    assert np.array_equal(many.y_end, each)


@pytest.mark.parametrize(("method", "in_lanes"), [("RK45", True), ("Taylor", False)])
def test_a_trajectory_that_slides_for_ever_ends(method, in_lanes):
    """The states chatter at y = 0, with 1e14 steps ahead of them."""

    def turned(t, y):
        return [-1.0 if y[0] > 0 else 1.0]

    problem, y0 = (turned, (0, 1e6)), np.linspace(1e4, 1.1e4, 11)[:, None]
    how = {"method": method, "rtol": 1e-9, "atol": 1e-9, "max_steps": 10_000_000}
    run = solve_ensemble(*problem, y0, **how)
    assert (run.width > 1) == in_lanes
    assert (run.n_accepted < 10_000_000).all()
    assert "no step is short enough" in run.message(3)
    np.testing.assert_allclose(run.t, y0[:, 0], rtol=1e-3)
    many = prepare(*problem, y0[0], **how).many(y0[:3])
    assert (many.status == -1).all() and (many.n_accepted < 10_000_000).all()
    np.testing.assert_allclose(many.t, y0[:3, 0], rtol=1e-3)
