"""Rodas5P: order conditions of its table, order on stiff problems, derivatives however found."""

import itertools

import numpy as np
import pytest

from bench.problems.stiff import STIFF
from fastdyn import METHODS, solve_ivp
from fastdyn.kernels.methods.rodas5p.table import DENSE, END, GAMMA, SLOPES, TIMES, A, C
from support.stiff import PROBLEMS, robertson, robertson_jacobian, solved

EPS = np.finfo(float).eps
N = 8


def lower(rows, ends):
    """A matrix with these rows below its diagonal; `ends` are those that go on the row before."""
    found = np.zeros((N, N))
    for i, row in enumerate(rows, 1):
        found[i, : len(row)] = row.floats
    for i in range(N - ends, N):
        found[i] = found[i - 1]
        found[i, i - 1] = 1.0
    return found


A_MATRIX, C_MATRIX = lower(A, 2), lower(C, 0)
GAMMAS = np.linalg.inv(np.eye(N) / GAMMA - C_MATRIX)
ALPHAS = A_MATRIX @ GAMMAS
M = A_MATRIX[-1] + np.eye(N)[-1]  # weights of the stages in the state at the end
SIZE = 30 * EPS * np.linalg.norm(A_MATRIX, 1) * np.linalg.norm(GAMMAS, 1) ** 2  # of rounding


def trees(order):
    """Rooted trees of so many vertices, each a sorted tuple of its branches."""
    if order == 1:
        return [()]
    found = set()
    for k in range(1, order):
        for smaller, branch in itertools.product(trees(order - k), trees(k)):
            found.add(tuple(sorted((*smaller, branch))))
    return sorted(found)


def vertices(tree):
    return 1 + sum(map(vertices, tree))


def density(tree):
    return vertices(tree) * np.prod([density(branch) for branch in tree])


def elementary_weight(tree):
    """Of each stage: E. Hairer and G. Wanner, section IV.7."""
    matrix = ALPHAS + GAMMAS if len(tree) == 1 else ALPHAS
    return np.prod([matrix @ elementary_weight(branch) for branch in tree], axis=0) * np.ones(N)


def far_from_order(order, weights, x=1.0):
    """The largest residual of the conditions of this order, for the state at the share x."""
    return max(
        abs(weights @ GAMMAS @ elementary_weight(tree) - x**order / density(tree))
        for tree in trees(order)
    )


def test_there_are_as_many_trees_as_known():
    assert [len(trees(order)) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]


def test_order_conditions_hold():
    embedded = A_MATRIX[-1]  # without the last stage
    for order in range(1, 6):
        assert far_from_order(order, M) < SIZE
    assert far_from_order(6, M) > 1e3 * SIZE
    for order in range(1, 5):
        assert far_from_order(order, embedded) < SIZE
    assert far_from_order(5, embedded) > 1e3 * SIZE
    d1, d2, d3 = (np.array(row.floats) for row in DENSE)
    for x in (0.1, 0.5, 0.9):
        weights = x * (M + (1 - x) * (d1 + x * (d2 + x * d3)))
        for order in range(1, 5):
            assert far_from_order(order, weights, x) < 10 * SIZE


def test_times_and_slopes_are_sums_of_rows():
    assert np.abs(ALPHAS.sum(1)[1:] - TIMES.floats).max() < SIZE
    assert np.abs(GAMMAS.sum(1) - SLOPES.floats).max() < SIZE
    assert np.abs((M @ GAMMAS / GAMMA)[:-1] - END.floats).max() < SIZE


def test_it_is_l_stable():
    """|R| <= 1 on the imaginary axis, where it is largest; 0 at infinity."""
    b, beta = M @ GAMMAS, ALPHAS + GAMMAS
    one = np.ones(N)
    for y in np.geomspace(1e-2, 1e3, 200):
        z = 1j * y
        assert abs(1 + z * (b @ np.linalg.solve(np.eye(N) - z * beta, one))) < 1 + SIZE
    assert abs(1 - b @ np.linalg.solve(beta, one)) < SIZE


def at_fixed_steps(h, *given, **options):
    return solve_ivp(
        *given, "Rodas5P", first_step=h, max_step=h, rtol=1e6, atol=1e6, **options
    )  # fmt: skip


def slope(steps, errors):
    return np.polyfit(np.log(steps), np.log(errors), 1)[0]


def prothero_robinson(t, y):
    return -1e6 * (y - np.sin(t + 1.0)) + np.cos(t + 1.0)


@pytest.mark.parametrize("jac", [None, "2-point"])
def test_order_on_a_stiff_problem(jac):
    """The problem of A. Prothero and A. Robinson, Math. Comp. 28 (1974), where h lambda is large:
    errors are some h^3 / lambda, where a wrong time derivative leaves h."""
    steps, errors = 2.0 ** -np.arange(1, 4), []
    for h in steps:
        run = at_fixed_steps(h, prothero_robinson, (0, 2), [np.sin(1.0)], jac=jac)
        assert len(run.t) == 2 / h + 1
        errors.append(np.abs(run.y[0] - np.sin(run.t + 1.0)).max())
    assert slope(steps, errors) > 2.9 and errors[0] < 1e-2 * steps[0] ** 3 / 1e6


def test_order_whatever_the_stiffness():
    """The largest error over lambda goes with h^4: between h^5 and, beyond h lambda = 1,
    h^3 / lambda."""
    steps = 2.0 ** -np.arange(1, 7)
    errors = np.zeros(len(steps))
    for rate in np.geomspace(1.0, 1e8, 17):
        for i, h in enumerate(steps):
            run = at_fixed_steps(
                h, lambda t, y, rate: -rate * (y - np.sin(t + 1.0)) + np.cos(t + 1.0), (0, 2),
                [np.sin(1.0)], args=(rate,),
            )  # fmt: skip
            errors[i] = max(errors[i], np.abs(run.y[0] - np.sin(run.t + 1.0)).max())
    assert abs(slope(steps, errors) - 4) < 0.5


