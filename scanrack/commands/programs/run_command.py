"""`scanrack run RACK` without typer, whose import takes longer than most runs: its arguments, and the run.

Plain words are read here. All others, and all mistakes, are typer's: see `run`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NoReturn

from scanrack.io_images.dataclass import dataclass
from scanrack.terminal.importing import imported
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


FLAGS = {
    "--no-record": "no_record",
    "--replace": "replace",
    "--json": "as_json",
    "--quiet": "quiet",
    "-q": "quiet",
}
"""Plain options that take no word, with their arguments."""

VALUES: Mapping[str, tuple[str, Callable[[str], Any], str]] = {
    "--for": ("duration", str, r"[^-].*"),
    "--scans": ("scans", int, r"[1-9]\d{0,17}"),
    "--record": ("record", Path, r"[^-].*"),
}
"""Plain options that take a word: argument, type, pattern of a plain word."""


def plain_arguments(words: Sequence[str]) -> RunArguments | None:
    """Return the arguments that plain words mean: a rack, and options of the tables above, each once.

    Args:
        words: those after `run`.

    Returns:
        None for words that are not plain; they need not be wrong.

    >>> plain_arguments(["line.toml", "--scans", "10"]).scans
    10
    >>> plain_arguments(["--scans=10", "line.toml"]) is None
    True
    """
    found: dict[str, Any] = {}
    rest = iter(words)
    for word in rest:
        value: Any
        if word in VALUES:
            name, kind, pattern = VALUES[word]
            text = next(rest, "")
            if not re.fullmatch(pattern, text, re.ASCII | re.DOTALL):
                return None
            value = kind(text)
        elif word in FLAGS:
            name, value = FLAGS[word], True
        else:
            name, value = "rack", word
        if name in found or word.startswith("-") == (name == "rack"):
            return None
        found[name] = value
    return RunArguments(**found) if found.get("rack") else None


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
