"""The command line: what it prints, writes and returns."""

import dataclasses

import numpy as np
import pytest

from fastdyn.cli.main import main
from fastdyn.systems import SYSTEMS, pendulum


def test_list_names_every_system_and_parameter(capsys):
    assert main(["list"]) == 0
    text = capsys.readouterr().out
    for name, system in SYSTEMS.items():
        assert f"{name}: {system.title}" in text
        assert all(f"\n    {field.name} " in text for field in dataclasses.fields(system))


def test_run_writes_table_and_figure(tmp_path, capsys):
    table, figure = tmp_path / "swing.csv", tmp_path / "swing.png"
    words = "run pendulum --V0 -5 --t-end 10 --method DOP853 --rtol 1e-10 --atol 1e-12 --points 101"
    assert main([*words.split(), "--csv", str(table), "--plot", str(figure)]) == 0
    assert figure.read_bytes().startswith(b"\x89PNG")
    columns = np.genfromtxt(table, delimiter=",", names=True)
    assert columns.dtype.names == ("t", "theta", "omega", "energy", "tension")
    assert np.array_equal(columns["t"], np.linspace(0.0, 10.0, 101))
    exact = pendulum(V0=-5.0).exact(columns["t"])
    assert np.allclose(columns["theta"], exact[0], rtol=0, atol=1e-7)
    text = capsys.readouterr().out
    assert "regime = swinging" in text and "(error " in text


def test_run_with_a_fixed_step(capsys):
    assert main("run satellite --method VelocityVerlet --step 0.01 --t-end 10".split()) == 0
    assert "angular momentum has changed by" in capsys.readouterr().out


def test_run_that_fails_has_status_one_and_says_why(capsys):
    assert main("run satellite --rtol 1e-3 --atol 1e-6".split()) == 1
    assert "step" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, sentence",
    [
        ("run satellite --GM -1", "must be greater than zero, but -1 was given"),
        ("run satellite --method RK54", "RK45"),
        ("tour moon", "No system is called moon; choose from"),
        ("run pendulum --plot nowhere/at/all/x.png --t-end 1", "nowhere"),
    ],
)
def test_wrong_input_has_status_two_and_a_sentence(words, sentence, capsys):
    assert main(words.split()) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    "words", ["", "run", "run moon", "run pendulum --V 1", "run pendulum --V0 x"]
)
def test_unknown_words_are_refused_by_the_parser(words, capsys):
    with pytest.raises(SystemExit) as exit_:
        main(words.split())
    assert exit_.value.code == 2 and "usage" in capsys.readouterr().err


def test_no_parameter_hides_an_option():
    options = {"t_end", "method", "rtol", "atol", "step", "points", "plot", "csv", "help"}
    options |= {"project", "animate", "methods", "steps_per_period", "evaluations", "periods"}
    options |= {"n_steps", "samples", "checkpoint"}
    for system in SYSTEMS.values():
        assert options.isdisjoint(field.name for field in dataclasses.fields(system))


def test_drift_from_the_command_line(tmp_path, capsys):
    figure = tmp_path / "drift.png"
    words = "drift satellite --V 1.2 --methods VelocityVerlet BlanesMoan6 --steps-per-period 100"
    assert main([*words.split(), "--periods", "50", "--plot", str(figure)]) == 0
    text = capsys.readouterr().out
    assert "BlanesMoan6" in text and "bounded" in text and figure.exists()
    words = "drift satellite --methods VelocityVerlet --evaluations 300 --periods 20"
    assert main(words.split()) == 0
    assert main("drift satellite --methods Gauss16".split()) == 2
