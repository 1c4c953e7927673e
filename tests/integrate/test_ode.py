"""ode and complex_ode: SciPy's classes, whose integrators are compiled."""

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import complex_ode, ode
from fastdyn.integrate import continued, integrators


def spring(t, y, c):
    return [y[1], -2.0 * y[0] - c * y[1]]


def robertson(t, y):
    slow, fast = 0.04 * y[0] - 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [-slow, slow - fast, fast]


NAMES = [("lsoda", {}), ("vode", {}), ("vode", {"method": "bdf"}), ("dopri5", {}), ("dop853", {})]


def solver_of(kind, name, options):
    solver = kind(spring).set_integrator(name, **options).set_f_params(0.1)
    return solver.set_initial_value([1.0, 0.0], 0.0)


@pytest.fixture
def own(monkeypatch):
    """Fail if SciPy's integrators run."""

    def refused(*given):
        raise AssertionError("SciPy's integrator")

    for name in ("vode", "zvode", "lsoda", "dopri5", "dop853"):
        kind = getattr(scipy.integrate._ode, name)
        for how in ("run", "step", "run_relax"):
            monkeypatch.setattr(kind, how, refused)


def exact(t):
    """y'' + 0.1 y' + 2 y = 0 from (1, 0)."""
    w = np.sqrt(2.0 - 0.05**2)
    return np.exp(-0.05 * t) * (np.cos(w * t) + 0.05 / w * np.sin(w * t))


@pytest.mark.parametrize(("name", "options"), NAMES)
def test_a_loop_of_calls_keeps_the_tolerance(own, name, options):
    solver, errors = solver_of(ode, name, {**options, "rtol": 1e-8, "atol": 1e-8}), []
    while solver.successful() and solver.t < 20.0:
        y = solver.integrate(solver.t + 0.25)
        errors.append(abs(y[0] - exact(solver.t)))
        assert (solver.y == y).all()
    assert solver.get_return_code() > 0
    assert len(errors) == 80
    assert max(errors) < 1e-8 * 1000  # some 300 steps of BDF, each of the tolerance


def test_lsoda_takes_scipys_steps():
    counts = []
    for kind in (ode, scipy.integrate.ode):
        solver = kind(robertson).set_integrator("lsoda").set_initial_value([1.0, 0.0, 0.0], 0.0)
        states = [solver.integrate(t).copy() for t in (0.4, 4.0, 40.0)]
        counts.append((solver._integrator.iwork[10:13].tolist(), states))
    assert counts[0][0] == counts[1][0]
    np.testing.assert_allclose(counts[0][1], counts[1][1], rtol=1e-6, atol=1e-12)


def test_vode_steps_by_one_family_alone():
    stiff = ode(robertson).set_integrator("vode", method="bdf", nsteps=5000)
    stiff.set_initial_value([1.0, 0.0, 0.0], 0.0).integrate(40.0)
    assert stiff._integrator.iwork[10] < 500
    adams = ode(robertson).set_integrator("vode", method="adams", nsteps=500)
    adams.set_initial_value([1.0, 0.0, 0.0], 0.0)
    with pytest.warns(UserWarning, match="vode: Excess work.* 500 steps do not lead to t = 40"):
        adams.integrate(40.0)
    assert not adams.successful()
    assert adams.get_return_code() == -1
    assert 0.0 < adams.t < 40.0


def test_single_steps_and_relaxed_calls(own):
    solver = solver_of(ode, "vode", {})
    times = []
    for _ in range(4):
        solver.integrate(9.0, step=True)
        times.append(solver.t)
        assert abs(solver.y[0] - exact(solver.t)) < 1e-5
    assert (np.diff(times) > 0).all()
    y = solver.integrate(9.0, relax=True)
    assert solver.t >= 9.0
    assert abs(y[0] - exact(solver.t)) < 1e-4
    with pytest.warns(UserWarning, match="before the last step.*set_initial_value"):
        solver.integrate(1.0)


def test_new_parameters_and_outside_values_are_taken(own):
    stiffness = {"k": 2.0}

    def rates(t, y, c):
        return [y[1], -stiffness["k"] * y[0] - c * y[1]]

    solver = ode(rates).set_integrator("lsoda", rtol=1e-9).set_f_params(0.1)
    y = solver.set_initial_value([1.0, 0.0]).integrate(1.0).copy()
    stiffness["k"] = 5.0
    solver.set_f_params(0.3)
    found = solver.integrate(2.0)
    wanted = fastdyn.solve_ivp(
        lambda t, y: [y[1], -5.0 * y[0] - 0.3 * y[1]], (1, 2), y, "DOP853", rtol=1e-10, atol=1e-12
    )
    np.testing.assert_allclose(found, wanted.y[:, -1], rtol=1e-7)


