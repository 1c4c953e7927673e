"""Claims about events that change the state in an ensemble."""

import numpy as np
import pytest

from fastdyn import CompileWarning, solve_ensemble, solve_ivp
from tests.support.impacts import bounce, falling, ground, marked

M = 37
TIGHT = {"rtol": 1e-9, "atol": 1e-12}


def balls(simd=False, method="RK45", events=ground, on_event=bounce, **options):
    random = np.random.default_rng(3)
    y0 = np.column_stack([random.uniform(0.5, 2.0, M), random.uniform(-1.0, 1.0, M)])
    e = random.uniform(0.3, 0.95, M)
    options = ({"step": 0.01} if method == "RK4" else TIGHT) | options
    given = {"method": method, "events": events, "on_event": on_event, **options}
    run = solve_ensemble(falling, (0.0, 2.5), y0, (e,), simd=simd, **given)
    given.pop("threads", None)
    return run, lambda i: solve_ivp(falling, (0.0, 2.5), y0[i], args=(float(e[i]),), **given)


@pytest.mark.few
@pytest.mark.parametrize("method", ["RK45", "DOP853", "ode45", "RK4"])
@pytest.mark.parametrize("t_eval", [None, np.linspace(0.0, 2.5, 11)])
def test_each_trajectory_is_the_single_solve(method, t_eval):
    run, single = balls(method=method, t_eval=t_eval)
    assert set(run.status) == {0, -1}  # some come to rest
    for i in range(M):
        one = single(i)
        assert run.status[i] == one.status and run.nfev[i] == one.nfev
        assert np.array_equal(run.t_events[0][i], one.t_events[0])
        assert np.array_equal(run.y_events[0][i], one.y_events[0])
        found = run[i]
        assert np.array_equal(found.y, one.y[:, -1:] if t_eval is None else one.y)
        assert found.message[:40] == one.message[:40]


@pytest.mark.parametrize("events", [ground, marked(ground, terminal=2), [ground, ground]])
def test_vectors_and_threads_give_the_same_motion(events):
    several = isinstance(events, list)
    jumps = [None, bounce] if several else bounce
    run, _ = balls(events=events, on_event=jumps)
    for threads in (1, 2):
        lanes, _ = balls("auto", events=events, on_event=jumps, threads=threads)
        assert lanes.width > 1 and np.array_equal(lanes.status, run.status)
        for i in range(M):
            for k in range(1 + several):
                assert len(lanes.t_events[k][i]) == len(run.t_events[k][i]) or run.status[i] < 0
                n = min(len(lanes.t_events[k][i]), len(run.t_events[k][i]))
                off = lanes.t_events[k][i][:n] - run.t_events[k][i][:n]
                assert np.abs(off).max(initial=0.0) <= 1e-11
        ended = run.status >= 0
        assert np.abs(lanes.y_end - run.y_end)[ended].max() <= 1e-10


def test_constant_steps_run_alone_and_say_why():
    run, _ = balls("auto", "RK4")
    assert run.width == 1 and "constant steps begin anew" in run.reason
    with pytest.raises(ValueError, match="constant steps begin anew after each jump"):
        balls(True, "RK4")


def test_reductions_that_do_not_see_jumps_are_refused():
    kept, _ = balls()
    run, _ = balls(reduce=["final", "first_event"])
    first = [times[0] if len(times) else np.nan for times in kept.t_events[0]]
    assert np.array_equal(run.reduced["first_event"][:, 0], first, equal_nan=True)
    for reduce in ("max", "mean"):
        with pytest.raises(ValueError, match="does not see the jumps of `on_event`"):
            balls(reduce=reduce)


def test_blocks_and_python_functions_give_the_same(tmp_path):
    pytest.importorskip("zarr")
    run, _ = balls()
    stored, _ = balls(store=tmp_path / "balls.zarr", block=10)
    assert np.array_equal(stored.y_end, run.y_end) and np.array_equal(stored.status, run.status)
    seen = []

    def noted(t, y, e):
        seen.append(t)
        return bounce(t, y, e)

    given = {"events": ground, "threads": 1, "simd": False, **TIGHT}
    start = falling, (0.0, 1.0), [1.0, 0.0], (np.array([0.5, 0.9]),)
    plain = solve_ensemble(*start, on_event=bounce, **given)
    with pytest.warns(CompileWarning, match="noted"):
        python = solve_ensemble(*start, on_event=noted, **given)
    assert np.array_equal(plain.y_end, python.y_end) and python.success.all()
    assert sorted(seen) == sorted(np.concatenate(python.t_events[0]))
