"""Pages without a browser: their solver by node, their text, the commands that write them."""

import html
import html.parser
import re
import shutil

import numpy as np
import pytest

from fastdyn import systems
from fastdyn.cli.main import main
from fastdyn.kernels.methods import METHODS
from fastdyn.pages import html as of_page
from fastdyn.pages import methods, plain, site
from fastdyn.pages.functions import PageFunctions
from fastdyn.systems.base import State, System, parameter, quantity
from fastdyn.trace.emit.source.functions import NotExported
from support.pages import DERIVED, Case, by_node, compare

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
MOST_BYTES = 400_000


@needs_node
@pytest.mark.few(5)
@pytest.mark.parametrize("name", systems.SYSTEMS)
def test_a_page_solves_as_fastdyn_does(name, tmp_path):
    case = Case(name)
    functions = PageFunctions(case.first)
    calls, runs = case.runs(functions)
    assert functions.left_out == [] and functions.scene is not None
    compare(calls, runs, by_node(of_page.solver(functions), case, calls, tmp_path))


@needs_node
@pytest.mark.parametrize("name", DERIVED[:2])
def test_a_page_solves_derived_systems(name, tmp_path):
    pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    case = Case(name)
    functions = PageFunctions(case.first)
    calls, runs = case.runs(functions)
    compare(calls, runs, by_node(of_page.solver(functions), case, calls, tmp_path))


def test_methods_are_written_from_the_tables_of_the_kernels():
    text = methods.text()
    for name in ("RK45", "RK4"):
        table = METHODS[name].code.tableau
        for row in (*table["a"], table["b"], *(table["e"] or ()), *(table["d"] or ())):
            for one in row.floats:
                assert one == 0.0 or repr(abs(one)) in text, (name, one)


# -- the text of a page


class Parts(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.addresses = [], []

    def handle_starttag(self, tag, attrs):
        self.found.append(tag)
        self.addresses += [value for key, value in attrs if key in ("src", "href")]


@pytest.mark.parametrize("name", systems.SYSTEMS)
def test_a_page_is_one_file_without_addresses(name, tmp_path):
    file = systems.SYSTEMS[name]().page(tmp_path / "page.html")
    text = file.read_text("utf-8")
    assert len(text.encode()) <= MOST_BYTES
    parts = Parts()
    parts.feed(text)
    assert parts.found.count("script") == 2 and parts.addresses == ["data:,"]
    assert "default-src 'none'" in text and "Leon Sorokin" in text
    assert not re.search(
        r"\b(eval|Function|fetch|XMLHttpRequest|import)\s*\(", text.split("uPlot.js")[-1]
    )


def test_texts_of_a_stranger_run_nothing(tmp_path):
    import dataclasses

    evil = "</script><script>alert(1)</script><!-- \u2028 ${1} '\"`&"

    def rhs(t, w, a):
        return [a * w[0]]

    def odd(t, w, a):
        return w[0]

    space = {
        "__annotations__": {"a": float}, "name": "evil", "title": evil, "source": evil,
        "t_end": 1.0,
        "states": (State(evil, evil, evil),), "rhs": staticmethod(rhs),
        "a": parameter(1.0, evil, evil), "initial_state": lambda self: (1.0,),
        "odd": quantity(evil, evil)(odd),
    }  # fmt: skip
    made = dataclasses.dataclass(frozen=True)(type("Evil", (System,), space))
    text = made().page(tmp_path / "evil.html").read_text("utf-8")
    parts = Parts()
    parts.feed(text)
    assert parts.found.count("script") == 2
    assert "<script>alert" not in text
    assert "\u2028" not in "".join(re.findall(r"<script>.*?</script>", text, re.DOTALL))


def test_the_nine_steps_are_mathml(tmp_path):
    pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    from fastdyn.derive.pages import page

    text = page("pendulum").derive().system().page(tmp_path / "page.html").read_text("utf-8")
    steps = html.unescape(text[text.index("<ol>") : text.index("</ol>")])
    assert steps.count("<li>") == 9 and "<math>" in steps
    assert "<mover><mi>θ</mi><mo>¨</mo></mover>" in steps
    assert "<mo>−</mo>" in steps and "<mi>𝐣</mi>" in steps


# -- what is refused, and the commands

MINE = """
import math
import random

def swing(t, y, g, l):
    return [y[1], -g / l * math.sin(y[0])]

def down(t, y, g, l):
    return y[0]

def noisy(t, y):
    return [random.random()]

def named(t, y, solve, name):
    return [solve * y[0] * name]
"""


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    (tmp_path / "mine.py").write_text(MINE, "utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))

    def ask(words):
        status = main(words.split())
        return status, *capsys.readouterr()

    return ask


def test_the_command_writes_pages(command, tmp_path):
    assert command("page pendulum --out a.html")[:2] == (0, "a.html\n")
    assert '"value": 4.0' in (tmp_path / "a.html").read_text("utf-8")  # as `explore` begins
    words = "page mine.py:swing --y0 1,0 --args 9.81,1 --events down --t-end 5"
    assert command(words)[:2] == (0, "swing.html\n")
    text = (tmp_path / "swing.html").read_text("utf-8")
    assert '"tEnd": 5.0' in text and '"name": "down"' in text and '"name": "g"' in text
    assert command("page mine.py:named --y0 1 --args 1.5,2.5")[0] == 0  # names that systems have


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("page mine.py:noisy --n 1", "mine.py, line 12"),
        ("page", "give a system"),
        ("page pendulum --all", "not both"),
        ("page pendulum --y0 1,2", "`--y0` belongs to FILE:FUNCTION"),
        ("page pendulu", "pendulum"),
    ],
)
def test_refusals(words, said, command):
    status, out, err = command(words)
    assert (status, out) == (2, "") and said in err


