"""dde23 and ddesd with MATLAB's calls."""

import numpy as np
import pytest

from fastdyn.matlab import dde23, ddesd, deval, ode15i, ode45, odeset

# Wille and Baker's example 3, as of dde23's documentation, at t = 5 to 8 digits: by JiTCDDE.
AT_5 = [19.174998, 176.42253, 190.34415]


def wille_and_baker(t, y, Z):
    return [Z[0, 0], Z[0, 0] + Z[1, 1], y[1]]


def test_the_example_of_dde23():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    sol = dde23(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 5], options)
    np.testing.assert_allclose(deval(sol, 5), AT_5, rtol=1e-6)
    t, y = dde23(wille_and_baker, [1, 0.2], lambda t: [1, 1, 1], [0, 2.5, 5], options)
    assert t.tolist() == [0, 2.5, 5]
    np.testing.assert_allclose(y[-1], AT_5, rtol=1e-6)


def test_ddesd_takes_functions_and_numbers():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    constant = ddesd(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 5], options)
    np.testing.assert_allclose(deval(constant, 5), AT_5, rtol=1e-6)
    moving = ddesd(
        lambda t, y, Z: [-Z[0, 0] + np.sin(t - 0.5 - 0.4 * y[0] ** 2) + np.cos(t)],
        lambda t, y: [t - 0.5 - 0.4 * y[0] ** 2], lambda t: [np.sin(t)], [0, 5], options,
    )  # fmt: skip
    np.testing.assert_allclose(deval(moving, 5), [np.sin(5)], rtol=1e-6)


def test_a_solution_goes_on():
    options = odeset(RelTol=1e-8, AbsTol=1e-10)
    first = dde23(wille_and_baker, [1, 0.2], [1, 1, 1], [0, 3], options)
    rest = dde23(wille_and_baker, [1, 0.2], first, [3, 5], options)
    np.testing.assert_allclose(deval(rest, 5), AT_5, rtol=1e-5)


def test_lags_are_positive():
    with pytest.raises(ValueError, match="`lags` must be positive"):
        dde23(wille_and_baker, [1, 0.0], [1, 1, 1], [0, 5])


TIGHT = odeset(RelTol=1e-8, AbsTol=1e-10)


def doubled(t, y, Z):
    return [-2.0 * Z[0, 0]]


def test_events_read_the_past():
    """From 1, y = 1 - 2 t to t = 1: zeros at 1/2 and, of the past, one delay later."""

    def events(t, y, Z):
        return [y[0], Z[0, 0]], [0, 1], [0, 1]  # the past ends the run where it rises

    options = odeset(TIGHT, Events=events)
    t, _, te, ye, ie = dde23(doubled, 1, [1.0], [0, 6], options)
    assert ie.tolist() == [0, 0, 1] and t[-1] == te[-1]
    assert abs(te[0] - 0.5) < 1e-7 and abs(te[2] - te[1] - 1.0) < 1e-7
    assert abs(ye[:2]).max() < 1e-7
    falling = odeset(TIGHT, Events=lambda t, y, Z: (y[0], 0, 0))
    sol = ddesd(
        lambda t, y, Z: [-Z[0, 0]], lambda t, y: [t - 1 - y[0] ** 2], [1.0], [0, 3], falling
    )
    assert abs(sol.xe[0] - 1.0) < 1e-7  # y = 1 - t, while the past is constant


def test_a_start_beside_the_history():
    """After a jump at 2, as events make it, the solution goes on with the earlier past."""
    constant = dde23(doubled, 1, [1.0], [0, 2], odeset(TIGHT, InitialY=3.0))
    # 3 - 2 t to t = 1, then 1 - 6 s + 2 s^2 with s = t - 1
    np.testing.assert_allclose(deval(constant, [1.0, 2.0]), [[1.0, -3.0]], rtol=0, atol=1e-7)
    moving = dde23(doubled, 1, lambda t: t, [0, 1], odeset(TIGHT, InitialY=[3.0]))
    np.testing.assert_allclose(deval(moving, 1.0), [4.0], rtol=0, atol=1e-7)  # 3 + 1
    first = dde23(doubled, 1, [1.0], [0, 1.5], TIGHT)  # -1 - 2 s + 2 s^2, -1.5 at the end
    rest = dde23(doubled, 1, first, [1.5, 2.5], odeset(TIGHT, InitialY=[0.0]))
    at_2 = 2 * 0.5 - 1.0 + 0.25 + 0.0  # the integral of -2 (1 - 2 u) from 1/2 to 1
    np.testing.assert_allclose(deval(rest, 2.0), [at_2 + 0.25], rtol=0, atol=1e-7)
    assert rest.result.jumps.tolist() == [0.0, 1.5]
    with pytest.raises(ValueError, match="InitialY has 2 numbers, and `history` 1"):
        dde23(doubled, 1, [1.0], [0, 2], odeset(InitialY=[3.0, 1.0]))


def test_jumps_columns_statistics_and_no_lags(capsys):
    sol = dde23(
        doubled,
        1,
        lambda t: 1.0 if t < -0.5 else 2.0,
        [0, 2],
        odeset(TIGHT, Jumps=[-0.5], Stats="on"),
    )
    assert sol.result.jumps.tolist() == [-0.5, 0.0]
    np.testing.assert_allclose(deval(sol, 1.0), [-1.0], rtol=0, atol=1e-7)  # 2 - 1 - 2
    assert capsys.readouterr().out.count("\n") == 3
    column = dde23(lambda t, y, Z: -Z[:, 0], [1], np.array([[1.0], [2.0]]), [0, 1])
    np.testing.assert_allclose(column.y[:, -1], [0.0, 0.0], rtol=0, atol=1e-12)
    alone = dde23(lambda t, y, Z: -y + Z.sum(), [], [1.0], [0, 1], TIGHT)
    assert abs(alone.y[0, -1] - np.exp(-1)) < 1e-8


@pytest.mark.parametrize("name, value", [("Mass", [[2.0]]), ("NonNegative", [0]), ("MinStep", 0.1)])
def test_options_without_effect_are_refused(name, value):
    """The options change solutions of MATLAB; other solvers refuse the options of `dde23`."""
    given = odeset(name, value)
    with pytest.raises(ValueError, match=f"{name} is no option of fastdyn's dde23: of its kind"):
        dde23(doubled, 1, [1.0], [0, 2], given)
    with pytest.raises(ValueError, match=f"{name} is no option of fastdyn's ode15i"):
        ode15i(lambda t, y, yp: [yp[0] + y[0]], [0, 1], [1.0], [-1.0], given)
    with pytest.raises(ValueError, match="Jumps is no option of fastdyn's ode45"):
        ode45(lambda t, y: -y, [0, 1], [1.0], odeset(Jumps=[0.5]))
    with pytest.raises(TypeError, match=r"`Events` is called as Events\(t, y\)"):
        ode45(lambda t, y: -y, [0, 1], [1.0], odeset(Events=lambda t, y, Z: (y[0], 0, 0)))
