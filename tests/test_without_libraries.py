"""A solve needs neither matplotlib nor tqdm; what needs them says so in a sentence."""

import os
import subprocess
import sys

ABSENT = "import sys; sys.modules.update(dict.fromkeys(['matplotlib', 'tqdm', 'sympy']))\n"
GIVEN = "import fastdyn, fastdyn.systems\ngiven = (lambda t, y: -y, (0, 1), [1.0])\n"


def run(script):
    return subprocess.run(
        [sys.executable, "-c", ABSENT + GIVEN + script], capture_output=True, text=True
    )


def test_a_solve_needs_neither():
    done = run("""
fastdyn.solve_ivp(*given)
fastdyn.solve_ivp(*given, method='Radau', dense_output=True, events=lambda t, y: y[0] - 0.5)
fastdyn.solve_ensemble(*given[:2], [[1.0], [2.0]])
fastdyn.energy_drift(fastdyn.systems.satellite(), 'KahanLi8', step=0.1, n_steps=500)
fastdyn.systems.pendulum().solve()
""")
    assert done.returncode == 0, done.stderr


NEED = {
    "fastdyn.systems.pendulum().solve().plot()": "Figures need matplotlib: ",
    "fastdyn.systems.pendulum().solve().animate('swing.gif')": "Figures need matplotlib: ",
    "fastdyn.solve_ivp(*given, progress=True)": "Progress bars need tqdm: ",
    "fastdyn.solve_ensemble(*given[:2], [[1.0]], progress=True)": "Progress bars need tqdm: ",
}
SAY = """
for script in scripts:
    try:
        exec(script)
    except ImportError as error:
        print(error)
"""


def test_a_missing_library_is_named(tmp_path):
    done = run(f"import os; os.chdir({str(tmp_path)!r}); scripts = {list(NEED)}\n{SAY}")
    told = done.stdout.splitlines()
    for sentence, said in zip(NEED.values(), told, strict=True):
        assert said.startswith(sentence) and said.endswith(f"install {sentence.split()[-1][:-1]}")


def test_the_command_says_it_without_a_traceback(tmp_path):
    script = "from fastdyn.cli.main import main\nsys.exit(main(sys.argv[1:]))"
    words = ["run", "pendulum", "--plot", str(tmp_path / "swing.png")]
    done = subprocess.run(
        [sys.executable, "-c", ABSENT + script, *words], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "fastdyn: Figures need matplotlib: " in done.stderr


def test_a_command_that_draws_nothing_imports_no_matplotlib():
    script = "import sys; from fastdyn.cli.main import main; main(['list'])\n"
    script += "sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], env=os.environ).returncode == 0
