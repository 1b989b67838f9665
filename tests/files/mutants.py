"""Damaged copies of files: each is drawn from a seed, by one to three changes such as disks, editors and forgers make."""

import io
import re
import zipfile
from random import Random

NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
STRANGE_NUMBERS = (
    *(b"nan", b"-inf", b"1e400", b"-1", b"0", b"1e-320", b"18446744073709551616", b"9" * 400, b"1_0", b"0x1F"),
    *(b"2147483648", b"-9223372036854775808", b"1,5", b"", b"true", b"NaN", b"1e308", b"3.5", "\u0661".encode()),
)


def flip_a_bit(data: bytes, rnd: Random) -> bytes:
    changed = bytearray(data)
    if changed:
        changed[rnd.randrange(len(changed))] ^= 1 << rnd.randrange(8)
    return bytes(changed)


def overwrite(data: bytes, rnd: Random) -> bytes:
    changed, at = bytearray(data), rnd.randrange(len(data) + 1)
    changed[at : at + rnd.randrange(1, 9)] = rnd.choice((rnd.randbytes(8), b"\0" * 8, b"\xff" * 8))
    return bytes(changed)


def truncate(data: bytes, rnd: Random) -> bytes:
    return data[: rnd.randrange(len(data) + 1)]


def cut_out(data: bytes, rnd: Random) -> bytes:
    at = rnd.randrange(len(data) + 1)
    return data[:at] + data[at + rnd.randrange(1, 64) :]


def repeat_a_part(data: bytes, rnd: Random) -> bytes:
    at = rnd.randrange(len(data) + 1)
    return data[:at] + data[at : at + rnd.randrange(1, 200)] * rnd.choice((2, 3, 50)) + data[at:]


def change_lines(data: bytes, rnd: Random) -> bytes:
    lines = data.split(b"\n")
    k, other = rnd.randrange(len(lines)), rnd.randrange(len(lines))
    kind = rnd.randrange(4)
    if kind == 0:
        lines[k:k] = [lines[k]]
    elif kind == 1:
        del lines[k]
    else:
        lines[k], lines[other] = lines[other], lines[k]
    return b"\n".join(lines)


def swap_fields(data: bytes, rnd: Random) -> bytes:
    parts = re.split(rb"([\s,;=]+)", data)
    places = range(0, len(parts), 2)
    a, b = rnd.choice(places), rnd.choice(places)
    parts[a], parts[b] = parts[b], parts[a]
    return b"".join(parts)


def strange_number(data: bytes, rnd: Random) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    place = rnd.choice(found)
    return data[: place.start()] + rnd.choice(STRANGE_NUMBERS) + data[place.end() :]


def encode_otherwise(data: bytes, rnd: Random) -> bytes:
    text = data.decode("latin-1")
    return rnd.choice(
        (
            b"\xef\xbb\xbf" + data,
            b"\xff\xfe" + data,
            text.encode("utf-16"),
            text.encode("utf-32"),
            data.replace(b"\n", b"\r"),
            data.replace(b"\n", b"\r\r\n"),
            data + b"\x1a",
        )
    )


def insert_strange_bytes(data: bytes, rnd: Random) -> bytes:
    at = rnd.randrange(len(data) + 1)
    strange = (
        b"\0",
        b"\n" * 50,
        b'"',
        b"'",
        b"\xff",
        b"\x1b[31m",
        b"[" * 60,
        b"{" * 60,
        b"# ",
        "\u202e".encode(),
        b"\\",
    )
    return data[:at] + rnd.choice(strange) + data[at:]


def empty(_data: bytes, rnd: Random) -> bytes:
    return rnd.choice((b"", b"\n", b"\0" * 100, b" " * 1000))


CHANGES = (
    *(flip_a_bit, overwrite, truncate, cut_out, repeat_a_part, change_lines, swap_fields, strange_number),
    *(encode_otherwise, insert_strange_bytes),
)


def mutant(data: bytes, rnd: Random) -> bytes:
    """Return a damaged copy."""
    if rnd.random() < 0.01:
        return empty(data, rnd)
    for _ in range(rnd.choice((1, 1, 2, 3))):
        data = rnd.choice(CHANGES)(data, rnd)
    return data


def mutant_inside(data: bytes, rnd: Random) -> bytes:
    """Return an archive that is whole, with one damaged entry."""
    with zipfile.ZipFile(io.BytesIO(data)) as file:
        entries = {name: file.read(name) for name in file.namelist()}
    name = rnd.choice(sorted(entries))
    entries[name] = mutant(entries[name], rnd)
    if rnd.random() < 0.1:
        entries["../" * rnd.randrange(3) + rnd.choice(sorted(entries))] = rnd.choice(list(entries.values()))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        for entry, content in entries.items():
            file.writestr(entry, content)
    return packed.getvalue()
