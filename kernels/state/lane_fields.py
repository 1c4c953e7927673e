"""The rows of `lanes`, the array that has a column for each trajectory of a vector.

Behind them is one row for each event function and for each accumulated value.
"""

T, T_OLD, T_END, T_STOP, H, ERROR, ACCEPTED, REJECTED, TRIES, LIMIT, LIVE, STATUS = range(12)
N_FIELDS = 12
NOTHING = -1  # status of a lane with nothing for the scheduler
