"""One adapter a solver.

A module here has ``solvers(problem)``, which returns ``{name: prepare}``, empty for a problem that
is not for it.  ``prepare(tol, times=None)`` does all that a user does once (compiling, building the
integrator) and returns a function of nothing, which solves the problem from its start with
rtol = atol = tol and returns the end state, NaN if it failed; with `times` it also makes the output
there.  It returns None if there is no such output.  A rival that is not installed is an
ImportError.
"""

import functools
import importlib

MAX_STEPS = 10**6  # for those that would follow a fall into the planet for ever
NAMES = (
    "fastdyn", "cpp", "scipy", "cyrk", "numbalsoda", "heyoka", "diffrax", "sundae", "rebound"
)  # fmt: skip


@functools.cache
def installed():
    """The modules whose libraries are there; the others are named, once."""
    found = []
    for name in NAMES:
        try:
            found.append(importlib.import_module(f"{__name__}.{name}"))
        except ImportError as error:
            print(f"skipped {name}: {error}")
    return found


def solvers(problem):
    """{name: prepare} of everything that is installed and takes the problem."""
    made = {}
    for module in installed():
        made |= module.solvers(problem)
    return made
