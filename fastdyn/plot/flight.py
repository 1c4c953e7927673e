"""The figure of a flight in space: the trajectory, height and speed."""

from typing import Any

from . import solution, style


def figure(results, speed, **options):
    """
    Trajectories in space, beside height and speed against time.

    Parameters
    ----------
    results : dict of str to OdeResult
        Results by label, their states beginning with x, y, z.
    speed : callable
        The speed as a quantity, for the first of the systems; others bring their own.
    """
    from matplotlib import pyplot
    from matplotlib.ticker import MaxNLocator

    with style.slides():
        size = {"figsize": (13, 6.5), "layout": "constrained"}
        drawing = pyplot.figure(**size | options)
        grid = drawing.add_gridspec(2, 2, width_ratios=(3, 2))
        space: Any = drawing.add_subplot(grid[:, 0], projection="3d")
        height = drawing.add_subplot(grid[0, 1])
        fast = drawing.add_subplot(grid[1, 1], sharex=height)
        for label, result in results.items():
            t, y = solution.curve(result)
            (line,) = space.plot(*y[:3], label=label)
            space.plot(y[0], y[1], 0.0 * y[2], color=line.get_color(), lw=1.0, ls=":")
            height.plot(t, y[2], label=label)
            fast.plot(t, result.system.along(result.system.quantities.get("speed", speed), t, y))
        space.set(xlabel="x (m)", ylabel="y (m)", zlabel="z (m)")
        for axis in (space.xaxis, space.yaxis, space.zaxis):
            axis.labelpad = 12
            axis.set_major_locator(MaxNLocator(4))
        space.set_box_aspect(None, zoom=0.9)
        height.axhline(0.0, color="0.4", lw=2)
        height.set_ylabel("height z (m)")
        fast.set(xlabel="t (s)", ylabel="speed (m/s)")
        fast.set_ylim(bottom=0.0)
        style.legend(drawing, height)
    return drawing
