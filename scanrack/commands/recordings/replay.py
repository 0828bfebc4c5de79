"""`scanrack replay TRACE`: replay a trace, or repeat its session, and compare."""

from __future__ import annotations

import typer
from scanrack.jobs.replay.targets import ReplayTarget
from scanrack.terminal.grouped import grouped
from scanrack.terminal.status import BAD_INPUT, complain

from .comparison_options import ReplayOptions


def _replay_command(options: ReplayOptions) -> None:
    """Replay and check for differences; stop at the first scan that differs.

    Rack and program come from the trace, or from --rack and --program, so that an old trace can check a
    changed program. With a tolerance, the whole trace is replayed and compared by time; see scanrack compare.

    --into session runs the same rack file and program for the same number of scans, and repeats the
    operator actions and edits of a session of scanrack watch before the same scans. Python that came with
    the trace runs only if it is the same as in the current folder, or with --trust.

    A 3601 that was in operation before the trace starts with the state of the first image at rest, and is
    compared from the next scan on. Its configuration is the first in the trace, or --configuration. --record
    writes the replay, for scanrack compare; earlier recordings are kept unless --replace is given.

    Examples:
        scanrack replay line.mcap --into program --program new.rung

    Exit status: 0 no difference, 1 a difference, 2 a file or option can't be used, 130 stopped by Ctrl-C.
    """
    if options.into is ReplayTarget.SESSION:
        not_for_sessions = {
            "--slot": options.slot is not None,
            "--rack": options.rack is not None,
            "--program": options.program is not None,
            "--stimuli": options.stimuli is not None,
            "--tolerance-time": options.tolerance_time != "0s",
            "--tolerance-counts": options.tolerance_counts != 0,
            "--to-the-end": options.to_the_end,
        }
        wrong = [option for option, is_given in not_for_sessions.items() if is_given]
        if wrong:
            raise typer.Exit(complain(f"{wrong[0]}: not possible with --into session", BAD_INPUT))
        from .session_job import rerun_trace

        rerun_trace(options)
        return
    from .replay_job import replay_trace

    replay_trace(options)


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("replay", no_args_is_help=True)(grouped(_replay_command, options=ReplayOptions))
