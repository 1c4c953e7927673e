"""The benchmarks measure what they say: stored end states, adapters, interpolation."""

import json

import numpy as np
import pytest

import fastdyn
from bench import rivals
from bench.groups import switches
from bench.groups.stiff import relative_to
from bench.problems import WORK, compiled, error, reference
from bench.problems.delays import DELAYS
from bench.problems.hybrids import HYBRIDS
from bench.problems.reaction_diffusion import brusselator_square
from bench.problems.stiff import STIFF, brusselator
from bench.problems.stiff_physics import PHYSICS
from bench.problems.switches import STATES, TIMES
from bench.report import __main__ as report
from bench.report import last_run, table
from bench.report.equal_error import at_error
from bench.report.panels import front


@pytest.mark.parametrize("problem", WORK, ids=lambda problem: problem.name)
def test_stored_end_state(problem):
    """At the tightest tolerance DOP853 comes close; Arenstorf's orbit magnifies errors the most."""
    fun = problem.fun
    result = fastdyn.solve_ivp(
        fun, problem.t_span, problem.y0, "DOP853", rtol=1e-13, atol=1e-13, args=problem.args
    )
    assert error(result.y[:, -1], reference(problem)) < 1e-8


@pytest.mark.hunt
def test_adapters():
    """Each solver comes within some thousand tolerances of the pendulum's end state."""
    problem = next(p for p in WORK if p.name == "pendulum, swinging")
    for name, prepare in rivals.solvers(problem).items():
        assert error(prepare(1e-9)(), reference(problem)) < 5e-6, name
        with_times = prepare(1e-9, np.linspace(*problem.t_span, 5))
        if with_times is not None:
            assert error(with_times(), reference(problem)) < 5e-6, name


def test_time_at_an_error():
    """Straight in logarithms, nothing beyond what was reached, never more than a better one."""
    points = [(1e-2, 1.0), (1e-4, 10.0), (1e-5, 5.0), (None, 2.0)]
    assert at_error(points, 1e-6) is None
    assert at_error(points, 1e-1) == 1.0
    assert at_error(points, 1e-5) == pytest.approx(5.0)
    assert at_error(points, 10**-3.5) == pytest.approx(5.0**0.5)


def test_a_line_of_the_figure():
    """What another point beats in both error and time is not drawn."""
    points = [(1e-5, 5.0), (1e-4, 10.0), (1e-2, 1.0), (1e-3, 5.0)]
    assert front(points) == [(1e-2, 1.0), (1e-5, 5.0)]


@pytest.mark.few(2)
@pytest.mark.parametrize("given", PHYSICS, ids=lambda given: given.problem.name)
def test_end_states_of_stiff_problems(given):
    """Within a thousand tolerances; the oscillation of Schrödinger's equation is not damped."""
    p, options = given.problem, {"rtol": 1e-8, "atol": 1e-8 * given.floor}
    method = "DOP853" if np.iscomplexobj(p.y0) else "Radau"
    if given.mass is not None:
        method, options["mass"] = "Rodas5P", given.mass
    fun = compiled(p) if p.into else p.fun
    run = fastdyn.solve_ivp(fun, p.t_span, p.y0, method, **options)
    assert relative_to(np.array(given.end), given.floor)(run.y[:, -1]) < 1e-5


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "given",
    [*PHYSICS[:3], brusselator(8), brusselator_square(4), STIFF[0]],
    ids=lambda given: given.problem.name,
)
def test_bands_and_jacobians_of_stiff_problems(given):
    """Beside central differences, right to eps^(2/3) of the scales here but for stray terms."""
    p, rng = given.problem, np.random.default_rng(0)
    fun = compiled(p)
    y = np.array(p.y0) + 0.1 * rng.random(len(p.y0))
    n, dy = len(y), np.diag(1e-5 * np.ones(len(y)))
    found = np.array([(fun(0.1, y + d) - fun(0.1, y - d)) / 2e-5 for d in dy]).T
    i, j = np.nonzero(found)
    if given.band is not None:
        assert ((i - j).max(), (j - i).max()) == given.band
    if given.jacobian is not None:
        exact = np.zeros((n, n))
        given.jacobian(0.1, y, exact)
        assert np.abs(found - exact).max() < 1e-7 * np.abs(exact).max()


@pytest.mark.hunt
def test_rivals_for_stiff_problems():
    """Each comes within a thousand tolerances of Robertson's end, as an ODE and as a DAE."""
    for given in (STIFF[0], PHYSICS[-1]):
        far = relative_to(np.array(given.end), given.floor)
        for name, prepare in rivals.stiff(given).items():
            assert far(prepare(1e-6)()) < 1e-3, name


@pytest.mark.few(2)
@pytest.mark.parametrize("given", DELAYS, ids=lambda given: given.name)
def test_ends_of_delay_equations(given):
    """By DOP853, which did not make them, within a thousand tolerances."""
    run = fastdyn.solve_dde(
        given.fun, (0, given.end), given.history, "DOP853", rtol=1e-11, atol=1e-11
    )
    assert relative_to(np.array(given.solution), 0.0)(run.y[:, -1]) < 1e-8


