"""Cuts decorated data, which is most of a document, out of the document and parses it tag by tag.

Parsed elements use sixteen times the memory of their text.

    <Data Format="Decorated"> ... </Data>   becomes   <Data Format="Decorated" Cut="0"/>

A regular expression reads values in the exact notation of Studio 5000, in a third of the parser's time. The
XML parser reads all other notations, and reports their errors.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

_CUT = re.compile(rb"Cut\s*=")
_NEXT = re.compile(rb'<!\[CDATA\[|<!--|<Data Format="Decorated">')
_END = re.compile(rb"<!\[CDATA\[|<!--|</Data>")
_CLOSING = {b"<![CDATA[": b"]]>", b"<!--": b"-->"}
_ONE_VALUE = re.compile(
    rb'<Data Format="Decorated">\s*<DataValue DataType="\w+"(?: Radix="[\w/ ]+")?'
    rb' Value="([\w.+-]+)"/>\s*</Data>'
)


class DecoratedValue(NamedTuple):
    """An element of decorated data."""

    tag: str
    name: str  # its Name, for an `Element` its Index; "" without one
    value: str | None
    text: str
    inner: list[DecoratedValue]  # the elements in it


_BLANK = r"[ \t\r\n]"
_PARENT = "(?:DataValue|Structure|Array)"
_TAG = rf"{_PARENT}Member(?= Name=)|Element(?= Index=)|{_PARENT}(?= DataType=)"
_NAME = r'(?: (?:Name|Index)="(\w+|\[[\d,]{1,30}\])")?'
_TYPE = r'(?: DataType="[\w:]+")?(?: Dimensions="[\d,]+")?(?: Radix="[\w/ ]+")?'
_VALUE = r"""(?: Value="([\w.+#:$'-]+)")?"""
_TEXT = r"((?:(?!\]\]>)[^\x00-\x1f\ufffe\uffff])*+)"
_CHARACTERS = rf"(?:{_BLANK}*<!\[CDATA\[{_TEXT}\]\]>{_BLANK}*(?=</DataValueMember>))?"
_MARK = rf"<({_TAG}){_NAME}{_TYPE}{_VALUE}(/)?>{_CHARACTERS}|</(\w+)>|([^ \t\r\n])"
_ZERO = r'<DataValueMember Name="\w+" DataType="\w+"(?: Radix="[\w/ ]+")? Value="(?:0|0\.0)"/>'
"""A member with the value 0, which is half of all members in an export."""

_MARKS = {
    True: re.compile(rf"{_BLANK}*+(?:{_MARK})", re.ASCII),
    False: re.compile(rf"(?:{_BLANK}|{_ZERO})*+(?:{_MARK})", re.ASCII),
}
"""Patterns that find one tag after another; the key says whether members with the value 0 are found."""

_HEAD, _TAIL = '<Data Format="Decorated">', "</Data>"

_DEEPEST = 200
"""Maximum depth of values; the XML parser allows elements 256 deep."""


def _read(text: str, marks: re.Pattern[str]) -> list[DecoratedValue] | None:
    """Return the values in the text of decorated data; None if it is not in Studio 5000's notation."""
    siblings: list[DecoratedValue] = []
    open_tags: list[str] = []
    outer: list[list[DecoratedValue]] = []  # the siblings of each open element
    for tag, name, value, is_single, characters, closed_tag, stray in marks.findall(
        text, len(_HEAD), len(text) - len(_TAIL)
    ):
        if tag:
            inner: list[DecoratedValue] = []
            siblings.append(DecoratedValue(tag, name, value or None, characters, inner))
            if not is_single:
                open_tags.append(tag)
                outer.append(siblings)
                siblings = inner
        elif stray or len(open_tags) > _DEEPEST or not open_tags or open_tags.pop() != closed_tag:
            return None
        else:
            siblings = outer.pop()
    return None if open_tags else siblings


def _of_element(element: Any) -> list[DecoratedValue]:
    """Return the values in an element."""
    return [
        DecoratedValue(
            child.tag,
            child.get("Index" if child.tag == "Element" else "Name", ""),
            child.get("Value"),
            (child.text or "").strip(),
            _of_element(child),
        )
        for child in element.iterchildren("*")
    ]


class Data:
    """The values of a tag in one form.

    Attributes:
        form: `Decorated`, `L5K`, `String`, …; "" for bytes.
        value: the text of a single value; None for an array, a structure or another form.

    Args:
        cut: the texts that `cut_out` has cut out of the document.
        parse: parses one of these texts, given its first line in the file.
    """

    __slots__ = ("_element", "_parse", "_text", "form", "value")

    def __init__(
        self, element: Any, cut: Sequence[bytes] = (), parse: Callable[[bytes, int], Any] | None = None
    ) -> None:
        self.form: str = element.get("Format", "")
        self._element, self._parse = element, parse
        number = element.get("Cut") if cut else None
        self._text = None if number is None else cut[int(number)]
        match = None if self._text is None else _ONE_VALUE.fullmatch(self._text)
        self.value = None if match is None else match[1].decode()

    @property
    def shows_forces(self) -> bool:
        """Whether its values have forces."""
        if self._text is not None:
            return b"ForceValue" in self._text
        return self.form == "Decorated" and any(
            "ForceValue" in node.attrib for node in self._element.iter("*")
        )

    @property
    def element(self) -> Any:
        """The element, which is parsed again each time if it was cut out."""
        if self._text is None or self._parse is None:
            return self._element
        return self._parse(self._text, self._element.sourceline)

    def values(self, *, zeros: bool) -> list[DecoratedValue]:
        """Return its values; if `zeros` is not set, members with the value 0 may be missing."""
        read = None
        if self._text is not None:
            read = _read(self._text.decode(), _MARKS[zeros])
        return _of_element(self.element) if read is None else read


def cut_out(data: bytes) -> tuple[bytes, list[bytes]]:
    """Cut the decorated data out of a document; return the document and the decorated data.

    Line breaks remain, so lines keep their numbers. Nothing is cut out of a document that has a `Cut`
    attribute, or an unterminated comment, CDATA section or value.
    """
    if _CUT.search(data):
        return data, []
    pieces: list[bytes] = []
    cut: list[bytes] = []
    copied = position = 0  # bytes before `copied` are in the pieces
    while match := _NEXT.search(data, position):
        closing = _CLOSING.get(match.group())
        if closing is None:
            position = _end_of_data(data, match.end())
            block = data[match.start() : position]
            mark = b'<Data Format="Decorated" Cut="%d"/>' % len(cut)
            pieces += [data[copied : match.start()], mark, b"\n" * block.count(b"\n")]
            cut.append(block)
            copied = position
        else:
            position = data.find(closing, match.end())
        if position < 0:
            return data, []
    return b"".join((*pieces, data[copied:])), cut


def _end_of_data(data: bytes, position: int) -> int:
    """Return the end of the `Data` element that contains a position; -1 if the element has no end."""
    while position >= 0:
        match = _END.search(data, position)
        if match is None:
            return -1
        closing = _CLOSING.get(match.group())
        if closing is None:
            return match.end()
        position = data.find(closing, match.end())
    return -1
