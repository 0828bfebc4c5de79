"""A progress bar that polls the CPU; the scan loop knows nothing of it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.runtime.loop.cpu import Cpu


@contextmanager
def shown_progress(cpu: Cpu, scans: int | None, *, quiet: bool) -> Iterator[None]:
    """Show a progress bar on stderr while the CPU runs, if that is a terminal, unless --quiet."""
    if quiet or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console  # rich takes time to import

    from .progress_bar import CpuProgress

    with CpuProgress(cpu, scans, Console(stderr=True)):
        yield
