"""Repeated calls of `solve_ivp` with complex states."""

import numpy as np
import pytest

from fastdyn import solve_ivp
from support.repeated import assert_first, in_threads, is_plain, plain, warm

SPAN, START = (0.0, 1.0), [1.0 + 0.5j, -0.25]
METHODS = {
    "RK45": {}, "RK4": {"step": 0.125}, "Taylor": {"rtol": 1e-8}, "Radau": {},
}  # fmt: skip

pytestmark = pytest.mark.usefixtures("nothing_known")


def turning(t, y, k):
    return [1j * k * y[0] - y[1], -0.5j * y[1]]


def rises(t, y, k):
    return y[0].real - 0.8


STATES = [
    START, (2, 1j), np.array([0.5 + 1j, 2.0]), np.array([1, 2], np.complex64),
    [np.complex128(0.3j), np.float64(1.0)], np.array([1.0 + 0j, 2.0, 3.0])[::2], [-0.0, 1j],
    np.array([1.0 + 1.0j, 2.0]), [complex(-0.0, -0.0), 1],
]  # fmt: skip


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "given", [{}, {"t_eval": [0.25, 1.0]}, {"events": rises, "dense_output": True}]
)
def test_a_call_again_is_a_first_solve(method, given):
    if method == "Taylor" and "events" in given:
        given = {"dense_output": True}
    given = {"method": method, **given, **METHODS[method]}
    assert is_plain(solve_ivp, turning, SPAN, START, args=(1.0,), **given)
    for i, y0 in enumerate(STATES * 2):
        own = given | {"args": (1.0 + 0.5 * (i % 3),)}
        assert_first(solve_ivp(turning, SPAN, y0, **own), plain(turning, SPAN, y0, **own))


def of_any_kind(t, y):
    return [-y[0], y[0] * y[1]]


def test_real_and_complex_states_in_turn():
    for _ in range(8):
        for y0 in ([1.0, 2.0], [1.0 + 0j, 2.0], [1, 2], np.array([1.0, 2.0j])):
            found = solve_ivp(of_any_kind, SPAN, y0)
            assert_first(found, plain(of_any_kind, SPAN, y0))
    assert is_plain(solve_ivp, of_any_kind, SPAN, [1.0, 2.0])
    assert is_plain(solve_ivp, of_any_kind, SPAN, [1.0 + 0j, 2.0])


@pytest.mark.parametrize("bad", [complex(np.nan, 0.0), complex(0.0, np.inf), 10**400])
def test_states_that_are_refused(bad):
    warm(solve_ivp, turning, SPAN, START, args=(1.0,))
    with pytest.raises((ValueError, OverflowError, TypeError)) as found:
        solve_ivp(turning, SPAN, [1j, bad], args=(1.0,))
    with pytest.raises(found.type) as expected:
        plain(turning, SPAN, [1j, bad], args=(1.0,))
    assert str(found.value) == str(expected.value)


def test_results_share_nothing():
    found = warm(solve_ivp, turning, SPAN, START, args=(1.0,))
    before = found.y.copy()
    solve_ivp(turning, SPAN, [5.0j, 1.0], args=(1.0,))
    assert np.array_equal(found.y, before)


def test_threads():
    expected = [plain(turning, SPAN, [k + 1j, 1.0], args=(k,)).y for k in range(4)]
    warm(solve_ivp, turning, SPAN, START, args=(1.0,))
    wrong = []

    def work(k):
        for _ in range(50):
            if not np.array_equal(
                solve_ivp(turning, SPAN, [k + 1j, 1.0], args=(k,)).y, expected[k]
            ):
                wrong.append(k)

    in_threads(work, range(4))
    assert not wrong
