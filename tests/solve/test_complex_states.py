"""Complex states in compiled code: SciPy's steps and evaluations, and its states to rounding."""

import numpy as np
import pytest
import scipy.sparse
from scipy.integrate import solve_ivp as reference
from scipy.interpolate import CubicSpline, interp1d, make_interp_spline

import fastdyn
from fastdyn.kernels.methods import COMPLEX, METHODS

START = np.array([1.0 + 0.3j, -0.4 + 0.2j, 0.1j])
LEVELS = np.array([[0.5, 0.2 - 0.1j, 0.0], [0.2 + 0.1j, -0.3, 0.1j], [0.0, -0.1j, 0.7]])


def levels(t, psi, strength=0.3):
    return -1j * (LEVELS @ psi) - strength * np.abs(psi) ** 2 * psi * np.exp(1j * t)


def half(t, psi, *args):
    return abs(psi[0]) - 0.8


def turned(t, psi, *args):
    return psi[1].real


turned.direction = -1


def assert_same(found, expected, near=1e-9):
    """The states differ by rounding, which 100 steps of a tame system multiply by 1e3 at most."""
    assert (found.status, found.nfev, found.message) == (
        expected.status, expected.nfev, expected.message,
    )  # fmt: skip
    assert np.array_equal(found.t.shape, expected.t.shape)
    np.testing.assert_allclose(found.t, expected.t, rtol=near)
    assert found.y.dtype == complex
    np.testing.assert_allclose(found.y, expected.y, rtol=10 * near, atol=near)


@pytest.mark.filterwarnings("error")  # it is compiled
@pytest.mark.parametrize("method", ["RK23", "RK45", "DOP853"])
@pytest.mark.parametrize(
    "options",
    [
        {"rtol": 1e-6},
        {"rtol": 1e-7, "atol": np.array([1e-8, 1e-6, 1e-9]), "t_eval": np.linspace(0, 6, 9)},
        {"first_step": 0.05, "max_step": 0.2},
        {"args": (0.1,), "rtol": 1e-5},
    ],
)
def test_steps_are_those_of_scipy(method, options):
    given = levels, (0, 6), START, method
    # the error estimate of the first, short step of DOP853 is rounding, and chooses the second
    near = 1e-5 if method == "DOP853" else 1e-9
    assert_same(fastdyn.solve_ivp(*given, **options), reference(*given, **options), near)


@pytest.mark.filterwarnings("error")
def test_events_and_dense_output():
    given = {"events": [half, turned], "dense_output": True, "rtol": 1e-8, "atol": 1e-9}
    found, expected = (s(levels, (0, 9), START, **given) for s in (fastdyn.solve_ivp, reference))
    assert_same(found, expected)
    times = np.linspace(0, 9, 40)
    np.testing.assert_allclose(found.sol(times), expected.sol(times), rtol=1e-7, atol=1e-9)
    assert found.sol(2.0).shape == (3,)
    for mine, other in zip(found.t_events, expected.t_events, strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-7)
    for mine, other in zip(found.y_events, expected.y_events, strict=True):
        np.testing.assert_allclose(mine, other, rtol=1e-6, atol=1e-8)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-12])
def test_taylor(rtol):
    """Within 100 tolerances of DOP853 at 1e-13, in few evaluations."""

    def squared(t, psi):
        return (psi[0] * np.conj(psi[0])).real - 0.64

    given = {"events": [squared, turned], "dense_output": True}
    found = fastdyn.solve_ivp(levels, (0, 9), START, "Taylor", rtol=rtol, atol=rtol, **given)
    expected = reference(levels, (0, 9), START, "DOP853", rtol=1e-13, atol=1e-13, **given)
    near, times = 100 * rtol, np.linspace(0, 9, 40)
    assert found.nfev < 100 and found.y.dtype == complex
    assert np.abs(found.y[:, -1] - expected.y[:, -1]).max() < near
    assert np.abs(found.sol(times) - expected.sol(times)).max() < near
    for mine, other in zip(found.t_events, expected.t_events, strict=True):
        np.testing.assert_allclose(mine, other, atol=10 * near)


def stiff(t, z):
    """A component that is pulled to exp(it), one that turns, one between."""
    on = np.exp(1j * t)
    return [-1000 * (z[0] - on) + 1j * on, 3j * z[1] - 0.1 * z[1], -50 * (z[2] - z[0] * z[1])]


