"""Two documents without what both have: the rest is all that is parsed and compared.

    <Tag Name="A" ...> ... </Tag>     in both, byte for byte:     <Cut N="5"/>

Most of two versions is the same, and comparing its bytes takes a tenth of the time of reading its elements.
Line numbers stay: a cut leaves its newlines. Programs, tags and so on are compared first; of those that
differ, their tags and routines.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

CUT = "Cut"
"""The element that replaces what both documents have."""

_WHOLE = "|".join(
    (
        *("AddOnInstructionDefinition", "Program", "Routine", "DataType", "Module", "Tag", "Parameter"),
        *("LocalTag", "Task", "Trend"),
    )
)
"""Elements that are replaced."""

_LEVELS = 2
"""Levels of them: a program, and a routine of it."""

_CDATA = r"<!\[CDATA\[(?:[^\]]++|\](?!\]>))*+\]\]>"
_GIVEN = r"""(?:[^<>"']++|"[^"]*+"|'[^']*+')*+"""
_INNER = rf"[^<]*+(?:(?:<(?![!?]|/?+\1[\s/>])|{_CDATA})[^<]*+)*+"
_ELEMENT = re.compile(
    rf"{_CDATA}|<({_WHOLE})(?=[\s/>]){_GIVEN}(?:(?<=/)>|>{_INNER}</\1\s*+>)|(<[!?])".encode()
)
"""One of those elements with no other of its name in it; characters, in which there is none; or a comment."""

Span = tuple[int, int]


class Pruned(NamedTuple):
    """A document, and what was cut out of it: by the number in it."""

    data: bytes
    cuts: list[bytes]


def pruned(old: bytes, new: bytes) -> tuple[Pruned, Pruned]:
    """Return two documents without the elements that both have; whole ones if one has comments."""
    documents = old, new
    cut: tuple[list[Span], list[Span]] = ([], [])
    spans: list[list[Span]] = [[(0, len(each))] for each in documents]
    for _ in range(_LEVELS):
        found = [_elements(data, each) for data, each in zip(documents, spans, strict=True)]
        if None in found:
            return Pruned(old, []), Pruned(new, [])
        contents = [
            {data[begin:end] for begin, end in each or ()}
            for data, each in zip(documents, found, strict=True)
        ]
        common = contents[0] & contents[1]
        for number, data in enumerate(documents):
            spans[number] = []
            for begin, end in found[number] or ():
                (cut[number] if data[begin:end] in common else spans[number]).append((begin, end))
    before, after = _without(old, cut[0]), _without(new, cut[1])
    if _has_own_cuts(before) or _has_own_cuts(after):
        return Pruned(old, []), Pruned(new, [])
    return before, after


def _has_own_cuts(document: Pruned) -> bool:
    return document.data.count(b"<Cut") != len(document.cuts)


def _elements(data: bytes, spans: Iterable[Span]) -> list[Span] | None:
    """Return the outermost elements inside of spans; None if there are comments or unended characters."""
    if data.rfind(b"<![CDATA[") > data.rfind(b"]]>"):
        return None
    elements: list[Span] = []
    for begin, end in spans:
        for found in _ELEMENT.finditer(
            data, begin + 1, end
        ):  # without the element itself, or the declaration
            if found[1]:
                elements.append(found.span())
            elif found[2]:
                return None
    return elements


def _without(data: bytes, spans: list[Span]) -> Pruned:
    kept: list[bytes] = []
    cuts: list[bytes] = []
    done = 0
    for begin, end in sorted(spans):
        content = data[begin:end]
        kept += [data[done:begin], b'<Cut N="%d"/>' % len(cuts), b"\n" * content.count(b"\n")]
        cuts.append(content)
        done = end
    return Pruned(b"".join((*kept, data[done:])), cuts)
