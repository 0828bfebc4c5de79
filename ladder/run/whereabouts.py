"""Finds the position in a program from a traceback, because a watchdog or Ctrl-C can stop it anywhere."""

from __future__ import annotations

from collections.abc import Mapping
from traceback import walk_tb
from types import CodeType, FrameType, TracebackType

from ..interpreter import Interpreter
from ..state.lowered import LoweredLine, LoweredRoutine
from ..state.scheduler import Scheduler

Compiled = Mapping[CodeType, LoweredRoutine]
"""The routine of each compiled function."""


def position_in_program(trace: TracebackType | None, compiled: Compiled) -> str:
    """Return the task, routine, and rung or line of a traceback's innermost call; "" outside a program."""
    task: str | None = None
    routine: LoweredRoutine | None = None
    line: LoweredLine | None = None
    for frame, number in walk_tb(trace):
        if frame.f_code is _TASK:
            task = frame.f_locals["scheduled"].task.name
        elif frame.f_code in _INTERPRETED:
            routine, line = _interpreted(frame, routine, line)
        elif frame.f_code in compiled:
            routine = compiled[frame.f_code]
            line = next(
                (lowered_line for lowered_line in routine.lines if lowered_line.origin.line == number), None
            )
    names = (
        f"task {task}" if task else "",
        f"routine {routine.name}" if routine else "",
        f"{routine.unit} {line.number}" if routine and line else "",
    )
    return ", ".join(filter(None, names))


def _interpreted(
    frame: FrameType, routine: LoweredRoutine | None, line: LoweredLine | None
) -> tuple[LoweredRoutine | None, LoweredLine | None]:
    """Return the routine and line of an interpreter frame."""
    if frame.f_code is _ROUTINE:
        return frame.f_locals["routine"], None
    return routine, frame.f_locals["line"]


_TASK = Scheduler._run_task.__code__
_ROUTINE = Interpreter._lines.__code__
_INTERPRETED = (_ROUTINE, Interpreter._line.__code__)
