"""What is remembered of functions has a bound, and what somebody uses is never released."""

import ast
import gc
import pathlib
import threading

import numpy as np
import pytest

import fastdyn
from fastdyn import prepare, solve_ivp
from fastdyn.code_store import loader
from fastdyn.compile import memory

MOST = 60
SPAN, START = (0.0, 1.0), [1.0, 0.5]


@pytest.fixture
def small(monkeypatch):
    """A store of few entries."""
    memory.forget()
    monkeypatch.setattr(memory, "MOST", MOST)
    yield
    memory.forget()


def function(k):
    """A function that differs from others by its code."""
    scope = {}
    exec(f"def fun(t, y):\n    return [y[1] * 1.{k}, -y[0] * 0.{k}5]", scope)
    return scope["fun"]


def libraries():
    """How many pieces of machine code are in the process, and how many linkers."""
    gc.collect()
    loader.unload()
    return sum(len(linker.trackers) for linker in loader._linkers.used), len(loader._linkers.used)


def end(k, **options):
    return solve_ivp(function(k), SPAN, START, **options).y[:, -1]


def test_entries_and_machine_code_have_a_bound(small):
    expected = [end(k) for k in range(20)]
    before = libraries()
    for k in range(20, 130):
        end(k)
        assert memory.remembered()[1] <= MOST
    n_pieces, n_linkers = libraries()
    assert n_pieces <= before[0] + 2 and n_linkers <= before[1] + 2
    assert np.array_equal([end(k) for k in range(20)], expected)  # each was released before


@pytest.mark.parametrize("method", ["RK45", "Radau", "Rodas5P", "Taylor"])
def test_what_a_solver_holds_stays(small, method):
    """Its function, its kernel, its Jacobian, the elimination of its matrices, its series."""
    events = None if method == "Taylor" else (lambda t, y: y[0] - 0.9)
    solver = prepare(function(7), SPAN, START, method, events=events)
    expected = solver().y
    for k in range(100, 100 + MOST):
        end(k, method="RK45" if k % 8 else method)
    memory.forget()
    libraries()
    assert np.array_equal(solver().y, expected)


def test_a_stepper_goes_on(small):
    stepper = fastdyn.Stepper(function(3), 0.0, START, 60.0, "DOP853")
    other = fastdyn.Stepper(function(3), 0.0, START, 60.0, "DOP853")
    for k in range(8):
        stepper.step()
        other.step()
        end(300 + k)
        memory.forget()
        libraries()
        assert stepper.t == other.t and np.array_equal(stepper.y, other.y)


def test_threads_that_release_what_others_use(small):
    expected = {k: end(k, rtol=1e-8) for k in range(24)}
    wrong, go_on = [], threading.Event()

    def work(seed):
        for k in np.random.default_rng(seed).integers(24, size=60):
            if not np.array_equal(end(k, rtol=1e-8), expected[k]):
                wrong.append(k)

    def release():
        while not go_on.wait(0.002):
            memory.forget()

    others = [threading.Thread(target=work, args=(i,)) for i in range(2)]
    releasing = threading.Thread(target=release)
    for thread in (*others, releasing):
        thread.start()
    for thread in others:
        thread.join()
    go_on.set()
    releasing.join()
    assert wrong == [] and memory.remembered()[1] <= MOST


def test_the_entry_that_was_not_used_for_longest_is_released(small):
    table = memory.Table()
    for k in range(MOST):
        table.put(k, str(k))
    for k in range(0, MOST, 2):
        table.get(k)  # each was new before
    table.put("large", "one", MOST // 2)
    assert memory.remembered()[1] <= MOST
    kept = [k for k in range(MOST) if table.entries.get(k)]
    assert len(kept) == MOST // 2
    for k in kept[5:]:
        table.get(k)
    for k in range(5):
        table.put(f"new {k}", k)
    assert not any(table.entries.get(k) for k in kept[:5])
    assert all(table.get(k) == str(k) for k in kept[5:])


def test_machine_code_ends_with_who_holds_it(small):
    solver = prepare(function(11), SPAN, START)
    solver()
    memory.forget()
    n, _ = libraries()
    del solver
    assert libraries()[0] < n


def test_modules_have_no_store_of_their_own():
    """Of empty containers, which grow: `memory.Table` is there, and caches with a bound."""
    root = pathlib.Path(fastdyn.__file__).parent
    found = set()
    for folder in ("compile", "trace", "specialise", "run", "code_store"):
        for path in (root / folder).rglob("*.py"):
            for node in ast.parse(path.read_text()).body:
                value = getattr(node, "value", None)
                empty = isinstance(value, ast.Dict | ast.Set | ast.List) and not ast.unparse(
                    value
                ).strip("{}[]")
                if empty or (isinstance(value, ast.Call) and ast.unparse(value) == "set()"):
                    found.add(f"{path.relative_to(root)}: {ast.unparse(node).split(':')[0]}")
    registries = "trace/symbols/symbol.py", "trace/operations/record.py"  # of the tracer's files
    assert {each for each in found if not each.startswith(registries)} == {
        "compile/memory.py: _clear",
        "compile/mode.py: MODES",
        "trace/functions/ufuncs.py: OF_ROWS",  # NumPy's transforms
        "code_store/object_file.py: OFFERED",  # the loops of Taylor's kernels
        "trace/emit/numbers.py: BY_KERNELS",  # four operations
        "specialise/scalar.py: _serving",  # one kernel
        "code_store/announced.py: _told",  # names of methods
        "compile/python_callback.py: FORMS_OF_CODE",  # one function of `integrate`
        "specialise/rare.py: _failures",  # one a thread, until the solve raises it
    }
