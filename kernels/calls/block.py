"""The words of a block, the data of one compiled function in one solve.

``block`` is an int64 array.  The words are, in order:

- the address of the function;
- whether the function raised;
- the sides of its decisions, two bits for each of the first decisions: it was true, or was false;
- the time at which the function raised, and the place of the state there;
- three addresses, each 0 if there is no such thing: the block of the Jacobian, the words of the
  mass matrix (`algebra/mass.py`), the words of the matrices (`algebra/matrices.py`);
- the address of the addresses of kernels that few solves of implicit methods need;
- in the block of a Jacobian: the numbers of its entries (0 for a full matrix) and of its groups of
  columns, whether its function takes this block, and, for a residual, the numbers of entries of
  dF/dy and of dF/dy';
- the parameters of the function.

A Jacobian of the user is called as any function, and fills n x n numbers, row by row.  The block of
a constant Jacobian has the address 0, and the numbers of the Jacobian in place of parameters.

A sparse Jacobian has N_ENTRIES entries, column by column.  The places of the entries in the matrix
lie behind the words.  The entries have one of four sources:

- the function of an exact Jacobian, which takes the block of the derivative, and appends df/dt for
  a method that needs df/dt;
- a function of the user, with a block of its own (OWN_BLOCK);
- differences in GROUPS of columns, which also replace exact entries that are not finite;
- constant numbers behind the places.
"""

ADDRESS, RAISED_WORD, SIDES, TIME, FAULT, JACOBIAN, MASS, MATRICES, RARE = range(9)
N_ENTRIES, GROUPS, OWN_BLOCK, N_STATE, N_RATE, FIRST = range(9, 15)
MOST_DECISIONS = 31  # that have bits in SIDES

# Words of the block of a pair, q' = velocity(t, p), p' = force(t, q): the blocks of both functions.
VELOCITY = FIRST
FORCE = FIRST + 1
WORDS_OF_PAIR = FIRST + 2

# Words of the matrices of an implicit method, see `algebra/matrices.py`: two routines for real
# matrices, two for complex ones.  Kinds: our elimination; routines with LAPACK's interface, for
# full or for band matrices; another solver.
KIND, ROWS, LD, BASE, BELOW, ABOVE, REAL, COMPLEX, PRODUCT = (*range(7), 8, 10)
ORDERED = 11
ORDER = 12
OWN, FULL, BAND, OUTSIDE = range(4)

# The kernels that RARE names, see `fastdyn/specialise/rare.py`.
OTHER_JACOBIAN, OTHER_FACTORS, OTHER_SOLUTION = range(3)
OTHER_COMPLEX_FACTORS = 3
OTHER_COMPLEX_SOLUTION = 4
PAST_OF_RARE = 5  # the words of the past, see `output/past/steps.py`; 0 without a past

# Words of a mass matrix, see `algebra/mass.py`.
N, LOWER, UPPER, PENCIL, PLACES = range(5)

# Words behind FIRST of the block of a pencil, see `algebra/pencil.py`.  They are the addresses of
# `change` and `settle`, and of the block of the equations; the number of algebraic equations; the
# address of the numbers; the evaluations of the equations since the last count; and the failure,
# NO_START if the start is not consistent, NOT_FOUND if Newton's iteration finds no consistent
# state.  The function of the block is `rates` of `algebra/consistent_states.py`.
CHANGE, SETTLE, EQUATIONS, N_ALGEBRAIC, NUMBERS, EVALUATIONS, FAILURE = range(FIRST, FIRST + 7)
WORDS_OF_PENCIL = FIRST + 7
NO_START = 1
NOT_FOUND = 2

# Words behind FIRST of the block of an action whose state is made consistent: the addresses of the
# block of the user's function, and of the block of the pencil.
ACTION = FIRST
PENCIL_OF_ACTION = FIRST + 1
WORDS_OF_ACTION = FIRST + 2

FAILED = -(2**62)  # status of a kernel that raised an exception, which no kernel of fastdyn does


def shapes_of_pencil(n, r):
    """The shapes of the numbers of a pencil of n components with r algebraic equations."""
    return (1,), (n,), (n,), (n, n), (r, n), (r, n), (r, r), (4, r), (5, n)
