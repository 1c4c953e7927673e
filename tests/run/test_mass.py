"""M y' = f(t, y): regular and singular matrices, starts that are not consistent."""

import numpy as np
import pytest
import scipy.sparse
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn import solve_ivp
from support.masses import TAKE
from support.stiff import robertson

TIGHT = {"rtol": 1e-9, "atol": 1e-13}


def robertson_dae(t, y):
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, a + b + c - 1.0]


ROBERTSON_MASS = np.diag([1.0, 1.0, 0.0])


def other(method):
    """Radau and BDF keep the errors of their steps in tolerance, not those of the solution."""
    return 1.0 if method == "Rodas5P" else 30.0


@pytest.mark.few(2)
@pytest.mark.parametrize("method", TAKE)
@pytest.mark.parametrize("jac", [None, "2-point"])
def test_robertson_as_ode_and_as_dae(jac, method):
    """At loose tolerances where the Jacobian is by differences."""
    times, start = np.geomspace(1e-3, 1e7, 11), [1.0, 0.0, 0.0]
    given = {"t_eval": times, "rtol": 1e-5 if jac else 1e-9, "atol": 1e-8 if jac else 1e-13}
    radau = solve_ivp(robertson, (0, 1e7), start, "Radau", t_eval=times, **TIGHT)
    ode = solve_ivp(robertson, (0, 1e7), start, method, jac=jac, **given)
    dae = solve_ivp(robertson_dae, (0, 1e7), start, method, jac=jac, mass=ROBERTSON_MASS, **given)
    for run in (ode, dae):  # by rtol a step, of which some hundred are not damped
        assert run.status == 0
        assert run.y == pytest.approx(
            radau.y, rel=300 * other(method) * given["rtol"], abs=other(method) * given["atol"]
        )
    assert np.abs(dae.y.sum(0) - 1.0).max() < 10 * given["rtol"]


@pytest.mark.parametrize("rtol", [1e-5, 1e-7])
def test_differences_do_for_many_algebraic_equations(rtol):
    """They are right to some sqrt(eps), and the steps those of the exact Jacobian but for the first
    ones: at a state of zeros there is no size to take differences by."""
    n, rng = 39, np.random.default_rng(0)
    matrix = np.eye(n) + 0.1 * rng.standard_normal((n, n))
    given, shares = rng.standard_normal((2, n))

    def fun(t, y):
        d = np.empty(n + 1)
        d[0] = np.cos(2.0 * t) - y[0] + (shares * y[1:]).sum() / 10.0
        d[1:] = matrix @ y[1:] + 0.1 * y[1:] ** 3 - given * y[0]
        return d

    args = fun, (0, 10), np.zeros(n + 1), "Rodas5P"
    options = {"mass": np.diag([1.0] + n * [0.0]), "rtol": rtol, "atol": 1e-3 * rtol}
    exact, other = (solve_ivp(*args, **options, jac=jac) for jac in (None, "2-point"))
    assert other.status == 0 and abs(other.n_accepted / exact.n_accepted - 1.0) < 0.02
    assert np.abs(other.y[:, -1] - exact.y[:, -1]).max() < rtol


def pendulum(t, z):
    """Of length 1, in x and y, with the constraint differentiated twice."""
    x, y, u, v, tension = z
    return [u, v, -tension * x, -tension * y - 9.81, u * u + v * v - tension - 9.81 * y]


PENDULUM_MASS = scipy.sparse.diags([1.0, 1.0, 1.0, 1.0, 0.0])


@pytest.mark.parametrize("method", TAKE)
def test_a_pendulum_with_its_tension(method):
    given = {"rtol": 1e-8, "atol": 1e-8, "dense_output": True}
    run = solve_ivp(pendulum, (0, 2), [1.0, 0, 0, 0, 0], method, mass=PENDULUM_MASS, **given)
    angle = solve_ivp(
        lambda t, q: [q[1], -9.81 * np.cos(q[0])], (0, 2), [0.0, 0.0], "DOP853",
        rtol=1e-12, atol=1e-12, dense_output=True,
    )  # fmt: skip
    t = np.linspace(0, 2, 101)
    q, rate = angle.sol(t)
    expected = [np.cos(q), np.sin(q), rate**2 - 9.81 * np.sin(q)]
    assert np.abs(run.sol(t)[[0, 1, 4]] - expected).max() < (1e-5 if method == "Rodas5P" else 1e-3)


