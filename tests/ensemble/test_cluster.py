"""Ensembles in blocks: on workers, into a store, through breaks, always to the same bits."""

import concurrent.futures as futures
import functools
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor

import numba
import numpy as np
import pytest

from fastdyn import Shared, solve_ensemble
from fastdyn.ensemble import distribute

G = 2.0
M = 333


def pendulum(t, w, a, damping):
    theta, omega = w
    return [omega, -a * G * np.sin(theta) - damping * omega]


def bottom(t, w, a, damping):
    return w[0]


def problem(**changes):
    given = {
        "fun": pendulum, "t_span": (0, 20), "y0": [1.0, 0.0],
        "args": (np.linspace(1.0, 9.0, M), 0.1), "t_eval": np.linspace(0, 20, 11),
    }  # fmt: skip
    return given | changes


def assert_same(one, other):
    names = ["t", "y", "y_end", "t_end", "status", "nfev", "n_accepted", "n_rejected"]
    for name in names:
        a, b = getattr(one, name)[:], getattr(other, name)[:]
        assert a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(), name
    assert repr(one) == repr(other)
    assert list(one.reduced) == list(other.reduced)
    for name in one.reduced:
        assert one.reduced[name].tobytes() == other.reduced[name].tobytes()
    for name in ("t_events", "y_events"):
        for a, b in zip(getattr(one, name) or [], getattr(other, name) or [], strict=True):
            assert [x.tobytes() for x in a] == [x.tobytes() for x in b]
    assert one[7].message == other[7].message and one[7].y.tobytes() == other[7].y.tobytes()


class Watched(Executor):
    """Counts what is submitted, and does something before one of them."""

    def __init__(self, executor, at=None, action=None):
        self.executor, self.at, self.action, self.futures = executor, at, action, []
        self._max_workers = executor._max_workers

    def submit(self, fn, /, *args, **kwargs):
        if len(self.futures) == self.at:
            self.action()
        self.futures.append(self.executor.submit(fn, *args, **kwargs))
        return self.futures[-1]


