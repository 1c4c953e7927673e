"""A mass matrix in the form for kernels, and the functions that make states consistent."""

import math
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls import block as words
from fastdyn.problem.mass import equilibrated, parts_of
from fastdyn.specialise.scalar import evaluate_kernel, function_of_pencil

from .inconsistent import refuse_action, refuse_start


class Mass:
    """The matrix M of M y' = f, named in the block of the equations.

    Parameters
    ----------
    problem : validate.Problem
    bound : bind.Bound
        The equations.

    Attributes
    ----------
    left, right : ndarray, shape (r, n)
        Combinations of the equations without y', and directions that M maps to 0.
    blocks : list of ndarray
        The blocks of functions that may raise.
    """

    def __init__(self, problem, bound):
        p = problem
        n = len(problem.y0)
        mass, rows, columns = equilibrated(p.mass)
        inverse, left, right = parts_of(mass)
        self.left = left * rows
        self.right = right * columns
        self.problem = p
        self.bound = bound
        sizes = [math.prod(shape) for shape in words.shapes_of_pencil(n, len(self.left))]
        self._numbers = np.zeros(sum(sizes))
        parts = np.split(self._numbers, np.cumsum(sizes)[:-1])
        span = p.tf - p.t0 if math.isfinite(p.tf) else math.copysign(1.0, p.tf)
        given = (
            span, p.rtol, p.atol, columns[:, None] * inverse * rows, self.left, self.right,
        )  # fmt: skip
        for part, value in zip(parts, given, strict=False):
            part[:] = np.broadcast_to(np.ravel(value), part.shape)
        self._failed = parts[-1][-n:]
        self._kept: list = [function_of_pencil(name) for name in ("rates", "change", "settle")]
        self.block: Any = np.zeros(words.WORDS_OF_PENCIL, np.int64)
        places = [words.ADDRESS, words.CHANGE, words.SETTLE]
        self.block[places] = [code.address for code in self._kept]
        self.block[words.EQUATIONS] = address_of(bound.block)
        self.block[words.N_ALGEBRAIC] = len(self.left)
        self.block[words.NUMBERS] = address_of(self._numbers)
        self.blocks = [self.block]
        self._words = _entries(p.mass)
        self._words[words.PENCIL] = address_of(self.block)
        bound.block[words.MASS] = address_of(self._words)

    def consistent(self, others):
        """The Bounds `others`, but with actions that also make the new state consistent."""
        if not len(self.left):
            return others
        return [self._acting(each) if each.mode.acts_at_events else each for each in others]

    def _acting(self, action):
        block = np.zeros(words.WORDS_OF_ACTION, np.int64)
        code = function_of_pencil("act")
        block[words.ADDRESS], block[words.ACTION] = code.address, address_of(action.block)
        block[words.PENCIL_OF_ACTION] = address_of(self.block)
        self._kept += [code, action]
        self.blocks.append(block)
        return action._replace(block=block)

    def called(self, name, t, y):
        """The result of a function of the pencil at a time and a state; exceptions are dropped."""
        block = self.block.copy()
        out = np.zeros(len(y))
        block[words.ADDRESS] = function_of_pencil(name).address
        Call(evaluate_kernel(), block, t, np.ascontiguousarray(y), out)()
        return out

    def fun(self, t, y):
        """The equations at a time and a state."""
        out = np.zeros(len(y))
        Call(evaluate_kernel(), self.bound.block, t, np.ascontiguousarray(y), out)()
        return out

    def raise_kept(self):
        """Raise ValueError if a start, or the state behind an action, was not consistent."""
        if self.block[words.RAISED_WORD]:
            self.block[words.RAISED_WORD] = 0
            refuse = refuse_start if self.block[words.FAILURE] == words.NO_START else refuse_action
            refuse(self, float(self.block.view(float)[words.TIME]), self._failed.copy())


class NoMass:
    """The identity."""

    blocks: tuple = ()

    def __init__(self, bound):
        bound.block[words.MASS] = 0

    def consistent(self, others):
        return others

    def raise_kept(self):
        pass


def mass_of(problem, bound):
    """The mass matrix of a problem whose equations are bound."""
    return NoMass(bound) if problem.mass is None else Mass(problem, bound)


def _entries(matrix):
    """The words of `kernels/algebra/mass.py`."""
    columns, rows = np.nonzero(matrix.T)
    numbers = np.ascontiguousarray(matrix[rows, columns]).view(np.int64)
    far = rows - columns
    head = [len(rows), max(0, far.max(initial=0)), max(0, -far.min(initial=0)), 0]
    assert len(head) == words.PLACES
    return np.concatenate([np.array(head, np.int64), columns * len(matrix) + rows, numbers])
