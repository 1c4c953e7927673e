"""Claims about the systems: what they call exact is exact, what they call constant is constant."""

import dataclasses
import inspect
import math
import pickle

import numpy as np
import pytest

from fastdyn import OdeResult, systems
from fastdyn.code_store import Call
from fastdyn.compile.bind import bind
from fastdyn.compile.mode import EVENT
from fastdyn.specialise.scalar import evaluate_kernel
from fastdyn.systems import (
    SYSTEMS,
    System,
    building,
    cable,
    nanoparticle,
    pendulum,
    pendulum_xy,
    projectile,
    rod,
    satellite,
    suspension,
    tower,
)
from fastdyn.systems.base.result import SystemResult

EPS = np.finfo(float).eps

EDGE = 2.0 * math.sqrt(9.81)  # launch velocity of the separatrix for g = 9.81, l = 1

EXACT = [
    satellite(),
    satellite(V=1.2),
    satellite(V=-0.8),
    satellite(GM=3.986e14, R=7e6, V=7800.0),
    pendulum(),
    pendulum(V0=0.0),
    pendulum(V0=5.0),
    pendulum(V0=-6.2),
    pendulum(V0=EDGE),
    pendulum(V0=8.0),
    pendulum(g=1.62, l=2.5, V0=-30.0, m=3.0),
    projectile(),
    projectile(g=1.62, x0=3.0, y0=-2.0, z0=7.0, vx0=-1.0, vz0=-4.0),
    tower(),
    nanoparticle(),
    suspension(),
    suspension(m=3.0, k=7.0, x0=9.0),
    rod(mu=0.0),
    rod(omega=5.0, mu=0.8, m=2.0),
    building(),
    building(omega=2.0, k=7.0, m=3.0, d=-0.3),
    building(omega=10.0 * math.sqrt(3.0 + math.sqrt(5.0))),
    pendulum_xy(V0=4.0),
    pendulum_xy(V0=-8.0, l=0.7, m=2.0),
    cable(V0=4.0),
]

ALL = [system() for system in SYSTEMS.values()]


def characteristic_time(system):
    """Shortest time in which anything happens, to scale differences and tolerances."""
    if system.name == "satellite":
        nearest = system.semi_major_axis * (1.0 - system.eccentricity)
        return math.sqrt(nearest**3 / system.GM)
    if system.name in ("projectile", "tower", "nanoparticle"):
        return 0.1 * system.t_end
    if system.name == "suspension":
        return 1.0 / system.natural_frequency
    if system.name == "rod":
        return 1.0 / system.decay_rate
    if system.name == "building":
        return 1.0 / max(system.upper_frequency, system.omega)
    if system.name in ("pendulum_xy", "cable"):
        system = system.by_angle
    return 1.0 / (system.natural_frequency * max(1.0, 2.0 * system.modulus))


@pytest.mark.parametrize("system", EXACT, ids=str)
def test_exact_solution_starts_at_the_initial_state(system):
    scale = np.abs(system.exact(np.linspace(0.0, 20 * characteristic_time(system), 99))).max(1)
    error = np.abs(system.exact(0.0) - system.initial_state())
    assert np.all(error <= 8 * EPS * scale)


@pytest.mark.parametrize("system", EXACT, ids=str)
def test_exact_solution_satisfies_the_equations_of_motion(system):
    unit = characteristic_time(system)
    h = 1e-3 * unit
    t = np.linspace(-5.0, 30.0, 141) * unit
    y = system.exact(t)
    far, near = (
        (system.exact(t + 2 * h) - system.exact(t - 2 * h)),
        (system.exact(t + h) - system.exact(t - h)),
    )
    slope = (8.0 * near - far) / (12.0 * h)
    expected = np.array([system.rhs(t, w, *system.args) for t, w in zip(t, y.T, strict=True)]).T
    size = np.abs(y).max(axis=1, keepdims=True)
    # The formula's own error is h^4/30 times the fifth derivative, its rounding EPS/h times y.
    truncation = (h / unit) ** 4 * 100.0
    assert np.all(np.abs(slope - expected) <= size / unit * (truncation + 60.0 * EPS * unit / h))


