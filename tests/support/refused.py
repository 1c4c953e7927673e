"""Functions that no compiler takes, each with the line, marked `# here`, that says why."""

import functools
import logging
import random
import re
import time
import warnings

import numpy as np
import scipy.optimize
from scipy.integrate import quad

LOG: list = []
TABLE = {"calls": 0}
COUNT = 0
LOGGER = logging.getLogger(__name__)
LOGGER.addHandler(logging.NullHandler())
LOGGER.propagate = False
GENERATOR = np.random.default_rng(1)


def appends(t, y):
    LOG.append(t)  # here
    return -y


def counts_in_a_dict(t, y):
    TABLE["calls"] += 1  # here
    return -y


def counts_in_a_global(t, y):
    global COUNT
    COUNT += 1  # here
    return -y


def appends_in_a_helper(t, y):
    return -note(y)


def note(y):
    LOG.append(y[0])  # here
    return y


def draws(t, y):
    return -y * random.random()  # here


def draws_from_a_generator(t, y):
    return -y * GENERATOR.normal()  # here


def draws_by_numpy(t, y):
    return -y * np.random.rand()  # here  # noqa: NPY002


def logs(t, y):
    LOGGER.warning("%s", t)  # here
    return -y


def takes_the_time(t, y):
    return -y + 0 * time.time()  # here


def prints_a_state(t, y):
    print(end="")  # here
    return -y


def reads_text(t, y):
    k = float(re.sub("x", "", f"x{float(y[0])}"))  # here
    return -y + 0 * k


def looks_up_a_state(t, y):
    return [{True: -1.0, False: -2.0}[bool(y[0] > 2)] * float(str(abs(v))) for v in y]  # here


def minimizes(t, y):
    root = scipy.optimize.brentq(lambda x: x - y[0], -9, 9)  # here
    return [-root, 0.0]


def integrates(t, y):
    return -y * quad(lambda x: x * y[0], 0, 1)[0]  # here


def of_integers(t, y):
    return -y * bin(int(abs(y[0]) * 8)).count("1")  # here


def opens_a_file(t, y):
    with open("/dev/null") as file:  # here
        file.read()
    return -y


def loops_over_text(t, y):
    total, x = 0.0, abs(y[0])
    while x > 1e-3:
        x = x / 2
        total += len(f"{x:.3f}")  # here
    return -y * total


def catches_a_warning(t, y):
    with warnings.catch_warnings():  # here
        warnings.simplefilter("ignore")
        x = float(y[0])
        while abs(x) > 1e-3:
            x /= 2
    return -y


def converges(x):
    while True:
        x = x / 2
        if abs(x) < 1e-3:
            return x


def rotates(t, y):
    return -1j * y + 0 * len(str(y))


def compares_text(t, y):
    return -y * converges(y[0]) * (TABLE.get("a", 1.0) if str(t) else 1.0)  # here


def calls_scipy_in_a_loop(t, y):
    x = abs(y[0])
    while x > 1e-3:
        x = x / 2
    root = scipy.optimize.brentq(lambda z: z - x, -9, 9)  # here
    return [-root, 0.0]


def joins_numbers_in_a_loop(t, y):
    x = converges(y[0])
    return np.r_[-x, y[1:]]  # here


class Tank:
    def __init__(self):
        self.level, self.seen = 1.0, []

    def method(self, t, y):
        self.seen.append(t)  # here
        return -y

    def __call__(self, t, y):
        self.level += y[0]  # here
        return -y


def with_options(t, y, k, **options):
    LOG.append(options)  # here
    return -k * y


FUNCTIONS = {
    f.__name__: f
    for f in (
        appends, counts_in_a_dict, counts_in_a_global, draws, draws_from_a_generator,
        draws_by_numpy, logs, takes_the_time, prints_a_state, reads_text, looks_up_a_state,
        minimizes, integrates, of_integers, opens_a_file, loops_over_text, catches_a_warning,
        compares_text, calls_scipy_in_a_loop, joins_numbers_in_a_loop, appends_in_a_helper,
    )
} | {
    "method": Tank().method,
    "object": Tank(),
    "partial": functools.partial(with_options, k=1.0, other=2.0),
}  # fmt: skip
