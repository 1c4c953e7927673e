"""`fastdyn.jax`: derivatives in both directions, under the transformations of JAX."""

import dataclasses
import functools
from typing import NamedTuple

import numpy as np
import pytest

import fastdyn
from fastdyn.solve.differentiable import call as calls
from tests.doors import problems
from tests.doors.problems import TIGHT, TIMES, pendulum


@pytest.fixture(scope="module", autouse=True)
def library():
    """JAX comes with the first of these tests: collecting them would cost each process 200 MB."""
    global SPRINGS, STRAY, STRETCHED, VALUES, check, jax, jnp, solve_ivp
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp
    from jax.test_util import check_grads

    from fastdyn.jax import solve_ivp

    check = functools.partial(check_grads, order=1, rtol=1e-5, atol=1e-5)  # of differences
    VALUES = jnp.array([1.0, 0.0]), jnp.float64(9.81), jnp.float64(0.2)
    SPRINGS = jnp.linspace(0.5, 2.0, 6)  # more directions than sensitivities are taken for
    STRETCHED = jnp.concatenate((jnp.sin(jnp.arange(1.0, 6.0)), jnp.zeros(5)))
    STRAY = jnp.float64(9.81)


def states(y0, *args, method="Tsit5", fun=pendulum, **options):
    return solve_ivp(fun, (0, 3), y0, method, TIMES, args=args, **{**TIGHT, **options}).y


def test_the_outputs_are_those_of_solve_ivp():
    known = fastdyn.solve_ivp(pendulum, (0, 3), [1, 0], "Tsit5", TIMES, args=(9.81, 0.2), **TIGHT)

    def solve(y0, stiffness):
        return solve_ivp(pendulum, (0, 3), y0, "Tsit5", TIMES, args=(stiffness, 0.2), **TIGHT)

    for found in (solve(*VALUES[:2]), jax.jit(solve)(*VALUES[:2]), solve([1, 0], 9.81)):
        assert np.array_equal(found.y, known.y) and np.array_equal(found.t, TIMES)
        assert found.status == 0 and found.t_events is found.y_events is None
    last = solve_ivp(pendulum, (0, 3), VALUES[0], "Tsit5", args=(9.81, 0.2), **TIGHT)
    assert np.allclose(last.y[:, 0], known.y[:, -1], rtol=1e-9) and np.array_equal(last.t, [3.0])


@pytest.mark.few(1)
@pytest.mark.parametrize("method", ["Tsit5", "Radau"])
def test_few_directions(method):
    solve = functools.partial(states, method=method)
    check(jax.jit(solve), VALUES, modes=["fwd", "rev"])
    check(lambda y0: solve([y0, 0.0], *VALUES[1:]), (VALUES[0][0],), modes=["fwd", "rev"])
    by_all = jax.jacrev(solve, (0, 1, 2))(*VALUES)
    for one, other in zip(by_all, jax.jacfwd(solve, (0, 1, 2))(*VALUES), strict=True):
        assert np.allclose(one, other, rtol=1e-12, atol=1e-12)


def test_many_directions_take_the_adjoint(monkeypatch):
    asked = []
    own = calls.solve_ivp

    def noted(*given, **options):
        asked.extend({"adjoint", "sensitivity"} & {*options})
        return own(*given, **options)

    monkeypatch.setattr(calls, "solve_ivp", noted)
    solve = functools.partial(states, fun=problems.chain)
    loss = jax.jit(jax.grad(lambda *values: (solve(*values) ** 2).sum(), (0, 1)))
    by_adjoint = loss(STRETCHED, SPRINGS)
    assert asked == ["adjoint"]
    check(solve, (STRETCHED, SPRINGS), modes=["fwd", "rev"])
    y, slopes = solve(STRETCHED, SPRINGS), jax.jacfwd(solve, (0, 1))(STRETCHED, SPRINGS)
    assert {*asked} == {"adjoint", "sensitivity"}
    for one, other in zip(by_adjoint, slopes, strict=True):
        assert np.allclose(one, 2 * np.einsum("it,itj", y, other), rtol=1e-7, atol=1e-9)
    asked.clear()
    implicit = jax.grad(lambda *values: (solve(*values, method="Radau") ** 2).sum(), (0, 1))
    for one, other in zip(implicit(STRETCHED, SPRINGS), by_adjoint, strict=True):
        assert np.allclose(one, other, rtol=1e-6, atol=1e-7)
    assert asked in (["adjoint", "sensitivity"], ["adjoint"])  # where the method has no adjoint


