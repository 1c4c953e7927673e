"""Parameters of equations of motion from measured data: `fit`, and the `Fit` that it returns."""

from .fit import fit
from .free import Free
from .record import Record
from .result import Fit

__all__ = ["Fit", "Free", "Record", "fit"]
