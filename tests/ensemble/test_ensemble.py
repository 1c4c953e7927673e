"""Ensembles: every member is the single solve, whatever its neighbours do."""

import math
import threading

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp, systems
from fastdyn.ensemble import Shared
from support.many import launch, orbit, oscillator

METHODS = {
    "RK23": {"rtol": 1e-5, "atol": 1e-8},
    "RK45": {"rtol": 1e-6, "atol": 1e-9},
    "DOP853": {"rtol": 1e-6, "atol": 1e-9},
    "ode45": {"rtol": 1e-6, "atol": 1e-9},
    "RK4": {"step": 0.05},
    "VelocityVerlet": {"step": 0.05},
    "BlanesMoan6": {"step": 0.05},
    "KahanLi8": {"step": 0.05},
}

TIGHT = METHODS["RK45"]


def bits(result):
    return result.y_end.tobytes(), result.t_end.tobytes(), result.nfev.tobytes()


@pytest.mark.few(5)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("simd", [True, False])
def test_each_member_is_the_single_solve(method, simd):
    y0, GM = launch(np.linspace(0.95, 1.2, 11)), np.linspace(0.9, 1.1, 11)
    options = METHODS[method] | {"t_eval": np.linspace(0, 6.0, 7)}
    many = solve_ensemble(orbit, (0, 6.1), y0, (GM,), method, simd=simd, **options)
    assert many.width == (many.width if simd else 1) and many.success.all()
    for i in range(11):
        one = solve_ivp(orbit, (0, 6.1), y0[i], method, args=(GM[i],), **options)
        assert many.nfev[i] == one.nfev
        # Of DOP853's first short steps the estimated error is rounding for the most part: it moves
        # later steps by 1e-6 of themselves, and the solution by that share of its error of 1e-5.
        assert abs(many.y[i] - one.y).max() < 1e-10
        assert many[i].y.shape == one.y.shape and many[i].message == one.message


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 1000])
def test_any_number_of_members(count):
    speeds = np.linspace(0.8, 1.2, count)
    result = solve_ensemble(orbit, (0, 3), launch(speeds), (1.0,), **TIGHT)
    assert result.y.shape == (count, 4) and result.status.shape == (count,)
    assert result.success.all() and np.isfinite(result.y).all()
    if count == 1000:
        alone = solve_ensemble(orbit, (0, 3), launch(speeds[333:334]), (1.0,), **TIGHT)
        assert np.array_equal(alone.y[0], result.y[333])


def test_threads_order_and_neighbours_change_no_bit():
    speeds = np.random.default_rng(1).uniform(0.5, 1.3, 40)  # steps differ tenfold
    first = solve_ensemble(orbit, (0, 20), launch(speeds), (1.0,), threads=1, **TIGHT)
    for threads in (2, 3):
        again = solve_ensemble(orbit, (0, 20), launch(speeds), (1.0,), threads=threads, **TIGHT)
        assert bits(again) == bits(first)
    order = np.random.default_rng(2).permutation(40)
    mixed = solve_ensemble(orbit, (0, 20), launch(speeds[order]), (1.0,), **TIGHT)
    assert np.array_equal(mixed.y, first.y[order])


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("method", ["Radau", "BDF", "Rodas5P"])
def test_a_jacobian_that_is_no_number_has_a_sentence(method):
    run = solve_ensemble(
        lambda t, y: [-y[0]], (0, 2), [[1.0]], method=method, jac=lambda t, y: [[float("nan")]]
    )
    assert run.status[0] == -1 and "The Jacobian is nan or inf at t = 0" in run.message(0)


