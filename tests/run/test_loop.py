"""The chunk loop: cut anywhere, the bits are the same; it stops when asked; memory stays flat."""

import itertools
import signal
import threading
import tracemalloc
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile import background, memory
from fastdyn.kernels.methods import METHODS
from fastdyn.run import loop, stiffness
from fastdyn.run import output as pieces
from fastdyn.specialise.scalar import watch_kernel

FIXED = {name for name, m in METHODS.items() if not m.error_order}


def spring(t, y, k):
    q, v = y
    return v, -k * q


def rise(t, y, k):
    return y[0]


def solve(method, t_end=20.0, **options):
    options |= {"step": 0.01} if method in FIXED else {"rtol": 1e-6, "atol": 1e-9}
    return fastdyn.solve_ivp(spring, (0, t_end), [1.0, 0.0], method, args=(2.0,), **options)


def same(a, b):
    return all(
        np.array_equal(x, y)
        for x, y in [
            (a.t, b.t),
            (a.y, b.y),
            (a.nfev, b.nfev),
            *zip(a.t_events or [], b.t_events or [], strict=True),
        ]
    )


OUTPUTS = {
    "steps": {},
    "t_eval": {"t_eval": np.linspace(0, 20, 333)},
    "dense": {"dense_output": True},
    "events": {"events": rise},
}


OF_EACH_LOOP = ("RK45", "ode45", "BlanesMoan6", "Gauss8")
CUT = [
    *itertools.product(METHODS, OUTPUTS, ["shared"]),
    *itertools.product(OF_EACH_LOOP, ["steps"], ["inlined"]),
]


@pytest.mark.few(16)
@pytest.mark.parametrize(("method", "output", "tier"), CUT)
def test_chunked_equals_whole_bit_for_bit(method, output, tier, monkeypatch):
    whole = solve(method, compile=tier, **OUTPUTS[output])
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)  # one step a chunk
    monkeypatch.setattr(pieces, "PIECE", 3)
    monkeypatch.setattr(pieces, "PIECE_NUMBERS", 64)
    cut = solve(method, compile=tier, **OUTPUTS[output])
    assert same(whole, cut)
    if output == "dense":
        t = np.linspace(-1, 21, 57)
        assert np.array_equal(whole.sol(t), cut.sol(t))


@pytest.mark.parametrize("method", OF_EACH_LOOP)
def test_changing_the_tier_between_chunks_changes_no_bit(method, monkeypatch, tmp_path):
    expected = solve(method, compile="shared", t_eval=[20.0])
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)
    for price in ("FOR_LLVM", "FOR_A_NUMBER", "FOR_NUMBA"):
        monkeypatch.setattr(fastdyn.specialise.shared_or_inlined, price, 0.0)
    queued = background.idle_job

    def made_at_once(make):
        job = queued(make)
        assert job.wait(120)
        return job

    monkeypatch.setattr(background, "idle_job", made_at_once)
    memory.forget()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))  # nothing is there
    used = []
    original = fastdyn.specialise.shared_or_inlined.inlined_kernel

    def watched(*args, **options):
        kernel = original(*args, **options)
        used.append(kernel)
        return kernel

    monkeypatch.setattr(fastdyn.specialise.shared_or_inlined, "inlined_kernel", watched)
    assert same(expected, solve(method, t_eval=[20.0]))
    assert used[0] is None and used[-1] is not None


@pytest.fixture
def taken(monkeypatch):
    """The steps asked for in each chunk but the first of a solve; no chunk ends by the clock."""
    taken = []
    original = loop.Run.step

    def counted(run, n_steps=1):
        taken.append(n_steps)
        return original(run, n_steps)

    monkeypatch.setattr(loop, "CHUNK_SECONDS", 1e3)  # no chunk ends by the clock
    monkeypatch.setattr(loop.Run, "step", counted)
    return taken


def looks_of(run):
    """The numbers of steps of the looks at a solve, and that of the first one behind its end."""
    looks = [loop.next_look(0)]
    while looks[-1] < run.n_accepted:
        looks.append(loop.next_look(looks[-1]))
    return looks


def test_a_look_shortens_no_chunk_after_it(taken):
    for _ in range(3):  # the first chunk of a repeated solve ends a step before the first look
        taken.clear()
        run = solve("Taylor", t_end=20_000.0, t_eval=[20_000.0])
    assert len(looks_of(run)) > 3 and len(taken) == len(looks_of(run))


def test_looks_that_can_see_nothing_are_left_out(taken):
    run = solve("RK45", t_end=2000.0, compile="shared", t_eval=[2000.0])
    ends = {*itertools.accumulate([loop.FIRST_LOOK, *taken])}
    behind = [k for k in looks_of(run)[1:-1] if k in ends]
    assert behind == [k for k in looks_of(run)[:-1] if k > loop.NOWHERE] != []


def test_solves_that_nothing_looks_at_take_one_chunk(taken):
    for _ in range(stiffness.MOST + 4):
        taken.clear()
        run = solve("RK45", t_end=500.0, compile="shared", t_eval=[500.0])
    assert run.n_accepted > stiffness.MANY and not taken


