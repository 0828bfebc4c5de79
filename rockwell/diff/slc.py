"""Reads RSLogix 500 text as an outline of ladder files, data files, slots, forces, and other lines."""

from __future__ import annotations

from collections.abc import Iterator

from ..slc.addresses import STRUCTURED, WORDS
from ..slc.datafiles import letters_of
from ..slc.datavalues import placed_rows
from ..slc.document import document_in
from ..slc.records import DataRecord, LadderRecord, SlcDocument, SlcRungRecord
from ..slc.rungs import routine_name
from .outline import LINE, RUNG, Item, Step


def outline_of_slc(data: bytes, file: str) -> Item:
    """Read an export of RSLogix 500; raise an SlcError if it has no rung."""
    document = document_in(data, file, "")
    root = Item("export", "", 1)
    root.fields += [("project", document.name), ("processor", document.processor)]
    for number, record in enumerate(document.others):
        root.steps.append(Step(LINE, number, record.text, " ".join(record.text.split()), "", record.line))
    root.items += map(_ladder, document.ladders.values())
    root.items += _data_files(document.data)
    root.items += _slots(document)
    for line, text in document.forces:
        root.items.append(Item("force", text, line))
    return root


def _ladder(ladder: LadderRecord) -> Item:
    """Return a ladder file as a routine with its rungs."""
    item = Item("routine", routine_name(ladder.number), ladder.line)
    item.fields.append(("name", ladder.name))
    item.steps += (_step(number, rung) for number, rung in enumerate(ladder.rungs))
    return item


def _step(number: int, rung: SlcRungRecord) -> Step:
    return Step(RUNG, number, rung.text, rung.text, rung.comment, rung.line)


def _data_files(records: list[DataRecord]) -> Iterator[Item]:
    """Yield data files with a field for each value."""
    files: dict[str, Item] = {}
    for record in records:
        item = files.setdefault(record.file, Item("data file", record.file, record.line))
        item.fields += _elements(record)
    yield from files.values()


def _elements(record: DataRecord) -> Iterator[tuple[str, str]]:
    """Yield the address and the value of each word in a data file."""
    letters = letters_of(record.file)
    words = (".CTL", *(f".{word}" for word in WORDS[letters])) if letters in STRUCTURED else ("",)
    separator = "." if ":" in record.file else ":"
    for first_element, row in placed_rows(record, len(words)):
        for index, value in enumerate(row.values):
            element, word = divmod(index, len(words))
            yield f"{record.file}{separator}{first_element + element}{words[word]}", value


def _slots(document: SlcDocument) -> Iterator[Item]:
    """Yield each slot of the chassis with its card, comment and settings."""
    for slot in document.slots.values():
        item = Item("slot", str(slot.number), slot.line)
        item.fields.append(("card", " ".join(slot.text.split())))
        item.fields.append(("comment", slot.comment))
        item.fields.append(("settings", " ".join(slot.settings.split())))
        yield item
