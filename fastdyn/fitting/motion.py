"""The motion of one record at given parameters, and its derivatives by the parameters."""

import contextlib

import numpy as np

from fastdyn.compile.python_callback import value_of
from fastdyn.delays import solve_dde
from fastdyn.kernels.methods import METHODS
from fastdyn.problem.options.names import refuse_unknown
from fastdyn.problem.options.table import OPTIONS, TOLERANCES, check_kinds, defaults_of
from fastdyn.problem.validate import method_named
from fastdyn.solve.ivp import solve_ivp
from fastdyn.words.kinds import shown

DEFAULTS = defaults_of("fit")
OF_RECORDS = "the records have it"
OF_FITS = "the fit sets it"
OWN = {  # options that are none of a fit, and why
    "args": OF_RECORDS, "t_eval": OF_RECORDS, "dense_output": OF_FITS, "sensitivity": OF_FITS,
    "adjoint": OF_FITS, "on_interrupt": OF_FITS,
    "error_estimate": "`solver_error` of the Fit tells the error of the solves",
    "checkpoint": "a fit takes many solves", "callback": "a fit takes many solves",
    "discrete": "states that only events change are not fitted; `events` may change the state, and "
    "`solve_ivp` solves with `discrete`",
}  # fmt: skip
HISTORY = "history"  # the option that makes a delay equation of a fit
CONSTANT = "constant"  # its value: `y0` of a record is the state up to the start, too
KNOWN = {*OPTIONS, "method", "events", "vectorized", HISTORY} - OWN.keys()


class Failed(Exception):
    """A motion that ends early, or whose numbers are not finite; the message says why."""


OF_FIT = (
    "records", "starts", "max_nfev", "level", "differences", "progress", "loss", "f_scale",
)  # fmt: skip


def options_of(options):
    """Options of the solves, with the defaults of a fit."""
    for name in OWN:
        if name in options:
            raise TypeError(f"`{name}` is no option here: {OWN[name]}.")
    refuse_unknown("`fit`", options, KNOWN, OF_FIT)
    check_kinds(options)
    if options.get(HISTORY, CONSTANT) != CONSTANT:
        raise ValueError(
            f'`history` of a fit must be "{CONSTANT}": `y0` of each record is the state up to its '
            f"start; got {shown(options[HISTORY])}."
        )
    given = {"method": "Vern9", **DEFAULTS, **options}
    method_named(given["method"])
    if has_constant_steps(given["method"]):
        return {name: v for name, v in given.items() if name not in TOLERANCES or name in options}
    return given


def has_constant_steps(name):
    """Whether a method, by its name, has no tolerances."""
    method = METHODS.get(name) if isinstance(name, str) else None
    return method is not None and not method.error_order