def test_events_and_breakpoints_of_a_dae():
    def lowest(t, z):
        return z[0]

    lowest.terminal = True
    given = (pendulum, (0, 2), [1.0, 0, 0, 0, 0], "Rodas5P")
    run = solve_ivp(*given, mass=PENDULUM_MASS, events=lowest, breakpoints=[0.1], **TIGHT)
    assert run.status == 1
    assert run.y_events[0][0][4] == pytest.approx(3 * 9.81, rel=1e-6)


FULL = np.array([[2.0, 1.0, 0.0], [0.5, 3.0, 1.0], [0.0, 0.0, 4.0]])
STIFF = np.array([[-1.0, 100.0, 0.0], [0.0, -50.0, 1.0], [1.0, 0.0, -2.0]])


def driven(t, y):
    return STIFF @ y + np.array([np.sin(t), 0.0, 1.0])


def solved_for_slopes(t, y):
    return np.linalg.solve(FULL, STIFF @ y + np.array([np.sin(t), 0.0, 1.0]))


def test_a_full_regular_matrix():
    given = (0, 5), [1.0, 2.0, 3.0]
    run = solve_ivp(driven, *given, "Rodas5P", mass=FULL, **TIGHT)
    exact = solve_ivp(solved_for_slopes, *given, "DOP853", rtol=1e-12, atol=1e-12)
    assert run.y[:, -1] == pytest.approx(exact.y[:, -1], rel=1e-7)
    same = solve_ivp(solved_for_slopes, *given, "Rodas5P", **TIGHT)
    assert abs(same.n_accepted - run.n_accepted) <= 5


@pytest.mark.parametrize("sizes", [[1e-12, 1.0, 1e12], [1e12, 1e-12, 1.0]])
def test_units_do_not_make_a_matrix_singular(sizes):
    """Equations and components in any units; the same steps but for rounding in other pivots."""
    rows, columns = np.array(sizes), 1.0 / np.sqrt(sizes)
    events = {"events": lambda t, y: y[0] + 1e30, "on_event": lambda t, y: y}  # of regular ones
    mass, matrix = (rows[:, None] * a / columns for a in (FULL, STIFF))
    driven, start = rows * np.array([0.0, 0.0, 1.0]), np.array([1.0, 2.0, 3.0])
    given = {"rtol": 1e-6, "atol": 1e-9}
    plain = solve_ivp(
        lambda t, y: STIFF @ y + np.array([0.0, 0.0, 1.0]), (0, 5), start, "Rodas5P", mass=FULL,
        first_step=1e-3, **given,
    )  # fmt: skip
    run = solve_ivp(
        lambda t, y: matrix @ y + driven, (0, 5), columns * start, "Rodas5P", mass=mass,
        first_step=1e-3, rtol=1e-6, atol=1e-9 * columns, **events,
    )  # fmt: skip
    assert run.n_accepted == plain.n_accepted
    assert run.y[:, -1] / columns == pytest.approx(plain.y[:, -1], rel=1e-9)


def test_an_algebraic_equation_is_found_in_any_units():
    """Robertson's, with components and equations in units 1e12 apart."""
    rows, columns = np.array([1e-12, 1e12, 1.0]), np.array([1e6, 1e-6, 1.0])

    def fun(t, y):
        return rows * np.array(robertson_dae(t, y / columns))

    mass = rows[:, None] * ROBERTSON_MASS / columns
    start, given = np.array([1.0, 0.0, 0.0]), {"rtol": 1e-6, "mass": mass}
    run = solve_ivp(fun, (0, 40), columns * start, "Rodas5P", atol=1e-10 * columns, **given)
    plain = solve_ivp(
        robertson_dae, (0, 40), start, "Rodas5P", mass=ROBERTSON_MASS, rtol=1e-6, atol=1e-10
    )
    assert run.y[:, -1] / columns == pytest.approx(plain.y[:, -1], rel=1e-5)
    with pytest.raises(ValueError, match="component 2 is off by"):
        solve_ivp(fun, (0, 40), columns * [1.0, 0.0, 0.5], "Rodas5P", atol=1e-10 * columns, **given)


@pytest.mark.parametrize("method", TAKE)
def test_a_start_that_is_not_consistent_is_named_with_one_that_is(method):
    given = (robertson_dae, (0, 1), [1.0, 0.0, 0.5], method)
    with pytest.raises(
        ValueError, match=r"component 2 is off by .* Start from \[1\.0, 0\.0, "
    ) as e:
        solve_ivp(*given, mass=ROBERTSON_MASS)
    found = eval(str(e.value).split("Start from ")[1].split(", where")[0])
    assert found == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    off = [1.0, 0.0, 1e-5]  # inside atol + rtol |y|
    run = solve_ivp(*given[:2], off, method, mass=ROBERTSON_MASS, atol=1e-4)
    assert run.status == 0
    with pytest.raises(ValueError, match="Newton's iteration finds no state"):
        solve_ivp(lambda t, y: [1.0, y[1] ** 2 + 1.0], (0, 1), [0, 1], method, mass=np.diag([1, 0]))


