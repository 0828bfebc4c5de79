"""Reads exports: rungs with their lines, data files with their values, and slots.

    START Bul.1766  % MicroLogix 1400 Series B %
    SLOT 1 OTHER 3 10 25  % an axis %  SCAN_IN 8 SCAN_OUT 8    a 3601: card of vendor 3, type 10, code 25
    PROJECT "feeder"
       2 "MAIN"                                                names of ladder files
    LADDER 2
    % Rung: 0 %
    SOR XIC I:0/0 OTE O:0/0 EOR
    % TITLE/RUNG DESCRIPTION                     for the rung above, up to a line that ends in %
    RUNG DESCRIPTION: starts the pump
    %
    DATA N7:0
    % N7:0  %      60      0     -3 0XFFF0                       values from N7:0 on
    % N7:10 %       7
    DATA T4:0
    % .CTL   .PRE   .ACC    %
    0XA200     60     60 % T4:0  %               bits, PRE, ACC of a timer
    DATA ST9:0
    % ST9:0 %
    "a text"
    FORCE O:03
    0X0000 0XFFFF % FORCE O:3.0 %

Text between two % is a comment. In DATA, a comment has the address of the values on its line. Values without
an address follow the previous values. A header names the first element. In the older form
`DATA N7:5 1 2 3 4 5 6`, it names the last element if there is a value for it and each element before it
[9323-PA2E, p. 5-19]. `DATA ...N7:5` always names the first element.

A rung extends from SOR to EOR, over any number of lines. Other lines are noted.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from scanrack.io_images.input_files import open_input
from scanrack.io_images.site import Site
from scanrack.ladder.model.errors import LadderError

from .lines import WORD, Line, lines_of
from .records import DataRecord, DataRow, LadderRecord, Other, SlcDocument, SlcRungRecord, SlotRecord

MOST_BYTES = 4 * 1024 * 1024
"""Maximum size of a file, in bytes; an SLC 500 has 64 K words of program memory."""

MOST_RUNGS = 65_536
"""Maximum number of rungs in a file."""


class SlcError(LadderError):
    """The file is not an export of RSLogix 500."""


_LADDER = re.compile(r'(?:LADDER|LAD)(?:\s+FILE)?\s+(?:LAD\s*)?(\d{1,3})\b[\s:-]*"?([^"]*?)"?', re.IGNORECASE)
_SLOT = re.compile(r"SLOT\s+(\d{1,3})\b\s*(.*)", re.IGNORECASE)
_DATA = re.compile(
    r"(?:DATA(?:\s*FILE)?\b\s*(?P<dots>\.{3})?\s*#?(?P<file>[A-Z]{1,5}\s*\d{0,3})|#?(?P<bare>[A-Z]{1,3}\d{0,3}))"
    r"\s*[:;]\s*(?P<element>\d{1,3})(?:\.(?P<word>\d{1,2}))?(?![\w/:.])\s*(?P<values>.*)",
    re.IGNORECASE,
)
_FORCE = re.compile(r"FORCE\s+(?:\.{3}\s*)?[IO]\s*:.*", re.IGNORECASE)
_PROJECT = re.compile(r'(?:START\s+)?PROJECT\s+"?([^"]*?)"?', re.IGNORECASE)
_FILE_NAME = re.compile(r'(\d{1,3})\s+"([^"]*)"')
_PROCESSOR = re.compile(r'(?:START|PROC(?:ESSOR)?(?:_TYPE)?)[\s=]+"?([^"]*?)"?', re.IGNORECASE)
_IGNORED = re.compile(r"(?:START|END)\b.*", re.IGNORECASE)
_VALUE = re.compile(
    r'[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?|[+-]?1\.#\w+|0X[0-9A-F]+|[0-9A-F]+h|"[^"]*"|16#[0-9A-F]+',
    re.IGNORECASE,
)
DESCRIPTION = re.compile(r"^\s*(?:TITLE/RUNG DESCRIPTION|TITLE:|RUNG DESCRIPTION:)", re.MULTILINE)
"""Headings of the parts of a rung's description."""
_SETTINGS = re.compile(r"(?:(?:[A-Z][A-Z0-9_]+|[+-]?\d+|0X[0-9A-F]+)\s*)++")
"""A line with a slot's settings: numbers and their names."""
_NOT_FORCED = ["0X0000", "0XFFFF"]  # mask of bits forced on, and mask of bits not forced off
_NUMBERED = re.compile(r"RUNG\s*:?\s*\d+", re.IGNORECASE)  # a comment that only numbers the next rung


