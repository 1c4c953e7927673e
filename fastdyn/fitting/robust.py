"""Robust losses of normal residuals, and the errors of fits by them.

P. J. Huber, "Robust Statistics", Wiley 1981, section 7.6.
"""

import numpy as np

from fastdyn.words.near import did_you_mean

MAD = 0.6744897501960817  # median of |r| of the standard normal distribution


def _soft_l1(z):
    root = np.sqrt(1.0 + z)
    return 2.0 * (root - 1.0), 1.0 / root, -0.5 / root**3


def _huber(z):
    inner = z <= 1.0
    root = np.sqrt(np.maximum(z, 1.0))
    return (
        np.where(inner, z, 2.0 * root - 1.0), 1.0 / root, np.where(inner, 0.0, -0.5 / root**3),
    )  # fmt: skip


def _cauchy(z):
    slope = 1.0 / (1.0 + z)
    return np.log1p(z), slope, -(slope**2)


def _arctan(z):
    slope = 1.0 / (1.0 + z**2)
    return np.arctan(z), slope, -2.0 * z * slope**2


LOSSES = {"soft_l1": _soft_l1, "huber": _huber, "cauchy": _cauchy, "arctan": _arctan}


class Loss:
    """A loss rho((r / scale)^2) scale^2 in place of r^2, as `least_squares` has it.

    Parameters
    ----------
    loss : str or callable
        ``loss(z)`` returns rho, its first and its second derivative, shape (3, m).
    scale : float
        The residual at which rho turns away from the square.
    """

    def __init__(self, loss, scale):
        self.scale = scale
        self._rho = loss if callable(loss) else LOSSES[loss]

    def __call__(self, z):
        found = np.asarray(self._rho(z), float)
        if found.shape != (3, len(z)):
            raise ValueError(
                f"`loss` must return rho and two derivatives, shape (3, {len(z)}); got "
                f"{found.shape}."
            )
        return found

    def total(self, r):
        """The sum of the losses of residuals."""
        return float(self.scale**2 * self((r / self.scale) ** 2)[0].sum())

    def variance(self, r, n_parameters):
        """The factor of the inverse of J'J in the covariance, Huber's (6.5) in section 7.6."""
        z = (r / self.scale) ** 2
        _, first, second = self(z)
        psi = r * first
        slope = first + 2.0 * z * second
        mean = slope.mean()
        free = len(r) - n_parameters
        if not (mean > 0 and free > 0):
            return np.inf
        correction = 1.0 + n_parameters / len(r) * slope.var() / mean**2
        return float(correction**2 * (psi @ psi) / free / mean**2)


def loss_of(loss, scale):
    """The Loss of the arguments `loss` and `f_scale` of `fit`; None for squares."""
    if not (isinstance(scale, int | float | np.number) and scale > 0 and np.isfinite(scale)):
        raise ValueError(f"`f_scale` must be a number above 0; got {scale!r}.")
    if isinstance(loss, str) and loss == "linear":
        return None
    if not callable(loss) and not (isinstance(loss, str) and loss in LOSSES):
        advice = did_you_mean(str(loss), LOSSES)
        raise ValueError(
            f"`loss={loss!r}` is unknown; {advice or 'choose from linear, ' + ', '.join(LOSSES)}."
        )
    return Loss(loss, float(scale))
