"""The progress bar, drawn by rich."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console, RenderableType
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from scanrack.runtime.loop.cpu import Cpu


class CpuProgress(Progress):
    """A bar of the CPU's scans, updated each time it is drawn."""

    def __init__(self, cpu: Cpu, scans: int | None, console: Console) -> None:
        self._cpu: Cpu | None = None  # until the task exists: the next line draws the bar
        super().__init__(
            TextColumn("scans"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), console=console
        )
        self._task = self.add_task("scans", total=scans)
        self._cpu = cpu

    def get_renderables(self) -> Iterable[RenderableType]:
        """Draw the bar with the CPU's current scan."""
        if self._cpu is not None:
            self.update(self._task, completed=self._cpu.scan)
        yield from super().get_renderables()
