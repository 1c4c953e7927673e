"""method="auto": what it takes, and what it says of it."""

import math
import warnings

import numpy as np
import pytest

from fastdyn import StiffnessWarning, solve_ivp
from fastdyn.compile import memory
from fastdyn.run import loop
from support.stiff import hires


def pendulum(t, y):
    return [y[1], -9.81 * math.sin(y[0])]


def stepped(t, y):
    return [np.floor(t) - y[0]]


@pytest.mark.parametrize(
    ("fun", "rtol", "method"),
    [
        (pendulum, 1e-3, "Tsit5"), (pendulum, 1e-6, "Taylor"), (pendulum, 1e-12, "Taylor"),
        (stepped, 1e-7, "Vern7"), (stepped, 1e-10, "Vern9"),
    ],
)  # fmt: skip
def test_the_method_is_named_and_the_same_as_by_its_name(fun, rtol, method):
    y0 = [1.0, 0.0] if fun is pendulum else [1.0]
    run = solve_ivp(fun, (0, 5), y0, "auto", rtol=rtol, atol=rtol)
    same = solve_ivp(fun, (0, 5), y0, method, rtol=rtol, atol=rtol)
    assert run.method == method and len(run.reason) > 10
    assert np.array_equal(run.t, same.t) and np.array_equal(run.y, same.y)


def test_an_event_without_a_series_is_left_to_another_method():
    run = solve_ivp(
        pendulum, (0, 5), [1.0, 0.0], "auto", rtol=1e-8, atol=1e-8,
        events=lambda t, y: abs(y[0]) - 0.5,
    )  # fmt: skip
    assert run.method == "Vern7" and "series" in run.reason and len(run.t_events[0]) > 5


def test_where_taylor_fails_another_method_is_tried():
    """The state comes to rest on a jump, and an option keeps it from being followed by modes.

    Roundings decide whether Vern7 ends there; where it does not, Radau fails, too, which is told.
    """
    run = solve_ivp(
        lambda t, y: [y[1], -y[0] - 0.2 * np.sign(y[1])], (0, 12), [1.0, 0.0], "auto",
        rtol=1e-6, atol=1e-6, project=lambda t, y: y,
    )  # fmt: skip
    if run.status == 0:
        assert run.method == "Vern7" and "Taylor failed" in run.reason
    else:
        assert run.method == "Radau" and "no step is short enough" in run.message


def test_complex_states():
    run = solve_ivp(lambda t, y: 1j * y, (0, 1), [1.0 + 0j], "auto", rtol=1e-8, atol=1e-8)
    assert run.method == "Vern7" and abs(run.y[0, -1] - np.exp(1j)) < 1e-6


@pytest.mark.few(3)
@pytest.mark.parametrize("value", [-1e6, -1e6 + 1e6j, -3e5 - 1e6j, 1e6j])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_a_stiff_complex_problem_begins_anew(value, rtol):
    """By Vern7 it would take 10^8 evaluations; oscillations that hardly show count, too."""

    def fun(t, z):
        return [value * (z[0] - np.exp(1j * t)) + 1j * np.exp(1j * t), 1j * z[1]]

    run = solve_ivp(fun, (0, 30), [1.0 + 0j, 1.0], "auto", rtol=rtol, atol=1e-9)
    assert run.method == "Radau" and "the problem is stiff" in run.reason and run.nfev < 50_000
    assert np.abs(run.y[:, -1] - np.exp(30j)).max() < 1e4 * rtol


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_stiff_complex_problem_in_python():
    def fun(t, z):
        return [(-1e4 + 2e3j) * (z[0] - np.exp(1j * t)), len(str(z[1])) * 0 + 1j * z[1]]

    run = solve_ivp(fun, (0, 10), [1.0 + 0j, 1.0], "auto", rtol=1e-6, atol=1e-9)
    assert run.method == "Radau" and "the problem is stiff" in run.reason
    assert abs(run.y[1, -1] - np.exp(10j)) < 1e-3


