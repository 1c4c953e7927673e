"""The words of a block, with which a function of the user is called; what kernels return.

``block`` is an int64 array that carries what belongs to one solve: the address of the function,
whether it raised, and when; where the state is kept when it raised; of a derivative, the address of
the block of its Jacobian, or 0 if there is none, and that of its mass matrix (`algebra/mass.py`),
or 0; then its parameters.

A Jacobian of the user is called as any function, and fills n x n numbers, row by row.  The block
of a constant one names no function: its numbers take the place of parameters.  The function of an
exact one takes the block of the derivative, and gives the entries that are not zero everywhere:
N_ENTRIES, with their places, column by column, in the place of parameters.  For a method that wants
it, the time derivative follows the entries.
"""

ADDRESS, RAISED_WORD, TIME, FAULT, JACOBIAN, MASS, FIRST = 0, 1, 2, 3, 4, 5, 6
N_ENTRIES = JACOBIAN  # of the block of a Jacobian; 0 if it is full

# Of a pair, q' = velocity(t, p) and p' = force(t, q): the addresses of the blocks of both.
VELOCITY, FORCE = FIRST, FIRST + 1
WORDS_OF_PAIR = FIRST + 2

# Of a mass matrix, see `algebra/mass.py`.
N, LOWER, UPPER, PLACES = 0, 1, 2, 3

FAILED = -(2**62)  # returned by a kernel that raised, which none of ours does
