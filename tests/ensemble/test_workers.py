"""Ensembles in blocks on workers, always to the same bits."""

import concurrent.futures as futures
import functools
import os
import signal
import sys
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor

import numba
import numpy as np
import pytest

from fastdyn import solve_ensemble
from fastdyn.ensemble import Shared, in_blocks
from support import blocks
from support.blocks import M, Watched, assert_same, bottom, in_python, problem


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    distributed = pytest.importorskip("distributed", reason="needs dask.distributed")
    with (
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address=":0",
            local_directory=tmp_path_factory.mktemp("dask"),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.mark.parametrize(
    "changes",
    [
        {"events": bottom, "reduce": ("max", "rms")},
        {"y0": np.array([np.linspace(0, 3, M), np.ones(M)]).T, "args": (1.0, 0.1), "t_eval": None},
        {"fun": lambda t, w, a, d: [w[1], -a * np.sin(w[0])], "simd": False},
    ],
    ids=["events and reductions", "initial states", "lambda, one at a time"],
)
def test_dask_gives_the_bits_of_the_local_run(client, changes):
    given = problem(**changes)
    assert_same(solve_ensemble(**given), solve_ensemble(**given, client=client, block=50))


def test_a_worker_killed_in_the_middle_loses_nothing(client, monkeypatch):
    given = problem(t_span=(0, 3000), rtol=1e-8, t_eval=None)
    ours = client.get_executor(pure=False)
    ours._max_workers = 2
    victim = next(iter(client.run(os.getpid).values()))
    killing = Watched(ours, 5, lambda: os.kill(victim, signal.SIGKILL))
    monkeypatch.setattr(client, "get_executor", lambda **options: killing)
    assert_same(solve_ensemble(**given), solve_ensemble(**given, client=client, block=30))
    assert len(killing.futures) == 12  # none was lost; dask itself sends those of the dead again
    client.wait_for_workers(2)
    assert victim not in client.run(os.getpid).values()


def test_a_worker_that_sees_other_numbers_is_refused(client, monkeypatch):
    monkeypatch.setattr(blocks, "G", 3.0)
    with pytest.raises(RuntimeError, match="what differs: functions and what they use"):
        solve_ensemble(**problem(), client=client)


class Spring:
    def __init__(self, stiffness):
        self.stiffness = stiffness

    def rhs(self, t, w, a, table, damping):
        return [w[1], -self.stiffness * a * w[0] - table[1] * damping * w[1]]


@numba.njit
def jitted(t, w, a, damping):
    return np.array([w[1], -a * w[0]])


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_functions_of_every_kind_reach_processes():
    table = Shared(np.array([1.0, 2.0]))
    method = functools.partial(Spring(2.0).rhs, damping=0.2)
    kinds = [
        problem(fun=method, args=(np.linspace(1.0, 2.0, M), table)),
        problem(fun=jitted),
        problem(fun=in_python, t_span=(0, 2), t_eval=None),
    ]
    with ProcessPoolExecutor(2) as pool:
        for given in kinds:
            given |= {"method": "RK4", "step": 0.05, "simd": False}
            assert_same(solve_ensemble(**given), solve_ensemble(**given, client=pool, block=111))


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_what_cannot_be_sent_or_is_no_client_is_refused():
    with ProcessPoolExecutor(1) as pool, pytest.raises(TypeError, match="cannot be sent"):
        lock = threading.Lock()
        solve_ensemble(
            **problem(fun=lambda t, w, a, d: [w[1], -a * w[0] * (lock is None)]), client=pool
        )
    with pytest.raises(TypeError, match="`client` must be a dask"):
        solve_ensemble(**problem(), client="localhost:8786")
    with pytest.raises(ValueError, match="`block` must be a whole number"):
        solve_ensemble(**problem(), client=ThreadPoolExecutor(1), block=0)


@pytest.mark.few
@pytest.mark.parametrize("count", [0, 1, 2, 3, 9, 17])
@pytest.mark.parametrize("kept", [False, True], ids=["assembled", "stored"])
@pytest.mark.filterwarnings("error")
def test_any_number_in_any_blocks(count, kept, request):
    given = problem(args=(np.linspace(1.0, 9.0, count), 0.1), events=bottom)
    where = {"store": request.getfixturevalue("store")} if kept else {}
    local = solve_ensemble(**given)
    with ThreadPoolExecutor(2) as pool:
        parts = solve_ensemble(**given, client=pool, block=1, **where)
    for name in ("y", "status", "nfev"):
        assert np.array_equal(getattr(parts, name)[:], getattr(local, name))
    assert list(map(len, parts.t_events[0])) == list(map(len, local.t_events[0]))


def test_no_block_holds_one_of_many():
    for count in range(2, 60):
        for block in range(1, 70):
            size = in_blocks.block_size(block, count, 8, 2)
            assert count % size != 1 or count < size
    assert in_blocks.block_size(None, 10**6, 8, 4) == 10**6 // 64
    assert in_blocks.block_size(None, 10**6, 8 * 10**4, 4) == in_blocks.LARGEST // (8 * 10**4)


class Held(Watched):
    """Lets nothing run until it is told to."""

    def __init__(self, executor):
        super().__init__(executor)
        self.go_on = threading.Event()

    def submit(self, fn, /, *args, **kwargs):
        return super().submit(lambda: (self.go_on.wait(), fn(*args, **kwargs))[1])


def waits(thread):
    """Whether a thread is inside `concurrent.futures.wait`."""
    frame = sys._current_frames()[thread]
    while frame is not None:
        if frame.f_code is futures.wait.__code__:
            return True
        frame = frame.f_back
    return False


def test_ctrl_c_takes_back_what_has_not_begun():
    main = threading.main_thread().ident

    def press():
        while len(held.futures) < 2 or not waits(main):
            time.sleep(0.01)
        signal.pthread_kill(main, signal.SIGINT)

    with ThreadPoolExecutor(1) as pool:
        held = Held(pool)
        threading.Thread(target=press).start()
        result = solve_ensemble(**problem(), client=held, block=50, on_interrupt="return")
        running, waiting = held.futures
        assert running.running() and waiting.cancelled()
        held.go_on.set()
        assert set(result.status) == {-2}
