"""Claims about consistent starts of `solve_dae`, and about the index."""

import math

import numpy as np
import pytest

from bench.problems.daes import AKZO_NOBEL, TRANSISTOR
from fastdyn import solve_dae

NOWHERE = (0.0, 0.0)  # a span that has only its start


def start(F, y0, yp0=None, **options):
    run = solve_dae(F, NOWHERE, y0, yp0, **options)
    return run.y[:, 0], run.yp[:, 0]


def circle(t, y, yp):
    """A point that moves along a circle, whose second coordinate is algebraic."""
    return [yp[0] - y[1], y[0] ** 2 + y[1] ** 2 - 1]


@pytest.mark.parametrize("guess, found", [(0.1, 0.8), (5.0, 0.8), (-3.0, -0.8)])
def test_differential_components_are_held(guess, found):
    y, yp = start(circle, [0.6, guess])
    assert np.abs(y - [0.6, found]).max() <= 1e-14 and yp[0] == pytest.approx(found, abs=1e-14)
    again, _ = start(circle, [0.6, guess], [0.0, 0.0], given="differential")
    assert np.array_equal(y, again)


def test_the_index_counts_where_the_solution_begins():
    """The circle's equation does not determine y1 at y1 = 0, and does at 0.8."""
    y, _ = start(circle, [0.6, 1e-9])
    assert y[1] == pytest.approx(0.8, abs=1e-12)
    with pytest.raises(ValueError, match=r"No consistent start.*start nearer to a solution"):
        start(circle, [0.6, 0.0])
    with pytest.raises(ValueError, match="equation 1 does not determine"):
        start(circle, [1.0, 0.0], [0.0, 0.0])


def test_a_derivative_times_zero_does_not_occur():
    def F(t, y, yp, C):
        return [yp[0] + y[1], C * yp[1] + y[1] - 2 * y[0]]

    y, yp = start(F, [1.0, 7.0], args=(0.0,))
    assert y.tolist() == [1.0, 2.0] and yp == pytest.approx([-2.0, -4.0])
    y, yp = start(F, [1.0, 7.0], args=(0.5,))
    assert y.tolist() == [1.0, 7.0] and yp.tolist() == [-7.0, -10.0]


