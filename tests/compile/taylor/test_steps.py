"""Taylor: its loop over steps."""

import math

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from support.motions import satellite
from support.steppers import ended

EPS = np.finfo(float).eps


def perihelion(e):
    return [1.0 - e, 0.0, 0.0, math.sqrt((1.0 + e) / (1.0 - e))]


def energy(w):
    return (w[2] ** 2 + w[3] ** 2) / 2 - 1 / np.hypot(w[0], w[1])


@pytest.mark.parametrize("tol", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_errors_follow_the_tolerance(tol):
    """An orbit of e = 0.3: each step errs by the tolerance at most, which grows with the time."""
    run = solve_ivp(satellite, (0.0, 2 * math.pi), perihelion(0.3), "Taylor", rtol=tol, atol=tol)
    far = np.abs(run.y[:, -1] - perihelion(0.3)).max()
    assert tol / 1000 < far < 3 * 2 * math.pi * run.n_accepted * tol


def test_between_steps():
    t = np.linspace(0.0, 20.0, 5001)
    options = {"rtol": 1e-12, "atol": 1e-12}
    run = solve_ivp(satellite, (0, 20), perihelion(0.5), "Taylor", dense_output=True, **options)
    at = solve_ivp(satellite, (0, 20), perihelion(0.5), "Taylor", t_eval=t, **options)
    assert np.abs(run.sol(t) - at.y).max() < 1e-13
    assert np.abs(energy(at.y) - energy(at.y[:, 0])).max() < 1e-11  # also inside the steps
    assert np.abs(run.sol(run.t) - run.y).max() < 4 * EPS


@pytest.mark.parametrize("reach", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("pace", [1e-12, 1.0, 1e12])
def test_units_do_not_matter(reach, pace):
    """Coefficients of order 25 would overflow, or vanish."""

    def fun(t, y, k):
        return [y[1], -k * y[0]]

    run = solve_ivp(
        fun, (0.0, 5.0 * pace), [reach, 0.0], "Taylor", args=(pace**-2,), rtol=1e-10,
        atol=[1e-10 * reach, 1e-10 * reach / pace],
    )  # fmt: skip
    assert run.status == 0 and run.n_accepted < 20
    assert abs(run.y[0, -1] / reach - math.cos(5.0)) < 1e-9


@pytest.mark.parametrize(("tol", "order"), [(1e-3, 13), (1e-6, 17), (1e-10, 25)])
@pytest.mark.parametrize("n", [1, 4, 6])
def test_between_steps_the_polynomial_is_the_series(tol, order, n):
    """Of y' = y^2; the polynomials have a row for each order, and no more."""

    def square(t, y):
        return y * y

    y0 = np.linspace(0.5, 1.0, n)
    run = solve_ivp(square, (0.0, 0.75), y0, "Taylor", rtol=tol, atol=tol, dense_output=True)
    assert run.sol.polynomials.shape == (run.n_accepted, order + 1, n)
    (start, h), *_ = run.sol.spans
    for x in np.linspace(0.0, h, 7):
        series = y0 * ((y0[:, None] * x).T ** np.arange(order + 1)[:, None]).sum(axis=0)
        # A sum of positive terms: each of the few roundings of each order is at most half an ulp.
        bound = 4 * order * np.finfo(float).eps * series
        assert (abs(run.sol(start + x) - series) <= bound).all()


def test_polynomials_and_gaps():
    run = solve_ivp(lambda t, y: [3 * t * t], (-1.0, 2.0), [-1.0], "Taylor", rtol=1e-9, atol=1e-9)
    assert run.y[0, -1] == pytest.approx(8.0, rel=4 * EPS)
    run = solve_ivp(lambda t, y: [t**3 * y[0]], (0, 2), [1.0], "Taylor", rtol=1e-10, atol=1e-10)
    assert abs(run.y[0, -1] / math.exp(4.0) - 1) < 1e-8
    run = solve_ivp(lambda t, y: [0.0 * y[0]], (0.0, 1e9), [3.0], "Taylor")
    assert run.y[0, -1] == 3.0


def test_a_blow_up_ends_with_the_last_finite_state():
    run = solve_ivp(lambda t, y: [y[0] ** 2], (0.0, 2.0), [1.0], "Taylor", rtol=1e-9, atol=1e-9)
    assert run.status == -1 and abs(run.t[-1] - 1.0) < 1e-6
    assert np.isfinite(run.y).all() and run.y[0, -1] > 1e6
    assert "blows up" in run.message


def test_limits_of_steps():
    run = solve_ivp(satellite, (0, 3), perihelion(0.1), "Taylor", max_step=0.125, first_step=0.0625)
    assert run.t[1] == 0.0625 and np.diff(run.t).max() == 0.125 and run.t[-1] == 3.0


def test_there_and_back():
    options = {"method": "Taylor", "rtol": 1e-13, "atol": 1e-13}
    there = solve_ivp(satellite, (0.0, 30.0), perihelion(0.6), **options)
    back = solve_ivp(satellite, (30.0, 0.0), there.y[:, -1], **options)
    assert np.abs(back.y[:, -1] - perihelion(0.6)).max() < 1e-9


def test_bits_do_not_depend_on_chunks(tmp_path):
    options = {"method": "Taylor", "rtol": 1e-11, "atol": 1e-11}
    whole = solve_ivp(satellite, (0.0, 100.0), perihelion(0.7), **options)
    stepper = ended(fastdyn.Stepper(satellite, 0.0, perihelion(0.7), 100.0, **options))
    assert np.array_equal(stepper.y, whole.y[:, -1]) and stepper.nstep == whole.n_accepted
    at_end = solve_ivp(satellite, (0.0, 100.0), perihelion(0.7), t_eval=[100.0], **options)
    assert np.array_equal(at_end.y[:, -1], whole.y[:, -1])
    file = tmp_path / "run"
    solve_ivp(satellite, (0, 100), perihelion(0.7), checkpoint=file, max_steps=50, **options)
    resumed = solve_ivp(satellite, (0.0, 100.0), perihelion(0.7), checkpoint=file, **options)
    assert np.array_equal(resumed.y, whole.y)


@pytest.mark.parametrize("e", [0.0, 0.3001, 0.4, 0.6])
def test_the_energy_walks_at_round_off(e):
    """Each step is rounded by chance, also where as many steps as orbits make a whole number."""
    end = 30_000 * 2 * math.pi
    run = solve_ivp(
        satellite, (0, end), perihelion(e), "Taylor", rtol=2.3e-16, atol=2.3e-16, t_eval=[end]
    )
    drift = abs(energy(run.y[:, -1]) / energy(np.array(perihelion(e))) - 1)
    assert drift < 4 * EPS * math.sqrt(run.n_accepted)


def test_other_systems_of_units_of_tolerance():
    """By component: what has a loose tolerance does not shorten the steps."""

    def fun(t, y):
        return [y[1], -y[0], 50.0 * y[3], -50.0 * y[2]]

    start = [1.0, 0.0, 1e-3, 0.0]
    both = solve_ivp(fun, (0, 10), start, "Taylor", rtol=1e-15, atol=[1e-9] * 4)
    one = solve_ivp(fun, (0, 10), start, "Taylor", rtol=1e-15, atol=[1e-9, 1e-9, 1.0, 1.0])
    assert one.n_accepted < 0.6 * both.n_accepted


def test_refusals_say_what_to_do():
    count = [0]

    def counted(t, y):
        count[0] += 1
        return [-y[0]]

    with pytest.raises(NameError, match="unheard_of"):
        solve_ivp(lambda t, y: [unheard_of], (0, 1), [1.0], "Taylor")  # noqa: F821
    with pytest.raises(ValueError, match=r"Taylor needs the formulas.*Vern9"):
        solve_ivp(counted, (0, 1), [1.0], "Taylor")
    with pytest.raises(ValueError, match=r"rounding to a whole number.*Vern9"):
        solve_ivp(lambda t, y: [np.floor(y[0])], (0, 1), [1.0], "Taylor")


def rubbing(steep, n=1):
    """Oscillators with dry friction, nearly."""

    def fun(t, y):
        x, v = y[:n], y[n:]
        return np.concatenate([v, -x - 0.1 * np.tanh(v / steep)])

    return fun


@pytest.mark.parametrize("steep", [1e-2, 1e-3])
@pytest.mark.parametrize("how", ["alone", "among many", "in lanes"])
def test_a_transition_that_no_series_sees_from_afar(how, steep):
    """tanh(v / steep) is 1 to rounding where a step begins; the function there tells."""
    start, span, options = [1.0, 0.3], (0.0, 8.0), {"rtol": 1e-10, "atol": 1e-12}
    same = solve_ivp(rubbing(steep), span, start, "DOP853", rtol=1e-13, atol=1e-14)
    if how == "in lanes":
        run = fastdyn.solve_ensemble(rubbing(steep), span, [start] * 9, method="Taylor", **options)
        assert run.width > 1
        found = run.y_end
    else:
        n = 1 if how == "alone" else 40
        run = solve_ivp(rubbing(steep, n), span, np.repeat(start, n), "Taylor", **options)
        assert run.n_accepted < 1000
        found = run.y[:, -1].reshape(2, n).T
    assert np.abs(found - same.y[:, -1]).max() < 1e-8


@pytest.mark.parametrize(
    ("fun", "end", "exact"),
    [
        (lambda t, y: [math.cos(t**5)], 1.5, 0.90958335240), (lambda t, y: [t**40], 1.0, 1 / 41),
        (lambda t, y: [math.sin(t) ** 30], 3.0, 0.4538484488),
    ],
)  # fmt: skip
def test_series_with_long_gaps(fun, end, exact):
    run = solve_ivp(fun, (0.0, end), [0.0], "Taylor", rtol=1e-12, atol=1e-14)
    assert abs(run.y[0, -1] - exact) < 1e-9


@pytest.mark.parametrize(
    ("fun", "y0", "end"),
    [
        (lambda t, y: [-1 / y[0]], [1.0], "0.5000"),
        (lambda t, y: [-np.sign(y[0] - 0.3) - 0.5, -100 * (y[1] - y[0])], [1.0, 0.0], "0.4666"),
    ],
)
def test_to_and_fro_about_a_singularity_ends(fun, y0, end):
    """The state comes to y = 0, or y = 0.3, and both sides drive it back there."""
    run = solve_ivp(fun, (0.0, 2.0), y0, "Taylor", rtol=1e-6, atol=1e-8, t_eval=[2.0])
    assert run.status == -1 and f"At t = {end}" in run.message
    assert "a singularity or a jump" in run.message
