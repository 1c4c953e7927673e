"""MATLAB's other solvers, what continues a solution, and what calls may look like."""

import math

import numpy as np
import pytest

from fastdyn import SingularMatrixError, matlab
from fastdyn.matlab import deval, ode15s, ode23t, ode45, ode113, odeset, odextend

SOLVERS = ("ode15s", "ode23", "ode23s", "ode23t", "ode23tb", "ode45", "ode78", "ode89", "ode113")
STIFF = ("ode15s", "ode23s", "ode23t", "ode23tb")
METHODS = {"ode15s": "BDF", "ode23s": "Rodas5P", "ode23t": "Radau", "ode78": "DOP853",
           "ode89": "Vern9", "ode113": "LSODA"}  # fmt: skip


def swing(t, y):
    return [y[1], -y[0]]


def stiff(t, y):
    return [-1000.0 * (y[0] - math.cos(t)) - math.sin(t)]


def crosses(t, y):
    return y[0], 0, 0


@pytest.mark.parametrize("name", SOLVERS)
def test_each_solver_has_its_options_and_its_output(name):
    solver = getattr(matlab, name)
    options = odeset("RelTol", 1e-8, "AbsTol", 1e-10, "Events", crosses)
    sol = solver(swing, [0, 10], [1, 0], options)
    t, y = sol
    assert y[:, 0] == pytest.approx(np.cos(t), abs=1e-5)
    assert sol.te == pytest.approx(math.pi * np.array([0.5, 1.5, 2.5]), abs=1e-6)
    assert list(sol.ie) == [0, 0, 0] and sol.solver == name
    refine = {"ode45": 4, "ode78": 8, "ode89": 8}.get(name, 1)
    assert len(t) == refine * (len(sol.x) - 1) + 1
    assert np.diff(sol.x).max() <= 1.0 * (1 + 1e-12)  # a tenth of the span
    t, y = solver(swing, [0, 1, 2], [1, 0], odeset("MaxStep", 0.01))
    assert list(t) == [0, 1, 2]
    coarse, fine = (solver(swing, [0, 100], [1, 0], odeset("RelTol", r)) for r in (1e-3, 1e-7))
    off = [np.abs(one.y[0] - np.cos(one.x)).max() for one in (coarse, fine)]
    assert off[1] < 0.1 * off[0]


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", STIFF)
def test_stiff_solvers_take_few_steps_and_a_jacobian(name):
    solver = getattr(matlab, name)
    seen = []

    def jacobian(t, y):
        seen.append(t)
        return [[-1000.0]]

    for options in (odeset(), odeset("Jacobian", [[-1000.0]]), odeset("Jacobian", jacobian)):
        sol = solver(stiff, [0, 10], 1, options)
        assert sol.y[0] == pytest.approx(np.cos(sol.x), abs=5e-3)
        assert sol.stats["nsteps"] < 300 < ode45(stiff, [0, 10], 1).stats["nsteps"]
    assert seen


@pytest.mark.parametrize("name", METHODS)
def test_the_docstring_names_the_method_that_solves(name):
    assert f'"{METHODS[name]}"' in getattr(matlab, name).__doc__


@pytest.mark.parametrize("solver", [ode15s, ode23t])
def test_a_singular_mass_is_an_algebraic_equation(solver):
    """Robertson's reactions as MathWorks' example hb1dae: y1 + y2 + y3 = 1."""

    def robertson(t, y):
        slow = 0.04 * y[0] - 1e4 * y[1] * y[2]
        return [-slow, slow - 3e7 * y[1] ** 2, y[0] + y[1] + y[2] - 1.0]

    mass, small = np.diag([1.0, 1.0, 0.0]), [1e-8, 1e-12, 1e-8]
    options = odeset("Mass", mass, "RelTol", 1e-6, "AbsTol", small)
    _, y = solver(robertson, [0, 40], [1, 0, 0], options)
    assert y[-1] == pytest.approx([0.7158270688, 9.185534765e-6, 0.2841637457], rel=1e-4)
    with pytest.raises(SingularMatrixError, match="and ode45 solves no algebraic"):
        ode45(robertson, [0, 40], [1, 0, 0], options)


