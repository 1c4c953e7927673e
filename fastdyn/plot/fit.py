"""Measured values, the fitted motions with their bands, and the residuals."""

from typing import NamedTuple

import numpy as np

from fastdyn.plot import style


class Drawn(NamedTuple):
    """One record in a picture.

    Attributes
    ----------
    name : str
    t : ndarray, shape (k,)
    motion, band : ndarray, shape (n_series, k)
        The fitted motion, and half the width of its band.
    times, values, residuals : ndarray, shapes (n_times,), (n_series, n_times), (n_series, n_times)
    """

    name: str
    t: np.ndarray
    motion: np.ndarray
    band: np.ndarray
    times: np.ndarray
    values: np.ndarray
    residuals: np.ndarray


def fitted(records, of_band, **options):
    """A column for each series: values and motions above, residuals below.

    Parameters
    ----------
    records : list of Drawn
    of_band : str
        The words for the band in the legend.
    """
    n_series = len(records[0].values)
    many = len(records) > 1
    with style.slides():
        figure = style.new_figure(**{"figsize": (2.0 + 5.0 * n_series, 6.0)} | options)
        panels = figure.subplots(
            2, n_series, sharex=True, squeeze=False, gridspec_kw={"height_ratios": [2, 1]}
        )
        for i, (above, below) in enumerate(panels.T):
            below.axhline(0.0, color="0.5", linewidth=1.0)
            for k, one in enumerate(records):
                colour = style.COLOURS[k % len(style.COLOURS)]
                points = colour if many else "0.4"
                measured = "" if many else "measured"
                motion = one.motion[i]
                band = one.band[i]
                above.plot(one.times, one.values[i], ".", color=points, label=measured or None)
                above.plot(one.t, motion, color=colour, label=one.name if many else "fitted")
                above.fill_between(
                    one.t, motion - band, motion + band, where=np.isfinite(band), alpha=0.3,
                    color=colour, linewidth=0, label=None if k else of_band,
                )  # fmt: skip
                below.plot(one.times, one.residuals[i], ".", color=points)
            below.set(xlabel="time", ylabel="residual (σ)" if i == 0 else "")
            if n_series > 1:
                above.set_title(f"series {i}")
        style.legend(figure, *panels[0])
    return figure
