"""Kernels of a method and a right-hand side in two tiers, whose results are bitwise equal.

- shared: one stepping kernel for each method, on rows of the work array, calls any function by its
  address.  The kernel is compiled once and kept on disk.
- inlined: the kernel contains the function, and the state is a tuple in registers, for n up to
  MAX_TUPLE.  The kernel is up to twice as fast for few components, and compiles for half a second
  or more; for more components, the shared kernel of a pair is faster, as its loops are vectors.

Kernels are found on disk by their keys.  The compiler is imported only if a kernel is missing.
"""

import functools
import itertools
from typing import Any, NamedTuple

from fastdyn import code_store
from fastdyn.code_store import target
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import made
from fastdyn.kernels.methods import BY_NAME
from fastdyn.kernels.methods.taylor.accuracy import ALLOWANCE
from fastdyn.trace.graph.clock import look
from fastdyn.trace.operations.delays import PAST
from fastdyn.trace.operations.linear import FACTORS, SOLUTION

from .for_all import FOR_ALL, PLAIN_START, modules_of

MAX_TUPLE = 16
# A state of more components than this, with its stages, leaves the registers: for pairs of up to
# FEW_STAGES stages, and of more.  Time of shared over inlined kernels, RK45 and DOP853 on chains
# and Lorenz-96: with 16 registers (AMD, AVX2) 1.06 / 0.9 at n = 8, 0.7 / 0.6 at 12; with 32 (Intel,
# AVX-512) 1.15 / 1.0 at 8, 0.95 / 0.75 at 12, 0.8 / 0.73 at 16.
FEW_STAGES = 7
MOST_INLINED = {16: (8, 7), 32: (10, 7)}
LARGE = 400  # operations of a function whose time is that of the solve, in either kernel
FUNCTION = "fastdyn_function"  # equal to `unlinked.FUNCTION`, whose file imports LLVM


def splits(name, pair):
    """True if a method calls the two functions of a pair separately."""
    return pair and BY_NAME[name].separable


def inlines(name, n, function):
    """True if a kernel that contains a function of n components is faster than the shared kernel.

    Methods that factorise matrices gain nothing from inlining.
    """
    method = BY_NAME[name]
    if not 0 < n <= MAX_TUPLE or method.n_matrices > 0:
        return False
    few = MOST_INLINED.get(target.vector_registers(), (MAX_TUPLE,) * 2)
    if not method.is_pair or n <= few[method.n_stages > FEW_STAGES]:
        return True
    return made(function) and not function.in_batches and function.traced.n_operations > LARGE


class Recipe(NamedTuple):
    """How a kernel that inlines no function of the user is made.

    ``make(dispatchers)`` returns the dispatcher and its signature, out of what `modules` of fastdyn
    and their imports define.
    """

    key: str
    modules: tuple
    make: Any

    @property
    def made_by(self):
        """The sources that the code depends on."""
        return code_store.KERNELS.around(*self.modules)

    def kept(self):
        """The code, from disk or compiled."""
        return _kept(self.key, self.make, self.made_by)


def module_of(method):
    """The module of the file of a method."""
    return f"kernels.methods.{method.file}"


def _kept(key, make, made_by):
    """The code of a kernel; ``make(dispatchers)`` returns the dispatcher to compile."""

    def build():
        from . import dispatchers

        return make(dispatchers)

    return code_store.compiled(key, build, made_by)


def _placed(method, place):
    """The module of a function of a method, and the name of the function in keys."""
    module, _, function = place.rpartition(".")
    if module:
        return f"kernels.{module}", place
    return module_of(method), f"{method.file}.{function}"  # made with numbers of the method


def _start(name, pair=False):
    method, apart = BY_NAME[name], splits(name, pair)
    module, function = _placed(method, PLAIN_START if apart else method.start)
    return Recipe(f"start {function}", (module,), lambda made: made.start(method, apart))


def _dense_rows(name, pair=False):
    method, apart = BY_NAME[name], splits(name, pair)
    module, function = _placed(method, f"{name} of pair" if apart else method.dense_rows)
    return Recipe(f"dense rows {function}", (module,), lambda made: made.dense_rows(method, apart))


def _shared(name, pair=False):
    method, apart = BY_NAME[BY_NAME[name].loop or name], splits(name, pair)
    key = f"{'split' if apart else 'advance'} {method.name}"
    return Recipe(key, (module_of(method),), lambda made: made.shared(method, apart))


