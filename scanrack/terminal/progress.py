"""A progress bar that polls the CPU, so that the scan loop does not depend on it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.runtime.loop.cpu import Cpu


@contextmanager
def shown_progress(cpu: Cpu, scans: int | None, *, quiet: bool) -> Iterator[None]:
    """Show a progress bar while the CPU runs, if standard error is a terminal and not `quiet`."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console  # rich takes time to import

    from .progress_bar import CpuProgress

    with CpuProgress(cpu, scans, Console(stderr=True)):
        yield
