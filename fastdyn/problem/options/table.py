"""The options of all solvers, one record each: a name, a default, a check, who takes the option.

From the records come warnings, refusals and proposals, the defaults, the docstrings of the public
functions, and the names in MATLAB.
"""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from fastdyn.words import kinds
from fastdyn.words.near import did_you_mean

from ..lsoda import NAME as LSODA

# Who may refuse an option beside the public functions, which have their names:
SITUATIONS = {
    "complex": "a complex state in compiled code",
    "SciPy": "a solver class of SciPy's, and problems that are left to SciPy",
    "SciPy's LSODA": "a problem that is left to SciPy's LSODA, which has not read it since 1.17",
    "discrete": "a solve with `discrete`: the longer Jacobian has another band",
    "sensitivity": "a solve with `sensitivity`",
    "adjoint": "a solve with `adjoint`",
    "again": "a solve that may begin anew with another method: its effects come twice",
    "second pass": "the pass of `error_estimate` that gives no result of its own",
    "repetition": "a run of a system repeated up to its end, for a dense output",
    "past again": "a repeated call of `solve_dde`: the delays have carried on other ends of steps",
    "residual": "`solve_dae` without another method: its own BDF",
}
RTOL, ATOL = 1e-3, 1e-6  # SciPy's and MATLAB's defaults
TIGHT = ("poincare", "periodic_orbit", "frequency_response")  # Newton's method differentiates these
RTOLS = {
    "systems": 1e-6,  # with 1e-3 the course's satellite falls onto its planet
    "energy_drift": 1e-9,  # with 1e-3 the drift is that of the tolerance
    **dict.fromkeys(TIGHT, 1e-10), "lyapunov": 1e-8, "fit": 1e-8, "phase_portrait": 1e-8,
    "basin": 1e-6,
}  # fmt: skip
ATOLS = {
    "systems": 1e-9, **dict.fromkeys(TIGHT, 1e-12), "lyapunov": 1e-10, "fit": 1e-10,
    "phase_portrait": 1e-8, "basin": 1e-8,
}  # fmt: skip
MOST_STEPS = {  # sliding along a jump would never end; nor would a trial of a fit far from the data
    **dict.fromkeys((*TIGHT, "lyapunov", "basin"), 1_000_000), "fit": 100_000,
    "phase_portrait": 20_000,
}  # fmt: skip
COMPILE = ("auto", "shared", "inlined")
ON_INTERRUPT = ("raise", "return")


def every(method):
    """For all methods."""
    return True


def adaptive(method):
    """For methods that choose their steps."""
    return method.error_order > 0


def constant(method):
    """For methods with constant steps."""
    return not method.error_order


def lsoda(method):
    """For LSODA alone."""
    return method.name == LSODA


def with_matrices(method):
    """For adaptive implicit methods whose Jacobian is fastdyn's."""
    return adaptive(method) and method.n_matrices > 0 and not lsoda(method)


def with_jacobian(method):
    """For adaptive implicit methods."""
    return with_matrices(method) or lsoda(method)


def with_mass(method):
    """For methods that solve M y' = f."""
    return method.takes_mass


def none(method):
    """For `solve_ivp` itself, which takes the option out before it makes a Problem."""
    return False


