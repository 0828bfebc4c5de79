"""`scanrack serve amci3601 [RACK] --tcp PORT`: serve a 3601 as remote I/O of another PLC."""

from __future__ import annotations

import sys
from contextlib import ExitStack, closing
from functools import partial

from scanrack.io_images.times import time_text
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.jobs.serve.line import socket_address
from scanrack.jobs.serve.remote import ExternalPlc, ServingPace, remote_job
from scanrack.jobs.trust.owned import check_recording
from scanrack.runtime.line.ports import ModbusTcpPort
from scanrack.terminal.progress import shown_progress
from scanrack.terminal.run_end import run_to_end
from scanrack.terminal.status import complain, ignore
from scanrack.terminal.terminal import say

from .serve_options import ServeOptions


def serve_remote(options: ServeOptions) -> int:
    """Serve a 3601 until Ctrl-C; return the exit status.

    Raises:
        ValueError: a file, a port or an option can't be used.
    """
    if options.tcp is None:
        raise ValueError("amci3601: give --tcp [HOST:]PORT")
    keep = 0 if options.replace else None
    loaded = remote_job(options.rack, options.slot, options.silence, whole=options.whole)
    with loaded as (job, plc), ExitStack() as ports:
        if options.record is not None:
            check_recording(job, options.record, keep=keep)
        port = ports.enter_context(closing(ModbusTcpPort(*socket_address(options.tcp))))
        pace = ServingPace(port, plc)
        warn = ignore if options.quiet else complain
        run_options = RunOptions(options.record, pacer=pace, listeners=[plc], warn=warn, keep=keep)
        run = JobRun(job, ports, run_options)
        plc.attach(run.cpu)
        rack_text = "a rack of its own" if options.rack is None else options.rack
        interval = f"exchanged every {time_text(job.spec.scan_ns)}"
        say(f"{port.name}  amci3601 in slot {plc.slot} of {rack_text}, {interval}; Ctrl-C ends")
        sys.stdout.flush()  # a program may read the port through a pipe
        observed = partial(shown_progress, quiet=options.quiet)
        status = run_to_end(
            run.cpu, partial(run.run, None, observed=observed), lambda: run.cpu.stop_requested
        )
        if not options.quiet:
            complain(_counts(plc))
        return status


def _counts(plc: ExternalPlc) -> str:
    words = plc.words
    return f"exchanges: {words.exchanges:,}; torn writes: {words.torn:,}; silences: {plc.silences:,}"
