"""Figures of solutions: labelled, complete, smooth between the steps."""

import numpy as np
import pytest

from fastdyn import plot
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
    assert plot.curve(satellite().solve((0.0, 6.0)))[0].shape == run.t.shape
