"""The methods on complex states."""

from . import ON_PAIRS, bdf, dop853, radau, rk4, rk23, rk45, taylor, tsit5, vern7, vern9
from .complex_states import on_complex_states, sum_of_squares_of_pairs

FILES = ((rk23.RK23, rk23), (rk45.RK45, rk45), (tsit5.TSIT5, tsit5), (rk4.RK4, rk4),
         (vern7.VERN7, vern7), (vern9.VERN9, vern9))  # fmt: skip
ON_COMPLEX_STATES = (
    on_complex_states(
        dop853.DOP853, dop853.TABLE, dop853.make_both_estimates(sum_of_squares_of_pairs, 2)
    ),
    *[on_complex_states(method, file.TABLE) for method, file in FILES],
    *[on_complex_states(method, None) for method in (bdf.BDF, radau.RADAU)],
    taylor.TAYLOR._replace(name=taylor.TAYLOR.name + ON_PAIRS),
)
