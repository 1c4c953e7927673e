"""Implicit Runge-Kutta steps of constant size for y' = f(t, y), solved by fixed-point iteration.

The arrangement is that of M. Antonana, J. Makazaga and A. Murua, "Reducing and monitoring
round-off error propagation for symplectic implicit Runge-Kutta schemes", Numer. Algorithms 76
(2017): with L_j = h b_j f(Y_j) the stages are Y_i = y + sum mu_ij L_j, where mu_ij = a_ij / b_j
is rounded so that mu_ij + mu_ji = 1 holds exactly, and y + sum L_j is summed with compensation.
The iteration starts from the stages of the last step, extrapolated, and goes on until no component
has got nearer twice (E. Hairer, R. I. McLachlan and A. Razakarivony, "Achieving Brouwer's law with
implicit Runge-Kutta methods", BIT 48 (2008)): a tolerance would leave errors of one sign.

The stages of a component lie side by side, so that they are one vector of the processor.
"""

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.imputils import lower_constant
from numba.extending import intrinsic, models, register_model, typeof_impl
from numba.np import arrayobj

from .calls import FUSED
from .calls import RAISED as RAISED_WORD
from .combine import ROW, fetch, halves, slot
from .fixed import LANDED
from .state import (
    FINISHED,
    NON_FINITE,
    NOT_CONVERGED,
    RAISED,
    RUNNING,
    STAGE,
    Y_OLD,
    K,
    Y,
)

REAL = ir.DoubleType()
MAX_ITERATIONS = 100
SMALL = 1e-6  # changes above this share of a component are not rounding
STALLS = 2  # positions and velocities get nearer in turns: one iteration without progress is none


class Matrix:
    """A square matrix of constants known to the compiler, given by rows."""

    def __init__(self, rows):
        self.rows = tuple(tuple(map(float, row)) for row in rows)


class MatrixType(types.Type):
    """The type of one Matrix; its numbers are part of the type."""

    def __init__(self, rows):
        self.rows = rows
        super().__init__(name=f"Matrix({rows!r})")


register_model(MatrixType)(models.OpaqueModel)


@typeof_impl.register(Matrix)
def _typeof_matrix(value, context):
    return MatrixType(value.rows)


@lower_constant(MatrixType)
def _constant_matrix(context, builder, ty, value):
    return context.get_dummy_value()


def _stages_at(context, builder, work, args, s):
    """Pointer to the s stages of component args[2] in the block of rows from args[1] on."""
    array = arrayobj.make_array(work)(context, builder, args[0])
    n = builder.extract_value(array.shape, 1)
    at = builder.add(builder.mul(args[1], n), builder.mul(args[2], ir.Constant(n.type, s)))
    pointer = builder.gep(array.data, [at])
    return builder.bitcast(pointer, ir.VectorType(REAL, s).as_pointer())


def _splat(builder, value, s):
    vector = ir.VectorType(REAL, s)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.IntType(32)(0))
    return builder.shuffle_vector(
        one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), s), None)
    )


def _product(builder, matrix, stages, s):
    """matrix @ stages: a fused multiply-add of whole vectors for each column, in two chains."""
    vector = ir.VectorType(REAL, s)
    kind = ir.FunctionType(vector, [vector] * 3)
    fma = cgutils.get_or_insert_function(builder.module, kind, f"llvm.fma.v{s}f64")
    sums = [ir.Constant(vector, [0.0] * s)] * 2
    for j in range(s):
        column = ir.Constant(vector, [row[j] for row in matrix.rows])
        part = builder.extract_element(stages, ir.IntType(32)(j))
        sums[j % 2] = builder.call(fma, [column, _splat(builder, part, s), sums[j % 2]])
    return builder.fadd(*sums)


def _load(builder, pointer):
    value = builder.load(pointer)
    value.align = 8
    return value


@intrinsic
def predict(typingctx, matrix, work, row, c):
    """Stages of component c from those of the last step, in place."""
    s = len(matrix.rows)

    def codegen(context, builder, signature, args):
        pointer = _stages_at(context, builder, work, args[1:], s)
        result = _product(builder, matrix, _load(builder, pointer), s)
        builder.store(result, pointer).align = 8
        return context.get_dummy_value()

    return types.none(matrix, work, types.intp, types.intp), codegen


@intrinsic
def refine(typingctx, matrix, work, increments, stages, c, y, low):
    """Stages of component c from the increments: y + (low + mu L); the largest change."""
    s = len(matrix.rows)

    def codegen(context, builder, signature, args):
        _, array, first, second, component, y, low = args
        given = _stages_at(context, builder, work, (array, first, component), s)
        place = _stages_at(context, builder, work, (array, second, component), s)
        total = _product(builder, matrix, _load(builder, given), s)
        total = builder.fadd(_splat(builder, low, s), total)
        total = builder.fadd(_splat(builder, y, s), total)
        change = builder.fsub(total, _load(builder, place))
        builder.store(total, place).align = 8
        vector = ir.VectorType(REAL, s)
        fabs = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector]), f"llvm.fabs.v{s}f64"
        )
        largest = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(REAL, [vector]), f"llvm.vector.reduce.fmax.v{s}f64"
        )
        return builder.call(largest, [builder.call(fabs, [change])])

    numbers = (types.intp, types.intp, types.intp, types.float64, types.float64)
    return types.float64(matrix, work, *numbers), codegen


