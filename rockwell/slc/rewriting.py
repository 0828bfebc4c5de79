"""Writes edited rungs into the text of an export; all other lines stay unchanged.

A rung consists of its lines, from SOR to EOR, the comments before it, and its description after it.

    % starts the pump %                        a comment of the rung below
    SOR XIC I:1.0/0 OTE B3:0/0 EOR
    % RUNG DESCRIPTION: ... %                  a description of the rung above

A changed rung keeps its comments; a deleted one loses them.
"""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from scanrack.ladder.lowering.edited import BEFORE_FIRST, NewTag, Rewritten, RungEdit, changes_of
from scanrack.ladder.lowering.text import parse_rung
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.spec import Spec, Use

from .addresses import is_address, parse
from .document import DESCRIPTION, parse_document
from .lines import lines_of
from .records import LadderRecord, SlcRungRecord
from .rungs import FILES, ROUTINE, ROUTINE_WORD, read_operand, routine_name, rung_text

_BEGIN = re.compile(r"([A-Z_]\w*)\(", re.IGNORECASE)
_COMMENT = r"%[^%]*%"
_RUNG = re.compile(rf"{_COMMENT}|\bSOR\b(?:{_COMMENT}|(?!\bEOR\b)[^%])*+\bEOR\b", re.IGNORECASE)
"""A rung, or a comment before or after it."""


def program_text(text: str, specs: Mapping[str, Spec]) -> str:
    """Return a rung in the notation of programs; its addresses may be those of RSLogix 500.

    >>> from scanrack.ladder.instructions.slc import SLC_SPECS
    >>> program_text("XIC(B3/17)COP(#N7:0,#N7:[N7:9],5);", SLC_SPECS)
    'XIC(B3:1/1)COP(N7:0,N7[N7:9],5);'
    """
    pieces, position = [], 0
    while (match := _BEGIN.search(text, position)) is not None:
        words, end = _operands(text, match.end())
        spec = specs.get(match[1].upper())
        operands = [
            _word(match[1].upper(), spec.use_at(place) if spec else None, word)
            for place, word in enumerate(words)
        ]
        pieces += [text[position : match.end()], ",".join(operands)]
        position = end
    return "".join([*pieces, text[position:]])


def _operands(text: str, at: int) -> tuple[list[str], int]:
    """Return the operands of an instruction that begin at a place, and where they end."""
    words, depth = [""], 0
    while at < len(text) and (depth or text[at] != ")"):
        depth += (text[at] in "([") - (text[at] in ")]")
        if text[at] == "," and not depth:
            words.append("")
        else:
            words[-1] += text[at]
        at += 1
    return words, at


def _word(name: str, use: Use | None, word: str) -> str:
    """Return an operand in the notation of programs; an unreadable operand is returned unchanged."""
    word = word.strip()
    if name == "JSR" and (match := ROUTINE_WORD.fullmatch(word)):
        return routine_name(int(match[1]))
    try:
        if use in (Use.EXPRESSION, Use.CONDITION):
            return str(read_operand(use, word))
        return str(parse(word, file=use in FILES)) if is_address(word) else word
    except LadderError:
        return word


def rewritten_slc(
    data: bytes, edits: Sequence[RungEdit], tags: Sequence[NewTag], specs: Mapping[str, Spec]
) -> Rewritten:
    """Return an export with edited rungs, and a list of its changes.

    Args:
        data: an export that can be read, see `document`.
        edits: their texts are in the program's notation, see `EditedProgram`.
        tags: always empty, because an export has data files instead of tags.
        specs: specs of the program's instructions.

    Raises:
        LadderError: the file has no such rung, or a rung shares a line with another one.
    """
    if tags:
        raise LadderError(f"{tags[0].name} is no data file: create it in RSLogix 500")
    encoding = "utf-8"
    try:
        text = data.removeprefix(BOM_UTF8).decode()
    except UnicodeDecodeError:
        encoding = "cp1252"
        text = data.decode(encoding, errors="surrogateescape")
    ladders = parse_document(text, "", "").ladders
    lines, places = text.splitlines(keepends=True), dict(_places(text, ladders.values()))
    newline = "\r\n" if "\r\n" in text else "\n"
    changes: list[_Change] = []
    for edit in edits:
        ladder = _ladder_of(edit, ladders)
        texts = [
            f"SOR {rung_text(parse_rung(new_text, specs=specs).series, specs)} EOR" for new_text in edit.texts
        ]
        place = places.get((ladder.number, max(edit.rung, 0)))
        line_index = ladder.line if place is None else place.begin
        if place is not None and edit.rung != BEFORE_FIRST:
            line_index = place.end
            changes += _replaced(lines, place, texts[:1], keeps=edit.keeps)
            texts = texts[1:]
        added = "".join(f"{new_text}{newline}" for new_text in texts)
        if added and line_index >= len(lines) and not text.endswith("\n"):
            added = newline + added
        changes.append((line_index, line_index, added))
    for first, end, new in sorted(changes, key=lambda change: change[:2], reverse=True):
        lines[first:end] = [new]
    encoded = "".join(lines).encode(encoding, errors="surrogateescape")
    byte_order_mark = BOM_UTF8 * data.startswith(BOM_UTF8)
    return Rewritten(byte_order_mark + encoded, tuple(changes_of(edits, tags)))


