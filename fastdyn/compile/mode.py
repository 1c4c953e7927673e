"""The modes of functions: how each kind of function is called.

The compiled function takes n numbers and returns ``n_results(n)`` numbers.  `given` and the flags
tell what the user's function takes and returns.  Other files ask for flags, not for names of modes.
"""

from dataclasses import dataclass


@dataclass(frozen=True, eq=False, repr=False)
class Mode:
    """How one kind of function is called.

    Attributes
    ----------
    name : str
        Part of the keys of kept code.
    argument : str
        The name of the user's argument, for messages.
    one_number, matrix : bool
        Whether the result is one real number, or a matrix (n, n); else it has the state's shape.
    complex_numbers : bool
        Whether the user's y has n / 2 complex numbers.
    column : bool
        Whether the user's y has shape (n, 1), as for `vectorized=True`.
    second_order : bool
        Whether the user's y has n zeros, as velocities, behind the n numbers.  Only the second half
        of the user's result is used.
    moments : tuple of str
        Integrals behind the state: "mean" of the state, "rms" of the state's squares.
    half : int or None
        The half of a state [q, p] that the user's function takes.
    constant : bool
        Whether a constant matrix takes the place of a function.
    entries : bool
        Whether the result is the entries of a sparse matrix, in any number.
    residual : bool
        Whether the function is the residual of a DAE.
    sensitivities : bool
        Whether the function is the user's derivative extended by sensitivities.
    saltation : bool
        Whether the function is a change of the state extended by sensitivities.
    adds : bool
        Whether the function adds its results, in any number, to the numbers in `out`.
    acts_at_events : bool
        Whether the function gives the state after an event, and may write to y.
    acts_on_state : bool
        Whether a Python function that writes to y changes the state, as in SciPy.
    long_arrays : bool
        Whether long arrays may be traced in batches.
    notes_sides : bool
        Whether the machine code notes the sides that its decisions take.
    probed : bool
        Whether the function is called in Python before a solve, to find mistakes.
    by_numba : bool
        Whether Numba may compile a function that cannot be traced; else the function runs in
        Python.
    in_vectors : bool
        Whether kernels may evaluate the stages of a step together, as vectors.
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
    residual: bool = False
    sensitivities: bool = False
    saltation: bool = False
    adds: bool = False
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
        """The size of the state, with moments behind it, over the size of the user's state."""
        return 1 + len(self.moments)

    @property
    def compared(self):
        """Whether machine code is compared with the function at states of a solution."""
        of_others = self.entries or self.sensitivities or self.saltation or self.adds
        return not (self.constant or of_others)

    def shapes(self, n):
        """(length of the user's y, shape of the user's result, number of zeros behind y).

        The shape is None for a single number.
        """
        own = n // 2 if self.complex_numbers else n // self.n_copies
        if self.one_number:
            return own, None, 0
        if self.second_order:
            return n, (2 * n,), n
        return own, (n * n,) if self.matrix else (own, 1) if self.column else (own,), 0

    def n_results(self, n):
        """The number of results of the compiled function."""
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
RESIDUAL = _mode(  # F(t, [y, y']); the result is F and as many zeros
    "residual", argument="F", residual=True, long_arrays=True, notes_sides=True, by_numba=True,
)  # fmt: skip
COLUMN = _mode("column", column=True, acts_on_state=True)
ACCELERATION = _mode("acceleration", second_order=True, in_vectors=True)
VELOCITY = _mode("velocity", argument="velocity", half=1)
FORCE = _mode("force", argument="force", half=0)
EVENT = _mode(
    "event", argument="event", one_number=True, long_arrays=True, notes_sides=True, by_numba=True
)
PROJECTION = _mode(
    "projection", argument="project", acts_on_state=True, long_arrays=True, notes_sides=True,
    probed=True, by_numba=True,
)  # fmt: skip
JUMP = _mode("jump", argument="on_event", acts_at_events=True, notes_sides=True, probed=True)
MATRIX = _mode("matrix", argument="jac", matrix=True, probed=True)
HISTORY = _mode("history", argument="history", by_numba=True)  # of a delay equation
ENTRIES = _mode("entries", entries=True)
CONSTANT = _mode("constant", constant=True)
COMPLEX_NUMBERS = _mode("complex", complex_numbers=True, acts_on_state=True, long_arrays=True)
COMPLEX_COLUMN = _mode("complex column", complex_numbers=True, column=True, acts_on_state=True)
COMPLEX_EVENT = _mode("complex event", argument="event", complex_numbers=True, one_number=True)
SENSITIVITIES = _mode("variational", sensitivities=True)
RESIDUAL_SENSITIVITIES = _mode(
    "variational residual", argument="F", residual=True, sensitivities=True
)
SALTATION = _mode("saltation", argument="on_event", saltation=True)
TIMED = _mode("timed")  # numbers of the time and the parameters alone, in any number
VJP = _mode("vjp", adds=True)  # of (t, [y, k]): k df/dy, and k df/dp for parameters p
MOMENTS: dict[tuple, Mode] = {
    moments: _mode(" ".join(moments), moments=moments)
    for moments in (("mean",), ("rms",), ("mean", "rms"))
}
