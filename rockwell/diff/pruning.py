"""Cut out what two documents have in common, so that only the rest is parsed and compared.

    <Tag Name="A" ...> ... </Tag>     in both, byte for byte, and perhaps
    <Tag Name="B" ...> ... </Tag>     its neighbor:                             <Cut N="5"/>

Most of two versions is the same, and comparing bytes takes a tenth of the time of parsing elements.
Line numbers do not change: a cut keeps its newlines. Programs, tags and so on are compared first; in those
that differ, their tags and routines are compared.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Iterable
from itertools import pairwise
from typing import NamedTuple

CUT = "Cut"
"""Name of the element that replaces common content."""

_WHOLE = "|".join(
    (
        *("AddOnInstructionDefinition", "Program", "Routine", "DataType", "Module", "Tag", "Parameter"),
        *("LocalTag", "Task", "Trend"),
    )
)
"""Elements that are replaced."""

_LEVELS = 2
"""Nesting levels of them: a program, and a routine in it."""

_CDATA = r"<!\[CDATA\[(?:[^\]]++|\](?!\]>))*+\]\]>"
_GIVEN = r"""(?:[^<>"']++|"[^"]*+"|'[^']*+')*+"""
_INNER = rf"[^<]*+(?:(?:<(?![!?]|/?+\1[\s/>])|{_CDATA})[^<]*+)*+"
_ELEMENT = re.compile(
    rf"{_CDATA}|<({_WHOLE})(?=[\s/>]){_GIVEN}(?:(?<=/)>|>{_INNER}</\1\s*+>)|(<[!?])".encode()
)
"""An element that may be replaced, without a nested one of the same name; a CDATA section; or a comment."""

Span = tuple[int, int]
Joint = tuple[bytes, bytes, bytes]
"""Two elements and the bytes between them."""


class PrunedDocument(NamedTuple):
    """A document with cuts, and the contents that they replace; each cut has the index of its content."""

    data: bytes
    cuts: list[bytes]


class _Element(NamedTuple):
    """An element: where it begins and ends, and its bytes."""

    begin: int
    end: int
    content: bytes


def pruned(old: bytes, new: bytes) -> tuple[PrunedDocument, PrunedDocument]:
    """Return two documents without the elements that both have; unchanged if either has comments."""
    documents = PrunedDocument(old, []), PrunedDocument(new, [])
    old_cutting, new_cutting = _Cutting(old), _Cutting(new)
    for _ in range(_LEVELS):
        old_elements, new_elements = old_cutting.elements(), new_cutting.elements()
        if old_elements is None or new_elements is None:
            return documents
        common_contents = {element.content for element in old_elements} & {
            element.content for element in new_elements
        }
        old_cutting.cut_out(old_elements, common_contents)
        new_cutting.cut_out(new_elements, common_contents)
    joints = _joints(old, old_cutting.cut) & _joints(new, new_cutting.cut)
    before, after = _without(old, old_cutting.cut, joints), _without(new, new_cutting.cut, joints)
    return documents if _has_own_cuts(before) or _has_own_cuts(after) else (before, after)


class _Cutting:
    """A document whose elements are cut out level by level."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._spans: list[Span] = [(0, len(data))]  # spans that contain the next level
        self.cut: list[_Element] = []

    def elements(self) -> list[_Element] | None:
        return _elements(self._data, self._spans)

    def cut_out(self, elements: Iterable[_Element], common: Container[bytes]) -> None:
        self._spans = []
        for element in elements:
            if element.content in common:
                self.cut.append(element)
            else:
                self._spans.append((element.begin, element.end))


def _has_own_cuts(document: PrunedDocument) -> bool:
    return document.data.count(b"<Cut") != len(document.cuts)


def _elements(data: bytes, spans: Iterable[Span]) -> list[_Element] | None:
    """Return the outermost elements in spans; None if there are comments or unterminated CDATA."""
    if data.rfind(b"<![CDATA[") > data.rfind(b"]]>"):
        return None
    elements: list[_Element] = []
    for begin, end in spans:
        for match in _ELEMENT.finditer(
            data, begin + 1, end
        ):  # without the element itself, or the declaration
            if match[1]:
                elements.append(_Element(match.start(), match.end(), match[0]))
            elif match[2]:
                return None
    return elements


def _joints(data: bytes, parts: list[_Element]) -> set[Joint]:
    """Return neighboring elements with only blanks between them, where each element occurs once."""
    parts.sort()
    counts = Counter(part.content for part in parts)
    return {
        (part.content, between, following.content)
        for part, following in pairwise(parts)
        if (between := data[part.end : following.begin]).isspace()
        and counts[part.content] == counts[following.content] == 1
    }


def _without(data: bytes, parts: list[_Element], joints: set[Joint]) -> PrunedDocument:
    """Replace elements with cuts; elements that are neighbors in both documents become one cut."""
    runs: list[list[int]] = []
    before: _Element | None = None
    for part in parts:
        joined = (
            before is not None and (before.content, data[before.end : part.begin], part.content) in joints
        )
        if joined:
            runs[-1][1] = part.end
        else:
            runs.append([part.begin, part.end])
        before = part
    pieces: list[bytes] = []
    cuts: list[bytes] = []
    done = 0
    for begin, end in runs:
        content = data[begin:end]
        pieces += [data[done:begin], b'<Cut N="%d"/>' % len(cuts), b"\n" * content.count(b"\n")]
        cuts.append(content)
        done = end
    return PrunedDocument(b"".join((*pieces, data[done:])), cuts)
