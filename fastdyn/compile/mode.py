"""The modes: what kinds of functions there are, and how each is called.  Nothing else asks a name.

A compiled function gets n numbers and gives `n_results(n)`; the user's own gets and gives what
`given` and the flags say.
"""

from dataclasses import dataclass


@dataclass(frozen=True, eq=False, repr=False)
class Mode:
    """How one kind of function is called.

    Attributes
    ----------
    name : str
        In keys of kept code.
    argument : str
        What the user's function is for him, in sentences.
    one_number, matrix : bool
        Whether the result is one real number, or n rows of n; otherwise it is like the state.
    complex_numbers : bool
        Whether y is half as many complex numbers.
    column : bool
        Whether y is given as (n, 1), as `vectorized=True` has it.
    second_order : bool
        Whether y is given with as many zeros behind it, velocities, and only the second half of
        the result counts.
    moments : tuple of str
        Integrals that follow the state: "mean" of the state, "rms" of its squares.
    half : int or None
        Which half of a state [q, p] it is given.
    constant : bool
        Whether there is no function: a matrix that stays the same.
    entries : bool
        Whether the result is the entries of a sparse matrix, however many.
    sensitivities : bool
        Whether the derivative is made from that of the user, and followed by sensitivities.
    acts_at_events : bool
        Whether it gives the state after an event, for which it may write to y.
    acts_on_state : bool
        Whether a function in Python that writes to y changes the state, as in SciPy.
    long_arrays : bool
        Whether its trace may keep arrays long.
    notes_sides : bool
        Whether its machine code notes which sides its decisions take.
    probed : bool
        Whether it is called in Python before a solve, for the mistakes in it.
    by_numba : bool
        Whether Numba may compile a function that cannot be traced; else it stays in Python.
    in_vectors : bool
        Whether kernels may evaluate the stages of a step at once on vectors.
    """

    name: str
    argument: str = "fun"
    one_number: bool = False
    matrix: bool = False
    complex_numbers: bool = False
    column: bool = False
    second_order: bool = False
    moments: tuple = ()
    half: int | None = None
    constant: bool = False
    entries: bool = False
    sensitivities: bool = False
    acts_at_events: bool = False
    acts_on_state: bool = False
    long_arrays: bool = False
    notes_sides: bool = False
    probed: bool = False
    by_numba: bool = False
    in_vectors: bool = False

    def __repr__(self):
        return repr(self.name)

    def __reduce__(self):
        return _named, (self.name,)

    @property
    def n_copies(self):
        """How many times the user's state fits into the state, with the moments that follow."""
        return 1 + len(self.moments)

    @property
    def compared(self):
        """Whether machine code of a solve is compared with the function at its states."""
        return not (self.constant or self.entries or self.sensitivities)

    def given(self, n):
        """Numbers that the user's function gets, the shape of its result, zeros behind them.

        The shape is None of one number.
        """
        own = n // 2 if self.complex_numbers else n // self.n_copies
        if self.one_number:
            return own, None, 0
        if self.second_order:
            return n, (2 * n,), n
        return own, (n * n,) if self.matrix else (n, 1) if self.column else (own,), 0

    def n_results(self, n):
        """Numbers that the compiled function gives, where the mode says that."""
        return 1 if self.one_number else n * n if self.matrix else n


MODES: dict[str, Mode] = {}


def _named(name):
    return MODES[name]


def _mode(name, **facts):
    MODES[name] = mode = Mode(name, **facts)
    return mode


DERIVATIVE = _mode(
    "derivative", acts_on_state=True, long_arrays=True, notes_sides=True, probed=True,
    by_numba=True, in_vectors=True,
)  # fmt: skip
COLUMN = _mode("column", column=True, acts_on_state=True)
ACCELERATION = _mode("acceleration", second_order=True, in_vectors=True)
VELOCITY = _mode("velocity", argument="velocity", half=1)
FORCE = _mode("force", argument="force", half=0)
EVENT = _mode("event", one_number=True, long_arrays=True, notes_sides=True, by_numba=True)
JUMP = _mode("jump", argument="on_event", acts_at_events=True, notes_sides=True, probed=True)
MATRIX = _mode("matrix", matrix=True, probed=True)
ENTRIES = _mode("entries", entries=True)
CONSTANT = _mode("constant", constant=True)
COMPLEX_NUMBERS = _mode("complex", complex_numbers=True)
COMPLEX_EVENT = _mode("complex event", complex_numbers=True, one_number=True)
SENSITIVITIES = _mode("variational", sensitivities=True)
MOMENTS: dict[tuple, Mode] = {
    moments: _mode(" ".join(moments), moments=moments)
    for moments in (("mean",), ("rms",), ("mean", "rms"))
}
