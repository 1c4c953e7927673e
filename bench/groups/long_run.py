"""A billion orbits of a circle by Taylor, stopped by Ctrl-C and continued from the checkpoint."""

import _thread
import math
import pathlib
import tempfile
import threading
import time

import numpy as np

import fastdyn
from fastdyn.systems import SYSTEMS

EPS = 2.3e-16
LOOKS = 1000  # of each run
STOPPED = 60.0  # seconds until Ctrl-C


def rows(quick):
    """Energy and phase by powers of ten orbits, beside Brouwer's estimate 2^-53 sqrt(steps)."""
    orbits = 10_000 if quick else 10**9
    orbit = SYSTEMS["satellite"](V=1.0)
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        study, stopped = stopped_once(orbit, orbits, pathlib.Path(folder) / "orbits.npz")
    us = (time.process_time() - begun) / orbits * 1e6
    energy = study.drifts["energy"]
    largest = np.maximum(abs(energy.low), abs(energy.high))
    so_far = orbits // LOOKS
    while so_far <= orbits:
        looks = so_far * LOOKS // orbits
        yield {
            "orbits": so_far,
            "energy": float(largest[:looks].max()),
            "energy_at_the_end": float(abs(energy.mean[looks - 1])),
            "brouwer": 2.0**-53 * math.sqrt(study.n_steps * (so_far / orbits)),
            "phase": float(abs(study.phase[looks - 1])),
            "us_an_orbit": us,
            "stopped_after": stopped,
        }
        so_far *= 10


def stopped_once(orbit, orbits, checkpoint):
    """The study, and after how many orbits it was stopped: None if it ended before."""

    def study():
        return fastdyn.energy_drift(
            orbit, "Taylor", periods=orbits, samples=LOOKS, every=20, rtol=EPS, atol=EPS,
            checkpoint=checkpoint,
        )  # fmt: skip

    timer = threading.Timer(STOPPED, _thread.interrupt_main)
    timer.start()
    try:
        return study(), None
    except KeyboardInterrupt as stop:
        reached = float(str(stop).split("t = ")[1].split(";")[0])
        return study(), round(reached / orbit.period)
    finally:
        timer.cancel()
