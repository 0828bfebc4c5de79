"""A progress bar that looks at the CPU now and then; the scan loop knows nothing of it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ..loop.cpu import Cpu


class CpuProgress(Progress):
    """A bar of the scans a CPU has done, brought up to date whenever it is drawn."""

    def __init__(self, cpu: Cpu, scans: int | None, console: Console) -> None:
        self._cpu: Cpu | None = None
        super().__init__(
            TextColumn("scans"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=console
        )
        self._task = self.add_task("scans", total=scans)
        self._cpu = cpu

    def get_renderables(self) -> Iterable[RenderableType]:
        """Draw the bar as far as the CPU is now."""
        if self._cpu is not None:
            self.update(self._task, completed=self._cpu.scan)
        yield from super().get_renderables()


@contextmanager
def shown_progress(cpu: Cpu, scans: int | None, *, quiet: bool) -> Iterator[None]:
    """Show a progress bar on stderr while the CPU runs, if that is a terminal and nobody asked for quiet."""
    console = Console(stderr=True)
    if quiet or not console.is_terminal:
        yield
        return
    with CpuProgress(cpu, scans, console):
        yield
