"""odeint takes the steps of SciPy's odeint, and tells of them and fails as SciPy's does."""

import subprocess
import sys
import warnings

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.integrate import again, odeint, steps

TOLERANCE = 1.49012e-8


def oscillator(y, t):
    return [y[1], -y[0]]


def van_der_pol(y, t, mu):
    return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]


def jacobian(y, t, mu):
    return [[0.0, 1.0], [-2 * mu * y[0] * y[1] - 1, mu * (1 - y[0] ** 2)]]


def heat(y, t):
    flow = np.diff(np.concatenate([[1.0], y, [0.0]])) * 40.0
    return np.diff(flow)


def bands(y, t):
    n = len(y)
    return np.array([[40.0] * n, [-80.0] * n, [40.0] * n])


ROD = np.zeros(12)
# Spans are so short that rounding errors decide about no step; the stiff ones change the family.
STIFF = van_der_pol, [2.0, 0.0], np.linspace(0, 250, 19)
CASES = {
    "plain": (oscillator, [1.0, 0.0], np.linspace(0, 10, 7), {}),
    "falling": (oscillator, [1.0, 0.0], np.linspace(10, 0, 7), {}),
    "stiff": (*STIFF, {"args": (200.0,)}),
    "jacobian": (*STIFF, {"args": (200.0,), "Dfun": jacobian}),
    "columns": (
        *STIFF,
        {"args": (200.0,), "Dfun": lambda *a: np.transpose(jacobian(*a)), "col_deriv": True},
    ),
    "highest orders": (*STIFF, {"args": (200.0,), "mxordn": 4, "mxords": 3, "mxstep": 5000}),
    "bands": (heat, ROD, np.linspace(0, 1.5, 7), {"ml": 1, "mu": 1}),
    "given bands": (heat, ROD, np.linspace(0, 1.5, 7), {"ml": 1, "mu": 1, "Dfun": bands}),
    "first step": (oscillator, [1.0, 0.0], np.linspace(0, 10, 7), {"h0": 3.0}),
    "longest step": (oscillator, [1.0, 0.0], np.linspace(0, 10, 7), {"hmax": 0.05}),
    "critical times": (oscillator, [1.0, 0.0], np.linspace(0, 10, 7), {"tcrit": [1.7, 5.1, 9.0]}),
    "tolerances": (oscillator, [1.0, 0.0], np.linspace(0, 9, 4), {"rtol": 1e-9, "atol": [1e-4, 1]}),
    "few steps": (oscillator, [1.0, 0.0], np.linspace(0, 10, 7), {"mxstep": 20}),
}


@pytest.mark.filterwarnings("ignore:Excess work")
@pytest.mark.parametrize("name", CASES)
def test_steps_and_infodict_are_scipys(name):
    func, y0, t, options = CASES[name]
    ours, told = odeint(func, y0, t, full_output=True, **options)
    theirs, expected = scipy.integrate.odeint(func, y0, t, full_output=True, **options)
    done = np.isfinite(ours).all(axis=1)
    assert done.all() == (told["message"] == "Integration successful.") == (name != "few steps")
    bound = options.get("rtol", TOLERANCE) * abs(theirs) + options.get("atol", TOLERANCE)
    assert (abs(ours - theirs)[done] <= np.broadcast_to(bound, ours.shape)[done]).all()
    n = done.sum()  # rows behind the start, and the row of a failure; SciPy leaves the rest open
    for key in ("nst", "nfe", "nje", "nqu", "mused"):
        assert told[key][:n].tolist() == expected[key][:n].tolist(), key
    for key in ("lenrw", "leniw", "imxer", "message"):
        assert told[key] == expected[key], key
    # An error estimate has rounding errors of eps |y|, which change a step by their share of the
    # tolerance; the changes of all steps add up.
    share = np.finfo(float).eps / np.min(options.get("rtol", TOLERANCE))
    bound = share * told["nst"].max() * abs(t[-1] - t[0])
    for key in ("hu", "tcur", "tsw", "tolsf"):
        assert abs(told[key] - expected[key])[:n].max() <= bound, key
    assert told.keys() == expected.keys()


def test_a_call_without_infodict_has_the_same_rows():
    for func, y0, t, options in CASES.values():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            full, _ = odeint(func, y0, t, full_output=True, **options)
            assert odeint(func, y0, t, **options).tobytes() == full.tobytes()


