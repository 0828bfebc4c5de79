"""What a run came to, for people: scans, time, moves, errors in the manual's words, the trace."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ..events import JsonValue
from ..pace import Pacer

WIDTH = 14
"""Columns of the titles."""


@dataclass(slots=True)
class SeenError:
    """A rule of the manual that set an error bit.

    Attributes:
        slot: the slot whose module it was.
        rule: the rule's id.
        text: the rule in a sentence.
        section: where the manual has it.
        bits: the status bits that it set.
        first_scan: the first scan that shows it.
        first_ns: when it happened first.
        count: how often it happened.
    """

    slot: JsonValue
    rule: JsonValue
    text: JsonValue
    section: JsonValue
    bits: tuple[str, ...]
    first_scan: int
    first_ns: int
    count: int = 0


@dataclass(slots=True)
class Tally:
    """A listener that counts. What it keeps does not grow with the length of a run.

    Attributes:
        scans: scans so far.
        moves: moves that ended, by (slot, kind, outcome).
        errors: errors by (slot, rule), the first one first.
    """

    scans: int = 0
    moves: Counter[tuple[JsonValue, JsonValue, JsonValue]] = field(default_factory=Counter)
    errors: dict[tuple[JsonValue, JsonValue], SeenError] = field(default_factory=dict)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Count a move or an error."""
        if topic != "/events":
            return
        if fields["kind"] == "move":
            self.moves[fields["slot"], fields["name"], fields.get("outcome", "")] += 1
        bits = fields.get("bits")
        if fields["kind"] == "rule" and isinstance(bits, list) and bits:
            self._error(scan, now_ns, fields, tuple(map(str, bits)))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Count a scan."""
        self.scans += 1

    def close(self) -> None:
        """There is nothing to close."""

    def _error(self, scan: int, now_ns: int, fields: Mapping[str, JsonValue], bits: tuple[str, ...]) -> None:
        slot, rule = fields["slot"], fields["name"]
        first = SeenError(slot, rule, fields["text"], fields.get("section", ""), bits, scan, now_ns)
        self.errors.setdefault((slot, rule), first).count += 1


def seconds(time_ns: int) -> str:
    """Return a time in seconds, exactly.

    >>> seconds(2_240_000_000), seconds(250_000), seconds(0)
    ('2.24 s', '0.00025 s', '0 s')
    """
    whole, rest = divmod(time_ns, 1_000_000_000)
    return f"{whole}.{rest:09d}".rstrip("0").rstrip(".") + " s"


def summary(tally: Tally, period_ns: int, wall_ns: int, pacer: Pacer, trace: Path | None) -> str:
    """Return the closing summary of a run.

    Args:
        tally: what was counted.
        period_ns: time from scan to scan.
        wall_ns: what the run took on the wall clock.
        pacer: what paced it.
        trace: the recording, or None.
    """
    lines = [
        f"{title if first else '':<{WIDTH}}{line}"
        for title, paragraph in (
            ("scans", _scans(tally.scans, wall_ns)),
            ("machine time", _machine_time(tally.scans * period_ns, wall_ns)),
            ("overruns", _overruns(pacer)),
            ("moves", _moves(tally)),
            ("errors", _errors(tally)),
            ("trace", _trace(trace)),
        )
        for first, line in ((index == 0, text) for index, text in enumerate(paragraph))
    ]
    return "\n".join(lines)


def _scans(scans: int, wall_ns: int) -> Iterator[str]:
    rate = scans * 1_000_000_000 // max(wall_ns, 1)
    yield f"{scans:,} ({rate:,} per second)"


def _machine_time(machine_ns: int, wall_ns: int) -> Iterator[str]:
    yield f"{seconds(machine_ns)}, run in {wall_ns / 1e9:.3g} s"


def _overruns(pacer: Pacer) -> Iterator[str]:
    if not pacer.free:
        yield f"{pacer.overruns:,}; latest scan {pacer.worst_late_ns / 1e6:.3g} ms after it was due"


def _moves(tally: Tally) -> Iterator[str]:
    yield f"{tally.moves.total():,}" if tally.moves else "none"
    several = len({slot for slot, _, _ in tally.moves}) > 1
    for (slot, kind, outcome), count in tally.moves.items():
        yield f"{f'slot {slot}: ' if several else ''}{count:,} {kind}: {outcome}"


def _errors(tally: Tally) -> Iterator[str]:
    if not tally.errors:
        yield "none"
    for error in tally.errors.values():
        yield f"{', '.join(error.bits)}: {error.text} [{error.rule}, {error.section}]"
        times = "once" if error.count == 1 else f"{error.count:,} times, first"
        yield f"    slot {error.slot}, {times} at {seconds(error.first_ns)}, scan {error.first_scan}"


def _trace(trace: Path | None) -> Iterator[str]:
    if trace is None:
        yield "not recorded"
    else:
        yield f"{trace} ({trace.stat().st_size:,} bytes)"
