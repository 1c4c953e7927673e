"""``python -m bench.odeint``: the time of a script in `odeint`, fastdyn's and SciPy's.

All calls of a script count, with the compilation of its functions; a script is run several times,
each time with new functions.  Processor times, the least of the runs.
"""

import bench.one_thread  # noqa: F401  before all that follow

# isort: split
import time

import scipy.integrate

import fastdyn

from .corpus import odeint

RUNS = 5


def seconds(body, solver):
    """The seconds of a script in its solver."""
    spent = 0.0

    def timed(*given, **named):
        nonlocal spent
        began = time.process_time()
        try:
            return solver(*given, **named)
        finally:
            spent += time.process_time() - began

    odeint.run(body, timed)
    return spent


def main():
    ratios = []
    for title, body in odeint.load().items():
        pairs = [(seconds(body, scipy.integrate.odeint), seconds(body, fastdyn.odeint))
                 for _ in range(RUNS)]  # fmt: skip
        theirs, ours = map(min, zip(*pairs, strict=True))
        ratios.append(ours / theirs)
        print(f"{title:48s} SciPy {1e3 * theirs:8.2f} ms   ours {ratios[-1]:5.2f}", flush=True)
    ratios.sort()
    more = sum(ratio > 1.1 for ratio in ratios)
    middle = ratios[len(ratios) // 2]
    print(f"{len(ratios)} scripts; {more} take more than 1.1 of SciPy's time")
    print(f"least {ratios[0]:.2f}, median {middle:.2f}, most {ratios[-1]:.2f}")


if __name__ == "__main__":
    main()