class FittedMotion:
    """Solves from the initial state of one record.

    Parameters
    ----------
    fun : callable
        Of (t, y, *leaves of the arguments).
    places : free.FreePlaces
    parameters : free.Parameters
    options : dict
        Of `solve_ivp`.
    differences : bool
        Whether derivatives are central differences.

    Attributes
    ----------
    accuracy : float
        Relative error of the derivatives.
    """

    def __init__(self, fun, places, parameters, options, differences):
        self.fun = fun
        self.places = places
        self.parameters = parameters
        self.options = options
        self.differences = differences
        self._is_late = HISTORY in options
        self._asked = places.asked()
        self._begins = "t0" in self._asked
        if self._is_late and (self._begins or any(places.apart.trees)):
            raise ValueError(
                "a fit of a delay equation takes no Free in `t0`, and none in dicts, NamedTuples "
                "and dataclasses: give numbers and arrays."
            )
        names = dict.fromkeys([*self._asked, *["y0"] * self._begins])
        self._names = tuple([name for name in names if name != "t0"])
        rtol = options.get("rtol", DEFAULTS["rtol"])
        accuracy = max(float(np.max(rtol)), np.finfo(float).eps)
        self._step = accuracy ** (1 / 3)  # balances the error of solves and of the formula
        self.accuracy = self._step**2 if differences else accuracy

    def probe(self, x):
        """Call the function in Python, so that mistakes of the user are raised as they are.

        The function of a delay equation is called by its solve.
        """
        if self._is_late:
            return
        y0, args = self.places.at(x)
        with np.errstate(all="ignore"), contextlib.suppress(ArithmeticError, ValueError):
            value_of(self.fun, args, "fun", self.places.begin(x), y0)

    def states(self, x, times):
        """y at increasing times not before t0, of shape (n, n_times); Failed if there is none."""
        return self._solved(x, times).y

    def slopes(self, x, times):
        """(y, dy / dx), of shapes (n, n_times) and (n, n_parameters, n_times), or Failed."""
        if self.differences:
            return self._by_differences(x, times)
        if not self._names:  # this record has fixed values only
            y = self.states(x, times)
            return y, np.zeros((len(y), len(x), len(times)))
        result = self._solved(x, times, sensitivity=self._names)
        slopes = np.zeros((len(result.y), len(x), len(times)))
        by_value = dict(zip(self._names, result.sensitivity.values(), strict=True))
        for name, template in self._asked.items():
            found = self._by_start(x, by_value["y0"]) if name == "t0" else by_value[name]
            template.add(found, slopes)
        if not np.isfinite(slopes).all():
            raise Failed("its derivatives by the parameters are not finite")
        return result.y, slopes

    def _by_start(self, x, by_y0):
        """The derivatives by the starting time: those by y0 times -y'(t0)."""
        y0, args = self.places.at(x)
        slope = np.asarray(value_of(self.fun, args, "fun", self.places.begin(x), y0), float)
        return -np.einsum("ijt,j->it", by_y0, slope)[:, None]

    def _solved(self, x, times, **more):
        y0, args = self.places.at(x)
        t0 = self.places.begin(x)
        if t0 >= times[-1]:
            raise Failed(f"t0 = {t0:g} is not before the last time, {times[-1]:g}")
        try:
            result = self._solve((t0, times[-1]), y0, times, args, **more)
        except (ArithmeticError, ValueError) as error:  # outside of the domain of the function
            raise Failed(f"{type(error).__name__}: {error}") from error
        if len(result.t) < len(times):
            raise Failed(result.message)
        if not np.isfinite(result.y).all():
            raise Failed("its state is not finite")
        return result

    def _solve(self, span, y0, times, args, sensitivity=None):
        """The OdeResult of `solve_ivp` or `solve_dde`."""
        options = dict(self.options)
        if not self._is_late:
            named = {} if sensitivity is None else {"sensitivity": sensitivity}
            return solve_ivp(self.fun, span, y0, t_eval=times, args=args, **options, **named)
        del options[HISTORY]
        if sensitivity is not None:
            options["sensitivity"] = [HISTORY if n == "y0" else n for n in sensitivity]
        return solve_dde(self.fun, span, y0, t_eval=times, args=args, **options)

    def _by_differences(self, x, times):
        y = self.states(x, times)
        p = self.parameters
        slopes = np.zeros((len(y), len(x), len(times)))
        for i in self.used():
            h = self._step * (max(abs(x[i]), abs(p.start[i])) or 1.0)
            ends = []
            states = []
            for moved in (min(x[i] + h, p.high[i]), max(x[i] - h, p.low[i])):
                ends.append(moved)
                states.append(self.states(np.r_[x[:i], moved, x[i + 1 :]], times))
            slopes[:, i] = (states[0] - states[1]) / (ends[0] - ends[1])
        return y, slopes

    def used(self):
        """The parameters of this record."""
        found = [template.index[template.free] for template in self._asked.values()]
        return np.unique(np.concatenate([np.empty(0, int), *found]))

    def tighter(self, factor, least):
        """A FittedMotion with tolerances divided by a factor; None for constant steps."""
        if has_constant_steps(self.options["method"]):
            return None
        rtol, atol = (np.asarray(self.options[name], float) / factor for name in ("rtol", "atol"))
        options = {**self.options, "rtol": np.maximum(rtol, least)[()], "atol": atol[()]}
        given = self.fun, self.places, self.parameters, options, self.differences
        return FittedMotion(*given)
