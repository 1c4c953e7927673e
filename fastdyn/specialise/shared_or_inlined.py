"""The tier: the choice between the shared and the inlined stepping kernel."""

import functools
import math
from time import thread_time
from typing import Any

from fastdyn.compile import background
from fastdyn.kernels.methods import BY_NAME
from fastdyn.trace.graph.refusal import NotYet

from .scalar import inlined_kernel, inlines, kernel_without_function, links, shared_kernel
from .series import series_kernel

# Seconds in the shared kernel after which the inlined kernel is compiled: at most half of the time
# of the compilation.  LLVM takes at least 2 FOR_LLVM, and about 2 FOR_A_NUMBER for each number of
# each stage; Numba takes seconds.
FOR_LLVM = 0.05
FOR_A_NUMBER = 0.0012
FOR_NUMBA = 1.0


class Tier:
    """The stepping kernel of a solve, and its replacement by a faster kernel.

    Parameters
    ----------
    problem : problem.validate.Problem
        With `compile` "auto", "shared" or "inlined".  "auto" takes the inlined kernel if that
        kernel exists already.  Otherwise the background thread makes the inlined kernel after the
        solves of the function have spent some time in the shared kernel, in total.
    bound : compile.bind.Bound
        The equations.
    may_inline : bool
        False if the code of a function may have to be replaced within a solve.

    Attributes
    ----------
    address : int
        The address of the present stepping kernel.
    open : bool
        True if the inlined kernel may still take over.
    """

    def __init__(self, problem, bound, may_inline=True):
        p = problem
        n = len(problem.y0)
        name = problem.method.name
        function = bound.function
        self.open = False
        kernel = None
        if p.method.series:
            self._kernel = series_kernel(p, bound)
            self.address = self._kernel.address
            return
        may_inline = may_inline and function is not None and p.compile != "shared"
        if may_inline and inlines(name, n, function):
            kernel = inlined_kernel(name, function, n, p.compile == "inlined")
            self.open = kernel is None
        self._kernel = kernel or shared_kernel(name, bool(bound.pair))
        self.address = self._kernel.address
        if self.open:
            self._of = name, function, n
            self._spent = _spent(*self._of)
            self.promote()

    def record_time(self, seconds):
        """Add the time of a chunk, in seconds of this thread: not of what else the machine does."""
        if self.open:
            self._spent.seconds += seconds

    def timed(self, work, *given):
        """The value of ``work(*given)``, whose time is added if a faster kernel may take over.

        The time of a thread takes a system call, which waits up to 0.1 ms on some machines.
        """
        if not self.open:
            return work(*given)
        began = thread_time()
        found = work(*given)
        self.record_time(thread_time() - began)
        return found

    def promote(self):
        """Between two chunks, change to the inlined kernel, or let the thread make the kernel."""
        if not self.open:
            return
        spent = self._spent
        if spent.job is not None and spent.job.done:
            spent.job, kernel = None, inlined_kernel(*self._of, build=False)
            if kernel is not None:
                self._kernel = kernel
                self.address = kernel.address
                self.open = False
                return
        if spent.job is None and spent.seconds > spent.after:
            spent.job = background.idle_job(functools.partial(_make, spent, *self._of))


class Spent:
    """The time of all solves of a function in a shared kernel.

    Attributes
    ----------
    seconds : float
    after : float
        The seconds after which the inlined kernel is made.
    job : background.Job or None
        The job that makes the inlined kernel.
    """

    def __init__(self, after):
        self.seconds = 0.0
        self.after = after
        self.job: Any = None


def _spent(name, function, n):
    """The Spent of a method and a function of n numbers."""
    found = function.notes.get(("spent", name, n))
    if found is None:
        price = FOR_A_NUMBER * n * (BY_NAME[name].n_stages + 1)
        found = Spent(max(FOR_LLVM, price) if links(name, function) else FOR_NUMBA)
        function.notes["spent", name, n] = found
    return found


def _make(spent, name, function, n):
    """Make an inlined kernel: by LLVM, or by Numba if solves have spent FOR_NUMBA."""
    before = spent.after
    spent.after = math.inf
    try:
        if before < FOR_NUMBA and kernel_without_function(name, n) is None:
            spent.after = FOR_NUMBA
            return
        inlined_kernel(name, function, n)
    except NotYet:  # the process forks, or ends
        spent.after = before
        raise
