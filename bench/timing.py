"""Interleaved timing, so that every solver of a row sees the same machine, and what machine."""

import os
import platform
import statistics
import time


def interleaved(functions, repetitions=30, seconds=2.0):
    """{name: (minimum, median)} of the run times in seconds, the functions taking turns.

    Stops after `repetitions` turns or when `seconds` are over, with three turns at least.
    """
    times = {name: [] for name in functions}
    began = time.perf_counter()
    for turn in range(repetitions):
        if turn >= 3 and time.perf_counter() - began > seconds:
            break
        for name, function in functions.items():
            start = time.perf_counter()
            function()
            times[name].append(time.perf_counter() - start)
    return {name: (min(t), statistics.median(t)) for name, t in times.items()}


def machine():
    """Versions, processor, load."""
    import numba
    import numpy
    import scipy

    import fastdyn

    cpu = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            cpu = next(s.split(":")[1].strip() for s in file if s.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return {
        "python": platform.python_version(),
        "fastdyn": fastdyn.__version__,
        "numba": numba.__version__,
        "numpy": numpy.__version__,
        "scipy": scipy.__version__,
        "cpu": cpu,
        "cores": os.cpu_count(),
        "load": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }
