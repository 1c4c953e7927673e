"""Figures of an ensemble, with the names and units that are known."""

import numpy as np
import pytest

from fastdyn import solve_ensemble, systems
from support.sweeps import FAST, labels, pendulum, plain


def test_a_fan_holds_what_it_says():
    result = plain(400, t_eval=np.linspace(0, 4, 9))
    figure = result.plot()
    assert labels(figure) == [("", "y[0]", ""), ("t", "y[1]", "")]
    median = figure.axes[0].lines[-1].get_ydata()
    assert np.array_equal(median, np.median(result.y[:, 0], axis=0))
    outer = figure.axes[0].collections[0].get_paths()[0].vertices
    share = [
        np.mean((y >= outer[outer[:, 0] == t, 1].min()) & (y <= outer[outer[:, 0] == t, 1].max()))
        for t, y in zip(result.t[1:], result.y[:, 0, 1:].T, strict=True)
    ]
    assert np.allclose(share, 0.9, atol=0.01)


def test_few_trajectories_are_drawn_one_by_one():
    figure = plain(3, t_eval=np.linspace(0, 4, 9)).plot(components="y[1]")
    told = [line.get_label() for line in figure.axes[0].lines]
    assert told == ["stiffness = 1", "stiffness = 5", "stiffness = 9"]


def test_a_sweep_draws_each_reduction_over_the_parameter():
    omega = np.array([9.0, 3.0, 20.0, 5.0, 12.0, 7.0, 25.0])
    result = systems.building().ensemble(omega=omega, t_span=(0, 2), reduce=("max", "max_time"))
    figure = result.plot(components=["y1", "y2"])
    assert [entry[1] for entry in labels(figure)] == [
        "largest y₁ (m)", "largest y₂ (m)", "time of the largest y₁ (s)",
        "time of the largest y₂ (s)",
    ]  # fmt: skip
    assert figure.axes[-1].get_xlabel() == "ω (rad/s)"
    line = figure.axes[1].lines[0]
    assert np.array_equal(line.get_xdata(), np.sort(omega))
    assert np.array_equal(line.get_ydata(), result.reduced["max"][np.argsort(omega), 1])


def test_a_map_puts_values_where_they_belong():
    a, b = np.meshgrid([1.0, 10.0, 100.0], [0.0, 0.3])
    order = np.random.default_rng(0).permutation(6)
    args = (a.ravel()[order], b.ravel()[order])
    result = solve_ensemble(pendulum, (0, 4), [1.0, 0.0], args, **FAST)
    axes = result.plot().axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("stiffness", "damping")
    assert axes.get_xscale() == "log" and axes.get_yscale() == "linear"
    values = np.asarray(axes.collections[0].get_array()).reshape(2, 3)
    assert values[1, 2] == result.y_end[(args[0] == 100.0) & (args[1] == 0.3), 0][0]
    scattered = solve_ensemble(pendulum, (0, 4), [1.0, 0.0], (a.ravel(), np.arange(6.0)), **FAST)
    points = scattered.plot().axes[0].collections[0]
    assert np.array_equal(points.get_offsets()[:, 1], np.arange(6.0))


def test_what_varies_too_much_is_counted():
    y0 = np.random.default_rng(0).normal(size=(200, 2))
    result = solve_ensemble(pendulum, (0, 4), y0, (np.linspace(1, 2, 200), 0.1), **FAST)
    figure = result.plot(over=[])
    assert sum(patch.get_height() for patch in figure.axes[0].patches) == 200
    over = result.plot(over=["y[0] at the start", "stiffness"])
    assert labels(over)[0][:2] == ("y[0] at the start", "stiffness")


def test_failed_trajectories_are_left_out_and_counted():
    rates = np.array([0.1, 0.2, 2.0, 0.3])
    result = solve_ensemble(lambda t, y, rate: [rate * y[0] ** 2], (0, 1), [1.0], (rates,))
    figure = result.plot()
    assert np.isnan(figure.axes[0].lines[0].get_ydata()).sum() == 1
    assert figure.get_suptitle() == "1 of 4 trajectories did not get to the end"


@pytest.mark.parametrize(
    ("asked", "sentence"),
    [
        ({"of": "y"}, "choose from y_end"),
        ({"of": "max"}, "`of='max'` is not there"),
        ({"over": "mass"}, "`over='mass'` does not vary; choose from stiffness"),
        ({"components": "z"}, r"choose from y\[0\], y\[1\]"),
    ],
)
def test_what_is_not_there_is_refused(asked, sentence):
    with pytest.raises(ValueError, match=sentence):
        plain().plot(**asked)
