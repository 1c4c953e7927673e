"""Checkpoints of studies: killed runs go on bit for bit, and wrong files are refused."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import fastdyn
from fastdyn.drift import survey
from fastdyn.kernels.methods import METHODS
from fastdyn.run import checkpoint, loop
from fastdyn.systems import satellite

ORBIT = satellite(V=1.14)

SCRIPT = """
import sys
from fastdyn import energy_drift, systems
from fastdyn.run import loop
from fastdyn.run import checkpoint
checkpoint.SECONDS = loop.CHUNK_SECONDS = 0.02
method, path = sys.argv[1:]
step = {"rtol": 1e-9, "atol": 1e-12} if method in ("RK45", "Vern9") else {"step": 0.02}
study = energy_drift(systems.satellite(V=1.14), method, t_end=float(sys.stdin.read()), samples=100,
                     checkpoint=path or None, compile="shared", **step)
energy = study.drifts["energy"]
print(study.n_steps, study.nfev, study.y.tobytes().hex(), energy.mean.tobytes().hex())
print(energy.rms.hex(), energy.largest.hex())
"""


def start(method, path, t_end):
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, method, str(path)], text=True, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, env=os.environ | {"PYTHONWARNINGS": "ignore"},
    )  # fmt: skip
    process.stdin.write(str(t_end))
    process.stdin.close()
    return process


RUNS = {"VelocityVerlet": 3e5, "RK45": 3e4}


@pytest.mark.hunt
@pytest.mark.parametrize("method", RUNS)
def test_a_killed_run_goes_on_bit_for_bit(method, tmp_path):
    path = tmp_path / "run.npz"
    whole = start(method, "", RUNS[method])
    expected = whole.stdout.read()
    assert whole.wait() == 0
    kills = 0
    for delay in (0.05, 0.11, 0.02):
        process = start(method, path, RUNS[method])
        seen = path.stat().st_mtime_ns if path.exists() else 0
        while process.poll() is None and not (path.exists() and path.stat().st_mtime_ns > seen):
            time.sleep(0.005)
        time.sleep(delay)
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
            kills += 1
        process.wait()
    process = start(method, path, RUNS[method])
    answer = process.stdout.read()
    assert process.wait() == 0 and kills >= 1 and answer == expected


EVERY_METHOD = """
import os, pathlib, random, signal, sys, time
from fastdyn import energy_drift, systems
from fastdyn.run import loop
from fastdyn.run import checkpoint
from fastdyn.kernels.methods import METHODS

loop.CHUNK_SECONDS = 0.005
orbit = systems.satellite(V=1.14)


def velocity(t, p):
    return [p[0] / (1.0 + p[0] * p[0]) ** 0.5]


def force(t, q):
    return [-q[0]]


def energy(t, y):
    return (1.0 + y[1] * y[1]) ** 0.5 + 0.5 * y[0] * y[0]


pair = {"y0": [1.0, 0.0], "invariants": {"energy": energy}}


def run(system, method, given, t_end, path):
    size = {"rtol": 1e-9, "atol": 1e-12} if METHODS[method].error_order else {"step": 0.02}
    study = energy_drift(system, method, t_end=t_end, samples=50, checkpoint=path, compile="shared",
                         **size, **given)
    parts = [(d.mean.tobytes(), d.rms, d.largest) for d in study.drifts.values()]
    return study.n_steps, study.nfev, study.y.tobytes(), parts


def killed(path, go):
    seen = path.stat().st_mtime_ns if path.exists() else 0
    child = os.fork()
    if child == 0:
        checkpoint.SECONDS = 0.005
        go(path)
        os._exit(0)
    while os.waitpid(child, os.WNOHANG)[0] == 0:
        if path.exists() and path.stat().st_mtime_ns > seen:
            time.sleep(random.uniform(0.0, 0.03))
            os.kill(child, signal.SIGKILL)
            return os.waitpid(child, 0)[1] == signal.SIGKILL
        time.sleep(0.001)
    return False


