"""Checkpoints of solves: killed runs go on bit for bit, and wrong files are refused."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn.run import checkpoint, loop

SOLVE = """
import sys
import fastdyn
from fastdyn.run import checkpoint, loop
checkpoint.SECONDS = loop.CHUNK_SECONDS = 0.01
path, kind = sys.argv[1:]
def fun(t, y, k):
    return [y[1], -k * y[0] ** 3]
def hit(t, y, k):
    return y[0]
times = {"t_eval": [1e3, 2.5e4, 3e4]}
given = {"steps": {}, "dense": {"dense_output": True}, "t_eval": times}[kind]
r = fastdyn.solve_ivp(fun, (0, 3e4), [1.0, 0.0], "DOP853", rtol=1e-9, args=(1.0,), events=hit,
                      checkpoint=path or None, compile="shared", **given)
end = r.sol(12345.678) if r.sol else r.y[:, -1]
print(len(r.t), r.nfev, end.tobytes().hex(), r.y.sum().hex(), r.t_events[0].sum().hex(), r.status)
"""


@pytest.mark.parametrize("kind", ["steps", "dense", "t_eval"])
def test_a_killed_solve_goes_on_bit_for_bit(kind, tmp_path):
    path = tmp_path / "run.npz"

    def begin(name):
        return subprocess.Popen(
            [sys.executable, "-c", SOLVE, str(name), kind], text=True, stdout=subprocess.PIPE
        )

    whole = begin("")
    expected = whole.communicate()[0]
    kills = 0
    for delay in (0.01, 0.05):
        process = begin(path)
        seen = path.stat().st_mtime_ns if path.exists() else 0
        while process.poll() is None and not (path.exists() and path.stat().st_mtime_ns > seen):
            time.sleep(0.002)
        time.sleep(delay)
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            kills += 1
        process.communicate()
    process = begin(path)
    answer = process.communicate()[0]
    assert process.returncode == 0 and kills >= 1 and answer == expected


def test_ctrl_c_in_a_solve_writes_a_checkpoint(tmp_path, monkeypatch):

    def fun(t, y):
        return [y[1], -y[0]]

    path, given = tmp_path / "run.npz", {"rtol": 1e-8, "atol": 1e-10}
    expected = fastdyn.solve_ivp(fun, (0, 200), [1.0, 0.0], **given)
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)
    looks = []

    def interrupted(self):
        looks.append(self)
        if len(looks) == 40:
            raise KeyboardInterrupt
        return False

    monkeypatch.setattr(checkpoint.Checkpoint, "due", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fastdyn.solve_ivp(fun, (0, 200), [1.0, 0.0], checkpoint=path, **given)
    run = fastdyn.solve_ivp(fun, (0, 200), [1.0, 0.0], checkpoint=path, **given)
    assert np.array_equal(run.y, expected.y) and run.nfev == expected.nfev
    with pytest.raises(ValueError, match="differs: initial state"):
        fastdyn.solve_ivp(fun, (0, 200), [1.0, 0.1], checkpoint=path, **given)
    with pytest.raises(ValueError, match="`checkpoint` is for compiled"):
        fastdyn.solve_ivp(fun, (0, 200), [1.0, 0.0], OdeSolver, checkpoint=path)
    verlet = {"step": 0.1, "checkpoint": tmp_path / "verlet.npz"}
    first = fastdyn.solve_second_order(lambda t, q: -q, (0, 10), [1.0], [0.0], **verlet)
    again = fastdyn.solve_second_order(lambda t, q: -q, (0, 10), [1.0], [0.0], **verlet)
    assert np.array_equal(first.y, again.y)
