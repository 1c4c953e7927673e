"""The levels of processors for which a wheel has kernels."""

import llvmlite.binding as llvm
import pytest

from fastdyn.code_store import precompiled


def test_levels_hold_each_other():
    v4, v3, v2 = map(set, precompiled.LEVELS["x86_64-unknown-linux-gnu"].values())
    assert v4 > v3 > v2


@pytest.mark.parametrize("triple, features, level", [
    ("aarch64-unknown-linux-gnu", None, "generic"),  # no feature is asked for
    ("x86_64-unknown-linux-gnu", precompiled._V3, "x86-64-v3"),
    ("x86_64-pc-linux-gnu", precompiled._V2, "x86-64-v2"),
    ("x86_64-pc-linux-gnu", precompiled._V2[1:], None),
    ("x86_64-pc-linux-gnu", (*precompiled._V2, "fma"), None),  # kernels of the process have fma
    ("arm64-apple-macosx", (), None),
])  # fmt: skip
def test_each_system_has_its_levels(triple, features, level, monkeypatch):
    def host():
        return dict.fromkeys(features, True)

    monkeypatch.setattr(llvm, "get_process_triple", lambda: triple)
    monkeypatch.setattr(llvm, "get_host_cpu_features", host)
    assert precompiled.best_level() == level