def stiff_jacobian(t, z):
    return np.array([[-1000, 0, 0], [0, 3j - 0.1, 0], [50 * z[1], 50 * z[0], -50]])


def sparse_jacobian(t, z):
    return scipy.sparse.csc_matrix(stiff_jacobian(t, z))


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("jac", [None, "2-point", stiff_jacobian, sparse_jacobian])
@pytest.mark.parametrize("tol", [1e-3, 1e-5])
def test_bdf_takes_the_steps_of_scipy(jac, tol):
    """Newton's iterations differ by the error of SciPy's differences, far below the tolerance."""
    given, options = (stiff, (0, 3), START, "BDF"), {"rtol": tol, "atol": 1e-2 * tol}
    found = fastdyn.solve_ivp(*given, **options, jac=jac)
    expected = reference(*given, **options)
    assert (found.status, found.nfev, found.nlu, len(found.t)) == (
        expected.status, expected.nfev, expected.nlu, len(expected.t),
    )  # fmt: skip
    assert np.abs(found.y - expected.y).max() < tol


@pytest.mark.parametrize("method", ["BDF", "Radau"])
def test_implicit_methods_solve_what_has_no_complex_derivative(method):
    """|z|: the Jacobian is by real and imaginary parts."""

    def fun(t, z):
        return [-1e3 * (abs(z[0]) - 2) * z[0] + 1j * z[0]]

    # |z| = r solves r' = -1e3 (r - 2) r, and the phase is t
    found = fastdyn.solve_ivp(fun, (0, 5), [1 + 0j], method, rtol=1e-8, atol=1e-8)
    assert abs(found.y[0, -1] - 2 * np.exp(5j)) < 1e-6


def test_the_shapes_of_jacobians_are_looked_at():
    for name in ("jac", "jac_sparsity"):
        with pytest.raises(ValueError, match=rf"`{name}` is expected to have shape \(3, 3\)"):
            fastdyn.solve_ivp(stiff, (0, 1), START, "BDF", **{name: np.eye(4)})


@pytest.mark.parametrize("method", ["Tsit5", "Vern7", "Vern9", "RK4"])
def test_exact_solution(method):
    """z' = i omega z: the methods that SciPy does not have."""
    options = {"step": 0.01} if method == "RK4" else {"rtol": 1e-11, "atol": 1e-12}
    found = fastdyn.solve_ivp(lambda t, z: 1j * z * 2.0, (0, 3), [1 - 1j], method, **options)
    assert abs(found.y[0, -1] - (1 - 1j) * np.exp(6j)) < 1e-7


def test_new_numbers_are_seen():
    rate, matrix = 0.5j, np.array([[1j]])

    def fun(t, z, k):
        return rate * z + matrix @ z + k * z

    for k in (0.0j, 1 + 0j):
        matrix[0, 0] += 1
        expected = np.exp(rate + matrix[0, 0] + k)
        found = fastdyn.solve_ivp(fun, (0, 1), [1 + 0j], args=(k,), rtol=1e-10, atol=1e-10)
        assert abs(found.y[0, -1] - expected) < 1e-7 * abs(expected)
        rate += 1j


def in_python(t, z):
    return levels(t, z) + 0 * len(str(z[0]))


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
@pytest.mark.parametrize("vectorized", [False, True])
@pytest.mark.parametrize("method", COMPLEX)
def test_the_method_of_a_function_in_python_is_the_method_asked_for(method, vectorized):
    """The kernel of the compiled function takes the same steps, with the function in Python."""
    given = {"method": method, "vectorized": vectorized}
    given |= {"step": 0.01} if method == "RK4" else {"rtol": 1e-6, "atol": 1e-8}
    if method == "Taylor":
        with pytest.raises(ValueError, match="needs the formulas"):
            fastdyn.solve_ivp(in_python, (0, 6), START, **given)
        return
    found = fastdyn.solve_ivp(in_python, (0, 6), START, **given)
    expected = fastdyn.solve_ivp(levels, (0, 6), START, **given)
    assert found.n_accepted == expected.n_accepted
    np.testing.assert_allclose(found.y[:, -1], expected.y[:, -1], atol=1e-6)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_auto_in_python_names_the_method_that_ran():
    found = fastdyn.solve_ivp(in_python, (0, 6), START, "auto", rtol=1e-6)
    again = fastdyn.solve_ivp(in_python, (0, 6), START, found.method, rtol=1e-6)
    assert found.method == "Vern7" and np.array_equal(found.y, again.y)


