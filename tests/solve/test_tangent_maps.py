"""Sensitivities by methods for q'' = a(t, q): the derivatives of the discrete flow itself."""

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from fastdyn.analysis import lyapunov
from fastdyn.kernels.methods import METHODS
from fastdyn.solve import solve_second_order

NAMES = [name for name, method in METHODS.items() if method.second_order]
H = 1e-5  # of central differences of the same steps: off by H^2, and 1e-15 / H


def henon_heiles(t, y, k, c):
    x, z, u, w = y
    return [u, w, -k * x - 2 * c[0] * x * z, -k * z - c[0] * x * x + c[1] * z * z]


def chain(t, y, k):
    n = len(y) // 2
    q = y[:n]
    stretch = np.concatenate((q[:1], q[1:] - q[:-1], -q[-1:]))
    force = k * (stretch + 0.1 * stretch**3)
    return np.concatenate((y[n:], force[1:] - force[:-1]))


def differences(solve, values):
    """d solve(values) / d values by central differences, a column for each value."""
    found = []
    for i in range(len(values)):
        ahead, back = np.array(values, float), np.array(values, float)
        ahead[i], back[i] = ahead[i] + H, back[i] - H
        found.append((solve(ahead) - solve(back)) / (2 * H))
    return np.stack(found, 1)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", NAMES)
def test_the_tangent_map_is_symplectic_and_that_of_the_steps(name):
    y0, k, c = [0.1, 0.2, 0.3, -0.1], 1.0, np.array([1.0, 0.9])
    given = {"method": name, "step": 0.05, "t_eval": [1.0, 3.0]}
    r = solve_ivp(
        henon_heiles,
        (0, 3),
        y0,
        args=(k, c),
        sensitivity=("y0", "args"),
        dense_output=True,
        **given,
    )
    plain = solve_ivp(henon_heiles, (0, 3), y0, args=(k, c), dense_output=True, **given)
    assert np.abs(r.y - plain.y).max() < 1e-14
    assert r.nfev == plain.nfev or name.startswith("Gauss")  # S converges later than the state
    assert np.allclose(r.sol(1.0), r.y[:, 0], atol=1e-6)
    unit = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
    for flow in np.moveaxis(r.sensitivity["y0"], -1, 0):
        assert np.abs(flow.T @ unit @ flow - unit).max() < 1e-12  # rounding of 60 steps

    def ends(p):
        return solve_ivp(henon_heiles, (0, 3), p[:4], args=(p[4], p[5:]), **given).y

    s = r.sensitivity
    found = np.concatenate([s["y0"], s["k"][:, None], s["c"]], axis=1)
    assert np.abs(found - differences(ends, [*y0, k, *c])).max() < 1e-8


def test_many_components_events_and_time():
    n, rng = 9, np.random.default_rng(0)
    k, y0 = rng.uniform(0.5, 2, n + 1), np.r_[rng.normal(size=n), np.zeros(n)]

    def middle(t, y, k):
        return y[4] - 0.1 * y[13] - 0.01 * t * k[0]

    given = {"method": "BlanesMoan6", "step": 0.1, "events": middle}
    r = solve_ivp(chain, (0, 6), y0, args=(k,), sensitivity="k", **given)
    assert r.sensitivity["k"].shape == (2 * n, n + 1, len(r.t))

    def ends(k):
        return solve_ivp(chain, (0, 6), y0, args=(k,), **given).y[:, -1]

    assert np.abs(r.sensitivity["k"][:, :, -1] - differences(ends, k)).max() < 1e-8
    fine = solve_ivp(
        chain, (0, 6), y0, args=(k,), sensitivity="k", method="DOP853", rtol=1e-11, atol=1e-11,
        events=middle,
    )  # fmt: skip
    ours, theirs = r.event_sensitivity[0], fine.event_sensitivity[0]
    size = np.abs(theirs.t["k"]).max()
    assert np.abs(ours.t["k"] - theirs.t["k"]).max() < 1e-3 * size  # by the interpolant's order
    size = np.abs(theirs.y["k"]).max()
    assert np.abs(ours.y["k"] - theirs.y["k"]).max() < 1e-3 * size


def test_accelerations_alone_and_prepared_solvers():
    def fall(t, q, g):
        return [-g * q[0]]

    def both(t, y, g):
        return [y[1], -g * y[0]]

    given = {"args": (2.0,), "step": 0.01, "t_eval": [1.0], "sensitivity": ("y0", "g")}
    r = solve_second_order(fall, (0, 1), [1.0], [0.5], "KahanLi8", **given)
    other = solve_ivp(both, (0, 1), [1.0, 0.5], "KahanLi8", **given)
    solver = prepare(both, (0, 1), [1.0, 0.5], "KahanLi8", compile="shared", **given)
    first = solve_ivp(both, (0, 1), [1.0, 0.5], "DOP853", rtol=1e-12, atol=1e-12, **{
        name: value for name, value in given.items() if name != "step"
    })  # fmt: skip
    for name in ("y0", "g"):
        assert np.allclose(r.sensitivity[name], first.sensitivity[name], atol=1e-10)
        assert (other.sensitivity[name] == r.sensitivity[name]).all()
        for _ in range(3):
            assert (solver().sensitivity[name] == other.sensitivity[name]).all()


@pytest.mark.filterwarnings("ignore:.*have no effect")
def test_what_is_refused():
    def both(t, y, g):
        return [y[1], -g * y[0]]

    given = {"args": (2.0,), "step": 0.01, "sensitivity": "y0"}
    with pytest.raises(
        ValueError, match="VelocityVerlet has no `sensitivity` with events that act"
    ):
        solve_ivp(
            both, (0, 1), [1.0, 0.5], "VelocityVerlet", events=lambda t, y, g: y[0],
            on_event=lambda t, y, g: -y, **given,
        )  # fmt: skip
    with pytest.raises(
        ValueError, match="VelocityVerlet has no `sensitivity` with events that act"
    ):
        solve_ivp(
            both, (0, 1), [1.0, 0.5], "VelocityVerlet", every=0.5,
            on_event=lambda t, y, g: -y, **given,
        )  # fmt: skip
    with pytest.raises(ValueError, match="`lyapunov` takes RK4 or Gauss8"):
        lyapunov(both, [1.0, 0.5], (2.0,), method="VelocityVerlet", step=0.1, t_end=9.0)
