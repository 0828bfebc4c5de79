"""The summary of a run for people: scans, time, moves, errors in the manual's words, the trace."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from ...jobs.run.result import RunResult, Tally
from ...jobs.run.running import JobRun
from ...runtime.loop.events import JsonValue
from ...runtime.loop.pace import LATE_FROM_NS, Pacer
from ...traces.read.event_text import move_wording

WIDTH = 14


def seconds(time_ns: int) -> str:
    """Return a time in seconds, exactly.

    >>> seconds(2_240_000_000), seconds(250_000), seconds(0)
    ('2.24 s', '0.00025 s', '0 s')
    """
    whole, rest = divmod(time_ns, 1_000_000_000)
    return f"{whole}.{rest:09d}".rstrip("0").rstrip(".") + " s"


def summary(
    tally: Tally,
    period_ns: int,
    wall_ns: int,
    pacer: Pacer,
    trace: Path | None,
    hints: Sequence[str] = (),
    stubs: Sequence[str] = (),
    sequences: Sequence[str] = (),
) -> str:
    """Return the closing summary of a run."""
    lines = [
        f"{title if first else '':<{WIDTH}}{line}"
        for title, paragraph in (
            ("scans", _scans(tally.scans, wall_ns)),
            ("machine time", [f"{seconds(tally.scans * period_ns)}, run in {wall_ns / 1e9:.3g} s"]),
            ("overruns", _overruns(pacer)),
            ("late scans", _late_scans(pacer)),
            ("moves", _moves(tally)),
            ("errors", _errors(tally)),
            ("every start", _start(tally)),
            ("sequences", iter(sequences)),
            ("stubs", iter(stubs)),
            ("hints", iter(hints)),
            ("trace", _trace(trace)),
        )
        for first, line in ((index == 0, text) for index, text in enumerate(paragraph))
    ]
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
        "moves": [asdict(each) for each in result.moves],
        "errors": [asdict(each) for each in result.errors],
        "every_start": [asdict(each) for each in result.every_start],
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
    """Yield the number of late scans, by size."""
    if pacer.free:
        return
    late, scans = sum(pacer.late[1:]), sum(pacer.late)
    yield f"{late:,} of {scans:,} ({late / max(scans, 1):.2%})" if late else "none"
    bounds = [f"{bound_ns / 1e6:g} ms" for bound_ns in LATE_FROM_NS]
    for count, lowest, next_up in zip(pacer.late[1:], bounds, [*bounds[1:], None], strict=True):
        if count:
            yield f"  {count:,} by {lowest} " + ("or more" if next_up is None else f"to {next_up}")


def _moves(tally: Tally) -> Iterator[str]:
    yield f"{tally.moves.total():,}" if tally.moves else "none"
    for (slot, kind, outcome), count in tally.moves.items():
        yield f"  {_of(slot, tally)}{count:,} {move_wording(kind, outcome)}"


def _errors(tally: Tally) -> Iterator[str]:
    total = sum(error.count for error in tally.errors.values())
    yield f"{total:,}" if total else "none"
    for (slot, _), error in tally.errors.items():
        often = f", {error.count:,} times in all" if error.count > 1 else ""
        yield f"  {_of(slot, tally)}{error.sentence}{often}"


def _start(tally: Tally) -> Iterator[str]:
    """Yield the rules of a normal start, which are not among the errors."""
    for (slot, _), seen in tally.of_start.items():
        yield f"{_of(slot, tally)}{seen.sentence}"


def _of(slot: JsonValue, tally: Tally) -> str:
    return f"slot {slot}, " if tally.slots > 1 else ""


def _trace(trace: Path | None) -> Iterator[str]:
    if trace is None:
        yield "not recorded"
    else:
        yield f"{trace} ({trace.stat().st_size:,} bytes)"
