"""The ways to solve: what changes between solves, and what is called during one."""

import itertools
import math

import numpy as np

from .solvers import N_STARTS

N_PIECES = 6


def once(s):
    s.once()


def again(s):
    for j in range(N_STARTS):
        if j:
            s.module.change(j)
        s.once()


def elsewhere(s):
    for j in range(N_STARTS):
        s.once(s.start(j))


def pieces(s):
    """A solve of many short ones, each from the end of the last, with changes between."""
    (begin, end), y = s.how["span"], s.start()
    ends = np.linspace(begin, end, N_PIECES + 1)
    for j, span in enumerate(itertools.pairwise(ends)):
        if j:
            s.module.change(1 + j % 2)
        s.once(y, span=span)
        y = s.runs[-1][1]


def twins(s):
    """Two modules of one text, of which one changes: their code is the same object."""
    one, two = s.module, s.again()
    two.change(1)
    for s.module in (one, two, one, two):
        s.once()


def prepared(s):
    s.many(lambda j: s.module.change(j) if j else None)


def events(s):
    fun = s.module.fun  # counts of calls are not compared where events call it, too
    rate = lambda t, y, *args: np.asarray(fun(t, y, *args))[0]  # noqa: E731
    s.once(events=[lambda t, y, *args: t - s.how["when"], lambda t, y, *args: y[0] - 0.7, rate])


def event(s):
    fun = s.module.fun
    rate = lambda t, y, *args: np.asarray(fun(t, y, *args))[0]  # noqa: E731
    s.once(events=[s.module.hook, rate] if s.how["two"] else s.module.hook)


def stepping(s):
    def at_each(t, y):
        s.module.hook(t, y)

    s.steps(at_each, s.how["way"])


def dense(s):
    s.once(dense_output=True, t_eval=np.linspace(*s.how["span"], 7))


def backward(s):
    s.once(span=s.how["span"][::-1])


def complex_start(s):
    s.once(np.array(s.start()) + 0.1j, events=lambda t, y, *args: t - s.how["when"])


def terminal(s):
    """Events with attributes: one ends the solve, one counts in one direction only."""
    looks = lambda t, y, *args: y[0] - 0.7  # noqa: E731
    passes = lambda t, y, *args: y[0] * math.sin(3 * t) - 0.1  # noqa: E731
    looks.terminal, passes.direction = 1 + s.how["two"], -1
    s.once(events=(looks, passes))


def times(s):
    s.once(t_eval=np.linspace(*s.how["span"], 9)[1:-1], max_step=0.3, first_step=1e-3)


def pulse(s):
    """With short steps, and no output while a pulse lasts: see `selections`."""
    s.once(t_eval=s.how["span"], max_step=0.002)


def matrix(s):
    """With a Jacobian of one's own, which reads what the function reads, where a method has one."""
    fun, n = s.module.fun, len(s.how["y0"])

    def jac(t, y, *args):
        at = np.asarray(fun(t, y, *args))
        return -np.eye(n) * (1.0 + 0.1 * abs(float(at[0])))

    s.once(**{"jac": jac} if s.how["method"] in ("Radau", "BDF", "LSODA") else {})


def on_event(s):
    def act(t, y, *args):
        s.module.hook(t, y)
        return 0.9 * y

    s.acting(lambda t, y, *args: t - s.how["when"], act)


def inside(s):
    """`fun` itself changes what it reads."""
    fun, hook = s.module.fun, s.module.hook

    def changing(t, y, *args):
        hook(t, y)
        return fun(t, y, *args)

    s.module.fun = changing
    s.once()


def ensemble(s):
    s.ensemble()


WAYS = {
    "once": once, "again": again, "elsewhere": elsewhere, "prepare": prepared, "events": events,
    "event": event, "callback": stepping, "stepper": stepping, "dense": dense, "fun": inside,
    "on_event": on_event, "ensemble": ensemble, "pieces": pieces, "twins": twins,
    "backward": backward, "complex": complex_start, "terminal": terminal, "times": times,
    "matrix": matrix, "pulse": pulse,
}  # fmt: skip
