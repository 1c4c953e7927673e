"""The modes are records in one file, and no other file asks for the name of one."""

import ast
import pathlib
import pickle

import fastdyn
from fastdyn.compile import mode

ROOT = pathlib.Path(fastdyn.__file__).parent
OF_NUMPY = "trace/"  # which knows none of ours, but arguments of NumPy's with this name


def texts(node):
    return [n.value for n in ast.walk(node) if isinstance(n, ast.Constant) and type(n.value) is str]


def is_mode(node):
    name = getattr(node, "id", getattr(node, "attr", ""))
    return name in ("mode", "_mode", "event_mode")


def asked(tree):
    """Lines that compare a mode with text, look a mode up, or take its name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            parts = [node.left, *node.comparators]
            if any(map(is_mode, parts)) and any(map(texts, parts)):
                yield node.lineno
        if (
            isinstance(node, ast.Attribute)
            and is_mode(node.value)
            and node.attr in ("name", "split")
        ):
            yield node.lineno
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if name in ("bind", "evaluate", "Callback", "Traced", "traced_function"):
                given = [a.value for a in node.args if isinstance(a, ast.Constant)]
                if set(map(str, given)) & set(mode.MODES):
                    yield node.lineno


def test_no_other_file_asks_for_the_name_of_a_mode():
    found = []
    for path in ROOT.rglob("*.py"):
        where = path.relative_to(ROOT).as_posix()
        if where != "compile/mode.py" and not where.startswith(OF_NUMPY):
            found += [f"{where}:{line}" for line in asked(ast.parse(path.read_text()))]
    assert found == []
    assert list(asked(ast.parse("if mode == 'event': bind(f, (), 'event', 2)"))) == [1, 1]


def test_a_mode_is_one_record_in_every_process():
    for one in mode.MODES.values():
        assert pickle.loads(pickle.dumps(one)) is one


def test_lengths_of_modes():
    assert mode.DERIVATIVE.shapes(4) == (4, (4,), 0)
    assert mode.ACCELERATION.shapes(4) == (4, (8,), 4)
    assert mode.MATRIX.shapes(3) == (3, (9,), 0) and mode.MATRIX.n_results(3) == 9
    assert mode.COMPLEX_NUMBERS.shapes(4) == (2, (2,), 0)
    assert mode.COMPLEX_EVENT.shapes(4) == (2, None, 0) and mode.COMPLEX_EVENT.n_results(4) == 1
    assert mode.MOMENTS["mean", "rms"].shapes(6) == (2, (2,), 0)