@intrinsic
def follow(typingctx, weights, work, increments, stages, k, of, h, end):
    """L of component k is h b times the stages of component `of`: positions follow velocities."""
    (b,) = weights.rows
    s = len(b)

    def codegen(context, builder, signature, args):
        _, array, first, second, k, of, h, end = args
        target = _stages_at(context, builder, work, (array, first, k), s)
        given = _stages_at(context, builder, work, (array, second, of), s)
        vector = builder.fmul(_splat(builder, h, s), ir.Constant(ir.VectorType(REAL, s), list(b)))
        for i in (0, s - 1):
            vector = builder.insert_element(vector, end, ir.IntType(32)(i))
        builder.store(builder.fmul(vector, _load(builder, given)), target).align = 8
        return context.get_dummy_value()

    numbers = (types.intp,) * 4 + (types.float64,) * 2
    return types.none(weights, work, *numbers), codegen


def _component(context, builder, work, array, row, s, c, i):
    """Pointer to stage i of component c."""
    value = arrayobj.make_array(work)(context, builder, array)
    n = builder.extract_value(value.shape, 1)
    at = builder.add(builder.mul(row, n), builder.add(builder.mul(c, n.type(s)), i))
    return builder.gep(value.data, [at])


@intrinsic
def stage_value(typingctx, form, place, work, row, matrix, i):
    """The state at stage i, as a value: a tuple, or the row `place`."""
    s = len(matrix.rows)
    signature_rest = (work, types.intp, matrix, types.intp)
    if isinstance(form, types.NoneType):

        def fill(context, builder, signature, args):
            _, target, array, row, _, i = args
            data = arrayobj.make_array(ROW)(context, builder, target)
            n = builder.extract_value(data.shape, 0)
            with cgutils.for_range(builder, n) as loop:
                source = _component(context, builder, work, array, row, s, loop.index, i)
                builder.store(builder.load(source), builder.gep(data.data, [loop.index]))
            return target

        return ROW(form, place, *signature_rest), fill

    def codegen(context, builder, signature, args):
        _, _, array, row, _, i = args
        parts = [
            builder.load(_component(context, builder, work, array, row, s, row.type(c), i))
            for c in range(len(form))
        ]
        return context.make_tuple(builder, form, parts)

    return form(form, place, *signature_rest), codegen


@intrinsic
def keep_increment(typingctx, value, work, row, matrix, i, weight):
    """L_i = weight * f, from a tuple or a row."""
    s = len(matrix.rows)

    def codegen(context, builder, signature, args):
        value_, array, row, _, i, weight = args

        def put(c, x):
            pointer = _component(context, builder, work, array, row, s, c, i)
            builder.store(builder.fmul(weight, x), pointer)

        if isinstance(value, types.BaseTuple):
            for c in range(len(value)):
                put(row.type(c), builder.extract_value(value_, c))
        else:
            data = arrayobj.make_array(ROW)(context, builder, value_)
            with cgutils.for_range(builder, builder.extract_value(data.shape, 0)) as loop:
                put(loop.index, builder.load(builder.gep(data.data, [loop.index])))
        return context.get_dummy_value()

    return types.none(value, work, types.intp, matrix, types.intp, types.float64), codegen


@njit(**FUSED)
def _judge(change, count, work, row, k, size):
    """(1, 0) if component k still gets nearer, (0, 1) if it did not change at all, else (0, 0)."""
    if count == 0:  # there was nothing to compare with
        return 1, 0
    if change == 0.0:  # for now, perhaps: it may wait for the others
        return 0, 1
    if change < work[row, k]:
        work[row, k] = change
        return 1, 0
    return (1 if change > SMALL * size else 0), 0


