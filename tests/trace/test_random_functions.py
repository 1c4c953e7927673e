"""Random functions with branches: machine code beside the function, for other arguments too."""

import numpy as np
import pytest

from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import make as by_tracing
from fastdyn.compile.traced.known import Attempt
from support.branching import drawn
from support.machine_code import called

NEAR = by_tracing.Near(0.0, 1.0, np.full(4, 0.4))
TOLERANCE = 1e-9  # of sums in another order, where they cancel


@pytest.mark.hunt
@pytest.mark.parametrize("seed", range(30))
def test_code_is_the_function_or_there_is_none(seed):
    fun, n, args, text = drawn(seed)
    near = by_tracing.Near(0.0, 1.0, np.full(n, 0.4))
    rng = np.random.default_rng(seed)
    for change in range(3):
        found = by_tracing.traced_function(Attempt(fun, args, DERIVATIVE, n), near)
        if found is None:
            return
        compiled = called(*found[:2], DERIVATIVE, n)
        for i in range(100):
            t, y = rng.normal(), rng.normal(size=n) * (0.3, 1.0, 3.0)[i % 3]
            try:
                expected = np.array(fun(t, y.copy(), *args), float)
            except Exception:
                assert compiled(t, y) is None
                continue
            mine = compiled(t, y)
            scale = 1.0 + np.max(np.abs(expected))
            assert mine is not None, text
            assert np.allclose(mine, expected, rtol=0, atol=TOLERANCE * scale), (t, y, args, text)
        p, q, w, k, m = args
        m.c, k["a"] = 0.9 - 0.3 * change, 0.4
        args = (p + 0.3, q + 1, w * 1.5, k, m)
