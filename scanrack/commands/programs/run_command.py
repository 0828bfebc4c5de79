"""`scanrack run RACK`, parsed without typer for simple command lines."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

from scanrack.io_images.dataclass import dataclass
from scanrack.terminal.importing import imported
from scanrack.terminal.plain_words import PlainWords, Value
from scanrack.terminal.status import BAD_INPUT, CANNOT_WRITE, complain, reason

if TYPE_CHECKING:  # `grouped` resolves the annotations only if typer reads the words
    import typer
    from scanrack.terminal.as_json import JsonOption
    from scanrack.terminal.shared_options import (
        ForcesOption,
        KeepValuesOption,
        MemoryOption,
        ReplaceOption,
        ScansOption,
        ServerOption,
        UaSecurityOption,
        UaUsersOption,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class RunArguments:
    """The argument and the options of `scanrack run`."""

    rack: Annotated[
        str,
        typer.Argument(
            metavar="RACK",
            help="Rack file (TOML, or Python that defines rack()), or an .L5X or .SLC export.",
            show_default=False,
        ),
    ]
    duration: Annotated[
        str | None,
        typer.Option("--for", metavar="TIME", help="Machine time to run for, such as '10 s' or '250 ms'."),
    ] = None
    scans: ScansOption = None
    realtime: Annotated[
        bool, typer.Option("--realtime", help="Run in real time; until Ctrl-C, or for --for or run_for_s.")
    ] = False
    spin: Annotated[
        bool,
        typer.Option(
            "--spin",
            help="With --realtime: wait the last tenth of a period (at most 0.2 ms) without sleeping.",
        ),
    ] = False
    record: Annotated[
        Path | None, typer.Option("--record", metavar="TRACE", help="Trace file.", show_default=False)
    ] = None
    no_record: Annotated[bool, typer.Option("--no-record", help="Record nothing.")] = False
    replace: ReplaceOption = False
    live: Annotated[
        bool,
        typer.Option(
            "--live", help="Use real ports, which may move real motors. This is not a safety system."
        ),
    ] = False
    retain: Annotated[
        Path | None,
        typer.Option(
            "--retain",
            metavar="FILE",
            help="Begin with the ladder tags in this file, if it exists; write them to it at the end.",
        ),
    ] = None
    forces: ForcesOption = False
    keep_values: KeepValuesOption = False
    memory: MemoryOption = None
    tag: Annotated[
        list[str] | None,
        typer.Option(
            "--tag",
            metavar="PATTERN",
            help="Also record these tags of the program; '*' = all.",
            show_default=False,
        ),
    ] = None
    server: ServerOption = None
    ua_security: UaSecurityOption = None
    ua_users: UaUsersOption = None
    as_json: JsonOption = False
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress bar and no summary.")] = False


WORDS = PlainWords(
    ["rack"],
    flags={
        "--no-record": "no_record",
        "--replace": "replace",
        "--json": "as_json",
        "--quiet": "quiet",
        "-q": "quiet",
    },
    values={
        "--for": Value("duration"),
        "--scans": Value("scans", int, r"[1-9]\d{0,17}"),
        "--record": Value("record", Path),
    },
)


def plain_run(words: Sequence[str]) -> bool:
    """Run a rack; return False if only typer can parse the words after `run`.

    Raises:
        SystemExit: the run has ended.
    """
    arguments = WORDS.read(words)
    if arguments is not None:
        run_command(RunArguments(**arguments))
    return False


def run_command(options: RunArguments) -> NoReturn:
    """Run a rack.

    Raises:
        SystemExit: always, with a status of `terminal.status`.
    """
    with imported():
        from scanrack.jobs.load.exports import start_of_export
        from scanrack.jobs.load.loading import forces_to_hold, load_job, scans_to_run, with_tags
        from scanrack.jobs.run.build import check_ports
        from scanrack.jobs.run.running import RunOptions
        from scanrack.runtime.loop.pace import RealTime

        from .run_job import retained_memory, run_job, run_retained, servers_at, trace_path

    try:
        export = start_of_export(keep_values=options.keep_values, memory=options.memory)
        job = with_tags(load_job(options.rack, export=export), options.tag or ())
        count = scans_to_run(job.spec, options.duration, options.scans, endless=options.realtime)
        keep = 0 if options.replace else None
        trace = trace_path(job, options.record, options.no_record, keep)
        check_ports(job.spec, realtime=options.realtime, live=options.live)
        if options.spin and not options.realtime:
            raise ValueError("--spin needs --realtime: virtual time does not wait")
        forces = forces_to_hold(job, options.forces)
        servers = servers_at(options.server, options.ua_security, options.ua_users)
        retained = None if options.retain is None else retained_memory(job, options.retain, trace, keep)
    except ValueError as error:
        raise SystemExit(complain(str(error), BAD_INPUT)) from error
    except OSError as error:
        raise SystemExit(complain(reason(error), CANNOT_WRITE)) from error
    pacer = RealTime(spin=options.spin) if options.realtime else None
    run = partial(
        run_job,
        scans=count,
        options=RunOptions(
            trace=trace, live=options.live, pacer=pacer, keep=keep, forces=forces, handled=bool(servers)
        ),
        quiet=options.quiet,
        server=servers,
        as_json=options.as_json,
    )
    raise SystemExit(run(job) if retained is None else run_retained(retained, run))
