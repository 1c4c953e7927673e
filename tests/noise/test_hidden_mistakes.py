"""What would be wrong without a word: refused, warned of, or solved by a method that holds."""

import numpy as np
import pytest

from fastdyn import CompileWarning, solve_langevin, solve_sde
from fastdyn.noise import Histogram, Quantiles
from fastdyn.run.functions.switching import SwitchingWarning


def falls(t, y):
    return -y


def kind(diffusion, n=1, **options):
    found = solve_sde(falls, diffusion, (0, 1), np.ones(n), step=0.5, rng=1, **options)
    return found.method, found.noise


@pytest.mark.parametrize("diffusion", [
    lambda t, y: [1.0 if y[0] > 0 else 2.0],
    lambda t, y: [np.array([1.0, 2.0, 3.0])[int(abs(y[0])) % 3]],
    lambda t, y: np.floor(y),
])  # fmt: skip
def test_a_diffusion_that_jumps_with_the_state_is_not_additive(diffusion):
    """Its derivative is zero, but Stratonovich's integral is not Ito's."""
    assert kind(diffusion) == ("EulerMaruyama", "general")
    assert kind(diffusion, calculus="stratonovich") == ("EulerHeun", "general")
    with pytest.raises(ValueError, match="`diffusion` does"):
        kind(diffusion, method="SRA1")


def test_auto_takes_a_method_that_there_is_code_for():
    """Without the form on vectors there is no derivative: Platen has Milstein's order."""
    assert kind(lambda t, y: 0.1 * y, 30) == ("Platen", "unmixed")
    found = kind(lambda t, y: 0.1 * y, 30, calculus="stratonovich")
    assert found == ("EulerHeun", "unmixed")
    with pytest.raises(ValueError, match="30 components are more than 24"):
        kind(lambda t, y: 0.1 * y, 30, method="Milstein")


def test_noise_that_mixes_has_stratonovichs_drift():
    """dy = A y o dW_1 + B y o dW_2, AB != BA: E y grows by (A A + B B) / 2."""
    a, b = np.array([[0.0, 0.5], [0.5, 0.0]]), np.array([[0.3, 0.0], [0.4, -0.3]])
    n = 100_000
    found = solve_sde(
        lambda t, y: 0.0 * y, lambda t, y: np.stack([a @ y, b @ y], axis=1), (2, 3), [1.0, 0.5],
        step=1 / 32, paths=n, rng=1, calculus="stratonovich",
    )  # fmt: skip
    assert (found.method, found.noise) == ("EulerHeun", "general")
    step = np.eye(2) + (grows := (a @ a + b @ b) / 2) / 32 + grows @ grows / 32**2 / 2
    exact = np.linalg.matrix_power(step, 32) @ [1.0, 0.5]
    deviation = found.y_end.std(axis=0) / np.sqrt(n)
    bias = np.abs(exact) * np.linalg.norm(grows, 2) ** 2 / 32  # of weak order 1
    assert (np.abs(found.y_end.mean(axis=0) - exact) < 5 * deviation + bias).all()
    ito = np.abs(np.array([1.0, 0.5]) - exact)
    assert (ito > 5 * deviation + bias).any()


@pytest.mark.parametrize(("diffusion", "words"), [
    (np.array([1j]), "real numbers"), (lambda t, y: [1j], "real numbers"), (None, "got None"),
    ("0.2", "got the text"), (True, "got True"), (np.nan, "not finite"), ([0.1, 0.2], "shape"),
])  # fmt: skip
def test_a_diffusion_is_real_numbers(diffusion, words):
    with pytest.raises((TypeError, ValueError), match=words):
        solve_sde(falls, diffusion, (0, 1), [1.0], step=0.5)


@pytest.mark.parametrize(("span", "options", "error", "words"), [
    ((1, 0), {}, ValueError, "ascend"), ((1e16, 1e16 + 4), {}, ValueError, "too short at t = "),
    ((0, 1), {"step": 1e-12}, MemoryError, "give `t_eval`"),
    ((0, 1), {"paths": 10**8, "t_eval": np.arange(101) / 100}, MemoryError, "`reduce`"),
])  # fmt: skip
def test_steps_and_paths_that_make_no_sense_are_refused(span, options, error, words):
    with pytest.raises(error, match=words):
        solve_sde(falls, 0.1, span, np.ones(9), **{"step": 0.01, **options})


@pytest.mark.parametrize("solve", ["sde", "langevin"])
def test_a_pulse_between_two_steps_is_told_once(solve):
    def pulse(t, y):
        return [100.0 if 0.503 < t < 0.504 else 0.0]

    def solved(step, f=pulse):
        if solve == "sde":
            return solve_sde(f, 0.0, (0, 1), [0.0], step=step, method="EulerMaruyama", rng=1)
        return solve_langevin(f, (0, 1), [0.0], [0.0], friction=0.0, sigma=0.0, step=step, rng=1)

    with pytest.warns(SwitchingWarning, match="changes at t = 0.503 and t = 0.504"):
        assert solved(0.1).y[-1, -1] == 0.0
    solved(0.1)
    assert abs(solved(1 / 4096).y[-1, -1] - 0.1) < 2 * 100 / 4096
    solved(0.1, lambda t, y: [1.0 if t < 0.505 else 0.0])  # a single change is seen behind it


def test_writes_to_the_state_have_no_effect():
    def spoils(t, y):
        return np.multiply(y, -1.0, out=y)

    with pytest.warns(CompileWarning, match="changes the state"):
        found = solve_sde(spoils, 0.1, (0, 1), [1.0], step=0.25, rng=1)
    plain = solve_sde(falls, 0.1, (0, 1), [1.0], step=0.25, rng=1)
    np.testing.assert_allclose(found.y, plain.y, rtol=0, atol=1e-15)


def spoils_the_paths(t, y):
    y[:] = 0.0


@pytest.mark.parametrize(("reduce", "words"), [
    ([lambda t, y: y.mean(axis=0), lambda t, y: y.std(axis=0)], "two items named '<lambda>'"),
    ([Quantiles([0.5]), Quantiles([0.1])], "two items named 'quantiles'"),
    ([Histogram([0, 1]), Histogram([1, 2])], "two items named 'histogram'"),
    (spoils_the_paths, "read-only"), ({"n": lambda t, y: np.ones(int(4 * t))}, "several shapes"),
])  # fmt: skip
def test_reductions_lose_nothing_and_write_nothing(reduce, words):
    with pytest.raises(ValueError, match=words):
        solve_sde(
            falls, 0.1, (0, 1), [1.0], step=0.25, paths=3, reduce=reduce, t_eval=[0.5, 1.0], rng=1
        )
