"""Objects and functions of SciPy: followed, and never stale."""

import warnings

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
import scipy.signal
import scipy.sparse
import scipy.special
from scipy.integrate import solve_ivp as reference
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicSpline,
    RectBivariateSpline,
    interp1d,
    make_interp_spline,
)
from scipy.spatial.transform import Rotation
from scipy.stats import gaussian_kde, norm

import fastdyn

START = np.array([0.5, 0.1, -0.4, 0.7])
TIMES = np.linspace(0.0, 1.0, 9)
FIXED = Rotation.from_euler("ZYX", [0.3, 0.2, 0.1])
WAVE = np.sin(5 * TIMES)


def agrees(fun):
    """Without a warning that it runs in Python; jumps and kinks do not change equal steps."""
    steps: dict = {"first_step": 1 / 64, "max_step": 1 / 64, "atol": 1e3}
    mine = fastdyn.solve_ivp(fun, (0.0, 1.0), START, **steps)
    theirs = reference(fun, (0.0, 1.0), START, **steps)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-9)


def beside(angle, vector):
    return np.concatenate([np.asarray(vector) - angle[:3], angle[3:] * -0.1])


ROTATIONS = {
    "quaternion": lambda t, y: beside(y, Rotation.from_quat(y).apply([1.0, 0.0, t])),
    "several vectors": lambda t, y: beside(y, Rotation.from_quat(y).apply(np.eye(3) * t)[1]),
    "inverse": lambda t, y: beside(y, Rotation.from_quat(y).apply(y[:3], inverse=True)),
    "matrix": lambda t, y: beside(y, Rotation.from_quat(y).inv().as_matrix() @ y[1:]),
    "and back": lambda t, y: Rotation.from_quat(-2 * y).inv().as_quat() - y,
    "a constant": lambda t, y: beside(y, FIXED.inv().apply(y[1:])),
    "of the body": lambda t, y: beside(y, Rotation.from_euler("ZY", [y[0], t]).apply(y[1:])),
    "fixed axes": lambda t, y: beside(y, Rotation.from_euler("xyz", y[1:]).inv().as_matrix()[1]),
    "one axis": lambda t, y: beside(y, Rotation.from_euler("y", t + y[1]).apply(y[1:])),
    "degrees": lambda t, y: beside(
        y, Rotation.from_euler("xyz", 30 * y[:3], degrees=True).apply(y[:3])
    ),
    "quaternion of angles": lambda t, y: Rotation.from_euler("ZY", [y[0], t]).as_quat() - y,
    "scalar_first": lambda t, y: Rotation.from_quat(y, scalar_first=True).as_quat() - y,
    "canonical": lambda t, y: Rotation.from_quat(y).as_quat(canonical=True) - y,
    "as scalar_first": lambda t, y: Rotation.from_quat(y).as_quat(scalar_first=True) - y,
    "from a vector": lambda t, y: beside(y, Rotation.from_rotvec(t * y[:3]).as_matrix() @ y[1:]),
    "vector": lambda t, y: beside(y, Rotation.from_quat(-y).as_rotvec()),
    "short vector": lambda t, y: beside(
        y, Rotation.from_rotvec(1e-4 * y[:3]).as_rotvec(degrees=True)
    ),
    "magnitude": lambda t, y: -y * Rotation.from_quat(y).magnitude(),
    "product": lambda t, y: (Rotation.from_quat(y) * FIXED * Rotation.identity()).as_quat() - y,
}
ANGLES = "xyz ZYX zxz YXY yzx XZY".split()
LEFT_TO_PYTHON = {
    "from_mrp": lambda t, y: beside(y, Rotation.from_mrp(y[:3]).apply(y[1:])),
    "as_mrp": lambda t, y: beside(y, Rotation.from_quat(y).as_mrp()),
}
FUNCTIONS = {
    "square": lambda t, y: scipy.signal.square(7 * t + y, duty=0.3) - y,
    "sawtooth": lambda t, y: scipy.signal.sawtooth(7 * t, 0.4) - y,
    "falling": lambda t, y: scipy.signal.sawtooth(7 * t, 0) - y,
    "softmax": lambda t, y: scipy.special.softmax(y) - y,
    "logsumexp": lambda t, y: -scipy.special.logsumexp(y) * y,
    "chirp": lambda t, y: scipy.signal.chirp(t, 0.1, 10.0, 2.0) - y,
    "gausspulse": lambda t, y: scipy.signal.gausspulse(t - y, fc=2.0) - y,
    "simpson": lambda t, y: scipy.integrate.simpson(y * y, dx=0.1) - y,
    "exprel": lambda t, y: -1.0 / scipy.special.exprel(10 * y),
    "hyp1f1": lambda t, y: -scipy.special.hyp1f1(1.2, 2.3, y) * y,
}
FUNCTIONS |= {
    f"as_euler {seq}": lambda t, y, seq=seq: beside(y, Rotation.from_quat(y).as_euler(seq))
    for seq in ANGLES
}
CASES = ROTATIONS | FUNCTIONS


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("name", CASES)
def test_it_is_followed(name):
    agrees(CASES[name])


@pytest.mark.parametrize("name", LEFT_TO_PYTHON)
def test_what_a_rotation_lacks_runs_in_python(name):
    with pytest.warns(fastdyn.CompileWarning, match=r"Rotation.*test_of_scipy.py, line"):
        agrees(LEFT_TO_PYTHON[name])


