"""Matrices of implicit methods in each layout: ours, LAPACK's, SuperLU's."""

import warnings

import numpy as np
import pytest
import scipy.integrate
import scipy.sparse

from fastdyn import solve_ivp
from fastdyn.compile import memory
from fastdyn.kernels.calls.block import BAND, FULL, OUTSIDE, OWN
from fastdyn.run import again, checkpoint, loop
from fastdyn.run.matrices import layouts as matrices
from support.stiff import counts

pytestmark = [
    pytest.mark.usefixtures("nothing_is_left_to_scipy"),
    pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning"),
]
METHODS = ("Radau", "BDF")
SPAN, OPTIONS = (0.0, 2.0), {"rtol": 1e-5, "atol": 1e-8}


class Network:
    """y_i' = sum of k (y_j - y_i) over the neighbours j, less y_i^3: a pattern of any form."""

    def __init__(self, n, pairs, k=100.0):
        i, j = np.array(pairs).T
        both = np.r_[i, j], np.r_[j, i]
        near = scipy.sparse.csc_matrix((np.ones(len(both[0])), both), (n, n))
        self.laplacian = k * (near - scipy.sparse.diags(np.asarray(near.sum(0)).ravel()))
        self.y0, self._i, self._j, self._k = 1 + 0.5 * np.cos(np.arange(n)), i, j, k

    def fun(self):
        """One that can be traced."""
        i, j, k = self._i, self._j, self._k

        def fun(t, y):
            flow = k * (y[j] - y[i])
            d = -(y**3)
            for e in range(len(i)):
                d[i[e]] += flow[e]
                d[j[e]] -= flow[e]
            return d

        return fun

    def in_python(self):
        def fun(t, y):
            return eval("a @ y - y**3", {"a": self.laplacian, "y": y})

        return fun

    def jac(self, t, y):
        return self.laplacian - scipy.sparse.diags(3 * y**2)


def chain(n):
    return [(i, i + 1) for i in range(n - 1)]


def tangle(n):
    rng = np.random.default_rng(n)
    return chain(n) + [(i, j) for i, j in rng.integers(0, n, (n, 2)).tolist() if i != j]


NETWORKS = {  # by the layout that their exact Jacobian gets; None: our elimination of full matrices
    None: Network(12, [*chain(12), (11, 0)]),
    "band": Network(40, chain(40)),
    "narrow": Network(60, [(i, i + k) for i in range(54) for k in (1, 6)]),
    "wider band": Network(60, [(i, i + k) for i in range(50) for k in (1, 10)]),
    "ring": Network(50, [*chain(50), (49, 0)]),
    "full": Network(34, [(i, j) for i in range(34) for j in range(i)], k=5.0),
    "corners of zeros": Network(40, [(i, j) for i in range(40) for j in range(max(0, i - 20), i)]),
    "sparse": Network(150, tangle(150)),
}
KINDS = {
    "band": BAND,
    "narrow": OWN,
    "wider band": OWN,
    "ring": BAND,
    "full": FULL,
    "corners of zeros": FULL,
    "sparse": OUTSIDE,
}


def solved(function, network, method, fun="fun", **options):
    given = getattr(network, fun)()
    return function(given, SPAN, network.y0, method, **{**OPTIONS, **options})


