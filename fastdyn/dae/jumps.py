"""Events that change the state of F(t, y, y') = 0: the functions of `on_event`, made consistent."""

import numpy as np

from fastdyn.compile.bind import Bound
from fastdyn.compile.mode import JUMP
from fastdyn.compile.python_callback import Callback, derivative
from fastdyn.kernels.calls.block import FIRST

from .consistent import consistent


def consistent_jumps(problem, equations, on_event):
    """The functions of [y, y'] that act at the events, None where there is none.

    The user's function gives y; components whose derivatives occur in F are held, others and all
    derivatives are computed.
    """
    return tuple([act and _consistent(problem, equations, act) for act in on_event])


def _consistent(p, equations, act):
    n = equations.n

    def jump(t, both, *args):
        y = derivative(act(t, both[:n].copy(), *args), n, JUMP)
        if not np.isfinite(y).all():
            return np.concatenate([y, both[n:]])  # the run ends and says why
        start = p._replace(t0=t, y0=np.concatenate([y, both[n:]]))
        return consistent(equations.at(t), start, "differential")

    return jump


def bound_in_python(jump, args, n):
    """The Bound of such a function of n numbers, which runs in Python."""
    keepalive = [jump, args]

    def as_written(t, both):
        return keepalive[0](t, both, *keepalive[1])

    callback = Callback(as_written, JUMP, n)
    block = np.zeros(FIRST, np.int64)
    block[0] = callback.address
    return Bound(None, block, as_written, [*keepalive, callback], callback, [], JUMP)
