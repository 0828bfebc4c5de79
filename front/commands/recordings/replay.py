"""`scanrack replay TRACE`: play a recording to a module, a program or a rack, and compare the answer."""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.load.loading import load_job, load_spec
from ...jobs.replay.replaying import Replay, ReplayTarget, Stimuli, check_slots, with_stimuli
from ...jobs.trust.attachments import job_of, spec_of
from ...runtime.config.rackspec import RackSpec
from ...runtime.loop.scan import ScanLogic
from ...terminal.as_json import JsonOption
from ...terminal.complaints import reported_mistakes
from ...terminal.progress import shown_progress
from ...terminal.terminal import say
from ...terminal.trace_options import QuietOption, tell_notes
from ...traces.read.reader import Trace, open_trace
from ...traces.replay import Recording
from .compare import ToleranceCountsOption, ToleranceTimeOption, tell, tolerance

REPLAY = "replay"
"""Name of the second recording in the report."""


def _replay_command(
    path: Annotated[
        Path, typer.Argument(metavar="TRACE", help="The recording, an MCAP file.", show_default=False)
    ],
    into: Annotated[
        ReplayTarget,
        typer.Option(
            "--into",
            help="Recorded outputs into the modules, recorded inputs into the program, or recorded stimuli "
            "into the whole rack.",
        ),
    ] = ReplayTarget.MODULE,
    slot: Annotated[
        int | None, typer.Option("--slot", metavar="N", help="Compare this slot only.", show_default="all")
    ] = None,
    rack: Annotated[
        str | None,
        typer.Option("--rack", metavar="RACK", help="Another rack file.", show_default="the trace's"),
    ] = None,
    program: Annotated[
        str | None,
        typer.Option("--program", metavar="FILE", help="Another program.", show_default="the trace's"),
    ] = None,
    stimuli: Annotated[
        Stimuli | None,
        typer.Option(
            "--stimuli",
            help="What acts on the machine: the rack file's timeline and stations, the recorded stimuli, or "
            "the recorded levels of the inputs.",
            show_default="machine; recorded, into a rack",
        ),
    ] = None,
    tolerance_time: ToleranceTimeOption = "0s",
    tolerance_counts: ToleranceCountsOption = 0,
    to_the_end: Annotated[
        bool, typer.Option("--to-the-end", help="Go on after the first scan that differs.")
    ] = False,
    trust: Annotated[bool, typer.Option("--trust", help="Run Python that came with the trace.")] = False,
    as_json: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Replay a recording, and stop at the first scan in which the answer is another one.

    Rack and program are those that came with the trace, or what --rack and --program say: so a changed
    program is checked against an old recording. With a tolerance the whole recording is replayed and
    compared by time, see scanrack compare.

    Exit status: 0 the same, 1 something differs, 2 a file or option can't be used.

    Example: scanrack replay line.mcap --into program --program new.rung
    """
    with reported_mistakes():
        allowed = tolerance(tolerance_time, tolerance_counts)
        with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
            recording = Recording.of(trace)
            tell_notes(trace)
            spec, logic = _sources(trace, Path(folder), into, rack, program, trust=trust)
            chosen = stimuli or (Stimuli.RECORDED if into is ReplayTarget.RACK else Stimuli.MACHINE)
            slots = check_slots(recording, spec, slot)
            replay = Replay(recording, with_stimuli(spec, recording, chosen), logic, into, slots)
            follower = replay.run(
                allowed, to_the_end=to_the_end, observed=partial(shown_progress, quiet=quiet)
            )
        if follower.stopped:
            total = len(recording.scans)
            replay.notes.append(f"stopped after {follower.scans:,} of {total:,} scans; --to-the-end goes on")
        for note in replay.notes:
            say(f"note: {note}", err=True)
        status = tell(follower.comparison(), (path.name, REPLAY), as_json=as_json)
    raise typer.Exit(status)


def _sources(
    trace: Trace, folder: Path, into: ReplayTarget, rack: str | None, program: str | None, *, trust: bool
) -> tuple[RackSpec, ScanLogic | None]:
    """Return the rack and, unless the recorded outputs are played, the logic."""
    if into is ReplayTarget.MODULE:
        if program is not None:
            raise ValueError(
                "--program goes with --into program or rack: a module is played recorded outputs"
            )
        return (load_spec(rack)[0] if rack else spec_of(trace, folder, trust=trust)), None
    job = load_job(rack, program) if rack else job_of(trace, folder, trust=trust, program=program)
    return job.spec, job.logic


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("replay", no_args_is_help=True)(_replay_command)
