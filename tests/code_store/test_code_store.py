"""Kept code is one object file an entry: one visible symbol, and nothing of its process."""

import resource
import threading

import llvmlite.binding as llvm
import numpy as np
import pytest
from numba import njit

import fastdyn
from fastdyn import code_store
from fastdyn.code_store import Call, cache, emit_object, target
from fastdyn.code_store.loader import UnknownSymbol, load, provider
from fastdyn.code_store.object_file import NotWhole, packed, symbols, unpacked
from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.state.record import STATE
from fastdyn.specialise.scalar import shared_kernel, start_kernel

RETURNS = "define i64 @{0}(ptr %words) {{ {1} ret i64 0 }}\n"


def assembled(text):
    module = llvm.parse_assembly(text)
    module.triple = llvm.get_process_triple()
    return target.target().emit_object(module)


def header(symbol, needs=()):
    return {"symbol": symbol, "needs": list(needs), "arguments": []}


def test_every_kept_file_shows_one_symbol_which_names_it(tmp_path, monkeypatch):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    fastdyn.solve_ivp(lambda t, y: [np.sort(y)[0], -y[0]], (0, 1), [1.0, 2.0], compile="shared")
    files = list((tmp_path / "fastdyn").glob("*.o"))
    assert files
    for file in files:
        head, code = unpacked(file.read_bytes(), f"fastdyn_{file.stem}")
        defined, undefined = symbols(code)
        assert defined == [head["symbol"]] == [f"fastdyn_{file.stem}"]
        assert undefined == head["needs"] and all(map(provider, undefined))
        assert b"numba" not in b" ".join(s.encode() for s in defined)


@pytest.mark.parametrize(
    ("text", "needs", "sentence"),
    [
        (RETURNS.format("mine", "") + RETURNS.format("other", ""), [], "not mine alone"),
        (RETURNS.format("other", ""), [], "not mine alone"),
        ("declare i32 @system(ptr)\n" + RETURNS.format("mine", "call i32 @system(ptr null)"), [],
         "needs"),
        (RETURNS.format("mine", "") + "define internal void @first() { ret void }\n"
         "@llvm.global_ctors = appending global [1 x { i32, ptr, ptr }] "
         "[{ i32, ptr, ptr } { i32 1, ptr @first, ptr null }]", [], "runs when it is loaded"),
    ],
)  # fmt: skip
def test_files_that_show_more_or_need_more_are_refused(text, needs, sentence):
    data = packed(header("mine", needs), assembled(text))
    with pytest.raises(NotWhole, match=sentence):
        unpacked(data, "mine")


def test_what_no_provider_has_is_refused():
    text = "declare i32 @system(ptr)\n" + RETURNS.format("mine", "call i32 @system(ptr null)")
    data = packed(header("mine", ["system"]), assembled(text))
    with pytest.raises(UnknownSymbol, match="system"):
        load(unpacked(data, "mine")[1], "mine", ["system"])


@pytest.mark.parametrize("change", ["cut", "flipped", "old magic", "pickle"])
def test_damaged_files_are_refused(change):
    data = packed(header("mine"), assembled(RETURNS.format("mine", "")))
    unpacked(data, "mine")
    damaged = {
        "cut": data[:-9],
        "flipped": data[:-9] + bytes([data[-9] ^ 1]) + data[-8:],
        "old magic": b"fastdyn1" + data[17:],
        "pickle": b"\x80\x04",
    }
    with pytest.raises(NotWhole):
        unpacked(damaged[change], "mine")


def test_two_files_of_one_symbol_stand_side_by_side():
    """As two versions of a function that this process alone can tell apart."""
    numbers = [assembled(f"define i64 @mine(ptr %words) {{ ret i64 {i} }}\n") for i in (1, 2)]
    libraries = [load(code, "mine", []) for code in numbers]
    assert [Call(cache.Code(each.address, {}, each))() for each in libraries] == [1, 2]


