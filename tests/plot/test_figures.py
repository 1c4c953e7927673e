"""Figures of solutions: labelled, complete, smooth between the steps."""

import numpy as np
import pytest

from fastdyn import plot, solve_ivp
from fastdyn.systems import (
    pendulum,
    satellite,
)


def test_figures_are_labelled():
    orbit = satellite(V=1.2).solve((0.0, 20.0), dense_output=True)
    swing = pendulum(V0=5.0).solve((0.0, 5.0), dense_output=True)
    figures = [
        orbit.plot(),
        plot.plot({"a": orbit, "b": orbit, "c": orbit}),
        swing.plot(label="swing"),
        plot.components({"swing": swing}),
        plot.drift({"orbit": orbit}),
        satellite(V=1.5).solve((0.0, 3.0)).plot(),
        satellite().solve((0.0, 3.0), y0=[1, 0, 0.1, 1]).plot(),
    ]
    for figure in figures:
        assert all(axes.get_ylabel() for axes in figure.axes)
        assert figure.axes[-1].get_xlabel().endswith("(s)")
    assert figures[0].axes[0].get_aspect() == 1.0
    texts = [text.get_text() for text in figures[2].legends[0].get_texts()]
    assert texts == ["swing", "R < 0: a cable is slack", "exact"]
    with pytest.raises(ValueError, match="without points"):
        satellite().solve((0.0, 1.0), t_eval=[]).plot()


def test_a_curve_is_smooth_between_the_steps():
    run = satellite().solve((0.0, 6.0), dense_output=True)
    t, y = plot.curve(run)
    per_step = max(16, 400 // (len(run.t) - 1))
    assert len(t) == per_step * (len(run.t) - 1) + 1 and t[0] == 0.0 and t[-1] == 6.0
    assert np.allclose(y, satellite().exact(t), atol=1e-4)


METHODS = ({"method": "ode45"}, {"method": "Taylor"}, {"t_eval": [0.0, 20.0]},
           {"events": "apsis"}, {"method": "RK4", "step": 0.5})  # fmt: skip


@pytest.mark.parametrize("options", METHODS, ids=str)
def test_a_picture_has_no_chords_between_long_steps(options):
    """An orbit drawn through a dozen steps is a star: the lines of a figure turn by little."""
    run = satellite(V=1.2).solve((0.0, 20.0), **options)
    x, y = run.plot().axes[0].lines[0].get_data()
    turn = np.diff(np.unwrap(np.arctan2(np.diff(y), np.diff(x))))
    assert len(x) > 100 and np.abs(turn).max() < 0.2
    assert run.sol is None  # as it was asked for
    t, w = plot.curve(run)
    assert t[-1] == run.t[-1] and w[:, -1] == pytest.approx(run.y[:, -1], rel=1e-12)


def test_a_run_with_impacts_is_drawn_with_them():
    def wall(t, w, GM):
        return w[0] + 0.5

    def back(t, w, GM):
        x, y, vx, vy = w
        return [x, y, -vx, vy]

    run = satellite(V=1.0).solve((0.0, 6.0), events=wall, on_event=back)
    assert plot.curve(run)[1][0].min() >= -0.5 - 1e-9
    stopped = satellite(V=1.2).solve((0.0, 1e9), max_steps=20)
    assert plot.curve(stopped)[0][-1] == stopped.t[-1]


def test_a_plain_result_without_dense_output_shows_its_steps():
    plain = solve_ivp(lambda t, y: [y[1], -y[0]], (0, 6), [1.0, 0.0])
    assert plot.plot(plain).axes[0].lines[0].get_marker() == "."
    smooth = solve_ivp(lambda t, y: [y[1], -y[0]], (0, 6), [1.0, 0.0], dense_output=True)
    assert plot.plot(smooth).axes[0].lines[0].get_marker() == "None"
