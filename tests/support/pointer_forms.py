"""The pointer form of a trace, called from Python."""

import numpy as np

from fastdyn.code_store.loader import load
from fastdyn.code_store.target import translated
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.parameters import n_words, pack_all
from fastdyn.compile.traced import pointer_form as module
from fastdyn.compile.traced.code import Traced
from fastdyn.compile.traced.in_batches import TracedInBatches
from fastdyn.kernels.calls.block import FAULT, FIRST
from fastdyn.trace.paths.runs import trace


def compiled(fun, n, args, loops, monkeypatch, batches=False):
    """``function(t, y)`` in loops, or straight; traced in batches, or not."""
    monkeypatch.setattr(module, "worth_loops", lambda nodes: loops)
    kind = TracedInBatches if batches else Traced
    traced = kind(trace(fun, args, n, (n,), batches=batches), DERIVATIVE, n)
    symbol = f"fastdyn_test_{np.random.default_rng().integers(1 << 60)}"
    code, needs = translated(traced.text(symbol), symbol)
    end = FIRST + sum(map(n_words, traced.kinds))
    block, held = np.zeros(end + n, np.int64), []
    block[FAULT] = end
    given = traced.trace.reads.values()
    pack_all(zip(traced.kinds, given, strict=True), block, held)
    library = load(code, symbol, needs)
    call, kept = traced.python(library.address, block), (held, library)
    return lambda t, y: (kept, call(t, y))[1]
