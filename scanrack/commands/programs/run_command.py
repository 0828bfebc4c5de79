"""`scanrack run RACK`: its arguments and its plain words, without typer, and the run."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import NoReturn

from scanrack.io_images.dataclass import dataclass
from scanrack.terminal.importing import imported
from scanrack.terminal.plain_words import PlainWords, Value
from scanrack.terminal.status import BAD_INPUT, CANNOT_WRITE, complain, reason


@dataclass(frozen=True, slots=True, kw_only=True)
class RunArguments:
    """The argument and the options of `scanrack run`; `run` describes them."""

    rack: str
    duration: str | None = None
    scans: int | None = None
    realtime: bool = False
    spin: bool = False
    record: Path | None = None
    no_record: bool = False
    replace: bool = False
    live: bool = False
    retain: Path | None = None
    forces: bool = False
    keep_values: bool = False
    memory: int | None = None
    tag: list[str] | None = None
    server: list[str] | None = None
    ua_security: str | None = None
    ua_users: Path | None = None
    as_json: bool = False
    quiet: bool = False


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
    """Run a rack if the words after `run` are plain; return False if they are not.

    Raises:
        SystemExit: the run has ended.
    """
    given = WORDS.read(words)
    if given is not None:
        run_command(RunArguments(**given))
    return False


def run_command(options: RunArguments) -> NoReturn:
    """Run a rack.

    Raises:
        SystemExit: always, with a status of `terminal.status`.
    """
    with imported():
        from scanrack.jobs.load.exports import begun
        from scanrack.jobs.load.loading import forces_to_hold, load_job, scans_to_run, with_tags
        from scanrack.jobs.run.build import check_ports
        from scanrack.jobs.run.running import RunOptions
        from scanrack.runtime.loop.pace import RealTime

        from .run_job import retained_memory, run_job, run_retained, servers_at, trace_path

    try:
        export = begun(keep_values=options.keep_values, memory=options.memory)
        job = with_tags(load_job(options.rack, export=export), options.tag or ())
        count = scans_to_run(job.spec, options.duration, options.scans, endless=options.realtime)
        keep = 0 if options.replace else None
        trace = trace_path(job, options.record, options.no_record, keep)
        check_ports(job.spec, realtime=options.realtime, live=options.live)
        if options.spin and not options.realtime:
            raise ValueError("--spin goes with --realtime only: virtual time does not wait")
        held = forces_to_hold(job, options.forces)
        where = servers_at(options.server, options.ua_security, options.ua_users)
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
            trace=trace, live=options.live, pacer=pacer, keep=keep, forces=held, handled=bool(where)
        ),
        quiet=options.quiet,
        server=where,
        as_json=options.as_json,
    )
    raise SystemExit(run(job) if retained is None else run_retained(retained, run))
