"""The file format of an entry, and its verification.

MAGIC, the sha256 of the rest, the length of the header, the header as JSON, the object code.
This file needs no Numba.
"""

import hashlib
import json
import struct

MAGIC = b"fastdyn object 1\n"
DIGEST = 32
ELF = b"\x7fELF\x02\x01"
MACH_O = b"\xcf\xfa\xed\xfe"
RELOCATABLE, SYMBOL_TABLE = 1, 2  # of ELF
MACH_O_OBJECT = 1
MACH_O_SYMBOLS = 0x02
MACH_O_SEGMENT = 0x19
MACH_O_CONSTRUCTORS = {0x09, 0x0A, 0x15, 0x16}  # types of sections
BROKEN = (
    ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError,
    struct.error,
)  # fmt: skip
RUNS_WHEN_LOADED = "it has code that runs when it is loaded"
OFFERED: dict = {}  # kernels that other code calls, by symbol: functions that return their Code
CONSTRUCTORS = (".init_array", ".fini_array", ".preinit_array", ".ctors", ".dtors")


class Unsealable(Exception):
    """Code that only this process can run, or that comes from Numba's own cache."""


class NotWhole(Exception):
    """A file that is damaged, or has another content than expected."""


def packed(header, code):
    """The bytes of the file of an entry."""
    head = json.dumps(header, sort_keys=True).encode()
    rest = struct.pack("<q", len(head)) + head + code
    return MAGIC + hashlib.sha256(rest).digest() + rest


def unpacked(data, symbol, check=None):
    """(header, code) of a file that must define `symbol`; raises NotWhole.

    ``check(code, symbol, needs)`` refuses wrong code; the default, `checked`, is for object code.
    """
    n = len(MAGIC)
    digest = data[n : n + DIGEST]
    rest = data[n + DIGEST :]
    if data[:n] != MAGIC or hashlib.sha256(rest).digest() != digest:
        raise NotWhole("it is damaged")
    try:
        (size,) = struct.unpack_from("<q", rest)
        header = json.loads(rest[8 : 8 + size])
        code = rest[8 + size :]
        _check_header(header, symbol)
        (check or checked)(code, symbol, header["needs"])
    except BROKEN as error:  # the hash tells that the file is unchanged, not that the file is right
        raise NotWhole(f"it is not made as it should be: {error}") from error
    return header, code


def _check_header(header, symbol):
    """Raise NotWhole, or one of BROKEN, if a field of the header is missing or wrong."""
    if header["symbol"] != symbol:
        raise NotWhole(f"it says that it is {header['symbol']}")
    texts = [*header["needs"]]
    for name, kind in header["arguments"]:
        texts += name, kind
        int(kind.partition(":")[2] or 0)
    if not all(isinstance(text, str) for text in texts):
        raise NotWhole("its header has no names")


def checked(code, symbol, needs):
    """Raise NotWhole unless the code defines `symbol` alone and needs exactly `needs`."""
    defined, undefined = symbols(code)
    if defined != [symbol]:
        raise NotWhole(f"it defines {defined}, not {symbol} alone")
    if set(undefined) != set(needs):
        raise NotWhole(f"it needs {sorted(undefined)}, not {sorted(needs)}")


def symbols(code):
    """(defined, undefined): the names of an object file that a linker sees."""
    if code.startswith(ELF):
        return _of_elf(code)
    if code.startswith(MACH_O):
        return _of_mach_o(code)
    raise NotWhole("it is no object file of ELF or Mach-O")


def _of_elf(code):
    (kind,) = struct.unpack_from("<H", code, 0x10)
    if kind != RELOCATABLE:
        raise NotWhole("it is no relocatable object")
    (start,) = struct.unpack_from("<Q", code, 0x28)
    size, count, names_of_sections = struct.unpack_from("<HHH", code, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + i * size) for i in range(count)]
    defined = []
    undefined = []
    for name, kind, _, _, offset, length, link, *_ in sections:
        if _text(code, sections[names_of_sections][4] + name).startswith(CONSTRUCTORS):
            raise NotWhole(RUNS_WHEN_LOADED)
        if kind != SYMBOL_TABLE:
            continue
        names = sections[link][4]
        for at in range(offset, offset + length, 24):
            name, info, _, section = struct.unpack_from("<IBBH", code, at)
            if info >> 4 == 0:  # local to the file
                continue
            (undefined if section == 0 else defined).append(_text(code, names + name))
    return defined, undefined


def _of_mach_o(code):
    """The result of `symbols` for a Mach-O file, without the underscore before each name.

    LLVM's linker adds this underscore again.
    """
    kind, count = struct.unpack_from("<II", code, 0x0C)
    if kind != MACH_O_OBJECT:
        raise NotWhole("it is no relocatable object")
    defined = []
    undefined = []
    at = 0x20
    for _ in range(count):
        command, size = struct.unpack_from("<II", code, at)
        if command == MACH_O_SEGMENT:
            (sections,) = struct.unpack_from("<I", code, at + 0x40)
            for section in range(at + 0x48, at + 0x48 + 80 * sections, 80):
                (flags,) = struct.unpack_from("<I", code, section + 0x40)
                if flags & 0xFF in MACH_O_CONSTRUCTORS:
                    raise NotWhole(RUNS_WHEN_LOADED)
        if command == MACH_O_SYMBOLS:
            table, length, names = struct.unpack_from("<III", code, at + 8)
            for symbol in range(table, table + 16 * length, 16):
                name, kind = struct.unpack_from("<IB", code, symbol)
                if kind & 0xE0 or not kind & 1:  # for a debugger, or local to the file
                    continue
                text = _text(code, names + name).removeprefix("_")
                (defined if kind & 0x0E else undefined).append(text)
        at += size
    return defined, undefined


def _text(code, at):
    return code[at : code.index(b"\0", at)].decode()
