"""Exports a program in the dialect slc as text; reading the text returns the same program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from scanrack.ladder.lowering.dialects import SLC
from scanrack.ladder.lowering.edited import BEFORE_FIRST, RungEdit
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import Rung

from .addresses import STRUCTURED, WORDS
from .datafiles import letters_of
from .document import text_of
from .records import SlcDocument, SlcRungRecord
from .rewriting import rewritten_slc
from .rungs import ROUTINE, RungError, RungReader, rung_text

_PER_LINE = 10  # values per line


def export_text(program: Program, document: SlcDocument | None = None) -> str:
    """Return a program as text.

    Args:
        document: the export that the program comes from; only rungs that differ are replaced in its text.

    Raises:
        LadderError: the program has another dialect, or the document lacks one of its ladder files.
    """
    if program.dialect != SLC:
        raise LadderError(f"program {program.name} has the dialect {program.dialect}, not {SLC}")
    if document is not None:
        edits = list(_edits(program, document))
        data = rewritten_slc(document.source, edits, (), program.specs).data if edits else document.source
        return text_of(data)
    return "\n".join([f'PROJECT "{program.name}"', *_ladder_lines(program), *_data_lines(program)]) + "\n"


def _edits(program: Program, document: SlcDocument) -> Iterator[RungEdit]:
    """Yield the edits that turn a document's rungs into a program's; added rungs follow the last rung."""
    reader = RungReader(program.specs)
    for routine in program.routines:
        ladder = document.ladders.get(int(routine.name[len(ROUTINE) :]))
        records = ladder.rungs if ladder is not None else []
        rungs, texts = routine.rungs, list(map(str, routine.rungs))
        for number, record in enumerate(records):
            if number >= len(texts):
                yield RungEdit(routine.name, number, ())
                continue
            is_same = _is_same(reader, rungs[number], record)
            added = texts[number + 1 :] if number == len(records) - 1 else []
            if added or not is_same:
                yield RungEdit(routine.name, number, (texts[number], *added), keeps=is_same)
        if texts and not records:
            yield RungEdit(routine.name, BEFORE_FIRST, tuple(texts))


def _is_same(reader: RungReader, rung: Rung, record: SlcRungRecord) -> bool:
    """Return whether a rung is unchanged since it was read; a refused rung was read as an empty one."""
    if not rung.series and rung.origin.line == record.line:
        return True
    try:
        return str(rung) == str(Rung(reader.read(record.words)))
    except RungError:
        return False


def _ladder_lines(program: Program) -> Iterator[str]:
    """Yield the lines of all ladder files: heading, and each rung after its comments."""
    for routine in program.routines:
        name = f' "{routine.comment}"' if routine.comment else ""
        yield f"LADDER {routine.name[len(ROUTINE) :]}{name}"
        for rung in routine.rungs:
            yield from (f"% {line.replace('%', 'percent')} %" for line in rung.comment.splitlines())
            yield " ".join(f"SOR {rung_text(rung.series, program.builtin)} EOR".split())


def _data_lines(program: Program) -> Iterator[str]:
    """Yield the lines of all data files with values; only the first line of a file has the heading."""
    for tag in program.declarations:
        if not isinstance(tag, Tag) or not isinstance(tag.initial, list):
            continue
        values = list(_values_of(tag))
        heading = f"DATA {tag.name}.0 " if ":" in tag.name else f"DATA {tag.name}:0 "
        for offset in range(0, len(values), _PER_LINE):
            yield heading + " ".join(values[offset : offset + _PER_LINE])
            heading = ""


def _values_of(tag: Tag) -> Iterator[str]:
    """Yield the values of a data file as text."""
    letters = letters_of(tag.name)
    assert isinstance(tag.initial, list)
    for value in tag.initial:
        if letters in STRUCTURED:
            yield from map(str, _three_words(letters, value))
        else:
            yield f'"{value}"' if letters == "ST" else _number(value)


def _number(value: float) -> str:
    """Return a number as text, in the Windows notation if it is not finite."""
    if isinstance(value, int) or math.isfinite(value):
        return str(value)
    return "1.#QNAN" if math.isnan(value) else f"{'-' if value < 0 else ''}1.#INF"


def _three_words(letters: str, value: Mapping[str, Any]) -> tuple[int, int, int]:
    """Return the words of a timer, counter or control."""
    flags = sum(1 << bit for bit, name in STRUCTURED[letters].items() if value.get(name))
    flags -= (flags & 1 << 15) << 1  # words are signed
    first, second = (int(value.get(name, 0)) for name in WORDS[letters])
    return flags, first, second
