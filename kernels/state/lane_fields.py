"""The rows of `lanes`, the array that has a column for each trajectory of a vector.

Behind them is one row for each event function and for each accumulated value.
"""

T, T_OLD, T_END, T_STOP, H, ERROR, ACCEPTED, REJECTED, TRIES, LIMIT, LIVE, STATUS = range(12)
EVALUATIONS = 12  # outside of what the steps of a method always take
N_FIELDS = 13
NOTHING = -1  # status of a lane with nothing for the scheduler
LEFT = -2  # of a lane that leaves its next step to the kernel of one trajectory