class Option(NamedTuple):
    """One option.

    Parameters
    ----------
    name : str
    type, text : str
        The entry in the docstring of `solve_ivp`; an option without one shares the entry before.
    methods : callable
        Of the Facts of a method: whether the method uses the option.
    default : object
    kind : callable, optional
        Of `kinds`, or like them: raises TypeError for a value of another kind.  The value None is
        of each kind if it is the default.
    check : callable, optional
        The value that a Problem has in its field of this name, from the value of the user; raises
        for a wrong one.  Options that are checked together have none: see `validate.problem`.
    refused : dict of str to str
        The public functions and SITUATIONS without the option, and the reason, if they tell one.
    scipys : bool
        Whether SciPy's `solve_ivp` has the option.
    matlab : str
        The name in MATLAB's odeset.
    of : dict of str to object
        Other defaults, by the name of the public function; "systems" stands for `System.solve`.
    words : str
        Names in other packages.
    in_key : bool or str
        True if repeated calls are known by the value: numbers, words, lists or arrays of these.
        "code" for functions that a solve calls, as they are or by a form of its own: calls are
        known by their code, and by a value in the place of a function.  "kinds" for values among
        which True is not 1: calls are known by their types, too.
    """

    name: str
    type: str
    text: str
    methods: Callable[[Any], bool] = every
    default: Any = None
    kind: Any = None
    check: Any = None
    refused: Mapping[str, str] = {}
    scipys: bool = False
    matlab: str = ""
    of: Mapping[str, Any] = {}
    words: str = ""
    in_key: bool | str = False


def _not(*who, **reasons):
    """`refused` of an Option."""
    return dict.fromkeys(who, "") | reasons


def _limit(value):
    if value is None:
        return math.inf
    if not value >= 1:
        raise ValueError(f"`max_steps` must be at least 1; got {value}.")
    return value


def _one_of(name, allowed):
    def check(value):
        if value not in allowed:
            said = did_you_mean(value, allowed, form='"{}"') or f"choose from {', '.join(allowed)}."
            raise ValueError(f"`{name}={value!r}` is unknown; {said}")
        return value

    return check


def _as_it_is(value):
    return value


def _callback(value):
    if value is not None and not callable(value):
        raise TypeError(f"`callback` must be a function of the solver; got {value!r}.")
    return value


OTHER_EQUATIONS = ("solve_dae", "solve_dae_ensemble", "solve_dde")
BORDER = "the solution has no derivative where it meets the border"
JACOBIANS = "Jacobians are exact where F can be traced, and by differences elsewhere"
ONE_BY_ONE = "`solve_dae`, trajectory by trajectory, has it"
BEHIND = f"a state behind a jump is computed in Python: {ONE_BY_ONE}"


def exact(number):
    """A power of ten in words, 1e-3."""
    return f"{number:.0e}".replace("e-0", "e-")