@pytest.mark.parametrize("y0", [1, 1.0, [1], (1.0,), np.array([1]), np.float32(1), np.array(1.0)])
@pytest.mark.parametrize("t", [[0, 1, 2], (0.0, 1, 2), range(3), np.arange(3), np.arange(3.0)])
def test_forms_of_state_and_times(y0, t):
    for _ in range(4):
        found = odeint(lambda y, t: -y, y0, t)
        assert found.shape == (3, 1)
        assert found[0] == 1.0
        assert abs(found[:, 0] - np.exp(-np.arange(3))).max() < 10 * TOLERANCE


def test_arguments_need_no_tuple_and_may_be_in_both_orders():
    t = np.linspace(0, 1, 4)
    of_tuple = odeint(lambda y, t, k: -k * y, [1.0], t, args=(2.0,))
    assert (odeint(lambda y, t, k: -k * y, [1.0], t, args=2.0) == of_tuple).all()
    assert (odeint(lambda t, y, k: -k * y, [1.0], t, (2.0,), tfirst=True) == of_tuple).all()


def test_repeated_times_and_no_time():
    found = odeint(oscillator, [1.0, 0.0], [0, 0, 1, 1, 2])
    assert (found[:2] == [1.0, 0.0]).all()
    assert (found[2] == found[3]).all()
    y, told = odeint(oscillator, [1.0, 0.0], [3.0, 3.0], full_output=True)
    assert (y == [1.0, 0.0]).all()
    assert told["message"].startswith("Nothing was done")
    assert odeint(oscillator, [1.0, 0.0], []).shape == (0, 2)


def test_a_failure_is_an_array_with_a_warning():
    with pytest.warns(scipy.integrate.ODEintWarning, match="Excess work.*mxstep") as said:
        found = odeint(lambda y, t: y**2, 1.0, np.linspace(0, 2, 6))
    assert said[0].filename == __file__
    assert np.isfinite(found[:5]).all() or np.isfinite(found[:3]).all()
    assert np.isnan(found[-1]).all()


@pytest.mark.parametrize("limit", [33, 34])
def test_mxstep_counts_from_output_to_output(limit):
    """The first of six outputs takes 34 steps, each other one less; see the infodict."""
    t = np.linspace(0, 10, 6)
    _, told = scipy.integrate.odeint(oscillator, [1.0, 0.0], t, full_output=True)
    assert max(np.diff(told["nst"], prepend=0)) == told["nst"][0] == 34
    for _ in range(5):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            found = odeint(oscillator, [1.0, 0.0], t, mxstep=limit)
        assert np.isnan(found).any() == bool(said) == (limit < 34)


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        ({"y0": [[1.0, 0.0]]}, ValueError, "one-dimensional"),
        ({"t": [[0, 1]]}, ValueError, "one-dimensional"),
        ({"t": [0, 1, 0.5]}, ValueError, "monotonically"),
        ({"rtol": [1e-3]}, ValueError, "same length"),
        ({"rtol": -1.0}, ValueError, "must not be negative"),
        ({"mxstep": -1}, ValueError, "must not be negative"),
        ({"mxordn": -1}, ValueError, "Incorrect value for mxordn"),
        ({"func": lambda y, t: [1.0]}, RuntimeError, "`func` returned 1 value"),
        ({"func": lambda y, t: [[1.0], [2.0]]}, RuntimeError, "`func` returned a column"),
        ({"func": "f"}, TypeError, r"function of \(y, t\)"),
    ],
)
def test_wrong_arguments(given, error, sentence):
    call = {"func": oscillator, "y0": [1.0, 0.0], "t": [0.0, 1.0]} | given
    with pytest.raises(error, match=sentence):
        odeint(**call)


def test_the_other_order_of_arguments_gets_a_sentence():
    with pytest.warns(UserWarning, match="tfirst=True"):
        odeint(lambda t, y: -y, 1.0, [0.0, 1.0])


def test_a_note_names_the_order_of_odeint():
    with pytest.raises(ZeroDivisionError) as caught:
        odeint(lambda y, t: 1 / 0, [1.0], [0.0, 1.0])
    assert "`fun` was called at t = 0" in "".join(caught.value.__notes__)
    with pytest.raises(IndexError) as caught:
        odeint(lambda y, t: [y[0], y[2]], [1.0, 0.0], [0.0, 1.0])
    assert "`y` has 2 components" in "".join(caught.value.__notes__)


def test_effects_of_a_function_happen_and_writes_are_scipys():
    seen, theirs = [], []

    def counts(y, t, seen):
        seen.append(t)
        return -y

    with pytest.warns(fastdyn.CompileWarning):
        odeint(counts, 1.0, [0.0, 1.0], args=(seen,))
    scipy.integrate.odeint(counts, 1.0, [0.0, 1.0], args=(theirs,))
    np.testing.assert_allclose(seen[-len(theirs) :], theirs, rtol=1e-9)

    def writes(y, t):
        y[y < 0.5] = 0.5
        return -y

    t = np.linspace(0, 2, 5)
    assert (odeint(writes, [1.0], t) == scipy.integrate.odeint(writes, [1.0], t)).all()


