"""JiTCDDE: the function becomes C by SymEngine; Bogacki and Shampine's method, of order 3."""

import functools
import os
import tempfile

import jitcdde
import numpy as np


def delays(given):
    """JiTCDDE, steps to the jumps of the start as its documentation advises."""
    return {
        "JiTCDDE": functools.partial(_prepare, given, functools.cache(lambda: _compiled(given)))
    }


def _compiled(given):
    n = len(given.history)

    def past(s):
        return [jitcdde.y(i, s) for i in range(n)]

    rates = given.fun(jitcdde.t, [jitcdde.y(i) for i in range(n)], past)
    made = jitcdde.jitcdde(rates, max_delay=max(given.delays), verbose=False)
    here = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # setuptools would read the pyproject.toml of this project
        try:
            made.compile_C()
            made.__del__()  # of its files; garbage in a cycle deletes them with a ResourceWarning
        finally:
            os.chdir(here)
    return made


def _prepare(given, compiled, tol):
    made = compiled()

    def solve():
        made.purge_past()
        made.constant_past(given.history)
        made.set_integration_parameters(rtol=tol, atol=tol)
        made.step_on_discontinuities()
        return np.array(made.integrate(given.end))

    return solve