ALL_OPTIONS = (
    Option(
        "rtol", "float or array_like, shape (n,)",
        f"Relative and absolute tolerance of adaptive methods, by default {exact(RTOL)} and "
        f"{exact(ATOL)}: the estimated local error of each step is kept below ``atol + rtol |y|`` "
        "in the method's norm.  The global error may be larger.  `rtol` is raised to at least "
        '2.2e-14, or 2.2e-16 for "Taylor".',
        adaptive, default=RTOL, kind=kinds.numbers, of=RTOLS, scipys=True,
        matlab="RelTol", words="tol", in_key=True,
    ),
    Option(
        "atol", "", "",
        adaptive, default=ATOL, kind=kinds.numbers, of=ATOLS, scipys=True,
        matlab="AbsTol", in_key=True,
    ),
    Option(
        "max_step", "float", "Longest step and first step of adaptive methods.",
        adaptive, kind=kinds.number, scipys=True, matlab="MaxStep", words="hmax", in_key=True,
    ),
    Option(
        "first_step", "", "",
        adaptive, kind=kinds.number, refused=_not("second pass"), scipys=True, matlab="InitialStep",
        words="h0", in_key=True,
    ),
    Option(
        "jac", 'callable or array_like or sparse matrix, shape (n, n), or "2-point"',
        "The Jacobian of `fun`, for implicit methods: ``jac(t, y, *args)``, or a matrix.  By "
        "default the Jacobian is exact for a traced `fun`; for another `fun` it is by differences, "
        'as with "2-point".  Functions that return sparse matrices run in Python.',
        with_jacobian, kind=kinds.jacobian, scipys=True, matlab="Jacobian", words="dfun",
        refused=_not(
            "solve_dde", solve_dae=JACOBIANS, solve_dae_ensemble=JACOBIANS,
            adjoint="the sweep takes the exact Jacobian, which is that of the solve without `jac`",
        ),
        in_key="code",
    ),
    Option(
        "jac_sparsity", "array_like or sparse matrix, shape (n, n)",
        "The places of elements of the Jacobian, for differences with fewer evaluations and for "
        "sparse elimination.  Not needed for an exact Jacobian.",
        with_matrices, kind=kinds.matrix, scipys=True,
        refused=_not(*OTHER_EQUATIONS), matlab="JPattern",
    ),
    Option(
        "lband", "int or None",
        'For "LSODA", as in SciPy: the numbers of diagonals of the Jacobian below and above the '
        "main diagonal.  A function `jac` then returns the diagonals.",
        lsoda, kind=kinds.whole, refused=_not(*OTHER_EQUATIONS, "discrete"),
        scipys=True, in_key="kinds",
    ),
    Option(
        "uband", "", "",
        lsoda, kind=kinds.whole, refused=_not(*OTHER_EQUATIONS, "discrete"),
        scipys=True, in_key="kinds",
    ),
    Option(
        "min_step", "float", 'For "LSODA", as in SciPy: the shortest step.',
        lsoda, default=0.0, kind=kinds.number,
        refused=_not(*OTHER_EQUATIONS, "SciPy's LSODA"), scipys=True,
        matlab="MinStep", in_key=True,
    ),
    Option(
        "mass", "array_like, shape (n, n), or callable",
        'For "Rodas5P", "Radau", "BDF": M of M y\' = fun(t, y), a regular ``mass(t, y, *args)``, '
        "or a constant M.  With a singular M (a DAE of index 1), `y0` satisfies the algebraic "
        "equations.",
        with_mass, kind=kinds.matrix_or_function, matlab="Mass",
        refused=_not(
            "energy_drift", *OTHER_EQUATIONS, "SciPy",
            solve_phases="it is of one solve_ivp",
            sensitivity="solve for y' in `fun` where the matrix is regular",
            adjoint="solve for y' in `fun` where the matrix is regular",
        ),
        in_key=True,
    ),
    Option(
        "step", "float",
        "Size of constant steps.  Steps are never shortened: if the span is not a whole number of "
        "steps, the last step overshoots and the end is interpolated.",
        constant, kind=kinds.number, refused=_not("residual", "solve_dae_ensemble", "solve_dde"),
        words="dt h", in_key=True,
    ),
    Option(
        "on_event", "callable or sequence of callable or None",
        "For each event None, or a function ``g(t, y, *args)`` that returns the state after the "
        "event: an impact, a separation, a switch.  `t` has the time of the event twice, with the "
        "states before and after; `y_events`, `t_eval` and `sol` have the state before.  Such an "
        "event does not end the run if `terminal` is True; if `terminal` is a number, the "
        "occurrence of this number ends the run and does not change the state.  Events that "
        "accumulate at one time end the run with status -1.",
        refused=_not(
            "past again", "energy_drift", "complex", "SciPy", "again",
            solve_phases="`after` of a phase changes the state", solve_dae_ensemble=BEHIND,
        ),
        in_key="code",
    ),
    Option(
        "at", "array_like of float, float, or sequences of these",
        "Schedules that follow the `events`, ``fastdyn.at(at)`` and ``fastdyn.every(every)``: "
        "exact times, at which a step ends and `on_event` acts as at an event.",
        refused=_not(
            "past again", "energy_drift", "SciPy", "second pass",
            solve_phases="`after` of a phase changes the state", solve_dae_ensemble=ONE_BY_ONE,
        ),
        in_key=True,
    ),
    Option(
        "every", "", "",
        refused=_not(
            "past again", "SciPy", "second pass",
            solve_phases="`after` of a phase changes the state", solve_dae_ensemble=ONE_BY_ONE,
        ),
        in_key=True,
    ),
    Option(
        "discrete", "array_like of float, shape (m,)",
        "States d that only events and schedules change: all functions are called as ``fun(t, y, "
        "d, *args)``, and the functions of `on_event` return ``(y, d)``.",
        none, refused=_not(
            "energy_drift", "solve_second_order", "solve_separable", "solve_dde",
            solve_dae_ensemble=BEHIND,
        ),
    ),
    Option(
        "breakpoints", "array_like of float",
        "Times at which `fun` has a kink or a jump: adaptive methods end a step there.",
        adaptive, kind=kinds.times,
        refused=_not("past again", "energy_drift", "SciPy", solve_dae_ensemble=BEHIND),
        in_key=True,
    ),
    Option(
        "project", "callable",
        "``project(t, y, *args)`` returns the state at the end of each step to its constraints or "
        "its energy, at the cost of one more evaluation of `fun`.  States at the times of `t_eval` "
        "are projected, too; states of `sol` are not.",
        refused=_not(
            "energy_drift", *OTHER_EQUATIONS, "complex", "SciPy", "sensitivity",
            "adjoint",
        ),
        in_key="code",
    ),
    Option(
        "domain", "",
        "``domain(t, y, *args)`` returns whether `fun` is defined; `nonnegative`, True, indices or "
        "bools, names the components that must not become negative.",
        refused=_not(
            "energy_drift", *OTHER_EQUATIONS, "complex", "SciPy",
            sensitivity=BORDER, adjoint=BORDER,
        ),
        in_key="code",
    ),
    Option(
        "nonnegative", "", "", matlab="NonNegative",
        refused=_not(
            "energy_drift", *OTHER_EQUATIONS, "complex", "SciPy",
            sensitivity=BORDER, adjoint=BORDER,
        ),
        in_key="kinds",
    ),
    Option(
        "max_steps", "int",
        "Largest number of accepted steps; then the run ends with status -1.",
        kind=kinds.whole, check=_limit, refused=_not("Stepper", "second pass", "repetition"),
        of=MOST_STEPS, in_key=True,
    ),
    Option(
        "progress", "bool", "Show a progress bar.",
        default=False, kind=kinds.flag, check=bool,
        refused=_not("Stepper", "prepare", "second pass", "repetition"),
    ),
    Option(
        "on_interrupt", '{"raise", "return"}',
        "On Ctrl-C, raise KeyboardInterrupt, or return the solution so far with status -2.",
        default="raise", check=_one_of("on_interrupt", ON_INTERRUPT),
        refused=_not(
            "Stepper", "second pass",
            solve_dde_ensemble="Ctrl-C raises KeyboardInterrupt, whose `result` has the "
            "trajectories so far",
        ),
    ),
    Option(
        "callback", "callable",
        "``callback(solver)`` is called after each accepted step, in Python; `solver` has the "
        "attributes of a `Stepper` (`t`, `y`, `t_old`, `step_size`, `nstep`, `nfev`, "
        "`interpolate`).  If the callback returns True or raises StopIteration, the status is 1.",
        check=_callback,
        refused=_not(
            "Stepper", "prepare", "solve_ensemble", "energy_drift", "sensitivity", "adjoint",
            "again", "second pass", "repetition", "solve_dde", solve_dae_ensemble=ONE_BY_ONE,
        ),
    ),
    Option(
        "checkpoint", "str or path",
        "A file, written every few seconds, whole or not at all.  After a crash or Ctrl-C, the "
        "same call continues from the file, bit for bit.  A folder that cannot be written raises "
        "OSError.",
        kind=kinds.path, check=_as_it_is,
        refused=_not(
            "Stepper", "prepare", "solve_ensemble", "SciPy", "sensitivity", "adjoint", "again",
            "second pass", "repetition", solve_dae_ensemble=ONE_BY_ONE,
            solve_dde_ensemble="a file is of one solve",
        ),
    ),
    Option(
        "sensitivity", "str or sequence of str",
        'Integrate derivatives of the solution, too, with respect to the initial state ("y0"), to '
        'arguments of `fun` by name (or "args[0]", ...), numbers or arrays of floats, or to all '
        'arguments ("args").  See Notes.',
        none,
        refused=_not(
            "Stepper", "energy_drift", "second pass", "solve_separable",
            solve_phases="it is of one solve_ivp", solve_dae_ensemble=ONE_BY_ONE,
            solve_dde_ensemble="`solve_dde`, trajectory by trajectory, has it",
        ),
    ),
    Option(
        "adjoint", "str or sequence of str",
        "Keep the steps, so that ``result.vjp(g)`` goes back over them: it returns the exact "
        "derivatives of any number that depends on the solution, from its derivatives g by `y`, "
        "with respect to the variables named as in `sensitivity`, at a cost that does not grow "
        "with their number.  For all methods but Taylor, BDF and LSODA.",
        none,
        refused=_not(
            "Stepper", "solve_ensemble", "energy_drift", "second pass",
            "solve_second_order", "solve_separable", "solve_dde",
            solve_phases="it is of one solve_ivp",
            solve_dae="`sensitivity` computes the derivatives along the solution",
            solve_dae_ensemble="`sensitivity` of `solve_dae` computes them along the solution",
        ),
    ),
    Option(
        "error_estimate", "bool",
        "Estimate the global error of `y` by a second pass, at a tolerance 100 times tighter or "
        "half the step, which takes 1.4 to 2.5 times the evaluations of the first pass.",
        none, kind=kinds.flag,
        refused=_not(
            "Stepper", "prepare", "solve_ensemble", "solve_dae", "solve_dae_ensemble",
            "second pass",
            "solve_second_order", "solve_separable", "solve_dde",
            solve_phases="it is of one solve_ivp",
        ),
    ),
    Option(
        "compile", '{"auto", "shared", "inlined"}',
        '"shared": a kernel for all functions calls `fun` by its address.  "inlined": a kernel '
        'that contains `fun` is compiled first, where the kernel is faster: for few components.  '
        '"auto": shared, then inlined, once a thread has made that kernel, after 50 ms.  The bits '
        "are equal.",
        default="auto", check=_one_of("compile", COMPILE),
        refused=_not("solve_ensemble", "residual", "solve_dae_ensemble"), in_key=True,
    ),
)  # fmt: skip
OPTIONS = {option.name: option for option in ALL_OPTIONS}
CHECKED = {o.name for o in ALL_OPTIONS if o.check is not None}  # each by itself, for all methods
UNSET = {name: OPTIONS[name].check(OPTIONS[name].default) for name in CHECKED}
TOLERANCES = {name: OPTIONS[name].default for name in ("rtol", "atol")}


