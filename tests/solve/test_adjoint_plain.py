"""The `vjp` of plain solves in repeated calls, laid out, is that of first calls."""

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from fastdyn.solve.adjoint.plain import PlainVjp
from support.discrete_solution import flat
from support.repeated import plain

HOW = {"adjoint": ("y0", "args"), "rtol": 1e-6, "atol": 1e-6}


def heat(t, u, diffusivity):
    flow = diffusivity * (u[1:] - u[:-1])
    return np.concatenate((flow[:1], flow[1:] - flow[:-1], -flow[-1:]))


def chain(t, y, k):
    return [-k * y[0], k * y[0] - y[1] * y[2], y[1]]


def both(fun, span, y0, args, t_eval):
    """The results of a repeated call, and of the same call the way of a first one."""
    given = (fun, span, y0, "Tsit5", t_eval)
    found = solve_ivp(*given, args=args, **HOW)
    return found, plain(*given, args=args, **HOW)


def is_laid(result):
    """Whether the sweep of a result is one that is laid out."""
    return type(result.vjp) is PlainVjp and result.vjp._sweeps is not None


def test_steps_that_are_taken_again():
    """The guard acts in each call, and later calls of `vjp` take the steps it found."""
    n, t_eval = 200, np.linspace(0, 40, 10)
    x = np.linspace(0, 1, n)
    for i in range(7):
        args = (1.0 + (0.5 + 0.01 * i) * np.sin(7 * x[1:]),)
        r, first = both(heat, (0, 40), np.exp(-40 * (x - 0.4) ** 2), args, t_eval)
        expected = flat(first.vjp(r.y))
    assert is_laid(r)
    for _ in range(2):
        assert np.array_equal(flat(r.vjp(r.y)), expected)
        assert not is_laid(r) and r.vjp._legs[0].is_whole
    assert np.array_equal(flat(r.vjp(2 * r.y)), flat(first.vjp(2 * r.y)))


def test_what_the_user_changes_later():
    """Outside values, arguments, times and outputs; spans with many more steps; any kind of g."""
    mass, made = {"m": np.array([1.0, 3.0])}, []

    def fun(t, y, k, c):
        return [y[1], -k[0] * np.sin(y[0]) / mass["m"][1] - c * k[1] * y[1]]

    for i in range(12):
        mass["m"] = np.array([1.0, 2.0 + i])
        k, span = np.array([[2.0 + i, 0.0], [0.2, 0.0]])[:, 0], (0, 5 if i < 9 else 400)
        r, first = both(
            fun, span, np.array([1.0, 0.1 * i]), (k, 0.3), np.array([0.0, 1.0, span[1]])
        )
        g = np.cos(r.y)
        made.append((i, r, g, flat(first.vjp(g))))
        k[:], mass["m"][:], r.t[:], r.y[:] = np.nan, np.nan, 7.0, np.nan
    assert sum(is_laid(r) for _, r, _, _ in made) >= 4
    for _, r, g, expected in made:
        for given in (g, np.asfortranarray(g)):
            assert np.array_equal(flat(r.vjp(given)), expected)
        assert np.array_equal(flat(r.vjp(g.tolist())), expected)
    assert r.vjp(g)["k"].shape == (2,) and isinstance(r.vjp(g)["c"], float)


def test_outputs_at_each_step():
    """Without `t_eval`: other numbers of steps, results that are changed later, any kind of g."""

    def fun(t, y, k, c):
        return [y[1], -k[0] * np.sin(y[0]) - c * k[1] * y[1]]

    made = []
    for i in range(14):
        k = np.array([2.0 + i, 0.2])
        span = (0, 40 if i in (8, 11) else 2 + 0.1 * i)
        r, first = both(fun, span, np.array([1.0, 0.1 * i]), (k, 0.3), None)
        assert np.array_equal(r.t, first.t) and np.array_equal(r.y, first.y)
        g = np.cos(r.y)
        made.append((r, g, flat(first.vjp(g))))
        k[:], r.t[:], r.y[:] = np.nan, 7.0, np.nan
    assert sum(is_laid(r) for r, _, _ in made) >= 4
    assert max(g.shape[1] for _, g, _ in made) > 128 > min(g.shape[1] for _, g, _ in made)
    for r, g, expected in made:
        assert np.array_equal(flat(r.vjp(g)), expected)
        assert np.array_equal(flat(r.vjp(g.tolist())), expected)


HELD = np.linspace(0.0, 1.0, 11)
SAMPLED = {  # input(t, u), for 11 samples u
    "held": lambda t, u: u[min(int(abs(t) * 10), 10)],
    "interpolated": lambda t, u: np.interp(abs(t), HELD, u),
}


