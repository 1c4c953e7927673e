"""The steps that no delay reads any more are dropped; a checkpoint has those that are read."""

import gc
import weakref

import numpy as np
import pytest

from fastdyn import solve_dde
from fastdyn.delays import prepare_dde, run
from fastdyn.run import checkpoint, enough_memory
from fastdyn.run.functions.crawling import SAMPLES, Samples
from support.delayed import mackey_glass

OPTIONS = {"args": (0.2, 0.1, 14.0), "rtol": 1e-7, "atol": 1e-7}
TIMES = np.linspace(0, 1500, 4)
KINDS = {
    "steps": {},
    "times": {"t_eval": TIMES},
    "events": {"t_eval": TIMES, "events": lambda t, y, past, *args: y[0] - past(t - 20.0)[0]},
    "stiff": {"t_eval": TIMES, "method": "Rodas5P"},
    "sensitivity": {"t_eval": TIMES, "sensitivity": "tau"},
}


def governed(t, y, past, a, b, tau):
    return [-a * past(t - 0.5 - b * y[0] ** 2)[0]]


def same(found, wanted):
    for name in ("t", "y", "nfev", "n_rejected", "message", "jumps"):
        np.testing.assert_array_equal(found[name], wanted[name], err_msg=name)
    for name in ("t_events", "y_events"):
        if wanted[name] is not None:
            np.testing.assert_array_equal(found[name][0], wanted[name][0])
    if "sensitivity" in wanted:
        np.testing.assert_array_equal(found.sensitivity["tau"], wanted.sensitivity["tau"])


@pytest.mark.parametrize("kind", KINDS)
def test_dropped_steps_change_no_bit(kind, monkeypatch):
    wanted = solve_dde(mackey_glass, (0, 1500), [0.5], **KINDS[kind], **OPTIONS)
    dropped = []
    monkeypatch.setattr(run, "FEW_NUMBERS", 1)
    grow = run.OnePiece._grow_dense

    def noted(self, o):
        grow(self, o)
        dropped.append((int(o["n_dense"]), len(self.d)))

    monkeypatch.setattr(run.OnePiece, "_grow_dense", noted)
    again = {**OPTIONS, "compile": "inlined"}
    same(solve_dde(mackey_glass, (0, 1500), [0.5], **KINDS[kind], **again), wanted)
    assert len(dropped) > 3 and max(dropped) < (64, 1024)  # of more than 500 steps


def test_the_memory_of_a_long_solve_is_bounded(monkeypatch):
    monkeypatch.setattr(run, "FEW_NUMBERS", 1000)
    solver = prepare_dde(mackey_glass, (0, 30), [0.5], t_eval=[30.0], **OPTIONS)
    rooms = []
    for end in (300, 3000, 30_000):
        solver = prepare_dde(mackey_glass, (0, end), [0.5], t_eval=[end], **OPTIONS)
        rooms.append(solver._equation.run.output.d.size)
    assert rooms[0] <= rooms[1] == rooms[2] <= 2 * 1000


def test_a_function_that_asks_for_what_is_dropped_keeps_it(monkeypatch):
    """The event function reads farther back than the equations, and one at a varying time."""
    monkeypatch.setattr(run, "FEW_NUMBERS", 1)
    for event in (
        lambda t, y, past, *args: y[0] - past(t - 700.0)[0],
        lambda t, y, past, *args: y[0] - past(t / 2)[0],
    ):
        kept = {"t_eval": TIMES, "events": event, **OPTIONS}
        found = solve_dde(mackey_glass, (0, 1500), [0.5], **kept)
        monkeypatch.setattr(run, "FEW_NUMBERS", 2**40)
        same(found, solve_dde(mackey_glass, (0, 1500), [0.5], **kept))
        monkeypatch.setattr(run, "FEW_NUMBERS", 1)
        assert len(found.t_events[0]) > 10


@pytest.mark.parametrize("terminal", [False, 60])
def test_a_solver_follows_the_delays_of_its_events(terminal, monkeypatch):
    """The equations and their delays are those of the solve before."""

    def late(t, y, past, a, b, tau, more):
        return y[0] - past(t - more)[0]

    def fun(t, y, past, a, b, tau, more):
        return mackey_glass(t, y, past, a, b, tau)

    late.terminal = terminal
    asked = {**OPTIONS, "args": (0.2, 0.1, 14.0, 1.0), "events": late, "t_eval": TIMES}
    monkeypatch.setattr(run, "FEW_NUMBERS", 1)
    solver = prepare_dde(fun, (0, 1500), [0.5], **asked)
    for more in (700.0, 3.0, 900.0):
        args = 0.2, 0.1, 14.0, more
        found = solver(args=args)
        same(found, solve_dde(fun, (0, 1500), [0.5], **{**asked, "args": args}))
        assert len(found.t_events[0]) > 10 and found.sol is None


def test_a_past_that_grows_beyond_the_memory_is_told(monkeypatch):
    monkeypatch.setattr(enough_memory, "memory_of_machine", lambda: 2e4)
    with pytest.raises(MemoryError, match="all of them where delays depend on the time or the sta"):
        solve_dde(governed, (0, 900), [0.5], **{**OPTIONS, "args": (2.2, 0.4, 0.0)})


