"""The methods, each a file with its tables.  A new method is a file, and a line in FILES.

A solve asks for the `Facts` of a method, which are derived from the file.  `facts.json` keeps the
facts, so that a process whose kernels are compiled imports no file of a method; a method without
kept facts is imported.  `python -m bench.report.methods` writes the facts anew.
"""

import json
import pathlib
from collections import ChainMap
from types import MappingProxyType

from .method import Facts, every_fact

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
    "VelocityVerlet": "symplectic",
    "McLachlanAtela4": "symplectic",
    "BlanesMoanPRK4": "symplectic",
    "BlanesMoan4": "symplectic",
    "BlanesMoan6": "symplectic",
    "KahanLi8": "symplectic",
    "SofroniouSpaletta10": "symplectic",
    "Yoshida4": "symplectic",
    "Yoshida6": "symplectic",
    "Yoshida8": "symplectic",
    "Gauss4": "gauss",
    "Gauss8": "gauss",
    "Gauss16": "gauss",
    "GaussNystrom8": "gauss",
    "GaussNystrom16": "gauss",
    "EnergyConserving2": "gauss",
    "EnergyConserving4": "gauss",
}
KEPT = pathlib.Path(__file__).parent / "facts.json"
_real: dict[str, Facts] = {}
_complex: dict[str, Facts] = {}
METHODS = MappingProxyType(_real)  # by name, read-only
COMPLEX = MappingProxyType(_complex)  # for complex states, by the names of those for real ones
BY_NAME = ChainMap(_real, {})  # both, each by its own name


def register(name, file, kept=()):
    """Let a method be found by its name; `kept` are the fields of its facts, if known."""
    found = [Facts(**fields) for fields in kept] or every_fact(file, name)
    for facts in found:
        if facts.name == name:
            _real[name] = facts
        else:
            _complex[name] = BY_NAME.maps[1][facts.name] = facts


def _register_all():
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    for name, file in FILES.items():
        register(name, file, kept.get(name, ()))


_register_all()