@pytest.mark.parametrize("angle", [180, 150, 135, 120, 106])
def test_damped_oscillations_are_stiff(angle):
    """A pair of eigenvalues of size 10^4, for a run that moves slowly."""
    a, b = 1e4 * np.cos(np.deg2rad(angle)), 1e4 * np.sin(np.deg2rad(angle))

    def fun(t, y):
        u, v = y[0] - np.cos(t), y[1] - 0.3
        return [a * u - b * v, b * u + a * v]

    run = solve_ivp(fun, (0, 300), [1.0, 0.3], "auto", rtol=1e-7, atol=1e-9)
    assert run.method == "Radau" and run.nfev < 50_000


def robertson(t, y):
    a, b, c = y
    return [-0.04 * a + 1e4 * b * c, 0.04 * a - 1e4 * b * c - 3e7 * b * b, 3e7 * b * b]


def cut(t, y):
    """As stiff, for Tsit5 and Vern9: it has no series."""
    return [-1e6 * (y[0] - np.cos(t)) + 0.0 * np.floor(t)]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("fun", "y0"), [(robertson, [1.0, 0.0, 0.0]), (cut, [1.0])])
@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_a_stiff_problem_begins_anew(rtol, fun, y0):
    """By an explicit method it would take a second to a minute."""
    t = np.linspace(0.0, 1e4 if fun is robertson else 100.0, 7)
    run = solve_ivp(fun, t[[0, -1]], y0, "auto", t_eval=t, rtol=rtol, atol=1e-9)
    same = solve_ivp(fun, t[[0, -1]], y0, "Radau", t_eval=t, rtol=rtol, atol=1e-9)
    assert run.method == "Radau" and "the problem is stiff" in run.reason
    assert np.array_equal(run.y, same.y) and run.nfev == same.nfev


def test_others_are_not_given_up_for_it():
    """Half a second of an oscillator."""
    run = solve_ivp(pendulum, (0, 2e5), [1.0, 0.0], "auto", rtol=1e-6, t_eval=[2e5])
    assert run.method == "Taylor" and run.n_accepted > 400_000


def limited(t, y):
    return [0.1 if y[0] <= 1.0 else 0.0]


@pytest.mark.parametrize(
    ("fun", "t_end", "y0", "rtol"),
    [
        (hires, 321.8, [1, 0, 0, 0, 0, 0, 0, 0.0057], 1e-3), (robertson, 1e4, [1, 0, 0], 1e-6),
        (pendulum, 1e4, [1.0, 0.0], 1e-6), (limited, 20, [0.0], 1e-6), (cut, 30, [1.0], 1e-3),
    ],
)  # fmt: skip
def test_the_clock_decides_nothing(monkeypatch, fun, t_end, y0, rtol):
    """Chunks of one step, of 0.05 s and of 1000 s: a slow machine, this one, and a fast one."""

    def solved():
        run = solve_ivp(fun, (0, t_end), y0, "auto", rtol=rtol)
        return run.method, run.reason, run.nfev, run.y.tobytes()

    expected = solved()
    for seconds in (0.0, 1e3):
        monkeypatch.setattr(loop, "CHUNK_SECONDS", seconds)
        assert solved() == expected


@pytest.mark.parametrize("option", ["sensitivity", "adjoint"])
@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_derivatives_of_a_stiff_problem_are_those_of_radau(option, rtol):
    how = {option: ("y0",), "rtol": rtol, "atol": 1e-9, "t_eval": [10.0, 1e3]}
    run = solve_ivp(robertson, (0, 1e3), [1.0, 0.0, 0.0], "auto", **how)
    same = solve_ivp(robertson, (0, 1e3), [1.0, 0.0, 0.0], "Radau", **how)
    assert run.method == "Radau" and np.array_equal(run.y, same.y)
    if option == "sensitivity":
        assert np.array_equal(run.sensitivity["y0"], same.sensitivity["y0"])
    else:
        g = np.ones((3, 2))
        np.testing.assert_array_equal(run.vjp(g)["y0"], same.vjp(g)["y0"])


