"""Finds a value that a function keeps from call to call and computes with: ``total += error * dt``.

A method calls `fun` at trial states, some of them twice, and steps back: the result of such a
function depends on the order of the calls.  Counters and logs do not matter, as no result depends
on them, nor do values kept because they are expensive, which depend on t and y alone.

The source of the function is read, not run, and so is that of the user's functions and objects
that the function calls and computes with.  What is not seen gets no warning.
"""

import ast
import functools
import inspect
import textwrap
import types
from typing import NamedTuple

from fastdyn.words.user_lines import of_user

from .callables import EMPTY, plain_function
from .sentences import CompileWarning, name_of, warn

ADDERS = {"append", "appendleft", "extend", "insert", "add", "update", "pop", "popleft"}
SETTERS = {"clear", "fill"}


def warn_if_remembered(fun):
    """Warn, in each solve, of a function that computes with what it has kept."""
    found = _keeper(fun)
    if found is None:
        return
    keeper, kept = found
    warn(
        f"{name_of(keeper)} keeps `{kept}` from call to call and computes with it. A method calls "
        "it at trial states, and again at earlier times, so that the result depends on the order "
        f"of the calls, and on the method. Make `{kept}` a component of the state, or a state that "
        "changes at known times only: `discrete=` with `every=`.",
        CompileWarning,
    )


def remembered(fun):
    """The name of a value that a function keeps and computes with; None if none is seen."""
    found = _keeper(fun)
    return found and found[1]


def _keeper(fun, seen=()):
    """The function that keeps a value, and the name of the value; None if none is seen.

    That is `fun`, or a function of the user's that it calls, and on whose value its own depends.
    """
    plain = plain_function(fun)
    if not isinstance(plain, types.FunctionType) or plain.__code__ in seen:
        return None
    bound = inspect.ismethod(fun) or not isinstance(fun, types.FunctionType | functools.partial)
    kept, named = _remembered(plain.__code__, bound, bool(seen))
    if kept is not None:
        return fun, kept
    for name in named:
        called = _named(fun, plain, name, bound)
        function = plain_function(called)
        if type(function) is types.FunctionType and of_user(function.__code__.co_filename):
            found = _keeper(called, (*seen, plain.__code__))
            if found is not None:
                return found
    return None


def _named(fun, plain, name, bound):
    """The value of a name such as ``control``, ``self.control`` in a function; None if unknown.

    No code of the user runs: a property has no value here.
    """
    root, *parts = name.split(".")
    if bound and plain.__code__.co_varnames[:1] == (root,):
        found = getattr(fun, "__self__", fun)
    else:
        found = _variable(plain, root)
    for part in parts:
        owner = found
        found = inspect.getattr_static(owner, part, None)
        if isinstance(found, types.FunctionType) and not isinstance(owner, types.ModuleType | type):
            found = types.MethodType(found, owner)
    return found


def _variable(function, name):
    """The value of a variable outside of a function; None if there is none."""
    cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
    if name not in cells:
        return function.__globals__.get(name)
    return None if cells[name] == EMPTY else cells[name].cell_contents


@functools.lru_cache(256)
def _remembered(code, bound, called):
    """The value that a function keeps and computes with, and the names on which its result depends.

    All arguments of a function that is `called` are its own; those of `fun` behind t and y are not.
    """
    nothing = None, ()
    try:
        (node,) = ast.parse(textwrap.dedent(inspect.getsource(code))).body
    except (OSError, TypeError, SyntaxError, ValueError):
        return nothing
    if not isinstance(node, ast.FunctionDef):
        own = [n for n in ast.walk(node) if isinstance(n, ast.Lambda) and _is_of(n, code)]
        if len(own) != 1:
            return nothing
        node = own[0]
    flow = _Flow(node, bound, called)
    for _ in range(2):  # once more, for what a loop or a later line gives to an earlier one
        flow.begin()
        if isinstance(node, ast.Lambda):
            flow.result.update(*flow.needs(node.body))
        else:
            flow.body(node.body)
    return flow.found(), tuple(sorted(flow.matter() | flow.tests))


