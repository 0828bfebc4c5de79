"""`scanrack watch RACK|TRACE`: a running rack or a trace in the browser."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer
from scanrack.runtime.live.speeds import MAX, SPEED_LEAST, SPEED_MOST
from scanrack.terminal.grouped import grouped
from scanrack.terminal.status import BAD_INPUT, complain

from .watch_options import WatchArguments, WatchOptions

if TYPE_CHECKING:
    from scanrack.jobs.load.loading import LoadedRack


def speed_of(text: str) -> float | None:
    """Parse a speed; None = as fast as possible.

    Raises:
        ValueError: the text is not an allowed speed.
    """
    if text == MAX:
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not SPEED_LEAST <= speed <= SPEED_MOST:
        raise ValueError(f"--time-scale {text}: must be {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}")
    return speed


def _watch_command(options: WatchArguments) -> None:
    """Watch a rack or a trace to the end, and exit with its status."""
    from scanrack.jobs.load.loading import runs
    from scanrack.jobs.load.program import lines_marked

    is_rack = runs(options.rack.partition("#")[0])
    with lines_marked():  # pages can set breakpoints on lines of Python
        raise typer.Exit(_watch_rack(options) if is_rack else _watch_recording(options))


def _watch_rack(options: WatchArguments) -> int:
    """Run a rack; return the exit status."""
    from .play import watch_job

    try:
        job, watched = _read(options)
    except ValueError as error:
        return complain(str(error), BAD_INPUT)
    return watch_job(job, watched)


def _watch_recording(options: WatchArguments) -> int:
    """Show a trace; return the exit status."""
    from scanrack.jobs.load.loading import recording_of
    from scanrack.terminal.complaints import reported_mistakes

    from .recorded_session import parse_trace_place, watch_trace
    from .share.page_file import is_page, recording_beside

    of_racks = {
        "--time-scale": options.speed != "1",
        "--spin": options.spin,
        "--paused": options.paused,
        "--record": options.record,
        "--for": options.duration,
        "--scans": options.scans is not None,
        "--live": options.live,
        "--allow-writes": options.control,
        "--text": options.text,
        "--forces": options.forces,
        "--keep-values": options.keep_values,
        "--memory": options.memory is not None,
        "--preview": options.preview,
        "--server": bool(options.server),
        "--opc-ua-security": options.ua_security is not None,
        "--opc-ua-users": options.ua_users is not None,
    }
    refused = [option for option, is_given in of_racks.items() if is_given]
    with reported_mistakes():
        place = parse_trace_place(recording_of(options.rack))
        if refused and place.path.exists():  # otherwise the missing file is reported
            raise ValueError(f"{refused[0]} needs a running rack; {options.rack} is a trace")
        if is_page(place.path):
            place = place._replace(path=recording_beside(place.path))
        return watch_trace(place, port=options.port, trust=options.trust, opened=options.opened)


def _check_live(options: WatchArguments, factor: float | None) -> None:
    """Raise ValueError for options that can't be used with real ports, or that need real ports."""
    if options.live and (options.paused or factor != 1):
        raise ValueError("--live: a real controller does not wait: no --paused and no --time-scale")
    if options.control and not options.live:
        raise ValueError("--allow-writes needs --live")


def _read(options: WatchArguments) -> tuple[LoadedRack, WatchOptions]:
    """Return the rack and the settings of its session; raise ValueError if an option can't be used."""
    from scanrack.jobs.load.exports import start_of_export
    from scanrack.jobs.load.loading import forces_to_hold, load_job, scans_to_run
    from scanrack.jobs.run.build import check_ports
    from scanrack.jobs.run.servers.kinds import addresses
    from scanrack.jobs.trust.owned import check_recording

    keep = 0 if options.replace else None  # numbered copies of an old recording; None: the usual number
    factor = speed_of(options.speed)
    export = start_of_export(keep_values=options.keep_values, memory=options.memory)
    job = load_job(options.rack, export=export)
    check_ports(job.spec, realtime=True, live=options.live)
    _check_live(options, factor)
    if options.record is not None:
        check_recording(job, options.record, keep=keep)
    held_forces = forces_to_hold(job, options.forces)
    server_addresses = addresses(options.server, options.ua_security, options.ua_users)
    endless = options.scans is None and options.duration is None
    count = None if endless else scans_to_run(job.spec, options.duration, options.scans, endless=True)
    is_read_only = options.read_only or (options.live and not options.control)
    return job, WatchOptions(
        options, factor, is_read_only, count, keep=keep, forces=held_forces, servers=server_addresses
    )


_HELP = """Open a live rack or a trace in the browser: rungs with power flow, words, machine, timing.

Prints the URL first. The page comes from this machine and works without a network. Scans run in real time,
or at --time-scale. Actions on the page are recorded, so the session can run again: see scanrack replay.

An .L5X or .SLC export opens unchanged. Its rack is made in a temporary folder, with memory for modules that
are not simulated.

A trace opens in the same page. TRACE#scan=12345&rung=Main.6 opens it at a scan and a rung. Python that came
with it runs only if it is the same as in the current folder, or with --trust. Otherwise the page shows only
images and events. A page of scanrack share --with-recording opens as well; its trace is written beside it.

Examples:
    scanrack new feeder --from feeder
    scanrack watch feeder/feeder.toml --open
    scanrack watch run.mcap --open

Exit status: 0 done, 1 the controller faulted, 2 a file or option can't be used, 3 the trace can't be written
or a helper process never started, 130 stopped by Ctrl-C, which ends a session without --for."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("watch", help=_HELP, no_args_is_help=True)(grouped(_watch_command, options=WatchArguments))
