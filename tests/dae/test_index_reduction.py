"""Solves of equations of index above 1, against exact and published solutions."""

import functools
import math

import numpy as np
import pytest

from fastdyn import solve_dae, solve_ivp
from fastdyn.dae.reduced.trajectory import places
from fastdyn.dae.structure import formulas, reduce_index
from fastdyn.dae.structure.eliminate import pivots
from fastdyn.dae.structure.start import consistent, guess
from support.mechanisms import (
    ANDREWS_END,
    ANDREWS_START,
    CAR_AXIS_END,
    CAR_AXIS_START,
    andrews,
    car_axis,
    from_angle,
    pendulum,
    slider_crank,
)

reduced = functools.partial(solve_dae, method="DOP853")
TIGHT = {"rtol": 1e-9, "atol": 1e-9}


def swing(t, y, length, g):
    return [y[1], -g / length * np.sin(y[0])]


@pytest.mark.parametrize(
    "angle, speed, length", [(1.5, 0.0, 1.0), (0.3, 8.0, 1.0), (2.0, 1.0, 0.2)]
)
def test_pendulum_of_its_length_alone(angle, speed, length):
    start = from_angle(angle, speed, length, 9.81)
    start[4] = 0.0  # the force is computed
    found = reduced(pendulum, (0, 3), start, args=(length, 9.81), dense_output=True, **TIGHT)
    times = np.linspace(0, 3, 50)
    exact = solve_ivp(
        swing, (0, 3), [angle, speed], "Vern9", t_eval=times, args=(length, 9.81),
        rtol=1e-13, atol=1e-13,
    )  # fmt: skip
    exact = from_angle(*exact.y, length, 9.81)
    assert found.index == 3 and found.success
    assert abs(found.sol(times) - exact).max() < 1e-6 * abs(exact).max()
    x, y, u, v, _ = found.y
    assert abs(np.hypot(x, y) - length).max() < 1e-14
    assert abs(x * u + y * v).max() < 1e-13


def test_states_change_with_the_angle():
    found = reduced(pendulum, (0, 3), [1.0, 0, 0, 0, 0], args=(1.0, 9.81), **TIGHT)
    assert {states for _, states in found.states} == {(0, 2), (1, 3)}
    for (time, states), (after, _) in zip(found.states, found.states[1:], strict=False):
        inside = (found.t >= time) & (found.t < after)
        follow, state = found.y[1 - states[0], inside], found.y[states[0], inside]
        assert (abs(state) < 10.1 * abs(follow)).all()


def test_car_axis_at_its_reference_solution():
    found = reduced(car_axis, (0, 3), CAR_AXIS_START, **TIGHT)
    assert abs(found.y[:, -1] - CAR_AXIS_END).max() < 5e-7


def test_andrews_squeezer_at_its_reference_solution():
    found = reduced(andrews, (0, 0.03), ANDREWS_START, **TIGHT)
    assert abs(found.y[:14, -1] / ANDREWS_END - 1).max() < 1e-6
    assert found.y[14:16, 0] == pytest.approx([14222.4439199541, -10666.8329399656], rel=1e-12)
    assert found.y[21:23, 0] == pytest.approx([98.566870396241, -6.12268834425566], rel=1e-12)


def test_slider_crank_keeps_its_energy():
    r, length, m1, m2, m3, g = args = (1.0, 2.0, 1.0, 1.5, 0.8, 9.81)
    start = [0.5, -0.2, 3.0, 8.0, 0, 0, 0, 0]
    found = reduced(slider_crank, (0, 5), start, args=args, given=[0, 3], **TIGHT)
    a, b, x, va, vb, vx, *_ = found.y
    assert found.y[[0, 3], 0].tolist() == [0.5, 8.0]
    assert abs(r * np.sin(a) + length * np.sin(b)).max() < 1e-14
    assert abs(r * np.cos(a) + length * np.cos(b) - x).max() < 1e-14
    energy = (
        (m1 / 3 + m2) * r**2 * va**2 / 2 + m2 * length**2 / 6 * vb**2 + m3 * vx**2 / 2
        + m2 * r * length / 2 * np.cos(a - b) * va * vb
        + (m1 / 2 + m2) * g * r * np.sin(a) + m2 * g * length / 2 * np.sin(b)
    )  # fmt: skip
    assert abs(energy / energy[0] - 1).max() < 1e-7


def hessenberg(t, y, yp):
    """U. M. Ascher, L. R. Petzold, SIAM J. Numer. Anal. 28 (1991) 1097: exp(t) solves this."""
    x1, x2, z = y
    a, e = 50.0, math.exp(t)
    return [
        yp[0] - (a - 1 / (2 - t)) * x1 - (2 - t) * a * z - (3 - t) / (2 - t) * e,
        yp[1] - (1 - a) / (t - 2) * x1 + x2 - (a - 1) * z - 2 * e,
        (t + 2) * x1 + (t * t - 4) * x2 - (t * t + t - 2) * e,
    ]


@pytest.mark.parametrize("method", ["DOP853", "Taylor"])
def test_index_2_with_an_exact_solution(method):
    found = reduced(hessenberg, (0, 1), [1.0, 1.0, 0.0], method=method, **TIGHT)
    e = np.exp(found.t)
    assert found.index == 2
    assert abs(found.y - [e, e, -e / (2 - found.t)]).max() < 1e-8


@pytest.mark.parametrize("factor", [1.0, 2.0])  # y_1 = 2 y_0' is no other name of a derivative
def test_differentiator(factor):
    def chain(t, y, yp):
        return [factor * yp[0] - y[1], yp[1] - y[2], yp[2] - y[3], y[0] - np.sin(t)]

    found = reduced(chain, (0, 2), [0.0, factor, 0, 0], **TIGHT)
    s, c = np.sin(found.t), np.cos(found.t)
    assert found.index == 4 and found.states == [(0.0, ())]
    assert abs(found.y - [s, factor * c, -factor * s, -factor * c]).max() < 1e-8


