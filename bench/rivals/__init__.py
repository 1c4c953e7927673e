"""One adapter a library, for every group.

A module here has one or more of:

``solvers(problem)``
    ``{name: prepare}``, empty for a problem that is not for it.  ``prepare(tol, times=None)`` does
    all that a user does once (compiling, building the integrator) and returns a function of
    nothing, which solves the problem from its start with rtol = atol = tol and returns the end
    state, NaN if it failed; with `times` it also makes the output there.  It returns None if there
    is no such output.
``trajectories(many)``
    ``{name: run}``; ``run()`` solves all trajectories of a `problems.many.Many` with `MANY_RTOL`
    and `MANY_ATOL` and returns their end states.
``stiff(stiff)``
    ``{name: prepare}`` for a `problems.stiff.Stiff`; ``prepare(tol)`` as above, with rtol = tol and
    atol = tol times its floor.
``dae(dae)``
    ``{name: prepare}`` for a `problems.daes.Dae`, with tolerances as for `stiff`.
``hybrid(hybrid)``
    ``{name: prepare}`` for a `problems.hybrids.Hybrid`, with rtol = atol = tol.
``delays(delayed)``
    ``{name: prepare}`` for a `problems.delays.Delayed`, with rtol = atol = tol.
``gradients(gradient)``
    ``{name: prepare}`` for a `problems.gradients.Gradient`, with rtol = atol = tol; the function
    returns the derivatives by the parameters.
``orbits(orbit)``
    ``{name: make}``; ``make()`` puts a satellite at its start and returns ``go(t)``, which carries
    it on to t and returns [x, y, vx, vy].
``planets(times)``
    ``{name: make}``; ``make()`` returns ``(go, most)``: ``go(y0)`` follows the outer planets and
    returns its time in s, the states at `times` and the number of steps; most starts to be tried.
``FIRST_CALL``
    ``{name: (imports, body)}``, the text of a script: `body` defines ``solve()`` for the numbers
    ``{k}`` and ``{power}``, fastdyn's by ``{method}``.

A rival that is not installed is an ImportError.
"""

import functools
import importlib

MAX_STEPS = 10**6  # for those that would follow a fall into the planet for ever
MANY_RTOL, MANY_ATOL = 1e-6, 1e-9
LEAPFROG_STEPS = 400  # an orbit
NAMES = (
    "fastdyn", "cpp", "scipy", "cyrk", "numbalsoda", "heyoka", "diffrax", "sundae", "casadi",
    "rebound", "jitcdde", "ddeint",
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
    return _joined("solvers", problem)


def trajectories(many):
    """{name: run} of everything that is installed and solves many trajectories."""
    return _joined("trajectories", many)


def stiff(given):
    """{name: prepare} of everything that is installed and made for stiff problems."""
    return _joined("stiff", given)


def dae(given):
    """{name: prepare} of everything that is installed and takes F(t, y, y') = 0."""
    return _joined("dae", given)


def hybrid(given):
    """{name: prepare} of everything that is installed and can act between two steps."""
    return _joined("hybrid", given)


def delays(given):
    """{name: prepare} of everything that is installed and takes equations with delays."""
    return _joined("delays", given)


def gradients(given):
    """{name: prepare} of everything that is installed and has derivatives by parameters."""
    return _joined("gradients", given)


def orbits(orbit):
    """{name: make} of everything that is installed and follows an orbit for long."""
    return _joined("orbits", orbit)


def planets(times):
    """{name: make} of everything that is installed and follows the outer planets for long."""
    return _joined("planets", times)


def first_calls():
    """{name: (imports, body)} of everything that is installed and compiles something."""
    return {
        name: script
        for module in installed()
        for name, script in getattr(module, "FIRST_CALL", {}).items()
    }


def _joined(word, given):
    made = {}
    for module in installed():
        if hasattr(module, word):
            made |= getattr(module, word)(given)
    return made
