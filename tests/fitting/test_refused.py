"""What a fit refuses, each in a sentence; threads and repeated calls."""

import concurrent.futures

import numpy as np
import pytest

from fastdyn import Free, Record, fit
from fastdyn.systems.pendulum import Pendulum
from support.fits import KNOWN

T = np.linspace(0.0, 2.0, 5)
V = np.exp(-T)


def decay(t, y, rate):
    return [-rate * y[0]]


@pytest.mark.parametrize(
    ("make", "kind", "said"),
    [
        (lambda: Free(True), TypeError, "real numbers; got True"),
        (lambda: Free("1"), TypeError, "real numbers; got '1'"),
        (lambda: Free(1j), TypeError, "real numbers"),
        (lambda: Free([1.0, [2.0]]), TypeError, "real numbers"),
        (lambda: Free(None), TypeError, "real numbers"),
        (lambda: Free(np.nan), ValueError, "finite numbers; got nan"),
        (lambda: Free([]), ValueError, "finite numbers"),
        (lambda: Free(3.0, low=0, high=2), ValueError, r"start 3.0 .* outside of its bounds 0 and"),
        (lambda: Free([1.0, 3.0], high=2), ValueError, "outside of its bounds"),
        (lambda: Free(1.0, low=2, high=0), ValueError, "low < high; got low=2, high=0"),
        (lambda: Free(1.0, low=1, high=1), ValueError, "low < high"),
        (lambda: Free(1.0, low=np.nan), ValueError, "`low` of a Free is nan"),
        (lambda: Free(1.0, low=[0, 0]), ValueError, r"shape of its start, \(\); got \(2,\)"),
        (lambda: Free(1.0, name=3), TypeError, "must be text"),
        (lambda: Free(1.0, prior=2.0), ValueError, r"\(mean, standard deviation\); got 2.0"),
        (lambda: Free(1.0, prior=(1.0, 0.0)), ValueError, "above 0"),
    ],
)
def test_a_wrong_free(make, kind, said):
    with pytest.raises(kind, match=said):
        make()


@pytest.mark.parametrize(
    ("given", "kind", "said"),
    [
        ({"values": V[:4]}, ValueError, r"shape \(n_series, 5\).* got \(4,\)"),
        ({"values": np.ones((5, 2))}, ValueError, "a column for each time"),
        ({"values": np.ones((5, 1))}, ValueError, r"got \(5, 1\): give values.T"),
        ({"name": 3}, TypeError, "`name` of a Record must be text"),
        ({"t0": Free(0.5)}, ValueError, "`t0` = 0.5 is after the first time, 0"),
        ({"values": np.ones((1, 1, 5))}, ValueError, "a column for each time"),
        ({"values": np.ones((2, 5))}, ValueError, "2 series, and the state has 1"),
        ({"values": np.full(5, np.nan)}, ValueError, "all of `values` are nan"),
        ({"values": np.r_[V[:4], np.inf]}, ValueError, "finite, or nan"),
        ({"values": ["a"] * 5}, TypeError, "`values` must be real numbers"),
        ({"values": V + 0j}, TypeError, "`values` must be real numbers"),
        ({"t": [0, 1, np.nan, 2, 3]}, ValueError, "`t` must be finite times"),
        ({"t": 1.0}, ValueError, "`t` must be finite times"),
        ({"t": [], "values": []}, ValueError, "`t` must be finite times"),
        ({"t": np.zeros(5)}, ValueError, "needs a time after `t0`"),
        ({"t0": 1.0}, ValueError, "`t0` = 1 is after the first time, 0"),
        ({"t0": np.nan}, ValueError, "`t0` must be a finite number"),
        ({"y0": []}, TypeError, "`y0` must be real numbers"),
        ({"y0": [1j]}, TypeError, "`y0` must be real numbers"),
        ({"y0": Free(1.0)}, ValueError, "give a list"),
        ({"args": 3.0}, TypeError, r"`args` must be a tuple, such as \(x,\)"),
        ({"noise": 0.0}, ValueError, "above 0"),
        ({"noise": [0.1, 0.1]}, ValueError, "one for each of the 5 times"),
        ({"noise": np.r_[0.1, 0.1, np.nan, 0.1, 0.1]}, ValueError, "finite standard deviations"),
        ({"noise": "normal"}, ValueError, "`noise='normal'` is unknown"),
        ({"noise": "poisson"}, ValueError, "the value 0.606531, and .* is for counts"),
        ({"observed": 1}, ValueError, "components 0 to 0 of the state; got 1"),
        ({"observed": "y"}, ValueError, "or a function"),
        ({"observed": [[1.0, 0.0]]}, ValueError, r"a matrix \(n_series, 1\)"),
        ({"observed": [0, 0]}, ValueError, "1 series, and `observed` names 2"),
    ],
)
def test_a_wrong_record(given, kind, said):
    with pytest.raises(kind, match=said):
        Record(**{"t": T, "values": V, "y0": [1.0], "args": (Free(1.0),), **given})


