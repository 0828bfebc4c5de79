"""The summary of a run: scans, time, moves, errors with the manual's text, and the trace."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from scanrack.io_images.times import milliseconds, seconds
from scanrack.jobs.run.result import RunResult
from scanrack.jobs.run.running import JobRun
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.pace import LATE_FROM_NS, Pacer
from scanrack.terminal.status import size_of
from scanrack.traces.read.event_text import move_wording

WIDTH = 14


def summary(
    result: RunResult, wall_ns: int, pacer: Pacer, stubs: Sequence[str] = (), sequences: Sequence[str] = ()
) -> str:
    """Return the closing summary of a run; titles without lines are omitted."""
    paragraphs: dict[str, Iterable[str]] = {
        "scans": _scans(result.scans, wall_ns),
        "machine time": [f"{seconds(result.time_ns)} s, run in {wall_ns / 1e9:.3g} s"],
        "overruns": _overruns(pacer),
        "late scans": _late_scans(pacer),
        "moves": _moves(result),
        "errors": _errors(result),
        "normal start": _start(result),
        "sequences": sequences,
        "stubs": stubs,
        "hints": result.hints,
        "trace": _trace(result.trace),
    }
    lines = []
    for title, paragraph in paragraphs.items():
        for index, text in enumerate(paragraph):
            lines.append(f"{title if index == 0 else '':<{WIDTH}}{text}")
    return "\n".join(lines)


def summary_row(run: JobRun, result: RunResult, took_ns: int) -> dict[str, object]:
    """Return the summary for --json; times are in ns."""
    cpu = run.cpu
    fault = cpu.fault and {"scan": cpu.fault.scan, "now_ns": cpu.fault.now_ns, **cpu.fault.fields}
    return {
        "scans": result.scans,
        "time_ns": result.time_ns,
        "took_ns": took_ns,
        "overruns": cpu.pacer.overruns,
        "worst_late_ns": cpu.pacer.worst_late_ns,
        "fault": fault,
        "moves": [asdict(move) for move in result.moves],
        "errors": [asdict(error) for error in result.errors],
        "every_start": [asdict(start) for start in result.every_start],
        "sequences": run.steps,
        "stubs": run.stubs,
        "hints": result.hints,
        "trace": None if result.trace is None else str(result.trace),
    }


def _scans(scans: int, wall_ns: int) -> Iterator[str]:
    rate = scans * 1_000_000_000 // max(wall_ns, 1)
    yield f"{scans:,} ({rate:,} per second)"


def _overruns(pacer: Pacer) -> Iterator[str]:
    if not pacer.free:
        yield f"{pacer.overruns:,}; latest scan {pacer.worst_late_ns / 1e6:.3g} ms after it was due"


def _late_scans(pacer: Pacer) -> Iterator[str]:
    """Yield lines with the number of late scans, in total and by how late they were."""
    if pacer.free:
        return
    late, scans = sum(pacer.late[1:]), sum(pacer.late)
    yield f"{late:,} of {scans:,} ({late / max(scans, 1):.2%})" if late else "none"
    bounds = [f"{milliseconds(bound_ns)} ms" for bound_ns in LATE_FROM_NS]
    for count, lowest, next_up in zip(pacer.late[1:], bounds, [*bounds[1:], None], strict=True):
        if count:
            yield f"  {count:,} by {lowest} " + ("or more" if next_up is None else f"to {next_up}")


def _moves(result: RunResult) -> Iterator[str]:
    yield f"{sum(moved.count for moved in result.moves):,}" if result.moves else "none"
    for move in result.moves:
        yield f"  {_slot_prefix(move.slot, result)}{move.count:,} {move_wording(move.kind, move.outcome)}"


def _errors(result: RunResult) -> Iterator[str]:
    total = sum(error.count for error in result.errors)
    yield f"{total:,}" if total else "none"
    for error in result.errors:
        times = f", {error.count:,} times in all" if error.count > 1 else ""
        yield f"  {_slot_prefix(error.slot, result)}{error.text}{times}"


def _start(result: RunResult) -> Iterator[str]:
    """Yield a row for each rule that fires at every normal start."""
    for start in result.every_start:
        yield f"{_slot_prefix(start.slot, result)}{start.text}"


def _slot_prefix(slot: JsonValue, result: RunResult) -> str:
    """Return "slot N, ", or "" if all moves and errors of the run belong to one slot."""
    slots = {
        *(move.slot for move in result.moves),
        *(entry.slot for entry in result.errors + result.every_start),
    }
    return f"slot {slot}, " if len(slots) > 1 else ""


def _trace(trace: Path | None) -> Iterator[str]:
    if trace is None:
        yield "not recorded"
    else:
        yield f"{trace} ({size_of(trace)})"
