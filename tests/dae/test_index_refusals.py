"""Equations and starts that index reduction refuses, with a sentence."""

import functools

import numpy as np
import pytest

from fastdyn import solve_dae
from fastdyn.dae.structure import reduce_index
from support.mechanisms import from_angle, pendulum

reduced = functools.partial(solve_dae, method="DOP853")
ON = [0.6, -0.8, 0.0, 0.0, 0.0]
GIVEN = {"args": (1.0, 9.81)}


def shrinking(t, y, yp):
    """A pendulum whose length passes zero at t = 1."""
    x, z, u, v, force = y
    return [
        yp[0] - u,
        yp[1] - v,
        yp[2] + force * x,
        yp[3] + force * z,
        x * x + z * z - (1 - t) ** 2,
    ]


def test_singular_structure_names_equations_and_components():
    def two_for_one(t, y, yp):
        return [y[0] - 1, y[0] ** 2 - yp[0], y[0] + y[1] + yp[2]]

    said = r"equations 0, 1 .* contain only the components \[0\] .* determines component [12]"
    with pytest.raises(ValueError, match=said):
        reduce_index(two_for_one, [1.0, 0, 0])
    with pytest.raises(ValueError, match=r"equation 1 .* contains no component"):
        reduce_index(lambda t, y, yp: [yp[0] - y[1], t], [1.0, 0])


def test_redundant_equations_are_named():
    def twice(t, y, yp):
        return [yp[0] + y[3] + y[2], yp[1] + y[2] - y[3], y[0] + y[1], 2 * y[0] + 2 * y[1]]

    with pytest.raises(ValueError, match="structure is regular: equations 2, 3 do not determine"):
        reduced(twice, (0, 1), np.zeros(4))


def test_a_third_parallel_crank_is_named():
    """`derive` refuses constraints of which one follows from the others; reduction does, too."""

    def coupler(t, y, yp):
        x, z, turn, *velocities = y[:6]
        forces, c, s = y[6:], np.cos(turn), np.sin(turn)
        ends = [(x + a * c, z + a * s, a) for a in (-1.0, 0.0, 1.0)]
        pull = [0.0, -9.81, 0.0]
        for (u, v, a), force in zip(ends, forces, strict=True):
            pull[0] += force * (u - a)
            pull[1] += force * v
            pull[2] += force * a * (v * c - (u - a) * s)
        return [
            *(yp[i] - velocities[i] for i in range(3)), *(yp[3 + i] - pull[i] for i in range(3)),
            *((u - a) ** 2 + v**2 - 1 for u, v, a in ends),
        ]  # fmt: skip

    said = "equations are singular: equation 8 and component y.8. do not determine each other"
    with pytest.raises(ValueError, match=said):
        solve_dae(coupler, (0, 1), [0.6, -0.8, *[0.0] * 7])
    with pytest.raises(ValueError, match="equations 6, 7, 8 do not determine the components"):
        reduced(coupler, (0, 1), [0.6, -0.8, *[0.0] * 7])


def test_functions_that_cannot_be_traced():
    def by_text(t, y, yp):
        return [yp[0] - y[1], y[0] - float(str(t))]

    with pytest.raises(ValueError, match="needs a function that can be traced"):
        reduced(by_text, (0, 1), [0.0, 1.0])


def test_tables_are_refused():
    knots, heights = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 3.0])

    def looked_up(t, y, yp):
        return [yp[0] - y[1], y[0] - np.interp(t, knots, heights)]

    with pytest.raises(ValueError, match="takes no tables"):
        reduced(looked_up, (0, 1), [0.0, 1.0])


@pytest.mark.parametrize("start, said", [
    ([0.6, -0.9, 0, 0, 0], r"component 1 would move from -0.9 to -0.83"),
    ([0.6, -0.8, 1, 0, 0], "y0 violates the constraints: .* component 3 would move from 0 to 0.48"),
    ([0.0, 0.0, 0, 0, 0], "no start satisfies the constraints of equations 4"),
])  # fmt: skip
def test_starts_that_violate_constraints(start, said):
    with pytest.raises(ValueError, match=said):
        reduced(pendulum, (0, 1), start, **GIVEN)