@pytest.mark.parametrize("method", TAKE)
def test_a_higher_index_is_refused(method):
    def constrained_velocity(t, z):
        x, y, u, v, tension = z
        return [u, v, -tension * x, -tension * y - 9.81, x * u + y * v]

    for fun in (constrained_velocity, lambda t, z: [z[1], z[2], z[3], z[4], z[0] * 2 - 2]):
        with pytest.raises(ValueError, match="no DAE of index 1 at the start"):
            solve_ivp(fun, (0, 1), [1.0, 0, 0, 0, 0], method, mass=PENDULUM_MASS)


@pytest.mark.parametrize("power", [1, 2])
def test_equations_that_become_singular_end_with_a_sentence(power):
    """0 = y0 (z - 1)^power at y0 = 1 - t; from t = 1 on, any z is a solution."""

    def fun(t, y):
        slope = 0.0 if y[0] <= 0.5 else -1.0
        weight = 0.0 if y[0] <= 0.5 else 1.0
        return [slope, weight * (y[1] - 1.0) * power]

    run = solve_ivp(fun, (0, 2), [1.0, 1.0], "Rodas5P", mass=np.diag([1, 0]), max_step=0.1)
    assert run.status == -1 and run.t[-1] < 0.7
    assert "is singular, however short the step" in run.message


@pytest.mark.parametrize(
    "mass, said",
    [
        (np.eye(2), "3 rows and columns"),
        (np.full((3, 3), np.nan), "finite numbers"),
        (1j * np.eye(3), "complex128"),
        (lambda t, y: np.eye(2), "3 rows and columns"),
        (lambda t, y: np.diag([1.0, 1.0, 0.0]), "`mass` is singular at the start"),
    ],
)
def test_what_is_no_mass_is_refused(mass, said):
    with pytest.raises((TypeError, ValueError), match=said):
        solve_ivp(driven, (0, 1), [1.0, 2, 3], "Rodas5P", mass=mass)


@pytest.mark.parametrize("method", [name for name in fastdyn.METHODS if name not in TAKE])
def test_other_methods_refuse_it(method):
    with pytest.raises(ValueError, match=rf"`mass` is not for {method}: take method='Rodas5P'"):
        solve_ivp(driven, (0, 1), [1.0, 2, 3], method, mass=np.eye(3), step=0.1)


def test_what_does_not_go_with_it_is_refused():
    given = (robertson_dae, (0, 1), [1.0, 0, 0])
    with pytest.raises(ValueError, match="not for this method"):
        solve_ivp(*given, OdeSolver, mass=ROBERTSON_MASS)
    with pytest.raises(ValueError, match=r"`project` does not go .* among the algebraic equations"):
        solve_ivp(*given, "Rodas5P", mass=ROBERTSON_MASS, project=lambda t, y: y)
    with pytest.raises(ValueError, match="`sensitivity` and `mass`"):
        solve_ivp(*given, "Rodas5P", mass=ROBERTSON_MASS, sensitivity="y0")
    for call in (fastdyn.prepare, fastdyn.solve_ensemble):
        with pytest.raises(ValueError, match="`mass` is not for RK45: take method='Rodas5P'"):
            call(*given, method="RK45", mass=ROBERTSON_MASS)
    phases = {"one": fastdyn.Phase(given[0], lambda t, y: y[0], after="one")}
    with pytest.raises(ValueError, match="phases take no `mass`"):
        fastdyn.solve_phases(phases, "one", *given[1:], method="Rodas5P", mass=ROBERTSON_MASS)


def test_a_checkpoint_is_of_one_matrix(tmp_path):
    given = (driven, (0, 5), [1.0, 2.0, 3.0], "Rodas5P")
    run = solve_ivp(*given, mass=FULL, checkpoint=tmp_path / "run.npz")
    assert np.array_equal(run.y, solve_ivp(*given, mass=FULL).y)
    again = solve_ivp(*given, mass=FULL, checkpoint=tmp_path / "run.npz")
    assert np.array_equal(again.y, run.y)
    other = solve_ivp(*given)
    assert not np.array_equal(other.y[:, -1], run.y[:, -1])
