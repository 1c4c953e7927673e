"""Derivatives by a sweep back over the steps of Rodas5P; what Radau shares with it."""

import itertools

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.methods.rodas5p.table import (
    DENSE,
    END_ROW,
    GAMMA,
    SLOPES,
    STAGE_ROWS,
    TIMES,
    C,
)
from fastdyn.solve.adjoint import backward
from fastdyn.solve.adjoint.keeping import Keeping
from support.discrete_solution import by_complex_steps, flat
from support.stiff_gradients import SYSTEMS, on_complex, slopes, van_der_pol

EPS = np.finfo(float).eps
ROWS, TIGHT = ((), *STAGE_ROWS, END_ROW), {"rtol": 1e-9, "atol": 1e-11}


def replayed(name, fun, steps, y, args, t_eval):
    """The outputs of the steps, for complex numbers."""
    found, fun = [], on_complex(fun)
    for t, end in itertools.pairwise(steps):
        h, u, (jac, by_time) = end - t, [], slopes(name, t, y, args)
        w = np.eye(len(y)) / (h * GAMMA) - jac
        for k, row in enumerate(ROWS[:8]):
            state = y + sum((a * x for a, x in zip(row, u, strict=False)), 0.0 * y)
            time = t + (TIMES.floats[k - 1] * h if k else 0.0)
            right = np.array(fun(time, state, *args)) + h * SLOPES.floats[k] * by_time
            before = C[k - 1].floats if k else ()
            right = right + sum((c / h * x for c, x in zip(before, u, strict=True)), 0.0 * y)
            u.append(np.linalg.solve(w, right))
        new = y + sum(a * x for a, x in zip(END_ROW, u, strict=True))
        d = [sum(a * x for a, x in zip(row.floats, u, strict=True)) for row in DENSE]
        for time in t_eval[(t_eval > t) & (t_eval <= end)]:
            x = (time - t) / h
            found.append(y + x * (new - y + (1 - x) * (d[0] + x * (d[1] + d[2] - (1 - x) * d[2]))))
        y = new
    return np.array(found).T


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("room", [Keeping.room, 40])
def test_the_derivatives_are_exact_for_the_discrete_solution(name, room, monkeypatch):
    """Complex steps of the same steps, relative to the effect of each number."""
    monkeypatch.setattr(Keeping, "room", room)
    fun, span, y0, args = SYSTEMS[name]
    t_eval, how = np.linspace(*span, 6)[1:], {"args": args, "rtol": 1e-6, "atol": 1e-9}
    r = solve_ivp(fun, span, y0, "Rodas5P", t_eval, **how, adjoint=("y0", "args"))
    steps = solve_ivp(fun, span, y0, "Rodas5P", **how).t
    g = np.random.default_rng(0).normal(size=r.y.shape)

    def number(*values):
        n = len(y0)
        y = replayed(name, fun, steps, np.array(values[:n]), values[n:], t_eval)
        return (g * y).sum()

    assert np.isclose(number(*y0, *args), (g * r.y).sum(), rtol=1e-9)
    exact, found = by_complex_steps(number, y0, args), flat(r.vjp(g))
    sizes = np.maximum(np.abs([*y0, *args]), 1e-3)
    assert np.abs((found - exact) * sizes).max() <= 1e-9 * np.abs(exact * sizes).max()


@pytest.mark.hunt
@pytest.mark.parametrize("name", ["Rodas5P", "Radau"])
def test_long_diffusion_in_a_band(name):
    """The same as by forward sensitivities, with steps of error control beyond explicit limits."""
    n = 60

    def heat(t, u, flow, heating):
        gain = flow * (u[1:] - u[:-1])
        out = np.concatenate((gain[:1], gain[1:] - gain[:-1], -gain[-1:]))
        return out + heating * np.exp(-t) * u * (1 - u)

    args, x = (30.0 + np.arange(n - 1) % 3, 0.7), np.linspace(0, 1, n)
    given = (heat, (0, 30), np.exp(-30 * (x - 0.4) ** 2), name, [3.0, 30.0])
    a = solve_ivp(*given, args=args, **TIGHT, adjoint=("y0", "args"))
    b = solve_ivp(*given, args=args, **TIGHT, sensitivity=("y0", "args"))
    g = np.random.default_rng(0).normal(size=a.y.shape)
    exact = flat({k: np.einsum("i...k,ik->...", s, g) for k, s in b.sensitivity.items()})
    assert np.abs(flat(a.vjp(g)) - exact).max() <= 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("name", ["Rodas5P", "Radau"])
