"""Bessel and gamma functions: compiled code calls SciPy's functions in C by their names."""

import functools

from .functions import function
from .record import add

IN_C = "scipy_special_"  # with the name in SciPy: the name in C, which the loader knows
OF_ONE = "j0 j1 y0 y1 i0 i0e i1 i1e k0 k0e k1 k1e psi rgamma ellipk ellipkm1 ellipe exp1 expi"
OF_TWO = "jv jve yv yve iv ive kv kve gammainc gammaincc beta betaln ellipkinc ellipeinc"


def _value(name, *args):
    import scipy.special  # imported where it is needed: most functions need no SciPy

    return getattr(scipy.special, name)(*args)


add(
    *[
        function(
            IN_C + name, functools.partial(_value, name), cost=100, c=None, js=None,
            aliases=(name,), words="a special function of SciPy",
        )
        for name in (OF_ONE + " " + OF_TWO).split()
    ]
)  # fmt: skip
