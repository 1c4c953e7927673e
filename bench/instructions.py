"""``python -m bench.instructions``: instructions of a satellite's RK45 step, fastdyn's and C++'s.

Runs each under ptrace, one instruction at a time (Linux on x86-64, with objdump), so that nothing
is estimated; what is executed at least every other step is the step, the rest is the call.
"""

import collections
import ctypes
import os
import re
import signal
import subprocess
import tempfile
import time

TRACE_ME, SINGLE_STEP, GET_REGISTERS = 0, 9, 12
RIP = 16  # its place in user_regs_struct
STEPS = 300
KINDS = {
    "divide, square root": r"v?(div|sqrt)[sp]d",
    "multiply and add in one": r"vfn?m(add|sub).*",
    "multiply": r"v?mul[sp]d",
    "add, subtract": r"v?(add|sub)[sp]d",
    "compare, maximum": r"v?(max|min|cmp|u?comi)[a-z]*d",
    "move, load, store": r"v?mov.*|lea|push|pop",
    "shuffle, broadcast": r"v?(unpck|shuf|perm|insert|extract|broadcast|blend|hadd).*",
    "jump, call": r"j.*|call|ret",
}
ptrace = ctypes.CDLL(None, use_errno=True).ptrace
ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]


def fastdyn_kernel():
    """``run()`` takes STEPS accepted steps by the specialised kernel; also the tried ones."""
    import numpy as np
    from numba import njit

    from fastdyn import check
    from fastdyn.adapt import bind
    from fastdyn.drive import begin
    from fastdyn.kernels import METHODS
    from fastdyn.kernels.calls import resume
    from fastdyn.specialise import specialised_kernel, start_kernel

    from .problems import SATELLITE

    method, y0, args = METHODS["RK45"], np.array(SATELLITE.y0), SATELLITE.args
    problem = check.problem(
        SATELLITE.fun, 0.0, 1e12, y0, method, np.empty(0), False, None, args, "derivative",
        {"rtol": 1e-6, "atol": 1e-6},
    )  # fmt: skip
    bound = bind(SATELLITE.fun, args, "derivative", 4)
    state, work = begin(problem)
    start_kernel("RK45")(state, work, bound.block, 4.0, method.last)
    address = specialised_kernel("RK45", bound.function, 4).address

    @njit
    def run(address, state, work, block, n):
        return resume(address, state, work, block, n)

    run(address, state, work, bound.block, 1)
    return lambda: run(address, state, work, bound.block, STEPS)


def cpp_loop(compiler):
    """``run()`` solves until about STEPS steps are done, by one compiler's code."""
    from . import cpp
    from .problems import SATELLITE

    problem = SATELLITE._replace(t_span=(0.0, 87.5))
    return cpp.solvers(problem, 5, 1e-6, 1e-6)[f"C++ {compiler}"]


CODES = {
    "fastdyn": fastdyn_kernel,
    "clang++": lambda: cpp_loop("clang++"),
    "g++": lambda: cpp_loop("g++"),
}


def trace(make):
    """How often each instruction is executed in the second of two runs, and the code around."""
    child = os.fork()
    if child == 0:
        run = make()
        run()
        ptrace(TRACE_ME, 0, None, None)
        os.kill(os.getpid(), signal.SIGSTOP)
        run()
        os.kill(os.getpid(), signal.SIGSTOP)
        os._exit(0)
    os.waitpid(child, 0)
    registers, counts = (ctypes.c_ulong * 27)(), collections.Counter()
    while True:
        ptrace(GET_REGISTERS, child, None, registers)
        counts[registers[RIP]] += 1
        ptrace(SINGLE_STEP, child, None, None)
        _, status = os.waitpid(child, 0)
        if os.WSTOPSIG(status) != signal.SIGTRAP:
            break
    hot = sorted(place for place, n in counts.items() if n >= STEPS // 2)
    with open(f"/proc/{child}/mem", "rb") as memory:
        code = {place: _bytes(memory, place) for place in hot}
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return {place: counts[place] for place in hot}, code


def _bytes(memory, place):
    memory.seek(place)
    return memory.read(15)


def mnemonic(code):
    """The name of the instruction at the start of `code`."""
    with tempfile.NamedTemporaryFile() as file:
        file.write(code)
        file.flush()
        said = subprocess.run(
            ["objdump", "-D", "-b", "binary", "-mi386:x86-64", "--no-show-raw-insn", file.name],
            capture_output=True, text=True, check=True,
        ).stdout  # fmt: skip
    return next(line for line in said.splitlines() if line.startswith("   0:")).split()[1]


def kind(name):
    """Which of KINDS an instruction is."""
    return next((k for k, pattern in KINDS.items() if re.fullmatch(pattern, name)), "other")


def seconds_a_step(make):
    """The least of many runs, per step."""
    run = make()
    times = []
    for _ in range(2000):
        begun = time.perf_counter()
        run()
        times.append(time.perf_counter() - begun)
    return min(times) / STEPS


def clock():
    """Cycles a nanosecond: a sum and an exclusive or that wait for each other take two."""
    from numba import njit

    @njit
    def chain(x, n):
        for i in range(n):
            x = (x + i) ^ 12345
        return x

    n, times = 10**5, []
    chain(1, n)
    for _ in range(200):
        begun = time.perf_counter()
        chain(1, n)
        times.append(time.perf_counter() - begun)
    return 2.0 * n / min(times) * 1e-9


def main():
    """A table: instructions of each kind a step, and the time of a step."""
    table = {}
    for name, make in CODES.items():
        counts, code = trace(make)
        steps = collections.Counter(counts.values()).most_common(1)[0][0]
        found = collections.Counter()
        for place, n in counts.items():
            found[kind(mnemonic(code[place]))] += n / steps
        ns = 1e9 * seconds_a_step(make)
        table[name] = found | {"all": sum(found.values()), "ns": ns, "cycles": ns * clock()}
    print(f"{'':26}" + "".join(f"{name:>10}" for name in table))
    for row in (*KINDS, "other", "all", "ns", "cycles"):
        print(f"{row:26}" + "".join(f"{column.get(row, 0):10.1f}" for column in table.values()))


if __name__ == "__main__":
    main()
