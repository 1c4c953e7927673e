"""solve_ivp: integrate one initial value problem."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fastdyn.compile.python_callback import OtherShape
from fastdyn.problem import validate
from fastdyn.problem.arguments import EXCHANGED, checked, is_exchanged
from fastdyn.problem.discrete import longer as with_discrete_states
from fastdyn.problem.options.docstrings import documented, filled
from fastdyn.run.result import FIELDS
from fastdyn.words.calls import shown_when_wrong

from . import automatic, repeated
from .discrete import parted

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import (
        Args,
        Function,
        Functions,
        Method,
        State,
        Times,
        TimeSpan,
    )
    from fastdyn.run.result import OdeResult


@shown_when_wrong()
@filled(fields=FIELDS)
@documented
def solve_ivp(
    fun: Function,
    t_span: TimeSpan,
    y0: State,
    method: Method = "RK45",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    vectorized: bool = False,
    args: Args | None = None,
    **options: Any,
) -> OdeResult:
    """Solve y' = fun(t, y) from y(t0) = y0, with compiled code.

    Steps, results and messages of "RK23", "RK45", "DOP853", "Radau", "BDF" and "LSODA" are those
    of `scipy.integrate.solve_ivp`, as far as rounding allows.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, *args)`` returns the derivative, n numbers; `t` is a float, `y` an ndarray of
        shape (n,).  Any Python callable; a function that does not compile runs in Python, with one
        CompileWarning.
    t_span : pair of float
        Start and end; the end may lie before the start.
    y0 : array_like, shape (n,)
        Initial state.  A complex state takes "Taylor", a pair (not MATLAB's), "RK4", "Radau" or
        "BDF"; other methods raise ValueError.
    method : str or OdeSolver
        ====================================  ==================================================
        "auto"                                "Taylor", "Tsit5", "Vern7", "Vern9" or "Radau"
        "RK45"                                Dormand-Prince 5(4), adaptive; the default
        "RK23", "DOP853"                      Bogacki-Shampine 3(2), Dormand-Prince 8(5,3)
        "Tsit5", "Vern7", "Vern9"             pairs of Tsitouras (5) and Verner (7 and 9)
        "Taylor"                              series of the solution, order 13, 17 or 25
        "ode45", "ode23"                      RK45 and RK23 under MATLAB's step control
        "RK4"                                 classical, constant steps
        "VelocityVerlet", "BlanesMoanPRK4",   explicit symplectic, constant steps,
        "KahanLi8", "SofroniouSpaletta10",    y = [q, v] with q'' = a(t, q)
        "Yoshida4", "Yoshida6", "Yoshida8",
        "McLachlanAtela4", "BlanesMoan4",
        "BlanesMoan6"
        "Gauss4", "Gauss8", "Gauss16"         implicit, symplectic, constant steps
        "GaussNystrom8", "GaussNystrom16"     as Gauss8 and Gauss16, for q'' = a(t, q)
        "EnergyConserving2",                  implicit, keep the energy (average vector
        "EnergyConserving4"                   field), constant steps
        "Radau", "BDF"                        implicit, adaptive, for stiff problems
        "Rodas5P"                             linearly implicit, adaptive, for stiff problems
        "LSODA"                               Adams' formulas and BDF in turn, adaptive
        OdeSolver                             a class of SciPy's, on the compiled derivative
        ====================================  ==================================================
    t_eval : array_like, optional
        Times of output, within `t_span`, in the direction of `t_span`; by default the steps.
    dense_output : bool
        Return the interpolant `sol`.
    events : callable or Schedule or sequence of these, optional
        ``event(t, y, *args)``, whose zeros are located.  Attributes `terminal` (bool, or the number
        of occurrences that end the run), `direction` (sign of the crossings that count) and `wait`
        (time after an occurrence in which no other one counts).
    vectorized : bool
        `fun` takes y of shape (n, k).
    args : tuple, optional
        Further arguments of `fun`, events and `project`.  Changing their values does not trigger
        recompilation.
    **options
        The options of the table in `problem/options/table.py`: ``help(solve_ivp)`` has them here.

    Returns
    -------
    OdeResult
        With the fields {fields}, and those of "auto", `sensitivity`, `error_estimate` and
        `discrete`: see `OdeResult`.

    Raises
    ------
    ValueError, TypeError
        For wrong arguments, and for a derivative of the wrong length or type.

    Notes
    -----
    Outside values of `fun` (arguments, closure variables, globals, attributes of `self`) are read
    anew at each call.

    "Taylor" needs a function that can be traced, and raises ValueError for operations without a
    series: tables, splines, rounding, remainders.  Steps end at kinks and jumps.  A step may pass a
    pulse by a high power, cos(t)**400, undetected: give `breakpoints` or `max_step`.

    Sensitivities solve S' = df/dy S + df/dp, with exact derivatives of a traced `fun`, in one
    system with y: n (1 + m) numbers for m directions.  The steps keep y, and the mean of the
    columns of S, in tolerance; `atol` of a column is that of y per unit of its direction (per its
    value, if above 1).  At events, S is the derivative at a fixed time; `event_sensitivity` has the
    derivatives of the times of events, and of the states there.  Events that act change S, too.  If
    `fun` jumps as the state passes a limit, S would jump, which is not computed: ValueError.

    Examples
    --------
    >>> def pendulum(t, y, g, l):
    ...     return [y[1], -g / l * math.sin(y[0])]
    >>> result = solve_ivp(pendulum, (0, 10), [0.5, 0.0], args=(9.81, 1.0), rtol=1e-8, atol=1e-8)
    """
    result = repeated.solved(
        fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options
    )
    if result is not None:
        return result
    asked = checked(
        fun, t_span, y0, method, t_eval, dense_output, events, vectorized, args, options
    )
    validate.function(fun)
    if asked.discrete is None:
        try:
            return automatic.solved(asked)
        except OtherShape as error:
            if is_exchanged(asked.y0):
                error.add_note(EXCHANGED)
            raise
    longer, n = with_discrete_states(asked)
    return parted(automatic.solved(longer), n)
