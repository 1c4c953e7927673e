"""On what machine, with which versions, under what load."""

import os
import platform
import shutil
import subprocess
from importlib import metadata

LIBRARIES = (
    "numba", "numpy", "scipy", "CyRK", "numbalsoda", "heyoka", "diffrax", "jax", "scikit-sundae",
    "casadi", "rebound", "sdeint", "jitcsde",
)  # fmt: skip


def machine():
    """Versions, processor, threads, load."""
    import fastdyn

    cpu = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo") as file:
            cpu = next(s.split(":")[1].strip() for s in file if s.startswith("model name"))
    except (OSError, StopIteration):
        pass
    versions = {"python": platform.python_version(), "fastdyn": fastdyn.__version__}
    for name in LIBRARIES:
        try:
            versions[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            versions[name] = None
    for compiler in ("clang++", "g++"):
        if shutil.which(compiler):
            said = subprocess.run([compiler, "--version"], capture_output=True, text=True)
            versions[compiler] = said.stdout.splitlines()[0]
    return {
        "cpu": cpu,
        "cores": os.cpu_count(),
        "threads": 1,
        "load": load(),
        "versions": versions,
    }


def load():
    """Mean number of running processes of the last minute, if the system tells."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None
