"""The exceptions that say why a function has no graph."""

import functools
import threading


class Untraceable(Exception):
    """The reason why a function has no graph.

    Attributes
    ----------
    final : bool
        Whether the reason holds for all values from outside.
    effect : bool
        Whether the function has a side effect, so that machine code cannot replace it.
    said : bool
        Whether the user should see the reason; False if Numba may still compile the function.
    writes : bool
        Whether the function writes to an array or to its state, which machine code can do.
    alive : bool
        Whether the function asks which objects are alive; the trace then may leave no object alive.
    typed : bool
        Whether a long array has a type of numbers that a trace number by number does not know.
    """

    def __init__(
        self, why, *, final=False, effect=False, said=True, writes=False, alive=False, typed=False
    ):
        super().__init__(why)
        self.final = final or effect or alive or typed
        self.effect = effect
        self.said = said
        self.writes = writes
        self.alive = alive
        self.typed = typed


class NotYet(Untraceable):
    """The reason that compilation takes longer than the current solve may wait."""


class _Latest(threading.local):
    """The first Refusal of the current run; a bare ``except:`` of the user may catch a Refusal."""

    refusal: "Refusal | None" = None


LATEST = _Latest()


class Abandoned(BaseException):
    """Ends a path that is left to Python: on this path, the compiled function reports a failure."""


class Refusal(BaseException):
    """The reason why a function has no graph, raised inside the traced function.

    Refusal is a BaseException, so that ``except Exception`` in the user's code does not catch one.
    """

    def __init__(self, why, **flags):
        super().__init__(why)
        self.flags = {"effect": False, **flags}
        LATEST.refusal = LATEST.refusal or self

    def untraceable(self):
        """The exception for callers of `trace`."""
        return Untraceable(str(self), **self.flags)


class OutOfTime(Refusal):
    """The refusal of a trace that takes longer than its time limit."""

    def __init__(self):
        super().__init__("it takes too long to be compiled while a solve waits", said=False)

    def untraceable(self):
        return NotYet(str(self), said=False)


def refused_as(error):
    """Decorate a function that works on a finished graph: its Refusals become other exceptions.

    ``error(refusal)`` makes the exception; an OutOfTime becomes NotYet.  Therefore no code outside
    `trace` and `compile` sees a Refusal.
    """

    def decorate(work):
        @functools.wraps(work)
        def guarded(*args, **kwargs):
            try:
                return work(*args, **kwargs)
            except OutOfTime as reason:
                raise reason.untraceable() from None
            except Refusal as reason:
                raise error(reason) from None

        return guarded

    return decorate
