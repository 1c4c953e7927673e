"""The names at the top of fastdyn, those of its topics, and those that moved."""

import importlib
import inspect
import pathlib
import pickle
import subprocess
import sys

import numpy as np
import pytest

import fastdyn

API = pathlib.Path(__file__).parents[1] / "docs" / "api"
TOPICS = ("analysis", "dae", "drift", "ensemble", "matlab", "planets", "solve")


def test_each_public_name_is_in_the_reference():
    text = "\n".join(path.read_text("utf-8") for path in API.glob("*.md"))
    for name in {*fastdyn.__all__} - {"__version__", "analysis", "systems"}:
        assert getattr(fastdyn, name) is not None
        assert f"`{name}`" in text or f".{name}\n" in text, name
    for topic in TOPICS:
        module = importlib.import_module(f"fastdyn.{topic}")
        missing = [name for name in module.__all__ if f"fastdyn.{topic}.{name}\n" not in text]
        assert missing == []
        assert not {*module.__all__} & {*fastdyn.__all__}


@pytest.mark.parametrize("name", sorted(fastdyn._MOVED))
def test_a_name_that_moved_is_given_with_a_sentence(name):
    folder = f"fastdyn.{fastdyn._MOVED[name]}"
    with pytest.warns(DeprecationWarning, match=f"from {folder} import {name}") as caught:
        found = getattr(fastdyn, name)
    assert found is getattr(importlib.import_module(folder), name)
    assert [each.filename for each in caught] == [__file__]
    assert name not in dir(fastdyn)


def test_a_moved_class_is_pickled_as_before():
    """Its module is the one that pickles of earlier states of the package name."""
    data = pickle.dumps(fastdyn.ensemble.Shared(np.array([1.0])), protocol=0)
    assert b"fastdyn.problem.members" in data
    assert fastdyn.ensemble.Fold.__module__ == "fastdyn.ensemble.reductions"
    assert fastdyn.systems.System.__module__ == "fastdyn.systems.base.system"


def test_importing_fastdyn_imports_no_topic():
    topics = [f"fastdyn.{name}" for name in ("analysis", "dae", "drift", "ensemble", "systems")]
    script = f"import fastdyn, sys; print([name for name in {topics} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr
    with pytest.raises(AttributeError, match="no attribute 'solve_ipv'"):
        _ = fastdyn.solve_ipv


def test_signatures_and_methods_are_shown_in_words():
    text = str(inspect.signature(fastdyn.solve_ivp))
    assert text.startswith("(fun: 'Function', t_span: 'TimeSpan', y0: 'State'")
    for name in fastdyn.__all__:
        found = getattr(fastdyn, name)
        if inspect.isfunction(found):
            assert "types." not in str(inspect.signature(found)), name
    assert repr(fastdyn.METHODS["RK45"]) == "<RK45: order 5, 6 stages, adaptive steps>"
