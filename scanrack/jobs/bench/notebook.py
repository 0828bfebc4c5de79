"""Shows a bench in a notebook: scan, module status, last events, and the rungs with their power flow."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from scanrack.io_images.static_html import card, line, rows

if TYPE_CHECKING:
    from scanrack.io_images.module_words import ModuleWords

    from .slot import SlotBench

EVENTS = 5
RUNGS = 20
"""Maximum number of events, and of rungs, to show."""


def as_html(
    name: str, now: str, slots: Iterable[tuple[SlotBench, ModuleWords]], events: Sequence[object], logic: Any
) -> str:
    """Return a bench as HTML: its slots with named words, the last events, the program.

    Args:
        name: title of the bench.
        now: text of its scan and time.
    """
    parts = [line(now), *(_slot(slot, words) for slot, words in slots)]
    parts.append(rows([str(event)] for event in events[-EVENTS:]))
    return card(name, *parts, _rungs(logic))


def _slot(slot: SlotBench, names: ModuleWords) -> str:
    """Return a slot as HTML: its status, and its words by name."""
    status_html = getattr(slot.status, "_repr_html_", None)
    status = line(str(slot.status)) if status_html is None else status_html()
    words = zip(names.inputs, slot.inputs, names.outputs, slot.outputs, strict=True)
    table = (
        (f"in {input_name}", f"{input_word:,}", f"out {output_name}", f"{output_word:,}")
        for input_name, input_word, output_name, output_word in words
    )
    return line(f"slot {slot.number}") + status + rows(table)


def _rungs(logic: Any) -> str:
    """Return the first routine of a ladder program as HTML, with the power flow in the last scan."""
    if not hasattr(logic, "truth"):
        return ""
    from scanrack.ladder.draw import captions_of, routines_svg

    routine = logic.routine_now(logic.program.routines[0].name)
    captions = captions_of(logic.program)
    truths = {routine.name: logic.truth(routine.name)}
    return routines_svg([(routine, list(routine.numbers)[:RUNGS])], truths=truths, captions=captions)