runs = [(orbit, method, {}) for method in METHODS] + [((velocity, force), "KahanLi8", pair)]
for i, (system, method, given) in enumerate(runs):
    path = pathlib.Path(sys.argv[1], f"{i}.npz")
    run(system, method, given, 5.0, None)  # compiles
    t_end, kills = 100.0, 0
    while not kills:  # too short a run ends before it is killed
        t_end *= 3.0
        path.unlink(missing_ok=True)
        kills = sum(killed(path, lambda to: run(system, method, given, t_end, to)) for _ in "12")
    same = run(system, method, given, t_end, path) == run(system, method, given, t_end, None)
    print(method, "same" if same else "another")
"""


@pytest.mark.hunt
def test_every_method_killed_at_random_goes_on_bit_for_bit(tmp_path):
    """In copies of one process that has compiled everything, to keep it short."""
    words = [sys.executable, "-c", EVERY_METHOD, str(tmp_path)]
    done = subprocess.run(words, text=True, capture_output=True)
    assert done.returncode == 0, done.stderr
    expected = [f"{method} same" for method in [*METHODS, "KahanLi8"]]
    assert done.stdout.splitlines() == expected


def small(path, **options):
    given = {"step": 0.05, "n_steps": 2000, "samples": 20, **options}
    method = given.pop("method", "VelocityVerlet")
    return fastdyn.energy_drift(given.pop("system", ORBIT), method, checkpoint=path, **given)


def test_a_checkpoint_of_another_run_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    first = small(path)
    assert np.array_equal(small(path).y, first.y)  # finished: nothing left to do
    for change, name in (
        ({"method": "BlanesMoan6"}, "method"),
        ({"step": 0.04}, "step"),
        ({"n_steps": 3000}, "end of the run"),
        ({"system": satellite(V=1.15)}, "initial state"),
        ({"y0": [1.0, 0.0, 0.0, 1.13]}, "initial state"),
        ({"samples": 30}, "samples"),
    ):
        with pytest.raises(ValueError, match=f"belongs to another run.*{name}"):
            small(path, **change)
    with pytest.raises(ValueError, match="differs: functions"):
        small(path, invariants={"energy": lambda t, w, GM: w[0]})


def test_a_damaged_checkpoint_is_refused(tmp_path):
    path = tmp_path / "run.npz"
    small(path)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match="not a whole checkpoint"):
        small(path)
    with np.load(fastdyn_file(data, path)) as file:
        arrays = {name: file[name] for name in file.files}
    arrays["work"][0, 0] += 1e-9
    np.savez(path, **arrays)
    with pytest.raises(ValueError, match="altered or damaged"):
        small(path)
    assert not list(tmp_path.glob("*.tmp"))


def fastdyn_file(data, path):
    path.write_bytes(data)
    return path


def test_a_function_that_only_this_process_knows_has_no_checkpoint(tmp_path):
    seen = []

    def remembering(t, y):
        seen.append(t)
        return [y[1], -y[0]]

    given = {"y0": [1.0, 0.0], "invariants": {"q": lambda t, y: y[0]}}
    with (
        pytest.warns(fastdyn.CompileWarning),
        pytest.raises(ValueError, match="this process alone"),
    ):
        fastdyn.energy_drift(
            remembering, "RK4", step=0.1, n_steps=10,
            checkpoint=tmp_path / "x.npz", **given,
        )  # fmt: skip


def test_ctrl_c_writes_a_checkpoint_and_says_how_to_go_on(tmp_path, monkeypatch):
    path = tmp_path / "run.npz"
    expected = small(tmp_path / "other.npz")
    monkeypatch.setattr(survey, "FIRST_STEPS", 100)
    monkeypatch.setattr(loop, "CHUNK_SECONDS", 0.0)
    looks = []

    def interrupted(self):
        looks.append(self)
        if len(looks) == 5:
            raise KeyboardInterrupt
        return False

    monkeypatch.setattr(checkpoint.Checkpoint, "due", interrupted)
    with pytest.raises(KeyboardInterrupt, match="the same call with the same `checkpoint`"):
        small(path)
    monkeypatch.setattr(checkpoint.Checkpoint, "due", lambda self: False)
    assert np.array_equal(small(path).y, expected.y)
