"""The tier: the choice between the shared and the inlined stepping kernel."""

from .scalar import inlined_kernel, inlines, shared_kernel
from .series import series_kernel

PROMOTE_AFTER = 1.0  # seconds in the shared kernel, after which the inlined one pays


class Tier:
    """The stepping kernel of a solve, and its replacement by a faster kernel.

    Parameters
    ----------
    problem : problem.validate.Problem
        With `compile` "auto", "shared" or "inlined".  "auto" takes the inlined kernel if that
        kernel exists already, and otherwise compiles the inlined kernel once this function has
        spent PROMOTE_AFTER seconds in the shared kernel, over all its solves.
    bound : compile.bind.Bound
        The equations.
    may_inline : bool
        False if other code may have to replace the code of a function within a solve.

    Attributes
    ----------
    address : int
        The address of the present stepping kernel.
    open : bool
        True if the inlined kernel may still take over.
    """

    def __init__(self, problem, bound, may_inline=True):
        p, n, name = problem, len(problem.y0), problem.method.name
        function, self.open, kernel = bound.function, False, None
        if p.method.series:
            self._kernel = series_kernel(p, bound)
            self.address = self._kernel.address
            return
        may_inline = may_inline and inlines(name, n) and p.compile != "shared"
        if function is not None and may_inline:
            self._name, self._function, self._n = name, function, n
            self._place = "seconds", name, n
            build = p.compile == "inlined" or function.notes.get(self._place, 0.0) > PROMOTE_AFTER
            kernel = inlined_kernel(name, function, n, build)
            self.open = kernel is None
        self._kernel = kernel or shared_kernel(name, bool(bound.pair))
        self.address = self._kernel.address

    def record_time(self, seconds):
        """Add the time of a chunk, in seconds."""
        if self.open:
            notes = self._function.notes
            notes[self._place] = notes.get(self._place, 0.0) + seconds

    def promote(self):
        """Between two chunks, replace the shared kernel by the inlined kernel if that pays."""
        if self.open and self._function.notes[self._place] > PROMOTE_AFTER:
            self._kernel = inlined_kernel(self._name, self._function, self._n) or self._kernel
            self.address = self._kernel.address
            self.open = False