def _series(loop, order, width):
    make, file = ("series_in_lanes", "lanes") if loop == "lanes" else ("series", "steps")
    modules = (f"kernels.methods.taylor.{file}",)
    key = f"{make} {order} {width}"
    return Recipe(key, modules, lambda made: getattr(made, make)(order, width))


def _for_all(name):
    return Recipe(name, modules_of(name), lambda made: made.for_all(name))


@code_store.first_kept
def start_kernel(name, pair=False):
    """``start(state, work, block, order, fsal_stage)`` of a method."""
    return _start(name, pair).kept()


@code_store.first_kept
def dense_rows_kernel(name, pair=False):
    """``dense_rows(t, h, work, block, d)``, the interpolant of a method."""
    return _dense_rows(name, pair).kept()


@code_store.first_kept
def shared_kernel(name, pair=False):
    """The stepping kernel for all functions, or for all pairs."""
    return _shared(name, pair).kept()


@code_store.first_kept
def series_loop(loop, order, width):
    """The loop of Taylor for all series of an order, in vectors of `width` lanes.

    With "lanes", each lane has a trajectory; with "series", all have one.
    """
    return _series(loop, order, width).kept()


SERIES = (
    *itertools.product(("series",), ALLOWANCE, (4,)),
    *itertools.product(("lanes",), ALLOWANCE, (4, 8)),
)
for _given in SERIES:  # the code of a series calls its loop
    _symbol = "fastdyn_{}_{}_{}".format(*_given)
    code_store.OFFERED[_symbol] = functools.partial(series_loop, *_given)


def kernel_for_all(name):
    """A function that returns the code of a kernel for all methods and functions."""
    return code_store.first_kept(lambda: _for_all(name).kept())


@code_store.first_kept
def function_of_pencil(name):
    """A function of `kernels/algebra/consistent_states.py`, with the form of a user's function."""
    return _for_all(f"pencil {name}").kept()


_serving: dict = {}


def serve_kernel(*sample):
    """The kernel in which a worker of an ensemble serves its lanes, for arguments like `sample`."""
    if not _serving:
        modules = "kernels.ensemble.scheduler", "kernels.ensemble.arguments"
        recipe = Recipe("serve", modules, lambda made: made.serve(*sample))
        _serving.setdefault("serve", recipe.kept())
    return _serving["serve"]


code_store.OFFERED[FACTORS] = kernel_for_all("factors")
code_store.OFFERED[SOLUTION] = kernel_for_all("solution")
past_kernel = kernel_for_all("past")
code_store.OFFERED[PAST] = past_kernel
within_past_kernel = kernel_for_all("within past")
residual_filters = {each: kernel_for_all(f"filter of {each}") for each in ("Rodas5P", "Radau")}
both_of_pair = kernel_for_all("both of a pair")
decide_kernel = kernel_for_all("decide")
sparse_kernels = {  # by the kind of the numbers
    kind: [kernel_for_all(f"{word}sparse {what}") for what in ("factors", "solution")]
    for kind, word in (("f", ""), ("c", "complex "))
}
evaluate_kernel = kernel_for_all("evaluate")
newton_kernel = kernel_for_all("newton")
residuals_kernel = kernel_for_all("residuals")
watch_kernel = kernel_for_all("watch")
watch_events_kernel = kernel_for_all("watch events")
watch_plain_kernel = kernel_for_all("watch plain")
launch_kernel = kernel_for_all("launch")
interpolant_kernel = kernel_for_all("interpolant")
whole_solve_kernel = kernel_for_all("whole solve")
events_kernel = kernel_for_all("events")
all_roots_kernel = kernel_for_all("all roots")
roots_inside_kernel = kernel_for_all("roots inside")
open_survey_kernel = kernel_for_all("open survey")
survey_kernel = kernel_for_all("survey")
already_kernel = kernel_for_all("already")
wisdom_holman_kernel = kernel_for_all("wisdom holman")
wisdom_holman_by_words_kernel = kernel_for_all("wisdom holman by words")
sweep_kernel = kernel_for_all("sweep")
replay_kernel = kernel_for_all("replay")
steps_kernel = kernel_for_all("steps")
sweep_whole_kernel = kernel_for_all("sweep whole")
sweep_of_kicks_kernel = kernel_for_all("sweep of kicks")
replay_of_kicks_kernel = kernel_for_all("replay of kicks")
sweep_of_rosenbrock_kernel = kernel_for_all("sweep of rosenbrock")
replay_of_rosenbrock_kernel = kernel_for_all("replay of rosenbrock")
sweep_of_collocation_kernel = kernel_for_all("sweep of collocation")
replay_of_collocation_kernel = kernel_for_all("replay of collocation")


