"""What the tests of the house ask about a file of Python: each file is parsed once, and let go."""

import ast
import functools
from typing import NamedTuple


class Function(NamedTuple):
    """A function: the lines of its body without the docstring, and the number of parameters."""

    name: str
    body: int
    n_parameters: int


class Parsed(NamedTuple):
    """The facts of a file.

    Attributes
    ----------
    lines : int
        The lines of the file, without its tables: a table or registry may be long.
    functions : list of Function
    imported : set of str
        The packages that the file imports by their names.
    n_assignments, n_several : int
        Assignments, and those that are several on one line.
    """

    lines: int
    functions: list
    imported: set
    n_assignments: int
    n_several: int


@functools.cache
def parsed(path):
    text = path.read_text("utf-8")
    tree = ast.parse(text)
    tables = [node for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign)]
    lines = len(text.splitlines()) - sum(node.end_lineno - node.lineno for node in tables)
    functions, imported, n_assignments, n_several = [], set(), 0, 0
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            n_parameters = len(node.args.args) + len(node.args.kwonlyargs)
            functions.append(Function(node.name, body(node), n_parameters))
        elif isinstance(node, ast.Assign):
            n_assignments += 1
            n_several += is_several(node)
        elif isinstance(node, ast.Import):
            imported |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level:
            imported.add(node.module.partition(".")[0])
    return Parsed(lines, functions, imported, n_assignments, n_several)


def body(function):
    first = function.body[1:2] if ast.get_docstring(function) else function.body[:1]
    return function.end_lineno - first[0].lineno + 1 if first else 0


def is_several(node):
    """Whether a statement puts a tuple into a tuple, and is several statements on one line.

    A swap, ``a, b = b, a``, is one statement: a value reads what stands left of its own target.
    """
    for target in node.targets:
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            earlier = set()
            for one, value in zip(target.elts, node.value.elts, strict=False):
                if earlier & {ast.dump(part) for part in ast.walk(value)}:
                    return False
                earlier.add(ast.dump(one).replace("Store()", "Load()"))
            return True
    return False