def read_document(path: Path | str) -> SlcDocument:
    """Read an export from a file.

    Raises:
        SlcError: the file is unreadable, too long, not text, or has no rungs.
    """
    file = Path(path)
    try:
        with open_input(file) as stream:
            data = stream.read(MOST_BYTES + 1)
    except FileNotFoundError:
        raise SlcError(f"{path}: no such file") from None
    except OSError as error:
        raise SlcError(f"{path}: the file can't be read: {error.strerror}") from None
    return document_in(data, str(path), file.stem)


def document_in(data: bytes, file: str, name: str) -> SlcDocument:
    """Read the bytes of an export, see `parse_document`.

    Raises:
        SlcError: the bytes are too many, are not text, or have no rungs.
    """
    if len(data) > MOST_BYTES:
        raise SlcError(f"{file}: the file has more than {MOST_BYTES:,} bytes")
    if b"\0" in data:
        raise SlcError(f"{file}: this is not text: export the program as text, with SOR and EOR")
    return replace(parse_document(text_of(data), file, name), source=data)


def text_of(data: bytes) -> str:
    """Decode text; RSLogix 500 writes Windows-1252, and other software writes UTF-8."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def parse_document(text: str, file: str, name: str) -> SlcDocument:
    """Read the text of an export; `name` is the default project name.

    Raises:
        SlcError: the text has no rung.
    """
    document = _SlcReader(text, SlcDocument(file, name, source=text.encode(errors="replace"))).read()
    if not any(ladder.rungs for ladder in document.ladders.values()):
        raise SlcError(f"{file}: no rung in it: SOR ... EOR")
    return document


class _SlcReader:
    """Reads lines into a document."""

    def __init__(self, text: str, document: SlcDocument) -> None:
        self._text = text
        self._document = document
        self._names: dict[int, str] = {}  # names of ladder files
        # the current section: at most one of slot, data, forces and an unknown section, and a ladder file
        self._ladder: LadderRecord | None = None
        self._slot: SlotRecord | None = None
        self._data: DataRecord | None = None
        self._element: int | None = None  # of the next values in DATA; None after the previous ones
        self._in_forces = self._in_unknown = False
        # the current rung
        self._comments: list[str] = []  # before it
        self._words: list[str] | None = None  # None outside of a rung
        self._first_line = 0
        self._rung_count = 0

    def read(self) -> SlcDocument:
        """Read all lines; return the document."""
        for line in lines_of(self._text):
            if self._words is None and not line.begins_rung:
                self._read_line(line)
                continue
            for word in line.words:
                self._read_word(line.number, word)
        self._end_rung(whole=False)
        for number, name in self._names.items():
            if number in self._document.ladders and not self._document.ladders[number].name:
                self._document.ladders[number].name = name
        return self._document

    # --- rungs

    def _read_word(self, number: int, word: str) -> None:
        """Add a word to a rung; SOR begins a new rung even if EOR is missing."""
        mark = word.upper()
        if mark == "SOR":
            self._end_rung(whole=False)
            self._words, self._first_line = [], number
        elif self._words is None:
            self._document.others.append(Other(number, word))
        elif mark == "EOR":
            self._end_rung(whole=True, end=number)
        else:
            self._words.append(word)

    def _end_rung(self, *, whole: bool, end: int = 0) -> None:
        """Store the rung being read, if any.

        Args:
            whole: whether it ends in EOR.
            end: its last line; 0 if it is incomplete.
        """
        if self._words is not None:
            self._add_rung(self._words, self._first_line, end, whole=whole)
        self._words = None

    def _add_rung(self, words: list[str], line: int, end: int, *, whole: bool) -> None:
        """Add a rung to the current ladder file, with the comments before it; end the current section."""
        self._end_section()
        self._rung_count += 1
        if self._rung_count > MOST_RUNGS:
            site = Site(file=self._document.file, line=line)
            raise SlcError.at(site, f"the file has more than {MOST_RUNGS:,} rungs")
        comment = "\n".join(self._comments)
        self._comments = []
        self._ladder_file(None).rungs.append(SlcRungRecord(tuple(words), line, comment, whole, end))

    def _ladder_file(self, number: int | None, name: str = "") -> LadderRecord:
        """Return the ladder file with a number; for None, return the current one, by default file 2."""
        if number is None and self._ladder is not None:
            return self._ladder
        file_number = 2 if number is None else number
        self._ladder = self._document.ladders.setdefault(file_number, LadderRecord(file_number, name))
        return self._ladder

    def _add_comment(self, comment: str) -> None:
        """Keep a comment for the next rung; a description belongs to the previous rung."""
        without_headings = DESCRIPTION.sub("\n", comment)
        text = "\n".join(filter(None, map(str.strip, without_headings.splitlines())))
        if not text or _NUMBERED.fullmatch(text):
            return
        rungs = self._ladder.rungs if self._ladder is not None else []
        if without_headings != comment and rungs and not self._comments:
            joined = "\n".join(filter(None, (rungs[-1].comment, text)))
            rungs[-1] = replace(rungs[-1], comment=joined)
        else:
            self._comments.append(text)

    # --- other lines

    def _end_section(self) -> None:
        """End the current section, except the ladder file."""
        self._slot = self._data = self._element = None
        self._in_forces = self._in_unknown = False

    def _read_line(self, line: Line) -> None:
        """Read a line outside of rungs: a heading, values, settings, or comments; note an unknown line."""
        text = line.plain
        if self._data is not None:
            element = self._element_in(line)
            self._element = self._element if element is None else element
        elif not text:
            for comment in line.comments:
                self._add_comment(comment)
        if text and not (self._begin_section(line, text) or self._continue_section(line, text)):
            file = self._data.file if self._data is not None else ""
            self._end_section()
            self._in_unknown = True
            if not _IGNORED.fullmatch(text):
                self._document.others.append(Other(line.number, text, file))

    def _begin_section(self, line: Line, plain: str) -> bool:
        """Begin a section if the line is a heading, or store a name; return whether the line was either."""
        document = self._document
        if match := _LADDER.fullmatch(plain):
            self._end_section()
            self._comments = []
            self._ladder_file(int(match[1]), match[2].strip()).line = line.number
        elif match := _SLOT.fullmatch(plain):
            self._end_section()
            comment = " ".join(remark.strip() for remark in line.comments)
            self._slot = SlotRecord(int(match[1]), match[2].strip(), line.number, comment)
            if self._slot.number in document.slots:
                document.others.append(Other(line.number, plain))
            document.slots.setdefault(self._slot.number, self._slot)
        elif match := _DATA.fullmatch(plain):
            self._end_section()
            self._data = _data_record(match, line.number)
            document.data.append(self._data)
            self._add_values(line.number, match["values"], self._element_in(line))
        elif _FORCE.fullmatch(plain):
            self._end_section()
            self._in_forces = True
        elif match := _PROJECT.fullmatch(plain):
            self._end_section()
            document.name = match[1].strip() or document.name
        elif match := _PROCESSOR.fullmatch(plain):
            self._end_section()
            words = " ".join((match[1], *line.comments)).split()
            document.processor = " ".join(dict.fromkeys(words))
        elif self._data is None and (match := _FILE_NAME.fullmatch(plain)):
            self._names[int(match[1])] = match[2].strip()
        else:
            return False
        return True

    def _continue_section(self, line: Line, plain: str) -> bool:
        """Continue the current section; return whether the line belongs to it."""
        are_values = all(map(_VALUE.fullmatch, WORD.findall(plain)))
        if self._data is not None and are_values:
            self._add_values(line.number, plain, self._element)
            self._element = None
        elif self._in_forces and are_values:
            if list(map(str.upper, line.words)) != _NOT_FORCED:
                self._document.forces.append((line.number, " ".join(line.comments).strip() or plain))
        elif self._slot is not None and _SETTINGS.fullmatch(plain):
            self._slot = replace(self._slot, settings=f"{self._slot.settings} {plain}")
            self._document.slots[self._slot.number] = self._slot
        else:
            return self._in_unknown and are_values
        return True

    def _add_values(self, number: int, text: str, element: int | None) -> None:
        """Add the values in a line to the current data file; note its other words as unknown."""
        assert self._data is not None
        words = WORD.findall(text)
        values = tuple(word for word in words if _VALUE.fullmatch(word))
        if values:
            self._data.rows.append(DataRow(element, number, values))
        unread_words = (word for word in words if not _VALUE.fullmatch(word))
        self._document.others += [Other(number, word, self._data.file) for word in unread_words]

    def _element_in(self, line: Line) -> int | None:
        """Return the element, or image word, in the address of a line's comment; None if it has none."""
        assert self._data is not None
        for comment in line.comments:
            match = _DATA.fullmatch(comment.strip())
            record = None if match is None or match["values"] else _data_record(match, 0)
            if record is not None and record.file == self._data.file:
                return record.element
        return None


def _data_record(match: re.Match[str], line: int) -> DataRecord:
    """Return the record for a heading or an address; a slot's image is a file, and its words are elements."""
    name = re.sub(r"\s", "", (match["file"] or match["bare"]).upper())
    element = int(match["element"])
    if name in ("I", "O"):
        return DataRecord(f"{name}:{element}", int(match["word"] or 0), line, first=True)
    return DataRecord(name, element, line, bool(match["dots"]))