def test_vmap_is_an_ensemble(monkeypatch):
    sizes, own = [], fastdyn.jax.solve_ensemble

    def noted(*given, **options):
        found = own(*given, **options)
        sizes.append(len(found.y))
        return found

    monkeypatch.setattr(fastdyn.jax, "solve_ensemble", noted)
    monkeypatch.setattr(calls, "solve_ivp", None)
    rates = jnp.linspace(5.0, 12.0, 7)
    many = jax.jit(jax.vmap(lambda k: states(VALUES[0], k, 0.2)))(rates)
    starts = VALUES[0] + 0.1 * jnp.arange(3.0)[:, None]
    both = jax.vmap(jax.vmap(states, (None, 0, None)), (0, None, None))(starts, rates, VALUES[2])
    assert sizes == [7, 21] and both.shape == (3, 7, 2, 6)
    monkeypatch.undo()
    for k, each in zip(rates, many, strict=True):
        assert np.allclose(each, states(VALUES[0], k, 0.2), rtol=1e-12, atol=1e-12)
    assert np.allclose(both[2, 5], states(starts[2], rates[5], VALUES[2]), rtol=1e-12, atol=1e-12)


@pytest.mark.hunt
def test_derivatives_under_vmap():
    rates = jnp.linspace(5.0, 12.0, 3)

    def loss(y0, k, d):
        return (states(y0, k, d) ** 2).sum()

    def total(y0, rates, d):
        return jax.vmap(loss, (None, 0, None))(y0, rates, d).sum()

    check(jax.jit(total), (VALUES[0], rates, VALUES[2]), modes=["fwd", "rev"])
    one_by_one = [jax.grad(loss, (0, 1, 2))(VALUES[0], k, VALUES[2]) for k in rates]
    within = jax.jit(jax.vmap(jax.grad(loss, (0, 1, 2)), (None, 0, None)))
    for at_once, *singly in zip(within(VALUES[0], rates, VALUES[2]), *one_by_one, strict=True):
        assert np.allclose(at_once, np.stack(singly), rtol=1e-12)
    by_all = jax.grad(total, (0, 1, 2))(VALUES[0], rates, VALUES[2])
    assert np.allclose(by_all[2], sum(each[2] for each in one_by_one), rtol=1e-12)


@pytest.mark.hunt
def test_many_directions_under_vmap(monkeypatch):
    springs = SPRINGS * jnp.array([[1.0], [1.5]])

    def loss(springs):
        return (states(STRETCHED, springs, fun=problems.chain) ** 2).sum()

    one_by_one = np.stack([jax.grad(loss)(each) for each in springs])
    assert np.allclose(jax.jit(jax.vmap(jax.grad(loss)))(springs), one_by_one, rtol=1e-12)
    summed = jax.grad(lambda springs: jax.vmap(loss)(springs).sum())(springs)
    assert np.allclose(summed, one_by_one, rtol=1e-12)
    rows = jax.jacrev(lambda k: states(STRETCHED, k, fun=problems.chain)[0])(springs[0])
    columns = jax.jacfwd(lambda k: states(STRETCHED, k, fun=problems.chain)[0])(springs[0])
    assert np.allclose(rows, columns, rtol=1e-7, atol=1e-9)
    solves = []
    monkeypatch.setattr(calls, "solve_ivp", counted(calls.solve_ivp, solves))
    jax.jacrev(lambda *given: states(*given, fun=problems.chain)[0], (0, 1))(STRETCHED, springs[0])
    assert len(solves) == 2  # the values, and one sweep after the other over the same steps


def counted(solve, solves):
    def called(*given, **options):
        solves.append(options)
        return solve(*given, **options)

    return called


def test_the_time_of_an_event():
    """diffrax #451: the time at which an event ends the run depends on a parameter."""

    def duration(k):
        found = solve_ivp(problems.fall, (0, 9), [10.0, 0.0], "DOP853", events=problems.ground,
                          args=(k,), **TIGHT)  # fmt: skip
        return found.t_events[0][0]

    for k in (0.1, 0.7):
        known = problems.time_of_fall(k)
        assert np.allclose(jax.jit(jax.value_and_grad(duration))(k), known, rtol=1e-9)
        assert np.allclose(jax.jvp(duration, (k,), (2.0,))[1], 2 * known[1], rtol=1e-9)

    def landing(drag):
        y0 = [0.0, 100.0, 5.0, np.pi / 4]
        found = solve_ivp(problems.cannonball, (0, 20), y0, "DOP853", events=problems.height,
                          args=(drag,), **TIGHT)  # fmt: skip
        return jnp.append(found.t_events[0], found.y_events[0])

    check(landing, (jnp.float64(0.5),), modes=["fwd", "rev"])