@pytest.mark.parametrize("tol", [1e-4, 1e-6])
def test_a_linear_invariant_outlives_stiffness(tol):
    """E5's y1 - y2 - y3, in which nothing damps an error and 1e-20 is all of the end.

    Eliminations leave some eps h |J| of the increments in it, eps 1e8 1e-13 where it counts: 1e-20
    without the equation of the end.
    """
    p = next(s.problem for s in STIFF if s.problem.name == "E5")
    run = solve_ivp(p.fun, p.t_span, p.y0, "Rodas5P", rtol=tol, atol=tol * 1e-22)
    y = run.y[:, -1]
    assert run.status == 0 and abs(y[1] - y[2] - y[3]) < 0.05 * (y[1] + y[2])


def semi_explicit(t, y):
    """y = sin(t), and z the square root in it."""
    root = np.sqrt(1.0 + y[0] ** 2 + t)
    return [np.cos(t) + y[1] - root, y[1] ** 2 - 1.0 - y[0] ** 2 - t]


def test_order_on_a_dae():
    """5, as of an ODE."""
    steps, errors = 2.0 ** -np.arange(2, 6), []
    for h in steps:
        run = at_fixed_steps(h, semi_explicit, (0, 2), [0.0, 1.0], mass=np.diag([1.0, 0.0]))
        exact = np.sin(2.0), np.sqrt(1 + np.sin(2.0) ** 2 + 2.0)
        errors.append(np.abs(run.y[:, -1] - exact).max())
    assert abs(slope(steps, errors) - 5) < 0.5


@pytest.mark.parametrize("name", PROBLEMS)
def test_its_solution_is_that_of_radau(name):
    p = PROBLEMS[name]._replace(options={"rtol": 1e-9, "atol": 1e-12})
    ours, theirs = (solved(solve_ivp, p, method) for method in ("Rodas5P", "Radau"))
    assert ours.status == 0 and ours.nlu == ours.n_accepted + ours.n_rejected
    assert ours.y[:, -1] == pytest.approx(theirs.y[:, -1], rel=1e-6, abs=1e-9)


def with_a_loop(t, y):
    x = t
    while x > 1e3:  # no graph: Numba compiles it
        x /= 2
    return [-50.0 * (y[0] - np.cos(t)), y[0] - y[1]]


def without(t, y):
    return [-50.0 * (y[0] - np.cos(t)), y[0] - y[1]]


@pytest.mark.parametrize(
    "fun, jac, tol",
    [(with_a_loop, None, 1e-6), (without, "2-point", 1e-6), (without, [[-50, 0], [1, -1]], 1e-10)],
)
def test_differences_do_for_derivatives(fun, jac, tol):
    """Those by time and by y, which are 1e-8 of them off."""
    given = (0, 5), [0.0, 1.0], "Rodas5P", None
    exact = solve_ivp(without, *given, rtol=tol, atol=tol)
    other = solve_ivp(fun, *given, rtol=tol, atol=tol, jac=jac)
    assert abs(other.n_accepted - exact.n_accepted) <= 1
    assert np.abs(other.y[:, -1] - exact.y[:, -1]).max() < 0.01 * tol
    assert other.nfev > exact.nfev


def test_differences_near_an_equilibrium():
    """Robertson's derivatives become small beside their terms; differences do not with them."""
    p = PROBLEMS["Robertson"]
    given = {"rtol": 1e-9, "atol": 1e-13}
    exact, other = (
        solve_ivp(p.fun, p.t_span, p.y0, "Rodas5P", **given, jac=jac) for jac in (None, "2-point")
    )
    assert other.status == 0 and other.n_accepted < 1.2 * exact.n_accepted


def test_a_jacobian_is_taken_a_sparse_one_too():
    import scipy.sparse

    def sparse(t, y):
        return scipy.sparse.csc_matrix(robertson_jacobian(t, y))

    given = (robertson, (0, 40), [1.0, 0.0, 0.0], "Rodas5P")
    exact = solve_ivp(*given)
    for jac in (robertson_jacobian, sparse):
        own = solve_ivp(*given, jac=jac)
        assert own.n_accepted == exact.n_accepted and own.njev == exact.njev == exact.n_accepted
    with pytest.raises(ValueError, match="Rodas5P takes no complex `y0`"):
        solve_ivp(lambda t, y: 1j * y, (0, 1), [1j], "Rodas5P")


def test_what_blows_up_says_so():
    run = solve_ivp(lambda t, y: y**2, (0, 2), [1.0], "Rodas5P", rtol=1e-6)
    assert run.status == -1 and "blows up" in run.message and abs(run.t[-1] - 1) < 1e-4


def test_checkpoints_ensembles_and_prepared_solvers_take_the_same_steps():
    import fastdyn

    mus = np.array([10.0, 100.0])
    p = PROBLEMS["van der Pol"]
    given = (p.fun, (0, 20), [2.0, 0.0])
    alone = [solve_ivp(*given, "Rodas5P", args=(mu,), rtol=1e-5) for mu in mus]
    many = fastdyn.solve_ensemble(*given, (mus,), "Rodas5P", rtol=1e-5, simd=False)
    solver = fastdyn.prepare(*given, "Rodas5P", args=(1.0,), rtol=1e-5)
    for i, run in enumerate(alone):
        assert np.array_equal(many.y_end[i], run.y[:, -1]) and many.nfev[i] == run.nfev
        assert np.array_equal(solver(args=(mus[i],)).y, run.y)
    assert METHODS["Rodas5P"].takes_mass
