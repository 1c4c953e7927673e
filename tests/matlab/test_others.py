"""deval's second output, options as attributes, ode15i, bvp4c, odeplot."""

import numpy as np
import pytest

from fastdyn.matlab import (
    bvp4c,
    bvp5c,
    bvpinit,
    deval,
    ode15i,
    ode45,
    odeplot,
    odeset,
    odextend,
)  # fmt: skip

TIGHT = odeset("RelTol", 1e-9, "AbsTol", 1e-9)


def spring(t, y):
    return [y[1], -y[0]]


def decay(t, y):
    return [-y[0], -2 * y[1], -3 * y[2]]


def test_two_names_for_deval_are_the_solution_and_its_derivative():
    sol = ode45(decay, [0, 2], [1, 1, 1], TIGHT)
    y, yp = deval(sol, [0.3, 0.5, 1.7])
    assert (y == deval(sol, [0.3, 0.5, 1.7])).all()
    assert abs(yp - np.array(decay(0, y))).max() < 1e-6  # a derivative loses an order
    y, yp = deval(sol, 0.5, [1])
    assert y.shape == yp.shape == (1,)
    longer = odextend(sol, None, 4.0)
    _, yp = deval(longer, [0.5, 3.0])
    assert abs(yp[0] + np.exp([-0.5, -3.0])).max() < 1e-6


def test_two_names_for_two_components_get_a_warning():
    sol = ode45(spring, [0, 2], [1, 0], TIGHT)
    with pytest.warns(UserWarning, match="its derivative, as in MATLAB; the two components"):
        y, yp = deval(sol, [0.5, 1.0])
    assert y.shape == yp.shape == (2, 2)
    assert abs(yp[0] - y[1]).max() < 1e-6
    rows = deval(sol, [0.5, 1.0])  # without a warning, which would be an error here
    first, second = rows
    assert (first == y[0]).all() and (second == y[1]).all()


def test_options_are_attributes():
    options = odeset("RelTol", 1e-5)
    assert options.RelTol == options.reltol == 1e-5
    assert options.AbsTol is None
    options.MaxStep = 0.1
    assert options == {"RelTol": 1e-5, "MaxStep": 0.1}
    with pytest.raises(ValueError, match="MaxStep must be one positive number"):
        options.MaxStep = -1
    with pytest.raises(AttributeError, match="did you mean RelTol"):
        options.RelToll  # noqa: B018
    assert "no option is set. There are: AbsTol, BDF" in repr(odeset())


def test_indices_from_one_get_a_sentence():
    for wrong, said in (
        (lambda t, y: [y[1], y[2]], "counted from 0, the last is y[1]"),
        (lambda t, y: [y(2), -y(1)], "in square brackets and are counted from 0"),
    ):
        with pytest.raises((IndexError, TypeError)) as caught:
            ode45(wrong, [0, 1], [1.0, 0.0])
        assert said in "".join(caught.value.__notes__)


def test_ode15i_solves_implicit_equations():
    def residual(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[0]]

    t, y = ode15i(residual, [0, 3], [1, 0], [0, -1], odeset("RelTol", 1e-7, "AbsTol", 1e-9))
    assert abs(y[:, 0] - np.cos(t)).max() < 1e-5
    at = np.linspace(0, 3, 7)
    t, y = ode15i(residual, at, [1, 0], [0, -1])
    assert (t == at).all()
    with pytest.raises(ValueError, match="consistent"):
        ode15i(residual, [0, 3], [1, 0], [5, -1])


@pytest.mark.parametrize("solver", [bvp4c, bvp5c])
def test_boundary_value_problems(solver):
    """MathWorks' examples twobvp and mat4bvp; the latter's eigenvalue is 17.097."""
    guess = bvpinit(np.linspace(0, 4, 5), [1, 0])
    sol = solver(lambda x, y: [y[1], -abs(y[0])], lambda a, b: [a[0], b[0] + 2], guess)
    assert abs(sol.y[0, 0]) < 1e-9 and abs(sol.y[0, -1] + 2) < 1e-9
    assert abs(deval(sol, 1.0)[0] / deval(sol, 2.0)[0] - np.sin(1) / np.sin(2)) < 1e-3
    _, yp = deval(sol, [1.0, 2.0, 3.9], [0])
    assert abs(yp - deval(sol, [1.0, 2.0, 3.9])[1]).max() < 1e-2

    def mathieu(x, y, p):
        return [y[1], -(p[0] - 10 * np.cos(2 * x)) * y[0]]

    guess = bvpinit(np.linspace(0, np.pi, 10), lambda x: [np.cos(4 * x), -4 * np.sin(4 * x)], 15)
    sol = solver(mathieu, lambda a, b, p: [a[1], b[1], a[0] - 1], guess)
    assert abs(sol.parameters[0] - 17.097) < 1e-3
    again = solver(mathieu, lambda a, b, p: [a[1], b[1], a[0] - 1], sol, odeset("RelTol", 1e-6))
    assert abs(again.parameters[0] - 17.0966) < 1e-4

    def as_in_matlab(x, y, p):  # where one parameter is a number
        return [y[1], -(p - 10 * np.cos(2 * x)) * y[0]]

    same = solver(as_in_matlab, lambda a, b, p: [a[1:], b[1], a[:1] - 1], guess)
    assert np.array_equal(same.parameters, sol.parameters)


def test_odeplot_draws_while_a_solver_runs():
    import matplotlib.pyplot as plt

    t, y = ode45(spring, [0, 2], [1, 0], odeset("OutputFcn", odeplot, "OutputSel", [1]))
    (line,) = plt.gcf().axes[0].lines
    np.testing.assert_allclose(line.get_xdata(), t)
    np.testing.assert_allclose(line.get_ydata(), y[:, 1], atol=1e-12)
    plt.close()
