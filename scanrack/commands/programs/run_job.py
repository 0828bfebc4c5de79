"""A run by `scanrack run`: scans, recording, servers and summary."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack, nullcontext, redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.run.result import RunCounters, result_of
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.jobs.trust.owned import check_recording
from scanrack.runtime.loop.pace import FreeRun, wall_ns
from scanrack.terminal.progress import shown_progress
from scanrack.terminal.run_end import run_to_end
from scanrack.terminal.status import (
    BAD_INPUT,
    CANNOT_WRITE,
    DONE,
    INTERRUPTED,
    NO,
    complain,
    complain_of_helper,
    ignore,
    reason,
)
from scanrack.terminal.terminal import say

from .summary import summary, summary_row

if TYPE_CHECKING:  # most runs serve and retain no tags, in virtual time
    from scanrack.jobs.run.retained_memory import RetainedMemory
    from scanrack.jobs.run.servers.kinds import ServerAddress
    from scanrack.jobs.run.servers.tag_service import TagServices


def run_job(
    job: LoadedRack,
    scans: int | None,
    options: RunOptions,
    *,
    quiet: bool,
    summarized: bool = True,
    as_json: bool = False,
    server: Sequence[ServerAddress] = (),
) -> int:
    """Run a loaded rack and report the result; return the exit status.

    Args:
        scans: number of scans; None runs until Ctrl-C.
        options: options of the run; their hints are printed.
        quiet: whether to print only error messages, without progress and summary.
        summarized: whether the run ends with a summary, unless `quiet`.
        server: addresses at which clients read and write tags.
        as_json: whether to print the summary as a JSON object, and the program's output to standard error.
    """
    with ExitStack() as ports:
        pacer, counters = options.pacer or FreeRun(), RunCounters()
        if not pacer.free:
            _in_real_time(ports, quiet=quiet)  # before the ports open, since their threads inherit it
        try:
            reported = replace(options, pacer=pacer, listeners=[counters], warn=ignore if quiet else complain)
            services = _open_servers(job, server, ports, live=options.live)
            run = JobRun(job, ports, reported)
            if services is not None:
                services.serve(run)
        except ValueError as error:
            return complain(str(error), BAD_INPUT)
        except OSError as error:
            return complain(f"the trace can't be written: {reason(error)}", CANNOT_WRITE)
        if not quiet:
            _warn(job, without_clients=bool(server) and pacer.free)
        start_ns = wall_ns()
        observed = partial(shown_progress, quiet=quiet)
        with redirect_stdout(sys.stderr) if as_json else nullcontext():
            status = run_to_end(
                run.cpu, partial(run.run, scans, observed=observed), lambda: run.cpu.stop_requested
            )
        _complain_all(() if run.repeated is None else run.repeated.refused)
        took_ns = wall_ns() - start_ns
        result = result_of(run, counters, options.trace)
        if as_json:
            _print_json(status, summary_row(run, result, took_ns))
        elif summarized and not quiet:
            say(summary(result, took_ns, pacer, run.stubs, run.steps))
        return status if services is None else _end_servers(services, status)


def _end_servers(services: TagServices, status: int) -> int:
    """End the servers; return the exit status of the run, or NO_HELPER if a server has not started."""
    if services.end() or status != DONE:
        return status
    return complain_of_helper()


def _warn(job: LoadedRack, *, without_clients: bool) -> None:
    """Print a loaded rack's warnings, including one if its servers end before a client can connect."""
    _complain_all(job.warnings)
    if without_clients:
        complain("without --realtime the run does not wait for clients; the servers end with the run")


def _complain_all(sentences: Iterable[str]) -> None:
    for sentence in sentences:
        complain(sentence)


def _print_json(status: int, row: dict[str, object]) -> None:
    from scanrack.terminal.as_json import say_json  # most runs print none

    say_json({"ended": ENDED[status], **row})


def servers_at(
    texts: Sequence[str] | None, ua_security: str | None = None, ua_users: Path | None = None
) -> Sequence[ServerAddress]:
    """Return the server addresses given by --server; see `addresses`."""
    if not (texts or ua_security or ua_users):
        return ()
    from scanrack.jobs.run.servers.kinds import addresses

    return addresses(texts, ua_security, ua_users)


def _open_servers(
    job: LoadedRack, addresses: Sequence[ServerAddress], ports: ExitStack, *, live: bool
) -> TagServices | None:
    """Open tag servers; they close when `ports` closes.

    Raises:
        ValueError: a port can't be used, or the rack file lacks an entry that a server needs.
    """
    if not addresses:
        return None
    from scanrack.jobs.run.servers.tag_service import TagServices

    services = TagServices(job, addresses, complain, writes=not live)
    ports.callback(services.end)
    return services


ENDED = {DONE: "done", NO: "fault", CANNOT_WRITE: "trace not written", INTERRUPTED: "stopped"}
"""Outcome of a run for --json, by exit status."""


def _in_real_time(ports: ExitStack, *, quiet: bool) -> None:
    """Request real-time rights before the first scan; print which of them are granted."""
    from scanrack.runtime.loop.realtime import real_time

    for outcome in ports.enter_context(real_time()):
        if not quiet:
            complain(str(outcome))


def trace_path(job: LoadedRack, record: Path | None, no_record: bool, keep: int | None = None) -> Path | None:
    """Return the recording's path from the command line or the rack file, or None without a recording.

    Raises:
        ValueError: contradictory options, or a recording that would replace an owned file.
    """
    if record is not None and no_record:
        raise ValueError("--record and --no-record: give only one of them")
    if no_record:
        return None
    trace = record or _default_path(job)
    check_recording(job, trace, keep=keep)
    return trace


def _default_path(job: LoadedRack) -> Path:
    if job.spec.trace is not None:
        return job.folder / job.spec.trace
    return Path(f"{job.rack_file.stem}.mcap")


def retained_memory(job: LoadedRack, path: Path, trace: Path | None, keep: int | None) -> RetainedMemory:
    """Return the retained tags of a loaded rack; see `RetainedMemory`."""
    from scanrack.jobs.run.retained_memory import RetainedMemory

    return RetainedMemory(job, path, trace, keep)


def run_retained(retained: RetainedMemory, run: Callable[[LoadedRack], int]) -> int:
    """Run a loaded rack with its retained tags, and store the tags at the end; return the exit status."""
    with retained:
        for note in retained.begin():
            complain(note)
        status = run(retained.job)
        try:
            retained.end()
        except ValueError as error:
            return complain(f"the tags can't be written: {error}", BAD_INPUT)
        except OSError as error:
            return complain(f"the tags can't be written to {retained.path}: {reason(error)}", CANNOT_WRITE)
    return status
