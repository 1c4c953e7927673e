"""The names of the words that C reads: the words of an entry, of a run, and of a row (one read)."""

OF_ENTRY = "table idle slow finish fun args y0 n_args most_given".split()
OF_RUN = (
    "live left_then look n room n_sized smallest largest image h_max_share n_eval t_eval n_short "
    "n_rest launch launch_kernel words kernel n_steps advance advance_kernel memory n_points t y "
    "state n_stages left n_sides sides n_rows rows found n_arrays arrays"
).split()
ENTRY = {name: 8 * i for i, name in enumerate(OF_ENTRY)}
RUN = {name: 8 * i for i, name in enumerate(OF_RUN)}

FIELDS = "parent step key check expected scope count place fixed value same".split()
ROW = {name: 8 * i for i, name in enumerate(FIELDS)}
SIZE = 8 * len(FIELDS)
ITSELF, GLOBAL, BUILTIN, CELL, DEFAULT, IN_TUPLE, IN_LIST, IN_DICT, OWN = range(9)  # steps
ANY, SAME, ABSENT, CODE, FLOAT, WHOLE, EMPTY, TUPLE, LIST, KEYS, ARRAY = range(11)  # checks
