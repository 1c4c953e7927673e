"""A path depends on the seed and its number: not on threads, blocks, pieces, lanes or outputs."""

import numpy as np
import pytest

import fastdyn.noise.run
from fastdyn import CompileWarning, solve_langevin, solve_sde
from fastdyn.compile.sentences import Uncompilable
from fastdyn.noise import Histogram, Quantiles, plan


def drift(t, y, rate=1.0):
    return np.array([y[1], -np.sin(y[0]) - rate * y[1] * np.cos(t)])


def matrix(t, y, rate=1.0):
    return np.array([[0.1, 0.0], [0.2 * y[0], 0.3 + 0.1 * rate * y[1]]])


PROBLEMS = {
    "EulerMaruyama": (solve_sde, (drift, matrix)),
    "EulerHeun": (solve_sde, (drift, matrix), {"calculus": "stratonovich"}),
    "Milstein": (solve_sde, (drift, lambda t, y: [0.2 * y[0], 0.3 * np.sin(y[1])])),
    "Platen": (solve_sde, (drift, lambda t, y: 0.3 * y), {"noise": "scalar"}),
    "SRA1": (solve_sde, (drift, lambda t, y: [0.2, 0.1 * t])),
    "BAOAB": (solve_langevin, (lambda t, q: -np.sin(q) * np.cos(t),), {"friction": 0.3}),
    "OBABO": (solve_langevin, (lambda t, q: -np.sin(q) * np.cos(t),), {"friction": [0.0]}),
}


def solved(method, paths=37, refine=1, **options):
    solve, functions, *given = PROBLEMS[method]
    options = {"rng": 4, "step": 0.125, "paths": paths, "refine": refine, **options}
    options |= {"method": method, **(given[0] if given else {})}
    if solve is solve_langevin:
        return solve(*functions, (0, 2), [1.0], [0.2], sigma=0.5, **options)
    return solve(*functions, (0, 2), [1.0, 0.2], **options)


@pytest.mark.few(4)
@pytest.mark.parametrize("method", PROBLEMS)
def test_the_bits_of_a_path_depend_on_nothing_else(method, monkeypatch):
    whole = solved(method, t_eval=np.arange(33) / 16)
    assert whole.success.all()
    assert (solved(method).y_end == whole.y[..., -1]).all()
    assert (solved(method, paths=5).y_end == whole.y_end[:5]).all()
    assert (solved(method, paths=None).y == whole.y[0]).all()
    monkeypatch.setattr(fastdyn.noise.run, "BLOCK", 8)
    monkeypatch.setattr(fastdyn.noise.run, "PIECE", 24)
    for threads in (1, 3):
        assert (solved(method, threads=threads).y_end == whole.y_end).all()


@pytest.mark.few(2)  # each compiles a kernel in lanes and one by addresses, 2 s
@pytest.mark.parametrize("method", [name for name in PROBLEMS if name != "Milstein"])
def test_one_path_at_a_time_is_a_path_in_lanes(method, monkeypatch):
    """Rows and addresses in place of vectors: the same numbers, up to roundings that may fuse."""

    def near(t, y):
        return y[0] - 0.9

    near.terminal = method != "EulerHeun"  # the places of passages, too
    event = {"events": [near, lambda t, y: y[0] - 0.95]}
    lanes = solved(method, **event)

    def refuse(*given):
        raise Uncompilable("the test asks for it")

    monkeypatch.setattr(plan, "_in_lanes", refuse)
    alone = solved(method, **event)
    assert (lanes.width, alone.width, alone.reason) == (8, 1, "the test asks for it")
    np.testing.assert_allclose(alone.y_end, lanes.y_end, rtol=0, atol=1e-12)
    np.testing.assert_allclose(alone.t_events, lanes.t_events, rtol=0, atol=1e-9)


def test_many_components_and_sources_go_one_by_one():
    n = 60
    found = solve_sde(
        lambda t, y: np.roll(y, 1) - y, np.full(n, 0.1), (0, 1), np.ones(n), step=0.1, paths=6,
        rng=1,
    )  # fmt: skip
    few = solve_sde(lambda t, y: -y, np.full(3, 0.1), (0, 1), np.ones(3), step=0.1, paths=6, rng=1)
    assert (found.width, found.method) == (1, "SRA1")
    np.testing.assert_allclose(found.brownian()[:, :3], few.brownian(), rtol=0, atol=1e-13)


def test_functions_that_stay_in_python_are_solved_in_python():
    seen = []

    def noted(t, y):
        seen.append(float(t))
        return [-y[0]]

    with pytest.warns(CompileWarning, match="noted"):
        found = solve_sde(noted, 0.2, (0, 1), [1.0], step=0.25, paths=2, rng=1, method="SRA1")
    assert len(seen) >= 2 * found.nfev == 16
    traced = solve_sde(lambda t, y: -y, 0.2, (0, 1), [1.0], step=0.25, paths=2, rng=1)
    np.testing.assert_allclose(found.y_end, traced.y_end, rtol=0, atol=1e-15)