def record(*args, y0=(1.0,), **more):
    return Record(T, V, y0, args or (Free(0.5),), **{"noise": 0.1, **more})


@pytest.mark.parametrize(
    ("call", "kind", "said"),
    [
        (lambda: fit(decay, record(1.0)), ValueError, "nothing to fit: put `Free"),
        (lambda: fit(decay, []), TypeError, "`records` must be a Record"),
        (lambda: fit(decay, [T, V]), TypeError, "`records` must be a Record"),
        (lambda: fit(decay, T, V, [0.5]), TypeError, r"fit\(fun, Record\(t, values, y0, args\)\)"),
        (lambda: fit(decay, record(), loss="hubr"), ValueError, "did you mean `huber`"),
        (lambda: fit(decay, record(), loss="huber", f_scale=0), ValueError, "`f_scale` must be"),
        (lambda: fit(decay, record(Free(1.0, prior=(1, 1))), loss="huber"), ValueError, "priors"),
        (lambda: fit(decay, Record(T, V)), TypeError, "without `y0`.* is for a system"),
        (lambda: fit(Pendulum, record()), TypeError, r"give a system, Pendulum\(\), not its class"),
        (
            lambda: fit(Pendulum(), Record(T, V, args={"mas": Free(1.0)}, observed=0)),
            ValueError,
            "has no parameter 'mas'; choose from",
        ),
        (
            lambda: fit(Pendulum(), Record(T, V, args={"m": Free(1.0)}, observed="x")),
            ValueError,
            "has no component 'x'; choose from",
        ),
        (lambda: fit(None, record()), TypeError, "`fun` must be a function"),
        (lambda: fit(decay, record(), level=95), ValueError, "between 0 and 1; got 95"),
        (lambda: fit(decay, record(), level="95%"), TypeError, "between 0 and 1"),
        (lambda: fit(decay, record(), max_nfev=0), ValueError, "at least 1; got 0"),
        (lambda: fit(decay, record(), starts=0), ValueError, "at least 1; got 0"),
        (lambda: fit(decay, record(), starts=[[1.0, 2.0]]), ValueError, r"shape \(m, 1\)"),
        (lambda: fit(decay, record(), starts=[["a"]]), ValueError, r"shape \(m, 1\)"),
        (lambda: fit(decay, record(Free(0.5, low=0)), starts=[[-1.0]]), ValueError, "outside"),
        (lambda: fit(decay, record(), t_eval=T), TypeError, "`t_eval` is no option here"),
        (lambda: fit(decay, record(), method="RK54"), ValueError, "RK54"),
        (lambda: fit(decay, record([Free(1.0), [2.0]])), ValueError, "lists of unequal lengths"),
        (lambda: fit(decay, record([Free([1.0]), 2.0])), ValueError, "within a list, give numbers"),
        (lambda: fit(decay, record([Free(1.0), "a"])), TypeError, "stands beside a Free"),
        (
            lambda: fit(decay, [record(Free(1.0, name="a"), y0=[Free(1.0, name="a")])]),
            ValueError,
            "Two parameters are called 'a'",
        ),
        (
            lambda: fit(decay, Record(T[:2], V[:2], [Free(1.0)], (Free(1.0),))),
            ValueError,
            "2 values cannot determine 2 parameters and the noise",
        ),
        (
            lambda: fit(decay, record(observed=lambda t, y, rate: [y[0], rate])),
            ValueError,
            "`observed` must return 1 real numbers",
        ),
        (
            lambda: fit(decay, record(observed=lambda t, y, rate: y[0] + 0j)),
            ValueError,
            "`observed` must return 1 real numbers",
        ),
        (
            lambda: fit(lambda t, y, n: [-y[0] * n for _ in range(n)], record()),
            TypeError,
            "integer",
        ),
    ],
)
def test_a_wrong_fit(call, kind, said):
    with pytest.raises(kind, match=said):
        call()


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("rtoll", "`fit` takes no `rtoll`; did you mean `rtol`"),
        ("start", "did you mean `starts`"),
        ("discrete", "states that only events change"),
        ("callback", "a fit takes many solves"),
    ],
)
def test_options_that_are_none_are_refused_before_the_first_solve(option, said):
    def never(t, y, rate):
        raise AssertionError

    with pytest.raises(TypeError, match=said):
        fit(never, record(), **{option: 1.0})


