"""Measured values, the fitted motion with its band, and the residuals."""

import numpy as np

from fastdyn.plot import style


def fitted(t, prediction, times, values, residuals, level, **options):
    """A column for each series: values and motion above, residuals below.

    Parameters
    ----------
    t : ndarray, shape (k,)
    prediction : tuple of two ndarrays, shape (n_series, k)
        The fitted motion, and half the width of its band.
    times, values, residuals : ndarray, shapes (n_times,), (n_series, n_times), (n_series, n_times)
    level : float
        Confidence of the band.
    """
    n_series = len(values)
    with style.slides():
        figure = style.new_figure(**{"figsize": (2.0 + 5.0 * n_series, 6.0)} | options)
        panels = figure.subplots(
            2, n_series, sharex=True, squeeze=False, gridspec_kw={"height_ratios": [2, 1]}
        )
        for i, (above, below) in enumerate(panels.T):
            motion, band = prediction[0][i], prediction[1][i]
            above.plot(times, values[i], ".", color="0.4", label="measured")
            above.plot(t, motion, color=style.COLOURS[0], label="fitted")
            above.fill_between(
                t, motion - band, motion + band, where=np.isfinite(band), alpha=0.3,
                color=style.COLOURS[0], linewidth=0, label=f"{level:.0%} band",
            )  # fmt: skip
            below.axhline(0.0, color="0.5", linewidth=1.0)
            below.plot(times, residuals[i], ".", color="0.4")
            below.set(xlabel="time", ylabel="residual (σ)" if i == 0 else "")
            if n_series > 1:
                above.set_title(f"series {i}")
        style.legend(figure, *panels[0])
    return figure
