"""Scripts with odeint as people write them, each with its answer in `sol`.

A file has scripts of a few topics, each below a line that begins with ###.  All were written for
this corpus, after the forms of public scripts: lists and arrays, classes and lambdas, arguments of
all kinds, loops of controllers, shooting, fits by SciPy's optimisers.
"""

import pathlib
import sys
import types

import numpy as np

SOLVERS = "solvers_of_the_script"


def load():
    """The scripts, by title."""
    found = {}
    for file in sorted(pathlib.Path(__file__).parent.glob("*.txt")):
        for script in file.read_text().split("### ")[1:]:
            title, _, body = script.partition("\n")
            found[title] = body
    return found


def run(body, odeint):
    """The answers of a script that calls the given `odeint`, as a list of arrays."""
    sys.modules[SOLVERS] = solvers = types.ModuleType(SOLVERS)
    solvers.odeint = odeint
    names = {"__name__": "script"}
    changed = body.replace("from scipy import integrate", f"import {SOLVERS} as integrate")
    try:
        exec(changed.replace("scipy.integrate", SOLVERS), names)
    finally:
        del sys.modules[SOLVERS]
    found = names["sol"]
    if isinstance(found, list) and np.ndim(found[0]) > 1:
        return [np.asarray(one) for one in found]
    return [np.asarray(found, dtype=float)]
