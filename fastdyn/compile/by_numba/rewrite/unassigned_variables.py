"""Checks of variables that may be read before an assignment, which Numba would read as zero."""

from numba.core import ir
from numba.core.analysis import compute_cfg_from_blocks, compute_use_defs

from fastdyn.kernels.jit_options import OWNING, njit


@njit(**OWNING)
def _check(assigned):
    if not assigned:
        raise UnboundLocalError("a variable is read before it is assigned")


def check_assigned(blocks):
    """Insert checks: the read of an unassigned variable raises, as in Python.

    A variable that some path leaves unassigned gets a flag: false at the start, true behind each
    assignment.
    """
    first = min(blocks)
    doubtful = _live_at(first, blocks)
    if not doubtful:
        return
    for block in blocks.values():
        block.body = [each for statement in block.body for each in _checked(statement, doubtful)]
    head = blocks[first]
    head.body[:0] = [_flag(name, False, head.scope, head.loc) for name in sorted(doubtful)]


def _live_at(first, blocks):
    """The variables that a path from the first block reads before it assigns them."""
    graph, (used, assigned) = compute_cfg_from_blocks(blocks), compute_use_defs(blocks)
    live, before = {label: set(used[label]) for label in blocks}, None
    while before != live:
        before = {label: set(names) for label, names in live.items()}
        for label, names in live.items():
            for follower, _ in graph.successors(label):
                names |= live[follower] - assigned[label]
    return live[first]


def _checked(statement, doubtful):
    """A statement with the checks before it, and the flag of its variable behind it."""
    if isinstance(statement, ir.Del):
        return [statement]
    read, written, loc = statement.list_vars(), None, statement.loc
    if isinstance(statement, ir.Assign):
        value, written = statement.value, statement.target
        read = [value] if isinstance(value, ir.Var) else []
        read = value.list_vars() if isinstance(value, ir.Inst) else read
    found = []
    for variable in {v.name: v for v in read if v.name in doubtful}.values():
        place, result = (variable.scope.redefine("$fastdyn_check", loc) for _ in range(2))
        flag = variable.scope.get_or_define(_named(variable.name), loc)
        found.append(ir.Assign(ir.Global("check", _check, loc), place, loc))
        found.append(ir.Assign(ir.Expr.call(place, (flag,), (), loc), result, loc))
    found.append(statement)
    if written is not None and written.name in doubtful:
        found.append(_flag(written.name, True, written.scope, loc))
    return found


def _flag(name, value, scope, loc):
    return ir.Assign(ir.Const(value, loc), scope.get_or_define(_named(name), loc), loc)


def _named(name):
    return f"$fastdyn_assigned.{name}"
