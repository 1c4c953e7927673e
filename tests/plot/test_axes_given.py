"""Figures in the place of an Axes of the user's."""

import matplotlib.pyplot as plt
import pytest

import fastdyn
from fastdyn.systems import SYSTEMS, satellite


def decay(t, y):
    return [-y[0]]


@pytest.fixture
def grid():
    figure, axes = plt.subplots(1, 2, figsize=(14, 6), layout="constrained")
    yield figure, axes
    figure.draw_without_rendering()
    plt.close(figure)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", SYSTEMS)
def test_systems(grid, name):
    figure, (left, right) = grid
    drawn = SYSTEMS[name]().plot((0.0, 1.0), ax=right)
    assert left in figure.axes and not left.lines
    if drawn is figure:
        assert right.lines
    else:
        assert drawn.figure is figure and drawn.axes and right not in figure.axes


def test_one_panel_is_drawn_in_the_axes(grid):
    figure, (left, _) = grid
    run = fastdyn.solve_ivp(decay, (0, 3), [1.0])
    assert fastdyn.plot.plot({"a": run, "b": run}, ax=left) is figure
    assert len(left.lines) == 2 and left.get_legend() and not figure.legends
    assert plt.get_fignums() == [figure.number]


def test_several_panels_take_its_place(grid):
    figure, (left, right) = grid
    run = satellite(V=1.2).solve((0, 10))
    part = run.plot(ax=right)
    assert part in figure.subfigs and part.legends and len(part.axes) == 3
    with pytest.raises(TypeError, match="must be one Axes of a grid"):
        run.plot(ax=[left, left])
    with pytest.raises(TypeError, match="must be one Axes of a grid"):
        run.plot(ax=right)  # is gone
