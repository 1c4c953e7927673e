"""A solve that ends at a jump, or at a limit about which the equations switch, says what to do."""

import numpy as np
import pytest

from fastdyn import solve_dae


def jumping(t, y, yp):
    return [yp[0] + y[1], y[1] - (1.0 if t < 2.3 else 5.0)]


def looked_up(t, y, yp):
    """The same; the time of the jump cannot be read off."""
    return [yp[0] + y[1], y[1] - {False: 1.0, True: 5.0}[bool(t >= 2.3)]]


def chattering(t, y, yp):
    return [yp[0] - y[1], y[1] + np.sign(y[0])]


@pytest.mark.filterwarnings("ignore:looked_up cannot be compiled")
@pytest.mark.parametrize(("F", "y1", "at"), [(looked_up, 1.0, "2.3"), (chattering, -1.0, "1")])
def test_a_remedy_is_named(F, y1, at):
    run = solve_dae(F, (0, 5), [1.0, y1], [-1.0, 0.0])
    assert run.status == -1 and f"t = {at}" in run.message
    for remedy in ("`breakpoints=`", "an event that resets the state, or hysteresis"):
        assert remedy in run.message


def test_a_jump_at_a_time_that_f_tells_needs_no_remedy():
    run = solve_dae(jumping, (0, 5), [1.0, 1.0], [-1.0, 0.0], t_eval=[2.0, 2.299, 2.301, 5.0])
    assert run.success and run.y[1] == pytest.approx([1.0, 1.0, 5.0, 5.0], rel=1e-13)
    assert run.y[0] == pytest.approx([-1.0, -1.299, -1.305, -14.8], rel=1e-12)


@pytest.mark.filterwarnings("ignore:looked_up cannot be compiled")
@pytest.mark.parametrize("F", [jumping, looked_up])
def test_the_remedy_of_a_jump_helps(F):
    run = solve_dae(F, (0, 5), [1.0, 1.0], [-1.0, 0.0], breakpoints=[2.3])
    assert run.success and run.y[0, -1] == pytest.approx(1.0 - 2.3 - 5.0 * 2.7, rel=1e-6)
