"""How the tests run: what hangs is ended, memory goes, and no plugin of pytest's is needed."""

import os
import pathlib
import subprocess
import sys
import textwrap
import types

import pytest

from support.apart import CAN_FORK
from support.common_kernels import order
from support.few import left_out
from support.hanging import Patience

TESTS = pathlib.Path(__file__).parent
ALONE = {name: value for name, value in os.environ.items() if "XDIST" not in name}  # no worker
HANGING = """
import os, threading, time
from support.hanging import Patience, watch

def waits_for_ever():
    patience.begin("a test")
    time.sleep(600)

patience = Patience(10**9, most=0.0)
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


def test_few_has_each_value_of_each_parameter():
    pairs = [{"method": method, "problem": problem} for method in "abcdef" for problem in range(3)]
    items = [types.SimpleNamespace(callspec=types.SimpleNamespace(params=one)) for one in pairs]
    hunts = left_out(items)
    stay = [item.callspec.params for item in items if item not in hunts]
    assert hunts == left_out(items) and len(stay) <= 6 + 3 - 1
    assert {one["method"] for one in stay} == set("abcdef")
    assert {one["problem"] for one in stay} == set(range(3))
    assert len(left_out(items, 4)) == len(items) - 4


def test_the_tests_run_without_the_cache_of_pytest():
    one = f"{TESTS / 'test_house.py'}::test_every_folder_is_a_package"
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", one]
    done = subprocess.run(command, cwd=TESTS.parent, capture_output=True, env=ALONE)
    assert done.returncode == 0, done.stdout.decode()


IN_FOLDERS = {
    "conftest.py": """
        import os, sys
        import pytest
        sys.path.insert(0, TESTS)
        from support.apart import Apart

        def pytest_configure(config):
            config.pluginmanager.register(Apart(lambda: None))

        @pytest.fixture(scope="session")
        def ended():
            yield
            print("the session of", os.getpid(), "ended")
        """,
    "a/test_a.py": """
        import os, sys, warnings
        import pytest
        sys.kept = []

        def test_something_is_kept(ended):
            sys.kept.append(os.getpid())

        @pytest.mark.filterwarnings("ignore:named")
        def test_the_marks_of_a_test_hold():
            warnings.warn("named", stacklevel=1)
            assert sys.kept == [os.getpid()]

        def test_they_hold_for_that_test_alone(request):
            with pytest.raises(UserWarning):
                warnings.warn("named", stacklevel=1)

        def test_the_process_ends():
            os.kill(os.getpid(), 9)

        def test_another_process_goes_on(ended):
            assert sys.kept == []
        """,
    "b/test_b.py": """
        import sys

        def test_what_was_kept_is_gone():
            assert sys.kept == []

        def test_a_failure_is_shown():
            print("before it failed")
            assert [1, 2] == [1, 3]
        """,
}


@pytest.mark.skipif(not CAN_FORK, reason="needs fork")
def test_each_folder_runs_in_a_process_that_ends(tmp_path):
    for name, text in IN_FOLDERS.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(textwrap.dedent(text).replace("TESTS", repr(str(TESTS))))
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-W", "error", "-q", "-rA"]
    command.append(".")
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=ALONE)
    assert done.returncode == 1, done.stderr
    assert "2 failed, 5 passed" in done.stdout
    assert "the process of this folder of tests ended by signal or exit status -9" in done.stdout
    assert done.stdout.count("the session of") == 1  # of the second process; the first was killed
    assert "before it failed" in done.stdout and "At index 1 diff: 2 != 3" in done.stdout


@pytest.mark.parametrize(("n_workers", "rounds"), [(1, 10), (2, 5), (3, 5), (4, 3)])
def test_workers_share_the_kernels_and_each_comes_to_all(n_workers, rounds):
    orders = [order(worker, n_workers, 10) for worker in range(n_workers)]
    assert all(sorted(one) == list(range(10)) for one in orders)
    begun = {one[i] for one in orders for i in range(rounds)}
    last = {one[i] for one in orders for i in range(rounds - 1)}
    assert len(begun) == 10 and len(last) < 10
