"""Phase portraits and basins of attraction beside closed ones."""

import math

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.analysis import basin, phase_portrait


def van_der_pol(t, y, mu):
    return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]


def wells(t, y):
    """Gradients of a double well: the sign of y[0] decides."""
    return [y[0] - y[0] ** 3, -y[1]]


def test_the_separatrices_of_the_pendulum():
    """Curves from and to the saddles have the saddles' energy, trajectories have their own."""
    pendulum = systems.pendulum()
    found = phase_portrait(pendulum, [(-5, 5), (-9, 9)])
    assert [each.kind for each in found.equilibria] == ["saddle", "centre", "saddle"]
    kept = pendulum.invariants["energy"]
    top = kept(0, np.array([math.pi, 0.0]), *pendulum.args)
    assert len(found.separatrices) == 8
    for _, curve in found.separatrices:
        assert np.abs(kept(0, curve, *pendulum.args) - top).max() < 1e-4
    assert len(found.trajectories) > 15 and not found.cycles
    for curve in found.trajectories:
        assert np.ptp(kept(0, curve, *pendulum.args)) < 1e-4


def test_trajectories_run_with_the_time():
    found = phase_portrait(lambda t, y: [1.0 + 0 * y[0], 0 * y[1]], [(0, 1), (0, 1)])
    assert len(found.equilibria) == 0
    assert all((np.diff(curve[0]) > 0).all() for curve in found.trajectories)


def test_the_limit_cycle_of_van_der_pol():
    (cycle,) = phase_portrait(van_der_pol, [(-3, 3), (-4, 4)], (1.0,)).cycles
    assert cycle.stable and math.isclose(cycle.period, 6.6632868593, rel_tol=1e-9)
    (back,) = phase_portrait(
        lambda t, y: [-r for r in van_der_pol(t, y, 1.0)], [(-3, 3)] * 2
    ).cycles
    assert back.stable is False and math.isclose(back.period, cycle.period, rel_tol=1e-9)


def test_starts_of_ones_own():
    found = phase_portrait(wells, [(-2, 2), (-2, 2)], starts=[[0.5, 1.0], [-0.5, 1.0]])
    assert len(found.trajectories) == 2
    assert np.abs(found.trajectories[0][:, -1] - [1, 0]).max() < 0.05


def test_a_portrait_of_a_function_that_cannot_be_differentiated():
    def by_text(t, y):
        return [float(str(y[1])), -float(str(y[0]))]

    with pytest.warns(UserWarning):
        found = phase_portrait(by_text, [(-1, 1), (-1, 1)], n_starts=4)
    assert found.equilibria is None and "can be traced" in found.message and found.trajectories


@pytest.mark.parametrize(
    "given, kind, said",
    [
        ({"fun": lambda t, y: [y[1], np.cos(t)]}, ValueError, "depends on the time"),
        ({"fun": systems.building()}, ValueError, "of two components"),
        ({"fun": lambda t, y: [y[0]]}, ValueError, "must return 2 numbers"),
        ({"fun": wells, "box": [(0, 1)]}, ValueError, "`box` must have"),
        ({"fun": wells, "starts": [[1.0, math.nan]]}, ValueError, "`starts`"),
        ({"fun": lambda t, y: [y[0] / 0.0 * 0, y[1]]}, ValueError, "finite nowhere"),
    ],
)
@pytest.mark.filterwarnings("ignore")
def test_what_a_portrait_refuses(given, kind, said):
    with pytest.raises(kind, match=said):
        phase_portrait(**{"box": [(-1, 1), (-1, 1)]} | given)


def test_basins_of_two_wells():
    found = basin(wells, [(-2, 2), (-1, 1)], n=(40, 10), t_end=30)
    assert found.labels.shape == (10, 40) and found.undecided == found.escaped == 0
    assert np.array_equal(found.labels, np.tile(found.x > 0, (10, 1)))
    assert np.allclose([low for low, _ in found.attractors], [[-1, 0], [1, 0]], atol=1e-3)
    assert np.allclose(found.shares, 0.5) and "equilibrium at 1, 0" in str(found)
    given = basin(wells, [(-2, 2), (-1, 1)], n=10, t_end=30, attractors=[[1.0, 0.0]])
    assert set(given.labels.ravel()) == {0, -1} and given.shares[0] == 0.5


def test_a_cycle_is_an_attractor():
    found = basin(van_der_pol, [(-2, 2), (-2, 2)], (1.0,), n=10, t_end=60, window=10)
    (((low, high)),) = found.attractors
    assert found.undecided == 0 and np.allclose([low[0], high[0]], [-2.00862, 2.00862], atol=1e-3)


