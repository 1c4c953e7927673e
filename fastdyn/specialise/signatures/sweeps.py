"""The types of the arguments of the kernels that go back over the steps of a solve."""

from fastdyn.kernels.methods.adjoint import (
    BlocksOfCollocation,
    BlocksOfRosenbrock,
    Collocation,
    Memory,
    MemoryOfCollocation,
    MemoryOfRosenbrock,
    Outside,
    Rosenbrock,
    Seeds,
    Splitting,
    Steps,
    Table,
    Terms,
)

from . import ROW, TABLE, WORDS, kernel_of

TERMS = Terms(WORDS, WORDS, ROW)
OF_STEPS = Steps(ROW, ROW, ROW, WORDS), 0, TABLE
OF_SWEEP = Seeds(ROW, ROW, TABLE, ROW, WORDS), WORDS, WORDS, Memory(TABLE, TABLE, ROW, ROW)
COEFFICIENTS = Table(0, ROW, TERMS, TERMS, TERMS, WORDS, TABLE)
KICKS = Splitting(ROW, ROW, ROW, ROW, TABLE)
SWEEP = kernel_of(COEFFICIENTS, *OF_STEPS, *OF_SWEEP)
STEPS = kernel_of(ROW, TABLE, OF_STEPS[0])
SWEEP_WHOLE = kernel_of(
    COEFFICIENTS, OF_STEPS[0], TABLE, TABLE, *OF_SWEEP, Outside(TABLE, 0.0, ROW)
)
REPLAY = kernel_of(COEFFICIENTS, *OF_STEPS, WORDS, TABLE)
SWEEP_OF_KICKS = kernel_of(KICKS, *OF_STEPS, *OF_SWEEP)
REPLAY_OF_KICKS = kernel_of(KICKS, *OF_STEPS, WORDS, TABLE)
ROSENBROCK = Rosenbrock(TABLE, TABLE, ROW, ROW, TABLE, 0.0, *[WORDS] * 3, 0, 0, 0)
OF_ROSENBROCK = (
    BlocksOfRosenbrock(WORDS, WORDS, WORDS, WORDS),
    MemoryOfRosenbrock(TABLE, ROW, ROW, ROW, ROW, ROW),
)
SWEEP_OF_ROSENBROCK = kernel_of(ROSENBROCK, *OF_STEPS, OF_SWEEP[0], *OF_ROSENBROCK)
REPLAY_OF_ROSENBROCK = kernel_of(ROSENBROCK, *OF_STEPS, *OF_ROSENBROCK)
COLLOCATION = Collocation(ROW, TABLE, TABLE, ROW, ROW, TABLE, 0, 0.0, WORDS, WORDS, WORDS, 0, 0, 0)
OF_COLLOCATION = (
    BlocksOfCollocation(WORDS, WORDS, WORDS),
    MemoryOfCollocation(TABLE, ROW, ROW, ROW, ROW, ROW, ROW),
)
SWEEP_OF_COLLOCATION = kernel_of(COLLOCATION, *OF_STEPS, OF_SWEEP[0], *OF_COLLOCATION)
REPLAY_OF_COLLOCATION = kernel_of(COLLOCATION, *OF_STEPS, *OF_COLLOCATION)
