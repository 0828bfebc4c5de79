"""The machine that runs a stored program against the controller, in virtual time.

    t      instruction    one every millisecond, including LABEL and END
    +1 ms  instruction
    +1 ms  WAIT 500       the next instruction follows after 500 ms
    +500   FINISH         repeats every millisecond, until the controller is not busy
    ...

The manual does not state how long an instruction takes; one millisecond is an interpretation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.io_images.pcl601 import Error
from scanrack.io_images.pcl601.program import Program, Step

from ..stored import Axis601
from .actions import ACTIONS

INSTRUCTION_NS = 1_000_000
"""Duration of one instruction, ns."""


class ProgramMachine:
    """Runs one stored program.

    The controller calls `advance` exactly at `next_wake_ns`, after it has updated motion and pins. A refused
    action sets an error bit in the controller and ends the program.

    Attributes:
        line: index of the next step.
        next_wake_ns: instant of the next step, or None while the program is not running.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        self.line = 0
        self.next_wake_ns: int | None = None
        self._previous_line = 0
        self._return_line: int | None = None  # the line after the last GOTO
        self._passes_left: dict[int, int] = {}  # of each loop, by the line of its LOOP

    @property
    def running(self) -> bool:
        """Whether the program has started and has not ended."""
        return self.next_wake_ns is not None

    def start(self, now_ns: int) -> None:
        """Start the program at the first line."""
        self.line = self._previous_line = 0
        self._return_line = None
        self._passes_left.clear()
        self.next_wake_ns = now_ns

    def stop(self) -> None:
        """Stop at the current line; a motion in progress continues."""
        self.next_wake_ns = None

    def advance(self, now_ns: int, axis: Axis601) -> None:
        """Carry out the instruction that is due at `now_ns`."""
        if self.next_wake_ns is None or now_ns < self.next_wake_ns:
            return
        line = self.line
        self.next_wake_ns = now_ns + INSTRUCTION_NS
        if not self._carry_out(self.program.steps[line], axis):
            self.stop()
        self._previous_line = line

    def _carry_out(self, step: Step, axis: Axis601) -> bool:
        """Carry out a step and advance to the next one; return whether the program continues."""
        if step.instruction.needs_idle and axis.busy:
            axis.report(Error.BUSY)
            return False
        if step.name in _FLOW:
            return _FLOW[step.name](self, step, axis)
        self.line += 1
        return ACTIONS[step.name](axis, step)

    def _wait(self, step: Step, _axis: Axis601) -> bool:
        """Delay the next instruction by the milliseconds of WAIT, which include this instruction."""
        if self.next_wake_ns is not None:
            self.next_wake_ns += (int(step.values[0]) - 1) * INSTRUCTION_NS
        self.line += 1
        return True

    def _finish(self, _step: Step, axis: Axis601) -> bool:
        """Advance to the next line if the controller is not busy; otherwise repeat this line."""
        if not axis.busy:
            self.line += 1
        return True

    def _end(self, _step: Step, _axis: Axis601) -> bool:
        return False

    def _if_inputs(self, step: Step, axis: Axis601) -> bool:
        return self._if(axis.inputs_raw() == step.values[0])

    def _if_input(self, step: Step, axis: Axis601) -> bool:
        number, is_on = (int(value) for value in step.values)
        return self._if(axis.inputs_raw() >> (number - 1) & 1 == is_on)

    def _if(self, matches: bool) -> bool:
        """Continue with the next line, or skip it; return whether the program continues."""
        self.line += 1 if matches else 2
        return self.line < len(self.program.steps)

    def _goto(self, step: Step, _axis: Axis601) -> bool:
        """Jump to the label; a later RETURN jumps to the line after this one."""
        self._return_line = self.line + 1
        return self._jump(step)

    def _jump(self, step: Step) -> bool:
        self.line = self.program.labels[str(step.target)]
        return True

    def _return_from(self, _step: Step, axis: Axis601) -> bool:
        """Jump to the line after the last GOTO; without one, end the program with an error."""
        if self._return_line is None:
            axis.report(Error.MEMORY_COMMAND)
            return False
        self.line = self._return_line
        return True

    def _label(self, step: Step, _axis: Axis601) -> bool:
        """Restart the loops that begin at this label, if the program enters them from outside."""
        for loop_line in self._loops_to(str(step.values[0])):
            if not self.line <= self._previous_line <= loop_line:
                self._passes_left.pop(loop_line, None)
        self.line += 1
        return True

    def _loops_to(self, label: str) -> list[int]:
        """Return the lines of the LOOP instructions that jump to a label."""
        return [
            line
            for line, step in enumerate(self.program.steps)
            if step.target == label and step.name.startswith("LOOP")
        ]

    def _loop(self, step: Step, _axis: Axis601) -> bool:
        """Jump to the label until the loop has run the programmed number of times."""
        passes_left = self._passes_left.pop(self.line, int(step.values[0])) - 1
        if passes_left == 0:
            self.line += 1
            return True
        self._passes_left[self.line] = passes_left
        return self._jump(step)


_FLOW: Mapping[str, Callable[[ProgramMachine, Step, Axis601], bool]] = {
    "WAIT": ProgramMachine._wait,
    "FINISH": ProgramMachine._finish,
    "END": ProgramMachine._end,
    "IF INPUTS": ProgramMachine._if_inputs,
    "IF INPUT": ProgramMachine._if_input,
    "GOTO": ProgramMachine._goto,
    "LABEL": ProgramMachine._label,
    "RETURN": ProgramMachine._return_from,
    "LOOP OUTER": ProgramMachine._loop,
    "LOOP INNER": ProgramMachine._loop,
}
"""Functions that carry out the flow control instructions."""
