"""Files that others may have made, of any size that the limits allow: of each kind what grows with the file.

What is beyond a limit, and what is nested, is a matter of the tests of the limits, one step beyond each.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from struct import pack
from typing import Any

import l5x_files
import slc_files
from captured import Frame, ethernet, pcap, pcapng, segment
from mcap.opcode import Opcode

Text = Callable[[int], bytes]


def repeated(part: str, before: str = "", after: str = "") -> Text:
    """Return what makes a text of about n characters of one part; `{}` in it is a number."""
    counted = "{}" in part

    def made(size: int) -> bytes:
        times = max(1, size // (len(part) + 4 * counted))
        inside = "".join(part.replace("{}", str(each)) for each in range(times)) if counted else part * times
        return f"{before}{inside}{after}".encode()

    return made


SLOT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'

TOML: Mapping[str, Text] = {
    "dotted keys": repeated("a.b.c.d.e{}.f = 1\n"),
    "a long line": repeated("1, ", "a = [", "1]"),
    "unknown keys": repeated("a{} = 1\n"),
    "one key many times": repeated("a = 1\n"),
    "slots": repeated(SLOT.replace("1", "{}")),
    "pokes": repeated('{ at_s = {}, input = "home" },\n', f"{SLOT}[slot.machine]\ntimeline = [\n", "]"),
    "a great number": repeated("#\n", "scan_ms = 1e20\n"),
    "comments": repeated("# a\n"),
}

JSON: Mapping[str, Text] = {
    "closed brackets": repeated("[],", "[", "[]]"),
    "keys": repeated('"a{}":1,', "{", '"a":1}'),
    "a closed string": repeated("\\u0061", '{"a":"', '"}'),
    "blanks": repeated(" "),
}

RUNGS: Mapping[str, Text] = {
    "a long line": repeated("XIC(A)", "PROGRAM p\nTAG A : BOOL\nROUTINE Main\n", "OTE(A);\nEND\n"),
    "a long sum": repeated("A+", "PROGRAM p\nTAG A : DINT\nROUTINE Main\nCPT(A,", "A);\nEND\n"),
    "rungs": repeated("OTE(A);\n", "PROGRAM p\nTAG A : BOOL\nROUTINE Main\n", "END\n"),
    "tags": repeated("TAG A{} : DINT\n", "PROGRAM p\n", "ROUTINE Main\nNOP();\nEND\n"),
    "unknown tags": repeated("OTE(A{});\n", "PROGRAM p\nROUTINE Main\n", "END\n"),
    "apostrophes": repeated("'", "PROGRAM p\nROUTINE Main\n"),
    "labels": repeated("LBL(A{})NOP();\n", "PROGRAM p\nROUTINE Main\n", "END\n"),
    "routines": repeated("ROUTINE A{}\nNOP();\n", "PROGRAM p\nROUTINE Main\nNOP();\n", "END\n"),
    "jumps": repeated("JSR(A{},0);\n", "PROGRAM p\nROUTINE Main\n", "END\n"),
}

STRUCTURED: Mapping[str, Text] = {
    "a long sum": repeated("A + ", "PROGRAM p\nTAG A : DINT\nA := ", "A;\n"),
    "assignments": repeated("A := A;\n", "PROGRAM p\nTAG A : BOOL\n"),
    "ELSIF": repeated("ELSIF A THEN A := A;\n", "PROGRAM p\nTAG A : BOOL\nIF A THEN A := A;\n", "END_IF;\n"),
}

STEPS: Mapping[str, Text] = {
    "words": repeated("1 ", "words "),
    "lines": repeated("zero for 1 ms\n"),
    "long times": repeated("zero for 9999999999 s\n"),
}

PYTHON: Mapping[str, Text] = {
    "assignments": repeated("a = 1\n", after="def logic(scan): pass\n"),
    "functions": repeated("def a{}(): pass\n", after="def logic(scan): pass\n"),
}


def in_machine(*rungs: str, **parts: Any) -> str:
    return l5x_files.document(
        programs=[l5x_files.program("P", l5x_files.ladder("Main", *rungs))],
        tasks=[l5x_files.task("T", "P")],
        **parts,
    )


def around(whole: str, mark: str = "@") -> tuple[str, str]:
    before, _, after = whole.partition(mark)
    return before, after


ROOT, END = "<RSLogix5000Content>", "</RSLogix5000Content>"
RUNG = l5x_files.rung("NOP();")
MAIN = l5x_files.ladder("Main", "NOP();")

L5X: Mapping[str, Text] = {
    "elements": repeated("<a/>", f'{ROOT}<Controller Name="x">', f"</Controller>{END}"),
    "a long attribute": repeated("a", '<RSLogix5000Content a="', '"/>'),
    "references": repeated("&#65;", ROOT, END),
    "rungs": repeated(RUNG, *around(in_machine(f"{RUNG}@"))),
    "a long rung": repeated("XIC(A)", *around(in_machine("@OTE(A);", tags=[l5x_files.tag("A", "BOOL")]))),
    "tags": repeated(l5x_files.tag("A{}", "DINT"), *around(in_machine("NOP();", tags=["@"]))),
    "one tag many times": repeated(l5x_files.tag("A", "DINT"), *around(in_machine("NOP();", tags=["@"]))),
    "aliases in a chain": lambda size: in_machine(
        "XIC(A0)OTE(A1);", tags=[l5x_files.alias(f"A{each}", f"A{each + 1}") for each in range(size // 55)]
    ).encode(),
    "types": repeated(
        l5x_files.data_type("T{}", l5x_files.member("A", "DINT")), *around(in_machine("NOP();", types=["@"]))
    ),
    "programs": repeated(l5x_files.program("P{}", MAIN), *around(l5x_files.document(programs=["@"]))),
    "values": repeated(
        l5x_files.value("DINT", 1),
        *around(in_machine("NOP();", tags=[l5x_files.tag("A", "DINT", data="@")])),
    ),
    "modules": repeated(l5x_files.module("M{}", 1), *around(in_machine("NOP();", modules=["@"]))),
    "tasks": repeated(l5x_files.task("T{}", "P"), *around(l5x_files.document(tasks=["@"]))),
}

SLC: Mapping[str, Text] = {
    "rungs": repeated("SOR XIC B3:0/0 OTE B3:0/1 EOR\n", f"{slc_files.HEAD}\nLADDER 2\n"),
    "a long rung": repeated("XIC B3:0/0 ", f"{slc_files.HEAD}\nLADDER 2\nSOR ", "OTE B3:0/1 EOR\n"),
    "values": repeated("1 ", f"{slc_files.HEAD}\nDATA N7:0\n"),
    "files": repeated("\nLADDER {}\nSOR EOR\n", slc_files.HEAD),
    "slots": repeated("SLOT {} Bul.1766 % x % SCAN_IN 8 SCAN_OUT 6\n", slc_files.HEAD),
    "quotation marks": repeated('"', slc_files.HEAD),
}

STORED: Mapping[str, Text] = {
    "lines": repeated("MAX 5000\n"),
    "labels": repeated("LABEL A{}\n"),
    "jumps": repeated("GOTO A{}\n"),
    "comments": repeated("; a\n"),
}

LISTING: Mapping[str, Text] = {
    "lines": repeated("V 100\n"),
}

IN_PLAN = 'name = "q"\nrpi_ms = 2\nscan_ms = 10\nbegin = "zero for 1 ms"\n'
SCENE = '[[scene]]\nname = "a{}"\nwhy = "b"\nsteps = "zero for 1 ms"\n'

PLAN: Mapping[str, Text] = {
    **TOML,
    "scenes": repeated(SCENE, IN_PLAN),
    "steps": repeated("zero for 1 ms\n", IN_PLAN + SCENE.replace('"zero for 1 ms"', "'''"), "'''\n"),
}


def record(kind: int, data: bytes) -> bytes:
    return pack("<BQ", kind, len(data)) + data


def text(words: str) -> bytes:
    return pack("<I", len(words)) + words.encode()


MAGIC = b"\x89MCAP0\r\n"
BEGIN = MAGIC + record(Opcode.HEADER, text("scanrack") + text("x"))


def records(one: Callable[[int], bytes]) -> Text:
    def made(size: int) -> bytes:
        return BEGIN + b"".join(one(each) for each in range(max(1, size // len(one(1)))))

    return made


def a_chunk(inside: bytes) -> bytes:
    head = pack("<QQQI", 0, 0, len(inside), 0) + text("") + pack("<Q", len(inside))
    return record(Opcode.CHUNK, head + inside)


def a_schema(number: int) -> bytes:
    return record(Opcode.SCHEMA, pack("<H", number % 60_000 + 1) + text("a") + text("") + text(""))


def a_channel(number: int) -> bytes:
    words = text(f"/a{number}") + text("json") + text("")
    return record(Opcode.CHANNEL, pack("<HH", number % 60_000 + 1, 0) + words)


RECORDING: Mapping[str, Text] = {
    "schemas": records(a_schema),
    "channels": records(a_channel),
    "metadata": records(lambda n: record(Opcode.METADATA, text(f"a{n}") + text(""))),
    "attachments": records(
        lambda n: record(Opcode.ATTACHMENT, pack("<QQ", 0, 0) + text(f"a{n}") + text("") + pack("<QI", 0, 0))
    ),
    "chunks": records(lambda _n: a_chunk(b"")),
    "empty records": records(lambda _n: record(0x90, b"")),
    "messages": records(lambda n: record(Opcode.MESSAGE, pack("<HIQQ", 1, n, n, n))),
    "zeros": lambda size: BEGIN + bytes(size),
    "magics": lambda size: MAGIC * (size // 8),
}


def packets(one: Callable[[int], bytes], file: Callable[..., bytes] = pcap) -> Text:
    def made(size: int) -> bytes:
        return file([Frame(each, one(each)) for each in range(max(1, size // (len(one(1)) + 16)))])

    return made


READ = bytes.fromhex("000100000006010300000001")

CAPTURE: Mapping[str, Text] = {
    "packets": packets(lambda n: ethernet(segment(READ, 1000 + 12 * n))),
    "blocks": packets(lambda n: ethernet(segment(READ, 1000 + 12 * n)), pcapng),
    "segments backwards": packets(lambda n: ethernet(segment(READ, 10_000_000 - 12 * n))),
    "segments with gaps": packets(lambda n: ethernet(segment(READ, 1000 + 24 * n))),
    "one byte each": packets(lambda n: ethernet(segment(READ[n % 12 : n % 12 + 1], 1000 + n))),
    "connections": packets(
        lambda n: ethernet(segment(READ, 1000, source=(f"10.0.{n // 250 % 250}.{n % 250}", 1 + n % 60_000)))
    ),
    "answers": packets(lambda n: ethernet(segment(READ, 1000 + 12 * n, asked=False))),
    "interfaces": lambda size: pcapng([]) + pack("<IIHHII", 1, 20, 1, 0, 0, 20) * (size // 20),
    "zeros": lambda size: pcap([]) + bytes(size),
}

LOG: Mapping[str, Text] = {
    "frames": repeated("0.{} > 01 03 00 00 00 26 c5 d0\n"),
    "a long line": repeated("01 ", "0.1 > "),
    "digits": repeated("0"),
    "no frames": repeated("> \n"),
    "times": repeated("9", "0."),
}

RETAINED: Mapping[str, Text] = {
    **JSON,
    "tags": repeated('"A{}":1,', '{"format":"scanrack tags 1","tags":{', '"A":1}}'),
}

HTML: Mapping[str, Text] = {"elements": repeated("<p></p>")}

FILES: Mapping[str, Mapping[str, Text]] = {
    ".toml": TOML,
    ".json": RETAINED,
    ".campaign": JSON,
    ".rung": RUNGS,
    ".st": STRUCTURED,
    ".steps": STEPS,
    ".py": PYTHON,
    ".L5X": L5X,
    ".SLC": SLC,
    ".pclt": STORED,
    ".unit": STORED,
    ".pmc": LISTING,
    ".mcap": RECORDING,
    ".pcap": CAPTURE,
    ".log": LOG,
    ".plan": PLAN,
    ".html": HTML,
}
"""What grows, by the kind of a file: its suffix, or what it is for."""

LARGEST: Mapping[str, str] = {
    ".toml": "dotted keys",
    ".json": "tags",
    ".campaign": "keys",
    ".rung": "rungs",
    ".st": "assignments",
    ".steps": "lines",
    ".py": "assignments",
    ".L5X": "rungs",
    ".SLC": "rungs",
    ".pclt": "lines",
    ".unit": "lines",
    ".pmc": "lines",
    ".mcap": "messages",
    ".pcap": "segments backwards",
    ".log": "frames",
    ".plan": "scenes",
    ".html": "elements",
}
"""What each command reads."""