@pytest.mark.parametrize(
    "wrong",
    [
        lambda state, work: (state, work.astype(np.float32)),
        lambda state, work: (state, work[:, ::2]),
        lambda state, work: (state, work[0]),
        lambda state, work: (state.view("f8"), work),
    ],
)
def test_arrays_that_a_kernel_does_not_take_are_refused(wrong):
    state, work = wrong(np.zeros(1, STATE), np.zeros((12, 4)))
    with pytest.raises(TypeError, match="must be a C-contiguous array"):
        Call(start_kernel("RK45"), state, work, np.zeros(FIRST, np.int64), 4.0, 6)


def test_arguments_that_are_changed_are_checked_too():
    call = Call(shared_kernel("RK45"), np.zeros(1, STATE), np.zeros((12, 4)), None, 0)
    call["n_steps"] = 1
    with pytest.raises(TypeError, match="`work`"):
        call["work"] = np.zeros(3)


def test_code_that_allocates_gives_all_of_it_back():
    def allocates(t, y):
        found = [y[0], y[1]]
        for i in range(50):
            found.append(float(i))
        whole = np.sort(np.array(found))
        return -y * whole[-1] / whole[-1]

    options = {"method": "RK4", "step": 1e-4, "t_eval": [1.0]}
    fastdyn.solve_ivp(allocates, (0, 1), [1.0, 2.0], **options)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    fastdyn.solve_ivp(allocates, (0, 10), [1.0, 2.0], **(options | {"t_eval": [10.0]}))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 20_000  # kB; 400 000 evaluations that kept a kB each would need 400 MB


def test_threads_that_compile_at_once():
    found = {}

    def solve(k):
        exec_space = {"np": np}
        exec(f"def fun(t, y):\n    return [-{k} * y[0], np.sin(y[1]) * {k}]", exec_space)
        found[k] = fastdyn.solve_ivp(exec_space["fun"], (0, 1), [1.0, 0.0], rtol=1e-8).y[0, -1]

    threads = [threading.Thread(target=solve, args=(k,)) for k in range(1, 9)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(abs(found[k] - np.exp(-k)) < 1e-6 for k in range(1, 9))


def test_a_jitted_function_is_what_python_makes_of_it():
    """Numba keeps to the globals that it has compiled with, and so does SciPy's answer."""
    space = {"K": 1.0, "njit": njit}
    exec("@njit\ndef pull(x):\n    return -K * x\n\ndef fun(t, y):\n    return [pull(y[0])]", space)
    assert space["pull"](1.0) == -1.0  # compiled for this K, by Numba
    space["K"] = 2.0
    with pytest.warns(fastdyn.CompileWarning):
        end = fastdyn.solve_ivp(space["fun"], (0, 1), [1.0], rtol=1e-8).y[0, -1]
    assert abs(end - np.exp(-1)) < 1e-6


@pytest.mark.filterwarnings("ignore")
def test_a_jitted_function_keeps_its_globals_as_in_python():
    space = {"K": 1.0, "njit": njit}
    exec("@njit\ndef fun(t, y):\n    return [-K * y[0]]", space)
    for space["K"] in (1.0, 2.0, 3.0):
        end = fastdyn.solve_ivp(space["fun"], (0, 1), [1.0], rtol=1e-8).y[0, -1]
        assert abs(end - np.exp(-1)) < 1e-6


def test_code_from_numbas_own_cache_is_not_linked(tmp_path, monkeypatch):
    class Loaded:
        _disable_inspection, _linking_libraries = True, ()

    class Library:
        _disable_inspection, _linking_libraries = False, (Loaded(),)

    with pytest.raises(code_store.Unsealable, match="Numba's own cache"):
        emit_object._check_origin(Library())


def test_what_prints_runs_in_python_and_prints(capsys):
    def talks(t, y):
        if t == 0.0:
            print("here")
        return [-y[0]]

    with pytest.warns(fastdyn.CompileWarning, match="it calls print"):
        fastdyn.solve_ivp(talks, (0, 1), [1.0])
    assert capsys.readouterr().out == "here\n"