def test_a_start_is_mended_when_asked():
    found = reduced(pendulum, (0, 0.1), [0.6, -0.9, 0, 0, 0], given=[0], **GIVEN)
    assert found.y[0, 0] == 0.6 and found.y[1, 0] == pytest.approx(-0.8, abs=1e-15)
    nearest = reduced(pendulum, (0, 0.1), [3.0, -4.0, 0, 0, 0], given=[], **GIVEN)
    assert nearest.y[:2, 0] == pytest.approx([0.6, -0.8], abs=1e-13)
    slightly = reduced(pendulum, (0, 0.1), [0.6001, -0.8, 0, 0, 0], **GIVEN)
    assert np.hypot(*slightly.y[:2, 0]) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("given, said", [
    ([4], "component 4 cannot be `given`"),
    ([5], "components of `y0`, 0 to 4"),
    ([0, 1], "0, 1 held"),
])  # fmt: skip
def test_components_that_cannot_be_held(given, said):
    with pytest.raises(ValueError, match=said):
        reduced(pendulum, (0, 1), [0.6, -0.9, 0, 0, 0], given=given, **GIVEN)


@pytest.mark.parametrize("change, error, said", [
    ({"method": "LSODA"}, ValueError, "cannot return a state to its constraints"),
    ({"method": "VelocityVerlet", "step": 0.1}, ValueError, "cannot return a state"),
    ({"jac": 1}, ValueError, "no `jac`"),
    ({"lband": 1}, TypeError, "no option `lband`"),
    ({"yp0": [0, 0]}, ValueError, "`yp0` must have one number for each"),
    ({"y0": [0.6, -0.8, 0, 0]}, ValueError, "not enough values"),
    ({"y0": [0.6, np.nan, 0, 0, 0]}, ValueError, "finite"),
    ({"y0": [0.6, -0.8j, 0, 0, 0]}, TypeError, "`y0` is complex"),
    ({"atol": [1e-6, 1e-6]}, ValueError, "wrong shape"),
])  # fmt: skip
def test_wrong_arguments(change, error, said):
    given = {"F": pendulum, "t_span": (0, 1), "y0": ON, **GIVEN, **change}
    with pytest.raises(error, match=said):
        reduced(**given)


def test_a_wrong_number_of_residuals():
    with pytest.raises(ValueError, match="returned 1 value for a state of 2"):
        reduced(lambda t, y, yp: [yp[0] - y[0]], (0, 1), [1.0, 1.0])


def test_equations_that_become_singular_on_the_way():
    found = reduced(shrinking, (0, 2), [0.0, -1.0, 0.0, 1.0, 0.0], rtol=1e-9, atol=1e-9)
    assert found.status == -1 and "singular between t = " in found.message
    assert found.t[-1] < 1 and abs(found.y[1] - (found.t - 1)).max() < 1e-12


def test_long_steps_are_no_singularity():
    start = from_angle(1.5, 0.0, 1.0, 9.81)
    for method in ("DOP853", "Vern9"):
        found = reduced(pendulum, (0, 20), start, method=method, rtol=1e-3, **GIVEN)
        assert found.success


def test_a_kink_of_a_constraint_ends_the_run():
    def struck(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[2], y[0] - abs(np.sin(t))]

    start = [np.sin(0.1), np.cos(0.1), 0.0]
    found = reduced(struck, (0.1, 5), start, rtol=1e-8, atol=1e-8, t_eval=[1, 2, 3, 4])
    assert found.status == -1 and "kink or a jump at t = 3.1415927" in found.message
    assert (
        found.t.tolist() in ([1, 2], [1, 2, 3]) and abs(found.y[0] - np.sin(found.t)).max() < 1e-7
    )
    assert reduced(struck, (0.1, 3), start).success


def test_kinks_that_jump_nowhere_are_allowed():
    def corner(t, y, yp):  # the corner is in y[0]; y[1] jumps, and follows
        return [yp[0] - y[1], y[0] - abs(np.sin(t))]

    found = reduced(corner, (0.1, 5), [np.sin(0.1), 0.0], rtol=1e-8, atol=1e-8)
    assert found.success
    assert abs(found.y[1] - np.cos(found.t) * np.sign(np.sin(found.t))).max() < 1e-7

    def glued(t, y, yp):
        return [yp[0] - y[1], yp[1] + y[2], y[0] - (t * t if t < 1 else 2 * t - 1)]

    found = reduced(glued, (0, 5), [0.0, 0.0, 0.0])
    assert found.success and found.y[:2, -1] == pytest.approx([9.0, 2.0])


def test_no_time_at_all():
    found = reduced(pendulum, (1, 1), ON, **GIVEN)
    assert found.success and found.y[:2, -1].tolist() == ON[:2]


@pytest.mark.parametrize("span", [(0, 0.1), (1, 1)])
def test_what_never_happens_is_an_empty_list(span):
    found = reduced(pendulum, span, ON, events=lambda t, y, *args: y[0] - 9.0, t_eval=[], **GIVEN)
    assert found.success and found.t.size == 0 and found.y.shape == (5, 0)
    assert [each.size for each in (*found.t_events, *found.y_events)] == [0, 0]
