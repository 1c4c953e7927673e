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
