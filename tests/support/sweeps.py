"""Pendulums of many stiffnesses, solved coarsely."""

import numpy as np

from fastdyn import solve_ensemble

FAST = {"method": "RK4", "step": 0.05}


def pendulum(t, w, stiffness, damping, table=None):
    theta, omega = w
    return [omega, -stiffness * np.sin(theta) - damping * omega]


def crossing(t, w, stiffness, damping, table=None):
    return w[0]


def plain(count=40, **options):
    args = (np.linspace(1.0, 9.0, count), 0.1)
    return solve_ensemble(pendulum, (0, 4), [1.0, 0.0], args, **FAST | options)


def labels(figure):
    return [(axes.get_xlabel(), axes.get_ylabel(), axes.get_title()) for axes in figure.axes]
