"""Replay of a recording into a module, a program or a rack."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

import typer
from scanrack.jobs.captures.words import is_sampled
from scanrack.jobs.load.loading import load_job, load_spec
from scanrack.jobs.replay.replaying import (
    Replay,
    check_slots,
    forced_rows,
    plan_of,
    with_stimuli,
    without_missing_slots,
)
from scanrack.jobs.replay.resumed import configuration_words
from scanrack.jobs.replay.resumed_operation import ResumedOperation
from scanrack.jobs.replay.targets import ReplayTarget, Stimuli
from scanrack.jobs.trust.attachments import job_of, spec_of
from scanrack.runtime.config.rackspec import KEPT_TRACES, RackSpec
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.progress import shown_progress
from scanrack.terminal.reading import print_notes
from scanrack.traces.files.keeping import RecordingKeeper, check_recordings
from scanrack.traces.read.reader import Trace, open_trace
from scanrack.traces.replay import PackedTrace
from scanrack.traces.write.recorder import ScanRecorder

from .compare_job import print_comparison, tolerance
from .comparison_options import ReplayOptions

REPLAY = "replay"
"""Name of the second recording in the report."""


def replay_trace(options: ReplayOptions) -> None:
    """Replay and check for differences; stop at the first scan that differs.

    Raises:
        typer.Exit: with the status of the command, unless it is 0.
    """
    with reported_mistakes():
        tolerances = tolerance(options.tolerance_time, options.tolerance_counts)
        keeping = None
        if options.record is not None:
            keeping = None if options.replace else RecordingKeeper(options.record, KEPT_TRACES)
            check_recordings([options.record], keeping, {options.path: "the trace"})
        with open_trace(options.path) as trace, tempfile.TemporaryDirectory() as folder:
            recording = PackedTrace.of(trace)
            try:
                spec, logic = _rack_and_logic(trace, Path(folder), options)
            finally:
                print_notes(trace)
            left_out: list[str] = []
            resumed = None
            if options.into is ReplayTarget.MODULE:
                spec, left_out = without_missing_slots(recording, spec)
                facts = trace.head.metadata
                resumed = ResumedOperation(
                    recording,
                    simulated={slot.number: slot.firmware for slot in spec.slot if slot.module == "amci3601"},
                    forced=forced_rows(plan_of(recording)),
                    configuration=configuration_words(options.configuration),
                    captured=facts.get("source") == "capture",
                    sampled=is_sampled(facts),
                )
            elif options.configuration is not None:
                raise ValueError("--configuration needs --into module")
            begins_late = resumed is not None and bool(resumed.slots)
            stimuli = options.stimuli or _DEFAULT[options.into, begins_late]
            slots = check_slots(recording, spec, options.slot)
            on_machine = with_stimuli(
                spec, recording, stimuli, resumed.active_high if resumed is not None else {}
            )
            exact = stimuli is not Stimuli.INPUTS
            replay = Replay(
                recording,
                spec=on_machine,
                logic=logic,
                into=options.into,
                slots=slots,
                resumed=resumed,
                exact_inputs=exact,
            )
            replay.notes[:0] = left_out
            observed = partial(shown_progress, quiet=options.quiet)
            period_ns = int(trace.head.metadata["scan_period_ns"])
            with _recorder(options.record, keeping, replay, recording, period_ns) as recorders:
                follower = replay.run(
                    tolerances, to_the_end=options.to_the_end, observed=observed, recorders=recorders
                )
        if follower.stopped:
            total = len(recording.scans)
            replay.notes.append(
                f"stopped after {follower.scans:,} of {total:,} scans; --to-the-end continues"
            )
        print_notes(replay)
        status = print_comparison(follower.comparison(), (options.path.name, REPLAY), as_json=options.as_json)
    raise typer.Exit(status)


@contextmanager
def _recorder(
    target: Path | None,
    keeping: RecordingKeeper | None,
    replay: Replay,
    recording: PackedTrace,
    period_ns: int,
) -> Iterator[list[ScanRecorder]]:
    """Record a replay, if there is a target; yield a list with the recorder, or an empty list."""
    if target is None:
        yield []
        return
    facts = {"name": target.stem, "source": REPLAY}
    recorder = ScanRecorder(
        target,
        replay.rack.memory,
        recording.slots,
        scan_period_ns=period_ns,
        metadata=facts,
        keeping=keeping,
    )
    with closing(recorder):
        yield [recorder]


_DEFAULT = {
    (ReplayTarget.MODULE, False): Stimuli.MACHINE,
    (ReplayTarget.MODULE, True): Stimuli.INPUTS,
    (ReplayTarget.PROGRAM, False): Stimuli.MACHINE,
    (ReplayTarget.RACK, False): Stimuli.RECORDED,
}
"""The default stimuli, by target and by whether a module was in operation before the recording."""


def _rack_and_logic(trace: Trace, folder: Path, options: ReplayOptions) -> tuple[RackSpec, ScanLogic | None]:
    """Return the rack and the logic; the logic is None if the recorded outputs are replayed."""
    rack, program, trust = options.rack, options.program, options.trust
    if options.into is ReplayTarget.MODULE:
        if program is not None:
            raise ValueError("--program needs --into program or rack: a module gets the recorded outputs")
        return (load_spec(rack)[0] if rack else spec_of(trace, folder, trust=trust)), None
    job = load_job(rack, program) if rack else job_of(trace, folder, trust=trust, program=program)
    return job.spec, job.logic
