"""The causes of a change: what the instruction had read, and how that differs from the scan before.

The scan of the change and the one before it are run again. Of contacts in series that are true all were
needed, and those that changed are the cause; of those that are false each would have done; in branches it
is the other way round. If nothing differs, as when a timer ends, the value that changed last counts.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Sequence

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
from .replay import Replayer
from .stretch import ScanInputs

KEPT = 64
"""Most scans that are kept as executed."""


@dataclass(frozen=True, slots=True)
class Cause:
    """A read that explains a change."""

    read: Read
    by: StepRun
    changed: bool = True  # since the run before; False if it is only the latest of all


@dataclass(frozen=True, slots=True)
class CellChange:
    """The change of a cell: by an instruction, or from outside before the scan."""

    scan: int
    cell: Cell
    write: Write | None


class Causes:
    """Finds causes in the past of a program."""

    def __init__(self, past: Replayer) -> None:
        assert isinstance(past.engine, TracedEngine)
        self._past, self._engine = past, past.engine
        self._known: OrderedDict[int, Execution] = OrderedDict()
        self._inputs: dict[int, ScanInputs] = {}

    # --- scans

    @property
    def engine(self) -> TracedEngine:
        """The engine that repeats scans, after the one that was repeated last."""
        return self._engine

    def value(self, cell: Cell, scan: int) -> Value:
        """Return a cell after a scan; a bit as a bool."""
        if self._past.at != scan and not self._past.show(scan):
            raise ValueError(f"scan {scan:,} can no longer be repeated")
        value = self._engine.memory.read(cell.leaf, cell.index)
        return value if cell.mask is None else bool(int(value) & cell.mask)

    def execution(self, scan: int) -> Execution:
        """Return a scan as it was executed; ValueError if it can't be repeated."""
        known = self._known.get(scan)
        if known is None:
            self._engine.traced = True
            try:
                self._past.again(scan)
            finally:
                self._engine.traced = False
            known = self._engine.execution
            assert known is not None
            if known.scan != scan:  # the program did not run in it
                known = Execution(scan)
            self._known[scan] = known
            while len(self._known) > KEPT:
                self._known.popitem(last=False)
        self._known.move_to_end(scan)
        return known

    def inputs(self, scan: int) -> ScanInputs | None:
        """Return what went into a scan."""
        known = self._inputs.get(scan)
        if known is None:
            known = self._past.inputs(scan)
            if known is not None:
                self._inputs[scan] = known
        return known

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""
        found = self.inputs(scan)
        return 0 if found is None else found.now_ns

    def _is_external(self, cell: Cell, scan: int) -> bool:
        """Whether a cell was changed between two scans: an input, or a tag that someone set or forced."""
        now = self.inputs(scan)
        if now is None:
            return False
        if any(Cell(leaf, index).overlaps(cell) for leaf, index, _ in now.writes):
            return True
        before = self.inputs(scan - 1) if scan else None
        if cell.leaf.is_image and not cell.leaf.output:
            return self.image(cell, scan) != (self.image(cell, scan - 1) if before is not None else 0)
        forces = now.forces or {}
        earlier = (before.forces if before is not None else None) or {}
        key = cell.leaf.ident, cell.index
        return forces.get(key) != earlier.get(key)

    def image(self, cell: Cell, scan: int) -> Value:
        """Return a cell of an input image in a scan; a bit as a bool."""
        inputs = self.inputs(scan)
        if inputs is None or not inputs.images:
            return 0
        place = [leaf.ident for leaf in self._past.images].index(cell.leaf.ident)
        data = inputs.images[place][2 * cell.index : 2 * cell.index + 2]
        word = int.from_bytes(data, "little", signed=True)
        return word if cell.mask is None else bool(word & cell.mask)

    # --- changes

    def origins(self, cells: Sequence[Cell], scan: int, order: int | None = None) -> list[CellChange]:
        """Return the latest changes of cells, all of one scan, the latest one.

        Args:
            order: only changes before this place in the scan count; None for all of it.
        """
        found = list(self._in_scan(cells, scan, order))
        if found or scan == 0:
            return found
        last = self._past.last_change_of(cells, scan - 1)
        return [] if last is None else list(self._in_scan(cells, last, None))

    def triggers(self, pending: Leaf, scan: int) -> list[CellChange]:
        """Return the EVENT that made a task due, in a scan or the one before."""
        for at in (scan, scan - 1):
            for each in reversed(self.execution(at).writes):
                if each.cell.leaf is pending and each.after and each.by is not None:
                    return [CellChange(at, each.cell, each)]
        return []

    def _in_scan(self, cells: Iterable[Cell], scan: int, order: int | None) -> Iterator[CellChange]:
        execution = self.execution(scan)
        for cell in cells:
            write = execution.last_write(cell, order)
            if write is not None and (order is not None or execution.changes(cell)):
                yield CellChange(scan, cell, write)
            elif write is None and self._is_external(cell, scan):
                yield CellChange(scan, cell, None)

    def of(self, origin: CellChange) -> list[list[Cause]]:
        """Return groups of causes of a change; of a group with several each would have done."""
        write = origin.write
        if write is None or write.by is None:
            return []
        entry, scan = write.by, origin.scan
        reads = list(self._used(entry, origin.cell))
        groups = [*self._control(entry, scan), *([each] for each in self._data(entry, scan, reads))]
        groups += self._overwriter(origin)
        if not any(groups):
            groups = [[each] for each in self._latest(entry, scan, reads)]
        return [group for group in groups if group]

    def _overwriter(self, origin: CellChange) -> list[list[Cause]]:
        """Return what took power from the instruction that wrote last in the scan before this one."""
        entry, scan = origin.write.by if origin.write else None, origin.scan
        if entry is None or not scan:
            return []
        earlier = next(
            (
                each.by
                for each in reversed(self.execution(scan - 1).writes)
                if each.cell.overlaps(origin.cell)
            ),
            None,
        )
        if earlier is None or (earlier.step is entry.step and earlier.instance == entry.instance):
            return []
        run = self.execution(scan).runs.get(earlier.run.key)
        now = None if run is None else run.steps.get(id(earlier.step))
        return [] if now is None or now.power else self._control(now, scan)

    def _used(self, entry: StepRun, cell: Cell) -> Iterator[Read]:
        """Yield what a cell was made of: of a copied one the same part of the source."""
        copied = self._source(entry, cell)
        for each in entry.reads:
            if copied is not None and each.cell.leaf is copied.leaf and each.cell.index == copied.index:
                yield Read(copied, copied.of(each.value), copied.name if copied.mask else each.text)
            elif copied is None and entry.step.name == "MOV" and each.cell.leaf.type is cell.leaf.type:
                same = Cell(each.cell.leaf, each.cell.index, each.cell.mask or cell.mask)
                yield Read(same, same.of(each.value), same.name if same.mask else each.text)
            elif copied is None or each.cell.leaf is not copied.leaf:
                yield each

    def _source(self, entry: StepRun, cell: Cell) -> Cell | None:
        """Return the cell that was copied to a cell; None if that is not known."""
        if entry.copied is None:
            return None
        source, destination = entry.copied
        rest = cell.leaf.path.upper().removeprefix(destination.path.upper())
        leaf = self._engine.lowered.layout.leaves.get(f"{source.path}{rest}".upper())
        if leaf is None or leaf.type is not cell.leaf.type:
            return None
        index = cell.index - destination.first + source.first
        return Cell(leaf, index, cell.mask) if 0 <= index < leaf.size else None

    def _before(self, entry: StepRun, scan: int) -> StepRun | None:
        """Return the run of an instruction in the scan before."""
        run = self._run_before(entry.run, scan)
        return None if run is None else run.steps.get(id(entry.step))

    def _run_before(self, run: LineRun, scan: int) -> LineRun | None:
        return self.execution(scan - 1).runs.get(run.key) if scan else None

    def _data(self, entry: StepRun, scan: int, reads: Sequence[Read] | None = None) -> Iterator[Cause]:
        """Yield the values that an instruction has read otherwise than before."""
        before = self._before(entry, scan)
        earlier = {} if before is None else {each.cell: each.value for each in before.reads}
        for each in entry.reads if reads is None else reads:
            whole = Cell(each.cell.leaf, each.cell.index)
            if each.cell in earlier:
                differs = not same(earlier[each.cell], each.value)
            else:
                differs = whole in earlier and not same(each.cell.of(earlier[whole]), each.value)
            if differs and not self._is_own(each, entry, scan):
                yield Cause(each, entry)

    def _is_own(self, read: Read, entry: StepRun, scan: int) -> bool:
        """Whether an instruction writes itself what it reads, such as ACC."""
        member = read.text.rpartition(".")[2].upper()
        for each, use in zip(entry.step.operands, entry.step.uses, strict=False):
            is_part = isinstance(each, Group) and read.cell.leaf.path.startswith(f"{each.path}.")
            is_given = member in _GIVEN or (use is Use.BLOCK and not member.startswith(HIDDEN))
            if is_part and use in BOTH_WAYS and not is_given:
                return True
        for at in (scan, scan - 1):
            for each in self.execution(at).writes if at >= 0 else ():
                by = each.by
                if (
                    by is not None
                    and each.cell.overlaps(read.cell)
                    and (by.number, by.instance) == (entry.number, entry.instance)
                ):
                    return True
        return False

    def _control(self, entry: StepRun, scan: int) -> list[list[Cause]]:
        """Return what let power come to an instruction, or took it away."""
        if entry.parent is not None:
            copied = [[each] for contact in entry.ahead for each in self._data(contact, scan)]
            return copied or self._control(entry.parent, scan)
        groups: list[list[Cause]] = []
        before = self._run_before(entry.run, scan)
        earlier = None if before is None else before.steps.get(id(entry.step))
        if before is not None and earlier is not None and earlier.power != entry.power:
            groups += self._all(tuple(prefix(entry)), entry.run, before, scan)
        for head in entry.run.heads:
            groups += [[each] for each in self._data(head, scan)]
        if entry.run.caller is not None:
            groups += self._control(entry.run.caller, scan)
        return groups

    def _all(self, nodes: Sequence[Node], run: LineRun, before: LineRun, scan: int) -> list[list[Cause]]:
        """Explain the power after nodes in series."""
        parts = [each for each in nodes if _changed(each, run, before)]
        if all(_truth(each, run) is not False for each in nodes):
            return [group for each in parts for group in self._one(each, run, before, scan)]
        return _any([self._one(each, run, before, scan) for each in parts if _truth(each, run) is False])

    def _one(self, node: Node, run: LineRun, before: LineRun, scan: int) -> list[list[Cause]]:
        if isinstance(node, LoweredStep):
            entry = run.steps[id(node)]
            return [[each] for each in self._data(entry, scan)]
        now = _truth(node, run)
        legs = [leg for leg in node.legs if _series(leg, run) == now and _series(leg, before) != now]
        found = [self._all(leg, run, before, scan) for leg in legs]
        return _any(found) if now else [group for each in found for group in each]

    # --- without a difference

    def _latest(self, entry: StepRun, scan: int, own: Sequence[Read]) -> list[Cause]:
        """Return the latest change of all that an instruction depends on; `own` are its reads."""
        reads = [pair for pair in self._reads(entry, own) if not self._is_own(pair[0], pair[1], scan)]
        found: list[tuple[Cause, CellChange]] = []
        for read, by in reads:
            for origin in self._in_scan([read.cell], scan, by.order):
                found.append((Cause(read, by, changed=False), origin))
        if not found and scan and reads:
            cells = list(dict.fromkeys(read.cell for read, _ in reads))
            changed = {each.cell for each in self.origins(cells, scan - 1)}
            return [Cause(read, by, changed=False) for read, by in reads if read.cell in changed]
        last = max((_order(origin) for _, origin in found), default=0)
        return [cause for cause, origin in found if _order(origin) == last]

    def _reads(self, entry: StepRun, own: Sequence[Read]) -> Iterator[tuple[Read, StepRun]]:
        """Yield what an instruction depends on: its operands, the conditions before it and around it."""
        if entry.power or entry.step.kind is InstructionKind.BOTH:
            yield from ((each, entry) for each in own)
        for contact in entry.ahead:
            yield from ((each, contact) for each in contact.reads)
        yield from self._reads_of_power(entry.parent or entry)

    def _reads_of_power(self, entry: StepRun) -> Iterator[tuple[Read, StepRun]]:
        for step in steps_of(tuple(prefix(entry)), copies=False):
            other = entry.run.steps.get(id(step))
            if other is not None and other.truth is entry.power and decides(step):
                yield from ((each, other) for each in other.reads)
                if step.spec.decides and other.power:  # a one-shot blocks because of what let power come
                    yield from self._reads_of_power(other)
        for head in entry.run.heads:
            yield from ((each, head) for each in head.reads)
        if entry.run.caller is not None:
            yield from self._reads_of_power(entry.run.caller)


