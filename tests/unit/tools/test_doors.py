"""Each format has one door: a parser of texts and files from outside is called nowhere else.

A parser that is called directly lacks the limits and the errors of its door, which goes unnoticed until a
file is large, nested or damaged.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from house import ROOMS

ROOT = Path(__file__).parents[3]

DOORS = {
    "tomllib.load": set(),
    "tomllib.loads": {"io_images/doors.py"},
    "json.load": set(),
    "json.loads": {"io_images/doors.py"},
    "json.JSONDecoder": set(),
    "lxml.etree.XMLParser": {"rockwell/l5x/xml/parsing.py"},
    "lxml.etree.fromstring": {"rockwell/l5x/xml/parsing.py"},
    **{f"lxml.etree.{each}": set() for each in ("parse", "XML", "iterparse", "HTML")},
    "mcap.reader.make_reader": {"traces/repair.py"},
    "mcap.data_stream.ReadDataStream": {"traces/format/records.py"},
    "zstandard.ZstdDecompressor": {"traces/format/records.py"},
    "lz4.frame.LZ4FrameDecompressor": {"traces/format/records.py"},
    "scanrack.io_images.captures.packets.Capture": {"scanrack/jobs/captures/reading.py"},
    "ast.literal_eval": {"scanrack/jobs/check/python/scans.py"},
    "numpy.load": set(),
    "numpy.loadtxt": set(),
    "numpy.genfromtxt": set(),
    "csv.reader": set(),
    "csv.DictReader": set(),
}
"""Parsers, and the files that may call them: with limits, and with errors that name the place."""

REFUSED = ("xml", "yaml", "ruamel", "toml", "tomli", "dpkt", "scapy", "pcapng", "marshal", "shelve", "dill")
"""Packages that parse one of these formats, or run what they read."""

OF_OUR_OWN = {
    "scanrack/jobs/prove/checking.py": "the certificate that was just written; the checker stands alone",
    "scanrack/lsp/findings.py": "a helper of this process answers on a pipe",
    "scanrack/watch/monitors/question_process.py": "a helper of this process answers on a pipe",
    "scanrack/watch/monitors/session_monitor.py": "our own messages to a page, read again",
}
"""Files that read JSON of our own processes only."""


WRITERS = "xml.sax.saxutils."
"""Functions that quote texts and read none."""

PLACES = {"rockwell/l5x/xml/spans.py": "xml.parsers.expat"}
"""Files that find the places of elements in a text that its door has accepted: lxml has no byte offsets."""


MAY_PARSE = re.compile(rf"\b({'|'.join({*REFUSED, *(each.rpartition('.')[2] for each in DOORS)})})\b")
"""Part of each file that uses a parser: the others need no tree."""


@cache
def used_by_file() -> dict[str, set[str]]:
    return {
        file: set(uses(ast.parse(text), package_of(file)))
        for room in ROOMS
        for path in sorted((ROOT / room).rglob("*.py"))
        for file in [path.relative_to(ROOT).as_posix()]
        for text in [path.read_text("utf-8")]
        if MAY_PARSE.search(text)
    }


def uses(tree: ast.Module, package: str) -> Iterator[str]:
    """Yield the full names that a module uses: of what it imports, wherever it does."""
    names: dict[str, str] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for each in node.names:
                names[each.asname or each.name.partition(".")[0]] = (
                    each.name if each.asname else each.name.partition(".")[0]
                )
        elif isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: -node.level] if node.level else []
            module = ".".join([*parts, *([node.module] if node.module else [])])
            for each in node.names:
                names[each.asname or each.name] = f"{module}.{each.name}"
                yield f"{module}.{each.name}"
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id in names:
            yield names[node.id]
        elif isinstance(node, ast.Attribute):
            parts = []
            inner: ast.expr = node
            while isinstance(inner, ast.Attribute):
                parts.append(inner.attr)
                inner = inner.value
            if isinstance(inner, ast.Name) and inner.id in names:
                yield ".".join([names[inner.id], *reversed(parts)])


def package_of(file: str) -> str:
    """Return the full name of a module; that of a package ends with `__init__`."""
    return "scanrack." + file.removesuffix(".py").removeprefix("scanrack/").replace("/", ".")


def strays(file: str, used: set[str]) -> set[str]:
    """Return the parsers that a file uses and is no door of."""
    known = (WRITERS, PLACES.get(file, WRITERS))
    refused = {each for each in used if each.partition(".")[0] in REFUSED and not each.startswith(known)}
    found = refused | {each for each in used if each in DOORS and file not in DOORS[each]}
    return found - {"json.load", "json.loads"} if file in OF_OUR_OWN else found


@pytest.mark.slow
def test_no_parser_is_called_beside_its_door() -> None:
    assert {file: found for file, used in used_by_file().items() if (found := strays(file, used))} == {}


@pytest.mark.slow
def test_every_door_is_used() -> None:
    used = used_by_file()
    assert [(each, door) for each, doors in DOORS.items() for door in doors if each not in used[door]] == []
    assert [each for each in OF_OUR_OWN if "json.loads" not in used[each]] == []


@pytest.mark.parametrize(
    ("text", "parser"),
    [
        ("import tomllib\ntomllib.loads('')", "tomllib.loads"),
        ("from tomllib import loads as read\nread('')", "tomllib.loads"),
        ("def f():\n    import json as j\n    return j.loads", "json.loads"),
        ("from lxml import etree\netree.parse('x')", "lxml.etree.parse"),
        ("import lxml.etree\nlxml.etree.fromstring(b'')", "lxml.etree.fromstring"),
        ("from xml.etree import ElementTree", "xml.etree.ElementTree"),
        ("from mcap.reader import make_reader", "mcap.reader.make_reader"),
        ("from ..io_images.captures.packets import Capture", "scanrack.io_images.captures.packets.Capture"),
    ],
)
def test_a_parser_is_found_by_any_name(text: str, parser: str) -> None:
    file = "scanrack/jobs/new.py"
    assert strays(file, set(uses(ast.parse(text), package_of(file)))) == {parser}
