"""How the tests run: what hangs is ended, and no plugin of pytest's is needed."""

import pathlib
import subprocess
import sys

from support.hanging import Patience

TESTS = pathlib.Path(__file__).parent
HANGING = """
import os, threading, time
from support.hanging import Patience, watch

def waits_for_ever():
    time.sleep(600)

patience = Patience(10**9, most=0.0)
patience.begin("a test")
ended = threading.Event()
threading.Thread(target=watch, args=(patience, os.dup(2), ended, 0.01), daemon=True).start()
waits_for_ever()
"""


def test_a_test_that_hangs_is_named_and_ended():
    done = subprocess.run([sys.executable, "-c", HANGING], cwd=TESTS, capture_output=True)
    assert done.returncode == 1
    assert b"a test hangs\n" in done.stderr and b"in waits_for_ever" in done.stderr


def test_a_busy_machine_shortens_no_test():
    patience = Patience(2, most=300.0)
    assert not any(patience.is_over(1000.0, 0.0) for _ in range(9))  # between tests
    for load, seconds in ((0.0, 300), (2.0, 300), (20.0, 3000)):
        patience.begin("a test")
        assert not any(patience.is_over(1.0, load) for _ in range(seconds - 1)), load
        assert patience.is_over(1.5 * max(load / 2, 1.0), load)


def test_the_tests_run_without_the_cache_of_pytest():
    one = f"{TESTS / 'test_house.py'}::test_every_folder_is_a_package"
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", one]
    done = subprocess.run(command, cwd=TESTS.parent, capture_output=True)
    assert done.returncode == 0, done.stdout.decode()