def test_a_repeated_call_is_a_ready_run(monkeypatch):
    """After some calls, no call goes the long way, also with new functions of one piece of code."""
    t = np.linspace(0, 5, 9)

    def of(k):
        return lambda y, t, c: [y[1], -k * y[0] - c * y[1]]

    def solve(k, full=False):
        return odeint(of(k), [1.0, k], t, args=(0.1 * k,), full_output=full)

    for k in range(1, 10):
        solve(float(k))
        solve(float(k), full=True)
    long = [odeint(of(k), [1.0, k], t.tolist(), (0.1 * k,), h0=0.0, mxords=4) for k in (3.0, 4.5)]

    def refused(*given):
        raise AssertionError("the long way")

    monkeypatch.setattr(steps, "solved", refused)
    for k, rows in zip((3.0, 4.5), long, strict=True):
        assert solve(k).tobytes() == rows.tobytes()
        found, told = solve(k, full=True)
        assert found.tobytes() == rows.tobytes()
        expected = scipy.integrate.odeint(of(k), [1.0, k], t, args=(0.1 * k,), full_output=True)[1]
        assert told["nfe"].tolist() == expected["nfe"].tolist()
    with pytest.raises(AssertionError, match="the long way"):
        odeint(of(1.0), [1.0, 0.0], t[:5], args=(0.1,))


def test_a_new_span_and_new_times_are_taken(monkeypatch):
    for i in range(9):
        odeint(oscillator, [1.0, 0.0], [float(i), i + 0.5])
    wanted = [odeint(oscillator, [1.0, 0.0], [0.0, s], mxords=4) for s in (-2.0, 3.0)]
    monkeypatch.setattr(steps, "solved", lambda *given: pytest.fail("the long way"))
    for end, rows in zip((-2.0, 3.0), wanted, strict=True):
        assert odeint(oscillator, [1.0, 0.0], [0.0, end]).tobytes() == rows.tobytes()


def test_the_table_of_recent_calls_keeps_the_code_alive():
    key = again.key_of(oscillator, [1.0, 0.0], [0.0, 1.0], (), ())
    assert key is not None
    assert again.key_of(print, [1.0], [0.0], (), ()) is None


def test_the_room_has_scipys_other_names():
    from fastdyn import integrate

    assert integrate.quad is scipy.integrate.quad
    assert integrate.solve_ivp is fastdyn.solve_ivp
    assert integrate.solve_bvp is fastdyn.solve_bvp
    assert integrate.odeint is fastdyn.odeint
    assert set(scipy.integrate.__all__) <= set(dir(integrate))
    with pytest.raises(AttributeError, match="odeintt"):
        integrate.odeintt  # noqa: B018


def test_a_change_of_family_is_printed(capsys):
    odeint(*STIFF, args=(200.0,), ixpr=True)
    assert "changes to BDF" in capsys.readouterr().out


def test_tolerances_below_rounding_errors_are_refused_as_by_scipy():
    with pytest.warns(scipy.integrate.ODEintWarning, match="Illegal input"):
        assert np.isnan(odeint(oscillator, [1.0, 0.0], [0.0, 1.0], rtol=1e-15, atol=1e-20)[1]).all()
    t = np.linspace(0, 40, 5)
    with pytest.warns(scipy.integrate.ODEintWarning, match="Excess accuracy"):
        found, told = odeint(lambda y, t: y, [1.0], t, rtol=1e-16, atol=1e-13, full_output=True)
    assert np.isnan(found[-1])
    assert told["tolsf"].max() > 1.0


def test_a_solve_imports_neither_numba_nor_scipys_solvers():
    program = """
import sys
from fastdyn import odeint
odeint(lambda y, t: -y, 1.0, [0.0, 1.0])
print([name for name in ("numba", "scipy.integrate") if name in sys.modules])
"""
    for _ in range(2):  # the first process may compile kernels
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.split() == [b"[]"]


def test_a_tolerance_may_be_an_array_of_one_number():
    """An array has no hash, and such a call is no call again."""
    times = [0.0, 1.0, 2.0]
    expected = odeint(oscillator, [1.0, 0.0], times, rtol=1e-6)
    for _ in range(4):
        found = odeint(oscillator, [1.0, 0.0], times, rtol=np.array(1e-6))
        np.testing.assert_array_equal(found, expected)
