"""The causes of a change: the values that the instruction read and that changed since the previous scan.

Both scans run again. If all contacts in series conduct, all of them were needed, and the contacts that
changed are the causes. If some do not conduct, each of them is a sufficient cause. For the legs of a branch
the opposite is true. If nothing changed, for example when a timer is done, the latest earlier change is the
cause.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain

from scanrack.io_images.dataclass import dataclass

from ..model.operands import Group
from ..model.spec import InstructionKind, Use
from ..model.tags import Leaf
from ..model.types import HIDDEN
from ..state.lowered import LoweredStep, Node, Parallel, steps_of
from ..state.memory import Value, same
from .cells import Cell
from .crossref import BOTH_WAYS
from .executed import Execution, LineRun, Read, StepRun, TracedEngine, Write
from .forces import Force
from .replay import Replayer
from .stretch import ScanInputs

KEPT = 64
"""Maximum number of executed scans in memory."""


@dataclass(frozen=True, slots=True)
class Cause:
    """A read that explains a change."""

    read: Read
    reader: StepRun
    changed: bool = True  # since the previous run; False if it is only the latest change


@dataclass(frozen=True, slots=True)
class CellChange:
    """A change in a cell, either by an instruction or from outside before the scan."""

    scan: int
    cell: Cell
    write: Write | None


class Causes:
    """Finds causes in a program's past."""

    def __init__(self, past: Replayer) -> None:
        assert isinstance(past.engine, TracedEngine)
        self._past, self._engine = past, past.engine
        self._executions: OrderedDict[int, Execution] = OrderedDict()
        self._inputs: dict[int, ScanInputs] = {}

    # --- scans

    @property
    def engine(self) -> TracedEngine:
        """The engine that repeats scans, in the state after the last repeated scan."""
        return self._engine

    def value(self, cell: Cell, scan: int) -> Value:
        """Return a cell's value after a scan; a bit as a bool."""
        if self._past.at != scan and not self._past.show(scan):
            raise ValueError(f"scan {scan:,} can no longer be repeated")
        return cell.read(self._engine.memory)

    def execution(self, scan: int) -> Execution:
        """Return an executed scan; raise a ValueError if it can't be repeated."""
        execution = self._executions.get(scan)
        if execution is None:
            self._engine.traced = True
            try:
                self._past.again(scan)
            finally:
                self._engine.traced = False
            execution = self._engine.execution
            assert execution is not None
            if execution.scan != scan:  # the program did not run in that scan
                execution = Execution(scan)
            self._executions[scan] = execution
            while len(self._executions) > KEPT:
                self._executions.popitem(last=False)
        self._executions.move_to_end(scan)
        return execution

    def inputs(self, scan: int) -> ScanInputs | None:
        """Return the inputs of a scan; None if they are unknown."""
        inputs = self._inputs.get(scan)
        if inputs is None and scan >= 0:
            inputs = self._past.inputs(scan)
            if inputs is not None:
                self._inputs[scan] = inputs
        return inputs

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""
        inputs = self.inputs(scan)
        return 0 if inputs is None else inputs.now_ns

    def _changed_outside(self, cell: Cell, scan: int) -> bool:
        """Return whether a cell changed between two scans: an input, or a tag that was set or forced."""
        if self.inputs(scan) is None:
            return False
        if self.written(cell, scan):
            return True
        value_in = self.image if cell.leaf.is_image and not cell.leaf.output else self.force
        return value_in(cell, scan) != value_in(cell, scan - 1)

    def written(self, cell: Cell, scan: int) -> list[Value]:
        """Return the values written from outside before a scan that share memory with a cell."""
        inputs = self.inputs(scan)
        writes = inputs.writes if inputs is not None else ()
        return [value for leaf, index, value in writes if Cell(leaf, index).overlaps(cell)]

    def force(self, cell: Cell, scan: int) -> Force | None:
        """Return the force on a cell's value in a scan."""
        inputs = self.inputs(scan)
        forces = inputs.forces if inputs is not None else None
        return forces.get((cell.leaf.ident, cell.index)) if forces else None

    def image(self, cell: Cell, scan: int) -> Value:
        """Return the value of an input image's cell in a scan; a bit as a bool."""
        inputs = self.inputs(scan)
        if inputs is None or not inputs.images:
            return 0
        position = [leaf.ident for leaf in self._past.images].index(cell.leaf.ident)
        data = inputs.images[position][2 * cell.index : 2 * cell.index + 2]
        return cell.in_value(int.from_bytes(data, "little", signed=True))

    # --- changes

    def origins(self, cells: Sequence[Cell], scan: int, order: int | None = None) -> list[CellChange]:
        """Return the changes in cells in the latest scan that changed any of them.

        Args:
            order: consider only changes before this place in the scan; None for the whole scan.
        """
        changes = list(self._changes_in(cells, scan, order))
        if changes or scan == 0:
            return changes
        last = self._past.last_change_of(cells, scan - 1)
        return [] if last is None else list(self._changes_in(cells, last, None))

    def triggers(self, pending: Leaf, scan: int) -> list[CellChange]:
        """Return the change by an EVENT instruction that made a task due, in a scan or the previous scan."""
        for number in (scan, scan - 1):
            for write in reversed(self.execution(number).writes):
                if write.cell.leaf is pending and write.after and write.writer is not None:
                    return [CellChange(number, write.cell, write)]
        return []

    def _changes_in(self, cells: Iterable[Cell], scan: int, order: int | None) -> Iterator[CellChange]:
        """Yield the changes in cells in a scan, or before a place in it; a change from outside has no write.

        In a whole scan, a value that was changed and changed back counts as unchanged.
        """
        execution = self.execution(scan)
        for cell in cells:
            write = execution.last_write(cell, order)
            if write is not None and (order is not None or execution.changes(cell)):
                yield CellChange(scan, cell, write)
            elif write is None and self._changed_outside(cell, scan):
                yield CellChange(scan, cell, None)

    def groups_of(self, origin: CellChange) -> list[list[Cause]]:
        """Return groups of causes of a change. Every group was needed; one cause in a group was enough."""
        write = origin.write
        if write is None or write.writer is None:
            return []
        entry, scan = write.writer, origin.scan
        reads = list(self._deciding_reads(entry, origin.cell))
        groups = [
            *self._power_causes(entry, scan),
            *([cause] for cause in self._changed_reads(entry, scan, reads)),
        ]
        groups += self._lost_write_causes(origin.cell, entry, scan)
        if not any(groups):
            groups = [[cause] for cause in self._latest_changes(entry, scan, reads)]
        return [group for group in groups if group]

    def _lost_write_causes(self, cell: Cell, entry: StepRun, scan: int) -> list[list[Cause]]:
        """Return why the instruction that wrote the cell in the previous scan lost its power."""
        writes = reversed(self.execution(scan - 1).writes) if scan else ()
        earlier = next((write.writer for write in writes if write.cell.overlaps(cell)), None)
        if earlier is None or (earlier.step is entry.step and earlier.instance == entry.instance):
            return []
        run = self.execution(scan).runs.get(earlier.run.key)
        entry_now = None if run is None else run.steps.get(id(earlier.step))
        return [] if entry_now is None or entry_now.power else self._power_causes(entry_now, scan)

    def _deciding_reads(self, entry: StepRun, cell: Cell) -> Iterator[Read]:
        """Yield the reads that determined a cell; for a copied cell, only the same part of the source."""
        copied = self._source(entry, cell)
        for read in entry.reads:
            source = read.cell
            if copied is not None and (source.leaf, source.index) == (copied.leaf, copied.index):
                yield read.part(copied)
            elif copied is None and entry.step.name == "MOV" and source.leaf.type is cell.leaf.type:
                yield read.part(Cell(source.leaf, source.index, source.mask or cell.mask))
            elif copied is None or source.leaf is not copied.leaf:
                yield read

    def _source(self, entry: StepRun, cell: Cell) -> Cell | None:
        """Return the source cell that was copied to a cell; None if it is not known."""
        if entry.copied is None:
            return None
        source, destination = entry.copied
        suffix = cell.leaf.path.upper().removeprefix(destination.path.upper())
        leaf = self._engine.lowered.layout.leaves.get(f"{source.path}{suffix}".upper())
        if leaf is None or leaf.type is not cell.leaf.type:
            return None
        index = cell.index - destination.first + source.first
        return Cell(leaf, index, cell.mask) if 0 <= index < leaf.size else None

    def _previous(self, entry: StepRun, scan: int) -> StepRun | None:
        """Return the run of an instruction in the previous scan."""
        run = self.execution(scan - 1).runs.get(entry.run.key) if scan else None
        return None if run is None else run.steps.get(id(entry.step))

    def _changed_reads(
        self, entry: StepRun, scan: int, reads: Sequence[Read] | None = None
    ) -> Iterator[Cause]:
        """Yield an instruction's reads whose values have changed since the previous scan."""
        previous_run = self._previous(entry, scan)
        earlier = (
            {}
            if previous_run is None
            else {earlier_read.cell: earlier_read.value for earlier_read in previous_run.reads}
        )
        for read in entry.reads if reads is None else reads:
            whole_cell = Cell(read.cell.leaf, read.cell.index)
            if read.cell in earlier:
                differs = not same(earlier[read.cell], read.value)
            else:
                differs = whole_cell in earlier and not same(
                    read.cell.masked(earlier[whole_cell]), read.value
                )
            if differs and not self._writes_itself(read, entry, scan):
                yield Cause(read, entry)

    def _writes_itself(self, read: Read, entry: StepRun, scan: int) -> bool:
        """Return whether an instruction writes what it reads, such as ACC, in this or the previous scan."""
        if _is_written_member(read, entry.step):
            return True
        instruction_key = entry.number, entry.instance
        writes = chain.from_iterable(
            self.execution(number).writes for number in (scan, scan - 1) if number >= 0
        )
        return any(
            write.writer is not None
            and write.cell.overlaps(read.cell)
            and (write.writer.number, write.writer.instance) == instruction_key
            for write in writes
        )

    def _power_causes(self, entry: StepRun, scan: int) -> list[list[Cause]]:
        """Return the causes that turned an instruction's power on or off."""
        if entry.parent is not None:
            copied = [[cause] for contact in entry.ahead for cause in self._changed_reads(contact, scan)]
            return copied or self._power_causes(entry.parent, scan)
        groups: list[list[Cause]] = []
        previous_run = self._previous(entry, scan)
        if previous_run is not None and previous_run.power != entry.power:
            groups += self._series_causes(tuple(nodes_before(entry)), entry.run, previous_run.run, scan)
        for head in entry.run.heads:
            groups += [[cause] for cause in self._changed_reads(head, scan)]
        if entry.run.caller is not None:
            groups += self._power_causes(entry.run.caller, scan)
        return groups

    def _series_causes(
        self, nodes: Sequence[Node], run: LineRun, previous_run: LineRun, scan: int
    ) -> list[list[Cause]]:
        """Return the causes of the power after nodes in series."""
        changed = [node for node in nodes if _truth(node, run) is not _truth(node, previous_run)]
        if all(_truth(node, run) is not False for node in nodes):
            return [group for node in changed for group in self._node_causes(node, run, previous_run, scan)]
        blocking = [node for node in changed if _truth(node, run) is False]
        return _alternatives([self._node_causes(node, run, previous_run, scan) for node in blocking])

    def _node_causes(self, node: Node, run: LineRun, previous_run: LineRun, scan: int) -> list[list[Cause]]:
        """Return the causes that made a contact or branch conduct or block, unlike in the previous scan."""
        if isinstance(node, LoweredStep):
            return [[cause] for cause in self._changed_reads(run.steps[id(node)], scan)]
        conducts = _truth(node, run)
        legs = [
            leg
            for leg in node.legs
            if _series_truth(leg, run) == conducts and _series_truth(leg, previous_run) != conducts
        ]
        # one leg is enough to conduct; to block, all legs are needed
        by_leg = [self._series_causes(leg, run, previous_run, scan) for leg in legs]
        return _alternatives(by_leg) if conducts else [group for groups in by_leg for group in groups]

    # --- causes if nothing differs

    def _latest_changes(self, entry: StepRun, scan: int, own_reads: Sequence[Read]) -> list[Cause]:
        """Return as causes the reads of an instruction whose values changed last, in this scan or before."""
        reads = [
            (read, reader)
            for read, reader in _dependencies(entry, own_reads)
            if not self._writes_itself(read, reader, scan)
        ]
        by_order: dict[int, list[Cause]] = {}
        for read, reader in reads:
            for origin in self._changes_in([read.cell], scan, reader.order):
                order = origin.write.order if origin.write else 0
                by_order.setdefault(order, []).append(Cause(read, reader, changed=False))
        if by_order or not scan or not reads:
            return by_order[max(by_order)] if by_order else []
        return self._latest_changes_before(reads, scan)

    def _latest_changes_before(self, reads: Sequence[tuple[Read, StepRun]], scan: int) -> list[Cause]:
        """Return as causes the reads whose values changed in the latest scan before that changed any."""
        cells = list(dict.fromkeys(read.cell for read, _ in reads))
        changed = {origin.cell for origin in self.origins(cells, scan - 1)}
        return [Cause(read, reader, changed=False) for read, reader in reads if read.cell in changed]