def test_a_member_that_fails_leaves_the_others_alone():
    """Speed 0 falls into the centre; GM = nan has no derivative; a stiff one runs out of steps."""
    y0, GM = launch([1.0, 0.0, 1.1, 1.0, 1.2, 1.0]), np.array([1, 1, 1, np.nan, 1, 1e8])
    options = TIGHT | {"max_steps": 2000}
    result = solve_ensemble(orbit, (0, 10), y0, (GM,), **options)
    assert result.status.tolist() == [0, -1, 0, -1, 0, -1]
    assert "max_steps" in result.message(5) and "finite" in result.message(3)
    healthy = solve_ensemble(orbit, (0, 10), y0[[0, 2, 4]], (GM[[0, 2, 4]],), **options)
    assert np.array_equal(result.y[[0, 2, 4]], healthy.y)
    assert 0 < result.t_end[1] < 10 and result.n_accepted[5] == 2000


def kicked(t, w, k, switch):
    x, v = w
    return [v, -k * x + (1.0 if t < switch else 0.0)]


def guarded(t, w, k, switch):
    if abs(w[0]) > 100.0:
        raise ValueError("it has left")
    return kicked(t, w, k, switch)


def test_what_branches_runs_on_vectors():
    k = np.linspace(1, 2, 5)
    given = (0, 5), [1, 0], (k, np.linspace(1.9, 2.1, 5))
    result = solve_ensemble(kicked, *given, simd=True, **TIGHT)
    for i in range(5):
        one = solve_ivp(kicked, (0, 5), [1, 0], args=(k[i], given[2][1][i]), **TIGHT)
        np.testing.assert_allclose(result.y[i], one.y[:, -1], atol=1e-8)


def test_what_raises_runs_one_by_one():
    k = np.linspace(1, 2, 5)
    result = solve_ensemble(guarded, (0, 5), [1, 0], (k, 2.0), breakpoints=[2.0], **TIGHT)
    assert result.width == 1 and "raise" in result.reason and "one by one" in repr(result)
    for i in range(5):
        one = solve_ivp(guarded, (0, 5), [1, 0], args=(k[i], 2.0), breakpoints=[2.0], **TIGHT)
        assert np.array_equal(result.y[i], one.y[:, -1])
    with pytest.raises(ValueError, match=r"no form for vectors: .*raise"):
        solve_ensemble(guarded, (0, 5), [1, 0], (k, 2.0), simd=True)


def joined(t, w, k):
    pairs = w[:1] + w[1:]  # components added; of tuples it would be the whole state again
    return [pairs[0], -k * w[0]]


def tabled(t, w, table, k):
    return [w[1], -k * table[0] * w[0]]


def in_python(t, w, k):
    return [w[1], -float(str(k)) * w[0]]


def choosy(t, w, k):
    if k > 3:
        raise ValueError("too stiff")
    return [w[1], -k * w[0]]


def test_states_added_as_arrays_are_not_joined_as_tuples():
    result = solve_ensemble(joined, (0, 1), [1.0, 0.5], (np.array([1.0, 2.0]),), **TIGHT)
    one = solve_ivp(joined, (0, 1), [1.0, 0.5], args=(2.0,), **TIGHT)
    np.testing.assert_allclose(result.y[1], one.y[:, -1], atol=1e-9)


def test_shared_arrays_numbers_and_closures():
    k = np.array([1, 2, 3])  # whole numbers
    result = solve_ensemble(tabled, (0, 1), [1.0, 0], (Shared(np.array([2.0])), k), **TIGHT)
    exact = np.cos(np.sqrt(2.0 * k))
    assert result.width > 1 and abs(result.y[:, 0] - exact).max() < 1e-5
    for factor in (1.0, 4.0):

        def scaled(t, w, k):
            return [w[1], -factor * k * w[0]]  # noqa: B023

        y = solve_ensemble(scaled, (0, 1), [1.0, 0], (k,), **TIGHT).y
        assert abs(y[:, 0] - np.cos(np.sqrt(factor * k))).max() < 1e-4


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_functions_that_stay_in_python_and_functions_that_raise():
    k = np.array([1.0, 2.0, 4.0])
    result = solve_ensemble(in_python, (0, 1), [1.0, 0], (k,), **TIGHT)
    assert abs(result.y[:, 0] - np.cos(np.sqrt(k))).max() < 1e-5
    result = solve_ensemble(choosy, (0, 1), [1.0, 0], (k,), **TIGHT)
    assert result.status.tolist() == [0, 0, -1] and "raised" in result.message(2)
    assert abs(result.y[:2, 0] - np.cos(np.sqrt(k[:2]))).max() < 1e-5


