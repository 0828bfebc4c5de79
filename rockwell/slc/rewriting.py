"""Writes edited rungs into the text of an export; all other lines remain unchanged.

A rung consists of its lines from SOR to EOR, the comments before them, and the description after them.

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
from .records import LadderRecord
from .rungs import FILES, ROUTINE, ROUTINE_WORD, read_operand, routine_name, rung_text

_BEGIN = re.compile(r"([A-Z_]\w*)\(", re.IGNORECASE)
_COMMENT = r"%[^%]*%"
_RUNG = re.compile(rf"{_COMMENT}|\bSOR\b(?:{_COMMENT}|(?!\bEOR\b)[^%])*+\bEOR\b", re.IGNORECASE)
"""A rung, or a comment before or after it."""


def program_text(text: str, specs: Mapping[str, Spec]) -> str:
    """Return a rung in the notation of programs; its addresses can be in RSLogix 500 notation.

    >>> from scanrack.ladder.instructions.slc import SLC_SPECS
    >>> program_text("XIC(B3/17)COP(#N7:0,#N7:[N7:9],5);", SLC_SPECS)
    'XIC(B3:1/1)COP(N7:0,N7[N7:9],5);'
    """
    pieces, position = [], 0
    while (match := _BEGIN.search(text, position)) is not None:
        words, end = _operands(text, match.end())
        spec = specs.get(match[1].upper())
        operands = [
            _operand_text(match[1].upper(), spec.use_at(index) if spec else None, word)
            for index, word in enumerate(words)
        ]
        pieces += [text[position : match.end()], ",".join(operands)]
        position = end
    return "".join([*pieces, text[position:]])


def _operands(text: str, begin: int) -> tuple[list[str], int]:
    """Return the operands of an instruction, which begin at a position, and the position where they end."""
    words, depth, position = [""], 0, begin
    while position < len(text) and (depth or text[position] != ")"):
        character = text[position]
        depth += (character in "([") - (character in ")]")
        if character == "," and not depth:
            words.append("")
        else:
            words[-1] += character
        position += 1
    return words, position


def _operand_text(name: str, use: Use | None, word: str) -> str:
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
        data: a valid export, see `document`.
        edits: edited rungs, with texts in the notation of `EditedProgram`.
        tags: must be empty, because an export has data files instead of tags.
        specs: specs of the program's instructions.

    Raises:
        LadderError: the file has no such rung, or a rung shares a line with another one.
    """
    if tags:
        raise LadderError(f"{tags[0].name} is not a data file: create it in RSLogix 500")
    text, encoding = _decoded(data)
    ladders = parse_document(text, "", "").ladders
    lines, rung_lines = text.splitlines(keepends=True), dict(_lines_of_rungs(text, ladders.values()))
    newline = "\r\n" if "\r\n" in text else "\n"
    changes: list[_Change] = []
    for edit in edits:
        ladder = _ladder_of(edit, ladders)
        texts = _slc_texts(edit, specs)
        # `position` is the line before which new rungs are added; a ladder file may have no rung yet
        rung = rung_lines.get((ladder.number, max(edit.rung, 0)))
        position = ladder.line if rung is None else rung.begin
        if rung is not None and edit.rung != BEFORE_FIRST:
            position = rung.end
            if not texts:
                changes.append(_Change(rung.begin, rung.end, ""))
            elif not edit.keeps:
                text_of_rung = "".join(lines[rung.first : rung.last])
                changes.append(_Change(rung.first, rung.last, _with_rung(text_of_rung, texts[0])))
            texts = texts[1:]
        added = "".join(f"{new_text}{newline}" for new_text in texts)
        if added and position >= len(lines) and not text.endswith("\n"):
            added = newline + added
        changes.append(_Change(position, position, added))
    # from the end of the file, so that the indexes of earlier lines stay valid
    for begin, end, new_text in sorted(changes, key=lambda change: (change.begin, change.end), reverse=True):
        lines[begin:end] = [new_text]
    encoded = "".join(lines).encode(encoding, errors="surrogateescape")
    byte_order_mark = BOM_UTF8 * data.startswith(BOM_UTF8)
    return Rewritten(byte_order_mark + encoded, tuple(changes_of(edits, tags)))


def _decoded(data: bytes) -> tuple[str, str]:
    """Return the text of an export and its encoding, UTF-8 or else cp1252."""
    try:
        return data.removeprefix(BOM_UTF8).decode(), "utf-8"
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="surrogateescape"), "cp1252"


def _slc_texts(edit: RungEdit, specs: Mapping[str, Spec]) -> list[str]:
    """Return the rungs of an edit in the notation of an export."""
    trees = [parse_rung(new_text, specs=specs) for new_text in edit.texts]
    return [f"SOR {rung_text(tree.series, specs)} EOR" for tree in trees]


def _ladder_of(edit: RungEdit, ladders: Mapping[int, LadderRecord]) -> LadderRecord:
    """Return the ladder file of an edit; raise a LadderError if the file has no such rung."""
    number = edit.routine[len(ROUTINE) :]
    ladder = ladders.get(int(number)) if number.isdigit() else None
    if ladder is None or not BEFORE_FIRST <= edit.rung < len(ladder.rungs):
        raise LadderError(f"routine {edit.routine} has no rung {edit.rung} in the file")
    return ladder


class _Change(NamedTuple):
    """New text for some lines, by their indexes."""

    begin: int
    end: int  # exclusive
    text: str


def _with_rung(lines: str, rung: str) -> str:
    """Return the lines of a rung with the rung replaced; comments on these lines remain."""
    return _RUNG.sub(lambda match: match[0] if match[0].startswith("%") else rung, lines)


class _RungLines(NamedTuple):
    """Indexes of the lines of a rung."""

    begin: int  # of its comments
    first: int  # of SOR
    last: int  # after EOR
    end: int  # after its description


def _lines_of_rungs(
    text: str, ladders: Iterable[LadderRecord]
) -> Iterator[tuple[tuple[int, int], _RungLines]]:
    """Yield the lines of each rung by the numbers of ladder file and rung.

    Raises:
        LadderError: two rungs share a line.
    """
    lines = list(lines_of(text))
    next_numbers = {line.number: following.number for line, following in pairwise(lines)}
    by_number = {line.number: line for line in lines}
    after_last = len(text.splitlines()) + 1

    def skip_blank(number: int) -> int:
        """Return the number of the first nonempty line, starting at `number`."""
        while (line := by_number.get(number)) is not None and not (line.words or line.comments):
            number = next_numbers.get(number, after_last)
        return number

    def after_comments(number: int, *, descriptions: bool) -> int:
        """Skip comments (only descriptions, or only other comments); return the number of the next line."""
        while (line := by_number.get(skip_blank(number))) is not None and not line.words:
            if any(map(DESCRIPTION.search, line.comments)) is not descriptions:
                break
            number = next_numbers.get(line.number, after_last)
        return number

    for ladder in ladders:
        begin = ladder.line + 1
        for number, rung in enumerate(ladder.rungs):
            following = ladder.rungs[number + 1 : number + 2]
            if not rung.whole or (following and following[0].line <= rung.end):
                raise LadderError(f"line {rung.line}: put each rung into its own lines, from SOR to EOR")
            end = after_comments(rung.end + 1, descriptions=True)
            # other lines may stand between the last rung and this one: then its comments stay with them
            has_comments_only = skip_blank(after_comments(begin, descriptions=False)) >= rung.line
            first = begin if has_comments_only else rung.line
            yield (ladder.number, number), _RungLines(first - 1, rung.line - 1, rung.end, end - 1)
            begin = end
