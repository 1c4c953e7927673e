"""The command ``fastdyn why``: by which way a function is compiled, and what prevents it."""

import pytest

from fastdyn.cli.main import main

SOURCE = """
import functools
import math

import numpy as np
from scipy import special

calls = 0


def satellite(t, w, GM):
    x, y, vx, vy = w
    r = np.sqrt(x**2 + y**2)
    return [vx, vy, -GM * x / r**3, -GM * y / r**3]


class Spring:
    def __init__(self, k):
        self.k = k

    def rhs(self, t, y):
        return [y[1], -self.k * y[0]]


stiff = Spring(100.0)


def kepler(t, y, e):
    E = y[0]
    while abs(E - e * math.sin(E) - t) > 1e-10:
        E -= (E - e * math.sin(E) - t) / (1 - e * math.cos(E))
    return [E]


def counted(t, y):
    global calls
    calls += 1
    return [-y[0]]


def rounded(t, y):
    return [-math.floor(10 * y[0])]


def bessel(t, y):
    return [special.j0(y[0])]


def heat(t, u):
    return np.roll(u, 1) - 2 * u + np.roll(u, -1)


def divides(t, y):
    return [1 / 0]


def pair(t, y):
    return [1.0, y[0], 2.0, 3.0][: len(y) + 1]
"""


@pytest.fixture
def why(tmp_path, monkeypatch, capsys):
    """``why(words)``: the exit status, what is printed, and what is printed as an error."""
    (tmp_path / "mine.py").write_text(SOURCE, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))  # and taken out again

    def ask(words):
        status = main(["why", *words.split()])
        return status, *capsys.readouterr()

    return ask


def line(text):
    """The line of SOURCE that begins with a text, as it is printed."""
    numbers = [i for i, one in enumerate(SOURCE.splitlines(), 1) if one.strip().startswith(text)]
    return f"mine.py:{numbers[0]}: {text}"


def test_a_traced_function_is_told_with_its_size(why):
    status, out, _ = why("mine.py:satellite --y0 1,0,0,1.2 --args 1.0")
    assert status == 0 and out.startswith("satellite is traced (t = 0, y of 4, args = (1.0,)): ")
    assert out.endswith(" nodes, 1 path.\nIt has a Taylor series.\n")


def test_a_length_of_the_state_is_found_by_trying(why):
    assert "satellite is traced (t = 0, y of 4" in why("mine.py:satellite --args 1.0")[1]


def test_a_negative_state_and_a_method_of_an_object(why):
    status, out, _ = why("mine.py:stiff.rhs --y0 -1,0")
    assert status == 0 and out.startswith("stiff.rhs is traced (t = 0, y of 2")


def test_a_long_state_is_traced_in_batches(why):
    status, out, _ = why("mine.py:heat --n 1000")
    assert status == 0 and out.startswith("heat is traced (t = 0, y of 1000, args = ()): ")
    assert out.endswith(" batches, 1 path.\n")


def test_a_function_without_a_series_says_so(why):
    assert "It has no Taylor series: rounding to a whole number" in why("mine.py:rounded")[1]
    assert "It has no Taylor series: a special function of SciPy" in why("mine.py:bessel")[1]


def test_what_tracing_refuses_is_told_with_the_lines_that_decide(why):
    status, out, _ = why("mine.py:kepler --args 0.3")
    assert status == 0 and "kepler is compiled by Numba" in out
    assert "it decides too often" in out and line("while abs(E") in out


def test_what_stays_in_python_is_told_with_its_line(why):
    status, out, _ = why("mine.py:counted")
    assert status == 1 and out.startswith("counted runs in Python")
    assert "it changes a global variable" in out and line("calls += 1") in out


@pytest.mark.parametrize(
    ("kind", "text"), [("llvm", " @stiff_rhs(ptr "), ("assembly", "\nstiff_rhs:\n")]
)
def test_the_machine_code_is_shown(why, kind, text):
    assert text in why(f"mine.py:stiff.rhs --show {kind}")[1]


@pytest.mark.parametrize(
    ("method", "text"),
    [
        ("RK45", "# k3 = f(t + 3/10 h, y + h (3/40 k1 + 9/40 k2))\n    u = combine("),
        ("RK45", "# row 3 = h (-12715105075/11282082432 k1"),  # of the interpolant
        ("Radau", "def step(rhs, state, work, block, h_min):"),
    ],
)
def test_the_step_of_a_method_is_shown(capsys, method, text):
    assert main(["why", "--show", "kernel", method]) == 0
    assert text in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("mine.py", "give FILE:FUNCTION"),
        ("RK54 --show kernel", "there is no method 'RK54'; did you mean"),
        ("nowhere.py:f", "there is no file 'nowhere.py'"),
        ("mine.py:nothing", "'mine.py' defines no function 'nothing'"),
        ("mine.py:satellite", "missing a required argument: 'GM': `--args` gives"),
        (
            "mine.py:divides",
            "('division by zero'); give a state, `--y0`",
        ),
        (
            "mine.py:satellite --args 1.0 --y0 1,0",
            "to unpack (expected 4, got 2)",
        ),
        ("mine.py:pair --y0 1,2", "it returns 3 numbers for 2 components"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_a_sentence(why, words, sentence):
    status, out, told = why(words)
    assert (status, out) == (2, "") and sentence in told


@pytest.mark.parametrize(
    "words", ["--y0 1,x", "--n 0", "--n 2 --y0 1,2", "--args 1,os.getcwd()", "--show source"]
)
def test_wrong_words_are_refused_before_the_file_is_read(words, capsys):
    with pytest.raises(SystemExit):
        main(["why", "nowhere.py:f", *words.split()])
    assert "usage" in capsys.readouterr().err
