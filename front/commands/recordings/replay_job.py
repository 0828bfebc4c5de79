"""A recording played to a module, a program or a rack."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

import typer

from ...jobs.load.loading import load_job, load_spec
from ...jobs.replay.replaying import Replay, check_slots, with_stimuli
from ...jobs.replay.targets import ReplayTarget, Stimuli
from ...jobs.trust.attachments import job_of, spec_of
from ...runtime.config.rackspec import RackSpec
from ...runtime.loop.scan import ScanLogic
from ...terminal.complaints import reported_mistakes
from ...terminal.progress import shown_progress
from ...terminal.terminal import say
from ...terminal.trace_options import tell_notes
from ...traces.read.reader import Trace, open_trace
from ...traces.replay import PackedTrace
from .compare_job import tell, tolerance
from .replay import ReplayOptions

REPLAY = "replay"
"""Name of the second recording in the report."""


def replay_trace(options: ReplayOptions) -> None:
    """Replay and check for differences; stop at the first scan whose response differs.

    Raises:
        typer.Exit: with the status of the command, unless it is 0.
    """
    with reported_mistakes():
        allowed = tolerance(options.tolerance_time, options.tolerance_counts)
        with open_trace(options.path) as trace, tempfile.TemporaryDirectory() as folder:
            recording = PackedTrace.of(trace)
            try:
                spec, logic = _sources(trace, Path(folder), options)
            finally:
                tell_notes(trace)
            otherwise = Stimuli.RECORDED if options.into is ReplayTarget.RACK else Stimuli.MACHINE
            played = with_stimuli(spec, recording, options.stimuli or otherwise)
            slots = check_slots(recording, spec, options.slot)
            replay = Replay(recording, played, logic, options.into, slots)
            observed = partial(shown_progress, quiet=options.quiet)
            follower = replay.run(allowed, to_the_end=options.to_the_end, observed=observed)
        if follower.stopped:
            total = len(recording.scans)
            replay.notes.append(f"stopped after {follower.scans:,} of {total:,} scans; --to-the-end goes on")
        for note in replay.notes:
            say(f"note: {note}", err=True)
        status = tell(follower.comparison(), (options.path.name, REPLAY), as_json=options.as_json)
    raise typer.Exit(status)


def _sources(trace: Trace, folder: Path, options: ReplayOptions) -> tuple[RackSpec, ScanLogic | None]:
    """Return the rack and, unless the recorded outputs are played, the logic."""
    rack, program, trust = options.rack, options.program, options.trust
    if options.into is ReplayTarget.MODULE:
        if program is not None:
            raise ValueError(
                "--program goes with --into program or rack: a module is played recorded outputs"
            )
        return (load_spec(rack)[0] if rack else spec_of(trace, folder, trust=trust)), None
    job = load_job(rack, program) if rack else job_of(trace, folder, trust=trust, program=program)
    return job.spec, job.logic
