"""Cuts out the common elements of two documents, so that only the others are parsed and compared.

    <Tag Name="A" ...> ... </Tag>     in both documents, byte for byte,
    <Tag Name="B" ...> ... </Tag>     and neighbors in both:                    <Cut N="5"/>

Two versions are mostly the same, and comparing bytes is ten times as fast as parsing elements.
Line numbers do not change: a cut keeps its newlines. Programs, controller tags and similar elements are
compared first. Then the tags and routines of elements that differ are compared.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
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
"""Nesting levels of replaced elements: a program, and a routine in it."""

_CDATA = r"<!\[CDATA\[(?:[^\]]++|\](?!\]>))*+\]\]>"
_ATTRIBUTES = r"""(?:[^<>"']++|"[^"]*+"|'[^']*+')*+"""
_INNER = rf"[^<]*+(?:(?:<(?![!?]|/?+\1[\s/>])|{_CDATA})[^<]*+)*+"
_ELEMENT = re.compile(
    rf"{_CDATA}|<({_WHOLE})(?=[\s/>]){_ATTRIBUTES}(?:(?<=/)>|>{_INNER}</\1\s*+>)|(<[!?])".encode()
)
"""A CDATA section, a comment, or a replaceable element that contains no element of the same name."""

Joint = tuple[bytes, bytes, bytes]
"""Two neighboring elements and the bytes between them."""


class PrunedDocument(NamedTuple):
    """A document with cuts."""

    data: bytes
    cuts: list[bytes]  # the replaced content of each cut, by its number N


class _Element(NamedTuple):
    """An element of a document, with its position."""

    begin: int
    end: int
    content: bytes


def pruned(old: bytes, new: bytes) -> tuple[PrunedDocument, PrunedDocument]:
    """Return two documents without their common elements; return both unchanged if either has comments."""
    unchanged = PrunedDocument(old, []), PrunedDocument(new, [])
    old_outer, new_outer = ([_Element(0, len(data), data)] for data in (old, new))
    old_cut: list[_Element] = []
    new_cut: list[_Element] = []
    for _ in range(_LEVELS):
        old_elements, new_elements = _elements(old, old_outer), _elements(new, new_outer)
        if old_elements is None or new_elements is None:
            return unchanged
        common = _contents(old_elements) & _contents(new_elements)
        cut, old_outer = _split(old_elements, common)
        old_cut += cut
        cut, new_outer = _split(new_elements, common)
        new_cut += cut
    old_cut.sort()
    new_cut.sort()
    joints = _joints(old, old_cut) & _joints(new, new_cut)
    old_pruned, new_pruned = _with_cuts(old, old_cut, joints), _with_cuts(new, new_cut, joints)
    if _has_own_cuts(old_pruned) or _has_own_cuts(new_pruned):
        return unchanged
    return old_pruned, new_pruned


def _contents(elements: Iterable[_Element]) -> set[bytes]:
    return {element.content for element in elements}


def _split(elements: Iterable[_Element], common: set[bytes]) -> tuple[list[_Element], list[_Element]]:
    """Return the elements with common content, and the other elements."""
    split: tuple[list[_Element], list[_Element]] = ([], [])
    for element in elements:
        split[element.content not in common].append(element)
    return split


def _has_own_cuts(document: PrunedDocument) -> bool:
    """Return whether the file itself has elements named Cut."""
    return document.data.count(b"<Cut") != len(document.cuts)


def _elements(data: bytes, outer_elements: Iterable[_Element]) -> list[_Element] | None:
    """Return the outermost elements inside other elements; None for comments or unterminated CDATA."""
    if data.rfind(b"<![CDATA[") > data.rfind(b"]]>"):
        return None
    elements: list[_Element] = []
    for outer in outer_elements:
        # from the second byte on, so that neither the outer element itself nor the declaration matches
        for match in _ELEMENT.finditer(data, outer.begin + 1, outer.end):
            if match[1]:
                elements.append(_Element(match.start(), match.end(), match[0]))
            elif match[2]:
                return None
    return elements


def _joints(data: bytes, elements: list[_Element]) -> set[Joint]:
    """Return the neighbors with only white space between them, if each occurs only once."""
    counts = Counter(element.content for element in elements)
    joints: set[Joint] = set()
    for element, following in pairwise(elements):
        between = data[element.end : following.begin]
        if between.isspace() and counts[element.content] == counts[following.content] == 1:
            joints.add((element.content, between, following.content))
    return joints


def _with_cuts(data: bytes, elements: list[_Element], joints: set[Joint]) -> PrunedDocument:
    """Return a document with cuts for elements; neighbors in `joints` become one cut."""
    spans: list[list[int]] = []  # begin and end of each cut
    previous: _Element | None = None
    for element in elements:
        if previous and (previous.content, data[previous.end : element.begin], element.content) in joints:
            spans[-1][1] = element.end
        else:
            spans.append([element.begin, element.end])
        previous = element
    pieces: list[bytes] = []
    cuts: list[bytes] = []
    position = 0
    for begin, end in spans:
        content = data[begin:end]
        pieces += [data[position:begin], b'<Cut N="%d"/>' % len(cuts), b"\n" * content.count(b"\n")]
        cuts.append(content)
        position = end
    return PrunedDocument(b"".join((*pieces, data[position:])), cuts)