def test_states_at_which_f_raises_are_avoided():
    """Newton's first step from 9 leads to a negative number under the root."""

    def F(t, y, yp):
        return [yp[0] + y[0], math.sqrt(y[1]) - y[0]]

    y, _ = start(F, [1.0, 9.0])
    assert y[1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("n", [1, 300])
def test_algebraic_components_have_derivatives_too(n):
    """y1 = sin(t) + cos(y0) beside y0' = 2: y1' = cos(t) - 2 sin(y0)."""

    def F(t, y, yp):
        return np.concatenate((yp[:n] - 2, y[n:] - np.sin(t) - np.cos(y[:n])))

    run = solve_dae(F, (0.3, 1.0), np.repeat([0.5, 0.0], n), rtol=1e-8, atol=1e-10)
    exact = math.cos(0.3) - 2 * math.sin(0.5)
    assert np.abs(run.yp[n:, 0] - exact).max() <= 1e-5
    assert np.abs(run.y[n:, -1] - math.sin(1) - math.cos(1.9)).max() <= 1e-6


def test_all_of_the_state_is_held():
    y, yp = start(circle, [0.6, 0.8], given="y")
    assert y.tolist() == [0.6, 0.8] and yp[0] == pytest.approx(0.8, abs=1e-15)
    with pytest.raises(ValueError, match=r"given='y'.*equation 1 of `F` stays different from 0"):
        start(circle, [0.6, 0.7], given="y")


def test_the_derivative_is_held():
    y, yp = start(circle, [0.5, 0.5], [0.8, 0.0], given="yp")
    assert np.abs(y - [0.6, 0.8]).max() <= 1e-14 and yp.tolist() == [0.8, 0.0]


def test_any_choice_may_be_held():
    y, yp = start(circle, [0.5, 0.8], [0.0, 0.0], given=[False, True, False, True])
    assert np.abs(y - [0.6, 0.8]).max() <= 1e-14 and yp[0] == pytest.approx(0.8, abs=1e-14)


def test_a_given_start_is_kept_or_refused():
    y, yp = start(circle, [0.6, 0.8], [0.8, -0.6])
    assert (y.tolist(), yp.tolist()) == ([0.6, 0.8], [0.8, -0.6])
    with pytest.raises(ValueError, match=r"equation 1 of `F` is not 0.*given='differential'"):
        start(circle, [0.6, 0.9], [0.9, 0.0])
    with pytest.raises(ValueError, match="equation 0 of `F` is not 0"):
        start(circle, [0.6, 0.8], [0.0, 0.0])
    with pytest.raises(ValueError, match="equations 0, 1 of `F` are not 0"):
        start(circle, [0.6, 0.9], [0.0, 0.0])


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_f_in_python_starts_alike():
    seen = []

    def F(t, y, yp):
        seen.append(t)
        return circle(t, y, yp)

    y, yp = start(F, [0.6, 5.0])
    assert np.abs(y - [0.6, 0.8]).max() <= 1e-9 and yp[0] == pytest.approx(0.8, abs=1e-9)


def test_capacitors_between_nodes():
    """All derivatives occur, in five combinations: the shortest change of y' is taken."""
    p = TRANSISTOR
    y, yp = start(p.F, p.y0)
    assert y.tolist() == p.y0 and np.abs(p.F(0, y, yp)).max() <= 1e-12


def test_the_equilibrium_of_a_reaction():
    p = AKZO_NOBEL
    y, yp = start(p.F, [*p.y0[:5], 0.0])
    assert np.abs(y - p.y0).max() <= 1e-12 and np.abs(yp - p.yp0)[:5].max() <= 1e-12


def test_many_equations():
    n = 700

    def F(t, y, yp):
        return np.concatenate((yp[:n] - y[n:], y[n:] ** 3 + y[n:] - y[:n]))

    y, yp = start(F, np.concatenate([np.full(n, 2.0), np.zeros(n)]))
    assert np.abs(y[n:] - 1).max() <= 1e-9 and np.abs(yp[:n] - 1).max() <= 1e-9


def test_without_a_solution():
    with pytest.raises(ValueError, match=r"No consistent start.*equation 1 of `F` stays different"):
        start(lambda t, y, yp: [yp[0] - y[1], y[1] ** 2 + 1], [1.0, 1.0])


def pendulum(t, y, yp):
    x, z, u, v, tension = y
    return [yp[0] - u, yp[1] - v, yp[2] + tension * x, yp[3] + tension * z + 9.81,
            x * x + z * z - 1]  # fmt: skip


def pendulums(t, y, yp):
    m = len(y) // 5
    x, z, u, v, tension = [y[i * m : (i + 1) * m] for i in range(5)]
    xp, zp, up, vp, _ = [yp[i * m : (i + 1) * m] for i in range(5)]
    return np.concatenate(
        (xp - u, zp - v, up + tension * x, vp + tension * z + 9.81, x * x + z * z - 1)
    )


def constrained_sum(t, y, yp):
    return [yp[0] + yp[1] + y[0], y[0] + y[1] - 1]


@pytest.mark.parametrize("yp0", [None, "zero"])
@pytest.mark.parametrize(
    "F, y0, said",
    [
        (pendulum, [1.0, 0, 0, 0, 0], r"equation 4 does not determine component y\[4\]"),
        (constrained_sum, [0.0, 1.0], r"equation 1 does not determine components y\[0\], y\[1\]"),
        (pendulums, np.repeat([1.0, 0, 0, 0, 0], 110), "constraints do not determine"),
        (lambda t, y, yp: [yp[0] - y[1], y[0] - math.sin(t)], [0.0, 1.0], "equation 1 does not"),
    ],
)
def test_a_higher_index_is_refused_by_bdf(F, y0, said, yp0):
    rates = None if yp0 is None else np.zeros(len(y0))
    with pytest.raises(ValueError, match=rf"index of the equations is above 1: {said}|{said}"):
        solve_dae(F, (0, 1), y0, rates, method="BDF")


def test_a_higher_index_is_reduced_unasked():
    found = solve_dae(pendulum, (0, 1), [1.0, 0, 0, 0, 0])
    assert found.index == 3 and found.success
    assert np.hypot(found.y[0], found.y[1]) == pytest.approx(1.0, abs=1e-12)
    with pytest.raises(ValueError, match=r"would move from 1.5.* above 1: "):
        solve_dae(pendulum, (0, 1), [1.5, 0, 0, 0, 0])
    held = solve_dae(pendulum, (0, 0.1), [0.6, -0.7, 0, 0, 0], given=[0])
    assert held.y[:2, 0] == pytest.approx([0.6, -0.8], abs=1e-12)
    with pytest.raises(ValueError, match="holds derivatives"):
        solve_dae(pendulum, (0, 1), [1.0, 0, 0, 0, 0], np.zeros(5), given="yp")


def test_many_equations_of_a_higher_index_are_refused_at_once():
    with pytest.raises(ValueError, match="constraints do not determine"):
        solve_dae(pendulums, (0, 1), np.repeat([1.0, 0, 0, 0, 0], 110))


@pytest.mark.parametrize(
    "F, said",
    [
        (lambda t, y, yp: [yp[0] - y[0], yp[0] + t, y[2]], r"component y\[1\] occurs in no"),
        (lambda t, y, yp: [yp[0] - y[1] - y[2], y[0] - t, y[0] ** 2],
         r"structurally singular: equation .* nothing determines component"),
        (lambda t, y, yp: [yp[0] - y[0] + y[1], sum(y), 2 * sum(y)], "equations 1, 2"),
        (lambda t, y, yp: [y[0] - t, y[1] + y[2], y[2]], "does not depend on `yp`"),
    ],
)  # fmt: skip
def test_singular_equations_are_named(F, said):
    with pytest.raises(ValueError, match=said):
        solve_dae(F, (0, 1), [0.0, 0.0, 0.0])


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_units_do_not_change_the_index(scale):
    """Capacities in farads, times in nanoseconds."""

    def F(t, y, yp):
        return [scale * (yp[0] - yp[1]) + y[0], scale * (yp[1] - yp[0]) + 1e-3 * y[1],
                1e-6 * scale * yp[2] + y[2] - y[3], 1e3 * (y[3] - y[0])]  # fmt: skip

    with pytest.raises(ValueError, match="No consistent start"):
        start(F, [1.0, 0.0, 0.0, 1.0])
    y, _ = start(F, [1.0, -1e3, 0.0, 1.0])
    assert y[3] == 1.0


def test_a_higher_index_that_cannot_be_reduced_says_the_cause_first():
    def prints(t, y, yp):
        print(end="")
        return [yp[0] - y[1], y[0] - math.sin(t)]

    cause = r"^index reduction needs a function .* calls print .* Such equations must be "
    then = r"differentiated\. The index of the equations is above 1: equation 1"
    with pytest.raises(ValueError, match=cause + then):
        solve_dae(prints, (0, 1), [0.0, 1.0])