@pytest.mark.parametrize("name", SAMPLED)
@pytest.mark.parametrize("method", ["Tsit5", "RK45", "Vern9"])
def test_steps_that_end_at_switching_times(name, method):
    """Forward, backward, from and to knots, with breakpoints; neighbours that are equal or not."""
    source = SAMPLED[name]
    rng = np.random.default_rng(len(name))

    def fun(t, y, u, a):
        return [-a * y[0] + source(t, u), y[0] - 0.5 * y[1] ** 2]

    laid = 0
    for span, breakpoints in (
        ((0, 1), None), ((1, 0), None), ((0, -1), None), ((0.13, 0.5), None), ((0, 1), [0.33, 0.5])
    ):  # fmt: skip
        given = {"breakpoints": breakpoints} if breakpoints else {}
        t_eval = np.linspace(*span, 6)
        for i in range(6):
            u = rng.normal(size=11)
            u[3 : 3 + i] = u[3]
            args = (u, 0.7)
            r = solve_ivp(fun, span, [1.0, 0.5], method, t_eval, args=args, **HOW, **given)
            first = solve_ivp(fun, span, [1.0, 0.5], method, t_eval, args=[*args], **HOW, **given)
            g = rng.normal(size=r.y.shape)
            laid += is_laid(r)
            assert np.array_equal(flat(r.vjp(g)), flat(first.vjp(g)))
    assert laid >= 15


def test_components_have_tolerances_of_their_own():
    atol = np.array([1e-6, 1e-9, 1e-7])
    for i in range(7):
        given = ([0.0, 1.0], np.array([1.0, 0.0, 0.5]), "Tsit5", [0.5, 1.0])
        how = {"adjoint": ("y0", "k"), "rtol": 1e-6, "atol": atol}
        r, first = (solve_ivp(chain, *given, args=args, **how) for args in ((1.0 + i,), [1.0 + i]))
        assert np.array_equal(flat(r.vjp(r.y)), flat(first.vjp(r.y)))
    assert is_laid(r)


def test_what_is_wrong_is_told_as_by_first_calls():
    for i in range(7):
        r, _ = both(lambda t, y, k: [k * y[0]], (0, 1), [1.0], (1.0 + i,), [0.5, 1.0])
    assert is_laid(r)
    for g, error, words in (
        (np.full((1, 2), np.nan), ValueError, "`g` contains nan or inf"),
        (np.full((1, 2), np.inf), ValueError, "`g` contains nan or inf"),
        (np.ones((2, 2)), ValueError, r"so its shape, \(1, 2\)"),
        (np.ones((1, 2), complex), TypeError, "real numbers"),
        (np.full((1, 2), 1e308), ValueError, "nan or inf: "),
        (None, TypeError, "real numbers"),
    ):
        with pytest.raises(error, match=words):
            r.vjp(g)
    assert not hasattr(r.vjp, "other") and "2 outputs by 'y0', 'k'" in repr(r.vjp)
    assert np.isclose(r.vjp(np.ones((1, 2)), t_events=[])["y0"][0], np.exp(3.5) + np.exp(7.0))


@pytest.mark.parametrize("method", ["Vern7", "Rodas5P"])
def test_solves_that_are_compared_have_the_segments_of_others(method):
    """The run of a solve that is compared, the fourth say, is laid out anew before its sweep."""
    drag = [1.0, 2.0]

    def fun(t, y):
        return [y[1], -2.0 * y[0] - drag[min(int(2.0 * t), 1)] * y[1]]

    found = [
        solve_ivp(fun, (0.0, 1.0), [0.5, 0.25], method, adjoint="y0", rtol=1e-6, atol=1e-8)
        for _ in range(9)
    ]
    expected = found[0].vjp(np.ones(found[0].y.shape))["y0"]
    for each in found:
        gradient = each.vjp(np.ones(each.y.shape))["y0"]
        np.testing.assert_allclose(gradient, expected, rtol=1e-12)


@pytest.mark.parametrize("option", ["adjoint", "sensitivity"])
def test_an_argument_that_is_not_given_is_told_in_each_call(option):
    def fun(t, y, k=1.0):
        return [-k * y[0]]

    for _ in range(4):
        assert solve_ivp(fun, (0.0, 1.0), [1.0], args=(2.0,), **{option: "k"}).success
    solver = prepare(fun, (0.0, 1.0), [1.0], args=(2.0,), **{option: "k"})
    for _ in range(3):
        with pytest.raises(ValueError, match="k"):
            solver(args=())
