"""Claims about drift studies: verdicts, statistics, memory."""

import math

import numpy as np
import pytest
from scipy.integrate import OdeSolver

import fastdyn
from fastdyn.drift.growth import BOUNDED, LINEAR, UNDECIDED, WALK, WORSE, growth
from fastdyn.drift.rounding import of_rounding
from fastdyn.systems import pendulum, satellite, suspension

EPS = np.finfo(float).eps

T = np.arange(1.0, 1001.0)

SERIES = {
    "noise": (lambda r: r.normal(size=1000), BOUNDED),
    "a swing and noise": (lambda r: np.sin(0.3 * T) + 0.1 * r.normal(size=1000), BOUNDED),
    "an offset": (lambda r: 5.0 + 1e-3 * r.normal(size=1000), BOUNDED),
    "a walk": (lambda r: np.cumsum(r.normal(size=1000)), WALK),
    "a walk under noise": (
        lambda r: np.cumsum(r.normal(size=1000)) + 2.0 * r.normal(size=1000), WALK,
    ),
    "a line": (lambda r: -0.01 * T + r.normal(size=1000), LINEAR),
    "a line below its noise": (lambda r: 0.002 * T + r.normal(size=1000), LINEAR),
    "a line and a walk": (lambda r: 0.5 * T + np.cumsum(r.normal(size=1000)), LINEAR),
    "a parabola": (lambda r: 1e-5 * T**2 + 0.3 * r.normal(size=1000), WORSE),
}  # fmt: skip


@pytest.mark.parametrize("name", SERIES)
def test_verdicts_on_series_of_known_growth(name):
    """Of a hundred series at most a quarter is misjudged: a random walk may well look bounded."""
    make, verdict = SERIES[name]
    found = [growth(T, make(np.random.default_rng(seed))).verdict for seed in range(100)]
    assert found.count(verdict) >= 75


def test_nothing_is_said_of_few_points_or_nan():
    assert growth(T[:20], T[:20]).verdict == UNDECIDED
    assert growth(T, np.full(1000, np.nan)).verdict == UNDECIDED


def test_slope_and_its_error():
    rng = np.random.default_rng(1)
    errors = [growth(T, 0.5 * T + rng.normal(size=1000)) for _ in range(200)]
    off = np.array([(g.slope - 0.5) / g.slope_error for g in errors])
    assert abs(off.mean()) < 0.3 and 0.8 < off.std() < 1.2


ORBIT = satellite(V=1.14)


@pytest.mark.parametrize(
    "method, options, verdicts",
    [
        ("VelocityVerlet", {"steps_per_period": 200}, {BOUNDED}),
        ("BlanesMoan4", {"steps_per_period": 60}, {BOUNDED}),
        ("RK4", {"steps_per_period": 200}, {LINEAR, WORSE}),
        ("RK45", {"rtol": 1e-8, "atol": 1e-11}, {LINEAR}),
        ("Gauss16", {"steps_per_period": 20}, {WALK, BOUNDED, UNDECIDED}),
    ],
)
def test_methods_of_known_behaviour(method, options, verdicts):
    study = fastdyn.energy_drift(ORBIT, method, periods=1000, samples=500, **options)
    assert study.drifts["energy"].growth.verdict in verdicts and study.message == ""
    assert len(study.t) == 500 and study.y.shape == (4, 500)
    assert str(study).count("\n") - ("before the first step" in str(study)) == 2


@pytest.mark.few
@pytest.mark.parametrize("method", ["Gauss16", "GaussNystrom16"])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.6])
def test_gauss16_follows_brouwers_law(e, method):
    """2^-53 times the square root of the number of steps, and a small factor."""
    orbit = satellite(V=math.sqrt(1.0 + e))
    steps = {0.0: 12, 0.3: 20, 0.6: 56}[e]
    study = fastdyn.energy_drift(orbit, method, steps_per_period=steps, periods=5000)
    law = 2.0**-53 * math.sqrt(study.n_steps)
    assert study.drifts["energy"].rms < 6.0 * law
    assert study.drifts["angular_momentum"].rms < 6.0 * law


