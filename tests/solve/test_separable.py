"""Claims about H = T(p) + V(q) given by two functions."""

import math

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn.kernels.methods import METHODS
from support.hamiltonians import GIVEN, START, balance, born, eaten, force, velocity, whole

EPS = np.finfo(float).eps
SPLITTINGS = [name for name, m in METHODS.items() if m.separable]
NYSTROM = [name for name, m in METHODS.items() if m.second_order and not m.separable]


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SPLITTINGS)
def test_the_order_with_time_in_both_functions(name):
    """H = (1 + sin t / 2) sqrt(1 + p²) - (1 + cos t / 3) cos q: time splits as well."""

    def fast(t, p):
        return [(1.0 + 0.5 * math.sin(t)) * p[0] / math.sqrt(1.0 + p[0] * p[0])]

    def pull(t, q):
        return [-(1.0 + math.cos(t) / 3.0) * math.sin(q[0])]

    def error(step):
        run = fastdyn.solve.solve_separable(fast, pull, (0, 3), [1.2], [0.4], name, step=step)
        return abs(run.y[:, -1] - exact).max()

    exact = fastdyn.solve.solve_separable(fast, pull, (0, 3), [1.2], [0.4], "Gauss16", step=0.05).y[
        :, -1
    ]
    coarse = 3 / 4 if METHODS[name].order == 10 else 3 / 16  # above rounding, below the bends
    order = math.log2(error(coarse) / error(coarse / 2))
    assert abs(order - METHODS[name].order) < 0.5


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SPLITTINGS)
def test_quadratic_t_gives_what_solve_second_order_gives(name):
    def itself(t, p):
        return [p[0], p[1]]

    def kepler(t, q):
        r3 = (q[0] * q[0] + q[1] * q[1]) ** 1.5
        return [-q[0] / r3, -q[1] / r3]

    given = {"step": 0.05, "dense_output": True, "compile": "shared"}
    state = ([1.0, 0.0], [0.0, 1.1])
    pair = fastdyn.solve.solve_separable(itself, kepler, (0, 20), *state, name, **given)
    alone = fastdyn.solve.solve_second_order(kepler, (0, 20), *state, name, **given)
    assert np.array_equal(pair.y, alone.y) and pair.nfev == alone.nfev
    assert np.array_equal(pair.sol(7.77), alone.sol(7.77))


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["VelocityVerlet", "KahanLi8", "Gauss16", "RK45", "RK4"])
def test_both_tiers_and_one_function_give_the_same(name):
    given = {"rtol": 1e-8, "atol": 1e-10} if name == "RK45" else {"step": 0.1}
    given |= {**GIVEN, "dense_output": True}
    runs = [
        fastdyn.solve.solve_separable(velocity, force, (0, 20), *START, name, compile=tier, **given)
        for tier in ("shared", "inlined")
    ]
    if name not in SPLITTINGS:
        y0 = np.concatenate(START)
        runs.append(fastdyn.solve_ivp(whole, (0, 20), y0, name, compile="shared", **given))
    for run in runs[1:]:
        assert np.array_equal(run.y, runs[0].y) and run.nfev == runs[0].nfev
        assert np.array_equal(run.sol(7.77), runs[0].sol(7.77))


def test_dense_output_events_and_output_times():
    def crossing(t, y, c):
        return y[0]

    given = {**GIVEN, "step": 0.01, "events": crossing}
    run = fastdyn.solve.solve_separable(
        velocity, force, (0, 20), *START, "KahanLi8", dense_output=True, **given
    )
    exact = fastdyn.solve_ivp(
        whole, (0, 20), np.concatenate(START), "DOP853", rtol=1e-12, atol=1e-13,
        dense_output=True, events=crossing, **GIVEN,
    )  # fmt: skip
    t = np.linspace(0, 20, 997)
    assert np.abs(run.sol(t) - exact.sol(t)).max() < 1e-8
    assert np.abs(run.t_events[0] - exact.t_events[0]).max() < 1e-8
    some = fastdyn.solve.solve_separable(
        velocity, force, (0, 20), *START, "KahanLi8", t_eval=t, **given
    )
    assert np.abs(some.y - run.sol(t)).max() < 4 * EPS


