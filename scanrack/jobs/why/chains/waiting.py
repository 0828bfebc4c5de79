"""Explains the wait of a sequence: a missed edge, an input, an axis, or the remaining dwell time."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from scanrack.io_images.times import parse_duration, seconds
from scanrack.ladder.debug import CauseLink
from scanrack.traces.read.sequence_steps import Step

from ..bits import Bits
from ..past import Past
from .python_chain import PythonChain

_DWELL = re.compile(r"dwell ([\d.]+ \w+)")
_EDGE = re.compile(r"(\w+) (rises|falls)")


def open_wait(chain: PythonChain, steps: Sequence[Step], row: int) -> CauseLink | None:
    """Return the link of the last step's wait at a scan; None if it is unknown."""
    step = steps[-1]
    if not step.line:
        return None
    edge = _EDGE.search(step.wait)
    if edge is not None and edge[1] in chain.names.addresses:
        return _edge_link(chain, steps, edge[1], rises=edge[2] == "rises", row=row)
    link = next(_links_of_names(chain, step, row), None)
    return link or _dwell_link(chain, step, row)


def _links_of_names(chain: PythonChain, step: Step, row: int) -> Iterator[CauseLink]:
    """Yield the states of the inputs and axes in a wait's condition."""
    for name in chain.names.named_in(step.wait):
        slot = chain.names.axes.get(name)
        if slot is not None:
            yield chain.of_module(slot, name, row)
        else:
            link = chain.of_bits(Bits.at(chain.place(name)), name, row)
            if link is not None:
                yield link


def _edge_link(
    chain: PythonChain, steps: Sequence[Step], name: str, *, rises: bool, row: int
) -> CauseLink | None:
    """Return the link of an input with an awaited edge; it names an edge that came too early."""
    bits, past = Bits.at(chain.place(name)), Past(chain.recording, row)
    words = chain.slot(bits.slot).words
    edges = [
        change_row
        for change_row in past.changes(bits.slot, bits.image, bits.word, bits.mask)
        if bool(past.words(bits.slot, bits.image, change_row)[bits.word] & bits.mask) is rises
        and not words.configures("in", past.words(bits.slot, "in", change_row))
    ]
    place_at_edge = _place_at_edge(chain, steps, edges[-1]) if edges else ""
    if not place_at_edge:
        link = chain.of_bits(bits, name, row)
        return None if link is None else replace(link, causes=(), depth=1)
    scan, now_ns = chain.recording.numbers[edges[-1]], chain.recording.times[edges[-1]]
    verb, noun = ("rose", "rise") if rises else ("fell", "fall")
    text = f"{verb} at {seconds(now_ns)} s while {place_at_edge}; it needs a new {noun}"
    return CauseLink("input", name, chain.value(bits, row), scan=scan, now_ns=now_ns, text=text)


def _place_at_edge(chain: PythonChain, steps: Sequence[Step], row: int) -> str:
    """Return a phrase for a sequence's line at an edge; "" if the sequence already waited for the edge."""
    scan, waits_now = chain.recording.numbers[row], steps[-1]
    before = [step for step in steps if step.scan < scan]
    previous = before[-1] if before else None
    if previous is None:
        return f"{waits_now.sequence} had not begun"
    if (previous.file, previous.line, previous.wait) == (waits_now.file, waits_now.line, waits_now.wait):
        return ""
    return f"{previous.sequence} was at line {previous.line} ({previous.wait})"


def _dwell_link(chain: PythonChain, step: Step, row: int) -> CauseLink | None:
    """Return the link of a dwell with its remaining time; None if the step waits for something else."""
    dwell = _DWELL.search(step.wait)
    if dwell is None:
        return None
    rest_ns = step.now_ns + parse_duration(dwell[1]) - chain.recording.times[row]
    text = f"runs since {seconds(step.now_ns)} s: {dwell[0]}, done in {seconds(max(rest_ns, 0))} s"
    return CauseLink("timer", step.sequence, None, scan=step.scan, now_ns=step.now_ns, text=text)
