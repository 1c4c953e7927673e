"""Two models of immunology among RADAR5's examples: thresholds, and hepatitis B.

E. Hairer and N. Guglielmi, "Users' guide for the code RADAR5", Geneva 2005, after P. Waltman, "A
threshold model of antigen-stimulated antibody production", 1978, and G. A. Bocharov and A. A.
Romanyukha, "Mathematical model of antiviral immune response III", J. Theor. Biol. 167 (1994).
"""

import functools

import numpy as np
import pytest

from fastdyn import solve_dde
from fastdyn.delays.equation import METHODS, STIFF

TENFOLD = 10.0
TO_AND_FRO = "a time for which `past` is asked runs to and fro"

HEPATITIS = [
    np.nan, 83.0, 5.0, 6.6e14, 3e11, 0.4, 2.5e7, 5e-13, 2.3e9, 0.052, 0.15, 9.4e9, 1e-15, 1.2,
    2.7e16, 2.0, 5.3e27, 1.0, 1e-18, 2.7e16, 2.0, 8e28, 1.0, 1e-19, 5.3e33, 16.0, 1.6e14, 0.4,
    1e-18, 8e32, 16.0, 0.1, 1e-18, 1.7e30, 3.0, 0.4, 4.3e-22, 8.5e6, 8.6e11, 0.043,
]  # fmt: skip


def hepatitis(t, y, past):
    """Viruses, infected and destroyed cells, macrophages, helpers (2), killers, B, plasma, F."""
    a = HEPATITIS
    virus, ill, dead, eaten, helper, other, killer, b, plasma, f = y
    early, late, last = past(t - 0.6), past(t - 2.0), past(t - 3.0)
    whole = 1.0 - dead / a[7]
    free = a[7] - ill - dead
    return [
        a[1] * ill + a[2] * a[3] * ill * killer - a[4] * virus * f - a[5] * virus
        - a[6] * virus * free,
        a[8] * virus * free - a[3] * ill * killer - a[9] * ill,
        a[3] * ill * killer + a[9] * ill - a[10] * dead,
        a[11] * a[12] * virus - a[13] * eaten,
        a[14] * (whole * a[15] * early[3] * early[4] - eaten * helper)
        - a[16] * eaten * helper * killer + a[17] * (a[18] - helper),
        a[19] * (whole * a[20] * early[3] * early[5] - eaten * other)
        - a[21] * eaten * other * b + a[22] * (a[23] - other),
        a[24] * (whole * a[25] * late[3] * late[4] * late[6] - eaten * helper * killer)
        - a[26] * ill * killer + a[27] * (a[28] - killer),
        a[29] * (whole * a[30] * late[3] * late[5] * late[7] - eaten * other * b)
        + a[31] * (a[32] - b),
        a[33] * whole * a[34] * last[3] * last[5] * last[7] + a[35] * (a[36] - plasma),
        a[37] * plasma - a[38] * f * virus - a[39] * f,
    ]  # fmt: skip


@functools.cache
def infected(method, rtol):
    """The state after 130 days, by a tolerance of components of 1e-15 to 1e-40."""
    a = HEPATITIS
    before = [2.9e-16, 0, 0, 0, a[18], a[23], a[28], a[32], a[36], a[37] * a[36] / a[39]]
    found = solve_dde(hepatitis, (0, 130), before, method, rtol=rtol, atol=1e-20 * rtol)
    assert found.success, found.message
    return found.y[:, -1]


@pytest.mark.parametrize("rtol", 10.0 ** -np.arange(3, 11))
def test_hepatitis_b(rtol):
    """Radau beside its own tighter solution, and beside Rodas5P up to 1e-6, which has other steps.

    (Below, Rodas5P takes 10 000 steps and more: its pivots mix rows of other units.)
    """
    exact = infected("Radau", 1e-11)
    for method in STIFF[: 2 if rtol >= 9e-7 else 0] or ("Radau",):
        error = np.abs(infected(method, rtol) - exact) / (1e-20 + np.abs(exact))
        assert error.max() < TENFOLD * rtol, method


def threshold(t, y, past, t0, t1, least):
    """Antigen, receptors, their complexes, antibody; two thresholds with delays of the state."""
    first = 1.0 if t >= t0 else 0.0
    second = 1.0 if t >= t1 else 0.0
    p = past(first * y[4])
    q = past(second * y[5])
    meets = 5e4 * y[0] * y[1]
    return [
        -meets - 1e5 * y[0] * y[3],
        -meets + 1.8 * 5e4 * p[0] * p[1] * first,
        meets,
        -1e5 * y[0] * y[3] - 0.002 * y[3] + 20.0 * 5e4 * q[0] * q[1] * second,
        first * (y[0] * y[1] + y[2]) / (p[0] * p[1] + p[2]),
        second * (least + y[1] + y[2]) / (least + q[1] + q[2]),
    ]


