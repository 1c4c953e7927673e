"""Interleaved timing, so that every solver of a row sees the same machine, and what machine."""

import os
import platform
import shutil
import statistics
import subprocess
import time
from importlib import metadata

WARM = 5e-3
CALLS = 50  # before the first that is timed: Python itself learns from them


def interleaved(functions, repetitions=30, seconds=2.0):
    """{name: (minimum, median)} of the run times in seconds, the functions taking turns.

    Stops after `repetitions` turns or when `seconds` are over, with three turns at least.  A call
    shorter than WARM follows an untimed one: after the others of a turn, the first would pay for
    their traces in the caches.
    """
    times = {name: [] for name in functions}
    for function in functions.values():
        _warm_up(function)
    began = time.perf_counter()
    for turn in range(repetitions):
        if turn >= 3 and time.perf_counter() - began > seconds:
            break
        for name, function in functions.items():
            if times[name] and times[name][-1] < WARM:
                function()
            start = time.perf_counter()
            function()
            times[name].append(time.perf_counter() - start)
    return {name: (min(t), statistics.median(t)) for name, t in times.items()}


def _warm_up(function):
    """Call it often, but no longer than a few times WARM."""
    end = time.perf_counter() + 4 * WARM
    for _ in range(CALLS):
        function()
        if time.perf_counter() > end:
            break


LIBRARIES = (
    "numba", "numpy", "scipy", "CyRK", "numbalsoda", "heyoka", "diffrax", "jax", "scikit-sundae",
    "rebound",
)  # fmt: skip


def machine():
    """Versions, processor, threads, load."""
    import fastdyn

    cpu = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            cpu = next(s.split(":")[1].strip() for s in file if s.startswith("model name"))
    except (OSError, StopIteration):
        pass
    versions = {"python": platform.python_version(), "fastdyn": fastdyn.__version__}
    for name in LIBRARIES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = None
    for compiler in ("clang++", "g++"):
        if shutil.which(compiler):
            said = subprocess.run([compiler, "--version"], capture_output=True, text=True)
            versions[compiler] = said.stdout.splitlines()[0]
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "threads": 1,
        "load": load(),
        "versions": versions,
    }


def load():
    """Mean number of running processes of the last minute, if the system tells."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None
