"""`scanrack run RACK`: logic against a rack, scan by scan, recorded, with a closing summary."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack, nullcontext, redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from ...jobs.load.loading import DEFAULT_RUN, Job, forces_to_hold, load_job, scans_to_run, with_tags
from ...jobs.run.build import check_ports
from ...jobs.run.result import Tally, result_of
from ...jobs.run.retained_memory import RetainedMemory
from ...jobs.run.running import JobRun, RunOptions
from ...jobs.run.tag_service import ServerAddress, TagService
from ...jobs.trust.owned import check_recording
from ...runtime.loop.pace import FreeRun, RealTime, wall_ns
from ...runtime.loop.realtime import Outcome, real_time
from ...terminal.as_json import JsonOption, say_json
from ...terminal.progress import shown_progress
from ...terminal.run_end import run_to_end
from ...terminal.status import BAD_INPUT, CANNOT_WRITE, DONE, INTERRUPTED, NO, complain, reason
from ...terminal.terminal import say
from ...terminal.trace_options import ForcesOption, ReplaceOption, ServerOption
from .summary import summary, summary_row


def run_job(
    job: Job,
    scans: int | None,
    options: RunOptions,
    *,
    quiet: bool,
    summarised: bool = True,
    as_json: bool = False,
    server: ServerAddress | None = None,
) -> int:
    """Run a job and report its result; return the exit status.

    Args:
        scans: their number, None = until Ctrl-C.
        options: of the run; its hints are printed.
        quiet: no progress and no summary; error messages are still printed.
        summarised: whether a run that is not quiet ends with a summary.
        server: where clients read and write tags; None = no server.
        as_json: print the summary as one JSON object, and the program's own output on standard error.
    """
    with ExitStack() as ports:
        pacer, tally = options.pacer or FreeRun(), Tally()
        if not pacer.free:
            outcomes = ports.enter_context(real_time())  # before there are ports: their threads inherit it
            _tell_of_real_time(outcomes, quiet=quiet)
        try:
            told = replace(options, pacer=pacer, listeners=[tally], warn=_quiet if quiet else complain)
            service = None if server is None else _tag_service(job, server, ports, live=options.live)
            run = JobRun(job, ports, told)
            if service is not None:
                run.cpu.add_listener(service.serve(run))
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        except OSError as error:
            return complain(f"the trace can't be written: {reason(error)}", CANNOT_WRITE)
        for each in () if quiet else job.warnings:
            complain(each)
        start_ns = wall_ns()
        observed = partial(shown_progress, quiet=quiet)
        with redirect_stdout(sys.stderr) if as_json else nullcontext():
            status = run_to_end(
                run.cpu, partial(run.run, scans, observed=observed), lambda: run.cpu.stop_requested
            )
        for each in () if run.repeated is None else run.repeated.refused:
            complain(each)
        took_ns = wall_ns() - start_ns
        result = result_of(run, tally, options.trace)
        if as_json:
            say_json({"ended": ENDED[status], **summary_row(run, result, took_ns)})
        elif summarised and not quiet:
            say(summary(result, took_ns, pacer, run.stubs, run.steps))
        return status


def _tag_service(job: Job, where: ServerAddress, ports: ExitStack, *, live: bool) -> TagService:
    """Return a server of tags that ends with `ports`; ValueError if its port can't be used."""
    service = TagService(job, where, complain, writes=not live)
    ports.callback(service.end)
    for line in service.said():
        complain(line)
    return service


ENDED = {DONE: "done", NO: "fault", CANNOT_WRITE: "trace not written", INTERRUPTED: "stopped"}
"""How a run ended, by exit status, for --json."""


def _tell_of_real_time(outcomes: list[Outcome], *, quiet: bool) -> None:
    """Print the real-time measures that the system has granted and refused, before the first scan."""
    if not quiet:
        for outcome in outcomes:
            complain(str(outcome))


def _quiet(_hint: str) -> None: ...


def trace_path(job: Job, record: Path | None, no_record: bool, keep: int | None = None) -> Path | None:
    """Return the path of the recording: the command line's, the rack file's, or one named after it.

    Raises:
        ValueError: contradictory options, or a recording that would replace an owned file.
    """
    if record is not None and no_record:
        raise ValueError("--record and --no-record contradict each other: give one of them")
    if no_record:
        return None
    trace = record or _own_path(job)
    check_recording(job, trace, keep=keep)
    return trace