@pytest.fixture
def ctrl_c():
    """Python's own handler of SIGINT, which a process started in the background lacks."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def interrupt_soon(seconds=0.3):
    timer = threading.Timer(seconds, signal.raise_signal, [signal.SIGINT])
    timer.start()
    return timer


@pytest.mark.parametrize("tier", ["shared", "inlined"])
@pytest.mark.parametrize("method", ["RK45", "RK4"])
def test_ctrl_c_raises_or_returns_what_there_is(method, tier, ctrl_c):
    solve(method, compile=tier, t_end=1.0)
    forever = {"t_end": 1e9, "compile": tier, "t_eval": [0.5, 1e9], "max_steps": 10**8}
    interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        solve(method, **forever)
    interrupt_soon()
    partial = solve(method, on_interrupt="return", **forever)
    assert partial.status == -2 and not partial.success and "Interrupted at t" in partial.message
    assert partial.t.tolist() == [0.5] and partial.n_accepted > 1000


def test_ctrl_c_inside_a_python_function_arrives(ctrl_c):
    table = {}
    interrupted = []

    def slow(t, y):
        table["t"] = t
        if isinstance(t, float) and t > 1.0 and not interrupted:
            interrupted.append(t)
            signal.raise_signal(signal.SIGINT)
        return -y

    with pytest.warns(fastdyn.CompileWarning), pytest.raises(KeyboardInterrupt):
        fastdyn.solve_ivp(slow, (0, 1e9), [1.0], "RK4", step=1e-3, t_eval=[1e9], max_steps=10**6)


def test_progress_is_shown(capsys):
    solve("RK45", progress=True)
    assert "100%" in capsys.readouterr().err


def test_max_steps_says_how_far_it_came_and_what_to_do():
    r = solve("RK45", max_steps=7)
    assert r.status == -1 and r.n_accepted == 7 and len(r.t) == 8
    assert "max_steps" in r.message and "%" in r.message


def peak(t_end):
    solve("RK4", t_end, t_eval=[t_end])
    tracemalloc.start()
    solve("RK4", t_end, t_eval=[t_end])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most


def test_memory_does_not_grow_with_steps():
    small, large = peak(10.0), peak(10_000.0)  # 10^3 and 10^6 steps
    assert large < small + 4096


def test_compiled_code_allocates_nothing_per_step():
    from numba.core.runtime import _nrt_python, rtsys

    _nrt_python.memsys_enable_stats()
    for tier in ("shared", "inlined"):
        for output in OUTPUTS.values():
            before = rtsys.get_allocation_stats().mi_alloc
            r = solve("DOP853", 20_000.0, compile=tier, **output)
            # Numba makes one record for each array of a call, a few hundred steps apart.
            assert rtsys.get_allocation_stats().mi_alloc - before < r.n_accepted / 10


def test_long_output_is_whole():
    r = fastdyn.solve_ivp(spring, (0, 3000), [1.0, 0.0], args=(2.0,), events=rise)
    s = scipy.integrate.solve_ivp(spring, (0, 3000), [1.0, 0.0], args=(2.0,), events=rise)
    assert r.t.shape == s.t.shape and r.nfev == s.nfev
    assert [len(t) for t in r.t_events] == [len(t) for t in s.t_events]
    assert len(r.t) > 8 * pieces.PIECE


def test_threads_do_not_disturb_each_other():
    def one(k):
        return fastdyn.solve_ivp(
            spring, (0, 200), [1.0, 0.0], args=(k,), rtol=1e-8, dense_output=True, events=rise
        )

    ks = np.linspace(1, 5, 40)
    alone = [one(k) for k in ks]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(one, ks))
    assert all(same(a, b) for a, b in zip(alone, together, strict=True))


@pytest.mark.parametrize("method", ["RK45", "BDF", "VelocityVerlet", "Taylor"])
@pytest.mark.parametrize("output", OUTPUTS)
def test_the_loops_for_less_have_the_bits_of_the_whole_loop(monkeypatch, method, output):
    small, whole = solve(method, **OUTPUTS[output]), []

    def watch_whole(problem):
        whole.append(problem)
        return watch_kernel()

    monkeypatch.setattr("fastdyn.run.laid_out.watch_of", watch_whole)
    assert same(small, solve(method, **OUTPUTS[output])) and whole


@pytest.mark.parametrize("n", range(1, 10))
@pytest.mark.parametrize("method", ["RK45", "Taylor"])
def test_outputs_at_once_have_the_bits_of_one_at_a_time(method, n):
    """Four times, and four components, are evaluated side by side."""

    def waves(t, y):
        return np.cos(y) + t

    times, y0 = np.linspace(0.0, 0.01, 8)[1:-1], np.linspace(0.0, 1.0, n)
    many = fastdyn.solve_ivp(waves, (0.0, 0.01), y0, method, t_eval=times, first_step=0.01)
    assert many.n_accepted == 1 and many.y.shape == (n, 6)
    for t, y in zip(times, many.y.T, strict=True):
        one = fastdyn.solve_ivp(waves, (0.0, 0.01), y0, method, t_eval=[t], first_step=0.01)
        assert (one.y[:, 0] == y).all()