def test_events_breakpoints_and_repeated_calls(name):
    """A switch at a known time, doses, and a time of an event, by exact exponentials."""

    def fun(t, y, k, force):
        return [-k * (y[0] - (force if t < 1 else 0.0))]

    def half(t, y, k, force):
        return y[0] - 0.5

    for i in range(6):
        k, force = 40.0 + i, 2.0
        r = solve_ivp(
            fun, (0, 3), [1.0], name, [1.0, 2.5], args=(k, force), breakpoints=[1.0],
            events=[half, fastdyn.at([2.0])], on_event=[None, lambda t, y, k, force: y + force],
            **TIGHT, adjoint=("y0", "args"),
        )  # fmt: skip
        assert [len(t) for t in r.t_events] == [2, 1]
        found = flat(r.vjp([[1.0, 1.0]], t_events=[[1.0, 1.0], None]))

        def number(y, k, force):
            one = force + (y - force) * np.exp(-k)
            last = (one * np.exp(-k) + force) * np.exp(-0.5 * k)
            first, second = 1 + np.log(2 * one) / k, 2 + np.log(2 * (one * np.exp(-k) + force)) / k
            return one + last + first + second

        exact = by_complex_steps(number, [1.0], (k, force))
        assert np.allclose(found, exact, rtol=1e-6, atol=1e-8)
    plain = (van_der_pol, (0, 1), [2.0, 0.0], name, [0.5, 1.0])
    for i in range(8):
        r = solve_ivp(*plain, args=(10.0 + i,), adjoint=("y0", "args"))
        again = solve_ivp(*plain, args=[10.0 + i], adjoint=("y0", "args"))
        assert np.array_equal(flat(r.vjp(r.y)), flat(again.vjp(r.y)))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"mass": np.diag([1.0, 0.0])}, "`adjoint` and `mass` do not go together"),
        ({"jac": lambda t, y, mu: np.eye(2)}, "`adjoint` and `jac` .*exact Jacobian"),
        ({"jac": "2-point"}, "`adjoint` and `jac` .*exact Jacobian"),
    ],
)
def test_what_has_no_adjoint(options, words):
    with pytest.raises(ValueError, match=words):
        solve_ivp(
            van_der_pol, (0, 1), [2.0, 0.0], "Rodas5P", args=(1.0,), adjoint="args", **options
        )


def reaction(t, y, rate, spread):
    """Reaction and diffusion on a line, all of u and then all of v: a band in another order."""
    u, v = np.split(y, 2)
    m = len(u)
    ends = np.array([1.0]), np.array([3.0])
    left = [np.concatenate((end, x[:-1])) for end, x in zip(ends, (u, v), strict=True)]
    right = [np.concatenate((x[1:], end)) for end, x in zip(ends, (u, v), strict=True)]
    react = rate * u * u * v
    du, dv = (
        spread * (m + 1) ** 2 * (a - 2.0 * x + b)
        for a, x, b in zip(left, (u, v), right, strict=True)
    )
    return np.concatenate((du + 1.0 + react - 4.0 * u, dv + 3.0 * u - react))


def test_a_band_in_another_order_is_a_band(monkeypatch):
    """The derivatives are those of the components as they stand, to rounding."""
    m = 40
    y0 = np.concatenate((1.0 + np.sin(np.linspace(0.0, 6.0, m)), np.full(m, 3.0)))
    orders = []
    made = backward.rosenbrock_of

    def noted(rows, columns, order):
        table = made(rows, columns, order)
        orders.append((table.lower, table.upper))
        return table

    def gradient():
        how = {"args": (1.0, 0.02), "rtol": 1e-5, "atol": 1e-7, "adjoint": ("y0", "args")}
        r = solve_ivp(reaction, (0, 3), y0, "Rodas5P", t_eval=[1.0, 3.0], **how)
        return r.vjp(np.cos(np.arange(2.0 * 2 * m)).reshape(2 * m, 2))

    monkeypatch.setattr(backward, "rosenbrock_of", noted)
    banded = gradient()
    monkeypatch.setattr(backward, "_order", lambda product: np.arange(product.n))
    full = gradient()
    assert set(orders) == {(2, 2), (m, m)}
    # Each of some 30 steps solves systems of condition below 1 + h |J| = 1e3.
    for name, each in full.items():
        assert abs(banded[name] - each).max() <= 30 * 1e3 * EPS * abs(each).max()
