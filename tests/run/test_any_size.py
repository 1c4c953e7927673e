"""States of any length: little memory by explicit methods, a sentence or bands by others."""

import tracemalloc

import numpy as np
import pytest
import scipy.integrate
import scipy.sparse

import fastdyn
from fastdyn.run import enough_memory
from fastdyn.trace.graph.expressions import MAX_NODES

EXACT = np.exp(-0.5)


def decay(t, y):
    return -y


def diffusion(t, u):
    rate = np.zeros_like(u)
    rate[1:-1] = u[2:] - 2 * u[1:-1] + u[:-2]
    return rate


@pytest.mark.parametrize("n", [MAX_NODES // 2, MAX_NODES - 1, MAX_NODES, 100_000])
@pytest.mark.parametrize("method", ["RK45", "Vern9", "auto"])
def test_states_of_any_length_are_solved(n, method):
    result = fastdyn.solve_ivp(decay, (0, 0.5), np.ones(n), method)
    assert abs(result.y[:, -1] - EXACT).max() < 1e-4


def test_a_million_components_take_few_arrays_of_the_state():
    y0 = np.ones(10**6)
    fastdyn.solve_ivp(decay, (0, 0.5), y0)  # compiles
    tracemalloc.start()
    result = fastdyn.solve_ivp(decay, (0, 0.5), y0, dense_output=True)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert abs(result.sol(0.5) - EXACT).max() < 1e-4
    assert most < 60 * y0.nbytes  # 12 of the method, 5 for each of 4 polynomials, results


def all_with_all(t, y):
    return np.mean(y) - y


@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA", "Rodas5P"])
def test_full_matrices_that_no_memory_holds_are_refused_with_a_sentence(method, monkeypatch):
    monkeypatch.setattr(enough_memory, "memory_of_machine", lambda: 1e9)
    with pytest.raises(MemoryError, match=r"this machine has 1: .* or take an explicit method"):
        fastdyn.solve_ivp(all_with_all, (0, 0.5), np.ones(100_000), method)


@pytest.mark.parametrize("method", ["Radau", "BDF", "LSODA", "Rodas5P"])
def test_the_pattern_of_long_states_is_found(method):
    result = fastdyn.solve_ivp(decay, (0, 0.5), np.ones(100_000), method)
    assert abs(result.y[:, -1] - EXACT).max() < 1e-3


@pytest.mark.parametrize("method", ["Radau", "BDF"])
def test_sparse_matrices_have_any_size(method):
    n = 100_000
    pattern = scipy.sparse.diags([1.0, 1.0, 1.0], [-1, 0, 1], shape=(n, n))
    y0 = np.sin(np.arange(n))
    result = fastdyn.solve_ivp(diffusion, (0, 0.5), y0, method, jac_sparsity=pattern)
    expected = fastdyn.solve_ivp(diffusion, (0, 0.5), y0, "DOP853", rtol=1e-9, atol=1e-9)
    assert abs(result.y[:, -1] - expected.y[:, -1]).max() < 1e-2


def test_lsoda_takes_the_band_from_the_trace():
    y0 = np.sin(np.arange(100_000))
    given = {"fun": diffusion, "t_span": (0, 0.5), "y0": y0, "method": "LSODA"}
    given |= {"rtol": 1e-6, "atol": 1e-9}
    found, theirs = fastdyn.solve_ivp(**given), scipy.integrate.solve_ivp(**given, lband=1, uband=1)
    assert found.njev <= theirs.njev + 2 and found.nfev <= theirs.nfev + 10
    np.testing.assert_allclose(found.y[:, -1], theirs.y[:, -1], 0, 1e-5)


def test_a_band_of_lsoda_has_any_size():
    y0 = np.sin(np.arange(100_000))
    given = {"fun": diffusion, "t_span": (0, 0.5), "y0": y0, "method": "LSODA"}
    result = fastdyn.solve_ivp(**given, lband=1, uband=1)
    assert result.t.tolist() == scipy.integrate.solve_ivp(**given, lband=1, uband=1).t.tolist()
