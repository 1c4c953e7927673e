"""Special functions: compiled code calls SciPy's functions in C by their names."""

import functools

from .functions import function
from .record import add

IN_C = "scipy_special_"  # with the name in SciPy: the name in C, which the loader knows
OF_ONE = (
    "j0 j1 y0 y1 i0 i0e i1 i1e k0 k0e k1 k1e psi rgamma ellipk ellipkm1 ellipe exp1 expi exprel "
    "logit log_expit cosm1 exp10 cosdg sindg tandg entr erfinv erfcinv erfcx erfi dawsn ndtr "
    "log_ndtr ndtri loggamma spence zetac"
)
OF_MORE = (
    "jv jve yv yve iv ive kv kve gammainc gammaincc beta betaln ellipkinc ellipeinc kn expn struve "
    "xlogy xlog1py rel_entr kl_div boxcox inv_boxcox huber pseudo_huber gammaincinv gammainccinv "
    "poch binom chdtr stdtr hyp0f1 hyp1f1 hyp2f1 betainc betaincinv radian"
)


def _value(name, *args):
    import scipy.special  # imported where it is needed: most functions need no SciPy

    return getattr(scipy.special, name)(*args)


add(
    *[
        function(
            IN_C + name, functools.partial(_value, name), cost=100, c=None, js=None,
            aliases=(name,), words="a special function of SciPy",
        )
        for name in (OF_ONE + " " + OF_MORE).split()
    ]
)  # fmt: skip
