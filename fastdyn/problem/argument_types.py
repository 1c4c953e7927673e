"""Types of the arguments of public functions; only type checkers import this file."""

import os
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

Function: TypeAlias = Callable[..., Any]  # of (t, y, *args)
Functions: TypeAlias = Function | Sequence[Function]
TimeSpan: TypeAlias = Sequence[float] | np.ndarray
Times: TypeAlias = ArrayLike
State: TypeAlias = ArrayLike
Method: TypeAlias = str | type  # a name, or a class of SciPy's solvers
Args: TypeAlias = Sequence[Any] | np.ndarray
Path: TypeAlias = str | os.PathLike[str]
