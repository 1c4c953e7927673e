"""The words by which the code of a series describes itself.

The series is code for one function: ``int64 series(double t, double scale, double *room)`` computes
the coefficients at the time t and at the state in the room, in powers of t / scale, and returns 1
if the function may raise there.  All numbers are in the room of the kernel: states and coefficients
lie in vectors, the coefficients of order k of a vector STRIDE k numbers behind the state.  The
lanes of the vectors are components of the state, in any order; a lane without a component has the
number -1, and its tolerances are zero.

Behind the words are tables: the place of each vector of states; the component of each lane; then,
for the numbers that a step watches (see `kinks.py`), the place of each vector, and the kind of each
lane.
"""

WIDTH, STRIDE, N_VECTORS, ARRAYS, FLAGS = range(5)
N_WATCHED, STRIDE_OF_WATCHED, WATCHED, TABLES = range(5, 9)

# With a trajectory in each lane, all vectors are components.  Three vectors lie before ARRAYS: the
# times, the units of the series, and 1 for a lane where the function raises.  The code
# ``int64 ask(double, double, double *room)`` calls the function at the times in TIMES and at the
# states in NOW, for the slopes GIVEN.
TIMES, UNITS, RAISES, N_OF_LANES = range(4)

# FLAGS: rtol may be near rounding; series and function are compared inside each step; the function
# has roots, which steps along the tangent may pass; the function may raise where no condition is
# watched; the function may jump where differences change sign.
FINE = 1
DECEPTIVE = 2
ROOTED = 4
MAY_RAISE = 8
JUMPS = 16

# The rows of ARRAYS, each as long as all vectors of states.  With one trajectory, the state NOW is
# order 0 of the series instead.
N_ARRAYS = 11
NOW, LOW_NOW, BEFORE, LOW_BEFORE, RELATIVE, ABSOLUTE, WEIGHTS, PREDICTED = range(8)
INSIDE, INSIDE_PREDICTED, GIVEN = range(8, 11)

# The kinds of watched numbers, as in `Plan.watched`.  The rows of WATCHED, each as long as all
# vectors of watched numbers: the sides of differences that are zero, chosen in the step; the width
# and the share of a `Hold`, infinite without; 1 for the argument of a root; 0 for numbers that must
# not change sign, else infinite; a mark of numbers that are searched.
SIGNED = 1
TOUCHES = 2
HOLDS = 4
CHOSEN, WIDTHS, SHARES, TOUCHING, FREE, MARKS = range(6)
N_OF_WATCHED = 6