def defaults_of(who):
    """The defaults of a public function that differ from those of `solve_ivp`, by option."""
    return {option.name: option.of[who] for option in ALL_OPTIONS if who in option.of}


def value_of(options, name):
    """The value of an option, or its default."""
    return options.get(name, OPTIONS[name].default)


def check_kinds(options):
    """Raise TypeError for the first value of another kind than its option has."""
    for name, value in options.items():
        option = OPTIONS.get(name)
        if option is not None and option.kind is not None:
            if value is not None or option.default is not None:
                option.kind(name, value)


def checked_by_themselves(options):
    """The fields of a Problem whose options have a `check`."""
    return {name: OPTIONS[name].check(options[name]) for name in CHECKED if name in options}


@functools.cache
def refused_by(who):
    """{name: reason} of the options that a function does not take, or a situation."""
    return {o.name: o.refused[who] for o in ALL_OPTIONS if who in o.refused}


def refused_among(options, who):
    """(name, reason) of the options that are given, neither None nor False, and not taken."""
    refused = refused_by(who)
    if refused.keys().isdisjoint(options):
        return []
    return [
        (name, reason)
        for name, reason in refused.items()
        if options.get(name) is not None and options[name] is not False
    ]


def taken_by(who):
    """The names of the options that a public function takes, in the order of the table."""
    return [o.name for o in ALL_OPTIONS if who not in o.refused]
