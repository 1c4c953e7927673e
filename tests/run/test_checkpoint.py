"""Checkpoints of solves: killed runs go on bit for bit, and wrong files are refused."""

import errno
import os
import pathlib
import pickle
import signal
import subprocess
import sys
import time
import traceback
import warnings

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


@pytest.mark.few(1)
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
    first = fastdyn.solve.solve_second_order(lambda t, q: -q, (0, 10), [1.0], [0.0], **verlet)
    again = fastdyn.solve.solve_second_order(lambda t, q: -q, (0, 10), [1.0], [0.0], **verlet)
    assert np.array_equal(first.y, again.y)


def swing(t, y):
    return [y[1], -y[0]]


def solve(path, **more):
    return fastdyn.solve_ivp(swing, (0, 60), [1.0, 0.0], checkpoint=path, rtol=1e-8, **more)


def study(path):
    given = {"y0": [1.0, 0.0], "invariants": {"first": lambda t, y: y[0]}}
    return fastdyn.energy_drift(
        swing, "RK4", step=0.01, n_steps=20_000, checkpoint=path, samples=10, **given
    )


@pytest.fixture(params=[solve, study])
def run(request, monkeypatch):
    """A run with many writes."""
    monkeypatch.setattr(checkpoint, "SECONDS", 0.0)
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 1e-4)
    return request.param


@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT, errno.EIO])
def test_a_full_disk_is_a_warning_and_the_run_goes_on(run, call, number, tmp_path, monkeypatch):
    path, writes = tmp_path / "run.npz", []
    original = getattr(os, call)

    def full_after_two(*given):
        writes.append(given)
        if len(writes) > 2:
            raise OSError(number, os.strerror(number))
        return original(*given)

    expected = run(None)
    monkeypatch.setattr(checkpoint.os, call, full_after_two)
    with pytest.warns(UserWarning, match="was not written.*The run goes on") as said:
        result = run(path)
    assert len(writes) > 3 and len(said) == 1  # it is said once
    assert np.array_equal(result.y, expected.y)
    assert [p.name for p in tmp_path.iterdir()] == ["run.npz"]  # the last whole one
    monkeypatch.setattr(checkpoint.os, call, original)
    assert np.array_equal(run(path).y, expected.y)


def test_each_time_that_the_disk_is_full_is_said(tmp_path, monkeypatch):
    file = checkpoint.Checkpoint(tmp_path / "run.npz", {})
    original, full = os.fsync, True

    def fsync(descriptor):
        if full:
            raise OSError(errno.ENOSPC, "full")
        original(descriptor)

    monkeypatch.setattr(checkpoint.os, "fsync", fsync)
    for full, n_said in ((True, 1), (True, 0), (False, 0), (True, 1)):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            assert file.save({"a": np.zeros(3)}) != full
        assert len(said) == n_said and not file.due()


def test_where_nothing_can_be_written_is_said_before_the_run(run, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*; make it first"):
        run(tmp_path / "nowhere" / "run.npz")
    with pytest.raises(FileNotFoundError, match="there is no folder"):
        run(tmp_path / "file" / "run.npz")
    with pytest.raises(IsADirectoryError, match="is a folder; give a file"):
        run(tmp_path)
    import tempfile

    def refused(number):
        def make(**given):
            raise OSError(number, os.strerror(number))

        return make

    monkeypatch.setattr(tempfile, "NamedTemporaryFile", refused(errno.EACCES))
    with pytest.raises(PermissionError, match=r"nothing can be written to .*: Permission"):
        run(tmp_path / "run.npz")
    monkeypatch.setattr(tempfile, "NamedTemporaryFile", refused(errno.ENOSPC))
    with pytest.warns(UserWarning, match="No space left"):  # there may be some soon
        run(tmp_path / "run.npz")


def npy(path):
    np.save(path, np.zeros(3))
    return pathlib.Path(f"{path}.npy").read_bytes()


def npz(path, **arrays):
    np.savez(path, **arrays)
    return pathlib.Path(f"{path}.npz").read_bytes()


GARBAGE = {
    "nothing": lambda path: b"",
    "garbage": lambda path: b"garbage" * 100,
    "pickle": lambda path: pickle.dumps({"y": 1}),
    "text": lambda path: b"t,y\n0,1\n",
    "npy": npy,
    "objects": lambda path: npz(path, header=np.array([{}], dtype=object), digest="0"),
    "other arrays": lambda path: npz(path, y=np.zeros(3)),
    "header without JSON": lambda path: npz(path, header="{", digest="0"),
    "header of a list": lambda path: npz(path, header="[]", digest="0"),
    "half": lambda path: npz(path, header="{}", digest="0")[:200],
    "zip signature alone": lambda path: b"PK\x03\x04" + b"\0" * 50,
    "npy without end": lambda path: b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 100,
}


@pytest.mark.parametrize("kind", GARBAGE)
def test_garbage_is_named_without_an_invitation_to_unpickle_it(run, kind, tmp_path):
    path = tmp_path / "run.npz"
    path.write_bytes(GARBAGE[kind](tmp_path / "other"))
    with pytest.raises(ValueError, match=r"not a whole checkpoint.*remove this one") as caught:
        run(path)
    text = "".join(traceback.format_exception(caught.value))
    assert "allow_pickle" not in text and "another exception" not in text


def test_a_checkpoint_with_arrays_of_another_shape_is_refused(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    whole = study(path)
    save, written = checkpoint.Checkpoint.save, []

    def other(self, arrays):
        written.append(self)
        return save(self, {**arrays, "bins": np.zeros((1, 3, 2))})

    path.unlink()
    monkeypatch.setattr(checkpoint.Checkpoint, "save", other)
    assert np.array_equal(study(path).y, whole.y) and written
    with pytest.raises(ValueError, match="its `bins` is another"):
        study(path)