def test_stiffness_is_told_of_beside_sensitivities():
    with pytest.warns(StiffnessWarning, match="took .* steps"):
        solve_ivp(lambda t, y: [-3e3 * (y[0] - np.cos(t))], (0, 9), [0.0], sensitivity="y0")


def test_robertson_at_the_default_tolerance():
    """Written thus, it leaves the numbers at t = 0.3, by Tsit5 and by its roundings."""

    def rob(t, y):
        return [
            -0.04 * y[0] + 1e4 * y[1] * y[2],
            0.04 * y[0] - 1e4 * y[1] * y[2] - 3e7 * y[1] ** 2,
            3e7 * y[1] ** 2,
        ]

    run = solve_ivp(rob, (0, 1e5), [1, 0, 0], "auto")
    assert run.method == "Radau" and run.status == 0 and "Tsit5 failed" in run.reason
    assert abs(run.y[0, -1] - 0.01786592) < 1e-4


def test_a_failure_of_stability_is_called_stiff():
    run = solve_ivp(robertson, (0, 1e5), [1.0, 0.0, 0.0], "Tsit5")
    assert run.status == -1 and "as long as stability allows" in run.message


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_singularity_is_told_by_the_first_method(rtol):
    run = solve_ivp(lambda t, y: [y[0] ** 2], (0, 2), [1.0], "auto", rtol=rtol)
    assert run.status == -1 and "blows up at t = 1.0" in run.message.replace("0.9999", "1.0")
    assert run.method != "Radau" and run.nfev < 1000


def overflows(t, y):
    return [1.0 - math.exp(1000 * (y[0] - math.sin(t) - 0.1))]


def emptied(t, y):
    return [0.01 - 3 * math.sqrt(y[0])]


@pytest.mark.parametrize(("fun", "y0"), [(overflows, 0.1), (emptied, 1.0)])
def test_an_exception_in_a_stage_leads_to_another_method(fun, y0):
    run = solve_ivp(fun, (0, 5), [y0], "auto")
    tight = solve_ivp(fun, (0, 5), [y0], "Taylor", rtol=1e-11, atol=1e-13)
    assert run.status == 0 and "`fun` raised" in run.reason
    assert abs(run.y[0, -1] - tight.y[0, -1]) < 1e-3 * abs(tight.y[0, -1]) + 1e-6


def test_an_exception_of_all_methods_is_told():
    def known_for_a_while(t, y):
        if t > 1:
            raise ValueError("beyond the data")
        return [-y[0]]

    with pytest.raises(ValueError, match="beyond the data"):
        solve_ivp(known_for_a_while, (0, 5), [1.0], "auto")


def test_what_begins_anew_warns_once():
    kept = [0.0]

    def counting(t, y):
        kept[0] += 1e-9 * y[0]
        return [-1e5 * (y[0] - np.cos(t)) + kept[0]]

    def hit(t, y):
        return y[0] - 0.5

    hit.Terminal = True
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        found = solve_ivp(
            counting, (0, 2), [0.0], method="auto", events=hit, breakpoints=[50.0], rtoll=1.0
        )
    said = [str(one.message) for one in heard]
    assert found.method == "Radau" and len(said) == len({*said}) >= 5
    assert any("keeps `kept[0]`" in one for one in said)
    assert any("`Terminal`" in one for one in said)
    with pytest.warns(UserWarning, match="rtoll"):  # the next call is told again
        solve_ivp(pendulum, (0, 1e-3), [0.0, 0.0], method="auto", rtoll=1.0)


def test_no_sentence_recommends_what_was_taken_already():
    def grows(t, y):
        return [-1e4 * (y[0] - np.cos(t)), y[1] ** 2]

    def slides(t, y):
        return [-1.0 if y[0] > 0.0 else 1.0, 1.0]

    auto, pair = (
        solve_ivp(grows, (0, 2), [0.0, 50.0], method=method).message for method in ("auto", "Tsit5")
    )
    assert "the problem is stiff; take Radau." in pair
    assert "the problem is stiff. Radau failed, too." in auto
    for method, words in (("auto", "other. Give an event"), ("Tsit5", "Take method='auto'")):
        memory.forget()
        with pytest.warns(StiffnessWarning) as heard:
            solve_ivp(slides, (0, 2), [0.5, 0.0], method=method, callback=lambda solver: None)
        assert words in str(heard[0].message)