@pytest.mark.parametrize("method", ["EnergyConserving2", "EnergyConserving4"])
@pytest.mark.parametrize("system", [pendulum(V0=5.0), ORBIT], ids=str)
def test_energy_is_conserved_to_rounding(method, system):
    study = fastdyn.energy_drift(system, method, steps_per_period=60, periods=100)
    assert study.drifts["energy"].largest < 6.0 * 2.0**-53 * math.sqrt(study.n_steps)


@pytest.mark.parametrize(
    "method, step, q", [("EnergyConserving2", 0.3, 0.5), ("Gauss16", 0.2, 1.0)]
)
def test_no_step_in_fifty_thousand_ends_its_iteration_early(method, step, q):
    """Where one of two components is right by chance at first, and the other waits for its turn."""
    study = fastdyn.energy_drift(
        lambda t, y: [y[1], -math.sin(y[0])], method, step=step, n_steps=50_000, samples=50_000,
        y0=[q, 0.0], invariants={"energy": lambda t, y: 0.5 * y[1] * y[1] - math.cos(y[0])},
    )  # fmt: skip
    assert np.abs(np.diff(study.drifts["energy"].mean)).max() < 8 * EPS


def test_compensated_sums_keep_what_rounding_cuts_off():
    """3000 orbits, 273 000 steps of 11 stages: uncompensated, 1e-13 and more."""
    orbit = satellite(V=math.sqrt(1.3))
    study = fastdyn.energy_drift(orbit, "BlanesMoan6", steps_per_period=182, periods=1000)
    energy = study.drifts["energy"]
    assert np.ptp(energy.mean) < 20 * EPS


@pytest.mark.parametrize("t0", [0.0, 3e7, 1e8, 1e9])
def test_late_steps_have_few_bits_and_squares_that_round_to_no_side(t0):
    """Squares of odd numbers leave 1 by 8: 7e-12 in 20 000 orbits on a circle from t = 1e8 on."""
    orbit = satellite(V=1.0)
    end, start = t0 + 20_000 * orbit.period, orbit.initial_state()
    run = fastdyn.solve_ivp(
        orbit.rhs, (t0, end), start, "Taylor", args=orbit.args, rtol=EPS, atol=EPS, t_eval=[end]
    )
    before, after = (orbit.invariants["energy"](0, y, *orbit.args) for y in (start, run.y[:, -1]))
    assert abs(after / before - 1.0) < 20 * 2.0**-53 * math.sqrt(run.n_accepted)


def test_statistics_are_those_of_the_values():
    run = ORBIT.solve((0.0, 50.0), method="VelocityVerlet", step=0.05)
    values = run.invariants()["energy"]
    change = (values[1:] - values[0]) / abs(values[0])
    study = fastdyn.energy_drift(ORBIT, "VelocityVerlet", step=0.05, t_end=50.0, samples=10)
    energy = study.drifts["energy"]
    bins = change.reshape(10, 100)
    assert np.allclose(energy.mean, bins.mean(axis=1), rtol=1e-9, atol=4 * EPS)
    assert np.allclose(energy.low, bins.min(axis=1), rtol=1e-9, atol=4 * EPS)
    assert np.allclose(energy.high, bins.max(axis=1), rtol=1e-9, atol=4 * EPS)
    assert energy.largest == pytest.approx(np.abs(change).max(), rel=1e-9)
    assert energy.rms == pytest.approx(np.sqrt(np.mean(change**2)), rel=1e-9)
    assert np.array_equal(study.y[:, -1], run.y[:, -1]) and study.n_steps == 1000
    assert study.phase == pytest.approx(study.phase, abs=0) and study.phase.shape == (10,)


def test_functions_of_the_user_and_looks_now_and_then():
    def fun(t, y, k):
        return [y[1], -k * y[0]]

    def energy(t, y, k):
        return 0.5 * y[1] ** 2 + 0.5 * k * y[0] ** 2

    given = {"y0": [1.0, 0.0], "invariants": {"energy": energy}, "args": (4.0,)}
    study = fastdyn.energy_drift(
        fun, "VelocityVerlet", step=0.01, n_steps=10_000, every=10, samples=50, **given
    )
    assert study.n_steps == 10_000 and study.drifts["energy"].largest < 1e-3
    assert study.phase is None


