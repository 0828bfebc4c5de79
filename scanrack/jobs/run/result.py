"""The Python API's `run` and its result: scans, moves, errors in the manual's words, and the trace."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import field
from pathlib import Path

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import ROWS_AT_ONCE, QuietListener
from scanrack.runtime.loop.rack import Rack
from scanrack.traces.read.event_text import OF_ADAPTERS, describe

from ..load.loading import LoadedRack, load_rack, scans_to_run
from .build import check_ports
from .running import JobRun, RunOptions

UNDER_WAY = "still under way at the end"

RULES_OF_START = frozenset({"CER-01", "POS-01"})
"""Rules that fire at every normal start: no module is configured, and no position is valid."""


@dataclass(slots=True)
class ErrorCount:
    """An error of a module."""

    slot: JsonValue
    rule: JsonValue  # rule of the manual, such as "CMD-03"; for an adapter, the kind of observation
    text: str  # the rule with its bits and words, and the first scan with the error
    count: int = 0


@dataclass(slots=True)
class RunCounters(QuietListener):
    """A listener that counts scans, moves and errors. Its memory use does not grow with the run.

    Attributes:
        moves: number of moves, by (slot, kind, outcome).
        errors: errors by (slot, rule), in order of first appearance.
        of_start: first errors of the rules in `RULES_OF_START`, by (slot, rule).
    """

    scans: int = 0
    moves: Counter[tuple[JsonValue, JsonValue, JsonValue]] = field(default_factory=Counter)
    errors: dict[tuple[JsonValue, JsonValue], ErrorCount] = field(default_factory=dict)
    of_start: dict[tuple[JsonValue, JsonValue], ErrorCount] = field(default_factory=dict)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Count a move or an error."""
        if topic != "/events":
            return
        if fields["kind"] == "move":
            self.moves[fields["slot"], fields["name"], fields.get("outcome", "ended")] += 1
        elif fields["kind"] in ("rule", *OF_ADAPTERS) and fields.get("bits"):
            key = fields["slot"], fields["name"]
            is_of_start = fields["name"] in RULES_OF_START and key not in self.of_start
            errors = self.of_start if is_of_start else self.errors
            errors.setdefault(key, ErrorCount(*key, describe(topic, scan, fields))).count += 1

    def end(self, rack: Rack) -> None:
        """Count the moves in progress at the end of the run."""
        for slot in rack.slots.values():
            kind = getattr(slot.module, "under_way", None)
            if kind is not None:
                self.moves[slot.number, kind, UNDER_WAY] += 1

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Count a scan."""
        self.scans += 1

    @property
    def look(self) -> None:
        """None, since nothing needs to be called within rows."""

    def begin_rows(self, scan: int) -> int:
        """Return the largest number of scans at once; this listener can count any number."""
        return ROWS_AT_ONCE

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Count scans."""
        self.scans += len(images)


@dataclass(frozen=True, slots=True)
class MoveCount:
    """Moves of one kind with one outcome, such as 3 "relative" moves that were "complete"."""

    slot: JsonValue
    kind: JsonValue
    outcome: JsonValue
    count: int


@dataclass(frozen=True, slots=True)
class RunResult:
    """The result of a run."""

    scans: int
    time_ns: int  # machine time of the scans, ns
    moves: list[MoveCount]  # by slot, kind and outcome, including moves in progress at the end
    errors: list[ErrorCount]  # in order of first appearance
    every_start: list[ErrorCount]  # errors that occur in every start, see `RULES_OF_START`
    hints: list[str]
    trace: Path | None  # path of the recording; None without a recording


def result_of(run: JobRun, counters: RunCounters, trace: Path | None) -> RunResult:
    """Return the result of a finished run."""
    counters.end(run.rack)
    moves = [MoveCount(*key, count) for key, count in counters.moves.items()]
    errors, every_start = list(counters.errors.values()), list(counters.of_start.values())
    time_ns = counters.scans * run.cpu.period_ns
    return RunResult(counters.scans, time_ns, moves, errors, every_start, run.hints.sentences(), trace)


def run(
    rack: LoadedRack | str | Path,
    duration: str | None = None,
    *,
    scans: int | None = None,
    trace: str | Path | None = None,
) -> RunResult:
    """Run a rack in virtual time.

    Args:
        rack: a loaded rack (see `load_rack`), or the path of a rack file.
        duration: machine time with a unit, such as "10 s"; by default, `run_for_s` of the rack or 10 s.
        scans: number of scans, instead of `duration`.
        trace: path of the recording; None = no recording.

    Raises:
        ValueError: the rack or program is unusable, the rack uses a real port, or the trace would replace an
            owned file.
        CpuFault: the program, a module or a listener failed; the trace has all scans up to then.
        OSError: the trace can't be written.
    """
    job = rack if isinstance(rack, LoadedRack) else load_rack(rack)
    check_ports(job.spec, realtime=False, live=False)
    count = scans_to_run(job.spec, duration, scans, endless=False)
    path, counters = None if trace is None else Path(trace), RunCounters()
    with ExitStack() as ports:
        job_run = JobRun(job, ports, RunOptions(trace=path, listeners=[counters]))
        job_run.run(count)
    return result_of(job_run, counters, path)
