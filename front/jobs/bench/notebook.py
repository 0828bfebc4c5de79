"""A bench as a notebook shows it: scan, each module's status, the program with its power, the last events."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ...io_images.static_html import card, line, rows

if TYPE_CHECKING:
    from ...io_images.module_words import ModuleWords
    from .bench import Bench
    from .slot import SlotBench

EVENTS = 5
RUNGS = 20
"""Most events, and most rungs, that are shown."""


def as_html(bench: Bench) -> str:
    """Return a bench as HTML."""
    parts = [line(f"scan {bench.scans:,}, {bench.now_s:g} s")]
    words = {slot.number: slot.words for slot in bench.spec.slot}
    parts += (_slot(slot, words[number]) for number, slot in bench.slot.items())
    parts.append(rows([str(each)] for each in bench.told[-EVENTS:]))
    return card(bench.spec.name, *parts, _rungs(bench.logic))


def _slot(slot: SlotBench, names: ModuleWords) -> str:
    """Return a slot: its status, and its words by name."""
    own = getattr(slot.status, "_repr_html_", None)
    status = line(str(slot.status)) if own is None else own()
    images = zip(names.inputs, slot.inputs, names.outputs, slot.outputs, strict=True)
    table = ((f"in {one}", f"{value:,}", f"out {other}", f"{sent:,}") for one, value, other, sent in images)
    return line(f"slot {slot.number}") + status + rows(table)


def _rungs(logic: Any) -> str:
    """Return the first routine of a ladder program with the power of the last scan."""
    if not hasattr(logic, "truth"):
        return ""
    from ...ladder.draw import captions_of, routines_svg

    first = logic.routine_now(logic.program.routines[0].name)
    captions = captions_of(logic.program.add_ons.values())
    truths = {first.name: logic.truth(first.name)}
    return routines_svg([(first, list(first.numbers)[:RUNGS])], truths=truths, captions=captions)