def _own_path(job: Job) -> Path:
    if job.spec.trace is not None:
        return job.folder / job.spec.trace
    return Path(f"{job.rack_file.stem}.mcap")


def _run_command(
    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK",
            help="Rack file: TOML, or Python that defines rack(). Or an .L5X or .SLC export.",
            show_default=False,
        ),
    ],
    duration: Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for, such as '10 s' or '250 ms'."),
    ] = None,
    scans: Annotated[int | None, typer.Option("--scans", help="Number of scans to run, instead.")] = None,
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Keep step with the wall clock; without --for until Ctrl-C.")
    ] = False,
    spin: Annotated[
        bool,
        typer.Option(
            "--spin",
            help="With --realtime: wait the last tenth of a period, 0.2 ms at most, without sleeping.",
        ),
    ] = False,
    record: Annotated[
        Path | None, typer.Option("--record", help="Where the trace goes.", show_default=False)
    ] = None,
    no_record: Annotated[bool, typer.Option("--no-record", help="Record nothing.")] = False,
    replace: ReplaceOption = False,
    live: Annotated[
        bool,
        typer.Option(
            "--live", help="Real ports in the rack file may move real motors. This is not a safety system."
        ),
    ] = False,
    retain: Annotated[
        Path | None,
        typer.Option(
            "--retain",
            metavar="FILE",
            help="Begin with the ladder tags in this file, if there is one, and write them to it at the end.",
        ),
    ] = None,
    forces: ForcesOption = False,
    tag: Annotated[
        list[str] | None,
        typer.Option(
            "--tag",
            metavar="PATTERN",
            help="Record tags of the program beside those that the rack file names; '*' is all.",
            show_default=False,
        ),
    ] = None,
    server: ServerOption = None,
    as_json: JsonOption = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")] = False,
) -> None:
    try:
        job = with_tags(load_job(rack), tag or ())
        count = scans_to_run(job.spec, duration, scans, endless=realtime)
        keep = 0 if replace else None
        trace = trace_path(job, record, no_record, keep)
        check_ports(job.spec, realtime=realtime, live=live)
        if spin and not realtime:
            raise ValueError("--spin goes with --realtime only: virtual time does not wait")
        held = forces_to_hold(job, forces)
        where = None if server is None else ServerAddress.parse(server)
        retained = None if retain is None else RetainedMemory(job, retain, trace, keep)
    except ValueError as error:
        raise typer.Exit(complain(str(error), BAD_INPUT)) from error
    except OSError as error:
        raise typer.Exit(complain(reason(error), CANNOT_WRITE)) from error
    pacer = RealTime(spin=spin) if realtime else None
    run = partial(
        run_job,
        scans=count,
        options=RunOptions(
            trace=trace, live=live, pacer=pacer, keep=keep, forces=held, handled=where is not None
        ),
        quiet=quiet,
        server=where,
        as_json=as_json,
    )
    raise typer.Exit(run(job) if retained is None else _run_retained(retained, run))


def _run_retained(retained: RetainedMemory, run: Callable[[Job], int]) -> int:
    """Run a job that begins with retained tags, and write them; return the exit status."""
    with retained:
        for said in retained.begin():
            complain(said)
        status = run(retained.job)
        try:
            retained.end()
        except ValueError as error:
            return complain(f"the tags can't be written: {error}", BAD_INPUT)
        except OSError as error:
            return complain(f"the tags can't be written to {retained.path}: {reason(error)}", CANNOT_WRITE)
    return status


_HELP = f"""Run a rack's logic scan by scan against its modules and machine, and record every scan.

Time is virtual and does not wait, unless --realtime says so. In real time the scans run under
SCHED_FIFO and in locked memory where the system lets them; the first lines say whether it does, and
the summary how late scans began. A run takes as long as --for or
--scans says, or run_for_s in the rack file, or {DEFAULT_RUN} of machine time. The trace goes where
--record or the rack file says, or into the current folder, named after the rack file.

Exit status: 0 done, 1 the CPU faulted (the program raised or did not come back), 2 a file or
option can't be used, 3 the trace can't be written, 130 stopped by Ctrl-C. Whatever the end, the
trace can be read up to there."""


def register(app: typer.Typer) -> None:
    """Add the command to the application."""
    app.command("run", help=_HELP, no_args_is_help=True)(_run_command)
