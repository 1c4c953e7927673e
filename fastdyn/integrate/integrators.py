"""The integrators of `ode`, in the place of SciPy's objects of the same names."""

import warnings
from typing import Any

import numpy as np

from fastdyn.compile.python_callback import OtherRows
from fastdyn.compile.sentences import WritesToState
from fastdyn.run.enough_memory import KeepsBands
from fastdyn.solve.ivp import solve_ivp

from .continued import Continued
from .messages import DONE

ADAMS, BDF = 1, 2  # `meth` of SciPy's vode and zvode
# Methods that begin anew at each call, by the name of the integrator and its family.
ONE_STEP = {
    ("dopri5", None): "RK45", ("dop853", None): "DOP853", ("zvode", ADAMS): "DOP853",
    ("zvode", BDF): "Radau",
}  # fmt: skip
TAKE_ROWS = "dopri5", "dop853"
DOPRI = 1, 2, -2, -3  # return codes: success, stopped by `solout`, too many steps, too small steps
ZVODE = DONE, DONE, -1, -4


def compiled(scipys):
    """The compiled integrator with the options of an integrator of SciPy's."""
    place = type(scipys).__name__, getattr(scipys, "meth", None)
    return OneStep(scipys, ONE_STEP[place]) if place in ONE_STEP else OnWhole(scipys)


class Replaced:
    """An integrator of SciPy's, whose runs are compiled; all else is SciPy's.

    A function that writes to its state runs by SciPy's integrator, and so does one that returns its
    numbers in a column, where SciPy's takes them.
    """

    success = 1
    istate = None

    def __init__(self, scipys):
        self._scipys = scipys
        self._left_to_scipy = False
        self.name = type(scipys).__name__

    def __getattr__(self, name):
        return getattr(self._scipys, name)

    def reset(self, n, has_jac):
        """Begin anew at the next call."""
        self._scipys.reset(n, has_jac)
        self.success = 1
        self._left_to_scipy = False

    def run(self, *given):
        """``(y, t)`` at t1."""
        return self._call("run", *given)

    def step(self, *given):
        """``(y, t)`` after one step."""
        return self._call("step", *given)

    def run_relax(self, *given):
        """``(y, t)`` at the first step that reaches t1."""
        return self._call("run_relax", *given)

    def _call(self, how, *given):
        if not self._left_to_scipy:
            try:
                y, t, self.istate, because = self._solved(how, *given)
            except (KeepsBands, WritesToState):
                self._left_to_scipy = True
            except OtherRows:
                if self.name not in TAKE_ROWS:
                    raise
                self._left_to_scipy = True
            else:
                if self.istate < 0:
                    self.success = 0
                    said = self._scipys.messages.get(self.istate, f"istate={self.istate}")
                    warnings.warn(f"{self.name}: {said} {because}".rstrip(), stacklevel=4)
                return y, t
        scipys = self._scipys
        y, t = getattr(scipys, how)(*given)
        self.istate = scipys.istate
        self.success = scipys.success
        return y, t

    def _solved(self, how, f, jac, y0, t0, t1, f_params, jac_params):
        """``(y, t, istate, because)``."""
        raise NotImplementedError


class OneStep(Replaced):
    """dopri5, dop853 and zvode: each call begins anew; in SciPy, those of zvode go on."""

    def __init__(self, scipys, method):
        super().__init__(scipys)
        self._method = method
        self._codes = ZVODE if self.name == "zvode" else DOPRI

    def _solved(self, how, f, jac, y0, t0, t1, f_params, jac_params):
        s = self._scipys
        span = abs(t1 - t0)
        success, _, many_steps, too_small = self._codes
        if not span:
            return y0, t0, success, ""
        options = {"rtol": s.rtol, "atol": s.atol}
        if s.max_step:
            options["max_step"] = s.max_step
        if s.first_step:
            options["first_step"] = min(s.first_step, span)
        if getattr(s, "solout", None) is not None:
            return self._told(f, t0, y0, t1, tuple(f_params), options)
        most = 1 if how == "step" and self.name == "zvode" else s.nsteps
        found: Any = solve_ivp(
            f, (t0, t1), y0, self._method, args=tuple(f_params), max_steps=most, **options
        )
        istate = success
        because = ""
        if not found.success and not (most == 1 == found.n_accepted):
            istate = many_steps if found.n_accepted >= s.nsteps else too_small
            because = found.message
        elif not found.success and s.nsteps == 1:
            istate = many_steps
        return found.y[:, -1].copy(), float(found.t[-1]), istate, because

    def _told(self, f, t0, y0, t1, args, options):
        """A run that tells `solout` of each step."""
        from fastdyn.solve.stepper import Stepper

        s = self._scipys
        success, stopped, many_steps, too_small = self._codes
        stepper = Stepper(f, t0, y0, t1, method=self._method, args=args, **options)
        stops = s._solout(t0, y0.copy()) == -1
        while stepper.status == "running" and not stops:
            if stepper.nstep >= s.nsteps:
                return stepper.y, stepper.t, many_steps, ""
            because = stepper.step()
            if stepper.status == "failed":
                return stepper.y, stepper.t, too_small, because
            stops = s._solout(stepper.t, stepper.y.copy()) == -1
        return stepper.y, stepper.t, stopped if stops else success, ""


class OnWhole(Replaced):
    """lsoda and vode: the steps of one run go on from call to call."""

    _run: Any = None

    def reset(self, n, has_jac):
        """Begin anew at the next call."""
        super().reset(n, has_jac)
        self._run = None
        self._has_jac = has_jac

    def run(self, *given):
        """``(y, t)`` at t1; within a run that goes on, the fast way."""
        f, _, _, t0, t1, f_params, _ = given
        run = self._run
        if run is not None and run.goes_on(f, f_params, t0):
            y = run.at(t1)
            if y is not None:
                self.istate = DONE
                return y, float(t1)
        return self._call("run", *given)

    @property
    def iwork(self):
        """ODEPACK's numbers, with the counts where ODEPACK has them."""
        found = self._scipys.iwork
        if self._run is not None:
            found[10:13] = self._run.counts()
        return found

    def _solved(self, how, f, jac, y0, t0, t1, f_params, jac_params):
        if self._run is None or not self._run.goes_on(f, f_params, t0):
            if t0 == t1:
                return y0, t0, DONE, ""
            self._run = self._begun(f, jac, y0, t0, t1, f_params, jac_params)
        return self._run.advance(how, t1)

    def _begun(self, f, jac, y0, t0, t1, f_params, jac_params):
        s = self._scipys
        band = None
        if s.ml is not None or s.mu is not None:
            band = s.ml or 0, s.mu or 0
        if not self._has_jac:
            jac = None
        elif jac_params != f_params:
            jac = _of_own(jac, tuple(jac_params))
        limits = s.first_step, s.max_step, s.min_step
        return Continued(
            (f, jac), (t0, t1), np.array(y0), f_params, (s.rtol, s.atol), limits, self._orders(),
            band, s.nsteps,
        )  # fmt: skip

    def _orders(self):
        """The highest orders of Adams' formulas and of BDF; 0: the family is not taken."""
        s = self._scipys
        if self.name == "lsoda":
            return min(s.max_order_ns, 12), min(s.max_order_s, 5)
        return (min(s.order, 12), 0) if s.meth == ADAMS else (0, min(s.order, 5))


def _of_own(jac, params):
    """A Jacobian with other parameters than the function."""
    return lambda t, y, *args: jac(t, y, *params)
