"""The XML of values, most of a document: cut out of it, and parsed tag by tag.

As elements values take sixteen times the memory of their text.

    <Data Format="Decorated"> ... </Data>   becomes   <Data Format="Decorated" Cut="0"/>
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

_MARK = re.compile(rb"Cut\s*=")
_NEXT = re.compile(rb'<!\[CDATA\[|<!--|<Data Format="Decorated">')
_END = re.compile(rb"<!\[CDATA\[|<!--|</Data>")
_CLOSING = {b"<![CDATA[": b"]]>", b"<!--": b"-->"}
_ONE_VALUE = re.compile(
    rb'<Data Format="Decorated">\s*<DataValue DataType="\w+"(?: Radix="[\w/ ]+")?'
    rb' Value="([\w.+-]+)"/>\s*</Data>'
)


_ZERO = re.compile(rb'<DataValueMember Name="\w+" DataType="\w+"(?: Radix="[\w/ ]+")? Value="(?:0|0\.0)"/>')
"""A member that is 0: half of the members of an export."""


class Data:
    """The values of a tag in one form.

    Attributes:
        form: `Decorated`, `L5K`, `String`, …; "" for bytes.
        value: the text of a single value if nothing else is in it, else None.
    """

    __slots__ = ("_element", "_parse", "_text", "form", "value")

    def __init__(
        self, element: Any, cut: Sequence[bytes] = (), parse: Callable[[bytes, int], Any] | None = None
    ) -> None:
        self.form: str = element.get("Format", "")
        self._element, self._parse = element, parse
        number = element.get("Cut") if cut else None
        self._text = None if number is None else cut[int(number)]
        one = None if self._text is None else _ONE_VALUE.fullmatch(self._text)
        self.value = None if one is None else one[1].decode()

    @property
    def shows_forces(self) -> bool:
        """Whether forces are beside its values."""
        if self._text is not None:
            return b"ForceValue" in self._text
        return self.form == "Decorated" and any(
            "ForceValue" in each.attrib for each in self._element.iter("*")
        )

    @property
    def element(self) -> Any:
        """The element; parsed again each time if it was cut out."""
        if self._text is None or self._parse is None:
            return self._element
        return self._parse(self._text, self._element.sourceline)

    @property
    def other_than_zero(self) -> Any:
        """The element without those members that are 0, as far as it was cut out."""
        if self._text is None or self._parse is None:
            return self._element
        return self._parse(_ZERO.sub(b"", self._text), self._element.sourceline)


def cut_out(data: bytes) -> tuple[bytes, list[bytes]]:
    """Return a document with as many lines but without values, and its values."""
    if _MARK.search(data):
        return data, []
    kept: list[bytes] = []
    cut: list[bytes] = []
    done = at = 0
    while found := _NEXT.search(data, at):
        closing = _CLOSING.get(found.group())
        if closing is None:
            at = _end_of_data(data, found.end())
            whole = data[found.start() : at]
            mark = b'<Data Format="Decorated" Cut="%d"/>' % len(cut)
            kept += [data[done : found.start()], mark, b"\n" * whole.count(b"\n")]
            cut.append(whole)
            done = at
        else:
            at = data.find(closing, found.end())
        if at < 0:
            return data, []
    return b"".join((*kept, data[done:])), cut


def _end_of_data(data: bytes, at: int) -> int:
    """Return the end of values that begin before `at`, -1 without one."""
    while found := _END.search(data, at):
        closing = _CLOSING.get(found.group())
        if closing is None:
            return found.end()
        at = data.find(closing, found.end())
        if at < 0:
            return -1
    return -1
