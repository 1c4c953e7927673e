"""Many solves in one call are the same as a loop over calls, to the last bit."""

import numpy as np
import pytest

from fastdyn import prepare
from fastdyn.compile import memory
from fastdyn.ensemble import Shared

RNG = np.random.default_rng(3)
STARTS = RNG.uniform(0.2, 1.0, (30, 2))
SPEEDS = RNG.uniform(1.0, 9.0, 30)
SPAN = (0.0, 3.0)


def spring(t, y, k, c):
    return [y[1], -k * y[0] - c * y[1]]


def at_zero(t, y, k, c):
    return y[0]


at_zero.terminal = True


def taken_up(t, y, k, c):
    return y * (1.0 + 0.0 * k)


def same(many, solver, starts, arguments):
    for i, (y0, args) in enumerate(zip(starts, arguments, strict=True)):
        one = solver(y0, args)
        if many.y.ndim == 2:
            assert many.t[i] == one.t[-1] and np.array_equal(many.y[i], one.y[:, -1])
        else:
            n = len(one.t)
            assert np.array_equal(many.y[i, :, :n], np.reshape(one.y, (-1, n)))
            assert np.isnan(many.y[i, :, n:]).all()
        for name in ("nfev", "status", "success", "n_accepted", "n_rejected"):
            assert many[name][i] == one[name], name


@pytest.fixture(params=["one by one", "ensemble"], autouse=True)
def way(request, monkeypatch):
    """A few solves are a loop, more are an ensemble."""
    from fastdyn.solve import many

    monkeypatch.setattr(many, "FEW", 1000 if request.param == "one by one" else -1)


OPTIONS = {
    "plain": {},
    "long": {"rtol": 1e-11, "atol": 1e-11},  # more steps than fit the first piece
    "times": {"t_eval": [1.0, 2.0, 3.0]},
    "event": {"events": at_zero},
    "event and times": {"events": at_zero, "t_eval": [0.1, 0.2, 2.5]},
    "few steps": {"max_steps": 3},
    "constant steps": {"method": "RK4", "step": 0.07},
    "projected": {"project": taken_up},
    "breakpoints": {"breakpoints": [1.0, 2.0]},
}


@pytest.mark.few
@pytest.mark.parametrize("options", OPTIONS.values(), ids=OPTIONS)
def test_the_same_as_one_by_one(options, monkeypatch):
    solver = prepare(spring, SPAN, STARTS[0], args=(1.0, 0.1), compile="shared", **options)
    found = solver.many(STARTS, (SPEEDS, 0.1))
    same(found, solver, STARTS, [(k, 0.1) for k in SPEEDS.tolist()])
    monkeypatch.setattr("fastdyn.run.loop.CHUNK_SECONDS", 0.0)  # a step a chunk
    cut = solver.many(STARTS, (SPEEDS, 0.1))
    assert all(np.array_equal(cut[name], found[name], equal_nan=True) for name in found)


def test_what_may_differ():
    solver = prepare(spring, SPAN, STARTS[0], args=(1.0, 0.1), compile="shared")
    columns = SPEEDS, SPEEDS / 10
    both = list(zip(*(c.tolist() for c in columns), strict=True))
    same(solver.many(args=columns), solver, 30 * [STARTS[0]], both)
    same(solver.many(STARTS), solver, STARTS, 30 * [(1.0, 0.1)])
    same(solver.many(STARTS[:1], columns), solver, 30 * [STARTS[0]], both)
    whole = np.arange(1, 31)
    same(solver.many(STARTS, (whole, 0.1)), solver, STARTS, [(int(k), 0.1) for k in whole])
    none = solver.many(np.empty((0, 2)))
    assert none.t.shape == (0,) and none.y.shape == (0, 2)

    def pulled(t, y, k, a):
        return [y[1], -k * a[0] * y[0] - a[1] * y[1]]

    solver = prepare(pulled, SPAN, STARTS[0], args=(1.0, np.ones(2)), compile="shared")
    a = np.array([2.0, 0.1])
    same(
        solver.many(STARTS, (SPEEDS, Shared(a))), solver, STARTS, [(k, a) for k in SPEEDS.tolist()]
    )


OUTSIDE = 1.0


def test_what_changes_outside_is_seen(monkeypatch):
    def decay(t, y, k):
        return -OUTSIDE * k * y

    solver = prepare(decay, SPAN, [1.0], args=(1.0,), compile="shared")
    for value in (1.0, 0.5, 3):
        monkeypatch.setitem(globals(), "OUTSIDE", value)
        same(solver.many(args=(SPEEDS,)), solver, 30 * [[1.0]], [(k,) for k in SPEEDS.tolist()])


def test_arguments_that_choose():
    def chosen(t, y, n):
        return -y if n == 0 else y / n

    solver = prepare(chosen, SPAN, [1.0], args=(0,), compile="shared")
    numbers = np.arange(5)
    same(solver.many(args=(numbers,)), solver, 5 * [[1.0]], [(int(n),) for n in numbers])


def test_the_first_that_raises():
    def root(t, y, a):
        if a < 2.0:
            raise ValueError(f"a = {a}")
        return -y

    solver = prepare(root, SPAN, [1.0], args=(3.0,), compile="shared")
    with pytest.raises(ValueError, match=r"a = 1\.5"):
        solver.many(args=(np.array([4.0, 3.0, 1.5, 1.0]),))
    same(solver.many(args=([4.0, 3.0],)), solver, 2 * [[1.0]], [(4.0,), (3.0,)])


def test_a_function_that_stays_in_python():
    seen = []

    def pull(t, y, k):
        seen.append(t)
        return -k * y

    memory.forget()  # the warning of the other way
    with pytest.warns(match="runs in Python"):
        solver = prepare(pull, SPAN, [1.0], args=(1.0,))
    same(solver.many(args=(SPEEDS,)), solver, 30 * [[1.0]], [(k,) for k in SPEEDS.tolist()])


def test_refused():
    solver = prepare(spring, SPAN, STARTS[0], args=(1.0, 0.1), compile="shared")
    for y0s, args in ((STARTS[:, :1], None), (STARTS, (SPEEDS[:7], 0.1)), (STARTS * np.nan, None)):
        with pytest.raises(ValueError):
            solver.many(y0s, args)
    dense = prepare(spring, SPAN, STARTS[0], args=(1.0, 0.1), compile="shared", dense_output=True)
    with pytest.raises(ValueError, match="dense_output"):
        dense.many(STARTS)


def test_few_and_many_have_the_same_fields(monkeypatch):
    monkeypatch.undo()
    solver = prepare(spring, SPAN, STARTS[0], args=(1.0, 0.1), compile="shared")
    few, many = (solver.many(np.resize(STARTS, (m, 2))) for m in (10, 1000))
    assert few.keys() == many.keys()
    for name in few:
        assert few[name].dtype == many[name].dtype and few[name].shape[1:] == many[name].shape[1:]
        assert np.array_equal(few[name], many[name][:10]), name
