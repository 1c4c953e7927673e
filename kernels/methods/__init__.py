"""The methods, each a file or a folder.  A new method is a file, and a line in FILES.

The file of a method determines the `Facts` of the method.  `facts.json` keeps the facts, so that a
process whose kernels are compiled imports no file of a method.  The file of a method without kept
facts is imported.  `python -m bench.report.methods` writes `facts.json`.
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
    "Radau": "radau.step",
    "BDF": "bdf.step",
    "LSODA": "lsoda.step",
    "Rodas5P": "rodas5p.step",
    "Taylor": "taylor.method",
    "RK4": "rk4",
    **dict.fromkeys(
        ("VelocityVerlet", "McLachlanAtela4", "BlanesMoanPRK4", "BlanesMoan4", "BlanesMoan6",
         "KahanLi8", "SofroniouSpaletta10", "Yoshida4", "Yoshida6", "Yoshida8"), "symplectic"
    ),
    **dict.fromkeys(
        ("Gauss4", "Gauss8", "Gauss16", "GaussNystrom8", "GaussNystrom16", "EnergyConserving2",
         "EnergyConserving4"), "gauss.methods"
    ),
}  # fmt: skip
RESIDUAL = "BDF of residuals"  # for F(t, y, y') = 0: `solve_dae` takes it, `solve_ivp` does not
APART = {RESIDUAL: "residual.step"}
KEPT = pathlib.Path(__file__).parent / "facts.json"
_real: dict[str, Facts] = {}
_complex: dict[str, Facts] = {}
METHODS = MappingProxyType(_real)  # Facts by name
COMPLEX = MappingProxyType(_complex)  # Facts for complex states, by the name of the real method
BY_NAME = ChainMap(_real, {})  # Facts for real and for complex states, each by its own name


def facts_in(name, file):
    """The Facts of a method from its file, and the Facts for complex states, if there are any."""
    code = method_in(file, name)
    return [m.facts._replace(file=file) for m in (code, code.on_pairs) if m is not None]


def _read(fields):
    """The Facts from their fields in JSON."""
    return Facts(**fields | {"looks": tuple(fields.get("looks", ()))})


def register(name, file, kept=()):
    """Add a method to the tables of methods; `kept` are the fields of its Facts, if known."""
    for facts in [_read(fields) for fields in kept] or facts_in(name, file):
        if facts.name == name:
            _real[name] = facts
        else:
            _complex[name] = BY_NAME.maps[1][facts.name] = facts


_kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
for _name, _file in FILES.items():
    register(_name, _file, _kept.get(_name, ()))
for _name, _file in APART.items():
    for _facts in [_read(fields) for fields in _kept.get(_name, ())] or facts_in(_name, _file):
        BY_NAME.maps[1][_name] = _facts
