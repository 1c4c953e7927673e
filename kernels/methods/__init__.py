"""The methods, each a file with its tables.  A new method is a file, and a line in FILES.

A solve asks for the `Facts` of a method, which are derived from the file.  `facts.json` keeps the
facts, so that a process whose kernels are compiled imports no file of a method; a method without
kept facts is imported.  `python -m bench.report.methods` writes the facts anew.
"""

import json
import pathlib
from collections import ChainMap
from types import MappingProxyType

from .method import Facts, method_in

FILES = {
    "RK23": "rk23",
    "RK45": "rk45",
    "DOP853": "dop853",
    "Tsit5": "tsit5",
    "Vern7": "vern7",
    "Vern9": "vern9",
    "ode45": "ode45",
    "ode23": "ode23",
    "Radau": "radau",
    "BDF": "bdf",
    "LSODA": "lsoda",
    "Rodas5P": "rodas5p",
    "Taylor": "taylor",
    "RK4": "rk4",
    **dict.fromkeys(
        ("VelocityVerlet", "McLachlanAtela4", "BlanesMoanPRK4", "BlanesMoan4", "BlanesMoan6",
         "KahanLi8", "SofroniouSpaletta10", "Yoshida4", "Yoshida6", "Yoshida8"), "symplectic"
    ),
    **dict.fromkeys(
        ("Gauss4", "Gauss8", "Gauss16", "GaussNystrom8", "GaussNystrom16", "EnergyConserving2",
         "EnergyConserving4"), "gauss"
    ),
}  # fmt: skip
RESIDUAL = "BDF of residuals"  # for F(t, y, y') = 0: `solve_dae` takes it, `solve_ivp` does not
APART = {RESIDUAL: "residual"}
KEPT = pathlib.Path(__file__).parent / "facts.json"
_real: dict[str, Facts] = {}
_complex: dict[str, Facts] = {}
METHODS = MappingProxyType(_real)  # by name, read-only
COMPLEX = MappingProxyType(_complex)  # for complex states, by the names of those for real ones
BY_NAME = ChainMap(_real, {})  # both, each by its own name


def facts_in(name, file):
    """The facts of a method from its file, and of its form for complex states, if there is one."""
    code = method_in(file, name)
    return [m.facts._replace(file=file) for m in (code, code.on_pairs) if m is not None]


def register(name, file, kept=()):
    """Let a method be found by its name; `kept` are the fields of its facts, if known."""
    for facts in [Facts(**fields) for fields in kept] or facts_in(name, file):
        if facts.name == name:
            _real[name] = facts
        else:
            _complex[name] = BY_NAME.maps[1][facts.name] = facts


_kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
for _name, _file in FILES.items():
    register(_name, _file, _kept.get(_name, ()))
for _name, _file in APART.items():
    for _facts in [Facts(**f) for f in _kept.get(_name, ())] or facts_in(_name, _file):
        BY_NAME.maps[1][_name] = _facts