def test_a_time_of_switching_is_fitted_by_differences():
    def switched(t, y, begin):
        return [1.0 * (t > begin) - 0.5 * y[0]]

    values = np.where(T > 0.7, 2 - 2 * np.exp(-0.5 * (T - 0.7)), 0.0)
    given = Record(T, values, [0.0], (Free(0.9),), 0.01)
    with pytest.raises(ValueError, match=r"jumps at t = 0\.9.*`differences=True` takes"):
        fit(switched, given, method="Tsit5")
    found = fit(switched, given, method="Tsit5", differences=True)
    assert np.isclose(found.x[0], 0.7, rtol=1e-6)


def test_counts_whose_model_is_negative_do_not_start():
    given = Record(T, [3, 2, 4, 3, 1], [Free(-1.0)], (0.0,), "poisson")
    with pytest.raises(ValueError, match="the model of counts is negative, -1"):
        fit(decay, given)
    above = Record(T, [3, 2, 4, 3, 1], [Free(1.0)], (0.0,), "poisson")
    assert np.isclose(fit(decay, above).x[0], 2.6, rtol=1e-6)


def test_a_series_too_short_for_its_noise():
    """The slope follows the first series alone, whose one residual is 0."""

    def two(t, y, slope, other):
        return [slope + 0 * y[0], other + 0 * y[1]]

    values = np.full((2, 5), np.nan)
    values[0, 4], values[1] = 2.0, np.r_[0.0, 0.6, 0.9, 1.6, 2.0]
    given = Record(T, values, [0.0, 0.0], (Free(0.5), Free(0.5)))
    with pytest.raises(ValueError, match=r"noise of y\[0\] cannot be estimated from 1 values"):
        fit(two, given)


def test_a_whole_number_starts_a_fit_of_a_float():
    found = fit(decay, record(Free(1, low=0, high=3)))
    assert isinstance(found.args()[0], float) and found.x.dtype == float


def test_wrong_questions_to_a_fit():
    found = fit(decay, record())
    with pytest.raises(ValueError, match=r"no parameter 'k'; choose from \['rate'\]"):
        found.profile("k")
    with pytest.raises(ValueError, match="must be below 1"):
        found.plot(record=1)
    with pytest.raises(TypeError, match="must be a number"):
        found.y0("first")
    for times in ([], [2.0, 1.0], [np.nan], [[1.0]]):
        with pytest.raises(ValueError, match="must be finite and increase"):
            found.predict(times)
    with pytest.raises(ValueError, match="not be before t0 = 0"):
        found.predict([-1.0, 1.0])


def test_what_was_given_is_not_changed_and_changes_nothing():
    times, values = T.copy(), V.copy()
    free = Free(0.5)
    given = Record(times, values, np.array([1.0]), (free,), 0.1)
    times[:], values[:] = 7.0, 7.0
    found = fit(decay, given)
    assert np.array_equal(given.t, T) and np.array_equal(given.values, [V])
    assert np.isclose(found.x[0], 1.0, rtol=1e-6) and free.start == 0.5
    again = fit(decay, given)
    assert np.array_equal(again.x, found.x) and str(again) == str(found)


def test_fits_in_threads_are_those_of_one():
    known = KNOWN["rates"]()
    alone = [known.fitted(seed) for seed in range(4)]
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        both = list(pool.map(known.fitted, range(4)))
    for one, other in zip(alone, both, strict=True):
        assert np.array_equal(one.x, other.x) and one.chi2 == other.chi2
