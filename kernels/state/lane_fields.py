"""The rows of `lanes`, the array that has a column for each trajectory of a vector.

Behind the named rows lies one row for each event function and for each accumulated value.
"""

T, T_OLD, T_END, T_STOP, H, ERROR, ACCEPTED, REJECTED, TRIES, LIMIT, LIVE, STATUS = range(12)
EVALUATIONS = 12  # evaluations beyond the constant number of each step
N_FIELDS = 13
NOTHING = -1  # status of a lane that does not need the scheduler
LEFT = -2  # status of a lane that leaves its next step to the kernel for one trajectory
