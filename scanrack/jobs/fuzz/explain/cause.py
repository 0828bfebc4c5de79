"""Finds the cause of a failure: the cause chain of the last output that came on before it."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.addresses import Address
from scanrack.ladder.debug import answer_text
from scanrack.traces.replay import PackedTrace

from ...bench.opening import loading
from ...load.loading import LoadedRack
from ...why.chains.of_run import chain_of
from ...why.past import Past
from ..run import NO_FAULT, BrokenInvariant


def cause_of(recording: PackedTrace, job: LoadedRack, rack: str, broken: BrokenInvariant) -> list[str]:
    """Return the cause chain of the last output that came on before a failure; [] without one.

    The list is empty for a CPU fault, which states its own place.

    Args:
        recording: recording of the failing run.
        rack: path of the rack file, from which a Python program is loaded again.
    """
    row = min(broken.scan, len(recording.scans) - 1)
    change = None if broken.invariant == NO_FAULT else _last_on(Past(recording, row))
    if change is None:
        return []
    changed, address = change
    try:
        return answer_text(chain_of(recording, job, address, changed, load=loading(job, rack))).splitlines()
    except ValueError as error:
        return [f"(not known: {error})"]


def _last_on(past: Past) -> tuple[int, str] | None:
    """Return the last row in which an output bit came on, and its address; None without one."""
    rows = [(row, place) for place in _words(past) for row in past.changes(place.slot, "out", place.word)]
    for row, place in sorted(rows, reverse=True):
        now = past.words(place.slot, "out", row)[place.word]
        before = past.words(place.slot, "out", row - 1)[place.word] if row else 0
        came = now & ~before & 0xFFFF
        if came:
            bit = came.bit_length() - 1
            return row, str(Address(place.slot, "O", place.word, bit))
    return None


def _words(past: Past) -> Iterator[Address]:
    """Yield the words that hold commands or terminals: two of a stepper, all of a card."""
    for slot in past.recording.slots:
        for word in range(2 if slot.is_stepper else len(slot.words.outputs)):
            yield Address(slot.number, "O", word, None)