def test_what_blows_up_and_what_does_not_settle():
    found = basin(lambda t, y: [-y[0] + y[0] ** 2, -y[1]], [(-2, 2), (-1, 1)], n=20, t_end=40)
    assert np.array_equal(found.labels == -2, np.tile(found.x > 1, (20, 1)))
    wandering = basin(lambda t, y: [1.0 + 0 * y[0], 0 * y[1]], [(-2, 2)] * 2, n=5, t_end=10)
    assert wandering.undecided == 1.0 and not wandering.attractors


@pytest.mark.few(3)
@pytest.mark.parametrize(
    "fun",
    [
        lambda t, y: [y[1], -np.sin(y[0])],
        lambda t, y: [y[1], -y[0]],
        lambda t, y: [-y[0], 0 * y[1]],
        lambda t, y: [y[1], y[0]],
        lambda t, y: [y[1], 0.1 * y[1] - y[0]],
    ],
)
def test_where_nothing_attracts_there_is_no_attractor(fun):
    found = basin(fun, [(-2, 2), (-2, 2)], n=30, t_end=100)
    assert not found.attractors and "No attractor was found" in str(found)
    assert found.apart + found.escaped + found.undecided == 1.0
    assert found.apart > 0.7 or found.escaped > 0.7


def test_turns_before_the_rest_do_not_blur_attractors():
    """Damped turns end in one of many equilibria, told from one another by 2 pi."""
    found = basin(lambda t, y: [y[1], -np.sin(y[0]) - 0.2 * y[1]], [(-6, 6), (-6, 6)], n=20)
    ends = np.array([0.5 * (low + high) for low, high in found.attractors])
    assert len(ends) > 8 and np.allclose(ends[:, 0], 2 * math.pi * np.round(ends[:, 0] / 6.28))
    figure = found.plot()
    (legend,) = figure.legends
    colours = {patch.get_facecolor() for patch in legend.get_patches()}
    assert len(colours) == len(legend.get_texts()) >= len(ends)


def test_the_legend_of_a_basin_is_inside():
    def forced(t, y):
        return [y[1], y[0] - y[0] ** 3 - 0.3 * y[1] + 0.2 * np.cos(1.2 * t)]

    found = basin(forced, [(-2, 2), (-2, 2)], n=10)
    figure = found.plot()
    figure.draw_without_rendering()
    box, page = figure.legends[0].get_window_extent(), figure.bbox
    assert page.x0 <= box.x0 and box.x1 <= page.x1 and box.y1 <= page.y1
    assert "e-" not in str(found)


def test_other_components():
    def pair(t, y):
        return [y[0] - y[0] ** 3, -y[1], y[2] - y[2] ** 3]

    found = basin(pair, [(-2, 2), (-2, 2)], at=[0, 0.3, 0], components=(0, 2), n=8, t_end=30)
    assert len(found.attractors) == 4 and np.allclose(found.shares, 0.25)


@pytest.mark.parametrize(
    "given, said",
    [
        ({"n": 1}, "`n` must be"),
        ({"components": (0, 0)}, "`components`"),
        ({"components": (0, 2)}, "`components`"),
        ({"at": [0, math.nan]}, "`at`"),
        ({"t_end": 0.0}, "`t_end`"),
        ({"attractors": [[1.0]]}, "`attractors`"),
        ({"near": -1.0}, "`near`"),
    ],
)
def test_what_a_basin_refuses(given, said):
    with pytest.raises(ValueError, match=said):
        basin(wells, **{"box": [(-1, 1), (-1, 1)], "n": 3, "t_end": 3.0} | given)


@pytest.mark.hunt
def test_closed_orbits_are_drawn_whole():
    """Each trajectory of an undamped pendulum ends at the box, or where it began."""
    box = np.array([(-3.0, 3.0), (-2.0, 2.0)])
    found = phase_portrait(lambda t, y: [y[1], -np.sin(y[0])], box)
    closed = 0
    for curve in found.trajectories:
        energy = 0.5 * curve[1] ** 2 - np.cos(curve[0])
        amplitude = math.acos(-energy.mean()) if energy.mean() < 1 else math.inf
        if amplitude < 2.9 and np.sqrt(2 * (1 + energy.mean())) < 1.95:
            assert np.abs(curve[:, 0] - curve[:, -1]).max() < 0.05
            closed += 1
    assert closed > 5
    assert len(str(found).splitlines()) < 10 and "equilibri" in str(found)
