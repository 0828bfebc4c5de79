"""Describes the changes in one scan of a run: new events, and changes in status and commands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from scanrack.io_images.amci3601.words import may_be_stepper, profile_of
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ..invariants.scan_view import SlotSnapshot
from ..run import TrialBench
from ..scenarios.parts import Lasting, parts_of, scenario_of
from ..scenarios.scenario import Scenario
from ..scenarios.words import described

MOST_LISTED = 6
"""Maximum number of listed changes."""

Names = dict[str, frozenset[str]]
"""Names of the bits that are on, by owner, such as "slot 1"."""


def changes_in(bench: TrialBench, scenario: Scenario, scan: int) -> tuple[str, ...]:
    """Return phrases for the events that begin in a scan and for the status and command changes in it."""
    views: list[_BitView] = []

    def listeners(_spec: RackSpec, rack: Rack, _logic: ScanLogic) -> Iterable[QuietListener]:
        views[:] = [_BitView(rack, scan)]
        return views

    replace(bench, invariants=(), scans=scan + 1).run(scenario, listeners=listeners)
    phrases = [*_new_events(scenario, scan, bench.spec.scan_ns), *views[0].phrases()]
    return tuple(phrases[:MOST_LISTED])


def _new_events(scenario: Scenario, scan: int, scan_ns: int) -> list[str]:
    """Return a description of each event that begins between the previous scan and this one."""
    begin_ns, end_ns = (scan - 1) * scan_ns, scan * scan_ns
    parts = [
        (name, part)
        for name, part in parts_of(scenario)
        if isinstance(part, Lasting) and begin_ns < part.at_ns <= end_ns
    ]
    return described(scenario_of(parts)) if parts else []


class _BitView(QuietListener):
    """Records the names of the bits that are on in a scan and in the previous scan."""

    def __init__(self, rack: Rack, scan: int) -> None:
        self._scan, self._previous_bits, self._bits = scan, Names(), Names()
        self._slots = {number: slot for number, slot in rack.slots.items() if may_be_stepper(slot.words)}

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record the bits if this is one of the two scans."""
        if scan == self._scan - 1:
            self._previous_bits = self._read_bits()
        elif scan == self._scan:
            self._bits = self._read_bits()

    def _read_bits(self) -> Names:
        """Return the status bits and the commands of each 3601 that are on now."""
        names = Names()
        for number, slot in self._slots.items():
            status_names = profile_of(slot.words).status_names(slot.inputs[0], slot.inputs[1])
            names[f"slot {number}"] = frozenset(status_names)
            snapshot = SlotSnapshot(slot)
            command_names = {"configuration"} if snapshot.configuring else set(snapshot.commands)
            names[f"the commands of slot {number}"] = frozenset(command_names)
        return names

    def phrases(self) -> Iterator[str]:
        """Yield phrases for the bits that turned on, and for the bits that turned off."""
        yield from _phrases(self._bits, self._previous_bits, "came on")
        yield from _phrases(self._previous_bits, self._bits, "went off")


def _phrases(bits: Names, other_bits: Names, verb: str) -> Iterator[str]:
    """Yield a phrase for each owner with bits that are on in one scan and off in the other."""
    for owner, names in bits.items():
        changed_names = sorted(names - other_bits.get(owner, frozenset()))
        if changed_names:
            yield f"{' and '.join(changed_names)} of {owner} {verb}"