def make_step(s, mu, ratio, b, c, nystrom=False):
    """The step of a method: `mu`, `ratio` (for the prediction) are Matrix, b and c arrays.

    With `nystrom` the equations are q'' = a(t, q) of a state [q, v], and `rhs` is a: each
    iteration finds the velocities first and the positions from them, which takes half as many.
    """
    INCREMENTS, LOW, STAGES, CHANGE, SLOPE = K, K + s, K + s + 1, K + 2 * s + 1, K + 2 * s + 2
    half = s // 2
    weights = Matrix([b])

    @njit(**FUSED)
    def weight(h, i):
        """h b_i, the outermost two such that all add up to h."""
        if 0 < i < s - 1:
            return h * b[i]
        inner = 0.0
        for j in range(1, half):
            inner += h * b[j]
        return 0.5 * h - inner

    @njit(**FUSED)
    def refined(work, k, count):
        change = refine(mu, work, INCREMENTS, STAGES, k, work[Y, k], work[LOW, k])
        return _judge(change, count, work, CHANGE, k, _size(work, STAGES, s, k))

    if nystrom:

        @njit(**FUSED)
        def sweep(work, h, count):
            """New stages from the increments; how many components move, and how many are still."""
            n = work.shape[1]
            m = n // 2
            moving = exact = 0
            for k in range(m, n):
                moves, same = refined(work, k, count)
                moving, exact = moving + moves, exact + same
            for k in range(m):
                follow(weights, work, INCREMENTS, STAGES, k, k + m, h, weight(h, 0))
                moves, same = refined(work, k, count)
                moving, exact = moving + moves, exact + same
            return moving, exact

        @njit(**FUSED)
        def evaluate(rhs, t, h, i, form, work, block):
            """The increments of stage i from its stage."""
            part, _ = halves(form)
            place, _ = halves(slot(form, work, STAGE))
            target, _ = halves(slot(form, work, SLOPE))
            u = stage_value(part, place, work, STAGES, mu, i)
            f = rhs(t + c[i] * h, u, block, target)
            behind = work.shape[1] // 2 * s  # the velocities' come after the positions'
            keep_increment(f, work, INCREMENTS, mu, i + behind, weight(h, i))

    else:

        @njit(**FUSED)
        def sweep(work, h, count):
            """New stages from the increments; how many components move, and how many are still."""
            moving = exact = 0
            for k in range(work.shape[1]):
                moves, same = refined(work, k, count)
                moving, exact = moving + moves, exact + same
            return moving, exact

        @njit(**FUSED)
        def evaluate(rhs, t, h, i, form, work, block):
            """The increments of stage i from its stage."""
            u = stage_value(form, slot(form, work, STAGE), work, STAGES, mu, i)
            f = rhs(t + c[i] * h, u, block, slot(form, work, SLOPE))
            keep_increment(f, work, INCREMENTS, mu, i, weight(h, i))

    @njit(**FUSED)
    def step(rhs, t, h, first, form, work, block):
        """One step from row Y; (status, evaluations)."""
        n = work.shape[1]
        for k in range(n):
            work[CHANGE, k] = np.inf
            if not first:
                predict(ratio, work, INCREMENTS, k)
        if first:
            for i in range(s):
                keep_increment(fetch(form, work, SLOPE), work, INCREMENTS, mu, i, weight(h, i))
        count = stalls = 0
        while True:
            moving, exact = sweep(work, h, count)
            stalls = 0 if moving else stalls + 1
            if stalls == STALLS or exact == n:
                break
            if count == MAX_ITERATIONS:
                return NOT_CONVERGED, s * count
            for i in range(s):
                evaluate(rhs, t, h, i, form, work, block)
                if block[RAISED_WORD] != 0:
                    return RAISED, s * count + i + 1
            count += 1
        total = 0.0
        for k in range(n):
            y = work[Y, k]
            part = _sum(work, INCREMENTS, s, k) + work[LOW, k]
            work[Y_OLD, k] = y
            work[Y, k] = y + part
            work[LOW, k] = part - (work[Y, k] - y)
            total += abs(work[Y, k])
        return (RUNNING if total < np.inf else NON_FINITE), s * count

    return step


@njit(**FUSED)
def _at(work, row, s, k, i):
    n = work.shape[1]
    place = row * n + k * s + i
    return work[place // n, place % n]


@njit(**FUSED)
def _size(work, row, s, k):
    """How large component k is in this step."""
    return abs(_at(work, row, s, k, 0)) + abs(_at(work, row, s, k, s - 1))


@njit(**FUSED)
def _sum(work, row, s, k):
    """The sum of the increments of component k, the smallest weights first."""
    total = 0.0
    for i in range(s // 2):
        total += _at(work, row, s, k, i) + _at(work, row, s, k, s - 1 - i)
    return total


@njit(**FUSED)
def advance(rhs, step, form, state, work, block, n_steps):
    """Take at most `n_steps` steps; as `fixed.advance`, for implicit steps."""
    s = state[0]
    direction, t_end, t_stop, t_start = s.direction, s.t_end, s.t_stop, s.t_start
    h = direction * s.h
    status, taken = RUNNING, 0
    if direction * (s.t - t_end) >= 0.0:
        return FINISHED
    while taken < n_steps:
        status, evaluations = step(rhs, s.t, h, s.n_accepted == 0, form, work, block)
        s.n_extra += evaluations
        if status != RUNNING:
            break
        taken += 1
        s.n_accepted += 1
        s.t_old = s.t
        s.t = t_start + s.n_accepted * h
        if abs(s.t - t_end) <= LANDED * s.h:
            s.t = t_end
        if direction * (s.t - t_end) >= 0.0:
            status = FINISHED
        if status == FINISHED or direction * (s.t - t_stop) >= 0.0:
            break
    return status