_READ_ONLY_MEMBERS = ("PRE", "LEN")
"""Members of an instruction's structure that the instruction only reads."""


def _is_written_member(read: Read, step: LoweredStep) -> bool:
    """Return whether a read is a member of an instruction's structure that the instruction writes."""
    member = read.text.rpartition(".")[2].upper()
    return member not in _READ_ONLY_MEMBERS and any(
        isinstance(operand, Group)
        and read.cell.leaf.path.startswith(f"{operand.path}.")
        and use in BOTH_WAYS
        and (use is not Use.BLOCK or member.startswith(HIDDEN))
        for operand, use in zip(step.operands, step.uses, strict=False)
    )


def _dependencies(entry: StepRun, own_reads: Sequence[Read]) -> Iterator[tuple[Read, StepRun]]:
    """Yield reads of an instruction's operands, and of the conditions before and around it."""
    if entry.power or entry.step.kind is InstructionKind.BOTH:
        yield from ((read, entry) for read in own_reads)
    for contact in entry.ahead:
        yield from ((read, contact) for read in contact.reads)
    yield from _conditions(entry.parent or entry)


def _conditions(entry: StepRun) -> Iterator[tuple[Read, StepRun]]:
    """Yield reads of the conditions before and around an instruction whose value equals its power."""
    for step in filter(decides, steps_of(tuple(nodes_before(entry)), copies=False)):
        condition = entry.run.steps.get(id(step))
        if condition is not None and condition.truth is entry.power:
            yield from ((read, condition) for read in condition.reads)
            if step.spec.decides and condition.power:  # a one-shot blocks because it already had power
                yield from _conditions(condition)
    for head in entry.run.heads:
        yield from ((read, head) for read in head.reads)
    if entry.run.caller is not None:
        yield from _conditions(entry.run.caller)