@pytest.mark.parametrize("method", sorted(METHODS.keys() - COMPLEX.keys()))
def test_other_methods_refuse(method):
    """VelocityVerlet asks for a step; all say that the state is complex."""
    options = {} if METHODS[method].error_order else {"step": 0.01}
    with pytest.raises(ValueError, match="no complex"):
        fastdyn.solve_ivp(lambda t, z: 1j * z, (0, 1), [1 + 0j, 1j], method, **options)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_writes_to_the_state_are_for_scipys_methods():
    def kept_real(t, z):
        z[0] = z[0].real
        return [1j * z[0] + 0 * len(str(z[0])), -z[1]]

    given = kept_real, (0, 3), [1.0 + 0j, 1.0]
    found = fastdyn.solve_ivp(*given, "RK45", t_eval=[1.0, 3.0])
    assert_same(found, reference(*given, "RK45", t_eval=[1.0, 3.0]))
    with pytest.raises(ValueError, match="RK23, RK45, DOP853, BDF"):
        fastdyn.solve_ivp(*given, "Radau", t_eval=[1.0, 3.0])


T = np.linspace(0, 10, 201)
SAMPLES = np.array([-1j * LEVELS * np.cos(t) for t in T])
LIST = SAMPLES[:, 0, 1].tolist()
KINDS = ["linear", "nearest", "previous", "next", "zero", "quadratic", "cubic"]
OUTSIDE = [{}, {"fill_value": "extrapolate"}, {"bounds_error": False, "fill_value": 0.1j}]


def of_interpolators():
    for kind in KINDS:
        for more in OUTSIDE:
            yield interp1d(T, SAMPLES, axis=0, kind=kind, **more)
    yield interp1d(T, np.moveaxis(SAMPLES, 0, -1))
    yield interp1d(T, SAMPLES[:, 0].T)
    yield CubicSpline(T, SAMPLES)
    yield CubicSpline(T, SAMPLES).derivative()
    yield make_interp_spline(T, SAMPLES, k=3)


RECORDS = [
    lambda t, z: SAMPLES[int(t / 0.05)] @ z,
    lambda t, z: SAMPLES[-1 - int(t / 0.05)] @ z,
    lambda t, z: SAMPLES[int(t / 0.05), 0, 1] * z,
    lambda t, z: LIST[int(t / 0.05)] * z,
    lambda t, z: SAMPLES[np.searchsorted(T, t)] @ z,
    *[lambda t, z, at=at: at(t) @ z + 0 * z for at in of_interpolators()],
]


@pytest.mark.filterwarnings("error")  # it is compiled
@pytest.mark.few(8)
@pytest.mark.parametrize("fun", RECORDS)
def test_complex_records_and_interpolators_compile(fun):
    given = fun, (0, 9.9), START
    found, expected = (s(*given, max_step=0.05) for s in (fastdyn.solve_ivp, reference))
    assert_same(found, expected)


def test_options_that_once_were_for_real_states_only(tmp_path):
    seen = []

    def watch(solver):
        seen.append((solver.t, solver.y.copy(), solver.interpolate(solver.t_old)))
        return solver.t > 3

    found = fastdyn.solve_ivp(levels, (0, 6), START, "Vern9", callback=watch)
    assert found.status == 1
    assert np.array_equal([y for _, y, _ in seen], found.y.T[1:])
    np.testing.assert_allclose([y for *_, y in seen], found.y.T[:-1], atol=1e-12)
    assert 1.0 in fastdyn.solve_ivp(levels, (0, 6), START, "Vern9", breakpoints=[1.0]).t
    plain = fastdyn.solve_ivp(levels, (0, 6), START, "Vern9")
    kept = [
        fastdyn.solve_ivp(levels, (0, 6), START, "Vern9", checkpoint=tmp_path / "kept", **more)
        for more in ({"max_steps": 2}, {})
    ]
    assert kept[0].status == -1 and np.array_equal(kept[1].y[:, -1], plain.y[:, -1])
