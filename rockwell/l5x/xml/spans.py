"""Finds the positions of elements in the text of an L5X, so that an edit replaces only their bytes.

    <Rung Number="0" Type="N"><Text>XIC(Go);</Text></Rung>
    ^begin                    ^inner               ^close ^end

Finds only the elements that exports and edits change: the parts of the controller, its programs, their
tags and routines, and rungs with their texts.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from typing import NamedTuple
from xml.parsers import expat

from .parsing import ROOT, FileText, L5xError, checked, decoded

_ALL = ("*",)
_FOLLOWED: Mapping[str, tuple[str, ...]] = {
    "": (ROOT,),
    ROOT: _ALL,
    "Controller": _ALL,
    "Programs": ("Program",),
    "Program": _ALL,
    "Routines": ("Routine", "EncodedData"),
    "Routine": _ALL,
    "RLLContent": ("Rung",),
    "Rung": ("Text",),
    "Text": _ALL,
}
"""Children that are found, by parent element."""

_DEEPEST = 256
"""Maximum depth of elements, as in `parsing`."""

_START_TAG = re.compile(rb"""<[^<>"']*+(?:"[^"]*+"[^<>"']*+|'[^']*+'[^<>"']*+)*+>""")
_BLANKS = b" \t\r\n"


class Splice(NamedTuple):
    """Text that replaces the bytes from `begin` to `end`; it is inserted if they are equal."""

    begin: int
    end: int
    text: bytes


class Span:
    """The positions of an element.

    Attributes:
        begin: the position of its `<`.
        inner: the end of its start tag.
        close: the beginning of its end tag.
        end: the end of the element.
    """

    __slots__ = ("attributes", "begin", "children", "close", "end", "inner", "tag")

    def __init__(self, tag: str, attributes: Mapping[str, str], begin: int) -> None:
        self.tag, self.attributes, self.begin = tag, attributes, begin
        self.inner = self.close = self.end = begin
        self.children: list[Span] = []

    @property
    def name(self) -> str:
        """The value of its Name attribute; "" if it has none."""
        return self.attributes.get("Name", "")

    @property
    def is_empty(self) -> bool:
        """Whether the element is a single tag such as `<Tags/>`."""
        return self.inner == self.end

    def child(self, tag: str) -> Span | None:
        """Return the first child with the given tag."""
        return next((child for child in self.children if child.tag == tag), None)

    def all(self, tag: str) -> list[Span]:
        """Return the children with the given tag."""
        return [child for child in self.children if child.tag == tag]


class L5xText:
    """The text of an L5X with the positions of its elements.

    Attributes:
        text: the text as UTF-8, from the first `<`.
        root: the root element.
        newline: the end of a line in the file.
    """

    def __init__(self, data: bytes, file: str) -> None:
        """Find the elements; raise an L5xError for a file that can't be imported."""
        checked(data, file)
        self._decoded: FileText = decoded(data, file)
        self.text = self._decoded.text
        self.root = _Finder(self.text, file).root()
        self.newline = b"\r\n" if b"\r\n" in self.text else b"\n"

    @property
    def controller(self) -> Span | None:
        """The element of its controller."""
        return self.root.child("Controller")

    @property
    def programs(self) -> list[Span]:
        """The elements of its programs."""
        groups = [] if self.controller is None else self.controller.all("Programs")
        return [program for group in groups for program in group.children]

    def line(self, position: int) -> int:
        """Return the line number of a position in the text."""
        return 1 + self._decoded.lead.count(b"\n") + self.text.count(b"\n", 0, position)

    def spliced(self, splices: Iterable[Splice]) -> bytes:
        """Return the bytes of the file with splices applied; they must not overlap."""
        pieces, position = [], 0
        for begin, end, text in sorted(splices, key=lambda splice: (splice.begin, splice.end)):
            pieces += [self.text[position:begin], text]
            position = end
        return self._decoded.bytes_of(b"".join((*pieces, self.text[position:])))

    def characters(self, text: str) -> bytes:
        """Return text as the content of an element, as a CDATA section if possible."""
        text = escaped(text)
        try:
            text.encode(self._decoded.encoding)
        except UnicodeEncodeError:
            return escape(text, quote=False).encode()
        return escape(text, quote=False).encode() if "]]>" in text else f"<![CDATA[{text}]]>".encode()

    def attribute(self, span: Span, name: str, value: str | None) -> Splice:
        """Return the splice that sets or adds an attribute of an element; None removes it."""
        start_tag = self.text[span.begin : span.inner]
        match = re.search(rb"""\s%s\s*=\s*("[^"]*"|'[^']*')""" % name.encode(), start_tag)
        quoted = b"" if value is None else b'"%s"' % escape(value).encode()
        if match is None:
            position = span.begin + 1 + len(span.tag.encode())
            return Splice(position, position, quoted and b" %s=%s" % (name.encode(), quoted))
        begin, end = match.span() if value is None else match.span(1)
        return Splice(span.begin + begin, span.begin + end, quoted)

    def without(self, span: Span) -> Splice:
        """Return the splice that removes an element and the blanks after it."""
        tail = self.text[span.end : span.end + 200]
        return Splice(span.begin, span.end + len(tail) - len(tail.lstrip(_BLANKS)), b"")

    def blanks_before(self, span: Span) -> bytes:
        """Return the blanks before an element."""
        preceding = self.text[max(0, span.begin - 200) : span.begin]
        return preceding[len(preceding.rstrip(_BLANKS)) :]

    def content(self, span: Span, content: bytes) -> Splice:
        """Return the splice that replaces an element's content, except the blanks at both ends."""
        inside = self.text[span.inner : span.close]
        begin = span.inner + len(inside) - len(inside.lstrip(_BLANKS))
        return Splice(begin, max(begin, span.inner + len(inside.rstrip(_BLANKS))), content)

    def last(self, span: Span, content: bytes) -> Splice:
        """Return the splice that appends to an element's content."""
        if not span.is_empty:
            return Splice(span.close, span.close, content)
        slash = span.end - len(b"/>")
        return Splice(slash, span.end, b">%s</%s>" % (content, span.tag.encode()))


_NO_CHARACTER = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 does not allow [XML 1.0, 2.2]."""


def escaped(text: str) -> str:
    r"""Replace characters that XML does not allow with their codes, in the notation of Logix.

    >>> escaped("a\x02b")
    'a$02b'
    """
    return text if text.isprintable() else _NO_CHARACTER.sub(lambda match: f"${ord(match[0]):02X}", text)


class _Finder:
    """Finds elements by the positions at which the XML parser reports their tags."""

    def __init__(self, text: bytes, file: str) -> None:
        self._text, self._file = text, file
        self._open_spans = [Span("", {}, 0)]
        self._skipped_depth = 0  # number of open elements that are not found

    def root(self) -> Span:
        """Parse the text; return the root element with the elements in it."""
        self._parser = parser = expat.ParserCreate("utf-8")
        parser.StartElementHandler, parser.EndElementHandler = self._start, self._end
        try:
            parser.Parse(self._text, True)
        except expat.ExpatError as error:
            raise L5xError(
                self._file, error.lineno, f"it is not XML: {expat.ErrorString(error.code)}"
            ) from None
        roots = self._open_spans[0].children
        if not roots:
            raise L5xError(self._file, 1, f"its root is not {ROOT}")
        return roots[0]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        """Add the span of an element to its parent's span; skip elements that `_FOLLOWED` does not list."""
        parent = self._open_spans[-1]
        followed = _FOLLOWED.get(parent.tag, ())
        if self._skipped_depth or not (tag in followed or followed is _ALL):
            self._skipped_depth += 1
            if self._skipped_depth > _DEEPEST:
                raise L5xError(self._file, self._parser.CurrentLineNumber, "its elements are too deep")
            return
        begin = self._parser.CurrentByteIndex
        match = _START_TAG.match(self._text, begin)
        assert match is not None
        span = Span(tag, attributes, begin)
        span.inner = span.close = span.end = match.end()
        parent.children.append(span)
        self._open_spans.append(span)

    def _end(self, _tag: str) -> None:
        """Set the end of an element's span; the span of an empty element, `<A/>`, already has its end."""
        if self._skipped_depth:
            self._skipped_depth -= 1
            return
        span = self._open_spans.pop()
        if self._text[span.inner - 2 : span.inner] != b"/>":
            span.close = self._parser.CurrentByteIndex
            span.end = self._text.index(b">", span.close) + 1


def defined(spans: Iterable[Span], name: str) -> Iterator[Span]:
    """Yield the elements that define a name, but not references to it; see `defined_routines`."""
    for span in spans:
        use = span.attributes.get("Use")
        has_content = any(child.tag.endswith("Content") for child in span.children)
        is_empty_context = span.tag == "Routine" and use == "Context" and not has_content
        if span.name.upper() == name.upper() and use != "Reference" and not is_empty_context:
            yield span