@pytest.mark.parametrize("method", ["adams", "bdf"])
def test_complex_states(own, method):
    turning = ode(lambda t, y, w: 1j * w * y).set_integrator("zvode", method=method, rtol=1e-8)
    found = turning.set_initial_value(1.0, 0.0).set_f_params(2.0).integrate(1.0)
    assert turning.successful()
    assert turning.get_return_code() == 2
    assert abs(found[0] - np.exp(2j)) < 1e-6
    both = complex_ode(lambda t, y: 1j * y).set_integrator("vode", method=method, rtol=1e-8)
    found = both.set_initial_value([1.0 + 1.0j], 0.0).integrate(1.0)
    assert abs(found[0] - (1 + 1j) * np.exp(1j)) < 1e-6


def test_one_step_at_a_time_by_nsteps(own):
    """The idiom of those who want each step of dopri5: nsteps=1, and warnings switched off."""
    solver = solver_of(ode, "dopri5", {"nsteps": 1})
    solver._integrator.iwork[2] = -1
    times = []
    with pytest.warns(UserWarning, match="larger nsteps is needed"):
        while solver.t < 1.0:
            solver.integrate(1.0, step=True)
            times.append(solver.t)
    assert len(times) > 3
    assert abs(solver.y[0] - exact(1.0)) < 1e-5


def test_a_function_that_writes_to_its_state_is_scipys():
    def writes(t, y):
        y[y < 0.5] = 0.5
        return -y

    values = []
    for kind in (ode, scipy.integrate.ode):
        solver = kind(writes).set_integrator("lsoda").set_initial_value([1.0], 0.0)
        values.append([float(solver.integrate(t)[0]) for t in (0.5, 1.0)])
    assert values[0] == values[1]


def test_each_integrator_of_scipys_has_a_compiled_one():
    for name in ("vode", "zvode", "lsoda", "dopri5", "dop853"):
        assert isinstance(ode(spring).set_integrator(name)._integrator, integrators.Replaced)


@pytest.mark.parametrize(("name", "options"), NAMES[:3])
def test_short_calls_are_those_of_the_long_way(monkeypatch, name, options):
    """Bit for bit, with a branch, an outside value that changes, and a Jacobian."""
    table = {"force": 0.0}

    def pushed(t, y):
        return [y[1], -2.0 * y[0] + (table["force"] if y[0] > 0 else 0.0)]

    def matrix(t, y):
        return [[0.0, 1.0], [-2.0, 0.0]]

    def states(jac):
        table["force"] = 0.0
        solver = ode(pushed, jac).set_integrator(name, **options)
        solver.set_initial_value([1.0, 0.0], 0.0)
        found = []
        for k in range(300):
            if k == 150:
                table["force"] = 0.5
            found.append(solver.integrate(solver.t + (0.03 if k % 3 else 0.4)).copy())
        return np.array(found), solver._integrator.iwork[10:13].tolist()

    quick = continued.Continued.at
    answers = []

    def noted(run, t):
        answers.append(quick(run, t))
        return answers[-1]

    for jac in (None, matrix):
        answers.clear()
        monkeypatch.setattr(continued.Continued, "at", lambda run, t: None)
        wanted, counts = states(jac)
        monkeypatch.setattr(continued.Continued, "at", noted)
        found, counts_now = states(jac)
        assert (found == wanted).all()
        assert counts == counts_now
        assert sum(answer is not None for answer in answers) > 250


COLUMNS = {"column": (2, 1), "row": (1, 2)}


def in_shape(shape):
    def fun(t, y, c):
        dy = np.zeros(2)
        dy[0] = y[1]
        dy[1] = -2.0 * y[0] - c * y[1]
        return dy.reshape(shape)

    return fun


@pytest.mark.parametrize("name", ["dopri5", "dop853"])
@pytest.mark.parametrize("shape", COLUMNS.values(), ids=COLUMNS)
def test_a_column_is_taken_where_scipy_takes_it(name, shape):
    """Scripts from the time of the first `ode` return ``np.zeros((n, 1))``."""
    ends = []
    for kind in (ode, scipy.integrate.ode):
        solver = kind(in_shape(shape)).set_integrator(name).set_f_params(0.1)
        solver.set_initial_value([1.0, 0.0], 0.0)
        for t in (0.5, 1.0):
            solver.integrate(t)
        assert solver.successful()
        ends.append(solver.y)
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize("name", ["vode", "lsoda"])
def test_a_column_is_refused_where_scipy_refuses_it(name):
    solver = ode(in_shape((2, 1))).set_integrator(name).set_f_params(0.1)
    with pytest.raises(ValueError, match=r"a column, of shape \(2, 1\)"):
        solver.set_initial_value([1.0, 0.0], 0.0).integrate(1.0)


def test_another_number_of_values_is_refused():
    """SciPy's dopri5 takes what lies in memory."""
    solver = ode(lambda t, y: np.ones((3, 1))).set_integrator("dopri5")
    with pytest.raises(ValueError, match="3 values in rows"):
        solver.set_initial_value([1.0, 0.0], 0.0).integrate(1.0)