def _is_of(node, code):
    """Whether a lambda may be that of a code."""
    arguments = [a.arg for a in (*node.args.posonlyargs, *node.args.args)]
    return tuple(arguments) == code.co_varnames[: code.co_argcount]


class _Store(NamedTuple):
    """An assignment to a kept value."""

    by: frozenset  # the kept values in its formula
    always: bool  # whether each call carries it out
    read_before: bool  # whether a formula has used the value before
    latches: bool  # whether it sets a constant under a condition, and nothing otherwise


class _Flow:
    """Which kept values the results of a function depend on, and how the function changes them.

    A value that a call has set is none that is kept, up to the end of the call.
    """

    def __init__(self, node, bound, called=False):
        names = [a.arg for a in (*node.args.posonlyargs, *node.args.args)]
        found = [n for n in ast.walk(node) if isinstance(n, ast.Name)]
        declared = [n for n in ast.walk(node) if isinstance(n, ast.Global | ast.Nonlocal)]
        own = {n.id for n in found if isinstance(n.ctx, ast.Store)}
        own -= {name for each in declared for name in each.names}
        first = 1 if bound or names[:1] == ["self"] else 0
        given = names[first:] if called else names[first : first + 2]
        self.local = own | set(given)
        self.own = set(names[:first])
        self.copied: dict = {}  # what names depend on: as copies, and by a formula
        self.computed: dict = {}
        self.begin()

    def begin(self):
        """Begin a pass; what names depend on is known from the last one."""
        self.stores: dict = {}
        self.read: set = set()
        self.written: set = set()
        self.result: set = set()  # what returned values depend on
        self.tests: set = set()  # what decides between them

    def place(self, node):
        """The value and the object that an expression names, ``m['sum']`` and ``m``, or None."""
        base = node
        exact = True
        while isinstance(base, ast.Subscript):
            exact = exact and isinstance(base.slice, ast.Constant)
            base = base.value
        root = base
        while isinstance(root, ast.Attribute | ast.Subscript):
            root = root.value
        if not isinstance(root, ast.Name) or root.id in self.local:
            return None
        return ast.unparse(node if exact else base), ast.unparse(base)

    def needs(self, node):
        """The kept values that an expression copies, and those in a formula of it."""
        if isinstance(node, ast.Name | ast.Attribute | ast.Subscript):
            place = self.place(node)
            if place is not None:
                set_here = self.written.intersection(place)
                kept = set() if set_here else set(place)
                for name in set_here:
                    kept |= self.copied.get(name, set())
                formulas = (self.computed.get(name, set()) for name in set_here)
                return kept, self._inside(node).union(*formulas)
            if isinstance(node, ast.Name):
                return self.copied.get(node.id, set()), self.computed.get(node.id, set())
        if isinstance(node, ast.IfExp):
            self.tests.update(*self.needs(node.test))
            a, b = self.needs(node.body)
            c, d = self.needs(node.orelse)
            return a | c, b | d
        return set(), self._inside(node)

    def _inside(self, node):
        """The kept values in the parts of an expression."""
        found = set()
        for part in ast.iter_child_nodes(node):
            found.update(*self.needs(part))
        return found

    def body(self, statements, when="always"):
        """Follow statements; those behind a branch that returns are carried out sometimes."""
        for one in statements:
            self.statement(one, when)
            if isinstance(one, ast.If) and _returns(one):
                when = "sometimes"

    def statement(self, one, when):
        """Follow a statement that is carried out always, sometimes, or in an if without else."""
        if isinstance(one, ast.Assign | ast.AnnAssign | ast.AugAssign) and one.value is not None:
            self.assignment(one, when)
        elif isinstance(one, ast.Return) and one.value is not None:
            self.result.update(*self.needs(one.value))
        elif isinstance(one, ast.Expr) and isinstance(one.value, ast.Call):
            self.call(one.value.func, when)
        elif isinstance(one, ast.If | ast.While) and _returns(one):
            self.tests.update(*self.needs(one.test))
        if isinstance(one, ast.FunctionDef | ast.ClassDef):
            return
        inner = when if isinstance(one, ast.With) else "sometimes"
        if isinstance(one, ast.If):
            inner = "if" if not _has_else(one) or when == "if" else "sometimes"
        for part in ("body", "orelse", "finalbody", "handlers"):
            if isinstance(getattr(one, part, None), list):
                self.body(getattr(one, part), inner)

    def assignment(self, one, when):
        """Follow an assignment to names, attributes and items."""
        copied, computed = self.needs(one.value)
        for target in one.targets if isinstance(one, ast.Assign) else [one.target]:
            pairs = [(target, copied, computed)]
            if isinstance(target, ast.Tuple | ast.List):
                pairs = [(each, copied, computed) for each in target.elts]
                if isinstance(one.value, ast.Tuple | ast.List) and len(pairs) == len(
                    one.value.elts
                ):
                    values = [self.needs(each) for each in one.value.elts]
                    pairs = [(p[0], *v) for p, v in zip(pairs, values, strict=True)]
            for part, a, b in pairs:
                if isinstance(one, ast.AugAssign):
                    b = b | a | set().union(*self.needs(part))
                self.given(part, a, b, when, when == "if" and self._is_constant(one.value))
        self.read |= computed

    def _is_constant(self, node):
        """Whether an expression is a constant, or a member of an enumeration: ``Mode.HEAT``."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            return node.value.id not in self.local | self.own
        return isinstance(node, ast.Constant)

    def given(self, target, copied, computed, when, latches):
        """Note the values on which a target of an assignment depends."""
        place = self.place(target)
        name = target
        while isinstance(name, ast.Subscript | ast.Attribute | ast.Starred):
            name = name.value
        if place is None:
            if isinstance(name, ast.Name):
                self._add(name.id, copied, computed)
            return
        key, base = place
        if key == base and isinstance(target, ast.Subscript):  # many items, or any
            self.written.add(base)
            self._add(base, copied, computed)
            return
        store = _Store(frozenset(computed), when == "always", key in self.read, latches)
        self.stores.setdefault(key, []).append(store)
        if when == "always":
            self.written.add(key)
            self._add(key, copied, computed)

    def _add(self, name, copied, computed):
        self.copied.setdefault(name, set()).update(copied)
        self.computed.setdefault(name, set()).update(computed)

    def call(self, function, when):
        """Follow ``kept.append(value)``, ``kept.clear()``."""
        place = self.place(function.value) if isinstance(function, ast.Attribute) else None
        if place is None:
            return
        if function.attr in SETTERS:
            self.written.add(place[1])
        elif function.attr in ADDERS and place[1] not in self.written:
            store = _Store(frozenset({place[1]}), when == "always", False, False)
            self.stores.setdefault(place[1], []).append(store)

    def matter(self):
        """The kept values on which the result depends."""
        matter = set(self.result)
        while (
            more := {
                key for one in matter for store in self.stores.get(one, ()) for key in store.by
            }
            - matter
        ):
            matter |= more
        return matter

    def found(self):
        """The first kept value on which the result depends, and which depends on earlier calls."""
        matter = self.matter()
        for key, stores in self.stores.items():
            depends = any(key in s.by or (s.always and s.read_before) for s in stores)
            latches = any(s.latches for s in stores) and not any(s.always for s in stores)
            if (key in matter and depends) or (key in matter | self.tests and latches):
                return key
        return None


def _has_else(node):
    """Whether an if, with its elifs, ends with an else."""
    while len(node.orelse) == 1 and isinstance(node.orelse[0], ast.If):
        node = node.orelse[0]
    return bool(node.orelse)


def _returns(node):
    return any(isinstance(one, ast.Return) for one in ast.walk(node))
