"""Exports a program in the dialect slc as text; reading the text gives the same program."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scanrack.ladder.lowering.dialects import SLC
from scanrack.ladder.lowering.edited import BEFORE_FIRST, RungEdit
from scanrack.ladder.lowering.program import Program
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import Rung

from .addresses import STRUCTURED
from .addresses import WORDS as INNER
from .datafiles import letters_of
from .document import text_of
from .records import SlcDocument, SlcRungRecord
from .rewriting import rewritten_slc
from .rungs import ROUTINE, RungError, RungReader, rung_text

_PER_LINE = 10  # values per line


def export_text(program: Program, document: SlcDocument | None = None) -> str:
    """Return a program as text; if a document is given, its text with only differing rungs replaced.

    Raises:
        LadderError: the program has another dialect, or the document lacks one of its ladder files.
    """
    if program.dialect != SLC:
        raise LadderError(f"program {program.name} has the dialect {program.dialect}, not {SLC}")
    if document is not None:
        edits = list(_edits(program, document))
        data = rewritten_slc(document.source, edits, (), program.specs).data if edits else document.source
        return text_of(data)
    return "\n".join([f'PROJECT "{program.name}"', *_ladders(program), *_data(program)]) + "\n"


def _edits(program: Program, document: SlcDocument) -> Iterator[RungEdit]:
    """Yield edits where a program's rungs differ from a document's; a refused rung is empty, and is kept."""
    reader = RungReader(program.specs)
    for routine in program.routines:
        name, ladder = routine.name, document.ladders.get(int(routine.name[len(ROUTINE) :]))
        records, new_rungs = ladder.rungs if ladder is not None else [], list(map(str, routine.rungs))
        last = len(records) - 1
        for number, record in enumerate(records):
            if number >= len(new_rungs):
                yield RungEdit(name, number, ())
                continue
            keeps = _keeps(reader, routine.rungs[number], record)
            extra_rungs = new_rungs[number + 1 :] if number == last else []
            if extra_rungs or not keeps:
                yield RungEdit(name, number, (new_rungs[number], *extra_rungs), keeps)
        if new_rungs and not records:
            yield RungEdit(name, BEFORE_FIRST, tuple(new_rungs))


def _keeps(reader: RungReader, rung: Rung, record: SlcRungRecord) -> bool:
    """Whether a rung is the record's, or its refused one."""
    is_refused = not rung.series and rung.origin.line == record.line
    return is_refused or str(rung) == _text(reader, record)


def _text(reader: RungReader, record: SlcRungRecord) -> str:
    """Return a rung in the notation of programs; "" if it can't be read."""
    try:
        return str(Rung(reader.read(record.words)))
    except RungError:
        return ""


def _ladders(program: Program) -> Iterator[str]:
    for routine in program.routines:
        name = f' "{routine.comment}"' if routine.comment else ""
        yield f"LADDER {routine.name[len(ROUTINE) :]}{name}"
        for rung in routine.rungs:
            yield from (f"% {line.replace('%', 'percent')} %" for line in rung.comment.splitlines())
            yield " ".join(f"SOR {rung_text(rung.series, program.builtin)} EOR".split())


def _data(program: Program) -> Iterator[str]:
    for tag in program.declarations:
        if not isinstance(tag, Tag) or not isinstance(tag.initial, list):
            continue
        words = list(_words(tag))
        address = f"{tag.name}.0" if ":" in tag.name else f"{tag.name}:0"
        for offset in range(0, len(words), _PER_LINE):
            yield " ".join(
                [f"DATA {address}" if not offset else "", *words[offset : offset + _PER_LINE]]
            ).strip()


def _words(tag: Tag) -> Iterator[str]:
    letters = letters_of(tag.name)
    values = tag.initial
    assert isinstance(values, Sequence)
    for value in values:
        if letters in STRUCTURED:
            yield from map(str, _three_words(letters, value))
        else:
            yield f'"{value}"' if letters == "ST" else _number(value)


def _number(value: float) -> str:
    if isinstance(value, int) or math.isfinite(value):
        return str(value)
    return "1.#QNAN" if math.isnan(value) else f"{'-' if value < 0 else ''}1.#INF"


def _three_words(letters: str, value: Mapping[str, Any]) -> tuple[int, int, int]:
    flags = sum(1 << bit for bit, name in STRUCTURED[letters].items() if value.get(name))
    flags -= (flags & 1 << 15) << 1
    first, second = (int(value.get(name, 0)) for name in INNER[letters])
    return flags, first, second
