"""The table of snapshots, shape (1 + places, 2 + n); see `state/snapshots.py`."""

# Numbers in row 0: the present row, the steps in an interval, and the steps left in the present
# interval.
PLACE, STRIDE, LEFT = range(3)
# Columns of the other rows: the size of a step, the time at its end, and from STATE on the state.
SIZE, TIME, STATE = range(3)
