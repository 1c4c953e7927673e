"""The error that a residual of the interpolant makes, by the matrix of an implicit step."""

from ...calls.user_function import by_pointer
from ...jit.options import INTERNAL, njit
from ...state.rows import copy_row
from .steps import size_of

# Share of a residual that may be left where a linear equation says that none is: 1 where Rodas5P
# stepped over the start of sqrt(8 t).
LINEAR = 0.5


def filter_by(solve, row, gamma):
    """The filter of a method: ``solve(s, work, block, row)`` divides by M / (h gamma) - J."""

    @njit(**INTERNAL)
    def filter_residual(state, work, block, t, values):
        """Filter a residual h r at time t within the last step: (I - h gamma J)^-1 h r.

        The rows of `values` are state, slope, h r, and the filtered residual to be found, which is
        the size of the error in stiff components, too.  Returns 0 if h r does not fall by the error
        as a linear equation says: from y = 0 on, y' = 1 / y has the same matrix as a fast decay.
        """
        s = state[0]
        n = work.shape[1]
        h = s.t - s.t_old
        size = size_of(work, values[0], values[2])
        for i in range(n):
            work[row, i] = values[2, i] / (h * gamma)
        solve(s, work, block, row)
        for i in range(n):
            values[0, i] += gamma * work[row, i]
            values[1, i] = h * values[1, i] + work[row, i]
        by_pointer(t, values[0], block, values[3])
        s.n_extra += 1
        for i in range(n):
            values[2, i] = h * values[3, i] - values[1, i]
        copy_row(work[row], values[3])
        return 1 if size_of(work, values[0], values[2]) <= LINEAR * size else 0

    return filter_residual