@pytest.mark.parametrize("system", EXACT, ids=str)
def test_invariants_are_constant_along_the_exact_solution(system):
    t = np.linspace(0.0, 50.0, 301) * characteristic_time(system)
    for function in system.invariants.values():
        values = system.along(function, t, system.exact(t))
        # Phases of up to 50 (and Kepler's equation) carry their rounding into the state.
        assert np.ptp(values) <= 1000 * EPS * np.abs(values).max()


@pytest.mark.few(3)
@pytest.mark.parametrize("system", ALL, ids=str)
def test_functions_of_the_state_compile_and_agree_with_python(system):
    y = np.array(system.initial_state()) + 0.1
    groups = (system.invariants, system.quantities, system.constraints, system.events)
    for group in groups:
        for name, function in group.items():
            bound, out = bind(function, system.args, EVENT, len(y)), np.empty(1)
            assert bound.function is not None, name
            Call(evaluate_kernel(), bound.block, 0.3, y, out)()
            expected = function(0.3, tuple(y), *system.args)
            assert out[0] == pytest.approx(expected, rel=16 * EPS, abs=16 * EPS), name


@pytest.mark.parametrize("system", ALL, ids=str)
def test_every_system_says_what_a_reader_needs(system):
    assert len(system.states) == len(system.initial_state())
    assert len(system.rhs(0.0, system.initial_state(), *system.args)) == len(system.states)
    assert system.title and system.source and system.t_end > 0.0
    assert "Raises" in type(system).__doc__ and "State ``[" in type(system).__doc__
    for group in (system.invariants, system.quantities, system.constraints):
        assert all(function.unit and function.label for function in group.values())
    for field in dataclasses.fields(system):
        about = field.metadata
        said = f"float, default {field.default:g}\n" if about else ""
        assert type(system).__doc__.count(f"\n{field.name} : {said}") == 1
        assert not about or f"{about['meaning'][1:]} ({about['unit']})" in type(system).__doc__


def test_along_takes_functions_that_see_all_columns_and_functions_that_see_one():
    system = satellite(V=1.2)
    t = np.linspace(0.0, 3.0, 4)  # as many points as components, the treacherous case
    y = system.exact(t)
    for function in (system.quantities["distance"], lambda t, w, *p: math.hypot(w[0], w[1])):
        assert np.allclose(system.along(function, t, y), np.hypot(y[0], y[1]), rtol=4 * EPS)
    assert np.allclose(system.along(lambda t, w, *p: max(w), t, y), y.max(axis=0))
    assert np.allclose(
        system.along(lambda t, w, *p: np.linalg.norm(w), t, y), np.linalg.norm(y, axis=0)
    )


@pytest.mark.parametrize(
    "build, error, sentence",
    [
        (lambda: pendulum(g=0.0), ValueError, "`g` .* greater than zero, but 0 was given"),
        (lambda: pendulum(l=-1), ValueError, "`l` .*length.* greater than zero, but -1"),
        (lambda: pendulum(m=-2.0), ValueError, "`m` .*kg.* greater than zero"),
        (lambda: pendulum(V0=math.nan), ValueError, "`V0` .* finite, but nan"),
        (lambda: pendulum(V0=math.inf), ValueError, "`V0` .* finite, but inf"),
        (lambda: pendulum(V0="fast"), TypeError, "one real number, but 'fast'"),
        (lambda: pendulum(V0=None), TypeError, "one real number, but None"),
        (lambda: pendulum(V0=[1.0]), TypeError, "one real number"),
        (lambda: pendulum(m=True), TypeError, "one real number, but True"),
        (lambda: pendulum(length=1), TypeError, "no parameter `length`; .* are g, l, V0, m"),
        (lambda: satellite(GM=-1), ValueError, "`GM` of the satellite .* greater than zero"),
        (lambda: satellite(R=0), ValueError, "`R` .* greater than zero"),
        (lambda: satellite(V=1j), TypeError, "one real number"),
        (lambda: satellite(mass=1), TypeError, "no parameter `mass`; .* are GM, R, V"),
    ],
)
def test_wrong_parameters_get_a_sentence(build, error, sentence):
    with pytest.raises(error, match=sentence):
        build()


