"""The command line: what it prints, writes and returns."""

import dataclasses
import os
import re
import subprocess
import sys

import numpy as np
import pytest

from fastdyn import __version__
from fastdyn.cli.main import main
from fastdyn.systems import SYSTEMS, building, drag, pendulum, tower


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
    assert np.array_equal(columns["t"], np.arange(101) / 10)
    exact = pendulum(V0=-5.0).exact(columns["t"])
    assert np.allclose(columns["theta"], exact[0], rtol=0, atol=1e-7)
    text = capsys.readouterr().out
    assert "regime = swinging" in text and "(error " in text


def test_run_with_a_fixed_step(capsys):
    assert main("run satellite --method VelocityVerlet --step 0.01 --t-end 10".split()) == 0
    said = capsys.readouterr().out
    assert re.search(r"energy has changed by \S+ m²/s²\n", said)
    assert re.search(r"angular momentum has changed by \S+ m²/s\n", said)


def test_run_that_fails_has_status_one_and_says_why(capsys):
    assert main("run satellite --rtol 1e-3 --atol 1e-6".split()) == 1
    assert "step" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, sentence",
    [
        ("run satellite --GM -1", "must be greater than zero, but -1 was given"),
        ("tour moon", "No system is called moon; choose from"),
        ("tour pendlum", "No system is called pendlum; did you mean pendulum?"),
        ("run satellite --method RK4", "RK4 takes constant steps: give their size"),
        ("run satellite --step 0.1", "RK45 adapts its steps: give `--rtol` and `--atol`"),
        ("run satellite --method RK4 --step 1 --rtol 1e-3", "give `--step`, not `--rtol`"),
        ("run drag --through-ground --events ground", "`--through-ground` does not"),
        ("run drag --start 0,0,0,1,1,1 --y0 3", "`--start` and `--y0` both set the start"),
        ("sweep satellite --V 1", "Give one parameter as a range"),
        ("sweep satellite --V 0:1:100000 --R 1:2:1000", "more than 1e+07"),
        ("sweep cable --V0 1,2", "solved one by one"),
        ("run nowhere.py", "there is no file 'nowhere.py'"),
        ("check nowhere.py", "there is no file 'nowhere.py'"),
        ("why nowhere.py:f", "there is no file 'nowhere.py'"),
        ("explore pendulm", "No system is called pendulm; did you mean pendulum?"),
    ],
)
def test_wrong_input_has_status_two_and_a_sentence(words, sentence, capsys):
    assert main(words.split()) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("", "required: COMMAND"),
        ("run", "required: SYSTEM"),
        ("run moon", "invalid choice: 'moon'"),
        ("runn", "argument COMMAND: invalid choice: 'runn'; did you mean run?"),
        ("run pendlum", "argument SYSTEM: invalid choice: 'pendlum'; did you mean pendulum?"),
        ("run pendulum --method verlet", "'verlet'; did you mean VelocityVerlet?"),
        ("drift pendulum --methods gauss16", "'gauss16'; did you mean Gauss16?"),
        ("run pendulum --V 1", "there is no --V; did you mean --V0?"),
        ("run pendulum --v0 1", "there is no --v0; did you mean --V0?"),
        ("run pendulum --tend 1", "there is no --tend; did you mean --t-end?"),
        ("run pendulum --zzz 1", "there is no --zzz; there are --help, --g, --l, --m"),
        ("sweep pendulum --theta 3", "there is no --theta; did you mean --theta0?"),
        ("run pendulum --l 6,5", "'6,5' has a comma; a decimal number has a point, '6.5'"),
        ("run pendulum --rtol 6,5", "'6,5' is not a number: a decimal number has a point, 6.5"),
        ("run pendulum --y0 0,1,0,2", "got 4; decimal numbers have points"),
        ("run pendulum --m 1kgg", "'1kgg' is not in kg; did you mean 'kg'?"),
        ("run pendulum --V0 x", "'x' is not a number"),
        ("run pendulum --V0 inf", "must be a finite number; got inf"),
        ("run satellite --method rk45", "there is no method 'rk45'; did you mean RK45?"),
        ("run satellite --method magic", "choose from RK23, RK45"),
        ("run satellite --rtol -1", "must be greater than zero; got -1"),
        ("run satellite --rtol nan", "must be a finite number; got nan"),
        ("run satellite --points 1", "must be at least 2"),
        ("run satellite --points 2.5", "'2.5' is not a whole number"),
        ("run satellite --t-end 0", "would end where it starts"),
        ("run satellite --y0 1,0,0", "starts from 4 numbers, x,y,vx,vy; got 3"),
        ("run satellite --y0 1,0,0,x", "'x' is not a number"),
        ("run satellite --events ground", "invalid choice: 'ground'"),
        ("run satellite --plot x.xyz", "must end in .png, .pdf or .svg"),
        ("run satellite --csv nowhere/x.csv", "there is no folder 'nowhere'"),
        ("run satellite --animate x.mp3", "must end in .gif, .html or .mp4"),
        ("run vehicle --driver sober", "choose from drunk, steady, coasting"),
        ("run vehicle --driver none.py:f", "there is no file 'none.py'"),
        ("sweep satellite --V 1:2", "a range is FROM:TO:COUNT; got '1:2'"),
        ("sweep satellite --V 1:2:2.5", "'2.5' is not a whole number"),
        ("sweep satellite --V nan,1", "must be a finite number; got nan"),
        ("drift satellite --periods -3", "must be greater than zero; got -3"),
    ],
)
def test_wrong_words_are_refused_before_anything_runs(words, sentence, capsys):
    with pytest.raises(SystemExit) as exit_:
        main(words.split())
    told = capsys.readouterr()
    assert exit_.value.code == 2 and sentence in told.err and "usage" in told.err
    assert not told.out


