"""Compiles a function by tracing: runs it on symbols, compares the code, keeps it."""

import gc
import re
import threading
from typing import Any, NamedTuple

import numpy as np

from fastdyn import code_store
from fastdyn.trace.graph.refusal import LATEST, NotYet, Refusal, Untraceable, refused_as
from fastdyn.trace.paths.places import line_of_refusal, line_of_write
from fastdyn.trace.paths.runs import trace
from fastdyn.trace.reads.program import reader
from fastdyn.trace.reads.reads import flat
from fastdyn.trace.symbols.symbol import STATE

from .. import background, memory
from ..callables import code_of
from ..compare import Different, compare_around, seconds_of
from ..functions import Function, with_code
from ..python_callback import Held
from ..sentences import located
from . import elimination
from .code import Traced
from .known import NOTHING, TABLE, Known, TracesOfPlace

LONG = 64  # least number of components of a state that is one long array
LIFTED = ("all", "none")  # numbers that become parameters, in the order of the trials
UNDEFINED = "NameError: "  # begin of the reason if a name is not defined
MAX_KNOWN, MAX_REFUSALS = 16, 3  # most traces, most refusals of a code object


class Near(NamedTuple):
    """The region in which a function will be called, and around which its code is compared.

    `batches` tells whether the caller needs the pointer form only: then long arrays may be traced
    in batches.
    """

    t0: float
    tf: float
    y0: np.ndarray
    batches: bool = False


elimination.stand_in()
_functions = memory.Table()  # by the keys of their code
_verified = memory.Table()  # by comparison, the parameters that were 0 each time
_asks_what_lives = threading.Event()  # set once a function asked which objects are alive
NODES, COMPONENTS = 100, 1000  # numbers with the memory of a small function


def traced_function(attempt, near, makes=True):
    """(Function, (type, value) of each parameter, indices of the arguments among them), or None.

    The result is None if the function of an Attempt cannot be traced, or if its code gave wrong
    values.  Without `makes`, only code that exists is returned.
    """
    if attempt.left.wrong:
        return None
    to_make = near if makes else None
    is_long = attempt.n >= LONG and attempt.mode.long_arrays and not attempt.varying
    if near is not None and near.batches and is_long:
        found = _traced_function(attempt, to_make, True)
        if found is not None or attempt.left.wrong:
            return found
    return _traced_function(attempt, to_make)


def _traced_function(attempt, near, batches=False):
    found = attempt.known(batches)
    if found is not None:
        known, given = found
        return known.function, list(zip(known.traced.kinds, given, strict=True)), known.traced.at
    place = attempt.place(batches)
    facts = attempt.facts(batches)
    if near is None or facts.refusals >= MAX_REFUSALS:
        return None
    if facts is NOTHING:
        facts = TABLE.put(place, TracesOfPlace())
    error: Any = None
    for lifted in LIFTED:
        try:
            with background.without_collecting():
                traced, function, given, zeros = _traced(attempt, near, lifted, batches, facts)
        except NotYet:
            raise
        except Untraceable as reason:
            error = reason
            if reason.final:
                break
            continue
        except code_store.Unsealable as reason:
            error = Untraceable(str(reason))
            continue
        facts.late = None
        if traced.trace.reads.lasting:
            held = attempt.fun, attempt.args
            facts.known.insert(0, Known(traced, function, held, zeros))
            del facts.known[MAX_KNOWN:]
            TABLE.put(place, facts, len(facts.known))
        return function, list(zip(traced.kinds, given, strict=True)), traced.at
    facts.effect = facts.effect or error.effect
    facts.writes = facts.writes or error.writes
    if not str(error).startswith(UNDEFINED):  # the name may be defined later
        facts.refusals = MAX_REFUSALS if error.final else facts.refusals + 1
    if error.typed:  # numbers are not traced one by one
        TABLE.put(attempt.place(), facts)
    facts.reason = _reason(error, attempt)
    facts.of_state = facts.of_state or STATE in str(error)
    facts.whole = located(str(error), line_of_refusal(error.__context__ or error))
    if error.alive:
        _asks_what_lives.set()
    if _asks_what_lives.is_set():  # traces may keep alive the objects that a function asks for
        error.__traceback__ = error.__context__ = LATEST.refusal = None
        gc.collect()
    return None


def _reason(error, attempt):
    refusal = error.__context__
    what = str(error)
    if not error.said or not (error.final or isinstance(refusal, Refusal)):
        return None
    if not isinstance(refusal, Refusal):
        return located(
            what, line_of_write(attempt.fun, attempt.args, *attempt.mode.shapes(attempt.n))
        )
    drawn = r"it uses ((numpy\.)?random|random numbers|secrets)$"
    return located(re.sub(drawn, "it draws random numbers", what), line_of_refusal(refusal))


def made(function):
    """Whether a compiled function comes from this module."""
    return function.traced is not None and not function.mode.sensitivities


@refused_as(Refusal.untraceable)
def _traced(attempt, near, lifted, batches, facts):
    fun = attempt.fun
    args = attempt.args
    mode = attempt.mode
    n = attempt.n
    own, shape, zeros = mode.shapes(n)
    of_what = own, shape, attempt.varying
    found = trace(fun, args, *of_what, lifted, zeros, mode.complex_numbers, batches)
    traced = Traced(found, mode, n, batches)
    given = found.reads.close()
    if any(traced.at[j - 1] is None for j in attempt.varying):
        raise Untraceable("an argument that varies is no parameter of its code")
    facts.late = Function("", 0, 0, None, None, mode, traced=traced)
    key = traced.key()
    function = _functions.get(key)
    new = False
    if function is None:
        function = traced.compiled()
        new = True
    parameters = list(zip(traced.kinds, given, strict=True))
    bound = with_code(function, lambda t, y: fun(t, y, *args), Held(fun, args), parameters, mode, n)
    if new:
        function.seconds = seconds_of(bound, near.t0, near.y0)
        size = 1 + len(traced.trace.graph.nodes) // NODES + n // COMPONENTS
        _functions.put(key, function, size)
    place = _compared_place(traced, function, fun, given)
    values = _numbers(traced, given)
    unseen = _verified.get(place) if found.reads.lasting else None
    if unseen is None or values[unseen].any():
        read = reader(found.reads)
        holds = read(fun, args) is not None
        different = compare_around(bound, near, traced.trace)
        after = read(fun, args) if holds else given
        stays = after is not None and np.array_equal(_numbers(traced, after), values, True)
        if background.is_here() and not (stays and (holds or not found.reads.lasting)):
            raise NotYet("the solves in Python have changed what it uses")
        if not stays:
            raise Untraceable("it changes what it uses", effect=True)
        if different:
            wrong = isinstance(different, Different)
            if wrong:
                attempt.leave(str(different), wrong)
            raise Untraceable(str(different), final=wrong)
        now = np.flatnonzero(values == 0)
        unseen = _verified.put(place, now if unseen is None else np.intersect1d(now, unseen))
    return traced, function, given, unseen


def _numbers(traced, given):
    """The values of parameters by slot; empty for long arrays, which are too many to inspect."""
    return np.empty(0) if traced.in_batches else flat(given)


def _compared_place(traced, function, fun, given):
    """The key of a comparison: the function, the types of its numbers."""
    same = tuple(traced.trace.reads.pattern.values())
    return function.key, code_of(fun), tuple(map(type, given)), same
