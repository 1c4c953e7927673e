"""Claims about prepared solvers with discrete states."""

import numpy as np
import pytest

from fastdyn import prepare, solve_ivp
from tests.support.impacts import marked

TIGHT = {"rtol": 1e-9, "atol": 1e-12}


def filled(t, y, d, rate):
    return [d[0] - rate * y[0]]


def switched(t, y, d, rate):
    return y, [0.5 * d[0], d[1] + 1.0]


SPAN, RATE = (0.0, 3.0), 0.4
GIVEN = {"every": 0.5, "on_event": switched, "dense_output": True, **TIGHT}
STARTS = [([1.0], [1.0, 0.0]), ([0.2], [3.0, 5.0]), ([7.0], [-2.0, 1.0])]


@pytest.mark.parametrize("t_eval", [None, [1.0, 3.0]])
def test_many_solves_are_a_loop_over_calls(t_eval):
    given = {**GIVEN, "dense_output": False, "t_eval": t_eval}
    solver = prepare(filled, SPAN, [1.0], args=(RATE,), discrete=[1.0, 0.0], **given)
    states, numbers = map(np.array, zip(*STARTS, strict=True))
    rates = np.array([0.1, 0.2, 0.3])
    for y0s, discrete in ((states, numbers), (states, None), ([2.0], numbers), (None, None)):
        found = solver.many(y0s, (rates,), discrete)
        for i, rate in enumerate(rates):
            y0 = [1.0] if y0s is None else np.atleast_2d(y0s)[i if y0s is states else 0]
            d0 = [1.0, 0.0] if discrete is None else discrete[i]
            one = solver(y0, (rate,), d0)
            last = -1 if t_eval is None else slice(None)
            assert np.array_equal(found.y[i], one.y[:, last])
            assert np.array_equal(found.discrete[i], one.discrete[:, last])


def test_a_loop_over_samples_keeps_its_memory():
    """A call for each sample, the end of one the start of the next, is the whole solve."""
    empty = marked(lambda t, y, d, rate: y[0] - 0.6, direction=-1)
    options = {"events": empty, "on_event": lambda t, y, d, rate: (y, [d[0] + 0.5, d[1]]), **TIGHT}
    whole = solve_ivp(filled, (0.0, 6.0), [1.0], args=(RATE,), discrete=[0.0, 0.0], **options)
    part = prepare(filled, (0.0, 2.0), [1.0], args=(RATE,), discrete=[0.0, 0.0], **options)
    y, d = [1.0], [0.0, 0.0]
    for _ in range(3):
        run = part(y, None, d)
        y, d = run.y[:, -1], run.discrete[:, -1]
    assert np.array_equal(d, whole.discrete[:, -1]) and d[0] >= 0.5
    assert y == pytest.approx(whole.y[:, -1], abs=1e-8)


def test_wrong_parts_are_answered_by_sentences():
    solver = prepare(filled, SPAN, [1.0], args=(RATE,), discrete=[1.0, 0.0], **GIVEN)
    for given in ({"discrete": [1.0]}, {"discrete": 1.0}, {"discrete": [1j, 0.0]}):
        with pytest.raises((ValueError, TypeError), match="`discrete` must be"):
            solver(**given)
    with pytest.raises(ValueError, match="`y0` must be 1 real numbers"):
        solver([1.0, 2.0])
    with pytest.raises(ValueError, match="finite"):
        solver(discrete=[np.nan, 0.0])
    many = prepare(filled, SPAN, [1.0], args=(RATE,), discrete=[1.0, 0.0], every=1.0,
                   on_event=switched)  # fmt: skip
    with pytest.raises(ValueError, match="`y0` has 3, `discrete` has 2"):
        many.many(np.ones((3, 1)), None, np.ones((2, 2)))
    with pytest.raises(ValueError, match="shape"):
        many.many(np.ones((3, 1)), None, np.ones((3, 5)))
    with pytest.raises(ValueError, match="`discrete` never changes"):
        prepare(filled, SPAN, [1.0], discrete=[1.0])
