"""Whoever waits for Numba is told what for, once for each method, in the log of fastdyn."""

import logging
import time

import pytest

from fastdyn import code_store
from fastdyn.cli.main import main
from fastdyn.code_store import announced
from fastdyn.compile import background
from fastdyn.run.memory import Plan
from fastdyn.specialise import scalar


class Made(Exception):
    pass


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    monkeypatch.setattr(announced, "AFTER", 0.0)
    monkeypatch.setattr(announced, "_told", set())


def compile_until(heard, made_by=code_store.KERNELS, seconds=30.0):
    """The lines in the log after a compilation that lasts until `heard()`, or for some seconds."""

    def build():
        end = time.monotonic() + seconds
        while not heard() and time.monotonic() < end:
            time.sleep(0.001)
        raise Made

    with pytest.raises(Made):
        code_store.compiled("a key that is not on disk", build, made_by)


def test_a_line_names_the_method_that_waits_once(caplog):
    Plan("BDF", False, 2, 0, 0, 8, (1, 6), 0, 4)
    compile_until(lambda: caplog.messages)
    compile_until(lambda: len(caplog.messages) > 1, seconds=0.05)
    assert caplog.messages == ["fastdyn compiles the kernel of BDF, once on this machine ..."]
    compile_until(lambda: len(caplog.messages) > 1, code_store.FUNCTIONS)
    assert caplog.messages[1:] == ["fastdyn compiles a function by Numba ..."]


def test_nobody_waits_for_the_background_thread(caplog):
    job = background.Job(lambda: compile_until(lambda: caplog.messages, seconds=0.05))
    assert job.wait(30) and not caplog.messages


def test_the_line_is_silenced_as_any_other(caplog):
    caplog.set_level(logging.ERROR, "fastdyn")
    compile_until(lambda: caplog.messages, seconds=0.05)
    assert not caplog.messages


def test_the_command_makes_kernels_and_says_what_it_does(capsys, monkeypatch):
    asked = []
    monkeypatch.setattr(scalar, "make_kernels", asked.append)
    assert main(["compile", "RK45", "Radau"]) == 0
    assert asked == ["RK45", "Radau", None]
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[3] for line in lines] == ["RK45", "Radau", "what"]
    assert not announced.LOG.disabled


def test_the_kernels_of_a_method_are_those_that_its_solves_load(monkeypatch):
    kept = []
    monkeypatch.setattr(scalar, "_kept", lambda key, make, made_by: kept.append(key))
    scalar.make_kernels("Radau")
    scalar.make_kernels()
    used = [scalar._start("Radau"), scalar._dense_rows("Radau"), scalar._shared("Radau")]
    assert {recipe.key for recipe in used} | {"whole solve", "watch plain", "launch"} <= set(kept)
