"""Finds the cause of a failure: the cause chain of the last output that turned on before the failure."""

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
    """Return the cause chain, as lines, of the last output that turned on before a failure; [] if none.

    The list is also empty for a CPU fault, since the fault itself names its place.

    Args:
        recording: recording of the failing run.
        rack: path of the rack file, used to reload a Python program.
    """
    row = min(broken.scan, len(recording.scans) - 1)
    last_on = None if broken.invariant == NO_FAULT else _last_on(Past(recording, row))
    if last_on is None:
        return []
    changed_row, address = last_on
    try:
        chain = chain_of(recording, job, address, changed_row, load=loading(job, rack))
        return answer_text(chain).splitlines()
    except ValueError as error:
        return [f"(unknown: {error})"]


def _last_on(past: Past) -> tuple[int, str] | None:
    """Return the last row in which an output bit turned on, and its address; None if there is none."""
    changes = [
        (row, word) for word in _output_words(past) for row in past.changes(word.slot, "out", word.word)
    ]
    for row, word in sorted(changes, reverse=True):
        value = past.words(word.slot, "out", row)[word.word]
        earlier_value = past.words(word.slot, "out", row - 1)[word.word] if row else 0
        new_bits = value & ~earlier_value & 0xFFFF
        if new_bits:
            bit = new_bits.bit_length() - 1
            return row, str(Address(word.slot, "O", word.word, bit))
    return None


def _output_words(past: Past) -> Iterator[Address]:
    """Yield the output words with commands or terminals: two for a stepper, all for a card."""
    for slot in past.recording.slots:
        for word in range(2 if slot.is_stepper else len(slot.words.outputs)):
            yield Address(slot.number, "O", word, None)
