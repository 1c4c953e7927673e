"""Scripts with odeint, as people write them, run by one changed import."""

import numpy as np
import pytest

HEAD = "import numpy as np\nfrom math import *\nfrom scipy.integrate import odeint\n"
SCRIPTS = {
    "logistic": """
r, K = 0.5, 10.0
def dN_dt(N, t):
    return r * N * (1 - N / K)
sol = odeint(dN_dt, 0.5, np.linspace(0, 30, 100))
""",
    "predator and prey": """
def model(X, t, a, b, c, d):
    x, y = X
    return np.array([a * x - b * x * y, -c * y + d * b * x * y])
sol = odeint(model, [10, 5], np.linspace(0, 15, 1000), args=(1.0, 0.1, 1.5, 0.75))
""",
    "epidemic": """
def deriv(y, t, N, beta, gamma):
    S, I, R = y
    dSdt = -beta * S * I / N
    dIdt = beta * S * I / N - gamma * I
    dRdt = gamma * I
    return dSdt, dIdt, dRdt
sol = odeint(deriv, (999, 1, 0), np.linspace(0, 160, 160), args=(1000, 0.2, 1.0 / 10))
""",
    "double pendulum": """
g, L1, L2, m1, m2 = 9.81, 1.0, 1.0, 1.0, 1.0
def derivs(state, t):
    dydx = np.zeros_like(state)
    dydx[0] = state[1]
    delta = state[2] - state[0]
    den1 = (m1 + m2) * L1 - m2 * L1 * cos(delta) * cos(delta)
    dydx[1] = (m2 * L1 * state[1] ** 2 * sin(delta) * cos(delta) + m2 * g * sin(state[2])
               * cos(delta) + m2 * L2 * state[3] ** 2 * sin(delta) - (m1 + m2) * g
               * sin(state[0])) / den1
    dydx[2] = state[3]
    den2 = (L2 / L1) * den1
    dydx[3] = (-m2 * L2 * state[3] ** 2 * sin(delta) * cos(delta) + (m1 + m2) * g
               * sin(state[0]) * cos(delta) - (m1 + m2) * L1 * state[1] ** 2 * sin(delta)
               - (m1 + m2) * g * sin(state[2])) / den2
    return dydx
sol = odeint(derivs, np.radians([60.0, 0.0, 20.0, 0.0]), np.arange(0, 3, 0.05))
""",
    "membrane": """
def hh(y, t, I):
    V, m, h, n = y
    am = 0.1 * (V + 40) / (1 - np.exp(-(V + 40) / 10))
    ah, bh = 0.07 * np.exp(-(V + 65) / 20), 1 / (1 + np.exp(-(V + 35) / 10))
    an, bn = 0.01 * (V + 55) / (1 - np.exp(-(V + 55) / 10)), 0.125 * np.exp(-(V + 65) / 80)
    bm = 4 * np.exp(-(V + 65) / 18)
    dV = I - 120 * m**3 * h * (V - 50) - 36 * n**4 * (V + 77) - 0.3 * (V + 54.4)
    return [dV, am * (1 - m) - bm * m, ah * (1 - h) - bh * h, an * (1 - n) - bn * n]
sol = odeint(hh, [-65, 0.05, 0.6, 0.32], np.arange(0, 20, 0.1), (10.0,))
""",
    "reaction": """
def rxn(C, t):
    k1, k2, k3 = 0.04, 3e7, 1e4
    r1, r2, r3 = k1 * C[0], k2 * C[1] ** 2, k3 * C[1] * C[2]
    return [-r1 + r3, r1 - r2 - r3, r2]
sol = odeint(rxn, [1, 0, 0], np.linspace(0, 40, 41))
""",
    "controller in a loop": """
def tank(h, t, u):
    return (u - 0.5 * np.sqrt(h)) / 2.0
h, ts, sol, e_sum = 1.0, np.linspace(0, 20, 101), [1.0], 0.0
for i in range(100):
    e = 2.0 - h
    e_sum += e * 0.2
    u = max(0.0, 0.8 * e + 0.3 * e_sum)
    h = odeint(tank, h, [ts[i], ts[i + 1]], args=(u,))[-1][0]
    sol.append(h)
sol = np.array(sol)[:, None]
""",
    "heat": """
N = 30
dx = 1.0 / (N - 1)
def heat(T, t):
    dT = np.zeros(N)
    dT[1:-1] = (T[2:] - 2 * T[1:-1] + T[:-2]) / dx**2
    return dT
sol = odeint(heat, np.r_[1.0, np.zeros(N - 1)], np.linspace(0, 0.2, 20), ml=1, mu=1)
""",
    "a class": """
class Rocket:
    g = 9.81
    def __init__(self, thrust):
        self.thrust = thrust
    def rhs(self, t, y):
        h, v, m = y
        burn = 0.5 if m > 1 else 0.0
        return [v, self.thrust * burn / m - self.g, -burn]
sol = odeint(Rocket(60.0).rhs, [0.0, 0.0, 3.0], np.linspace(0, 3, 40), tfirst=True)
""",
    "orbit backwards": """
def orbit(y, t, mu=1.0):
    r3 = (y[0] ** 2 + y[1] ** 2) ** 1.5
    return [y[2], y[3], -mu * y[0] / r3, -mu * y[1] / r3]
sol, info = odeint(orbit, [1, 0, 0, 1.1], np.linspace(0, -10, 50), full_output=True, rtol=1e-10)
""",
}


@pytest.mark.parametrize("name", SCRIPTS)
def test_a_script_has_scipys_solution(name):
    """Each of the two solutions keeps the tolerance in each step: they differ by few tolerances."""
    found = []
    for module in ("scipy.integrate", "fastdyn"):
        names = {"__name__": f"script_{module}"}
        exec((HEAD + SCRIPTS[name]).replace("scipy.integrate", module), names)
        found.append(names["sol"])
    theirs, ours = found
    assert theirs.shape == ours.shape
    tolerance = 1.49012e-8
    size = np.abs(theirs).max(axis=0)
    assert (abs(theirs - ours) <= 10 * tolerance * (1 + size)).all()