def test_gradients_after_an_event_that_acts():
    """diffrax #729: y grows at rate 1 until `end`, so that y = end and dy/d(end) = 1 behind it."""

    def grown(end):
        found = solve_ivp(problems.ramp, (0, 2), [0.0, 1.0], "Tsit5", [0.5, 1.5, 2.0],
                          problems.reached, (end,), on_event=problems.stop)  # fmt: skip
        return found.y[0]

    for transform in (jax.jacfwd, jax.jacrev):
        assert np.allclose(grown(0.98), [0.5, 0.98, 0.98], rtol=1e-12)
        assert np.allclose(transform(grown)(0.98), [0.0, 1.0, 1.0], rtol=0, atol=1e-12)
    assert np.allclose(jax.vmap(jax.grad(lambda end: grown(end)[2]))(jnp.array([0.7, 1.2])), 1.0)


def test_what_is_not_reached_is_nan():
    """As many occurrences as asked for; times behind the end; a derivative by nan is nan."""

    def falling(k, n=2):
        return solve_ivp(problems.fall, (0, 9), [10.0, 0.0], "DOP853", [0.5, 1.0, 5.0],
                         problems.ground, (k,), occurrences=n, **TIGHT)  # fmt: skip

    found = falling(0.1)
    assert found.status == 1 and np.isnan(found.y[:, 2]).all() and np.isfinite(found.y[:, :2]).all()
    assert found.t_events[0].shape == (2,) and found.y_events[0].shape == (2, 2)
    assert np.isfinite(found.t_events[0][0]) and np.isnan(found.t_events[0][1])
    grad = jax.grad(lambda k: jnp.nansum(falling(k).y[0]))(0.1)
    assert np.allclose(grad, jax.grad(lambda k: falling(k).y[0, :2].sum())(0.1), rtol=1e-12)
    assert np.isfinite(grad) and np.isnan(jax.grad(lambda k: falling(k).y[0].sum())(0.1))
    lost = solve_ivp(pendulum, (0, 3), jnp.array([np.nan, 0.0]), args=VALUES[1:])
    assert lost.status == -1 and np.isnan(lost.y).all()
    many = jax.vmap(lambda y: solve_ivp(pendulum, (0, 3), [y, 0.0], args=(9.81, 0.2)))
    found = many(jnp.array([1.0, jnp.nan]))
    slopes = jax.vmap(jax.grad(lambda y: many(y[None]).y.sum()))(jnp.array([1.0, jnp.nan]))
    assert np.isfinite(slopes[0]) and np.isnan(slopes[1])
    assert np.array_equal(found.status, [0, -1]) and np.isnan(found.y).any((1, 2))[1]


def of_jax(t, y, k, d):
    return jnp.stack([y[1], -k * jnp.sin(y[0])])


def with_global(t, y, k, d):
    return [y[1], -STRAY * y[0]]