def test_a_quaternion_of_no_length():
    def fun(t, y):
        return Rotation.from_quat(y * (t < 0.5)).as_quat()

    with pytest.raises(ValueError, match="zero norm"):
        fastdyn.solve_ivp(fun, (0.0, 1.0), START)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_a_quaternion_of_nan():
    """Code and function are compared at nan, too: SciPy 1.17 raises there, SciPy 1.15 does not."""

    def fun(t, y):
        turned = Rotation.from_quat(y[:4] / np.linalg.norm(y[:4]))
        return np.append(turned.as_quat(), y[:3]) - y

    fastdyn.solve_ivp(fun, (0.0, 1.0), [0.0, 0.0, 0.0, 1.0, 0.1, 0.2, 2.0])


OBJECTS = {
    "cubic": (lambda: CubicSpline(TIMES, WAVE), lambda s: s.c),
    "akima": (lambda: Akima1DInterpolator(TIMES, WAVE), lambda s: s.c),
    "b-spline": (lambda: make_interp_spline(TIMES, WAVE, k=3), lambda s: s.c),
    "columns": (lambda: interp1d(TIMES, [WAVE] * 4, kind="cubic"), lambda s: s._spline.c),
    "linear": (lambda: interp1d(TIMES, [WAVE] * 4), lambda s: s._y),
}


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("name", OBJECTS)
def test_a_table_is_read_anew(name):
    make, numbers = OBJECTS[name]
    spline = make()

    def fun(t, y):
        return spline(t) - y

    agrees(fun)
    numbers(spline)[...] *= 2.0
    agrees(fun)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_derivatives_of_a_spline():
    spline = CubicSpline(TIMES, WAVE)
    agrees(lambda t, y: spline(t, 1) + spline(t, nu=2) + spline(t, 4) - y)


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_a_sparse_matrix_is_read_anew():
    matrix = scipy.sparse.diags_array([1.0, -2.0, 1.0], offsets=[-1, 0, 1], shape=(4, 4)).tocsr()

    def fun(t, y):
        return matrix @ y

    agrees(fun)
    matrix.data *= 3.0
    agrees(fun)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_linear_system_is_read_anew():
    system = scipy.signal.TransferFunction([1.0], [1.0, 2.0, 3.0, 1.0, 0.5]).to_ss()

    def fun(t, y):
        return (system.A @ y.reshape(-1, 1) + system.B * np.sin(t)).ravel()

    agrees(fun)
    system.A = 2.0 * system.A
    agrees(fun)
    system.A *= 0.3
    agrees(fun)


def lower(array):
    array[(0,) * array.ndim] -= 0.01


WRITES = {
    "system": (
        lambda: scipy.signal.StateSpace(-np.eye(4), np.ones((4, 1)), np.eye(4), np.zeros((4, 1))),
        lambda s: lower(s.A),
        lambda s, y: s.A @ y,
    ),
    "spline": (
        lambda: CubicSpline(TIMES, WAVE),
        lambda s: lower(s.c),
        lambda s, y: y * s.c[0, 0],
    ),
    "surface": (
        lambda: RectBivariateSpline(TIMES, TIMES, np.outer(WAVE, TIMES)),
        lambda s: lower(s.tck[2]),
        lambda s, y: s.ev(y, 0.5),
    ),
    "samples": (
        lambda: gaussian_kde([1.0, 2.0, 3.0]),
        lambda s: lower(s.dataset),
        lambda s, y: s.pdf(y),
    ),
    "keywords": (
        lambda: norm(loc=1.0, scale=2.0),
        lambda s: s.kwds.update(loc=s.kwds["loc"] - 0.01),
        lambda s, y: s.pdf(y),
    ),
    "attribute": (
        lambda: gaussian_kde([1.0, 2.0, 3.0]),
        lambda s: setattr(s, "factor", s.factor - 0.01),
        lambda s, y: s.factor * y,
    ),
}


@pytest.mark.parametrize("name", WRITES)
def test_an_object_that_a_function_changes(name):
    """The function is called as often as by SciPy: a call more would change the object further."""
    make, write, value = WRITES[name]

    def fun(t, y, made):
        write(made)
        return value(made, y)

    def solved(solver):
        with warnings.catch_warnings(action="ignore"):
            return solver(fun, (0.0, 1.0), START, args=(make(),)).y

    np.testing.assert_allclose(solved(fastdyn.solve_ivp), solved(reference), rtol=1e-9)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_solver_inside_writes_nothing_to_stderr(capfd):
    def fun(t, y):
        return [-scipy.optimize.fsolve(lambda z, v=v: z + np.tanh(z) - v, 0.0)[0] for v in y]

    fastdyn.solve_ivp(fun, (0.0, 0.1), START)
    assert not capfd.readouterr().err


DIAGONALS = {
    "zeros": lambda t, y, m: np.fill_diagonal(m, 0),
    "numbers": lambda t, y, m: np.fill_diagonal(m, y),
    "of a view": lambda t, y, m: np.fill_diagonal(m[1:, 1:], t),
}


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
@pytest.mark.parametrize("name", DIAGONALS)
def test_a_diagonal_is_filled(name):
    def fun(t, y):
        m = np.outer(y, y)
        DIAGONALS[name](t, y, m)
        return m.sum(axis=1) - y

    agrees(fun)
