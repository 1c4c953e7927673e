"""Events and folds along the trajectories of an ensemble, in lanes and one by one."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, solve_ivp
from fastdyn.ensemble import Fold
from support.many import launch, orbit

TIGHT = {"rtol": 1e-8, "atol": 1e-10}

SIMD = [True, False]


def axis(t, w, GM):
    return w[1]


def apsis(t, w, GM):
    x, y, vx, vy = w
    return GM * (x * vx + y * vy)


def away(t, w, GM):
    return np.hypot(w[0], w[1]) - 1.2


away.terminal, away.direction = True, 1

apsis.direction = -1


SPEEDS = np.linspace(0.85, 1.2, 19)

MASSES = np.linspace(0.95, 1.05, 19)


@pytest.mark.parametrize(("simd", "method"), [(True, "RK45"), (True, "DOP853"), (False, "RK45")])
def test_events_are_those_of_single_solves(simd, method):
    events = [axis, apsis, away]
    many = solve_ensemble(
        orbit, (0, 30), launch(SPEEDS), (MASSES,), method, events=events, simd=simd, **TIGHT
    )
    assert not many.reason or not simd
    for i in range(19):
        one = solve_ivp(
            orbit, (0, 30), launch(SPEEDS)[i], method, args=(MASSES[i],), events=events, **TIGHT
        )
        assert many.status[i] == one.status
        for k in range(3):
            np.testing.assert_allclose(many.t_events[k][i], one.t_events[k], rtol=0, atol=1e-7)
            assert many.y_events[k][i].shape[0] == len(one.t_events[k])
    assert set(many.status) == {0, 1}  # some are stopped


def test_constant_steps_watch_events_too():
    given = {"method": "VelocityVerlet", "step": 0.01, "events": axis}
    one_by_one = solve_ensemble(orbit, (0, 12.005), launch(SPEEDS), (1.0,), simd=False, **given)
    many = solve_ensemble(orbit, (0, 12.005), launch(SPEEDS), (1.0,), simd=True, **given)
    for found, expected in zip(many.t_events[0], one_by_one.t_events[0], strict=True):
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("simd", SIMD)
def test_an_event_that_vanishes_at_the_ends_of_steps(simd):
    """Zero at the start, at a breakpoint, and where a constant step ends."""

    def ramp(t, y, k):
        return [k]

    def tick(t, y, k):
        return t - 1.0

    def start(t, y, k):
        return y[0]

    k = np.linspace(1, 2, 9)
    many = solve_ensemble(
        ramp, (0, 3), [0.0], (k,), "RK4", step=0.25, events=[tick, start], simd=simd
    )
    for i in range(9):
        one = solve_ivp(ramp, (0, 3), [0.0], "RK4", args=(k[i],), step=0.25, events=[tick, start])
        assert np.array_equal(many.t_events[0][i], one.t_events[0])
        assert np.array_equal(many.t_events[1][i], one.t_events[1])
    assert len(many.t_events[0][0]) > 0


def test_events_look_at_the_steps_that_cross_alone():
    """An event that never happens changes no bit: what is looked at alone rounds otherwise."""

    def never(t, w, GM):
        return w[0] + 100.0

    plain = solve_ensemble(orbit, (0, 30), launch(SPEEDS), (1.0,), simd=True, **TIGHT)
    watched = solve_ensemble(
        orbit, (0, 30), launch(SPEEDS), (1.0,), simd=True, events=never, **TIGHT
    )
    assert np.array_equal(plain.y_end, watched.y_end)
    assert all(len(t) == 0 for t in watched.t_events[0])


def test_events_that_may_raise_are_left_to_one_trajectory_at_a_time():
    def branching(t, w, GM):
        if w[0] > 9.0:
            raise ValueError("far away")
        if w[0] > 0:
            return w[1]
        return w[1] * 2.0

    many = solve_ensemble(orbit, (0, 9), launch(SPEEDS), (1.0,), events=branching, **TIGHT)
    assert many.width > 1 and many.reason.startswith("events and folds one by one")
    one = solve_ivp(orbit, (0, 9), launch(SPEEDS)[3], args=(1.0,), events=branching, **TIGHT)
    np.testing.assert_allclose(many.t_events[0][3], one.t_events[0], atol=1e-7)


def farthest(value, t, w, GM):
    return max(value, np.sqrt(w[0] * w[0] + w[1] * w[1]))


def steps(value, t, w, GM):
    return value + 1.0


@pytest.mark.parametrize("simd", SIMD)
def test_folds_see_the_end_of_every_step(simd):
    folds = [Fold(farthest), Fold(steps, 10.0, "count"), Fold(lambda last, t, w, GM: t, name="t")]
    many = solve_ensemble(
        orbit, (0, 30), launch(SPEEDS), (MASSES,), reduce=[*folds, "max"], simd=simd,
        events=away, **TIGHT,
    )  # fmt: skip
    assert set(many.status) == {0, 1}
    found = many.reduced
    assert list(found) == ["farthest", "count", "t", "max"]
    assert found["count"].shape == (19,)
    assert np.array_equal(found["count"], 10.0 + many.n_accepted)
    assert np.array_equal(found["t"], many.t_end)  # also where an event cut the last step
    for i in range(19):
        one = solve_ivp(orbit, (0, 30), launch(SPEEDS)[i], args=(MASSES[i],), events=away, **TIGHT)
        np.testing.assert_allclose(found["farthest"][i], np.hypot(*one.y[:2])[1:].max(), atol=1e-7)


@pytest.mark.few(1)
@pytest.mark.parametrize("simd", SIMD)
def test_folds_beside_means_projections_and_outputs(simd):
    def onto_speed(t, w, GM):
        return [w[0], w[1], w[2], w[3]]

    count = Fold(steps)
    given = (orbit, (0, 9), launch(SPEEDS), (1.0,))
    unpacked = solve_ensemble(*given, events=apsis, reduce="mean", simd=simd, **TIGHT)
    expected = solve_ensemble(*given, events=apsis, simd=simd, **TIGHT)
    for mine, its in zip(unpacked.t_events[0], expected.t_events[0], strict=True):
        np.testing.assert_allclose(mine, its, rtol=0, atol=1e-9)
    with_means = solve_ensemble(*given, reduce=[count, Fold(farthest), "mean"], simd=simd, **TIGHT)
    plain = solve_ensemble(*given, reduce=[count, Fold(farthest)], simd=simd, **TIGHT)
    assert np.array_equal(with_means.reduced["steps"], plain.reduced["steps"])
    np.testing.assert_allclose(with_means.reduced["farthest"], plain.reduced["farthest"], rtol=1e-9)
    projected = solve_ensemble(*given, reduce=count, project=onto_speed, simd=simd, **TIGHT)
    assert np.array_equal(projected.reduced["steps"], projected.n_accepted)
    sampled = solve_ensemble(*given, reduce=count, t_eval=np.linspace(0, 9, 50), simd=simd, **TIGHT)
    assert np.array_equal(sampled.reduced["steps"], plain.reduced["steps"])
    constant = solve_ensemble(
        *given, "VelocityVerlet", step=0.07, reduce=[Fold(lambda v, t, w, GM: t, name="t"), count],
        simd=simd,
    )  # fmt: skip
    assert (constant.reduced["t"] == 9.0).all() and (constant.reduced["steps"] == 129).all()


def test_folds_that_branch_that_stay_in_python_and_that_raise():
    def higher(value, t, w, GM):
        if w[0] > value:
            return w[0]
        return value

    seen = []

    def in_python(value, t, w, GM):
        seen.append(t)
        return value + 1.0

    def refuse(value, t, w, GM):
        if t > 5.0:
            raise ValueError("too late")
        return t

    given = (orbit, (0, 9), launch(SPEEDS[:5]), (1.0,))
    many = solve_ensemble(*given, reduce=Fold(higher, -9.0), **TIGHT)
    assert many.width > 1 and many.reason == ""
    one = solve_ivp(orbit, (0, 9), launch(SPEEDS)[2], args=(1.0,), **TIGHT)
    np.testing.assert_allclose(many.reduced["higher"][2], one.y[0, 1:].max(), atol=1e-7)
    with pytest.warns(match="runs in Python"):
        many = solve_ensemble(*given, reduce=Fold(in_python), **TIGHT)
    assert np.array_equal(many.reduced["in_python"], many.n_accepted)
    many = solve_ensemble(*given, reduce=Fold(refuse), **TIGHT)
    assert (many.status == -1).all() and "exception" in many.message(0)
    assert (many.reduced["refuse"] <= 5.0).all()


def test_no_thread_and_no_order_changes_a_bit():
    given = {"events": [axis], "reduce": [Fold(farthest), "first_event"], **TIGHT}
    y0 = launch(np.linspace(0.8, 1.2, 203))
    one = solve_ensemble(orbit, (0, 20), y0, (1.0,), threads=1, **given)
    two = solve_ensemble(orbit, (0, 20), y0[::-1], (1.0,), threads=2, **given)
    for name in ("farthest", "first_event"):
        assert np.array_equal(one.reduced[name], two.reduced[name][::-1])


@pytest.mark.parametrize(
    ("reduce", "said"),
    [
        ("sum", "or give a Fold"),
        (Fold(3), "function of a Fold. must be a function"),
        (Fold(steps, np.nan), "finite number"),
        ([Fold(steps), Fold(steps, 1.0)], "names steps twice"),
        ([Fold(steps, name="max"), "max"], "names max twice"),
    ],
)
def test_mistakes_are_named(reduce, said):
    with pytest.raises((TypeError, ValueError), match=said):
        solve_ensemble(orbit, (0, 1), launch(SPEEDS), (1.0,), reduce=reduce)


def test_folds_in_datasets_figures_and_stores(tmp_path):
    pytest.importorskip("xarray")
    given = {"reduce": [Fold(farthest), "max"], "block": 8, **TIGHT}
    plain = solve_ensemble(orbit, (0, 9), launch(SPEEDS), (MASSES,), **given)
    assert plain.to_xarray().farthest.dims == ("trajectory",)
    assert len(plain.plot().axes) >= 2
    pytest.importorskip("zarr")
    for _ in range(2):
        stored = solve_ensemble(
            orbit, (0, 9), launch(SPEEDS), (MASSES,), store=tmp_path / "store", **given
        )
        assert np.array_equal(stored.reduced["farthest"], plain.reduced["farthest"])
    with pytest.raises(ValueError, match="reduce"):
        given["reduce"] = [Fold(farthest, 0.5), "max"]
        solve_ensemble(orbit, (0, 9), launch(SPEEDS), (MASSES,), store=tmp_path / "store", **given)