@pytest.mark.hunt
@pytest.mark.parametrize("given", DELAYS, ids=lambda given: given.name)
def test_delay_equations_by_all(given):
    """Each comes within a thousand tolerances of the end; ddeint, of first order, comes near."""
    far = relative_to(np.array(given.solution), 0.0)
    for name, prepare in rivals.delays(given).items():
        tol, most = (1e-3, 0.5) if name == "ddeint" else (1e-6, 1e-3)
        assert far(prepare(tol)()) < most, name


@pytest.mark.hunt
@pytest.mark.parametrize("given", HYBRIDS, ids=lambda given: given.name)
def test_hybrid_systems_by_all(given):
    """Each comes within some hundred tolerances of the exact end state."""
    far = relative_to(np.array(given.solution), 1.0)
    for name, prepare in rivals.hybrid(given).items():
        if "SciPy DOP853" not in name:  # a second in a loop
            assert far(prepare(1e-8)()) < 2e-5, name


@pytest.mark.few(6)
@pytest.mark.parametrize("given", [*TIMES, *STATES], ids=lambda given: given.name)
def test_no_switch_is_lost_without_a_word(given):
    """By "auto" the end is right; fastdyn's own methods, and RK45 and Radau, tell where not."""
    end = switches.end_of(given)
    assert switches.verdict(given, "auto", end) == switches.RIGHT
    for method in ("Taylor", "Tsit5", "Vern9", "Rodas5P", "RK45", "Radau"):
        assert switches.verdict(given, method, end) != switches.WRONG, method


def _rows(ours, others):
    return [
        {"output": "end", "solver": "fastdyn RK45", "min_us": ours, "median_us": 9.0, "nfev": 7},
        {"output": "end", "solver": "SciPy RK45", "min_us": others, "median_us": 8.0, "nfev": 7},
    ]


def _record(rows, cpu="A"):
    return {"date": "2026-01-01", "quick": False, "machine": {"cpu": cpu}, "fixed_cost": rows}


def test_a_run_is_compared_with_the_last(tmp_path):
    """fastdyn's times are judged beside those of other libraries, on the same processor."""
    path = tmp_path / "runs" / "last.json"
    first = last_run.compared("fixed_cost", _record(_rows(2.0, 100.0)), path)
    assert first.startswith("no run")
    both_slower = last_run.compared("fixed_cost", _record(_rows(4.0, 200.0)), path)
    assert "fastdyn 2.00" in both_slower and "others 2.00" in both_slower
    assert "slower" not in both_slower
    alone = last_run.compared("fixed_cost", _record(_rows(6.0, 200.0)), path)
    assert "slower: 1.50  fastdyn RK45, end" in alone
    better = last_run.compared("fixed_cost", _record(_rows(3.0, 200.0)), path)
    assert "faster: 0.50  fastdyn RK45, end" in better
    assert last_run.compared("fixed_cost", _record(_rows(3.0, 200.0), "B"), path).startswith("no")


def test_times_of_a_run():
    """By columns, at equal errors where rows have tolerances, and as one over a rate."""
    columns = last_run.seconds_of([{"n": 6, "fastdyn_us": 1.0, "numpy_us": 2.0, "gain": 2.0}])
    assert {(p[2], last_run.is_ours(p)) for p in columns} == {
        ("fastdyn_us", True), ("numpy_us", False),
    }  # fmt: skip
    rate = last_run.seconds_of([{"solver": "fastdyn", "a_second": 4.0, "a_second_median": 3.0}])
    assert list(rate.values()) == [0.25]
    points = [
        {"problem": "p", "solver": "s", "tol": tol, "error": tol, "min_us": us}
        for tol, us in ((1e-3, 1.0), (1e-5, 3.0))
    ]
    assert list(last_run.seconds_of(points).values()) == [pytest.approx(3.0**0.5)]


def test_the_tables_of_the_pages_are_those_of_the_results():
    """Nobody edits a table by hand: the marks hold what the result files give."""
    record = json.loads(table.RESULTS.read_text())
    for page, lines in ((table.PAGE, table.for_page), (table.README, table.for_readme)):
        assert "\n".join(lines(record)) in page.read_text(), page.name


def test_parts_of_a_full_run_have_files(tmp_path):
    """With the date and the machine of their own run."""
    record = _record([]) | {
        "load": {"dae": 0.1, "stiff": 0.2}, "seconds": {"dae": 1, "stiff": 2}, "dae": [{"a": 1}],
        "stiff": [{"b": 2}], "replaced": {"stiff": {"date": "2026-02-02", "machine": {"cpu": "B"}}},
    }  # fmt: skip
    assert set(report.parts(record, tmp_path)) == {"dae", "stiff"}
    dae = json.loads((tmp_path / "dae.json").read_text())
    assert (dae["dae"], dae["date"], dae["load"]) == ([{"a": 1}], "2026-01-01", {"dae": 0.1})
    stiff = json.loads((tmp_path / "stiff.json").read_text())
    assert (stiff["date"], stiff["machine"]) == ("2026-02-02", {"cpu": "B"})