@pytest.mark.parametrize(
    "error, words, call",
    [
        (TypeError, "float32; fastdyn computes in float64", lambda k: states(jnp.ones(2, "f4"), k)),
        (TypeError, r"`args\[1\]` is of float32", lambda k: states([1.0, 0.0], k, jnp.float32(1))),
        (
            TypeError,
            r"`args\[1\]` is of int64, and has no",
            lambda k: states([1.0, 0.0], k, k.astype(int)),
        ),
        (TypeError, r"`y0\[1\]` is of int64", lambda k: states([k, jnp.int64(0)], k, 0.2)),
        (
            TypeError,
            "`t_span` is an array of JAX that varies",
            lambda k: solve_ivp(pendulum, (0, k), [1.0, 0.0], args=(k, k)),
        ),
        (
            TypeError,
            "`t_eval` is an array",
            lambda k: solve_ivp(pendulum, (0, 3), [1.0, 0.0], t_eval=[k], args=(k, k)),
        ),
        (TypeError, "`rtol` is an array", lambda k: states([1.0, 0.0], k, k, rtol=k)),
        (TypeError, "must be a tuple", lambda k: solve_ivp(pendulum, (0, 3), [1.0, 0.0], args=k)),
        (
            TypeError,
            "`STRAY`, which `with_global` takes",
            lambda k: states([1.0, 0.0], k, k, fun=with_global),
        ),
        (
            TypeError,
            "`k`, which `inner` takes from outside",
            lambda k: states([1.0, 0.0], fun=enclosed(k)),
        ),
        (
            TypeError,
            "argument 0`, which `fun` takes",
            lambda k: states([1.0, 0.0], fun=functools.partial(lambda k, t, y: y, k)),
        ),
        (
            TypeError,
            "`sensitivity` is no option of fastdyn.jax",
            lambda k: states([1.0, 0.0], k, k, sensitivity="y0"),
        ),
        (ValueError, "`occurrences` must be", lambda k: states([1.0, 0.0], k, k, occurrences=0)),
        (
            ValueError,
            "`method='RK54'` is unknown",
            lambda k: states([1.0, 0.0], k, k, method="RK54"),
        ),
        (ValueError, "one dimension", lambda k: states(jnp.ones((2, 2)), k, k)),
        (
            ValueError,
            "finite span",
            lambda k: solve_ivp(pendulum, (0, np.inf), [1.0, 0.0], args=(k, k), max_steps=9),
        ),
        (
            ValueError,
            "`t_eval` is empty",
            lambda k: solve_ivp(pendulum, (0, 1), [1.0, 0.0], t_eval=[], args=(k, k)),
        ),
        (Exception, "written with NumPy", lambda k: states(VALUES[0], k, k, fun=of_jax)),
        (
            NotImplementedError,
            "differentiated once",
            lambda k: jax.grad(lambda k: states([1.0, 0.0], k, k).sum())(k),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_slips_get_a_sentence(error, words, call):
    """Under a transformation, so that a derivative would be lost without a word."""
    with pytest.raises(error, match=words):
        jax.grad(lambda k: jnp.sum(jnp.asarray(getattr(found := call(k), "y", found))))(9.81)


def enclosed(k):
    def force(x):
        return -k * x

    def inner(t, y):
        return [y[1], force(y[0])]

    return inner


def test_float32_is_refused_where_it_is_the_default():
    jax.config.update("jax_enable_x64", False)
    try:
        with pytest.raises(ValueError, match="jax_enable_x64"):
            solve_ivp(pendulum, (0, 3), [1.0, 0.0], args=(9.81, 0.2))
    finally:
        jax.config.update("jax_enable_x64", True)


class Pair(NamedTuple):
    stiffness: object
    damping: object


@dataclasses.dataclass
class Fields:
    stiffness: object
    damping: object


def nested(t, y, p):
    return [y[1], -p["k"] * np.sin(y[0]) - p["c"][0] * y[1]]


def named(t, y, p):
    return [y[1], -p.stiffness * np.sin(y[0]) - p.damping * y[1]]


def listed(t, y, p):
    return [y[1], -p[0] * np.sin(y[0]) - p[1][0] * y[1]]


def crosses(t, y, p):
    return y[0] - 0.01 * p["k"]


@pytest.mark.parametrize(
    ("fun", "tree"),
    [
        (nested, lambda k, c: {"k": k, "c": [c]}),
        (named, Pair),
        (named, Fields),
        (listed, lambda k, c: (k, [c])),
    ],
)
def test_containers_of_arrays(fun, tree):
    """Values and gradients are those of the same numbers side by side, also under jit and vmap."""

    def loss(k, c):
        return jnp.sum(states(jnp.array([1.0, 0.0]), tree(k, c), fun=fun) ** 2)

    def plain(k, c):
        return jnp.sum(states(jnp.array([1.0, 0.0]), k, c) ** 2)

    given = VALUES[1:]
    both = [jax.value_and_grad(f, (0, 1))(*given) for f in (loss, plain)]
    assert np.allclose(jax.tree.leaves(both[0]), jax.tree.leaves(both[1]), rtol=1e-9)
    many = jnp.linspace(5.0, 9.0, 3), jnp.full(3, 0.2)
    both = [jax.jit(jax.vmap(jax.grad(f)))(*many) for f in (loss, plain)]
    assert np.allclose(*both, rtol=1e-6)


def test_gradients_have_the_form_of_the_container():
    def first(p):
        return states(jnp.array([1.0, 0.0]), p, fun=nested)[0, -1]

    found = jax.grad(first)({"k": VALUES[1], "c": [VALUES[2]]})
    assert set(found) == {"k", "c"} and isinstance(found["c"], list)

    def when(k):
        how = {"args": ({"k": k, "c": [0.2]},), "events": crosses, **TIGHT}
        return solve_ivp(nested, (0, 3), [1.0, 0.0], "Tsit5", **how).t_events[0][0]

    check(when, (VALUES[1],), modes=("fwd", "rev"))
    with pytest.raises(TypeError, match="`project` is a function, and `args` holds arrays in a"):
        states(VALUES[0], {"k": VALUES[1], "c": [0.2]}, fun=nested, project=lambda t, y, p: y)


def test_functions_of_jax_within_fun_are_refused():
    """With and without derivatives, before anything is solved."""

    def wrong(t, y, k):
        return [y[1], -k * jnp.sin(y[0])]

    for k in (2.0, VALUES[1]):
        with pytest.raises(TypeError, match=r"`wrong` uses `jnp`.*np\.sin for jnp\.sin"):
            solve_ivp(wrong, (0, 3), [1.0, 0.0], args=(k,))


def test_a_complex_start_is_refused_as_complex():
    with pytest.raises(TypeError, match="`y0` is of complex128: there are derivatives by real"):
        solve_ivp(pendulum, (0, 3), jnp.array([1.0, 0.0]) + 0j, args=(9.81, 0.2))
