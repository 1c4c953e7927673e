"""A process in which all is known imports neither Numba nor SciPy nor matplotlib."""

import os
import subprocess
import sys

import pytest

BEGINNING = """
import sys
import numpy as np
import fastdyn

def oscillator(t, y, k):
    x, v = y
    return [v, -k * x]

given = {"t_span": (0, 5), "y0": [1.0, 0.0], "args": (2.0,), "compile": "shared"}
"""
END = """
print([name for name in ("numba", "scipy", "matplotlib") if name in sys.modules])
print(fastdyn.code_store.COUNTS["compiled"])
"""
SCRIPTS = {
    "plain": "r = fastdyn.solve_ivp(oscillator, **given)",
    "auto": "given.pop('compile'); r = fastdyn.solve_ivp(oscillator, **given)",
    "fixed steps": "r = fastdyn.solve_ivp(oscillator, method='KahanLi8', step=0.1, **given)",
    "implicit": "r = fastdyn.solve_ivp(oscillator, method='Gauss8', step=0.1, **given)",
    "dense output and events": """
r = fastdyn.solve_ivp(oscillator, dense_output=True, events=lambda t, y, k: y[0], **given)
assert abs(r.sol(1.0)[0] - np.cos(2**0.5)) < 1e-2 and len(r.t_events[0]) > 1
""",
    "t_eval": "r = fastdyn.solve_ivp(oscillator, method='DOP853', t_eval=[0, 1, 5], **given)",
    "prepared": """
solve = fastdyn.prepare(oscillator, given["t_span"], given["y0"], args=given["args"],
                        compile="shared")
r = solve()
""",
    "complex": """
r = fastdyn.solve_ivp(lambda t, y: [1j * y[0]], (0, 1), [1.0 + 0j], method="Tsit5")
assert abs(r.y[0, -1] - np.exp(1j)) < 1e-2
""",
    "Taylor": """
r = fastdyn.solve_ivp(oscillator, method="Taylor", events=lambda t, y, k: y[0], **given)
assert len(r.t_events[0]) == 2
""",
    "Radau": "r = fastdyn.solve_ivp(oscillator, method='Radau', **given)",
    "BDF": "r = fastdyn.solve_ivp(oscillator, method='BDF', **given)",
    "LSODA": "r = fastdyn.solve_ivp(oscillator, method='LSODA', **given)",
    "mass": """
r = fastdyn.solve_ivp(oscillator, method="Rodas5P", mass=np.diag([1.0, 2.0]), **given)
""",
    "a method that is chosen": "r = fastdyn.solve_ivp(oscillator, method='auto', **given)",
    "sensitivity": """
given.pop("compile")
r = fastdyn.solve_ivp(oscillator, method="Taylor", sensitivity=("y0", "k"), **given)
""",
    "linear system": """
def lever(t, y):
    a, b = fastdyn.solve_linear(((2.0, 1.0), (1.0, 3.0)), (-y[0], -y[1]))
    return [a, b]

r = fastdyn.solve_ivp(lever, (0, 1), [1.0, 0.0], compile="shared")
""",
}


def run(script, **more):
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", BEGINNING + script + END],
        env=os.environ | more, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    imported, compiled = done.stdout.splitlines()
    return imported, int(compiled)


@pytest.fixture(scope="module")
def known():
    """All scripts have run once, in one process."""
    run("begun = given\n" + "\n".join(f"given = {{**begun}}\n{s}" for s in SCRIPTS.values()))


@pytest.mark.few(4)
@pytest.mark.usefixtures("known")
@pytest.mark.parametrize("name", SCRIPTS)
def test_what_is_known_needs_no_numba(name):
    assert run(SCRIPTS[name]) == ("[]", 0)


@pytest.mark.usefixtures("known")
def test_a_new_traced_function_needs_no_numba():
    """Only its own code is new: the number in it has never been seen."""
    number = int.from_bytes(os.urandom(6), "big")
    script = f"def oscillator(t, y, k): return [y[1], -y[0] * {number} / (t + {number})]\n"
    assert run(script + SCRIPTS["plain"]) == ("[]", 1)


KEYS = """
from fastdyn.code_store import target
from fastdyn.code_store.key.environment import environment
from fastdyn.code_store.key.sources import FUNCTIONS
print(environment(FUNCTIONS))
import numba
from numba.core.registry import cpu_target
assert target.processor() == cpu_target.target_context.codegen().magic_tuple()
print(environment(FUNCTIONS))
"""


def keys_under(settings):
    """What keys depend on, without Numba and with it."""
    done = subprocess.run(
        [sys.executable, "-c", KEYS], env=os.environ | settings, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.fixture(scope="module")
def plain():
    return keys_under({})


@pytest.mark.few(2)
@pytest.mark.parametrize("settings", [
    {}, {"NUMBA_CPU_NAME": "x86-64-v2", "NUMBA_CPU_FEATURES": ""}, {"NUMBA_OPT": "1"},
    {"NUMBA_OPT": "max"}, {"NUMBA_CPU_NAME": "generic"},
])  # fmt: skip
def test_keys_are_the_same_with_numba_and_without(settings, plain):
    without, with_it = keys_under(settings) if settings else plain
    assert without == with_it
    assert (without == plain[0]) == (not settings)
