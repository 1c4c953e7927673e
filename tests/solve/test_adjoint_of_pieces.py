"""Derivatives by the pieces of a table where the solution does not see that pieces meet."""

import numpy as np
import pytest

from fastdyn import solve_ivp

N = 4
KNOTS = np.linspace(0.0, 1.0, N + 1)
MIDDLES = 0.5 * (KNOTS[1:] + KNOTS[:-1])


def in_pieces(t, y, u):
    return [y[1], u[min(int(t * N), N - 1)]]


def in_lines(t, y, u):
    return [y[1], np.interp(t, KNOTS, u)]


def by_pieces():
    """Of the way of a mass at the end, 1: a piece acts at its middle."""
    return (1.0 - MIDDLES) / N


def by_lines():
    """A hat acts at its knot; of the halves at the ends, a third of a length inside."""
    found = (1.0 - KNOTS) / N
    found[0], found[-1] = (1.0 - 1.0 / (3 * N)) / (2 * N), 1.0 / (3 * N) / (2 * N)
    return found


@pytest.mark.parametrize("method", ["Tsit5", "RK45", "Rodas5P"])
@pytest.mark.parametrize(("fun", "exact"), [(in_pieces, by_pieces), (in_lines, by_lines)])
def test_equal_pieces_have_derivatives_of_their_own(method, fun, exact):
    """A step reached over pieces that the solution does not tell from each other."""
    n = N + (fun is in_lines)
    for u in (np.geomspace(1.0, 3.0, n), np.ones(n), np.zeros(n), np.linspace(1.0, 2.0, n)):
        for adjoint in ("u", ("y0", "args")):
            r = solve_ivp(
                fun, (0, 1), [0, 0], method, [1.0], args=(u,), adjoint=adjoint, rtol=1e-9, atol=1e-9
            )
            found = r.vjp([[1.0], [0.0]])["u"]
            # at changes of the solution, steps of RK45 are SciPy's, and find them by their errors
            assert np.abs(found - exact()).max() < (1e-5 if method == "RK45" else 1e-14)


HEIGHTS = np.random.default_rng(0).normal(size=(20, 3))
PLACES = np.linspace(-3.0, 3.0, 20) ** 3
READS = {
    "entry": lambda x, t, u, at: u[int(10.5 + 0.1 * np.tanh(x)), 1],
    "from the end": lambda x, t, u, at: u[-2 - int(t), 2],
    "neighbours": lambda x, t, u, at: u[int(t), 0] * (1 + t) + u[int(t) + 1, 0],
    "two indices": lambda x, t, u, at: u[int(t), int(3 * t) % 3],
    "line": lambda x, t, u, at: np.interp(x, at, u[:, 1]),
    "list": lambda x, t, u, at: [at[0], at[3], u[2, 2]][int(0.9 * t)],
}


@pytest.mark.parametrize("n", [2, 12])  # in straight-line code, in loops
@pytest.mark.parametrize("name", READS)
def test_reads_add_at_their_own_entries(name, n):
    """RK4's forward derivatives are those of the same steps."""

    def fun(t, y, u, at):
        push = READS[name](y[0], t, u, at)
        return [np.sin(y[(i + 1) % n]) - 0.1 * push * y[i] for i in range(n)]

    given = {"args": (HEIGHTS, PLACES), "step": 0.03125, "t_eval": [1.0, 2.0]}
    y0 = np.linspace(0.5, 1.0, n)
    r = solve_ivp(fun, (0, 2), y0, "RK4", adjoint=("at", "u"), **given)
    g = np.cos(np.arange(2.0 * n)).reshape(n, 2)
    found = r.vjp(g)
    by = solve_ivp(fun, (0, 2), y0, "RK4", sensitivity=("at", "u"), **given).sensitivity
    for of in ("at", "u"):
        expected = np.einsum("ik,i...k->...", g, by[of])
        size = np.einsum("ik,i...k->...", abs(g), abs(by[of])).max()
        # 64 steps of 4 stages, each of n sums of n roundings
        assert np.abs(found[of] - expected).max() <= 256 * n * np.finfo(float).eps * size
    assert np.count_nonzero(found["u"]) + np.count_nonzero(found["at"])
    again = solve_ivp(fun, (0, 2), y0, "RK4", adjoint=("u", "at"), **given).vjp(g)
    assert all(np.array_equal(again[of], found[of]) for of in found)


def test_the_second_guard_moves_tables(monkeypatch):
    """Alone, where steps do not end at the changes, it takes other steps."""
    from fastdyn.solve.adjoint import solve

    def in_other_pieces(t, y, u):  # gradients are compared in the first solve of a code
        return [2.0 * y[1], u[min(int(t * N), N - 1)]]

    original = solve.run_of
    monkeypatch.setattr(
        solve, "run_of", lambda p, kind: original(p._replace(differentiated=()), kind)
    )
    r = solve_ivp(
        in_other_pieces, (0, 1), [0, 0], "RK45", [1.0], args=(np.ones(N),), adjoint="u", rtol=1e-9,
        atol=1e-9,
    )  # fmt: skip
    assert np.abs(r.vjp([[1.0], [0.0]])["u"] - 2.0 * by_pieces()).max() < 1e-5


def test_the_gradient_asked_for_is_compared_and_no_other():
    """That by y0 is the larger one, and hid an error of 5 % of the one that is wanted."""

    def limited(t, y, tau):
        return [1.0 + np.clip(y[0] - tau, 0.0, 0.2)]

    r = solve_ivp(
        limited, (0, 1), [0.0], "Tsit5", [1.0], args=(0.3,), adjoint="tau", rtol=1e-6, atol=1e-6
    )
    assert abs(r.vjp([[1.0]])["tau"] + 0.2) < 1e-3
