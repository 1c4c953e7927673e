"""Claims about guesses of the start of `solve_dae`, in any unit and at any tolerance."""

import pytest

from fastdyn import solve_dae


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e6])
def test_a_rough_guess_does_at_any_tolerance(tolerance, unit):
    """A cubic of one root, in any unit: Newton's iteration ends at rounding."""

    def equations(t, y, yp):
        z = y[1] / unit
        return [yp[0] + y[0], z**3 + z - y[0] - 2.0]

    for guess in (0.0, 0.3, 0.5, 2.0):
        result = solve_dae(
            equations, (0.0, 1.0), [1.0, guess * unit], rtol=tolerance, atol=1e-2 * tolerance,
            max_steps=1,
        )  # fmt: skip
        z = result.y[1, 0] / unit
        assert abs(z**3 + z - 3.0) < 1e-14
