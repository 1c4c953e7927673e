"""LSODA: its formulas, SciPy's steps and dense output, its options, how it ends."""

from fractions import Fraction

import numpy as np
import pytest
import scipy
import scipy.integrate

from fastdyn import solve_ivp
from fastdyn.kernels.methods.lsoda import table
from support.stiff import (
    PROBLEMS,
    Problem,
    counts,
    in_other_roundings,
    robertson_jacobian,
    solved,
    spring,
    van_der_pol,
    van_der_pol_jacobian,
)

pytestmark = pytest.mark.usefixtures("nothing_is_left_to_scipy")
EPS = np.finfo(float).eps
FORMULAS = [(f, order) for f, most in enumerate(table.HIGHEST) for order in range(1, most + 1)]


def orbit(t, y):
    r = (y[0] ** 2 + y[1] ** 2) ** 1.5
    return [y[2], y[3], -y[0] / r, -y[1] / r]


def lorenz(t, y):
    return [10 * (y[1] - y[0]), y[0] * (28 - y[2]) - y[1], y[0] * y[1] - 8 / 3 * y[2]]


def logistic(t, y):
    return [y[0] * (1 - y[0])]


def chain(t, y):
    """A stiff linear system, of which the Jacobian is a lower band."""
    return [-1e4 * (y[0] - np.cos(t)), -1e3 * (y[1] - y[0]), -1e2 * (y[2] - y[1])]


def chain_jacobian(t, y):
    return [[-1e4, 0.0, 0.0], [1e3, -1e3, 0.0], [0.0, 1e2, -1e2]]


def chain_diagonals(t, y):
    return np.array([[-1e4, -1e3, -1e2], [1e3, 1e2, 0.0]])


def chain_half(t, y):
    return [[0.0, 0.0, 0.0], [-1e4, -1e3, -1e2]]


STEPPED = {
    **PROBLEMS,
    "orbit": Problem(orbit, (0, 20), [1.0, 0.0, 0.0, 1.2], {"rtol": 1e-9, "atol": 1e-9}),
    "Lorenz": Problem(lorenz, (0, 5), [1.0, 1.0, 1.0], {"rtol": 1e-6}),
    "logistic": Problem(logistic, (0, 50), [1e-3], {"rtol": 1e-7}),
    "to and fro": Problem(van_der_pol, (0, 100), [2.0, 0.0], {"rtol": 1e-6, "atol": 1e-8}, (10.0,)),
    "stiffer": Problem(van_der_pol, (0, 500), [2.0, 0.0], {"rtol": 1e-4}, (100.0,)),
    "long": PROBLEMS["Robertson"]._replace(
        t_span=(0, 4e10), options={"rtol": 1e-4, "atol": [1e-8, 1e-14, 1e-6]}
    ),
    "tolerances": Problem(spring, (0, 5), [1.0, 0.0], {"rtol": [1e-3, 1e-8]}),
    "short steps": Problem(spring, (0, 5), [1.0, 0.0], {"max_step": 0.01}),
    "long first step": Problem(spring, (0, 5), [1.0, 0.0], {"first_step": 4.0}),
    "chain": Problem(chain, (0, 5), [1.0, 0.0, 0.0], {}),
    "band": Problem(chain, (0, 5), [1.0, 0.0, 0.0], {"lband": 1}),
    "wider": Problem(chain, (0, 5), [1.0, 0.0, 0.0], {"lband": 1, "uband": 1}),
    "heat, band": PROBLEMS["heat"]._replace(
        options={**PROBLEMS["heat"].options, "lband": 1, "uband": 1}
    ),
}  # fmt: skip


def at(polynomial, x):
    return sum(a * Fraction(x) ** j for j, a in enumerate(polynomial))


@pytest.mark.parametrize("family, order", FORMULAS)
def test_corrections_leave_the_past_as_it_is(family, order):
    """Values before of BDF; the last one, and derivatives, of Adams' formulas."""
    found = table.correction(family, order)
    slope = [j * a for j, a in enumerate(found)][1:]
    assert slope[0] == 1 and at(found, -1) == 0 and len(found) == order + 1
    others = found if family == table.BDF else slope
    assert all(at(others, -j) == 0 for j in range(1, order + (family == table.BDF)))


