"""`scanrack watch RACK|TRACE`: a rack that runs, or a recording, in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..runtime.live.speeds import MAX, SPEED_LEAST, SPEED_MOST
from ..terminal.status import BAD_INPUT, complain
from ..terminal.trace_options import ForcesOption, ReplaceOption, ServerOption


def _speed(text: str) -> float | None:
    """Return a speed; None = as fast as possible.

    Raises:
        ValueError: an illegal speed.
    """
    if text == MAX:
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not SPEED_LEAST <= speed <= SPEED_MOST:
        raise ValueError(f"--speed {text} is not allowed: {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}")
    return speed


def _watch_command(
    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK|EXPORT|TRACE",
            help="Rack file: TOML, or Python with rack(). Or an export, or a trace.",
            show_default=False,
        ),
    ],
    port: Annotated[
        int, typer.Option("--port", help="Port of the page; 0 = any free one.", min=0, max=65535)
    ] = 0,
    speed: Annotated[
        str, typer.Option("--speed", help=f"Times real time, {SPEED_LEAST} to {SPEED_MOST:g}, or {MAX}.")
    ] = "1",
    paused: Annotated[bool, typer.Option("--paused", help="Begin with a pause before scan 0.")] = False,
    read_only: Annotated[bool, typer.Option("--read-only", help="Take no orders from pages.")] = False,
    record: Annotated[
        Path | None, typer.Option("--record", help="Keep the recording there.", show_default=False)
    ] = None,
    replace: ReplaceOption = False,
    duration: Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for; without it until Ctrl-C."),
    ] = None,
    scans: Annotated[int | None, typer.Option("--scans", help="Number of scans to run, instead.")] = None,
    live: Annotated[
        bool,
        typer.Option("--live", help="Real ports may move real motors. This is not a safety system."),
    ] = False,
    control: Annotated[
        bool,
        typer.Option("--control", help="With --live: take orders, too; without it the page is read-only."),
    ] = False,
    opened: Annotated[bool, typer.Option("--open", help="Open the page in the browser.")] = False,
    text: Annotated[
        bool, typer.Option("--text", help="Show bits, values and events in the terminal, too, at 4 Hz.")
    ] = False,
    forces: ForcesOption = False,
    server: ServerOption = None,
    trust: Annotated[
        bool, typer.Option("--trust", help="Run Python that came with a trace, or is typed in the page.")
    ] = False,
    preview: Annotated[
        bool, typer.Option("--preview", help="Show a saved program in the page before it is taken over.")
    ] = False,
) -> None:
    from ..jobs.load.loading import forces_to_hold, load_job, recording_of, runs, scans_to_run
    from ..jobs.run.build import check_ports
    from ..jobs.run.servers.kinds import addresses
    from ..jobs.trust.owned import check_recording
    from ..terminal.complaints import reported_mistakes
    from .play import watch_job
    from .prepared_run import WatchOptions
    from .recorded_session import place_of, watch_trace
    from .share.page_file import is_page, recording_beside

    if not runs(rack.partition("#")[0]):
        of_racks = {"--speed": speed != "1", "--paused": paused, "--record": record, "--for": duration}
        of_racks |= {"--scans": scans is not None, "--live": live, "--control": control, "--text": text}
        of_racks |= {"--forces": forces, "--preview": preview, "--server": bool(server)}
        given = [option for option, is_given in of_racks.items() if is_given]
        with reported_mistakes():
            if given:
                raise ValueError(f"{given[0]} is for a rack that runs; {rack} is a recording")
            place = place_of(recording_of(rack))
            if is_page(place.path):
                place = place._replace(path=recording_beside(place.path))
            status = watch_trace(place, port=port, trust=trust, opened=opened)
        raise typer.Exit(status)
    try:
        factor = _speed(speed)
        job = load_job(rack)
        check_ports(job.spec, realtime=True, live=live)
        if live and (paused or factor != 1):
            raise ValueError("--live: a real controller does not wait: no --paused and no --speed")
        if control and not live:
            raise ValueError("--control goes with --live")
        if record is not None:
            check_recording(job, record, keep=0 if replace else None)
        held = forces_to_hold(job, forces)
        where = addresses(server)
        endless = scans is None and duration is None
        count = None if endless else scans_to_run(job.spec, duration, scans, endless=True)
    except ValueError as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    looking = read_only or (live and not control)
    wanted = WatchOptions(
        *(rack, port, factor, paused, looking, record, count, live, opened, text),
        keep=0 if replace else None,
        forces=held,
        preview=preview,
        trust=trust,
        servers=where,
    )
    raise typer.Exit(watch_job(job, wanted))


_HELP = """Run a rack and show it in the browser: rungs with power, words, machine, timing.

The first word printed is the link; the page comes from this machine, and works without a network. Scans keep
step with the wall clock, or at --speed. What is ordered on the page is recorded, so that the session can run
again: see scanrack rerun.

An .L5X or .SLC export opens as it is: a rack for it is made in a temporary folder, with memory for what is
not simulated.

A trace opens in the same page, at TRACE#scan=12345&rung=Main.6 if you like. Python that came with it is run
only if it is the same as in the current folder, or you say --trust; without, its words are shown. So does a
page of scanrack share --with-recording; its recording is written beside it.

Exit status: 0 done, 1 the CPU faulted, 2 a file or option can't be used, 3 the trace can't be written, 130
stopped by Ctrl-C, which ends a session without --for."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("watch", help=_HELP, no_args_is_help=True)(_watch_command)
