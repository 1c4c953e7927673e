"""odeset and odeget: MATLAB's names, shortened or not, and what they refuse."""

import numpy as np
import pytest

from fastdyn.matlab import ode45, odeget, odeset
from fastdyn.matlab.options import NAMES, full_name


def test_names_may_be_shortened_and_their_case_does_not_count():
    given = odeset("reltol", 1e-5, "ABST", [1e-6, 1e-7], "ev", print, "mass", np.eye(2))
    assert list(given) == ["RelTol", "AbsTol", "Events", "Mass"]
    assert all(full_name(name) == full_name(name.lower()) == name for name in NAMES)
    assert odeset(RelTol=1e-5, refine=2) == {"RelTol": 1e-5, "Refine": 2}


def test_later_options_rule_and_empty_ones_reset():
    old = odeset("RelTol", 1e-5, "Stats", "on")
    assert odeset(old, "RelTol", 1e-7) == {"RelTol": 1e-7, "Stats": True}
    assert odeset(old, odeset("Stats", "off"), "Rel", []) == {"Stats": False}
    assert old == {"RelTol": 1e-5, "Stats": True}
    assert odeget(old, "rel") == 1e-5
    assert odeget(old, "MaxStep") is None and odeget(None, "MaxStep", 0.1) == 0.1


@pytest.mark.parametrize(
    ("given", "error", "sentence"),
    [
        (("Ma", 1), ValueError, "ambiguous: Mass, MassSingular, MaxOrder, MaxStep begin so"),
        (("MaxStp", 1), ValueError, "did you mean MaxStep"),
        (("tolerance", 1), ValueError, "choose from AbsTol, BDF"),
        (("", 1), ValueError, "choose from AbsTol, BDF"),
        (("RelTol",), ValueError, "in turns; 'RelTol' has no partner"),
        ((1e-5, "RelTol"), TypeError, "names and values, or older options; got 1e-05"),
        (("RelTol", 1e-5, 3, 4), TypeError, "the name of an option is a string; got 3"),
        (("RelTol", [1e-3, 1e-3]), ValueError, "RelTol must be one positive number"),
        (("RelTol", "small"), TypeError, "RelTol must be a number; got 'small'"),
        (("AbsTol", [1e-6, 0.0]), ValueError, "AbsTol must be positive"),
        (("MaxStep", float("nan")), ValueError, "MaxStep must be one positive number"),
        (("Refine", 1.5), ValueError, "Refine must be a whole number"),
        (("Stats", "yes"), ValueError, "Stats must be 'on' or 'off'"),
        (("Events", "hit"), TypeError, "Events must be a function"),
    ],
)
def test_wrong_options_get_a_sentence(given, error, sentence):
    with pytest.raises(error, match=sentence):
        odeset(*given)


def test_what_is_written_as_in_matlab_and_differs_gets_a_sentence():
    def decay(t, y):
        return -y

    with pytest.raises(TypeError, match=r"`\^` is the exclusive or .*; a power is y\*\*3"):
        ode45(lambda t, y: -(y ^ 3), [0, 1], [1.0])
    with pytest.raises(TypeError, match=r"a power is y\*\*3"):
        ode45(lambda t, y: [-(y[0] ^ 3)], [0, 1], [1.0])
    with pytest.raises(ValueError, match=r"AbsTol must be one number, .* 2 components .*; got 3"):
        ode45(decay, [0, 1], [1.0, 2.0], odeset("AbsTol", [1e-3, 1e-4, 1e-5]))
    with pytest.raises(TypeError, match=r"no entry 0: write `t, y = ode45\(...\)`"):
        ode45(decay, [0, 1], [1.0])[0]
    with pytest.raises(ValueError, match=r"for 5 names: .* need the option Events"):
        _t, _y, _te, _ye, _ie = ode45(decay, [0, 1], [1.0])