def interrupted_at(calls):
    """A `due` that is interrupted at a call."""
    left = [calls]

    def due(self):
        left[0] -= 1
        if not left[0]:
            raise KeyboardInterrupt
        return False

    return due


def noting(taken):
    """A `begin` that notes the number of steps that it takes."""
    begin = run.DelayRun.begin

    def noted(self, y0, n_steps=0, snapshots=0):
        taken.append(n_steps)
        return begin(self, y0, n_steps, snapshots)

    return noted


@pytest.mark.parametrize("room", [1, 2**40], ids=["dropped", "kept"])
@pytest.mark.parametrize("kind", ["steps", "times", "events", "stiff", "varying", "function"])
def test_a_checkpoint_goes_on_to_the_bit(kind, room, tmp_path, monkeypatch):
    monkeypatch.setattr(run, "FEW_NUMBERS", room)
    fun = mackey_glass
    options = {**OPTIONS, **KINDS.get(kind, {})}
    history = [0.5]
    end = 1500.0
    if kind == "varying":
        fun = governed
        options["args"] = 2.2, 0.4, 0.0
        end = 300.0
    if kind == "function":
        history = lambda t: [0.5 + 0.1 * np.sin(t)]  # noqa: E731
    given = fun, (0, end), history
    file = tmp_path / "run"
    wanted = solve_dde(*given, **options)
    for calls in (1, 2):  # of `due`, after each chunk of steps
        with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
            patch.setattr(checkpoint.Checkpoint, "due", interrupted_at(calls))
            solve_dde(*given, checkpoint=file, **options)
        assert file.exists()
    taken = []
    with monkeypatch.context() as patch:
        patch.setattr(run.DelayRun, "begin", noting(taken))
        found = solve_dde(*given, checkpoint=file, **options)
    assert taken == [0]  # steps before those of the file are put back
    same(found, wanted)
    other = (lambda t: [0.5 + 0.2 * np.sin(t)]) if kind == "function" else [0.6]
    with pytest.raises(ValueError, match="belongs to another run"):
        solve_dde(fun, (0, end), other, checkpoint=file, **options)


def test_what_a_checkpoint_cannot_hold_is_refused(tmp_path):
    acting = {"events": lambda t, y, past, *a: y[0] - 0.9, "on_event": lambda t, y, past, *a: y / 2}
    with pytest.raises(ValueError, match="`checkpoint` and `on_event` do not go together"):
        solve_dde(mackey_glass, (0, 50), [0.5], checkpoint=tmp_path / "a", **acting, **OPTIONS)
    earlier = solve_dde(mackey_glass, (0, 50), [0.5], dense_output=True, **OPTIONS)
    with pytest.raises(ValueError, match="`checkpoint` needs functions that compile"):
        solve_dde(mackey_glass, (50, 90), earlier, checkpoint=tmp_path / "b", **OPTIONS)


def test_a_solve_is_freed_with_its_result(monkeypatch):
    """Without the collector of cycles: polynomials are large."""
    runs = []
    init = run.DelayRun.__init__

    def noted(self, *given):
        init(self, *given)
        runs.append(weakref.ref(self))

    monkeypatch.setattr(run.DelayRun, "__init__", noted)
    gc.collect()
    gc.disable()
    try:
        solve_dde(mackey_glass, (0, 1500), [0.5], **KINDS["events"], **OPTIONS)
        solve_dde(mackey_glass, (0, 1500), [0.5], **KINDS["sensitivity"], **OPTIONS)
        assert len(runs) == 2 and all(each() is None for each in runs)
    finally:
        gc.enable()


@pytest.mark.parametrize("method", ["Tsit5", "Vern7", "Rodas5P"])
def test_steps_that_crawl_along_a_switch_are_told_of(method):
    """A relay with a late part slides along y = 0; delay equations crawled for ever there."""

    def relay(t, y, past):
        return [-2 * np.sign(y[0]) + 0.5 * past(t - 1.0)[0] + 0.3]

    with pytest.warns(UserWarning, match="changes"):
        found = solve_dde(
            relay, (0, 20), [1.0], method, rtol=1e-6, atol=1e-8, max_steps=500_000, t_eval=[20]
        )
    assert found.status == -1 and found.n_accepted < 300_000


def test_a_run_is_examined_behind_steps_that_are_dropped(monkeypatch):
    """Step 100 000 and the next 63 are looked at, when most steps have made room."""
    taken = []
    take = Samples.take

    def noted(self, done, t, y):
        taken.append(done)
        return take(self, done, t, y)

    monkeypatch.setattr(Samples, "take", noted)
    asked = {**OPTIONS, "rtol": 1e-6, "atol": 1e-6, "t_eval": [250_000.0]}
    wanted = solve_dde(mackey_glass, (0, 250_000), [0.5], **asked)
    assert wanted.n_accepted > 100_100 and len(taken) >= SAMPLES
    monkeypatch.setattr(run, "FEW_NUMBERS", 1)
    same(solve_dde(mackey_glass, (0, 250_000), [0.5], **asked, compile="inlined"), wanted)