@pytest.mark.few
@pytest.mark.parametrize("form", ["exact", "given", "constant", "pattern"])
@pytest.mark.parametrize("kind", NETWORKS, ids=str)
@pytest.mark.parametrize("method", METHODS)
def test_counts_are_scipys_in_each_layout(method, kind, form, monkeypatch):
    network, seen, layout = NETWORKS[kind], [], matrices.layout_of
    looked = lambda *given: seen.append(layout(*given)) or seen[-1]  # noqa: E731
    monkeypatch.setattr(matrices, "layout_of", looked)
    fun = "fun" if form == "exact" else "in_python"
    jac = network.jac(0, network.y0)
    options = {"exact": {}, "given": {"jac": network.jac}, "constant": {"jac": jac}}.get(form)
    ours = solved(solve_ivp, network, method, fun, **(options or {"jac_sparsity": jac != 0}))
    assert ours.success and (seen[-1] and seen[-1].kind) == KINDS.get(kind)
    if form == "exact":
        options = {"jac": network.jac}
    theirs = solved(
        scipy.integrate.solve_ivp, network, method, "in_python",
        **(options or {"jac_sparsity": jac != 0}),
    )  # fmt: skip
    assert counts(ours) == counts(theirs)
    # The same steps: y differs by what is left of Newton's iterations, which stop at some 1e-3 of
    # the tolerance, where solutions of linear systems are rounded differently.
    assert np.abs(ours.y[:, -1] - theirs.y[:, -1]).max() < 0.1 * OPTIONS["rtol"]


