"""Claims about runs of `solve_dae`: matrices, chunks, interrupts, threads, the work beside IDA."""

import math
import signal
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bench.problems.daes import AKZO_NOBEL, DAES
from fastdyn import solve_dae
from fastdyn.run import checkpoint, loop
from tests.support.daes import linear, linear_solution

TIGHT = {"rtol": 1e-9, "atol": 1e-11}
START = linear_solution(0.0)


def heated(n, shuffled=None):
    """A rod whose ends have given temperatures; `shuffled` puts the components in disorder."""
    order = np.arange(n) if shuffled is None else np.random.default_rng(shuffled).permutation(n)

    def F(t, u, up):
        u, up = u[order], up[order]
        inside = up[1:-1] - 0.01 * n * n * (u[2:] - 2 * u[1:-1] + u[:-2])
        return np.concatenate(([u[0] - np.sin(t)], inside, [u[-1]]))

    return F, order


@pytest.mark.parametrize("n", [12, 33, 120, 700])
def test_bands_and_sparse_matrices(n):
    """Small full matrices, bands, sparse elimination: the same solution."""
    options = {"rtol": 1e-7, "atol": 1e-9, "t_eval": [1.0]}
    plain = solve_dae(heated(n)[0], (0, 1), np.zeros(n), **options)
    F, order = heated(n, 1)
    mixed = solve_dae(F, (0, 1), np.zeros(n), **options)
    assert plain.success and mixed.success
    assert np.abs(mixed.y[order, 0] - plain.y[:, 0]).max() <= 1e-5
    assert plain.y[0, 0] == pytest.approx(math.sin(1), abs=1e-7)


def test_chunks_do_not_change_a_bit(monkeypatch):
    p = AKZO_NOBEL
    given = p.F, (0, p.end), p.y0, p.yp0
    whole = solve_dae(*given, rtol=1e-6, atol=1e-9, dense_output=True)
    monkeypatch.setattr("fastdyn.run.loop.CHUNK_SECONDS", 0.0)
    steps = solve_dae(*given, rtol=1e-6, atol=1e-9, dense_output=True)
    assert steps.y.tobytes() == whole.y.tobytes() and steps.yp.tobytes() == whole.yp.tobytes()
    times = np.linspace(0, p.end, 99)
    assert steps.sol.derivative(times).tobytes() == whole.sol.derivative(times).tobytes()


def test_an_interrupt_returns_what_there_is():
    endless = {"max_step": 1e-3, "max_steps": 10**8, "t_eval": [0.5, 1e9]}
    solve_dae(linear, (0, 1), *START)
    for choice in ("return", "raise"):
        timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
        timer.start()
        if choice == "return":
            run = solve_dae(linear, (0, 1e9), *START, on_interrupt=choice, **endless)
            assert run.status == -2 and run.t.tolist() == [0.5]
            assert run.yp.shape == run.y.shape == (2, 1)
        else:
            with pytest.raises(KeyboardInterrupt):
                solve_dae(linear, (0, 1e9), *START, **endless)
        timer.join()


def test_threads_solve_at_once():
    def end(k):
        def decay(t, y, yp, k):
            return [yp[0] + k * y[0], y[1] - y[0]]

        return solve_dae(decay, (0, 1), [1.0, 1.0], args=(k,), **TIGHT).y[1, -1]

    rates = np.linspace(0.5, 3.0, 24)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(end, rates))
    assert np.abs(np.array(found) - np.exp(-rates)).max() <= 1e-7


@pytest.mark.parametrize("dae, n_steps, nfev", [(DAES[0], 907, 1265), (DAES[1], 207, 268)])
def test_steps_are_not_more_than_those_of_ida(dae, n_steps, nfev):
    """SUNDIALS' IDA, by scikit-sundae 1.2.0, took so many steps and evaluations at rtol 1e-5."""
    atol = 1e-5 * np.asarray(dae.floor)
    run = solve_dae(dae.F, (0, dae.end), dae.y0, dae.yp0, rtol=1e-5, atol=atol)
    assert run.n_accepted <= 1.2 * n_steps and run.nfev <= 1.2 * nfev
    assert run.njev <= 40 * np.log10(run.n_accepted)


def pendulum(t, y, yp, length):
    x, z, u, v, force = y
    return [yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + 1, x**2 + z**2 - length**2]


CHECKPOINTED = {
    "small": (linear, START, {"events": lambda t, y: y[1]}),
    "sparse": (heated(120, 1)[0], (np.zeros(120), None), {"dense_output": True}),
    "sensitivities": (linear, START, {"sensitivity": "y0"}),
    "higher index": (
        pendulum,
        ([0.6, -0.8, 0, 0, 0], None),
        {"args": (1.0,), "t_eval": [2.0, 3.0]},
    ),
}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", CHECKPOINTED)
def test_an_interrupted_run_goes_on_bit_for_bit(name, tmp_path, monkeypatch):
    F, (y0, yp0), more = CHECKPOINTED[name]

    def solve(**changed):
        return solve_dae(F, (0, 3), y0, yp0, **{**TIGHT, **more, **changed})

    expected, path = solve(), tmp_path / "run.npz"
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)
    looks = []

    def interrupted(self):
        looks.append(self)
        if len(looks) == 8:
            raise KeyboardInterrupt
        return False

    monkeypatch.setattr(checkpoint.Checkpoint, "due", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solve(checkpoint=path)
    run = solve(checkpoint=path)
    for field in ("t", "y", "yp", "nfev", "n_accepted"):
        assert np.array_equal(run[field], expected[field], equal_nan=True), field
    assert str(run.t_events) == str(expected.t_events)
    if "sensitivity" in expected:
        assert np.array_equal(run.sensitivity["y0"], expected.sensitivity["y0"])
    with pytest.raises(ValueError, match="belongs to another run"):
        solve(checkpoint=path, rtol=1e-8)
