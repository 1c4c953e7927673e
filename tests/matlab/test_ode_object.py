"""MATLAB's object ode beside the functions ode45 and ode15s, and beside exact solutions."""

import copy

import numpy as np
import pytest

from fastdyn.matlab import ode, ode15s, ode45, odeEvent, odeset

G, V = 9.81, 20.0


def circle(t, y):
    return [y[1], -y[0]]


def fall(t, y, p):
    return [y[1], -p[0]]


def height(t, y):
    return y[0]


def bounce(te, ye, ie, p):
    return False, [0.0, -p[1] * ye[1]], p


def ball(**more):
    given = {"EventFcn": height, "Direction": "descending", "Response": "callback"}
    definition = odeEvent(**given | {"CallbackFcn": bounce} | more)
    return ode(ODEFcn=fall, InitialValue=[0, V], Parameters=[G, 0.9], EventDefinition=definition)


@pytest.mark.parametrize(("solver", "function"), [("ode45", ode45), ("ode15s", ode15s)])
def test_numbers_are_those_of_the_function(solver, function):
    options = odeset("RelTol", 1e-6, "AbsTol", [1e-9, 1e-8], "MaxStep", 0.5)
    F = ode(ODEFcn=circle, InitialValue=[1, 0], Solver=solver, RelativeTolerance=1e-6)
    F.AbsoluteTolerance = [1e-9, 1e-8]
    F.SolverOptions.MaxStep = 0.5
    for refine in (None, 3):
        S = F.solve(0, 10, Refine=refine)
        t, y = function(circle, [0, 10], [1, 0], odeset(options, Refine=refine))
        assert np.array_equal(S.Time, t) and np.array_equal(S.Solution, y.T)
        assert S.EventTime.shape == (0,) and S.EventSolution.shape == (2, 0)
    times = [0, 1, 2.5, 10]
    _, y = function(circle, times, [1, 0], options)
    assert np.array_equal(F.solve(times).Solution, y.T)
    assert np.array_equal(F.solutionFcn(0, 10)([0.5, 2.5])[:, 1], y[2])


def test_the_interval_may_lie_on_both_sides_of_the_initial_time():
    F = ode(ODEFcn=circle, InitialTime=1, InitialValue=[1, 0])
    _, before = ode45(circle, [1, -1, -3], [1, 0])
    _, after = ode45(circle, [1, 2, 4], [1, 0])
    asked = [-3, -1, 1, 2, 4]
    S = F.solve(asked)
    assert np.array_equal(S.Time, asked)
    assert np.array_equal(S.Solution, np.vstack([before[:0:-1], after]).T)
    back = F.solve(asked[::-1])
    assert np.array_equal(back.Time, asked[::-1])
    assert np.array_equal(back.Solution, S.Solution[:, ::-1])
    whole = F.solve(-3, 4)
    assert (np.diff(whole.Time) > 0).all() and list(whole.Time[[0, -1]]) == [-3, 4]
    assert np.array_equal(whole.Solution[:, [0, -1]], S.Solution[:, [0, -1]])
    part = F.solve(2, 4)
    kept = whole.Time > 2
    assert part.Time[0] == 2 and np.array_equal(part.Time[1:], whole.Time[kept])
    assert np.array_equal(part.Solution[:, 0], S.Solution[:, 3])
    assert np.array_equal(part.Solution[:, 1:], whole.Solution[:, kept])
    fh = F.solutionFcn(4, -3, OutputVariables=1)
    assert np.array_equal(fh([-1, 2]), S.Solution[1, [1, 3]]) and fh(1) == 0
    with pytest.raises(ValueError, match="known from -3 to 4"):
        fh(4.5)


def test_callbacks_change_the_state_and_the_run_goes_on():
    """The flights last 2 v / G, with v a tenth less after each."""
    S = ball().solve(0, 12)
    lands = np.cumsum(2 * V / G * 0.9 ** np.arange(3))
    assert S.EventTime == pytest.approx(lands, rel=1e-12) and list(S.EventIndex) == [0, 0, 0]
    assert S.EventSolution[1] == pytest.approx(-V * 0.9 ** np.arange(3), rel=1e-12)
    twice = np.flatnonzero(np.diff(S.Time) == 0)
    assert np.array_equal(S.Time[twice], S.EventTime)
    assert np.array_equal(S.Solution[1, twice + 1], -0.9 * S.Solution[1, twice])
    both = ball(Direction="both").solve(0, 12)  # the start is a zero, that of a bounce is no other
    assert np.array_equal(both.EventTime, [0, *S.EventTime])
    assert np.array_equal(both.Solution, S.Solution)
    flight = 6.0 - lands[0]
    exact = 0.9 * V * flight - G * flight**2 / 2
    assert ball().solve([0, 6]).Solution[0, 1] == pytest.approx(exact, rel=1e-12)
    assert ball().solutionFcn(0, 12)(6.0)[0] == pytest.approx(exact, rel=1e-12)


