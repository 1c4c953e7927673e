"""Following: compiled functions read outside values again after the user's Python code ran.

Python code that runs within a solve may change any value that a compiled function reads.  The
values are read again before the next evaluation.  If the new values need other code, the block
gets the address of this code, or of a callback of the Python function.
"""

import numpy as np

from fastdyn.compile.bind import bind, rebind
from fastdyn.compile.functions import BASE
from fastdyn.compile.python_callback import Callback
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FAULT, FIRST, JACOBIAN
from fastdyn.problem.events import between_steps
from fastdyn.problem.second_order_and_pairs import Pair, takes_batches

MOST_MADE = 4  # pieces of code that are made while a solve waits
ROOM = 64  # least number of words for parameters, in the block of code that may be replaced


class CannotFollow(ValueError):
    """Python code changed a value that needs other code, where the code cannot be replaced."""


def followed(problem, bound, others, ran):
    """A Followed for each compiled function of a problem whose functions are bound.

    Parameters
    ----------
    problem : validate.Problem
    bound : Bound
    others : list of Bound
    ran : callable
        ``ran(callback)`` is called for each Callback that takes over.
    """
    near = Near(problem.t0, problem.tf, problem.y0, takes_batches(problem))
    return [
        Followed(each, fun, problem.args, near, ran)
        for each, fun in functions_of(problem, bound, others)
        if each.function is not None and not each.mode.constant
    ]


def functions_of(problem, bound, others):
    """(Bound, function) of the equations, two of a Pair, and of functions called between steps."""
    p = problem
    own = zip(bound.pair, p.fun, strict=True) if isinstance(p.fun, Pair) else [(bound, p.fun)]
    return [*own, *zip(others, [fun for fun, _ in between_steps(p)], strict=True)]


def with_room(bound):
    """A copy of a Bound whose block has room for the parameters of other code."""
    if bound.function is None or bound.pair or bound.mode.constant:
        return bound
    end = int(bound.block[FAULT])
    n_words = end - FIRST
    room = max(ROOM, 2 * n_words)
    block = _longer(bound.block, end, FIRST + room)
    return bound._replace(block=block, seen=None if bound.seen is None else {})


def _longer(block, end, new_end):
    longer = np.zeros(new_end + len(block) - end, block.dtype)
    longer[:end], longer[new_end:] = block[:end], block[end:]
    longer[FAULT] = new_end
    return longer


def may_take_other_code(bound):
    """True if other outside values of a function could need other code."""
    return bound.function is not None and changes_of_code(*_given(bound))


def _given(bound):
    """The arguments of `bind` for a compiled function: function, args, mode, length of y."""
    held = bound.held
    return held.fun, held.args, bound.mode, bound.n, bound.function.in_batches


def changes_of_code(fun, args, mode, n, batches=False):
    """True if other outside values may need other code.

    Numbers of one type are parameters of the code, and need no other code.
    """
    known = Attempt(fun, args, mode, n).known(batches)
    return known is None or known[0].traced.trace.reads.may_need_other_code()


def keep_true(functions, args, near, callbacks):
    """Let compiled functions read their outside values again after a function has run in Python.

    `functions` are (Bound, function); CannotFollow is raised if the new values need other code.
    """
    every = [Followed(b, f, args, near, None) for b, f in functions if b.function is not None]

    def look():
        for each in every:
            if not each.holds():
                raise CannotFollow(
                    f"`{getattr(each.fun, '__name__', 'fun')}` reads what another function "
                    "changes during the solve, so that its code no longer holds."
                )

    for callback in callbacks:
        callback.after = look


class Followed:
    """A compiled function with a current block: call the object after Python code has run."""

    def __init__(self, bound, fun, args, near, ran):
        self.bound = bound
        self.fun = fun
        self._args = args
        self._near = near
        self._ran = ran
        self._held = []
        self._n_made = 0

    def holds(self):
        """Read the outside values into the block; True if the present code fits these values."""
        return self.bound.function is None or rebind(self.bound, self.fun, self._args)

    def __call__(self):
        if not self.holds():
            self._take_other_code()

    def _take_other_code(self):
        own = self.bound
        block = own.block
        n = own.n
        if block[JACOBIAN]:
            raise CannotFollow(
                f"`{getattr(self.fun, '__name__', 'fun')}` reads what other functions of the "
                'solve change, and its Jacobian cannot follow: give `jac="2-point"`.'
            )
        if BASE in own.function.notes:
            raise CannotFollow(
                f"`{getattr(own.held.fun, '__name__', 'fun')}` reads what another function of "
                "the solve changes, and its sensitivities cannot follow."
            )
        self._n_made += Attempt(self.fun, self._args, own.mode, n).known() is None
        refused = "it changes too often" if self._n_made > MOST_MADE else None
        new = bind(self.fun, self._args, own.mode, n, self._near, refused=refused)
        room = int(block[FAULT]) - FIRST
        self._held.append(new)
        if new.function is None or new.function.n_words > room:
            callback = new.callback or Callback(own.python, own.mode, n)
            new = new._replace(function=None, block=block, callback=callback)
            block[0] = callback.address
            self._held.append(callback)
            self._ran(callback)
        else:
            block[FIRST : FIRST + new.function.n_words] = new.block[FIRST : int(new.block[FAULT])]
            block[0] = new.function.address
            new = new._replace(block=block, seen={})
        self.bound = new
