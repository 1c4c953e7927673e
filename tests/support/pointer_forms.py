"""The pointer form of a trace, called from Python."""

import numpy as np

from fastdyn.code_store.loader import load
from fastdyn.code_store.target import translated
from fastdyn.compile.functions import Function
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.parameters import n_words
from fastdyn.compile.traced import pointer_form as module
from fastdyn.compile.traced.code import Traced
from fastdyn.trace.emit import program
from fastdyn.trace.paths.runs import trace

from .machine_code import called


def compiled(fun, n, args, loops, monkeypatch, batches=False):
    """``function(t, y)`` in loops, or straight; traced in batches, or not."""
    for each in (module, program):
        monkeypatch.setattr(each, "worth_loops", lambda nodes: loops)
    traced = Traced(trace(fun, args, n, (n,), batches=batches), DERIVATIVE, n, batches)
    symbol = f"fastdyn_test_{np.random.default_rng().integers(1 << 60)}"
    code, needs = translated(traced.text(symbol), symbol)
    library = load(code, symbol, needs)
    size = sum(map(n_words, traced.kinds))
    function = Function(None, library.address, size, None, library, traced=traced)
    values = list(zip(traced.kinds, traced.trace.reads.close(), strict=True))
    return called(function, values, DERIVATIVE, n)
