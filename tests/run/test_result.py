"""A result is a dict with attributes, whole at once: copies, pickles, names that it lacks."""

import copy
import pickle

import numpy as np
import pytest

from fastdyn import OdeResult, solve_ivp

FIELDS = [
    "t", "y", "sol", "t_events", "y_events", "nfev", "njev", "nlu", "status", "message", "success",
    "n_accepted", "n_rejected",
]  # fmt: skip


def decay(t, y):
    return -y


def fresh():
    return solve_ivp(decay, (0, 1), [1.0, 2.0])


def whole():
    """The same with nothing left to make."""
    r = fresh()
    return OdeResult(**{name: getattr(r, name) for name in FIELDS})


def equal(one, other):
    assert list(one) == list(other)
    for name in one:
        assert np.array_equal(one[name], other[name]), name


def test_as_a_dict():
    for made in (
        fresh(), dict(fresh()), {**fresh()}, fresh().copy(), fresh() | {}, {} | fresh(),
        dict(fresh().items()), OdeResult(fresh()), copy.copy(fresh()), copy.deepcopy(fresh()),
        pickle.loads(pickle.dumps(fresh())), dict(zip(fresh(), fresh().values(), strict=True)),
        {name: fresh()[name] for name in fresh()},
    ):  # fmt: skip
        equal(made, whole())
    assert type(pickle.loads(pickle.dumps(fresh()))) is OdeResult
    assert list(fresh().keys()) == FIELDS
    assert len(fresh()) == len(FIELDS) and "y" in fresh() and "z" not in fresh()
    assert list(reversed(fresh())) == FIELDS[::-1] and fresh()
    assert fresh().get("nfev") == whole().nfev and fresh().get("z", 3) == 3
    assert repr(fresh()) == repr(whole()) and set(FIELDS) <= set(dir(fresh()))
    scalars = {name: fresh()[name] for name in FIELDS[5:]}
    short = fresh()
    for name in FIELDS[:5]:
        del short[name]
    assert short == scalars and not short != scalars
    r = fresh()
    assert r.pop("t").shape == (len(r.y[0]),) and "t" not in r and list(r) == FIELDS[1:]


def test_order_and_changes():
    r = fresh()
    r.extra, r.y = "mine", "other"
    assert r.message and list(r) == [*FIELDS, "extra"] and r.y == "other"
    equal(OdeResult(r), r)
    r = fresh()
    del r.sol
    assert list(r) == [name for name in FIELDS if name != "sol"]
    with pytest.raises(AttributeError):
        _ = r.sol
    with pytest.raises(KeyError):
        r["z"]
    r = fresh()
    r.update(y=1)
    assert r.y == 1 and r.setdefault("t", 5) is r.t
    r.clear()
    assert not r and list(r) == []


def test_each_part_is_made_once():
    r = fresh()
    assert r.y is r.y and r["y"] is r.y and r.t is dict(r)["t"]


def test_results_keep_their_own_numbers():
    first = solve_ivp(decay, (0, 1), [1.0, 2.0])
    times = np.array([0.5, 1.0])
    second = solve_ivp(decay, (0, 1), [3.0, 4.0], t_eval=times)
    solve_ivp(decay, (0, 1), [5.0, 6.0])
    solve_ivp(decay, (0, 1), [5.0, 6.0], t_eval=[0.2, 0.3])
    times[:] = 0
    assert first.y[0, 0] == 1.0 and np.array_equal(first.t, fresh().t)
    assert np.array_equal(second.t, [0.5, 1.0])
    assert np.allclose(second.y[:, 1], np.exp(-1) * np.array([3.0, 4.0]), rtol=1e-2)
    first.y[:] = 0
    assert fresh().y[0, 0] == 1.0


def test_whole_times_stay_whole():
    assert solve_ivp(decay, (0, 3), [1.0], t_eval=[1, 2, 3]).t.dtype.kind == "i"


def test_a_name_that_a_result_lacks_is_no_key_and_no_attribute():
    result = OdeResult(y=1)
    assert result.y == 1 and not hasattr(result, "t") and not hasattr(result, "nonsense")
    assert result.get("t") is None and "t" not in result
    with pytest.raises(KeyError, match="'t'"):
        result["t"]
    result.t, result.more = 2, 3
    assert (result["t"], result.t, result.more) == (2, 2, 3)
    assert dir(result).count("t") == 1
    del result.t
    assert not hasattr(copy.deepcopy(pickle.loads(pickle.dumps(result))), "t")
