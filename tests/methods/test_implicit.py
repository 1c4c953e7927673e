"""Radau and BDF: SciPy's steps, its counts, its dense output; and what LSODA has in common."""

import numpy as np
import pytest
import scipy.integrate
import scipy.sparse

import fastdyn
from bench.problems.stiff import STIFF
from fastdyn import solve_ivp
from support.stiff import (
    PROBLEMS,
    counts,
    in_other_roundings,
    solved,
    van_der_pol,
    van_der_pol_jacobian,
)

pytestmark = pytest.mark.usefixtures("nothing_is_left_to_scipy")
METHODS = ("Radau", "BDF")
RESUMED = (*METHODS, "LSODA")  # whose own tests are in test_lsoda.py
EPS = np.finfo(float).eps


@pytest.mark.few(5)
@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("method", METHODS)
def test_steps_are_scipys(method, name):
    """As near as SciPy is to itself in other roundings, where it takes as many steps."""
    p = PROBLEMS[name]
    theirs = solved(scipy.integrate.solve_ivp, p, method)
    others = [
        solved(scipy.integrate.solve_ivp, in_other_roundings(p, seed), method) for seed in range(3)
    ]
    assert {counts(other) for other in others} == {counts(theirs)}
    apart = max(np.abs(other.t - theirs.t).max() for other in others)
    ours = solved(solve_ivp, p, method, jac="2-point")
    assert counts(ours) == counts(theirs)
    assert np.abs(ours.t - theirs.t).max() <= 30 * apart + 4 * EPS * np.abs(theirs.t).max()
    assert counts(solved(solve_ivp, p, method)) == counts(theirs)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["heat", "spring"])
def test_dense_output_is_scipys(method, name):
    """Inside the steps, to what 1e-8 in the Jacobian, by differences or exact, makes of it."""
    p = PROBLEMS[name]
    theirs = solved(scipy.integrate.solve_ivp, p, method, dense_output=True)
    ours = solved(solve_ivp, p, method, dense_output=True)
    inside = (theirs.t[1:] + theirs.t[:-1]) / 2
    size = np.abs(theirs.y).max(1, keepdims=True)
    assert (np.abs(ours.sol(inside) - theirs.sol(inside)) <= 1e-8 * size).all()
    assert (np.abs(ours.sol(ours.t) - ours.y) <= 2 * EPS * size).all()
    at = solved(solve_ivp, p, method, t_eval=ours.t[2:9])
    assert np.array_equal(at.y, ours.sol(at.t))


@pytest.mark.parametrize(
    "name, method",
    [
        *(("pollution", method) for method in (*METHODS, "Rodas5P")),
        *(("E5", method) for method in METHODS),
    ],
)
def test_published_ends_are_reached(name, method):
    """A step adds rtol at most, relative to the state then, and the problem amplifies none of it,
    except that a rounding of y2 in E5 stays in y2 - y3 - y4, absolute, while y2 decays."""
    (stiff,) = [s for s in STIFF if s.problem.name == name]
    p, rtol, end = stiff.problem, 1e-7, np.array(stiff.end)
    run = solve_ivp(p.fun, p.t_span, p.y0, method, rtol=rtol, atol=rtol * stiff.floor)
    kept = EPS * run.y[1].max() / end[1] if name == "E5" else 0.0
    size = np.maximum(np.abs(end), stiff.floor)
    assert run.status == 0
    assert (np.abs(run.y[:, -1] - end) / size).max() < len(run.t) * (rtol + kept)


@pytest.mark.parametrize("method", METHODS)
def test_what_fails_in_scipy_fails_here(method):
    def explodes(t, y):
        return [y[0] ** 2]

    given = (explodes, (0, 2), [1.0], method)
    theirs, ours = (f(*given, rtol=1e-6) for f in (scipy.integrate.solve_ivp, solve_ivp))
    assert ours.status == theirs.status == -1 and theirs.message in ours.message
    assert abs(ours.t[-1] - theirs.t[-1]) < 1e-5


@pytest.mark.parametrize("method", RESUMED)
def test_checkpoints_hold_all_that_is_kept(method, tmp_path, monkeypatch):
    p = PROBLEMS["van der Pol"]
    whole = solved(solve_ivp, p, method)
    monkeypatch.setattr(fastdyn.run.loop, "CHUNK_SECONDS", 0.0)
    path, looks = tmp_path / "run.npz", []

    def interrupted(self):
        looks.append(self)
        if len(looks) == 100:
            raise KeyboardInterrupt
        return False

    monkeypatch.setattr(fastdyn.run.checkpoint.Checkpoint, "due", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solved(solve_ivp, p, method, checkpoint=path)
    again = solved(solve_ivp, p, method, checkpoint=path)
    assert np.array_equal(again.y, whole.y) and counts(again) == counts(whole)


@pytest.mark.few(1)
@pytest.mark.parametrize("method", RESUMED)
def test_ensembles_and_prepared_solvers_take_the_same_steps(method):
    mus = np.array([10.0, 100.0, 1000.0])
    options = {"rtol": 1e-5, "jac": van_der_pol_jacobian}
    given = (van_der_pol, (0, 20), [2.0, 0.0])
    alone = [solve_ivp(*given, method, args=(mu,), **options) for mu in mus]
    many = fastdyn.solve_ensemble(*given, (mus,), method, **options)
    solver = fastdyn.prepare(*given, method, args=(1.0,), **options)
    for i, run in enumerate(alone):
        assert np.array_equal(many.y_end[i], run.y[:, -1]) and many.nfev[i] == run.nfev
        assert np.array_equal(solver(args=(mus[i],)).y, run.y)


@pytest.mark.parametrize("method", RESUMED)
def test_events_end_a_stiff_run(method):
    def crossing(t, y, mu):
        return y[0]

    crossing.terminal = True
    p = PROBLEMS["van der Pol"]
    theirs, ours = (
        solved(f, p, method, events=crossing) for f in (scipy.integrate.solve_ivp, solve_ivp)
    )
    assert ours.status == theirs.status == 1
    assert ours.t_events[0] == pytest.approx(theirs.t_events[0], rel=1e-4)
