"""The attributes that stand-ins of SciPy's objects return: copies that are watched for writes."""

import numpy as np

from ..numpy.constants import Constants
from ..numpy.plain_arrays import raised
from ..symbols.arrays import Array
from ..symbols.symbolic import refuse

NUMBERS = bool | int | float | complex | str | np.generic | None


def handed_out(part, watched):
    """A copy of an attribute; an array is appended to `watched`, to find writes after the run."""
    if type(part) is tuple:
        return tuple(handed_out(each, watched) for each in part)
    if not isinstance(part, np.ndarray):
        if isinstance(part, NUMBERS):
            return part
        refuse(f"it uses a {type(part).__name__} of an object", final=True)
    copy = raised(np.copy(part))
    copy = copy if isinstance(copy, Array) else np.copy(part).view(Constants)
    watched.append(copy.watch())
    return copy