def test_numbers_of_other_types_are_parameters_too():
    assert pendulum(V0=np.float32(2), m=3).args == (9.81, 1.0, 3.0)
    with pytest.raises(dataclasses.FrozenInstanceError):
        pendulum().g = 1.0
    assert pickle.loads(pickle.dumps(satellite(V=1.2))) == satellite(V=1.2)


def test_initial_conditions_are_no_arguments():
    for system in ALL:
        names = [field.name for field in system.parameter_fields()]
        for function in (system.rhs, *system.events.values(), *system.quantities.values()):
            assert list(inspect.signature(function).parameters)[2:] == names
        changed = {
            field.name: getattr(system, field.name) + 0.25 for field in system.initial_fields()
        }
        other = dataclasses.replace(system, **changed)
        assert other.args == system.args
        assert not changed or other.initial_state() != system.initial_state()


def test_wrong_calls_get_a_sentence():
    with pytest.raises(ValueError, match="no event 'impact'; its events are: apsis"):
        satellite().solve(events="impact")
    with pytest.raises(TypeError, match="`args` of the satellite are its parameters"):
        satellite().solve(args=(1.0,))


def test_error_is_refused_where_the_exact_solution_starts_elsewhere():
    system = satellite(V=1.2)
    assert np.abs(system.solve((0.0, 1.0), y0=[1, 0, 0, 1.2]).error()).max() < 1e-5
    for options in ({"y0": [1, 0, 0, 1.1]}, {"t_span": (1.0, 2.0)}):
        run = system.solve(**{"t_span": (0.0, 1.0), **options})
        assert run.system == system
        with pytest.raises(ValueError, match="from its own initial state"):
            run.error()


def test_results_know_their_invariants_and_default_tolerances():
    run = satellite().solve((0.0, 20.0))
    assert isinstance(run, SystemResult) and isinstance(run, OdeResult) and "system" not in run
    again = pickle.loads(pickle.dumps(run))
    assert again.system == run.system and np.array_equal(again.error(), run.error())
    assert set(run.quantities()) == {"distance"} and run.residuals() == {}
    assert set(run.invariants()) == {"energy", "angular_momentum"}
    assert all(values.shape == run.t.shape for values in run.invariants().values())
    # The defaults must not let the satellite fall as SciPy's do; 1e-6 a step at the most.
    assert np.ptp(run.invariants()["energy"]) <= run.n_accepted * 2e-6


def test_a_new_system_is_one_file(tmp_path, monkeypatch):
    decay = (
        "import dataclasses\n"
        "from fastdyn.systems.base.system import System\n"
        "@dataclasses.dataclass(frozen=True)\n"
        "class Decay(System):\n"
        "    name, title, source, states, t_end = 'decay', 'Decay', 'none', (), 1.0\n"
        "    rhs = staticmethod(lambda t, y: [])\n"
    )
    (tmp_path / "decay.py").write_text(decay)
    monkeypatch.setattr(systems, "__path__", [*systems.__path__, str(tmp_path)])
    found = systems._discovered()
    assert set(found) == {*SYSTEMS, "decay"} and issubclass(found["decay"], System)
    with pytest.raises(ValueError, match="No exact solution of the decay"):
        found["decay"]().exact(1.0)
    (tmp_path / "rise.py").write_text(decay.replace(", t_end", "").replace(", 1.0", ""))
    with pytest.raises(TypeError, match=r"Decay of fastdyn/systems/rise\.py declares no t_end\."):
        systems._discovered()
