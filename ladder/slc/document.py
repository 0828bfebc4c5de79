"""An export as records: every rung with its line, every data file with its values, every slot.

    PROJECT "feeder"
    PROCESSOR 1766-L32BXB
    SLOT 1 OTHER 3 10 25              // an I/O card by vendor, type and code: a 3601
    LADDER 2 "MAIN"
    % starts the pump %               // a comment on the rung below
    SOR XIC I:0/0 OTE O:0/0 EOR
    DATA N7:0
    % N7:0 % 0 1 2 3 4 5 6 7 8 9      // values; the address between % % is a comment
    DATA T4:0 0 500 0                 // bits, PRE, ACC of each timer

A rung goes from SOR to EOR, over as many lines as it takes. Other lines are noted.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import LadderError

MOST_BYTES = 4 * 1024 * 1024
"""Bytes of a file; an SLC 500 has 64 K words for its program."""

MOST_RUNGS = 65_536
"""Rungs of a file."""


class SlcError(LadderError):
    """A file that is not an export of RSLogix 500."""


@dataclass(frozen=True, slots=True)
class RungRecord:
    """A rung.

    Attributes:
        words: the words between SOR and EOR.
        line: its line.
        comment: what the comments before it say.
        whole: whether it ends in EOR.
    """

    words: tuple[str, ...]
    line: int
    comment: str = ""
    whole: bool = True

    @property
    def text(self) -> str:
        """Its text as it is exported."""
        return " ".join(("SOR", *self.words, *(["EOR"] if self.whole else [])))


@dataclass(slots=True)
class LadderRecord:
    """A ladder file.

    Attributes:
        number: its number, 2 for the main one.
        name: its name, "" without one.
        rungs: its rungs.
    """

    number: int
    name: str = ""
    rungs: list[RungRecord] = field(default_factory=list)


@dataclass(slots=True)
class DataRecord:
    """Values of a data file.

    Attributes:
        address: the first element.
        line: its line.
        values: as written.
    """

    address: str
    line: int
    values: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class SlotRecord:
    """What sits in a slot."""

    number: int
    text: str
    line: int

    @property
    def is_3601(self) -> bool:
        """Whether it is an AMCI 3601: by its name, or as I/O card of vendor 3, type 10, code 25."""
        numbers = tuple(map(int, re.findall(r"(?<![\w.-])\d+(?![\w.-])", self.text)))
        card = any(numbers[at : at + 3] == (3, 10, 25) for at in range(len(numbers)))
        return card or "3601" in self.text


@dataclass(slots=True)
class Document:
    """An export.

    Attributes:
        file: its name in messages.
        name: name of the project.
        processor: what PROCESSOR says.
        ladders: by number.
        data: values of data files, in their order.
        slots: by number.
        others: other lines, with their numbers.
    """

    file: str
    name: str
    processor: str = ""
    ladders: dict[int, LadderRecord] = field(default_factory=dict)
    data: list[DataRecord] = field(default_factory=list)
    slots: dict[int, SlotRecord] = field(default_factory=dict)
    others: list[tuple[int, str]] = field(default_factory=list)


_COMMENT = re.compile(r"%([^%]*)%")
_WORD = re.compile(r'"[^"]*"|\S+')
_LADDER = re.compile(r'(?:LADDER|LAD)(?:\s+FILE)?\s+(?:LAD\s*)?(\d{1,3})\b[\s:-]*"?([^"]*?)"?', re.IGNORECASE)
_SLOT = re.compile(r"SLOT\s+(\d{1,3})\b\s*(.*)", re.IGNORECASE)
_DATA = re.compile(
    r"(?:DATA(?:\s*FILE)?\s+)?#?([A-Z]{1,3}\d{0,3}:\d{1,3}(?:\.\d{1,2})?)\b\s*(.*)", re.IGNORECASE
)
_PROJECT = re.compile(r'(?:START\s+)?PROJECT\s+"?([^"]*?)"?', re.IGNORECASE)
_PROCESSOR = re.compile(r'PROC(?:ESSOR)?(?:_TYPE)?[\s=]+"?([^"]*?)"?', re.IGNORECASE)
_ENDS = re.compile(r"(?:START|END)\b.*", re.IGNORECASE)
_VALUE = re.compile(r'[+-]?[\d.]+(?:E[+-]?\d+)?|[0-9A-F]+h|"[^"]*"|16#[0-9A-F]+', re.IGNORECASE)


def read_document(path: Path | str) -> Document:
    """Read an export from a file.

    Raises:
        SlcError: it can't be read, is too long, is not text, or has no rung.
    """
    file = Path(path)
    try:
        data = file.read_bytes()
    except FileNotFoundError:
        raise SlcError(f"{path}: there is no such file") from None
    except OSError as error:
        raise SlcError(f"{path}: the file can't be read: {error.strerror}") from None
    if len(data) > MOST_BYTES:
        raise SlcError(f"{path}: the file has {len(data):,} bytes; {MOST_BYTES:,} are allowed")
    if b"\0" in data:
        raise SlcError(f"{path}: this is not text: export the program as text, with SOR and EOR")
    return parse_document(data.decode("utf-8-sig", errors="replace"), str(path), file.stem)


def parse_document(text: str, file: str, name: str) -> Document:
    """Read the text of an export.

    Args:
        text: the text.
        file: its name in messages.
        name: name of the project, unless the text says it.

    Raises:
        SlcError: it has no rung.
    """
    document = _Reader(text, Document(file, name)).read()
    if not any(each.rungs for each in document.ladders.values()):
        raise SlcError(f"{file}: there is no rung in it: SOR ... EOR")
    return document


class _Reader:
    """Reads line by line."""

    def __init__(self, text: str, document: Document) -> None:
        self._lines = text.splitlines()
        self._document = document
        self._ladder: LadderRecord | None = None
        self._data: DataRecord | None = None
        self._comment: list[str] = []
        self._words: list[str] | None = None
        self._begun = self._count = 0

    def read(self) -> Document:
        """Read all lines."""
        for number, line in enumerate(self._lines, 1):
            if self._words is None:
                plain = self._without_comments(line)
                if not plain.upper().startswith("SOR"):
                    if plain:
                        self._line(number, plain)
                    continue
            for word in _WORD.findall(_COMMENT.sub(" ", line)):
                self._word(number, word)
        self._end(whole=False)
        return self._document

    def _word(self, number: int, word: str) -> None:
        """Go on with a rung; SOR begins another one, also where EOR is missing."""
        mark = word.upper()
        if mark == "SOR":
            self._end(whole=False)
            self._words, self._begun = [], number
        elif self._words is None:
            self._document.others.append((number, word))
        elif mark == "EOR":
            self._end(whole=True)
        else:
            self._words.append(word)

    def _end(self, *, whole: bool) -> None:
        """Take the present rung, if there is one."""
        if self._words is not None:
            self._rung(self._words, self._begun, whole=whole)
        self._words = None

    def _rung(self, words: list[str], line: int, *, whole: bool) -> None:
        self._data = None
        self._count += 1
        if self._count > MOST_RUNGS:
            raise SlcError(f"{self._document.file}:{line}: there are more than {MOST_RUNGS:,} rungs")
        comment = "\n".join(self._comment)
        self._comment = []
        self._file(None).rungs.append(RungRecord(tuple(words), line, comment, whole))

    def _file(self, number: int | None, name: str = "") -> LadderRecord:
        """Return the present ladder file, or go on with that of a number; file 2 without one."""
        if number is None and self._ladder is not None:
            return self._ladder
        wanted = 2 if number is None else number
        self._ladder = self._document.ladders.setdefault(wanted, LadderRecord(wanted, name))
        return self._ladder

    def _without_comments(self, line: str) -> str:
        """Return what a line says; keep its comments for the next rung."""
        found = [each.strip() for each in _COMMENT.findall(line)]
        plain = _COMMENT.sub(" ", line).split("//")[0].strip()
        if not plain:
            self._comment += [each for each in found if each]
        return plain

    def _line(self, number: int, line: str) -> None:
        document = self._document
        if found := _LADDER.fullmatch(line):
            self._data = None
            self._file(int(found.group(1)), found.group(2).strip())
        elif found := _SLOT.fullmatch(line):
            slot = int(found.group(1))
            document.slots.setdefault(slot, SlotRecord(slot, found.group(2).strip(), number))
        elif found := _DATA.fullmatch(line):
            self._data = DataRecord(found.group(1).upper(), number, list(_values(found.group(2))))
            document.data.append(self._data)
        elif found := _PROJECT.fullmatch(line):
            document.name = found.group(1).strip() or document.name
        elif found := _PROCESSOR.fullmatch(line):
            document.processor = found.group(1).strip()
        elif self._data is not None and all(map(_VALUE.fullmatch, _WORD.findall(line))):
            self._data.values += _values(line)
        elif not _ENDS.fullmatch(line):
            document.others.append((number, line))


def _values(text: str) -> Iterator[str]:
    return (each for each in _WORD.findall(text) if _VALUE.fullmatch(each))