def test_a_site_has_an_index(tmp_path):
    said = []
    found = site.build(tmp_path / "site", ["pendulum", "cable", "nothing"], said.append)
    assert [path.name for path in found] == ["pendulum.html", "cable.html", "index.html"]
    assert "nothing is left out" in said[-1]
    assert 'href="cable.html"' in found[-1].read_text("utf-8")


@needs_node
def test_the_page_of_a_plain_function(tmp_path):
    def lorenz(t, y, s, r, b):
        return [s * (y[1] - y[0]), r * y[0] - y[1] - y[0] * y[2], y[0] * y[1] - b * y[2]]

    system = plain.system_of(lorenz, "lorenz", [1.0, 1.0, 1.0], (10.0, 28.0, 8 / 3), {}, 2.0)
    functions = PageFunctions(system)
    case = object.__new__(Case)
    case.first, case.systems, case.t_end, case.make = system, [system], 2.0, type(system)
    calls, runs = case.runs(functions)
    assert [call[1] for call in calls] == ["RK45", "RK4", "EnergyConserving2"]
    compare(calls, runs, by_node(of_page.solver(functions), case, calls, tmp_path))
    assert np.allclose(functions.system.initial_state(), 1.0)


# -- what a page could not solve as fastdyn does


def pulse(t, y, a):
    return [a if 1.0 < t < 1.01 else 0.0]


def test_a_page_loses_no_pulse():
    system = plain.system_of(pulse, "pulse", [0.0], (2.0,), {})
    with pytest.raises(NotExported, match="the equations of pulse switch with the time"):
        of_page.page(system)
    times = np.linspace(0.0, 3.0, 4)
    building = systems.building.sampled(times, displacements=0.1 * times)
    with pytest.raises(NotExported, match="the building has breakpoints"):
        of_page.page(building)


def test_an_event_with_a_rule_that_no_page_has_is_told():
    def falling(t, y, g):
        return [y[1], -g]

    def low(t, y, g):
        return y[0]

    def bounced(t, y, g):
        return y[0]

    low.direction = -1
    bounced.wait = 0.5
    events = {"bounced": bounced, "low": low}
    functions = PageFunctions(plain.system_of(falling, "fall", [0.0, 3.0], (9.81,), events))
    assert [(one["name"], one["direction"]) for one in functions.events] == [("low", -1.0)]
    assert len(functions.left_out) == 1 and "bounced is not sought here" in functions.left_out[0]
    assert "event has `wait`" in functions.left_out[0]
    assert "events: [function" in functions.texts[0].text


@pytest.mark.parametrize("rule, value", [("terminal", 2), ("wait", 0.5)])
def test_a_phase_with_a_rule_that_no_page_has_is_refused(rule, value, monkeypatch):
    def end(t, y, *args):
        return y[0]

    end.terminal = True
    setattr(end, rule, value)
    cable = systems.cable()
    phases = {name: one._replace(event=end) for name, one in cable.phases().items()}
    monkeypatch.setattr(type(cable), "phases", lambda self: phases)
    with pytest.raises(NotExported, match=f"phase cable ends .* `{rule}`"):
        of_page.page(cable)


def test_friction_is_refused(tmp_path):
    pytest.importorskip("sympy", reason="the extra `derive` is not installed")
    from fastdyn.derive import Model, i, j

    board = Model("floor")
    x, y = board.coordinates("x y")
    m, g, mu = board.parameters(m=(2.0, "kg"), g=(9.81, "m/s²"), mu=(0.5, "1"))
    block = board.particle(m, x * i + y * j, "block")
    board.gravity(-g * j)
    block.slides(j, board.reactions("N"), through=0 * i, friction=mu, along=i)
    board.start(vx=1.0, x=0)
    system = board.newton().system()
    for write in (system.page, system.export):
        with pytest.raises(ValueError, match="slips and rests"):
            write(tmp_path / "floor")
    assert list(tmp_path.iterdir()) == []
