"""Problems whose end depends on parameters: a number of the end state, and its derivatives."""

from typing import Any, NamedTuple

import numpy as np

import fastdyn

EXACT = 1e-14  # the tolerances of the true derivatives


class Gradient(NamedTuple):
    """y' = terms(t, y, p) from 0 to `end`; the number is weights @ y(end).

    ``terms`` is in arithmetic, for formulas; ``arrays(xp)(t, y, p)``, where there is one, is the
    same in whole arrays of `xp`.
    """

    name: str
    terms: Any
    y0: Any
    p: Any
    end: float
    arrays: Any = None

    @property
    def weights(self):
        return np.cos(np.arange(len(self.y0)))

    @property
    def true(self):
        """The derivatives by p: forward, by Taylor's series."""
        end = fastdyn.solve_ivp(
            self.terms, (0.0, self.end), self.y0, "Taylor", t_eval=[self.end], args=(self.p,),
            rtol=EXACT, atol=EXACT, sensitivity="p",
        )  # fmt: skip
        return self.weights @ end.sensitivity["p"][..., -1]


def lorenz(t, y, p):
    return [p[0] * (y[1] - y[0]), y[0] * (p[1] - y[2]) - y[1], y[0] * y[1] - p[2] * y[2]]


def lotka_volterra(t, y, p):
    return [p[0] * y[0] - p[1] * y[0] * y[1], -p[2] * y[1] + p[3] * y[0] * y[1]]


MASSES = 29


def chain(t, y, p):
    """Masses on a line between two walls; each of the 30 springs has its own stiffness."""
    x = [0.0, *(y[i] for i in range(MASSES)), 0.0]
    stretch = [x[i + 1] - x[i] for i in range(MASSES + 1)]
    force = [p[i] * (each + 0.1 * each * each * each) for i, each in enumerate(stretch)]
    speeds = [y[MASSES + i] for i in range(MASSES)]
    return speeds + [force[i + 1] - force[i] for i in range(MASSES)]


def chain_of_arrays(xp):
    def rates(t, y, p):
        x, v = y[:MASSES], y[MASSES:]
        stretch = xp.concatenate((x[:1], x[1:] - x[:-1], -x[-1:]))
        force = p * (stretch + 0.1 * stretch**3)
        return xp.concatenate((v, force[1:] - force[:-1]))

    return rates


def plucked():
    return np.concatenate((np.sin(np.arange(1, MASSES + 1)), np.zeros(MASSES)))


GRADIENTS = [
    Gradient("Lorenz, 3 parameters", lorenz, [1.0, 1.0, 1.0], np.array([10.0, 28.0, 8 / 3]), 2.0),
    Gradient(
        "Lotka-Volterra, 4 parameters", lotka_volterra, [1.0, 1.0],
        np.array([1.5, 1.0, 3.0, 1.0]), 10.0,
    ),
    Gradient(
        "chain, 30 parameters", chain, plucked(), np.linspace(0.5, 2.0, MASSES + 1), 10.0,
        chain_of_arrays,
    ),
]  # fmt: skip