def every_kernel():
    """The Recipes of all kernels that inline no function of the user, by their keys."""
    found = [_for_all(name) for name in FOR_ALL]
    for name in BY_NAME:
        found += _kernels_of(name)
    return {recipe.key: recipe for recipe in found}


def _kernels_of(name):
    """The Recipes of the kernels of a method that inline no function."""
    if BY_NAME[name].series:
        found = [_series(*given) for given in SERIES]
    else:
        found = [_shared(name), _shared(name, True)]
    return found + [make(name, pair) for make in (_start, _dense_rows) for pair in (False, True)]


def make_kernels(name=None):
    """Load or compile the kernels of a method; without name, those that serve all methods."""
    for recipe in map(_for_all, FOR_ALL) if name is None else _kernels_of(name):
        recipe.kept()


def inlined_kernel(name, function, n, build=True) -> Any:
    """The stepping kernel with `function` inlined, on tuples of n numbers; None if not available.

    With ``build=False`` the kernel is taken from memory or disk, and is never compiled.
    """
    place = "inlined", name, n
    found = function.notes.get(place)
    if found is None or (build and not found):
        key = f"specialised {name} {n} {function.key}"
        found = code_store.stored(key, _function_in(name)) or (
            build and _inlining(key, name, function, n)
        )
        function.notes[place] = found or False
    return found or None


def _function_in(name):
    """The sources that the code of a method with a function of the user inside depends on."""
    return code_store.FUNCTIONS.around(module_of(BY_NAME[name]))


def _inlining(key, name, function, n):
    """The code of an inlined kernel: linked by LLVM if possible, else compiled by Numba."""
    if links(name, function):
        kernel = kernel_without_function(name, n, True)
        texts = {FUNCTION: function.traced.text}
        return code_store.linked(key, kernel, texts, look, _function_in(name))
    if in_stages(name, function):
        try:
            return _stages(key, name, function, n // 2 if BY_NAME[name].second_order else n)
        except Uncompilable:  # without a form on vectors: the loop over stages, with equal results
            pass
    try:
        return _kept(
            key, lambda made: made.inlining(name, splits(name, True), function, n),
            _function_in(name),
        )  # fmt: skip
    except Uncompilable:  # another thread has changed an outside value
        return None


def links(name, function):
    """True if LLVM can link a kernel of a method to a function."""
    return made(function) and not function.traced.in_batches and not in_stages(name, function)


def in_stages(name, function):
    """True if a method evaluates a function for all stages at once, on vectors.

    Not if the pointer form is made of loops: their elementary functions have other bits.
    """
    in_vectors = function.traced and not function.in_batches and function.mode.in_vectors
    return BY_NAME[name].batched and in_vectors and not function.traced.in_loops


def _stages(key, name, function, n):
    """The code of a kernel of an implicit method that evaluates all stages at once."""
    width, _ = BY_NAME[name].code.batched
    text = functools.partial(function.traced.vector_text, n=n, width=width, exact=True)

    def build():
        from . import dispatchers

        return dispatchers.stages(name, n)

    made_by = code_store.KERNELS.around(module_of(BY_NAME[name]))
    kernel = code_store.without_function(f"waits {name} {n} in stages", build, made_by)
    return code_store.linked(key, kernel, {FUNCTION: text}, look, _function_in(name))


def kernel_without_function(name, n, build=False):
    """The stepping kernel of a method to which LLVM links a function of n numbers.

    With ``build=False`` the kernel is taken from disk; the result is None if it is not there.
    """

    def without_function():
        from . import dispatchers

        return dispatchers.without_function(name, n)

    build_it = without_function if build else None
    made_by = code_store.KERNELS.around(module_of(BY_NAME[name]))
    return code_store.without_function(f"waits {name} {n}", build_it, made_by)