def _ladder_of(edit: RungEdit, ladders: Mapping[int, LadderRecord]) -> LadderRecord:
    """Return the ladder file of an edit, or raise a LadderError if it has no such rung."""
    number = edit.routine[len(ROUTINE) :]
    ladder = ladders.get(int(number)) if number.isdigit() else None
    if ladder is None or not BEFORE_FIRST <= edit.rung < len(ladder.rungs):
        raise LadderError(f"routine {edit.routine} has no rung {edit.rung} in the file")
    return ladder


_Change = tuple[int, int, str]
"""The first line to replace, the one after the last, and the new text."""


def _replaced(
    lines: Sequence[str], place: _RungLines, rung: Sequence[str], *, keeps: bool
) -> Iterator[_Change]:
    """Yield the change that removes or replaces a rung; if the edit keeps the rung, there is none."""
    if not rung:
        yield place.begin, place.end, ""
    elif not keeps:
        rung_lines = "".join(lines[place.first : place.last])
        yield place.first, place.last, _with_rung(rung_lines, rung[0])


def _with_rung(lines: str, rung: str) -> str:
    """Return the lines of a rung with the rung replaced; comments on these lines stay."""
    return _RUNG.sub(lambda found: found[0] if found[0].startswith("%") else rung, lines)


class _RungLines(NamedTuple):
    """Line numbers of a rung, from 0: of its comments, of SOR, after EOR, and after its description."""

    begin: int
    first: int
    last: int
    end: int


def _places(text: str, ladders: Iterable[LadderRecord]) -> Iterator[tuple[tuple[int, int], _RungLines]]:
    """Yield the lines of each rung by the numbers of ladder file and rung.

    Raises:
        LadderError: two rungs share a line.
    """
    lines = list(lines_of(text))
    ends = {line.number: after.number for line, after in pairwise(lines)}
    known_lines = {line.number: line for line in lines}
    last = len(text.splitlines()) + 1

    def skip_blank(number: int) -> int:
        """Return the first line that is not empty, starting at `number`."""
        while (line := known_lines.get(number)) is not None and not (line.words or line.comments):
            number = ends.get(number, last)
        return number

    def after_comments(number: int, *, described: bool) -> int:
        """Skip the comments that begin at `number`: those that describe the rung above, or the others."""
        while (line := known_lines.get(skip_blank(number))) is not None and not line.words:
            if any(map(DESCRIPTION.search, line.comments)) is not described:
                break
            number = ends.get(line.number, last)
        return number

    for ladder in ladders:
        begin = ladder.line + 1
        for number, rung in enumerate(ladder.rungs):
            if not rung.whole or _shares(rung, ladder.rungs[number + 1 : number + 2]):
                raise LadderError(f"line {rung.line}: put each rung into its own lines, from SOR to EOR")
            end = after_comments(rung.end + 1, described=True)
            start = begin if skip_blank(after_comments(begin, described=False)) >= rung.line else rung.line
            yield (ladder.number, number), _RungLines(start - 1, rung.line - 1, rung.end, end - 1)
            begin = end


def _shares(rung: SlcRungRecord, after: Sequence[SlcRungRecord]) -> bool:
    return any(follower.line <= rung.end for follower in after)
