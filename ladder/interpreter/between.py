"""An interpreter that calls a function once, before a rung or line."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from typing_extensions import override

from ..state.lowered import LoweredLine, LoweredRoutine
from ..state.memory import Passed
from .interpreter import Interpreter


class PausingInterpreter(Interpreter):
    """Calls `pause` once, before a rung or line runs for the first time.

    Attributes:
        pause_at: the routine in capitals, and the number of the rung or line.
        pause: called without arguments; None = already called.
    """

    pause_at: tuple[str, int] = ("", 0)
    pause: Callable[[], object] | None = None
    _routine = ""

    @override
    def _lines(self, routine: LoweredRoutine, inputs: Sequence[Passed]) -> None:
        """Run the lines of a routine; `_line` needs its name."""
        outer, self._routine = self._routine, routine.name.upper()
        try:
            super()._lines(routine, inputs)
        finally:
            self._routine = outer

    @override
    def _line(self, line: LoweredLine, inputs: Sequence[Passed], *, statement: bool = False) -> bool:
        if self.pause is not None and (self._routine, line.number) == self.pause_at:
            pause, self.pause = self.pause, None
            pause()
        return super()._line(line, inputs, statement=statement)