@pytest.mark.parametrize("family, order", FORMULAS)
def test_constants_are_those_of_the_formulas(family, order):
    """The error of the formula in x^(order + 1) / (order + 1)!, of which it has the exact past."""
    zeros = range(order) if family == table.ADAMS else range(order + 1)
    rest = [Fraction(1)]  # the polynomial with these zeros, negated
    for root in zeros:
        rest = [root * a + b for a, b in zip([*rest, 0], [0, *rest], strict=True)]
    if family == table.ADAMS:  # what the derivatives at 0, -1, ... miss, from -1 to 0
        error = -sum(a * Fraction(-1) ** (j + 1) / (j + 1) for j, a in enumerate(rest)) / (
            table.math.factorial(order)
        )
    else:  # what the slope at 0 of the polynomial through 0, -1, ... misses
        error = rest[1] / table.math.factorial(order + 1)
    assert abs(error) == table.constant(family, order)


@pytest.mark.parametrize("name", STEPPED)
def test_steps_are_scipys(name):
    """As near as SciPy is to itself in other roundings, differences for differences.

    What SciPy takes in one of thirty roundings is drawn by 100 in all but a thirtieth of cases.
    """
    p = STEPPED[name]
    theirs = solved(scipy.integrate.solve_ivp, p, "LSODA")
    ours = solved(solve_ivp, p, "LSODA", jac="2-point")
    runs = [theirs]
    for seed in range(100):
        runs.append(solved(scipy.integrate.solve_ivp, in_other_roundings(p, seed), "LSODA"))
        if seed >= 2 and counts(ours) in map(counts, runs):
            break
    assert counts(ours) in map(counts, runs)
    t, *others = [run.t for run in runs if len(run.t) == len(ours.t)]
    apart = max(np.abs(other - t).max() for other in others)
    assert np.abs(ours.t - t).max() <= 30 * apart + 4 * EPS * np.abs(t).max()


def test_steps_too_short_to_change_the_time_go_on_while_they_grow():
    def fun(t, y):
        return [1e50 / y[0]]

    found, theirs = (
        solver(fun, (1, 2), [1e6], method="LSODA")
        for solver in (solve_ivp, scipy.integrate.solve_ivp)
    )
    assert found.status == 0 and found.nfev == theirs.nfev and (found.t[:300] == 1.0).all()
    assert found.y[0, -1] == pytest.approx(theirs.y[0, -1], rel=1e-9)
    # The exact solution, of which each step has an error of 1e-3 at most.
    assert found.y[0, -1] == pytest.approx(np.sqrt(1e12 + 2e50), rel=2e-3)


def test_steps_at_a_blow_up_end():
    found = solve_ivp(lambda t, y: [y[0] ** 2], (0, 2), [1.0], method="LSODA")
    assert found.status == -1 and found.t[-1] == pytest.approx(1.0, abs=1e-2)


@pytest.mark.parametrize(
    "name, jacobian",
    [("Robertson", robertson_jacobian), ("stiffer", van_der_pol_jacobian),
     ("chain", chain_jacobian),
     pytest.param("band", chain_diagonals, marks=pytest.mark.skipif(
         tuple(map(int, scipy.__version__.split(".")[:2])) < (1, 17),
         reason="the Fortran code of earlier SciPy takes no Jacobian as diagonals"))],
)  # fmt: skip
def test_exact_jacobians_are_as_those_that_scipy_is_given(name, jacobian):
    p = STEPPED[name]
    theirs = solved(scipy.integrate.solve_ivp, p, "LSODA", jac=jacobian)
    for ours in (solved(solve_ivp, p, "LSODA"), solved(solve_ivp, p, "LSODA", jac=jacobian)):
        assert counts(ours) == counts(theirs)


@pytest.mark.filterwarnings("ignore:`jac` is not the Jacobian")
@pytest.mark.parametrize("given", [{}, {"jac": chain_half}])
def test_entries_outside_of_a_band_are_left_out(given):
    """A short run: Newton's iteration with a wrong Jacobian magnifies rounding."""
    p = Problem(chain, (0, 0.01), [1.0, 0.0, 0.0], {"uband": 1})
    theirs = solved(scipy.integrate.solve_ivp, p, "LSODA", jac=chain_half)
    ours = solved(solve_ivp, p, "LSODA", **given)
    assert counts(ours) == counts(theirs) and theirs.njev == 4


@pytest.mark.parametrize("name", ["Lorenz", "to and fro", "orbit", "back"])
def test_dense_output_is_scipys(name):
    """Inside the steps, to what rounding has made of the steps, 1e-9 of the state at most."""
    p = STEPPED[name]
    theirs = solved(scipy.integrate.solve_ivp, p, "LSODA", dense_output=True)
    ours = solved(solve_ivp, p, "LSODA", dense_output=True, jac="2-point")
    inside = 0.3 * theirs.t[1:] + 0.7 * theirs.t[:-1]
    size = np.abs(theirs.y).max(1, keepdims=True)
    assert (np.abs(ours.sol(inside) - theirs.sol(inside)) <= 1e-9 * size).all()
    assert (np.abs(ours.sol(ours.t) - ours.y) <= 2 * EPS * size).all()
    times = solved(solve_ivp, p, "LSODA", t_eval=inside, jac="2-point")
    assert np.array_equal(times.y, ours.sol(inside))


