"""A rack that runs while a client asks, and its recording run again."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from pathlib import Path

from scanrack.jobs import JobRun, RunOptions
from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.record.order_repeater import orders_of
from scanrack.runtime.live.tag_desk import TagDesk
from scanrack.traces import open_trace


def run_while(run: JobRun, desk: TagDesk, client: threading.Thread) -> None:
    """Run a scan for each request of a client, and ten more."""
    client.start()
    with run.cpu:
        while client.is_alive():
            if desk.has_request:
                run.cpu.run(1)
            else:
                client.join(0.0005)
        run.cpu.run(10)
    client.join()


def rerun(job: LoadedRack, trace: Path, again: Path) -> None:
    """Run a recording's orders again."""
    with open_trace(trace) as recorded:
        orders = orders_of(recorded.events())
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(trace=again, orders=orders))
        with run.cpu, open_trace(trace) as recorded:
            run.cpu.run(sum(1 for _ in recorded.scans()))