@pytest.mark.few(2)
@pytest.mark.parametrize(
    ("words", "statuses"),
    [("list", {141}), ("tour pendulum", {141}), ("worksheet", {141}), ("tour moon", {141}),
     ("run moon", {2, 141}), ("--help", {0, 141})],  # later argparses tell nobody
)  # fmt: skip
def test_where_nobody_reads_on_it_ends_without_a_word(words, statuses, tmp_path):
    """As in ``fastdyn tour | head -1``, by a reader that has gone before the first line."""
    reading, writing = os.pipe()
    os.close(reading)
    wrong = "moon" in words  # of which is told on the other output
    try:
        done = subprocess.run(
            [sys.executable, "-m", "fastdyn", *words.split()],
            stdout=subprocess.DEVNULL if wrong else writing,
            stderr=writing if wrong else subprocess.PIPE, cwd=tmp_path,
        )  # fmt: skip
    finally:
        os.close(writing)
    assert not done.stderr and done.returncode in statuses


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs a device that is full")
def test_where_the_disk_is_full_a_sentence_says_so():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "fastdyn", "list"], stdout=full, stderr=subprocess.PIPE,
            text=True,
        )  # fmt: skip
    assert done.returncode == 2 and done.stderr == "fastdyn: [Errno 28] No space left on device\n"


