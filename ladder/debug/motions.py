"""Motion in chains of causes: the instruction that moves an axis, ends its motion or is refused.

Status bits and positions of an axis change between scans, when no instruction runs. Each course records its
instruction, see `instructions.motion.courses`. The cause is the instruction with a course that began or ended
in the scan of the change, or otherwise the instructions whose courses are under way.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from scanrack.io_images.dataclass import dataclass

from ..instructions.motion.ideal_axis import BITS, PLANNER_OF
from ..instructions.motion.motion_control import ERRORS
from ..instructions.motion.spots import Ideal, MotionPart
from ..model.operands import Group
from ..model.predefined.motion_types import MOTION_BITS, MOTION_INSTRUCTION, PLANNERS
from ..model.spec import Use
from ..state.lowered import LoweredProgram
from ..state.memory import Value, element_text
from .causes import Causes, CellChange
from .cells import Cell
from .executed import StepRun, Write

COMPLETE, MOVES, BLOCK = "the motion of {} is complete", "moved by {}", "as its block says"
"""Texts of the effects of a motion; the first two name its instructions."""

_BIT_NAMES = {position: name for name, position in BITS.items()}


@dataclass(frozen=True, slots=True)
class Motions:
    """Finds the motion instructions that changed axes and other instructions."""

    lowered: LoweredProgram
    causes: Causes

    def attributed(self, origin: CellChange) -> CellChange:
        """Attribute a change after a scan to the instruction that began or ended motion in that scan."""
        axis = self._axis_of(origin.cell)
        if axis is None or origin.write is None:
            return origin
        prefixes = tuple(self._courses(axis, origin.cell))
        for write in reversed(self.causes.execution(origin.scan).writes):
            if (
                write.writer is not None
                and write.cell.index == axis.index
                and write.cell.leaf.path.startswith(prefixes)
            ):
                return replace(origin, write=replace(origin.write, writer=write.writer))
        return origin

    def movers(self, origin: CellChange) -> Iterator[tuple[Cell, str, str]]:
        """Yield the causes of a change after a scan: cell, name, and text of the motion's effect."""
        ideal: Ideal | None = self.lowered.ideal
        control = self._part_of(origin.cell, ideal.controls if ideal else ())
        axis = self._axis_of(origin.cell)
        if control is not None:
            yield *self._in_process(control), COMPLETE
        elif axis is not None and ideal is not None:
            ended = list(self._ended(axis, origin))
            for claim in ended or self._under_way(axis, origin):
                cell, name = self._in_process(ideal.controls[(claim >> 32) - 1])
                yield cell, name, COMPLETE if ended else MOVES
        else:
            yield from self._mirrored_member(origin.cell)

    def _mirrored_member(self, cell: Cell) -> Iterator[tuple[Cell, str, str]]:
        """Yield the member of a 3601's block that is mirrored in a member of its axis."""
        path, _, host = cell.leaf.path.rpartition(".")
        for axis in self.lowered.axes.values():
            if axis.tag.path == path:
                name = f"{axis.state.path}.{'Step' if cell.mask or host.endswith('Status') else 'Position'}"
                yield Cell(self.lowered.layout.leaf(name), 0), name, BLOCK

    def _ended(self, axis: MotionPart, origin: CellChange) -> Iterator[int]:
        """Yield the claims of courses that ended in the scan of a change."""
        claims = tuple(f"{course}claim" for course in self._courses(axis, origin.cell))
        for write in self.causes.execution(origin.scan).writes:
            if (
                write.cell.index == axis.index
                and write.cell.leaf.path in claims
                and write.before
                and not write.after
            ):
                yield int(write.before)

    def _under_way(self, axis: MotionPart, origin: CellChange) -> Iterator[int]:
        """Yield the claims of courses under way; the high word of a claim is its instruction's number."""
        for course in self._courses(axis, origin.cell):
            leaf = self.lowered.layout.leaf(f"{course}claim")
            claim = int(self.causes.value(Cell(leaf, axis.index), origin.scan))
            if claim >> 32:
                yield claim

    def _axis_of(self, cell: Cell) -> MotionPart | None:
        ideal: Ideal | None = self.lowered.ideal
        return self._part_of(cell, [part for part, _ in ideal.axes] if ideal else ())

    def _part_of(self, cell: Cell, motion_parts: Iterable[MotionPart]) -> MotionPart | None:
        path = cell.leaf.path.rpartition(".")[0]
        return next((part for part in motion_parts if part.path == path and part.index == cell.index), None)

    def _courses(self, axis: MotionPart, cell: Cell) -> Iterator[str]:
        """Yield the member prefixes of the course that a status bit shows, or of all courses."""
        host = cell.leaf.path.rpartition(".")[2]
        bit = _BIT_NAMES.get(f"{host}.{cell.mask.bit_length() - 1}", "") if cell.mask else ""
        for planner in (PLANNER_OF[bit],) if bit in PLANNER_OF else PLANNERS:
            yield f"{axis.path}.~{planner}_"

    def _in_process(self, control: MotionPart) -> tuple[Cell, str]:
        """Return the IP bit of an instruction and the name of the bit."""
        leaf = self.lowered.layout.leaf(f"{control.path}.FLAGS")
        text = element_text(f"{control.path}.IP", leaf.dims, control.index)
        return Cell(leaf, control.index, 1 << MOTION_BITS["IP"]), text


def motion_text(entry: StepRun, cell: Cell, value: Value, writes: Sequence[Write]) -> str:
    """Return the effect of a motion instruction on a cell as text; "" for any other instruction.

    The text names the axis and the control, as in `MAM(Feed,Go)`. It also has the error of a refused
    instruction, or says that the instruction ends another motion.

    Args:
        writes: the writes of the scan.
    """
    step = entry.step
    if Use.MOTION not in step.uses:
        return ""
    groups = [operand for operand in step.operands if isinstance(operand, Group)]
    control = next(group for group in groups if group.type == MOTION_INSTRUCTION)
    name = f"{step.name}({','.join(dict.fromkeys((groups[0].text, control.text)))})"
    path, _, member = cell.leaf.path.rpartition(".")
    if value and (member == "ERR" or cell.mask == 1 << MOTION_BITS["ER"]):
        return f"{name}{_error_text(f'{path}.ERR', writes)}"
    ends = not value and cell.mask is not None and path != control.path
    return f"{name} ends it" if ends else name


def _error_text(path: str, writes: Sequence[Write]) -> str:
    """Return a colon and the last error that was written to a member; "" if there is no error."""
    errors = [int(write.after) for write in writes if write.cell.leaf.path == path and write.after]
    return f": ERR {errors[-1]}, {ERRORS[errors[-1]]}" if errors else ""
