"""Which stepping kernel runs, and when a faster one is worth its compiling."""

from .scalar import MAX_TUPLE, pointer_kernel, specialised_kernel

PATIENCE = 1.0  # seconds in the pointer tier before the specialised kernel is worth its compiling


_seconds: dict = {}


class Tier:
    """Which stepping kernel runs, and when to change: the policy.

    Parameters
    ----------
    name : str
        Of the method.
    bound : adapt.Bound
    n : int
    tier : {"auto", "pointer", "specialised"}
        "auto" takes the specialised kernel where it exists already, and otherwise compiles it
        once this function has spent PATIENCE seconds in the pointer tier, over all its solves.

    Attributes
    ----------
    address : int
        Of the stepping kernel to call next.
    """

    def __init__(self, name, bound, n, tier):
        function = bound.function
        self._open, kernel = False, None
        if function is not None and 0 < n <= MAX_TUPLE and tier != "pointer":
            self._name, self._function, self._n = name, function, n
            self._place = (name, function.address, n)
            build = tier == "specialised" or _seconds.get(self._place, 0.0) > PATIENCE
            kernel = specialised_kernel(name, function, n, build)
            self._open = kernel is None
        self.address = (kernel or pointer_kernel(name, bool(bound.parts))).address

    def spend(self, seconds):
        """Note the time of a chunk."""
        if self._open:
            _seconds[self._place] = _seconds.get(self._place, 0.0) + seconds

    def review(self):
        """Between two chunks: change the tier if that pays."""
        if self._open and _seconds[self._place] > PATIENCE:
            self.address = specialised_kernel(self._name, self._function, self._n).address
            self._open = False
