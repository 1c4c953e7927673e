"""Code for Windows, macOS and aarch64, made here: what the loader there would meet.

The code cannot be run here.  Each module that a few solves compile is translated for each platform,
parsed, and compared with what a loader of LLVM and the libraries of the platform have.
"""

import base64
import json
import os
import struct
import subprocess
import sys

import llvmlite.binding as llvm
import pytest

from fastdyn.code_store import loader, object_file, target

PLATFORMS = {  # triple, processor
    "x86_64-pc-windows-msvc-elf": "x86-64-v3",
    "arm64-apple-macosx": "apple-m1",
    "x86_64-apple-macosx": "x86-64-v3",
    "aarch64-unknown-linux-gnu": "generic",
}
OF_GNU = {"exp10", "sincos"}  # the other C libraries name them otherwise
X86, ARM = 0x01000007, 0x0100000C  # processors of Mach-O
RELOCATIONS = {  # that LLVM's linkers know, by machine: in ELF 62 is x86-64, 183 aarch64
    62: {1, 2, 4, 9, 10, 11, 24, 41, 42},  # 64, PC32, PLT32, GOTPCREL (also relaxed), 32, 32S, PC64
    183: {257, 258, 260, 261, 274, 275, 277, 278, 282, 283, 284, 285, 286, 299, 311, 312},
    X86: {0, 1, 2, 3, 4, 5, 6, 7, 8},  # all but the last, of variables of threads
    ARM: {0, 1, 2, 3, 4, 5, 6, 7, 10},  # all but 8 and 9, of variables of threads
}
SCRIPT = """
import base64, json, sys
import llvmlite.binding as llvm
import numpy as np
llvm.initialize_all_targets()
llvm.initialize_all_asmprinters()
from fastdyn.code_store import target, unlinked
import fastdyn

made, platforms, emitted = [], json.loads(sys.argv[1]), target.emitted

def for_all(module, symbol, machine=None):
    bitcode = module.as_bitcode()
    for triple, cpu in platforms.items():
        copy = llvm.parse_bitcode(bitcode, llvm.create_context())
        there = llvm.Target.from_triple(triple).create_target_machine(
            cpu=cpu, opt=2, reloc="pic", codemodel="small"
        )
        target.for_machine(copy, there)
        code = base64.b64encode(there.emit_object(copy)).decode()
        made.append((triple, symbol, code))
    return emitted(module, symbol, machine)

target.emitted = for_all

def everything(t, y, k):
    a, b = y
    table = np.interp(t, np.linspace(0, 1, 99), np.linspace(0, 1, 99) ** 2)
    f = [np.sin(a), np.cos(a), np.tan(a), np.arcsin(a / 9), np.arccos(a / 9), np.arctan(a)]
    f += [np.sinh(a), np.cosh(a), np.tanh(a), np.arcsinh(a), np.exp(-a * a), np.exp2(-a), 10 ** b]
    f += [np.expm1(a), np.log1p(a * a), np.log10(2 + a * a), np.cbrt(a), np.arctan2(a, b)]
    f += [np.hypot(a, b), np.fmod(a, 3), np.floor(a), np.round(b), max(a, b), np.sqrt(2 + a), table]
    return [b, -k * a + 1e-3 * sum(f)]

def long(t, y):
    return -y + np.exp(-y * y) * np.sin(y)

def rough(t, y, k):  # for Numba
    s = 0.0
    while s * s < abs(y[0]) * k:
        s += 0.01
    return [y[1], -s]

given = {"t_span": (0, 1), "y0": [1.0, 0.3], "args": (2.0,)}
fastdyn.solve_ivp(everything, **given)
fastdyn.solve_ivp(lambda t, y, k: [np.sin(y[1]), -k * y[0]], method="Taylor", **given)
fastdyn.solve_ivp(long, (0, 1), np.linspace(0, 1, 600))
fastdyn.solve_ivp(rough, **given)
print(json.dumps(made))
"""


@pytest.fixture(scope="module")
def objects(tmp_path_factory):
    """(triple, symbol, object code) of all that is compiled from an empty folder."""
    empty = {"NUMBA_CACHE_DIR": str(tmp_path_factory.mktemp("empty")), "FASTDYN_SHARED_CODE": ""}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps(PLATFORMS)],
        env=os.environ | empty, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = [(t, symbol, base64.b64decode(code)) for t, symbol, code in json.loads(done.stdout)]
    assert len(found) > 3 * 5
    return found