def onto_circle(t, w, k):
    x, v = w
    r = math.sqrt(x * x + v * v / k)
    return [x / r, v / r]


def test_projection_breakpoints_and_backwards():
    k = np.linspace(1, 2, 5)
    for options in ({"project": onto_circle}, {"breakpoints": [1.0, 2.0]}, {}):
        for span in ((0, 3), (3, 0)):
            many = solve_ensemble(oscillator, span, [1, 0], (k,), t_eval=[1.5], **TIGHT, **options)
            for i in range(5):
                one = solve_ivp(oscillator, span, [1, 0], args=(k[i],), **TIGHT, **options)
                assert abs(many.y_end[i] - one.y[:, -1]).max() < 1e-13
                assert many.n_accepted[i] == one.n_accepted


@pytest.mark.hunt
def test_ctrl_c_returns_the_finished_part():
    import _thread

    y0 = launch(np.ones(100_000))
    for choice in ("return", "raise"):
        timer = threading.Timer(3.0, _thread.interrupt_main)  # when it is under way
        solve_ensemble(orbit, (0, 1), y0[:9], (1.0,), **TIGHT)
        timer.start()
        try:
            result = solve_ensemble(orbit, (0, 1e4), y0, (1.0,), on_interrupt=choice, **TIGHT)
        except KeyboardInterrupt as interrupt:
            result = interrupt.result
            assert choice == "raise"
        done = result.status == 0
        assert set(result.status) <= {0, -2} and -2 in result.status  # it would take hours
        assert np.isfinite(result.y[done]).all() and np.isnan(result.y[~done]).all()


def test_systems_take_arrays_for_parameters():
    omega = np.array([5.0, 8.740320488976421, 15.0])
    result = systems.building(d=0.05).ensemble(omega=omega, reduce="max", t_span=(0, 10))
    assert result.width > 1 and result.system.d == 0.05
    for i, w in enumerate(omega):
        exact = systems.building(d=0.05, omega=w).exact(np.linspace(0, 10, 4001))
        assert abs(result.reduced["max"][i, 1] - exact[1].max()) < 1e-4
    with pytest.raises(ValueError, match="greater than zero"):
        systems.building().ensemble(omega=np.array([1.0, -1.0]))
    thrown = systems.tower().ensemble(V=np.array([5.0, 10.0]), events="ground", t_span=(0, 60))
    assert (thrown.status == 1).all() and abs(thrown.y[:, 1]).max() < 1e-9


def test_initial_conditions_of_a_system_vary_the_starts_alone():
    swings = systems.pendulum(l=2.0)
    V0, g = np.array([1.0, 2.0, 3.0]), np.array([9.81, 1.62, 3.71])
    result = swings.ensemble(V0=V0, g=g, t_span=(0, 1), method="RK4", step=0.01)
    assert list(result.parameters) == [0] and np.array_equal(result.initial_conditions["V0"], V0)
    assert np.array_equal(result.y0, np.stack([0.0 * V0, V0 / 2.0], axis=1))
    for i in range(3):
        alone = systems.pendulum(l=2.0, V0=V0[i], g=g[i]).solve((0, 1), method="RK4", step=0.01)
        assert np.allclose(result.y_end[i], alone.y[:, -1], rtol=1e-13, atol=0.0)
    figure = swings.ensemble(V0=V0, t_span=(0, 1)).plot()
    assert figure.axes[-1].get_xlabel() == "V₀ (m/s)"
    with pytest.raises(ValueError, match="`V0` of the pendulum and `y0` both set the start"):
        swings.ensemble(V0=V0, y0=[0.1, 0.0])
    with pytest.raises(ValueError, match="one entry a trajectory: `V0` has 3, `g` has 2"):
        swings.ensemble(V0=V0, g=np.ones(2))