def test_the_shortest_step():
    """SciPy 1.17 does not look at `min_step`; SciPy 1.15 takes 31 steps, and gives up, too."""
    run = solve_ivp(spring, (0, 5), [1.0, 0.0], "LSODA", min_step=0.5)
    assert run.status == -1 and (len(run.t), run.nfev) == (32, 65)
    assert "`min_step=0.5` is too long" in run.message


@pytest.mark.parametrize(
    "options, sentence",
    [
        ({"min_step": -1.0}, "`min_step` must be nonnegative"),
        ({"lband": -1}, "must not be negative"),
        ({"lband": 1, "uband": 1, "jac": chain_diagonals}, r"shape \(3, 3\).*has \(2, 3\)"),
    ],
)
def test_wrong_options_get_a_sentence(options, sentence):
    given = {"fun": chain, "t_span": (0, 1), "y0": [1.0, 0.0, 0.0], "method": "LSODA"}
    with pytest.raises(ValueError, match=sentence):
        solve_ivp(**{**given, **options})


@pytest.mark.parametrize(
    "fun, t_end, sentence",
    [
        (lambda t, y: [y[0] ** 2], 1.0, "blows up"),
        (lambda t, y: [np.sqrt(1.0 - t)], 1.0, "nan or inf at all times after t = 1"),
        (lambda t, y: [np.nan * y[0]], 0.0, "nan or inf at the start"),
    ],
)
def test_what_scipy_never_ends_or_takes_for_a_solution_fails(fun, t_end, sentence):
    """SciPy stands still, or returns NaN as a success.

    An error e of a step, at most 1e-6 + 1e-8 y, delays the blow-up of y by e / y^2.
    """
    run = solve_ivp(fun, (0, 2), [1.0], "LSODA", rtol=1e-8)
    assert run.status == -1 and sentence in run.message
    assert abs(run.t[-1] - t_end) <= len(run.t) * 1.01e-6 and np.isfinite(run.y).all()


def test_a_component_without_a_tolerance_on_the_way():
    run = solve_ivp(
        spring, (0, 9), [1.0, 0.5], "LSODA", atol=0.0, events=lambda t, y: y[1] + 0.5,
        on_event=lambda t, y: [y[0], 0.0],
    )  # fmt: skip
    assert run.status == -1 and "Unexpected istate in LSODA" in run.message
    assert "positive `atol`" in run.message


def test_first_steps_that_do_not_change_the_time():
    """The pressure in a star falls by 1e27 a centimetre at first, which is little of 1e38."""

    def star(r, y):
        pressure, mass = y
        density = (pressure / 5.4e12) ** 0.6
        inner = mass + 4 * np.pi * r**3 * pressure / 9e20
        slope = -6.674e-8 * (density + pressure / 9e20) * inner / (r * (r - 1.5e-28 * mass))
        return [slope, 4 * np.pi * r**2 * density]

    given = star, (1.0, 3e6), [6.6e37, 0.0], "LSODA"
    mine, theirs = (f(*given, rtol=1e-6) for f in (solve_ivp, scipy.integrate.solve_ivp))
    assert theirs.t[1] == 1.0
    assert mine.nfev == theirs.nfev and len(mine.t) == len(theirs.t)
    np.testing.assert_allclose(mine.y[:, -1], theirs.y[:, -1], rtol=1e-6)


@pytest.mark.parametrize("span", [(1.0, 1.0 + EPS), (0.0, 1e-300), (1.0, 1.0 - 8 * EPS)])
def test_spans_of_a_few_roundings(span):
    run = solve_ivp(spring, span, [1.0, 0.0], "LSODA")
    assert run.success and run.t[-1] == span[1] and np.allclose(run.y[:, -1], [1, 0], atol=1e-14)


def test_behind_a_breakpoint_it_begins_anew():
    """With the first step, order and family of a run of its own, to the rounding of its start."""
    given = {"method": "LSODA", "args": (1e3,), "rtol": 1e-5, "first_step": 1e-3}
    whole = solve_ivp(van_der_pol, (0, 20), [2.0, 0.0], breakpoints=[10.0], **given)
    i = int(np.searchsorted(whole.t, 10.0))
    alone = solve_ivp(van_der_pol, (10, 20), whole.y[:, i], **given)
    assert whole.njev > alone.njev > 0 and len(whole.t) == i + len(alone.t)
    assert np.allclose(np.diff(whole.t[i : i + 9]), np.diff(alone.t[:9]), rtol=1e-6, atol=0)