def test_odextend_goes_on_with_the_same_options():
    options = odeset("RelTol", 1e-8, "Events", crosses)
    sol = ode45(swing, [0, 5], [1, 0], options)
    longer = odextend(sol, [], 10)
    assert longer.x[0] == 0.0 and longer.x[-1] == 10.0 and len(np.unique(longer.x)) == len(longer.x)
    assert longer.y[0] == pytest.approx(np.cos(longer.x), abs=1e-5)
    assert list(longer.te) == pytest.approx(math.pi * np.array([0.5, 1.5, 2.5]), abs=1e-6)
    between = np.array([2.5, 7.5])
    assert deval(longer, between)[0] == pytest.approx(np.cos(between), abs=1e-5)
    assert deval(longer, 5.0)[0] == sol.y[0, -1]
    assert longer.stats["nsteps"] > sol.stats["nsteps"]
    t, y = longer
    assert y[:, 0] == pytest.approx(np.cos(t), abs=1e-5) and np.all(np.diff(t) > 0)
    again = odextend(longer, None, 12.0)
    assert again.y[0, -1] == pytest.approx(math.cos(12.0), abs=1e-5)


def test_odextend_takes_another_function_state_and_options():
    sol = ode45(swing, [0, 5], [1, 0])
    kicked = odextend(sol, lambda t, y: [0.0, 0.0], 6, [7, 8], odeset("MaxStep", 0.1))
    assert list(kicked.y[:, -1]) == [7, 8]
    assert np.sum(kicked.x == 5.0) == 2  # the state before, and after
    assert np.diff(kicked.x)[-5:].max() <= 0.1 * (1 + 1e-12)
    for wrong in (None, 4.0, 5.0):
        with pytest.raises(ValueError, match="beyond 5"):
            odextend(sol, None, wrong)
    with pytest.raises(TypeError, match="continues what"):
        odextend(sol.x, None, 6)


def test_two_names_take_two_outputs_and_five_take_five():
    options = odeset("Events", crosses)
    t, y = ode45(swing, [0, 5], [1, 0], options)
    t5, y5, te, ye, ie = sol = ode45(swing, [0, 5], [1, 0], options)
    assert np.array_equal(t, t5) and np.array_equal(y, y5)
    assert np.array_equal(te, sol.te) and np.array_equal(ye.T, sol.ye) and len(ie) == 2
    t2, *rest = sol
    assert np.array_equal(t2, t) and len(rest) == 4 and len(list(sol)) == 5
    with pytest.raises(ValueError, match="for 5 names"):
        t, y, te, ye, ie = ode45(swing, [0, 5], [1, 0])


def test_empty_options_and_columns():
    expected = ode45(swing, [0, 5], [1, 0])
    for empty in (None, [], {}, (), odeset(), odeset(RelTol=[])):
        assert np.array_equal(ode45(swing, [0, 5], [1, 0], empty).y, expected.y)

    def column(t, y):
        return np.array([[y[1]], [-y[0]]])

    def nested(t, y):
        return [[y[1]], [-y[0]]]

    for fun in (column, nested):
        for solver in (ode45, ode15s, ode113):
            given = [0, 5], [[1], [0]]
            assert np.array_equal(solver(fun, *given).y, solver(swing, *given).y)


def test_min_step_ends_the_run_where_shorter_steps_are_needed():
    def pole(t, y):
        return [1 / (2 - t) ** 2]

    with pytest.warns(UserWarning, match="Failure in ode45: .* below MinStep = 0.001"):
        cut = ode45(pole, [0, 3], 0.5, odeset("RelTol", 1e-6, "MaxStep", 0.5, "MinStep", 1e-3))
    assert 1.5 < cut.x[-1] < 2.0 and np.diff(cut.x).min() >= 1e-3 * (1 - 1e-9)
    assert cut.y[0] == pytest.approx(1 / (2 - cut.x), rel=1e-4)
    assert deval(cut, cut.x[-2:])[0] == pytest.approx(cut.y[0, -2:], rel=1e-12)
    with pytest.raises(ValueError, match="knows the solution from 0"):
        deval(cut, 2.0)
    never = odeset("MinStep", 1e-2), odeset("MinStep", 10.0), odeset()
    whole = [ode45(swing, [0, 5], [1, 0], one).y for one in never]  # the first steps are short
    assert np.array_equal(whole[0], whole[2]) and np.array_equal(whole[1], whole[2])


def test_initial_step_is_the_first_step_tried():
    for h in (1e-5, 0.01, 0.1):  # from the slope it would be 2e-4
        assert ode45(swing, [0, 5], [1, 0], odeset("InitialStep", h)).x[1] == pytest.approx(h)
    tried = ode45(swing, [0, 5], [1, 0], odeset("InitialStep", 5.0, "RelTol", 1e-6))
    assert tried.stats["nfailed"] > 0 and tried.x[1] < 0.5  # a tenth of the span was too long
