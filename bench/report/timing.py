"""Interleaved timing, so that every solver of a row sees the same machine."""

import statistics
import time

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