_GIVEN = ("PRE", "LEN")
"""Members of an instruction's structure that it only reads; of a block's those that it does not write."""


def _order(origin: CellChange) -> int:
    return origin.write.order if origin.write else 0


def _any(options: list[list[list[Cause]]]) -> list[list[Cause]]:
    """Return options as groups: one option as it is, of several each cause would have done."""
    options = [each for each in options if each]
    if len(options) <= 1:
        return options[0] if options else []
    return [[cause for option in options for group in option for cause in group]]


def prefix(entry: StepRun) -> Iterator[Node]:
    """Yield what is in series before an instruction."""
    nodes: Sequence[Node] = entry.run.line.nodes
    while True:
        for node in nodes:
            if node is entry.step:
                return
            if isinstance(node, Parallel) and _has(node, entry.step):
                nodes = next(
                    leg
                    for leg in node.legs
                    if any(each is entry.step or _has(each, entry.step) for each in leg)
                )
                break
            yield node
        else:
            return


def _has(node: Node, step: LoweredStep) -> bool:
    return isinstance(node, Parallel) and any(
        each is step or _has(each, step) for leg in node.legs for each in leg
    )


def decides(step: LoweredStep) -> bool:
    """Whether an instruction lets power on or not."""
    return step.kind is InstructionKind.INPUT or step.spec.decides


def _truth(node: Node, run: LineRun) -> bool | None:
    """Whether a contact or a branch conducts in a run; None if that is not known."""
    if isinstance(node, Parallel):
        legs = [_series(leg, run) for leg in node.legs]
        return True if True in legs else None if None in legs else False
    entry = run.steps.get(id(node))
    if entry is None:
        return None
    return entry.truth if decides(node) else True


def _series(nodes: Sequence[Node], run: LineRun) -> bool | None:
    truths = [_truth(each, run) for each in nodes]
    return False if False in truths else None if None in truths else True


def _changed(node: Node, run: LineRun, before: LineRun) -> bool:
    return _truth(node, run) is not _truth(node, before)
