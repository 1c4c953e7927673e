"""The form of a traced function that is compiled on vectors."""

import functools
from typing import Any, NamedTuple

from fastdyn.code_store.numba_settings import DISABLED
from fastdyn.trace.graph.refusal import Untraceable

from ..callables import Uncompilable
from ..parameters import n_words
from ..traced.known import Attempt
from ..traced.make import traced_function
from .jacobian import jacobian
from .phases import phases


class VectorForm(NamedTuple):
    """A function in the form that a kernel on vectors needs.

    `parameters` has a (type, value) for each parameter.  ``text(symbol, skip=0)`` is the LLVM text
    of the function on vectors, whose parameters begin behind `skip` words of the block, with
    `n_results` vectors; None stands for a single vector.
    ``series(order)`` makes the Taylor kernel on vectors, ``jacobian(time)`` the Jacobian and its
    text, ``phases()`` the Phases and their text.  `raises` tells whether the function may raise;
    in lanes where the function raises, the form on vectors returns NaN.
    """

    key: str
    parameters: list
    n_words: int
    text: Any
    n_results: int | None
    series: Any
    jacobian: Any
    phases: Any
    raises: bool


def vector_form(fun, args, varying, mode, n, near, width):
    """The VectorForm of a function; `args[j]` has one number for each lane if `varying[j]`."""
    places = tuple([j for j, v in enumerate(varying, 1) if v])
    attempt = Attempt(fun, args, mode, n, places)
    found = None if DISABLED else traced_function(attempt, near)
    if found is None:
        raise Uncompilable(attempt.why() or "it cannot be traced")
    function, values, at = found
    spread = {at[j - 1] for j in places}
    parameters = [
        (("lanes", width), v) if i in spread else (k, v) for i, (k, v) in enumerate(values)
    ]
    kinds = [k for k, _ in parameters]
    given = {"n": n, "width": width, "exact": False, "kinds": kinds}
    text = functools.partial(function.traced.vector_text, **given)
    n_results = None if mode.one_number else function.traced.n_stored
    series = functools.partial(function.traced.lane_series, kinds=kinds, width=width)
    n_all = sum(map(n_words, kinds))
    derive = functools.partial(_jacobian, function, given)
    raises = function.traced.trace.raising is not function.traced.trace.graph.false
    return VectorForm(
        f"{function.key} {kinds}",
        parameters,
        n_all,
        text,
        n_results,
        series,
        derive,
        functools.partial(_phases, function, given),
        raises,
    )


def _phases(function, given):
    """The `derivatives.phases.Phases` of a function, and their text on vectors by symbol."""
    found = phases(function)
    of = found.function
    return found, of and functools.partial(of.traced.vector_text, **given)


def _jacobian(function, given, time):
    """The `derivatives.jacobian.Jacobian` of a function, and its text on vectors by symbol."""
    try:
        found: Any = jacobian(function, time)
    except Untraceable as reason:
        raise Uncompilable(str(reason)) from None
    return found, functools.partial(found.function.traced.vector_text, **given)
