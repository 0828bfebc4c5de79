"""Parses untrusted bytes into elements; refuses content that no export has.

| refused | why |
|---|---|
| more than 64 MiB, or `MOST_MARKS` tags, attributes and texts | memory |
| a DOCTYPE | entities, external files; no export has one |
| elements more than 256 deep | libxml2's limit without `huge_tree` |
| bytes that are not UTF-8, UTF-16 or in the declared encoding | the text is unknown |
"""

from __future__ import annotations

import codecs
import re
from functools import cache
from typing import Any, NamedTuple

from lxml import etree
from scanrack.io_images.site import Site
from scanrack.ladder.model.errors import LadderError

ROOT = "RSLogix5000Content"
"""The root element of an L5X."""

MOST_BYTES = 64 << 20
"""Maximum size of a file, in bytes."""

MOST_MARKS = 1_350_000
"""Maximum number of tags, attributes and texts; libxml2 needs up to 260 bytes for each."""

_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_DECLARED = re.compile(rb"""<\?xml[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_ENCODINGS = {"iso-8859-1": "latin-1", "windows-1252": "cp1252", "us-ascii": "ascii"}
_PROLOG = re.compile(rb"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_TEXT = re.compile(rb">\s*+[^<\s]")
_ZERO = re.compile(
    rb'<Element Index="\[[0-9,]{1,30}\]" Value="(?:0|0\.0|0\.0{8}e\+0{3}|(?:2|8|16)#[0_]{1,100})"/>'
)
"""An array element that equals the default."""


class L5xError(LadderError):
    """The L5X is unusable; the message has file and line."""

    def __init__(self, file: str, line: int, text: str) -> None:
        site = Site(file=file, line=line)
        super().__init__(f"{site.spot}: {text}", site)


class FileText(NamedTuple):
    """The bytes of a file, in two parts, and the encoding of the file."""

    lead: bytes  # byte order mark and blanks, in the encoding of the file
    text: bytes  # the rest, as UTF-8
    encoding: str

    def bytes_of(self, text: bytes) -> bytes:
        """Return the file with new text; characters that its encoding lacks become codes like `&#8364;`."""
        if self.encoding == "utf-8":
            return self.lead + text
        return self.lead + text.decode().encode(self.encoding, "xmlcharrefreplace")


def checked(data: bytes, file: str) -> bytes:
    """Return a document's bytes as UTF-8; raise an L5xError for content that no export has."""
    if len(data) > MOST_BYTES:
        raise L5xError(file, 0, f"it has more than {MOST_BYTES:,} bytes")
    data = decoded(data, file).text
    marks = _marks(data)
    if marks > MOST_MARKS:
        data = _ZERO.sub(b"", data)  # large controllers consist mostly of arrays of zeros
        marks = _marks(data)
    if marks > MOST_MARKS:
        raise L5xError(file, 0, f"it has {marks:,} tags, attributes and texts; {MOST_MARKS:,} are allowed")
    _refuse_doctype(data, file)
    return data


@cache
def _parser() -> Any:
    return etree.XMLParser(
        encoding="utf-8", resolve_entities=False, load_dtd=False, no_network=True, huge_tree=False
    )


def parsed(data: bytes, file: str, line: int = 1) -> Any:
    """Return the root of a document, or of a part that begins on a line of the file."""
    try:
        return etree.fromstring(data, _parser())
    except etree.XMLSyntaxError as error:
        raise L5xError(file, line - 1 + (error.lineno or 1), f"it is not XML: {error.msg}") from None
    except ValueError as error:
        raise L5xError(file, line, f"it is not XML: {error}") from None


def root_of(data: bytes, file: str) -> Any:
    """Return the root of an L5X; raise an L5xError for any other document."""
    root = parsed(data, file)
    if root.tag != ROOT:
        raise L5xError(file, root.sourceline or 1, f"its root is {root.tag}; the root of an L5X is {ROOT}")
    return root


def _marks(data: bytes) -> int:
    """Return the number of tags, attributes and texts; texts count only if they might exceed the limit."""
    tags, attributes = data.count(b"<"), data.count(b"=")
    if 2 * tags + attributes <= MOST_MARKS:  # at most one text after each tag
        return tags + attributes
    return tags + attributes + sum(1 for _ in _TEXT.finditer(data))


def decoded(data: bytes, file: str) -> FileText:
    """Decode a file according to its byte order mark, UTF-16 zeros or XML declaration, or else as UTF-8.

    Raises:
        L5xError: the bytes can't be decoded.
    """
    encoding = next((name for mark, name in _BOMS if data.startswith(mark)), None)
    if encoding is None and data[:2] in (b"<\0", b"\0<"):
        encoding = "utf-16-le" if data[:1] == b"<" else "utf-16-be"
    if encoding is None:
        declared = _DECLARED.match(data.lstrip()[:300])
        name = declared.group(1).decode("ascii").lower() if declared else ""
        encoding = _ENCODINGS.get(name, "utf-8")
    try:
        text = data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise L5xError(file, line, f"it is not {encoding.upper()} text: {error.reason}") from None
    if encoding == "utf-8":
        body = data.removeprefix(codecs.BOM_UTF8).lstrip()
        return FileText(data[: len(data) - len(body)], body, encoding)
    stripped = text.removeprefix("\ufeff").lstrip()
    return FileText(text[: len(text) - len(stripped)].encode(encoding), stripped.encode("utf-8"), encoding)


def _refuse_doctype(data: bytes, file: str) -> None:
    """Raise an L5xError for a DOCTYPE, which can only follow the prolog."""
    position = 0
    while match := _PROLOG.match(data, position):
        position = match.end()
    if data.startswith(b"<!", position):
        line = data.count(b"\n", 0, position) + 1
        raise L5xError(file, line, "it has a DOCTYPE; no export of an L5X has one")
