"""`fastdyn.pytensor`: the Op and its derivatives in graphs of PyTensor."""

import numpy as np
import pytest

import fastdyn
from tests.doors import problems
from tests.doors.problems import TIGHT, TIMES, pendulum

pytensor = pytest.importorskip("pytensor")
pt = pytest.importorskip("pytensor.tensor")
gradient = pytest.importorskip("pytensor.gradient")

from fastdyn.pytensor import solve_ivp  # noqa: E402


def states(y0, *args, method="Tsit5", fun=pendulum):
    return solve_ivp(fun, (0, 3), y0, method, TIMES, args=args, **TIGHT).y


def test_the_outputs_are_those_of_solve_ivp():
    known = fastdyn.solve_ivp(pendulum, (0, 3), [1, 0], "Tsit5", TIMES, args=(9.81, 0.2), **TIGHT)
    k = pt.dscalar("k")
    found = solve_ivp(pendulum, (0, 3), [1, 0], "Tsit5", TIMES, args=(k, 0.2), **TIGHT)
    t, y, status = pytensor.function([k], [found.t, found.y, found.status])(9.81)
    assert np.array_equal(y, known.y) and np.array_equal(t, TIMES) and status == 0
    assert found.y.type.shape == (2, 6) and found.t_events is None


def test_verify_grad():
    rng = np.random.default_rng(1)

    def few(x, k, d):
        return states([x, 0.0], k, d)

    def many(k):
        y0 = np.append(np.sin(np.arange(1, 6)), np.zeros(5))
        return states(y0, pt.specify_shape(k, (9,))[:6], fun=problems.chain)

    gradient.verify_grad(few, [np.array(1.0), np.array(9.81), np.array(0.2)], rng=rng)
    gradient.verify_grad(many, [np.linspace(0.5, 2.0, 9)], rng=rng)


def test_derivatives_along_tangents():
    k = pt.dscalar("k")
    y = states([1.0, 0.0], k, 0.2)
    along = pytensor.function([k], gradient.Rop(y, k, pt.ones(())))
    back = pytensor.function([k], pytensor.grad(y[0, 3], k))
    assert np.allclose(along(9.81)[0, 3], back(9.81), rtol=1e-12)


def test_the_time_of_an_event():
    k, end = pt.dscalars("k", "end")
    found = solve_ivp(problems.fall, (0, 9), [10.0, 0.0], "DOP853", events=problems.ground,
                      args=(k,), **TIGHT)  # fmt: skip
    duration = found.t_events[0][0]
    both = pytensor.function([k], [duration, pytensor.grad(duration, k)])
    assert np.allclose(both(0.1), problems.time_of_fall(0.1), rtol=1e-9)
    grown = solve_ivp(problems.ramp, (0, 2), [0.0, 1.0], "Tsit5", events=problems.reached,
                      args=(end,), on_event=problems.stop).y[0, 0]  # fmt: skip
    both = pytensor.function([end], [grown, pytensor.grad(grown, end)])
    assert np.allclose(both(0.98), (0.98, 1.0), rtol=1e-12)


def test_a_failure_is_nan():
    x = pt.dscalar("x")
    found = solve_ivp(pendulum, (0, 3), [x, 0.0], args=(9.81, 0.2))
    y, status, slope = pytensor.function(
        [x], [found.y, found.status, pytensor.grad(found.y.sum(), x)]
    )(np.nan)
    assert np.isnan(y).all() and status == -1 and np.isnan(slope)


@pytest.mark.parametrize(
    "error, words, call",
    [
        (
            TypeError,
            "float32; fastdyn computes in float64",
            lambda k: states([1.0, 0.0], pt.fscalar(), k),
        ),
        (
            TypeError,
            r"`args\[1\]` is of int64, and has no",
            lambda k: states([1.0, 0.0], k, pt.lscalar()),
        ),
        (ValueError, "shape of `y0` must be known", lambda k: states(pt.dvector(), k, k)),
        (
            ValueError,
            r"shape of `args\[0\]` must be known",
            lambda k: states([1.0, 0.0], pt.dvector(), k),
        ),
        (
            TypeError,
            "`t_span` is an array of PyTensor that varies",
            lambda k: solve_ivp(pendulum, (0, k), [1.0, 0.0], args=(k, k)),
        ),
        (gradient.NullTypeGradError, "differentiated once", lambda k: twice(k)),
    ],
)
def test_slips_get_a_sentence(error, words, call):
    with pytest.raises(error, match=words):
        call(pt.dscalar("k"))


def twice(k):
    first = pytensor.grad(states([1.0, 0.0], k, 0.2).sum(), k)
    pytensor.grad(first, k)