def test_equations_that_are_not_linear_in_the_highest_orders():
    found = reduced(lambda t, y, yp: [yp[0] ** 2 + y[0] ** 2 - 1], (0, 1), [0.0], [1.0], **TIGHT)
    assert abs(found.y[0] - np.sin(found.t)).max() < 1e-8

    def implicit(t, y, yp):
        return [yp[0] - y[1], y[1] + y[1] ** 3 - np.cos(t) - np.cos(t) ** 3]

    found = reduced(implicit, (0, 1), [0.0, 0.5], **TIGHT)
    assert abs(found.y - [np.sin(found.t), np.cos(found.t)]).max() < 1e-8


def test_equations_without_derivatives():
    found = reduced(
        lambda t, y, yp: [y[0] + y[1] - t, y[0] * y[1] - t * t / 4 + 1],
        (0, 2),
        [1.0, -1.0],
        **TIGHT,
    )
    assert abs(found.y - [found.t / 2 + 1, found.t / 2 - 1]).max() < 1e-8


def test_arguments_events_times_and_direction_are_those_of_solve_ivp():
    def lowest(t, y, length, g):
        return y[0]

    given = {"args": (1.0, 9.81), **TIGHT}
    start = [1.0, 0, 0, 0, 0]
    found = reduced(pendulum, (0, 3), start, events=lowest, **given)
    angle = solve_ivp(
        swing, (0, 3), [np.pi / 2, 0.0], "Vern9", events=lambda t, y, length, g: y[0], **given
    )
    assert abs(found.t_events[0] - angle.t_events[0]).max() < 1e-7
    assert abs(found.y_events[0][:, 1] + 1).max() < 1e-13
    lowest.terminal = 2
    ended = reduced(pendulum, (0, 3), start, events=[lowest], **given)
    assert ended.status == 1 and ended.t[-1] == pytest.approx(found.t_events[0][1], abs=1e-8)
    times = np.linspace(0, 3, 7)
    at = reduced(pendulum, (0, 3), start, t_eval=times, **given)
    assert at.t.tolist() == times.tolist() and at.sol is None
    assert abs(at.y[:, -1] - found.y[:, -1]).max() < 1e-12
    back = reduced(pendulum, (3, 0), at.y[:, -1], **given)
    assert abs(back.y[:4, -1] - start[:4]).max() < 1e-6
    assert back.states[0][0] == 3.0


def test_residual_of_index_1_is_solved_by_bdf():
    start = np.array([0.6, -0.8, 0, 0, 0])
    reduction = reduce_index(pendulum, start, args=(1.0, 9.81))
    z = consistent(reduction.system, 0.0, guess(reduction.system, start, 0 * start))
    residual, unknowns = reduction.choice(0.0, z).residual()
    columns = reduction.system.given.columns
    places = [(order * 5 + columns[j]) for j, order in unknowns]
    p = reduction.parameters

    def F(t, y, yp):
        return residual(t, np.concatenate((y, yp)), p)

    found = solve_dae(F, (0, 0.3), z[places], given="differential", rtol=1e-7, atol=1e-9)
    exact = reduced(pendulum, (0, 0.3), start, args=(1.0, 9.81), **TIGHT)
    x, y = (places.index(k) for k in (0, 1))
    assert abs(found.y[[x, y], -1] - exact.y[:2, -1]).max() < 1e-5


def hanging(n):
    """n masses on n rods in a row."""

    def chain(t, y, yp):
        x, z, u, v, force = (y[k * n : (k + 1) * n] for k in range(5))
        found = [yp[i] - u[i] for i in range(n)] + [yp[n + i] - v[i] for i in range(n)]
        for i in range(n):
            dx, dz = (c[i] - (c[i - 1] if i else 0.0) for c in (x, z))
            more = force[i + 1] if i + 1 < n else 0.0
            right, up = (c[min(i + 1, n - 1)] - c[i] for c in (x, z))
            found += [
                yp[2 * n + i] + force[i] * dx - more * right,
                yp[3 * n + i] + force[i] * dz - more * up + 9.81,
                dx * dx + dz * dz - 1,
            ]
        return found

    return chain


def test_a_chain_of_pendulums_keeps_energy_and_lengths():
    n = 6
    found = reduced(hanging(n), (0, 1), [*range(1, n + 1), *[0.0] * (4 * n)], **TIGHT)
    x, z, u, v, _ = found.y.reshape(5, n, -1)
    assert found.index == 3 and len(found.states[0][1]) == 2 * n
    energy = (u**2 + v**2).sum(axis=0) / 2 + 9.81 * z.sum(axis=0)
    assert abs(energy).max() < 1e-5
    lengths = np.hypot(np.diff(x, axis=0, prepend=0.0), np.diff(z, axis=0, prepend=0.0))
    assert abs(lengths - 1).max() < 1e-14


def test_elimination_by_masses_changes_no_solution():
    start = np.array([*range(1, 7), *[0.0] * 24], float)
    system = reduce_index(hanging(6), start).system
    z = consistent(system, 0.0, guess(system, start, 0 * start))
    order = pivots(system, 0.0, z)
    assert len(order) == 12 and set(order) <= set(system.matrix)
    x = z[places(system)] + 0.1
    p = system.given.values
    with_pivots, whole = (formulas.motion(system, each)(0.0, x, p) for each in (order, ()))
    assert with_pivots == pytest.approx(whole, rel=1e-11, abs=1e-11)
