"""ode and complex_ode: SciPy's classes, with integrators that are compiled."""

from typing import Any

import numpy as np
import scipy.integrate

from .integrators import compiled


class _Compiled:
    """What both classes change of SciPy's: the integrator behind a name."""

    _integrator: Any
    _y: Any
    jac: Any

    def set_integrator(self, name, **integrator_params):
        """As in SciPy; the integrator that SciPy makes is replaced by a compiled one."""
        super().set_integrator(name, **integrator_params)  # pyright: ignore
        self._integrator = compiled(self._integrator)
        self._integrator.reset(len(self._y), self.jac is not None)  # pyright: ignore
        return self


class ode(_Compiled, scipy.integrate.ode):
    """Solve y' = f(t, y) on the way to one time after another, with compiled code.

    Methods, arguments, results, warnings and return codes are those of `scipy.integrate.ode`.
    "lsoda" takes SciPy's steps, and passes the times of output.  "vode" takes LSODA's formulas of
    one family, Adams' with ``method="adams"`` and BDF with ``method="bdf"``, the latter always with
    Newton's method; "dopri5" and "dop853" are the pairs of `solve_ivp` with its control of steps;
    "zvode" begins anew at each call, by "DOP853" or, with ``method="bdf"``, by "Radau".  Steps of
    these four are not SciPy's; the tolerances are.

    Parameters
    ----------
    f : callable
        ``f(t, y, *f_args)``, of any Python; compiled, if it can be.
    jac : callable, optional
        ``jac(t, y, *jac_args)``, or its diagonals, with `lband` and `uband`.

    Examples
    --------
    >>> solver = ode(lambda t, y: -y).set_integrator("lsoda")
    >>> solver = solver.set_initial_value([1.0], 0.0)
    >>> while solver.successful() and solver.t < 2:
    ...     y = solver.integrate(solver.t + 0.1)
    """


class complex_ode(_Compiled, scipy.integrate.complex_ode):  # pyright: ignore
    """`ode` for complex states by real integrators, as `scipy.integrate.complex_ode`.

    Parameters
    ----------
    f, jac : callable
        As for `ode`, with a complex y.
    """

    def __init__(self, f, jac=None):
        super().__init__(f, jac)
        self.f = of_pairs(f)
        if jac is not None:
            self.jac = jacobian_of_pairs(jac)


def of_pairs(f):
    """A function of a complex state as a function of pairs of real numbers."""

    def fun(t, y, *args):
        found: Any = np.asarray(f(t, y[::2] + 1j * y[1::2], *args))
        pairs = np.empty(len(y))
        pairs[::2] = found.real
        pairs[1::2] = found.imag
        return pairs

    return fun


def jacobian_of_pairs(jac):
    """The Jacobian of `of_pairs`, of an analytic function."""

    def real(t, y, *args):
        found: Any = np.asarray(jac(t, y[::2] + 1j * y[1::2], *args))
        pairs = np.empty((len(y), len(y)))
        pairs[::2, ::2] = pairs[1::2, 1::2] = found.real
        pairs[1::2, ::2] = found.imag
        pairs[::2, 1::2] = -found.imag
        return pairs

    return real
