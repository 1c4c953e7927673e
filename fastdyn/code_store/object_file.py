"""The file format of an entry, and its verification.

MAGIC, the sha256 of the rest, the length of the header, the header as JSON, the object code.
This file needs no Numba.
"""

import hashlib
import json
import struct

MAGIC = b"fastdyn object 1\n"
DIGEST = 32
RELOCATABLE, SYMBOL_TABLE = 1, 2  # of ELF
BROKEN = (
    ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError,
    struct.error,
)  # fmt: skip
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

    ``check(code, symbol, needs)`` is `checked`, of object code, unless the code is of another kind.
    """
    n = len(MAGIC)
    digest, rest = data[n : n + DIGEST], data[n + DIGEST :]
    if data[:n] != MAGIC or hashlib.sha256(rest).digest() != digest:
        raise NotWhole("it is damaged")
    try:
        (size,) = struct.unpack_from("<q", rest)
        header, code = json.loads(rest[8 : 8 + size]), rest[8 + size :]
        _check_header(header, symbol)
        (check or checked)(code, symbol, header["needs"])
    except BROKEN as error:  # the hash tells that the file is unchanged, not that it was right
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


def is_elf(code):
    """True for code that `symbols` can read: a 64-bit ELF object, little-endian."""
    return code[:6] == b"\x7fELF\x02\x01"


def checked(code, symbol, needs):
    """Raise NotWhole unless the code defines `symbol` alone and needs exactly `needs`."""
    defined, undefined = symbols(code)
    if defined != [symbol]:
        raise NotWhole(f"it defines {defined}, not {symbol} alone")
    if set(undefined) != set(needs):
        raise NotWhole(f"it needs {sorted(undefined)}, not {sorted(needs)}")


def symbols(code):
    """(defined, undefined): the names of an object file that a linker sees."""
    if not is_elf(code):
        raise NotWhole("it is no ELF object")
    (kind,) = struct.unpack_from("<H", code, 0x10)
    if kind != RELOCATABLE:
        raise NotWhole("it is no relocatable object")
    (start,) = struct.unpack_from("<Q", code, 0x28)
    size, count, names_of_sections = struct.unpack_from("<HHH", code, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", code, start + i * size) for i in range(count)]
    defined, undefined = [], []
    for name, kind, _, _, offset, length, link, *_ in sections:
        if _text(code, sections[names_of_sections][4] + name).startswith(CONSTRUCTORS):
            raise NotWhole("it has code that runs when it is loaded")
        if kind != SYMBOL_TABLE:
            continue
        names = sections[link][4]
        for at in range(offset, offset + length, 24):
            name, info, _, section = struct.unpack_from("<IBBH", code, at)
            if info >> 4 == 0:  # local to the file
                continue
            (undefined if section == 0 else defined).append(_text(code, names + name))
    return defined, undefined


def _text(code, at):
    return code[at : code.index(b"\0", at)].decode()
