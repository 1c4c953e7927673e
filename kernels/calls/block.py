"""The words of a block, with which a function of the user is called; what kernels return.

``block`` is an int64 array that carries what belongs to one solve: the address of the function,
whether it raised, and when (until then, which sides its decisions took: SIDES); where the state is
kept when it raised; of a derivative, the address of the block of its Jacobian, or 0 if there is
none, that of its mass matrix (`algebra/mass.py`), or 0, and that of the matrices of an implicit
method (`algebra/matrices.py`), or 0; then its parameters.

A Jacobian of the user is called as any function, and fills n x n numbers, row by row.  The block
of a constant one names no function: its numbers take the place of parameters.

A Jacobian may also be known by its entries that are not zero everywhere: N_ENTRIES, column by
column, whose places in the matrix come first behind the words.  They are given by the function of
an exact one, which takes the block of the derivative, and, for a method that wants it, lets the
time derivative follow the entries; or by a function of the user (OWN_BLOCK); or by differences in
GROUPS of columns, also where an exact entry is not finite; or they are numbers behind the places.
"""

ADDRESS, RAISED_WORD, TIME, FAULT, JACOBIAN, MASS, MATRICES, FIRST = range(8)

# Two bits for each of the first decisions of a function: whether they were true, and false.
SIDES, MOST_DECISIONS = TIME, 31

# Of the block of a Jacobian; N_ENTRIES is 0 if it is full.
N_ENTRIES, GROUPS, OWN_BLOCK = JACOBIAN, MASS, MATRICES

# Of a pair, q' = velocity(t, p) and p' = force(t, q): the addresses of the blocks of both.
VELOCITY, FORCE = FIRST, FIRST + 1
WORDS_OF_PAIR = FIRST + 2

# Of the matrices of an implicit method, see `algebra/matrices.py`; two routines for real ones, two
# for complex ones.  Kinds: elimination here, routines with LAPACK's interface for full ones or for
# bands, another solver's, bands that are eliminated here unless they are complex.
KIND, ROWS, LD, BASE, BELOW, ABOVE, REAL, COMPLEX, PRODUCT = (*range(7), 8, 10)
ORDERED, ORDER = 11, 12
OWN, FULL, BAND, OUTSIDE, NARROW = range(5)

# Of a mass matrix, see `algebra/mass.py`.
N, LOWER, UPPER, PLACES = 0, 1, 2, 3

FAILED = -(2**62)  # returned by a kernel that raised, which none of ours does