@pytest.mark.parametrize(("n", "method"), [(2, "Rodas5P"), (40, "Radau")])
def test_a_mass_matrix_goes_to_an_implicit_method(n, method):
    """y0' = -y0 and 0 = y0 - y_i."""
    mass = np.zeros((n, n))
    mass[0, 0] = 1.0

    def fun(t, y):
        return np.append(-y[0], y[0] - y[1:])

    given = {"mass": mass, "rtol": 1e-7, "atol": 1e-9}
    run = solve_ivp(fun, (0, 1), np.ones(n), "auto", **given)
    assert run.method == method and "mass" in run.reason
    assert np.allclose(run.y[:, -1], np.exp(-1.0), rtol=1e-5)


@pytest.mark.parametrize(
    ("n", "rtol", "force", "method"),
    [
        (62, 1e-10, lambda s: s**3, "Vern9"),
        (62, 1e-10, lambda s: s / (1 + s * s) ** 1.5, "Vern9"),
        (62, 1e-8, lambda s: s**3, "Vern7"),
        (60, 1e-10, lambda s: s**3, "Taylor"),
        (62, 1e-12, lambda s: s**3, "Taylor"),
        (62, 1e-10, np.sin, "Taylor"),
    ],
)
def test_many_components_without_sines_are_for_pairs(n, rtol, force, method):
    """Taylor would take longer, not only to compile."""

    def chain(t, y):
        x, v = np.split(y, 2)
        pull = force(np.diff(x, prepend=0.0, append=0.0))
        return np.concatenate((v, pull[1:] - pull[:-1]))

    run = solve_ivp(chain, (0, 0.1), np.linspace(0.0, 1.0, n), "auto", rtol=rtol, t_eval=[0.1])
    assert run.method == method
    assert ("60 components" in run.reason) == (n > 60 and method != "Taylor")


@pytest.mark.filterwarnings("ignore:.*runs in Python")
def test_a_solve_within_fun_reacts_by_itself():
    """Its steps, which stability limits, are warned of; they do not end the solve by "auto"."""
    inner = []

    def fast(t, y):
        return [-1e5 * (y[0] - 1.0)]

    def fun(t, y):
        inner.append(solve_ivp(fast, (0, 0.2), [0.0]).success if len(inner) < 3 else True)
        return [-y[0]]

    with pytest.warns(StiffnessWarning):
        run = solve_ivp(fun, (0, 1), [1.0], "auto")
    assert run.success and run.method == "Tsit5" and all(inner)


def test_friction_in_the_plane_crawls_and_is_told():
    """v / |v| with a guard: no implicit method and no average helps where v is as atol."""

    def fun(t, y):
        v = np.hypot(y[2], y[3])
        s = 1.0 / v if v > 1e-12 else 0.0
        return [y[2], y[3], -0.5 * y[2] * s + 0.3 * np.sin(t), -0.5 * y[3] * s + 0.1]

    start = [0.0, 0.0, 1.0, 0.5]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StiffnessWarning)
        expected = solve_ivp(fun, (0, 10), start, "RK23", rtol=1e-6)
    with pytest.warns(StiffnessWarning, match="as at a switch, such as v / |v|") as caught:
        run = solve_ivp(fun, (0, 10), start, "auto")
    along, alone = (str(each.message) for each in caught)
    assert "along switches" in along and "as at a switch" in alone
    assert run.status == 0 and run.nfev < 10**6
    assert run.y[:2, -1] == pytest.approx(expected.y[:2, -1], rel=2e-3)
    assert np.abs(run.y[2:, -1]).max() < 1e-4