@pytest.mark.parametrize(
    "call, error, sentence",
    [
        (lambda: fastdyn.energy_drift(ORBIT, step=0.1), ValueError, "how long is the run"),
        (lambda: fastdyn.energy_drift(ORBIT, periods=1, t_end=1), ValueError, "one of"),
        (lambda: fastdyn.energy_drift(ORBIT, periods=1), ValueError, "`step`"),
        (lambda: fastdyn.energy_drift(ORBIT, n_steps=5), ValueError, "give `step` too"),
        (lambda: fastdyn.energy_drift(ORBIT, OdeSolver, t_end=1.0), ValueError, "SciPy's"),
        (lambda: fastdyn.energy_drift(len, y0=[1.0], t_end=1.0), ValueError, "no `invariants`"),
        (lambda: fastdyn.energy_drift(len, t_end=1.0), TypeError, "`y0`"),
        (lambda: fastdyn.energy_drift(ORBIT, step=1, t_end=9, every=0), ValueError, "`every`"),
        (
            lambda: fastdyn.drift.compare_drift(ORBIT, ["rk45"], evaluations=9, periods=1),
            ValueError,
            'did you mean "RK45"',
        ),
        (
            lambda: fastdyn.drift.compare_drift(ORBIT, ["RK45"], evaluations=9, step=1, periods=1),
            ValueError,
            "give one of `evaluations`",
        ),
    ],
)
def test_wrong_studies_get_a_sentence(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()


def test_a_step_that_does_not_converge_says_so():
    run = fastdyn.solve_ivp(
        lambda t, y: [12.0 * y[1], -12.0 * y[0]], (0, 5), [1.0, 0.0], "Gauss16", step=1.0
    )
    assert run.status == -1 and "do not converge: reduce `step=1`" in run.message


def test_comparison_at_equal_work():
    found = fastdyn.drift.compare_drift(
        suspension(), ["VelocityVerlet", "Gauss8"], evaluations=400, periods=50
    )
    works = [study.nfev / 50 for study in found.values()]
    assert works == pytest.approx([400, 400], rel=0.2)
    figure = found.plot()
    assert figure.axes[-1].get_xlabel() == "t (s)" and "Gauss8" in str(found)


@pytest.mark.hunt
def test_comparison_in_equal_time():
    """What is measured differs from run to run: only that steps follow it is claimed."""
    methods, given = ["VelocityVerlet", "Gauss16"], {"periods": 3, "samples": 64}
    short, long = (
        fastdyn.drift.compare_drift(ORBIT, methods, seconds=seconds, **given)
        for seconds in (2e-5, 2e-3)
    )
    for name in methods:
        assert long[name].n_steps > 5 * short[name].n_steps
    assert short["VelocityVerlet"].n_steps > 5 * short["Gauss16"].n_steps
    assert "us / time" in str(short)
    with pytest.raises(ValueError, match="give their size as `step`"):
        fastdyn.drift.compare_drift(ORBIT, methods, **given)
    with pytest.raises(ValueError, match="the same steps again"):
        fastdyn.drift.compare_drift(ORBIT, methods, seconds=1e-4, checkpoint="x.npz", **given)


def test_adaptive_methods_are_given_the_errors_of_the_others():
    """At solve_ivp's `rtol` of 1e-3 the satellite of RK45 falls into the planet."""
    methods = ["RK45", "VelocityVerlet", "Taylor"]
    found = fastdyn.drift.compare_drift(ORBIT, methods, steps_per_period=100, periods=60)
    assert list(found) == methods
    errors = [study.drifts["energy"].largest for study in found.values()]
    assert all(0.1 < error / errors[1] < 2.0 for error in errors)
    assert found["RK45"].rtol < 1e-5 and "rtol" in str(found)


def test_adaptive_methods_are_given_the_work_of_the_others():
    found = fastdyn.drift.compare_drift(ORBIT, ["Gauss8", "DOP853"], evaluations=600, periods=30)
    assert [s.nfev / 30 for s in found.values()] == pytest.approx([600, 600], rel=0.2)


def test_the_time_before_the_first_step_is_told_apart():
    study = fastdyn.energy_drift(ORBIT, "VelocityVerlet", step=0.1, n_steps=10)
    study.seconds, study.preparation = 1e-5, 3.0
    assert "to trace and to compile: VelocityVerlet 3 s" in str(study)
    assert f"{1e-5 / study.t[-1] * 1e6:.3g}" in str(study)


def walks(seed, n=96):
    return np.cumsum(np.random.default_rng(seed).normal(size=(n, 1)), axis=0)


def test_the_rounding_of_walks_is_found():
    """Steps of 1 a bin are walks of sqrt(n); an error of the method is the same in both."""
    t = np.arange(1.0, 97.0)
    method = 1e3 * np.sin(t)[:, None]
    states = 2 * [np.ones((96, 1))]
    found = [
        of_rounding(t, states, [walks(k) + method, walks(1000 + k) + method], 9600.0, True)[0]
        for k in range(200)
    ]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(np.sqrt(9600.0), rel=0.1)
    parted = [np.ones((96, 1)), np.ones((96, 1)) + 1e-12 * np.exp(t)[:, None]]
    assert np.isnan(of_rounding(t, parted, [walks(1), walks(2)], 96.0, True)[0])


@pytest.mark.parametrize("method, options", [
    ("GaussNystrom16", {"steps_per_period": 20}),
    ("VelocityVerlet", {"steps_per_period": 400}),
    ("Taylor", {"rtol": 2.3e-16, "atol": 2.3e-16}),
])  # fmt: skip
def test_a_study_tells_its_rounding(method, options):
    """A few times Brouwer's law at most, whatever the error of the method: 1e-4 for Verlet."""
    study = fastdyn.energy_drift(ORBIT, method, periods=1000, **options)
    energy = study.drifts["energy"]
    assert 1e-17 < energy.rounding < 6.0 * 2.0**-53 * math.sqrt(study.n_steps)
    assert f"rounding {energy.rounding:.1e}" in str(study)
    silent = fastdyn.energy_drift(ORBIT, method, periods=10, rounding=False, **options)
    assert math.isnan(silent.drifts["energy"].rounding) and "rounding" not in str(silent)


def test_the_rounding_of_an_invariant_that_is_zero_at_the_start():
    """The neighbour's is 4e-16 there, and its changes are not relative to that."""
    study = fastdyn.energy_drift(
        lambda t, y: [y[1], -y[0]], "Gauss16", y0=[1.0, 0.0], step=0.3, n_steps=20_000,
        invariants={"excess": lambda t, y: y[0] ** 2 + y[1] ** 2 - 1.0},
    )  # fmt: skip
    excess = study.drifts["excess"]
    assert excess.start == 0.0 and 1e-17 < excess.rounding < 1e-13


def test_memory_does_not_depend_on_the_number_of_steps():
    tracemalloc = pytest.importorskip("tracemalloc")
    n = 1_000_000
    tracemalloc.start()
    fastdyn.energy_drift(ORBIT, "VelocityVerlet", step=0.05, n_steps=n, samples=20)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * n  # one number a step; other threads of the tests' process allocate, too


@pytest.mark.filterwarnings("ignore")
def test_an_invariant_that_changes_what_the_equations_read():
    ends = []
    for in_python in False, True:
        force, seen, kept = {"k": 1.0}, [], []

        def spring(t, y, force=force):
            return [y[1], -force["k"] * y[0]]

        def in_full(t, y, kept=kept, spring=spring):
            kept.append(t)
            return spring(t, y)

        def energy(t, y, force=force, seen=seen):
            seen.append(t)
            force["k"] = 1.0 if len(seen) < 200 else 4.0
            return 0.5 * (y[0] ** 2 + y[1] ** 2)

        study = fastdyn.energy_drift(
            in_full if in_python else spring, "RK4", y0=[1.0, 0.0], invariants={"energy": energy},
            step=0.01, n_steps=1000,
        )  # fmt: skip
        ends.append(study.y)
    assert np.array_equal(*ends) and np.abs(ends[0]).max() > 1.1


@pytest.mark.parametrize(
    "option",
    [{"mass": np.eye(4)}, {"project": lambda t, y: y}, {"domain": lambda t, y: True},
     {"breakpoints": [0.5]}, {"at": [0.5]}],
)  # fmt: skip
def test_what_the_steps_of_a_study_do_not_know_is_refused(option):
    (name,) = option
    with pytest.raises(TypeError, match=f"`energy_drift` takes no `{name}`"):
        fastdyn.energy_drift(ORBIT, "Rodas5P", t_end=1.0, **option)