def test_derived_pages_and_files_are_named_and_run(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    told = " ".join(capsys.readouterr().out.split())
    assert "FILE.py:NAME" in told and "double_pendulum" in told
    path = tmp_path / "balls.py"
    path.write_text(
        "from fastdyn.systems import pendulum, satellite\n"
        "class light(pendulum): name, title = 'light', 'A light pendulum'\n"
        "class fast(satellite): name, title = 'fast', 'A fast satellite'\n"
    )
    for words in (["double_pendulum"], [f"{path}:fast"]):
        assert main(["run", *words, "--t-end", "0.5"]) == 0
    assert "energy" in capsys.readouterr().out


def test_version(capsys):
    with pytest.raises(SystemExit) as exit_:
        main(["--version"])
    assert exit_.value.code == 0 and capsys.readouterr().out == f"fastdyn {__version__}\n"


def test_a_run_stops_at_the_ground_and_tells_its_events(tmp_path, capsys):
    ball = drag()
    landed = ball.solve(events="ground").t[-1]
    assert main("run drag --events apex".split()) == 0
    text = capsys.readouterr().out
    assert f"At t = {landed:.10g} s:" in text and "ground at t = " in text
    assert "apex at t = 0.53186" in text and "which ends the run" in text
    table = tmp_path / "landing.csv"
    assert main(f"run drag --points 5 --csv {table}".split()) == 0
    assert f"At t = {landed:.10g} s:" in capsys.readouterr().out
    t = np.genfromtxt(table, delimiter=",", names=True)["t"]
    assert np.array_equal(t, [0.0, 1.25, landed])
    assert main("run projectile --t-end -1".split()) == 0
    assert "At t = -1 s:" in capsys.readouterr().out
    assert main("run drag --through-ground".split()) == 0
    assert "At t = 5 s:" in capsys.readouterr().out
    assert main("run projectile --vz0 20 --z0 1000 --t-end 1".split()) == 0
    assert "ground: not reached" in capsys.readouterr().out


def test_a_run_from_another_start(capsys):
    assert main("run satellite --y0 -1,0,0,-1e0 --t-end 1".split()) == 0
    text = capsys.readouterr().out
    assert "x = -0.5403" in text and "period" not in text and "error" not in text
    assert main("run satellite --V -1e0 --t-end 1".split()) == 0
    assert "y = -0.8414" in capsys.readouterr().out


def test_a_driver_of_ones_own(tmp_path, capsys):
    file = tmp_path / "drivers.py"
    file.write_text("def mine(t, w): return 0.1, 0.0, 0.2\ndef two(t, w): return 0.1, 0.0\n")
    texts = []
    for driver in (f"{file}:mine", "steady", "drunk"):
        assert main(["run", "vehicle", "--driver", driver, "--t-end", "5"]) == 0
        texts.append(capsys.readouterr().out.partition("At t")[2])
    assert texts[0] == texts[1] != texts[2]
    assert main(["run", "vehicle", "--driver", f"{file}:two"]) == 2
    assert "must return three numbers" in capsys.readouterr().err
    file.write_text("raise RuntimeError('no')")
    with pytest.raises(SystemExit):
        main(["run", "vehicle", "--driver", f"{file}:mine"])
    assert "does not run: RuntimeError('no')" in capsys.readouterr().err


def test_no_table_holds_nan_or_inf(tmp_path, capsys):
    table = tmp_path / "sweep.csv"
    for words, status in (
        ("run drag --c 0", 0),
        ("run cable --V0 1 --t-end 1", 0),
        ("run pendulum --V0 6.26418390534633 --t-end 1", 0),
        ("drift satellite --V 2 --methods RK45 --t-end 20", 0),
        ("sweep satellite --V 0,0.5,1 --reduce max final", 1),
        (f"sweep pendulum --V0 1,5 --events slack --reduce first_event --csv {table}", 0),
    ):
        assert main(words.split()) == status
        text = capsys.readouterr().out
        assert not re.search(r"\b(nan|inf)\b", text), text
    assert "none" in text
    rows = table.read_text().splitlines()[1:]
    assert rows[0].startswith("1,") and rows[0].endswith(",") and not rows[1].endswith(",")


def test_a_sweep_tells_its_result(capsys):
    assert main("sweep building --omega 8:9:101 --reduce max --t-end 5".split()) == 0
    text = capsys.readouterr().out
    swept = building().ensemble((0, 5), omega=np.linspace(8, 9, 101), reduce="max")
    highest = swept.reduced["max"][:, 1]
    at = np.linspace(8, 9, 101)[highest.argmax()]
    assert f"y2: largest {highest.max():.6g} m at omega = {at:.6g}" in text
    assert text.count("\n") < 22 and "12 of 101 rows" in text
    assert main("sweep tower --V 5,10 --reduce final first_event".split()) == 0
    text = capsys.readouterr().out
    assert f"{tower(V=10.0).range:.6g}" in text and "ground: largest" in text


def test_no_parameter_hides_an_option():
    options = {"t_end", "method", "rtol", "atol", "step", "points", "plot", "csv", "help"}
    options |= {"project", "animate", "methods", "steps_per_period", "evaluations", "periods"}
    options |= {"n_steps", "samples", "checkpoint", "start", "events", "through_ground"}
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


def test_why_reads_which_functions_a_file_has_and_runs_it_once(tmp_path, capsys):
    file = tmp_path / "orbit.py"
    file.write_text("print('runs')\ndef fall(t, y): return [y[1], -9.81]\n")
    assert main(["why", str(file)]) == 2
    said = capsys.readouterr()
    assert f"such as {file}:fall" in said.err and "runs" not in said.out
    assert main(["why", f"{file}:fal"]) == 2 and "did you mean fall?" in capsys.readouterr().err
    assert main(["why", f"{file}:fall"]) == 0 and capsys.readouterr().out.count("runs") == 1