def relocations(code):
    """(machine, the kinds of relocation) of an object."""
    return (of_elf if code.startswith(object_file.ELF) else of_mach_o)(code)


def of_mach_o(code):
    (machine,) = struct.unpack_from("<I", code, 4)
    (count,) = struct.unpack_from("<I", code, 0x10)
    at, kinds = 0x20, set()
    for _ in range(count):
        command, size = struct.unpack_from("<II", code, at)
        if command == object_file.MACH_O_SEGMENT:
            (sections,) = struct.unpack_from("<I", code, at + 0x40)
            for i in range(sections):
                start, length = struct.unpack_from("<II", code, at + 0x48 + 80 * i + 0x38)
                places = range(start, start + 8 * length, 8)
                kinds |= {struct.unpack_from("<I", code, place + 4)[0] >> 28 for place in places}
        at += size
    return machine, kinds


def of_elf(code):
    (machine,) = struct.unpack_from("<H", code, 0x12)
    (start,) = struct.unpack_from("<Q", code, 0x28)
    size, count = struct.unpack_from("<HH", code, 0x3A)
    kinds = set()
    for i in range(count):
        _, kind, _, _, offset, length = struct.unpack_from("<IIQQQQ", code, start + i * size)
        if kind == 4:  # with addends
            kinds |= {
                struct.unpack_from("<QQ", code, at)[1] & 0xFFFFFFFF
                for at in range(offset, offset + length, 24)
                if not debugging(code, start + i * size)
            }
    return machine, kinds


def debugging(code, header):
    """True for relocations of a section that is not loaded."""
    (start,) = struct.unpack_from("<Q", code, 0x28)
    (of,) = struct.unpack_from("<I", code, header + 0x2C)
    (flags,) = struct.unpack_from("<Q", code, start + 64 * of + 8)
    return not flags & 2


@pytest.mark.hunt
@pytest.mark.parametrize("triple", PLATFORMS)
def test_objects_are_as_the_store_and_the_loader_want_them(objects, triple):
    seen = set()
    for made_for, symbol, code in objects:
        if made_for != triple:
            continue
        defined, undefined = object_file.symbols(code)  # refuses constructors
        assert defined == [symbol]
        foreign = [name for name in undefined if name == "__chkstk" and "windows" not in triple]
        absent = [name for name in undefined if name in OF_GNU and "linux" not in triple]
        assert foreign + absent == []
        for name in undefined:
            loader.provider(name)  # raises for what nobody has
        machine, kinds = relocations(code)
        assert kinds <= RELOCATIONS[machine], (symbol, sorted(kinds - RELOCATIONS[machine]))
        seen |= set(undefined)
    assert {"sin", "exp", "cbrt"} <= seen


@pytest.mark.hunt
def test_a_large_frame_touches_its_pages_on_windows(objects):
    asked = {t for t, _, code in objects if "__chkstk" in object_file.symbols(code)[1]}
    assert asked <= {"x86_64-pc-windows-msvc-elf"}


def test_code_that_runs_when_it_is_loaded_is_refused_on_macos():
    assembly = """
    @list = appending global [1 x { i32, ptr, ptr }] [{ i32, ptr, ptr } { i32 1, ptr @f, ptr null }]
    define internal void @f() { ret void }
    define void @g() { ret void }
    """.replace("@list", "@llvm.global_ctors")
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    module = llvm.parse_assembly(assembly, llvm.create_context())
    there = llvm.Target.from_triple("arm64-apple-macosx").create_target_machine(cpu="apple-m1")
    target.for_machine(module, there)
    with pytest.raises(object_file.NotWhole, match="runs when it is loaded"):
        object_file.symbols(there.emit_object(module))


@pytest.mark.parametrize("header", [b"", b"MZ", b"\xcf\xfa\xed\xfe" + 40 * b"\xff"])
def test_what_is_no_object_is_refused(header):
    with pytest.raises((object_file.NotWhole, *object_file.BROKEN)):
        object_file.symbols(header)


def test_object_code_is_elf_on_windows():
    assert target.in_elf("x86_64-pc-windows-msvc") == "x86_64-pc-windows-msvc-elf"
    assert target.in_elf("x86_64-pc-windows-msvc-elf") == "x86_64-pc-windows-msvc-elf"
    assert target.in_elf("x86_64-unknown-linux-gnu") == "x86_64-unknown-linux-gnu"