def test_callbacks_change_parameters_and_may_stop():
    def weaker(te, ye, ie, p):
        return p[0] < G, [0.0, V], [p[0] / 2, 0.9]

    S = ball(CallbackFcn=weaker).solve(0, 100)
    flight = 2 * V / G
    assert S.EventTime == pytest.approx([flight, 3 * flight], rel=1e-12)
    assert S.Time[-1] == S.EventTime[-1]
    with pytest.raises(TypeError, match="`CallbackFcn` must return stop, ye, p; got None"):
        ball(CallbackFcn=lambda te, ye, ie, p: None).solve(0, 100)


def test_each_event_has_its_direction_and_response():
    F = ode(ODEFcn=circle, InitialValue=[1, 0])
    F.EventDefinition = odeEvent(
        EventFcn=lambda t, y: [y[0], y[1]],
        Direction=["both", "ascending"],
        Response=["proceed", "stop"],
    )
    S = F.solve(0, 10)

    def events(t, y):
        return [y[0], y[1]], [0, 1], [0, 1]

    t, y, te, ye, ie = ode45(circle, [0, 10], [1, 0], odeset("Events", events))
    assert list(ie) == [0, 1]
    for found, known in zip(S, (t, y.T, te, ye.T, ie), strict=True):
        assert np.array_equal(found, known)
    assert F.solve([0, 1, 9]).Time[-1] == te[-1]
    with pytest.raises(ValueError, match="known from 0 to"):
        F.solutionFcn(0, 10)(9.0)
    F.EventDefinition.Direction = ["both", "both", "both"]
    with pytest.raises(ValueError, match="one for each of the 2 events"):
        F.solve(0, 10)


def test_an_event_with_a_callback_that_the_first_step_passes_is_told():
    F = ball(EventFcn=lambda t, y: y[0] - 1e-9)
    F.InitialValue = [1e-3, 0]
    F.SolverOptions = odeset("InitialStep", 0.5, "MaxStep", 0.5)
    with pytest.warns(UserWarning, match="CallbackFcn is not called"):
        F.solve(0, 0.6)


def test_solvers_are_selected():
    F = ode(ODEFcn=circle, InitialValue=[1, 0])
    assert F.SelectedSolver == "ode45"
    for solver, selected in (("nonstiff", "ode45"), ("stiff", "ode15s"), ("ode23T", "ode23t")):
        F.Solver = solver
        assert F.SelectedSolver == selected
    assert ode(Jacobian=np.eye(2)).SelectedSolver == "ode15s"
    algebraic = ode(
        ODEFcn=lambda t, y, p: [-p * y[0], y[0] - y[1]],
        InitialValue=[1, 1],
        Parameters=2.0,
        MassMatrix=np.diag([1.0, 0.0]),
    )
    S = algebraic.solve(0, 1)
    t, y = ode15s(
        lambda t, y: [-2.0 * y[0], y[0] - y[1]],
        [0, 1],
        [1, 1],
        odeset("Mass", np.diag([1.0, 0.0])),
    )
    assert np.array_equal(S.Time, t) and np.array_equal(S.Solution, y.T)


def test_functions_of_a_problem_take_its_parameters():
    p = 3.0
    F = ode(ODEFcn=lambda t, y, p: -p * y, InitialValue=1, Parameters=p, Solver="ode15s")
    F.MassMatrix = lambda t, y, p: [[p]]
    F.Jacobian = lambda t, y, p: [[-p]]
    F.MassMatrix = None
    t, y = ode15s(lambda t, y: -3.0 * y, [0, 1], 1, odeset("Jacobian", [[-3.0]]))
    S = F.solve(0, 1)
    assert np.array_equal(S.Time, t) and np.array_equal(S.Solution, y.T)
    G = ode(ODEFcn=lambda t, y: -y, InitialValue=1, Parameters=2.0)
    G.MassMatrix = lambda t, y, p: [[p]]
    G.Solver = "ode45"
    t, y = ode45(lambda t, y: -y, [0, 1], 1, odeset("Mass", [[2.0]]))
    assert G.solve(0, 1).Solution[0, -1] == pytest.approx(y[-1, 0], rel=1e-12)


def test_wrong_names_and_incomplete_problems_get_a_sentence():
    F = ode(ODEFcn=fall, InitialValue=[1, 0])
    with pytest.raises(TypeError, match="needs Parameters=p"):
        F.solve(0, 1)
    for wrong in (lambda: F.RelTol, lambda: setattr(F, "RelTol", 1e-3)):
        with pytest.raises(AttributeError, match="did you mean RelativeTolerance"):
            wrong()
    F.Parameters = [G]
    with pytest.raises(AttributeError, match="no `y`; did you mean `Solution`"):
        F.solve(0, 1).y  # noqa: B018
    F.SolverOptions = odeset("Refine", 2)
    with pytest.raises(ValueError, match="SolverOptions have no Refine"):
        F.solve(0, 1)
    with pytest.raises(ValueError, match="needs InitialValue"):
        ode(ODEFcn=circle).solve(0, 1)
    with pytest.raises(ValueError, match="`odeEvent` needs EventFcn"):
        ode(ODEFcn=circle, InitialValue=[1, 0], EventDefinition=odeEvent()).solve(0, 1)
    with pytest.raises(ValueError, match="needs CallbackFcn"):
        ball(CallbackFcn=None).solve(0, 1)
    assert repr(copy.copy(ode(Solver="stiff"))) == "ode(Solver='stiff')"