def _alternatives(options: list[list[list[Cause]]]) -> list[list[Cause]]:
    """Return options as groups; several options become a single group in which one cause was enough."""
    options = [option for option in options if option]
    if len(options) <= 1:
        return options[0] if options else []
    return [[cause for option in options for group in option for cause in group]]


def nodes_before(entry: StepRun) -> Iterator[Node]:
    """Yield the nodes in series before an instruction."""
    yield from _nodes_before(entry.run.line.nodes, entry.step)


def _nodes_before(nodes: Sequence[Node], step: LoweredStep) -> Iterator[Node]:
    """Yield the nodes in series before an instruction, including nodes in the branch legs around it."""
    for node in nodes:
        if node is step:
            return
        legs = node.legs if isinstance(node, Parallel) else ()
        leg_with_step = next((leg for leg in legs if _contains(leg, step)), None)
        if leg_with_step is not None:
            yield from _nodes_before(leg_with_step, step)
            return
        yield node


def _contains(nodes: Sequence[Node], step: LoweredStep) -> bool:
    """Return whether an instruction is among nodes, or in a branch among them."""
    return any(
        any(_contains(leg, step) for leg in node.legs) if isinstance(node, Parallel) else node is step
        for node in nodes
    )


def decides(step: LoweredStep) -> bool:
    """Return whether an instruction can block power."""
    return step.kind is InstructionKind.INPUT or step.spec.decides


def _truth(node: Node, run: LineRun) -> bool | None:
    """Return whether a contact or a branch conducts in a run; None if it is not known."""
    if isinstance(node, Parallel):
        legs = [_series_truth(leg, run) for leg in node.legs]
        if True in legs:
            return True
        return None if None in legs else False
    entry = run.steps.get(id(node))
    if entry is None:
        return None
    return entry.truth if decides(node) else True


def _series_truth(nodes: Sequence[Node], run: LineRun) -> bool | None:
    """Return whether nodes in series conduct in a run; None if it is not known."""
    truths = [_truth(node, run) for node in nodes]
    if False in truths:
        return False
    return None if None in truths else True