def interrupt():
    raise KeyboardInterrupt


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    distributed = pytest.importorskip("distributed", reason="needs dask.distributed")
    with (
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            dashboard_address=None,
            local_directory=tmp_path_factory.mktemp("dask"),
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        yield client


@pytest.fixture
def store(tmp_path):
    pytest.importorskip("zarr", reason="needs zarr")
    return tmp_path / "run.zarr"


@pytest.mark.parametrize(
    "changes",
    [
        {"events": bottom, "reduce": ("max", "rms")},
        {"y0": np.array([np.linspace(0, 3, M), np.ones(M)]).T, "args": (1.0, 0.1), "t_eval": None},
        {"fun": lambda t, w, a, d: [w[1], -a * np.sin(w[0])], "lanes": "scalar"},
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
    monkeypatch.setattr(sys.modules[__name__], "G", 3.0)
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


def in_python(t, w, a, damping):
    return [w[1], -a * w[0] * json.loads("1")]


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
            given |= {"method": "RK4", "step": 0.05, "lanes": "scalar"}
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
            size = distribute.block_size(block, count, 8, 2)
            assert count % size != 1 or count < size
    assert distribute.block_size(None, 10**6, 8, 4) == 10**6 // 64
    assert distribute.block_size(None, 10**6, 8 * 10**4, 4) == distribute.LARGEST // (8 * 10**4)


@pytest.mark.parametrize("events", [None, bottom])
def test_a_stored_run_goes_on_where_it_broke_off(store, events):
    given = problem(events=events, reduce=("max", "mean"))
    with ThreadPoolExecutor(2) as pool:
        breaking = Watched(pool, 5, interrupt)
        with pytest.raises(KeyboardInterrupt) as caught:
            solve_ensemble(**given, client=breaking, store=store, block=30)
        so_far = caught.value.result
        n_done = int((so_far.status == 0).sum())
        assert 30 <= n_done <= 150 and n_done % 30 == 0
        assert set(so_far.status) == {0, -2} and so_far[332].message.startswith("Interrupted")
        rest = Watched(pool)
        whole = solve_ensemble(**given, client=rest, store=store)
        assert len(rest.futures) == 12 - n_done // 30
        assert_same(solve_ensemble(**given), whole)
        again = Watched(pool)
        assert_same(whole, solve_ensemble(**given, client=again, store=store, block=7))
        assert again.futures == []


def test_a_block_without_its_mark_is_solved_again(store):
    given = problem(events=bottom)
    whole = solve_ensemble(**given, store=store, block=50)
    (store / "finished" / "c" / "2").unlink()
    (store / "y" / "c" / "2" / "0" / "0").write_bytes(b"half")
    (store / "status" / "c" / "2").unlink()
    with ThreadPoolExecutor(1) as pool:
        again = Watched(pool)
        assert_same(whole, solve_ensemble(**given, client=again, store=store))
    assert len(again.futures) == 1


SCRIPT = """
import sys, test_cluster
test_cluster.solve_ensemble(**test_cluster.slow(), store=sys.argv[1], block=20, threads=1)
"""


def slow():
    return problem(t_span=(0, 2000), rtol=1e-9, events=bottom)


def test_a_killed_process_goes_on(store):
    expected = solve_ensemble(**slow())
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(store)], cwd=pathlib.Path(__file__).parent
    )

    def count():  # names under which files are written are longer
        return sum(path.name.isdigit() for path in (store / "finished" / "c").glob("*"))

    while process.poll() is None and count() < 3:
        time.sleep(0.005)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    n_done = count()
    assert 3 <= n_done < 17
    with ThreadPoolExecutor(1) as pool:
        rest = Watched(pool)
        assert_same(expected, solve_ensemble(**slow(), client=rest, store=store))
    assert len(rest.futures) == 17 - n_done


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"fun": lambda t, w, a, d: [w[1], -a * w[0]]}, "functions and what they use"),
        ({"args": (np.linspace(1.0, 9.0, M), 0.2)}, "functions and what they use"),
        ({"args": (np.linspace(1.0, 9.5, M), 0.1)}, "members"),
        ({"y0": [1.0, 0.1]}, "members"),
        ({"method": "DOP853"}, "method"),
        ({"t_span": (0, 20.5)}, "span"),
        ({"rtol": 1e-5}, "tolerances and steps"),
        ({"t_eval": None}, "output"),
        ({"reduce": "max"}, "reduce"),
        ({"events": bottom}, "events"),
        ({"lanes": "scalar"}, "lanes"),
        ({"max_steps": 10**6}, "max_steps"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_store_of_another_run_is_refused(changes, what, finished_store):
    with pytest.raises(ValueError, match=f"another run; what differs: .*{what}"):
        solve_ensemble(**problem(**changes), store=finished_store)


@pytest.fixture(scope="module")
def finished_store(tmp_path_factory):
    pytest.importorskip("zarr", reason="needs zarr")
    path = tmp_path_factory.mktemp("stores") / "run.zarr"
    solve_ensemble(**problem(), store=path)
    return path


def test_a_store_of_another_version_or_of_something_else_is_refused(store, monkeypatch):
    import zarr

    zarr.create_group(store.with_name("other"))
    store.with_name("full").mkdir()
    store.with_name("full").joinpath("notes").write_text("mine")
    for name in ("other", "full"):
        with pytest.raises(ValueError, match="something else"):
            solve_ensemble(**problem(), store=store.with_name(name))
    assert os.listdir(store.with_name("full")) == ["notes"]
    solve_ensemble(**problem(), store=store)
    monkeypatch.setattr("fastdyn.__version__", "99")
    with pytest.raises(ValueError, match="what differs: fastdyn"):
        solve_ensemble(**problem(), store=store)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_store_needs_functions_that_others_can_tell(store):
    with pytest.raises(ValueError, match="`store` needs functions that compile"):
        solve_ensemble(**problem(fun=in_python), store=store)


def test_a_store_is_read_when_it_is_indexed_and_by_others(finished_store):
    zarr, xarray = pytest.importorskip("zarr"), pytest.importorskip("xarray")
    stored, local = solve_ensemble(**problem(), store=finished_store), solve_ensemble(**problem())
    assert isinstance(stored.y, zarr.Array) and np.array_equal(stored.y[5:9, 0], local.y[5:9, 0])
    with xarray.open_zarr(finished_store, consolidated=False) as seen:
        assert seen.y.dims == ("trajectory", "component", "time")
        assert np.array_equal(seen.y.sel(time=20.0), local.y[:, :, -1])


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