# The antigen at the start, and the arguments; behind t = 119 a number rises by 1e8 a day, and so by
# more than its tolerance between two times that the computer can tell apart.
CASES = {"RADAR5": (5e-6, (35.0, 197.0, 0.0)), "steep": (7.5e-5, (32.0, 119.0, 1e-12))}


def solved(case, method, rtol, more=0.0, less=1.0):
    """The result to t = 300; `more` is a change of the antigen at the start, as a share.

    `less` divides the absolute tolerances of receptors and of their complexes.
    """
    antigen, args = CASES[case]
    start = [antigen * (1.0 + more), 1e-15, 0.0, 0.0, 0.0, 0.0]
    atol = np.array([1e-12, 1e-12 / less, 1e-12 / less, 1e-12, 1.0, 1.0]) * rtol
    return solve_dde(
        threshold, (0, 300), start, method, args=args, rtol=rtol, atol=atol, max_steps=20_000
    )


@functools.cache
def immune(case, method, rtol, more=0.0, less=1.0):
    """The state at t = 300."""
    found = solved(case, method, rtol, more, less)
    assert found.success, found.message
    args = CASES[case][1]
    assert set(args[:2]) <= set(found.t.round(9).tolist())  # of SciPy's methods, too
    return found.y[:, -1]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES)
def test_waltmans_thresholds(case, method):
    """Receptors grow by 5e4 * 0.8 a day and antigen, read at two times right to t1 and 300 rtol.

    By how much an error at the start grows, another start tells.
    """
    # The start, 1e-15, has an absolute tolerance of 1e-12 rtol.  Other methods err by less.
    start = 1e-12 / 1e-15 if method == "Rodas5P" else 0.0
    for rtol in (1e-7, 1e-9):
        assert share_of(case, immune(case, method, rtol), start) < TENFOLD * rtol


def share_of(case, found, start=0.0):
    """The largest error but that of the antigen, 1e-16, which is below its tolerance."""
    exact = immune(case, "Vern9", 1e-11)
    grown = np.abs(immune(case, "Vern9", 1e-11, 1e-6) / exact - 1) / 1e-6
    antigen, args = CASES[case]
    late = 5e4 * antigen * 0.8 * (args[1] + 300.0)
    return (np.abs(found / exact - 1) / (1 + start + grown + late))[1:].max()


def test_a_rise_that_looks_like_a_fast_decay_at_its_start():
    """Behind t0 the sum of times is sqrt(8 (t - t0)): Rodas5P stepped over, 70 days at once.

    With a tolerance of 1e-3, that of the receptors is their start, and no answer is found.
    """
    for rtol in (1e-4, 1e-5):
        assert share_of("RADAR5", immune("RADAR5", "Rodas5P", rtol)) < TENFOLD * rtol
    found = solved("RADAR5", "Rodas5P", 1e-3)
    assert TO_AND_FRO in found.message


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_tolerances_as_large_as_the_receptors(case, rtol, method):
    """Steps crawled, because receptors below their tolerance decide a delay, without a word."""
    found = solved(case, method, rtol)
    crawls = {
        "Tsit5": case == "RADAR5", "Vern7": rtol == 1e-2 or case == "steep", "Vern9": rtol == 1e-2,
        "Rodas5P": rtol == 1e-3 or case == "RADAR5",
    }  # fmt: skip
    if crawls.get(method, False):
        assert found.status == -1 and len(found.t) < 3000
        assert TO_AND_FRO in found.message and "component" in found.message
    else:
        assert share_of(case, found.y[:, -1], 1e3) < TENFOLD * rtol


def test_a_time_of_the_past_that_the_past_decides_runs_to_and_fro():
    """As above; only the function itself knows for which times it asks."""

    def fun(t, y, past, *args):
        nothing = 0.0 * past(t - 200.0)[4]
        return threshold(t, [*y[:4], y[4] + nothing, y[5]], past, *args)

    antigen, args = CASES["RADAR5"]
    found = solve_dde(
        fun, (0, 300), [antigen, 1e-15, 0, 0, 0, 0], "Tsit5", args=args, rtol=1e-3,
        atol=[1e-15, 1e-15, 1e-15, 1e-15, 1e-3, 1e-3], max_steps=5000,
    )  # fmt: skip
    assert TO_AND_FRO in found.message and "component 1" in found.message


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("less", [1e2, 1e4, 1e6])
def test_receptors_of_a_tolerance_of_their_own(less, method):
    """Radau stepped over the same rise, 7 days at once, and lost all antibodies in silence."""
    for rtol in (1e-3, 1e-5):
        found = solved("RADAR5", method, rtol, less=less)
        if method == "Rodas5P" and rtol == 1e-3:  # see above
            assert TO_AND_FRO in found.message
        else:
            assert share_of("RADAR5", found.y[:, -1]) < TENFOLD * rtol
