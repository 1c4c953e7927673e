"""Processes that share a cache, in any order, never get each other's code.

Numba names helpers by counters that begin anew in each process: code that two processes have kept
may define the same names.  Each test lets some processes compile, then others load it all.
"""

import os
import random
import warnings

import numpy as np
import pytest

from support import across, everyday

MAKERS = 2
EVERYDAY = 10  # of the functions, others in each run; .ci/run takes all of them


def references(names):
    """Answers by SciPy, or in Python."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return {name: across.expected(name) for name in names}


def check(names, reference, rng):
    """Compile each in a process of its own, load all in one; all answers, to the bit."""
    cache = os.environ["NUMBA_CACHE_DIR"]
    across.what_all_need()
    rng.shuffle(names)
    makers = [across.start(cache, "apart", names[i::MAKERS]) for i in range(MAKERS)]
    made = {name: found for process in makers for name, found in across.answers(process).items()}
    rng.shuffle(names)
    loaded = across.answers(across.start(cache, "together", names))
    assert not across.wrong(made, reference)
    assert not across.wrong(loaded, reference)
    assert [name for name in names if not np.array_equal(made[name], loaded[name])] == []


@pytest.mark.hunt
def test_everyday_functions(rng, pytestconfig):
    """All of them in every mode with ``--all-modes``; else some, each in one mode that is drawn."""
    if pytestconfig.getoption("all_modes"):
        names = [f"{name}:{mode}" for name in everyday.CASES for mode in across.MODES]
    else:
        cases = rng.sample(list(everyday.CASES), EVERYDAY)
        names = [f"{name}:{rng.choice(across.MODES)}" for name in cases]
    check(names, references(names), rng)


@pytest.mark.hunt
def test_drawn_functions(rng, pytestconfig):
    """Other functions in each run, each in every mode: ``--draws`` tells how many."""
    left = pytestconfig.getoption("draws")
    while left > 0:
        numbers = [rng.randrange(10**9) for _ in range(min(left, 40))]
        names = [f"{number}:{mode}" for number in numbers for mode in across.MODES]
        check(names, references(names), rng)
        left -= len(numbers)


@pytest.fixture
def rng():
    """Random numbers whose seed a failure shows."""
    seed = random.SystemRandom().randrange(10**9)
    print("seed", seed)
    return random.Random(seed)