def test_exceptions_of_functions_are_raised():
    def fails(t, y):
        if t > 0.5:
            raise RuntimeError("no more")
        return [-y[0]]

    def stays_in_python(t, y):
        return [-float(str(y[0]))] if t < 0.5 else fails(t, y)

    with pytest.raises(RuntimeError, match="no more"):
        solve_sde(fails, 0.2, (0, 1), [1.0], step=0.25, paths=2, rng=1)
    with pytest.warns(CompileWarning), pytest.raises(RuntimeError, match="no more"):
        solve_sde(stays_in_python, 0.2, (0, 1), [1.0], step=0.25, paths=2, rng=1)


def test_values_from_outside_are_those_of_the_call():
    rate = [1.0]

    def decays(t, y):
        return [-rate[0] * y[0]]

    ends = []
    for rate[0] in (1.0, 2.0):
        ends.append(solve_sde(decays, 0.0, (0, 1), [1.0], step=1e-3, rng=1).y[0, -1])
    np.testing.assert_allclose(ends, np.exp([-1.0, -2.0]), rtol=1e-5)


def test_a_path_that_blows_up_is_told():
    found = solve_sde(lambda t, y: y**2, 0.0, (0, 3), np.array([[0.1], [1.0]]), step=0.01, rng=1)
    assert found.success.tolist() == [True, False]
    assert "1 of 2 paths left the finite numbers" in found.message


def test_reductions_take_the_place_of_paths():
    options = {"step": 0.25, "paths": 500, "rng": 9, "t_eval": [0.5, 1.0, 2.0]}
    problem = drift, matrix, (0, 2), [1.0, 0.2]
    y = solve_sde(*problem, **options).y
    edges = np.linspace(-3, 3, 7)
    found = solve_sde(
        *problem, **options,
        reduce=["mean", "variance", "standard_error", "quantiles", Histogram(edges)],
    )  # fmt: skip
    assert found.y is None
    np.testing.assert_array_equal(found.reduced["mean"], y.mean(axis=0))
    np.testing.assert_array_equal(found.reduced["variance"], y.var(axis=0, ddof=1))
    np.testing.assert_allclose(
        found.reduced["standard_error"], y.std(axis=0, ddof=1) / np.sqrt(500), rtol=1e-15
    )
    shares = Quantiles().shares
    np.testing.assert_array_equal(found.reduced["quantiles"], np.quantile(y, shares, axis=0))
    assert found.reduced["histogram"].shape == (6, 2, 3)
    expected = np.histogram(y[:, 1, 2], edges)[0]
    np.testing.assert_array_equal(found.reduced["histogram"][:, 1, 2], expected)
    named = solve_sde(*problem, **options, reduce={"largest": lambda t, y: y.max(axis=0) + t})
    np.testing.assert_array_equal(
        named.reduced["largest"], y.max(axis=0) + np.array(options["t_eval"])
    )


def test_seeds_are_those_of_numpy():
    def end(rng):
        return solve_sde(drift, 0.1, (0, 1), [1.0, 0.0], step=0.25, rng=rng).y[0, -1]

    assert end(5) == end(5) == end(np.random.default_rng(5)) == end(np.random.SeedSequence(5))
    assert end(5) != end(6)
    assert end(None) != end(None)
    generator = np.random.default_rng(5)
    assert end(generator) != end(generator)


class Planned(Exception):
    """Raised with the method, the kind of the noise and the number of its sources."""


def test_shapes_of_the_diffusion_are_kinds_of_noise(monkeypatch):
    """Seen before a kernel is compiled: each of these plans would be a kernel of its own, 0.8 s."""

    def solved(diffusion, n=2, **options):
        return solve_sde(
            lambda t, y: 0.0 * y, diffusion, (0, 1), np.ones(n), step=0.5, rng=1, **options
        )

    def noted(*given):
        kinds.append(plan.noise_of(*given))
        return kinds[-1]

    def plan_only(asked, *rest):
        raise Planned(asked.method.name, kinds[-1], asked.n_sources)

    def kind(diffusion, **options):
        with pytest.raises(Planned) as planned:
            solved(diffusion, **options)
        return planned.value.args

    kinds: list = []
    found = solved(np.ones((2, 3)))
    whole = found.method, found.noise, found.brownian().shape[0]
    monkeypatch.setattr("fastdyn.noise.solve.noise_of", noted)
    monkeypatch.setattr("fastdyn.noise.solve.kernel_of", plan_only)
    assert kind(np.ones((2, 3))) == whole == ("SRA1", "additive", 3)
    assert kind(0.3) == ("SRA1", "additive", 2)
    assert kind([0.3, 0.1]) == ("SRA1", "additive", 2)
    assert kind([[0.3], [0.1]]) == ("SRA1", "additive", 1)
    assert kind([0.3, 0.1], noise="scalar") == ("SRA1", "additive", 1)
    assert kind(lambda t, y: [t, 1.0]) == ("SRA1", "additive", 2)
    assert kind(lambda t, y: y) == ("Milstein", "unmixed", 2)
    assert kind(lambda t, y: y[::-1]) == ("EulerMaruyama", "general", 2)
    assert kind(lambda t, y: y[::-1], noise="scalar") == ("Milstein", "unmixed", 1)
    assert kind(lambda t, y: y[::-1], calculus="stratonovich")[0] == "EulerHeun"
    assert kind(lambda t, y: np.array([[y[1]], [y[0]]])) == ("Milstein", "unmixed", 1)
    assert kind(lambda t, y: 2.0, n=1) == ("SRA1", "additive", 1)
    assert kind(lambda t, y: np.eye(2) * y[0])[1] == "general"
