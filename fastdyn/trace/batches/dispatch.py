"""Dispatches NumPy's and SciPy's calls on long arrays that depend on the state."""

import functools
from typing import Any

import numpy as np

from ..islands import apart, or_apart
from ..numpy import functions
from ..numpy.calls import WITH_EFFECTS
from ..numpy.fourier import TRANSFORMS
from ..numpy.of_numbers import of_numbers
from ..symbols.arrays import stored
from ..symbols.complex_pair import any_complex
from ..symbols.layout import as_numpy_does, promoted
from ..symbols.masks import WHY, Masked
from ..symbols.symbolic import BATCHES, NOW, Batched, refuse
from .filters import FILTERS
from .formulas import as_columns, elementwise
from .library import OF_COMPLEXES, OWN, reduced
from .products import matmul
from .structure import JOINING, STRUCTURE, joined, structured

FOR_ALL_ARRAYS = {  # functions whose stand-ins in `numpy.functions` also handle long arrays
    np.clip, np.select, np.isclose, np.nan_to_num, np.sinc, np.interp, np.round,
    np.around, np.gradient, np.linalg.norm, np.dot, np.inner, np.vdot, np.outer,
    np.shape, np.ndim, np.size, np.real, np.imag, np.angle, np.iscomplexobj, np.isrealobj,
    np.isscalar,
}  # fmt: skip


def call_ufunc(ufunc, method, args, kwargs):
    """``ufunc(*args)``, or the method `method` of the ufunc, such as "reduce"."""
    table = NOW.table
    out, where = kwargs.pop("out", None), kwargs.pop("where", True)
    if kwargs.get("dtype") in (float, np.float64, None):
        kwargs.pop("dtype", None)
    kwargs.pop("casting", None)
    if any(isinstance(a, Masked) for a in args):
        refuse(WHY)
    if method == "__call__":
        if kwargs:
            refuse(f"np.{ufunc.__name__} with {next(iter(kwargs))}")
        if ufunc is np.matmul:
            result = as_numpy_does(ufunc, args, {}, matmul(table, *args))
        else:
            result = promoted(ufunc, args, elementwise(table, of_numbers(ufunc), args))
        if where is not True:
            kept = 0.0 if out is None else out[0]
            result = elementwise(table, functions.select, (where, result, kept))
    elif method == "reduce":
        if where is not True:
            refuse(f"np.{ufunc.__name__}.reduce of chosen elements")
        found = reduced(table, ufunc, *args, **kwargs)
        result = as_numpy_does(ufunc.reduce, args, kwargs, found)
    elif method == "outer":
        both: Any = [np.asarray(x) if not isinstance(x, Batched) else x for x in args]
        a, b = both
        result = ufunc(a.reshape(a.shape + (1,) * b.ndim), b)
    else:
        refuse(f"{ufunc.__name__}.{method} of a long array")
    return stored(result, out)


def call_function(function, args, kwargs):
    """Call the stand-in of a NumPy function; without a stand-in, compiled code calls NumPy."""
    table, of_complexes = NOW.table, any(map(any_complex, (*args, *kwargs.values())))
    if kwargs.get("dtype") in ((complex, np.complex128) if of_complexes else (float, np.float64)):
        kwargs = {k: v for k, v in kwargs.items() if k != "dtype"}
    if function in TRANSFORMS:
        return or_apart(function, functools.partial(_transformed, function))(*args, **kwargs)
    if of_complexes and not _takes_complexes(function):
        return apart(function, args, kwargs)
    if function in STRUCTURE:
        return structured(table, function, args, kwargs)
    if function in JOINING:
        return joined(table, function, *args, **kwargs)
    if function is np.where:
        return promoted(function, args, functions.where(*args, **kwargs))
    if function is np.piecewise:
        return functions.piecewise(*args, **kwargs)
    if function in OWN:
        return as_numpy_does(function, args, kwargs, OWN[function](table, *args, **kwargs))
    if function in FOR_ALL_ARRAYS:
        found = functions.STAND_INS[function](*args, **kwargs)
        return as_numpy_does(function, args, kwargs, found)
    if isinstance(function, np.ufunc):
        return function(*[_listed(table, a) for a in args], **kwargs)
    if function.__name__ in WITH_EFFECTS:
        refuse(f"np.{function.__name__} of a long array that depends on the state")
    return apart(function, args, kwargs)


def _transformed(function, *args, **kwargs):
    return as_numpy_does(function, args, kwargs, TRANSFORMS[function](*args, **kwargs))


def _takes_complexes(function):
    """Whether the stand-in of a function of NumPy also handles complex numbers."""
    elementwise_or_moves = function in STRUCTURE or function in JOINING or function is np.where
    return elementwise_or_moves or function in OF_COMPLEXES or isinstance(function, np.ufunc)


def _listed(table, value):
    return as_columns(table, value) if isinstance(value, list | tuple) else value


def call_scipy(function, stand_in, args, kwargs):
    """Call the stand-in of a SciPy function; refuse a function without a stand-in."""
    name = getattr(function, "__name__", "")
    if stand_in is None:
        if any(map(any_complex, args)):
            refuse(f"{name} of long complex arrays")
        stand_in = FILTERS.get(name)
    if stand_in is not None:
        return as_numpy_does(function, args, kwargs, stand_in(*args, **kwargs))
    if name == "norm":
        return functions.STAND_INS[np.linalg.norm](*args, **kwargs)
    return refuse(f"{name} of a long array that depends on the state")


BATCHES.update(
    ufunc=call_ufunc, function=call_function, elementwise=elementwise, scipy=call_scipy,
    raised=as_columns,
)  # fmt: skip