def test_numbers_from_outside_are_read_anew_and_python_does_as_well():
    depth, seen = 1.0, []

    def pull(t, q):
        return [-depth * math.sin(q[0])]

    def looked_up(t, q):
        seen.append(t)
        return [-2.0 * math.sin(q[0])]

    def run(force):
        return fastdyn.solve.solve_separable(
            lambda t, p: [math.tanh(p[0])], force, (0, 5), [1.0], [0.0], "KahanLi8", step=0.1
        ).y

    first = run(pull)
    depth = 2.0
    second = run(pull)
    with pytest.warns(fastdyn.CompileWarning, match="looked_up"):
        third = run(looked_up)
    assert not np.array_equal(first, second) and np.array_equal(second, third)


def late(t, p):
    if t > 1.0:
        raise ZeroDivisionError("too late")
    return [p[0]]


@pytest.mark.few(3)
@pytest.mark.parametrize("method", ["VelocityVerlet", "Gauss8", "RK45"])
@pytest.mark.parametrize("tier", ["shared", "inlined"])
def test_what_a_function_raises_arrives(method, tier):
    given = {"compile": tier} if method == "RK45" else {"compile": tier, "step": 0.1}
    for functions in ((late, born), (eaten, late)):
        with pytest.raises(ZeroDivisionError, match="too late"):
            fastdyn.solve.solve_separable(*functions, (0, 5), [0.1], [0.1], method, **given)


def fine(t, x):
    return [x[0]]


@pytest.mark.parametrize("name", NYSTROM)
def test_nystrom_methods_are_refused(name):
    sentence = f"{name} is a Nystrom method, made for q'' = a.* choose from RK23, .*KahanLi8"
    with pytest.raises(ValueError, match=sentence):
        fastdyn.solve.solve_separable(fine, fine, (0, 1), [1.0], [0.0], name, step=0.1)
    with pytest.raises(ValueError, match=sentence):
        fastdyn.energy_drift(
            (fine, fine), name, y0=[1.0, 0.0], step=0.1, n_steps=9, invariants={"H": balance}
        )


@pytest.mark.parametrize(
    "call, error, sentence",
    [
        (lambda s: s(fine, lambda t, q: [q[0], 1.0]), ValueError, "`force` returned 2 values"),
        (lambda s: s(lambda t, p: [], fine), ValueError, "`velocity` returned 0 values"),
        (lambda s: s(lambda t, p: None, fine), TypeError, "`velocity` returned None"),
        (lambda s: s(fine, lambda t, q: [1j]), TypeError, "`force` returned complex"),
        (lambda s: s(fine, lambda t, q: ["a"]), ValueError, "`force` returned"),
        (lambda s: s(fine, None), TypeError, "two functions, `velocity` and `force`"),
        (lambda s: s(fine, fine, q0=[1.0, 2.0]), ValueError, "`q0` and `p0` must be real"),
        (lambda s: s(fine, fine, p0=[math.nan]), ValueError, "`p0` must be finite"),
        (lambda s: s(fine, fine, q0=[[1.0]]), ValueError, "`q0` must be 1-dimensional"),
        (lambda s: s(fine, fine, q0=["a"]), TypeError, "`q0` must be numbers"),
        (lambda s: s(fine, fine, method=OdeSolver), ValueError, "OdeSolver.*is SciPy's"),
        (lambda s: s(fine, fine, step=None), ValueError, "constant steps"),
    ],
)
def test_wrong_input_gets_a_sentence(call, error, sentence):
    def solve(velocity, force, q0=(1.0,), p0=(0.0,), step=0.1, **options):
        return fastdyn.solve.solve_separable(velocity, force, (0, 1), q0, p0, step=step, **options)

    with pytest.raises(error, match=sentence):
        call(solve)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_state_that_is_no_number_ends_the_run():
    def breaks(t, p):
        return [p[0] / (0.0 if t > 0.5 else 1.0)]

    run = fastdyn.solve.solve_separable(breaks, fine, (0, 1), [1.0], [1.0], step=0.1)
    assert run.status == -1 and "not finite" in run.message
    run = fastdyn.solve.solve_separable(
        lambda t, p: [math.nan], fine, (0, 1), [1.0], [1.0], step=0.1
    )
    assert run.status == -1 and len(run.t) == 1
    with pytest.raises(TypeError, match="two functions"):
        fastdyn.energy_drift((fine,), y0=[1.0, 0.0], step=0.1, n_steps=9, invariants={"H": balance})
    with pytest.raises(ValueError, match="even number"):
        fastdyn.energy_drift(
            (fine, fine), "RK4", y0=[1.0], step=0.1, n_steps=9, invariants={"H": balance}
        )