@pytest.mark.few
@pytest.mark.parametrize("mass", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_rodas_has_the_end_of_full_matrices_in_each_layout(kind, mass, monkeypatch):
    network = NETWORKS[kind]
    options = {"mass": np.diag(1.0 + np.arange(len(network.y0)) % 3)} if mass else {}
    found = solved(solve_ivp, network, "Rodas5P", **options)
    monkeypatch.setattr(matrices, "SMALL", 10**9)
    monkeypatch.setattr(again, "calls", memory.Table())
    whole = solved(solve_ivp, network, "Rodas5P", **options)
    assert found.n_accepted == whole.n_accepted
    # Nothing is iterated: what differs is rounding, some eps times the condition 1 + h |J| < 1e3.
    assert np.abs(found.y[:, -1] - whole.y[:, -1]).max() < 1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_lsoda_takes_the_steps_of_full_matrices_in_each_layout(kind, monkeypatch):
    network, seen, layout = NETWORKS[kind], [], matrices.layout_of
    looked = lambda *given: seen.append(layout(*given)) or seen[-1]  # noqa: E731
    monkeypatch.setattr(matrices, "layout_of", looked)
    found = solved(solve_ivp, network, "LSODA")
    monkeypatch.setattr(matrices, "_takes_all", lambda *given: True)
    monkeypatch.setattr(again, "calls", memory.Table())
    whole = solved(solve_ivp, network, "LSODA")
    kinds = [layout.kind for layout in seen]  # of a run each, and of a run that is made ready
    assert (kinds[0], kinds[-1]) == (KINDS[kind], FULL) and set(kinds) <= {KINDS[kind], FULL}
    assert counts(found) == counts(whole) and found.njev > 1
    assert np.abs(found.y[:, -1] - whole.y[:, -1]).max() < 1e-10


def test_the_norm_by_which_lsoda_changes_its_formulas_is_that_of_a_full_matrix(monkeypatch):
    """To and fro, with tolerances of their own: the norm is one in units of these."""

    def oscillators(t, y):
        x, v = y[::2], y[1::2]
        return np.stack([v, 10.0 * (1.0 - x * x) * v - x], axis=1).ravel()

    y0 = np.stack([np.linspace(1.0, 2.0, 20), np.zeros(20)], axis=1).ravel()
    options = {"rtol": 1e-6, "atol": np.tile([1e-9, 1e-5], 20)}
    found = solve_ivp(oscillators, (0, 60), y0, "LSODA", **options)
    monkeypatch.setattr(matrices, "_takes_all", lambda *given: True)
    monkeypatch.setattr(again, "calls", memory.Table())
    whole = solve_ivp(oscillators, (0, 60), y0, "LSODA", **options)
    assert counts(found) == counts(whole) and np.array_equal(found.y, whole.y)


def test_a_pattern_that_grows_is_taken_up():
    def fun(t, y):
        return eval("[-1e3 * (y[0] - y[1] ** 2 * (t > 0.5)), -y[1]]", {"t": t, "y": y})

    def jac(t, y):
        m = [[-1e3, 2e3 * y[1] * (t > 0.5)], [0.0, -1.0]]
        return scipy.sparse.csc_matrix(m)

    for method in METHODS:
        found = [
            f(fun, SPAN, [1.0, 1.0], method, jac=jac)
            for f in (scipy.integrate.solve_ivp, solve_ivp)
        ]
        assert counts(found[0]) == counts(found[1])


def test_what_is_wrong_is_named():
    network = NETWORKS["ring"]
    lacking = scipy.sparse.diags([1.0, 1.0, 1.0], [-1, 0, 1], shape=(50, 50))
    for fun in ("fun", "in_python"):
        with pytest.warns(UserWarning, match="`jac_sparsity` is not the pattern .* it lacks"):
            solved(solve_ivp, network, "BDF", fun, jac_sparsity=lacking)
    with pytest.warns(UserWarning, match="`jac` is not the Jacobian of `fun`: at t = 0, row"):
        solved(solve_ivp, network, "BDF", jac=lambda t, y: 2 * network.jac(t, y))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        solved(solve_ivp, network, "BDF", jac=network.jac)
        solved(solve_ivp, network, "BDF", jac_sparsity=network.laplacian)
    for wrong in (np.eye(49), scipy.sparse.eye(51)):
        with pytest.raises(
            ValueError, match=r"`jac_sparsity` is expected to have shape \(50, 50\)"
        ):
            solved(solve_ivp, network, "BDF", jac_sparsity=wrong)
        with pytest.raises(ValueError, match=r"`jac` is expected to have shape \(50, 50\)"):
            solved(solve_ivp, network, "BDF", jac=wrong)


def test_what_a_sparse_jacobian_raises_arrives():
    network, calls = NETWORKS["sparse"], []

    def jac(t, y):
        calls.append(t)
        if len(calls) == 2:
            raise ZeroDivisionError("in jac")
        return network.jac(t, y)

    with pytest.raises(ZeroDivisionError, match="in jac"):
        solved(solve_ivp, network, "BDF", "in_python", jac=jac)
    with pytest.raises(TypeError, match="returned a sparse matrix before"):
        now = iter([network.jac, *[lambda t, y: network.jac(t, y).toarray()] * 99])
        solved(solve_ivp, network, "BDF", "in_python", jac=lambda t, y: next(now)(t, y))


@pytest.mark.few
@pytest.mark.parametrize("method", [*METHODS, "Rodas5P"])
@pytest.mark.parametrize("kind", ["ring", "full", "sparse"])
def test_a_resumed_solve_has_the_bits_of_a_whole_one(method, kind, tmp_path, monkeypatch):
    """The factors of SuperLU are no more then."""
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 1e-9)
    network, path = NETWORKS[kind], tmp_path / "run.npz"
    whole = solved(solve_ivp, network, method)
    for steps in (1, 3, 7, 10**6):
        options = {"checkpoint": path, "max_steps": steps}
        found = solved(solve_ivp, network, method, **options)
    assert np.array_equal(found.y, whole.y) and found.nlu == whole.nlu


def test_ctrl_c_between_solutions(monkeypatch):
    network = NETWORKS["sparse"]
    solve, count = matrices.SparseSolver._made, []

    def made(self, *given):
        count.append(0)
        if len(count) == 3:
            raise KeyboardInterrupt
        return solve(self, *given)

    monkeypatch.setattr(matrices.SparseSolver, "_made", made)
    with pytest.raises(KeyboardInterrupt):
        solved(solve_ivp, network, "BDF")


def test_a_jacobian_without_entries():
    n = 40
    for options in ({"jac": scipy.sparse.csc_matrix((n, n))}, {"jac_sparsity": np.zeros((n, n))}):
        run = solve_ivp(lambda t, y: eval("0 * y + t", {"t": t, "y": y}), (0, 1), np.ones(n), "BDF",
                        rtol=1e-8, **options)  # fmt: skip
        assert np.abs(run.y[:, -1] - 1.5).max() < 1e-4  # atol is 1e-6 a step
