"""Chains of causes, from a tag back through rungs, add-on instructions and statements."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field
from itertools import chain

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site
from scanrack.io_images.times import time_text

from ..model.resolver import Resolver
from ..model.schedule import TaskKind
from ..state.lowered import LoweredProgram
from ..state.memory import Value
from .causes import Cause, Causes, CellChange
from .cells import Cell, cells_of
from .executed import StepRun
from .links import CauseLink, Operand, kind_at, linked
from .motions import COMPLETE, Motions, motion_text
from .never import AtRest, Blocks, Never
from .watched import shown

EARLIER = "earlier scans are not kept"
"""Text of a link whose earlier scans can't be repeated."""

DEEPEST = 200
"""Maximum depth of a chain, in links."""

NESTED = 8
"""Maximum depth of nested Python calls that build links."""

Outside = Callable[[CellChange, str, Value], CauseLink | None]
"""Returns a link that explains an input, from the cell's change, name and value; None if it can't."""


class _NestedError(Exception):
    """A link is nested too deeply; `link_of` then builds it with an empty Python stack."""

    def __init__(self, origin: CellChange, name: str, depth: int) -> None:
        self.origin, self.name, self.depth = origin, name, depth


@dataclass(slots=True)
class Chains:
    """Builds the chains of causes of a program.

    Args:
        causes: finds the causes of changes in the program's past.
        deep: whether rungs inside add-on instructions are links; if not, calls to the instructions are.
        outside: explains inputs that changed; by default, chains end at the images.
        most: maximum depth of a chain, in links, including links through modules.
        at_rest: explains inputs that have not changed.
        blocks: explains the blocks of an axis; None = no blocks.
        run_mode: returns the event before the first scan in run mode; "" if it is unknown.
    """

    lowered: LoweredProgram
    causes: Causes
    deep: bool = False
    outside: Outside = lambda _origin, _name, _value: None
    most: int = DEEPEST
    at_rest: AtRest = lambda _cell, _name, _value, _scan: None
    blocks: Blocks | None = None
    run_mode: Callable[[int], str] = lambda _scan: ""
    _links: dict[tuple[Cell, int, int], CauseLink] = field(default_factory=dict)
    _depth: int = 0
    _nested: int = 0

    def of_tag(self, tag: str, scan: int) -> CauseLink | None:
        """Return the chain of a tag's value after a scan; None for a structure that has not changed."""
        cells = self.cells(tag)
        origins = self.causes.origins(cells, scan)
        if not origins:
            return self.never(cells[0], tag, scan) if len(cells) == 1 else None
        last = max(origins, key=lambda origin: origin.write.order if origin.write else 0)
        name = tag if len(cells) == 1 else last.cell.name
        return self.link_of(last, name)

    def of_cell(self, cell: Cell, name: str, scan: int) -> CauseLink | None:
        """Return the chain of a cell after a scan."""
        origins = self.causes.origins([cell], scan)
        return self.link_of(origins[0], name) if origins else self.never(cell, name, scan)

    def never(self, cell: Cell, name: str, scan: int) -> CauseLink:
        """Return the chain of a value that had not changed by the end of a scan, see `Never`."""
        return Never(self.causes, scan, self.link_of, self.at_rest, self.blocks).link_of(cell, name)

    def cells(self, tag: str) -> list[Cell]:
        """Return a tag's cells (a timer's or counter's bits); raise a ValueError for an unknown name."""
        return cells_of(Resolver(self.lowered.layout).named(tag))

    def full_name(self, tag: str) -> str:
        """Return the name of a tag in the form that forces use."""
        return Resolver(self.lowered.layout).base_name(tag)

    def link_of(self, origin: CellChange, name: str) -> CauseLink:
        """Return the link of a change.

        A link's causes must be built before the link. Calls nest at most `NESTED` deep. The loop builds a
        deeper link separately and stores it in `_links`, then retries the links that need it.
        """
        if self._nested:
            return self._cached_link(origin, name)
        pending = [(origin, name, self._depth)]
        while True:
            outer_depth = self._depth
            try:
                origin, name, self._depth = pending[-1]
                link = self._cached_link(origin, name)
            except _NestedError as deeper:
                pending.append((deeper.origin, deeper.name, deeper.depth))
            else:
                pending.pop()
                if not pending:
                    return link
            finally:
                self._depth = outer_depth

    def _cached_link(self, origin: CellChange, name: str) -> CauseLink:
        """Return the link of a change; `_links` caches it.

        Raises:
            _NestedError: the calls are `NESTED` deep.
        """
        key = origin.cell, origin.scan, origin.write.order if origin.write else 0
        link = self._links.get(key)
        if link is None:
            if self._nested == NESTED:
                raise _NestedError(origin, name, self._depth)
            self._depth += 1
            self._nested += 1
            try:
                self._links[key] = link = self._link(origin, name)
            finally:
                self._depth -= 1
                self._nested -= 1
        return link

    def _link(self, origin: CellChange, name: str) -> CauseLink:
        """Return a new link for a change by an instruction, a motion, the rack or an operator."""
        scan, motions = origin.scan, Motions(self.lowered, self.causes)
        now_ns = self.causes.now_ns(scan)
        if origin.write is None or self._is_set_outside(origin):
            return self._outside_link(origin, name, now_ns)
        if origin.write.writer is None:
            origin = motions.attributed(origin)
        write = origin.write
        assert write is not None
        value = origin.cell.in_value(write.after)
        if write.writer is None:
            moved = self._motion_link(motions, origin, name, value)
            return moved or self._uncaused_link(origin, name, value, now_ns)
        if self._depth > self.most:
            return CauseLink("unknown", name, value, scan, now_ns, f"more than {self.most} links")
        return self._instruction_link(origin, write.writer, name, value, origin.cell.in_value(write.before))

    def _instruction_link(
        self, origin: CellChange, entry: StepRun, name: str, value: Value, before: Value
    ) -> CauseLink:
        """Return the link of a change that an instruction made."""
        scan, site = origin.scan, self._site(entry)
        groups = self.causes.groups_of(origin)
        causes = [cause for group in groups for cause in group]
        link_groups = [
            tuple(link for cause in group for link in self._causes_of(cause, scan)) for group in groups
        ]
        if not any(link_groups):
            link_groups = [(trigger,) for trigger in self._triggers(entry, scan)]
        return linked(
            self._refusals(origin, value) or self._without_calls(link_groups, entry),
            kind=kind_at(site),
            name=name,
            value=value,
            before=before,
            scan=scan,
            now_ns=self.causes.now_ns(scan),
            text=self._text(origin, entry, causes, value),
            site=site,
            operands=_operands(entry, causes),
        )

    def _refusals(self, origin: CellChange, value: Value) -> list[tuple[CauseLink, ...]]:
        """Return the module's rule that ended a block with an error; [] for any other change."""
        path, _, member = origin.cell.leaf.path.rpartition(".")
        if self.blocks is None or member.upper() not in ("ERROR", "ERRORID") or not value:
            return []
        busy = self.lowered.layout.leaves.get(f"{path}.Busy".upper())
        begun = (
            self.causes.origins([Cell(busy, origin.cell.index)], origin.scan - 1)
            if busy and origin.scan
            else []
        )
        link = self.blocks.failed(path, begun[0].scan if begun else 0, origin.scan)
        return [(link,)] if link else []

    def _triggers(self, entry: StepRun, scan: int) -> Iterator[CauseLink]:
        """Yield the reason why an instruction without conditions ran: the first scan, or its task."""
        now_ns = self.causes.now_ns(scan)
        if scan == 0:
            yield CauseLink("power-up", "power-up", None, scan, now_ns)
            return
        while entry.run.caller is not None:
            entry = entry.run.caller
        tasks = self.lowered.schedule.tasks if self.lowered.schedule else ()
        for task in tasks:
            name = f"task {task.task.name}"
            if all(program.main != entry.run.routine for program in task.programs):
                continue
            if task.task.kind is TaskKind.PERIODIC:
                text = f"every {time_text(task.task.rate_ns)}"
                yield CauseLink("task", name, None, scan, now_ns, text)
            elif task.task.kind is TaskKind.EVENT:
                yield from (self.link_of(origin, name) for origin in self.causes.triggers(task.pending, scan))

    def _causes_of(self, cause: Cause, scan: int) -> Iterator[CauseLink]:
        """Yield the links of the latest changes in a value that an instruction read."""
        try:
            origins = self.causes.origins([cause.read.cell], scan, cause.reader.order)
            yield from (self.link_of(origin, cause.read.text) for origin in origins)
        except ValueError:  # the scan can't be repeated
            yield CauseLink(
                "unknown", cause.read.text, cause.read.value, scan, self.causes.now_ns(scan), EARLIER
            )

    def _motion_link(self, motions: Motions, origin: CellChange, name: str, value: Value) -> CauseLink | None:
        """Return the link of a change caused by motion after a scan; None for any other change."""
        moves = list(motions.movers(origin))
        if not moves:
            return None
        scan, text = origin.scan, moves[0][2]
        movers = (self.of_cell(cell, bit_name, scan - (text == COMPLETE)) for cell, bit_name, _ in moves)
        return linked(
            [(mover,) for mover in movers if mover],
            kind="rung",
            name=name,
            value=value,
            scan=scan,
            now_ns=self.causes.now_ns(scan),
            text=text.format(", ".join(bit_name.removesuffix(".IP") for _, bit_name, _ in moves)),
        )

    def _uncaused_link(self, origin: CellChange, name: str, value: Value, now_ns: int) -> CauseLink:
        """Return the link of a change not made by an instruction: a consumed tag's sample, or prescan."""
        assert origin.write is not None
        common = (name, value, origin.scan, now_ns)
        for connection in self.lowered.connections:
            if f"{origin.cell.leaf.path}.".upper().startswith(f"{connection.tag}.".upper()):
                link = self.outside(origin, name, value)
                return link or CauseLink("partner", *common, f"a sample of {connection.tag}")
        if origin.write.mode and origin.scan:
            earlier_mode = self.run_mode(origin.scan)
            text = f"the CPU went to run mode: its first scan begins with {origin.write.mode}"
            return CauseLink("mode", *common, f"{earlier_mode}, then {text}" if earlier_mode else text)
        return CauseLink("power-up", *common, origin.write.mode or "the start of the scan")

    def _outside_link(self, origin: CellChange, name: str, now_ns: int) -> CauseLink:
        """Return the link of a change between two scans: an input, a force, or a value that was set."""
        cell, scan = origin.cell, origin.scan
        leaf, written = cell.leaf, self.causes.written(cell, scan)
        if leaf.is_image and not leaf.output and not written:
            value = self.causes.image(cell, scan)
            link = self.outside(origin, name, value)
            return link or CauseLink("input", name, value, scan, now_ns, terminal_text(cell))
        if not written:
            is_forced = self.causes.force(cell, scan) is not None
            text = "forced" if is_forced else "its force was removed"
            return CauseLink("force", name, None, scan, now_ns, text)
        value = cell.in_value(written[-1])
        if self.causes.force(cell, scan) is not None:
            return CauseLink("force", name, value, scan, now_ns, f"forced to {shown(value)}")
        if leaf.slot is None:
            return CauseLink("operator", name, value, scan, now_ns, "set from outside of the program")
        link = self.outside(origin, name, value)
        return link or CauseLink("incident", name, value, scan, now_ns, f"slot {leaf.slot}")

    def _is_set_outside(self, origin: CellChange) -> bool:
        """Return whether a tag was set between two scans."""
        write = origin.write
        return (
            write is not None and write.writer is None and bool(self.causes.written(origin.cell, origin.scan))
        )

    # --- places

    def _outermost(self, entry: StepRun) -> StepRun:
        """Return the instruction in the user's program that contains this run."""
        entry = entry.parent or entry
        while entry.run.caller is not None and (entry.run.instance and not self.deep):
            entry = entry.run.caller.parent or entry.run.caller
        return entry

    def _site(self, entry: StepRun) -> Site:
        """Return the place of an instruction, or of the call that contains it, in the user's program."""
        return self.lowered.sites[self._outermost(entry).number]

    def _without_calls(
        self, groups: Sequence[tuple[CauseLink, ...]], entry: StepRun
    ) -> Iterator[tuple[CauseLink, ...]]:
        """Yield groups in which links to the same add-on call are replaced by their causes."""
        site = self._site(entry)
        inside = not self.deep and (entry.run.instance or entry.parent is not None)
        for group in filter(None, groups):
            replacements = [
                link.causes if inside and link.site is site and link.causes else ((link,),) for link in group
            ]
            if len(replacements) == 1:
                yield from replacements[0]
            else:
                yield tuple(chain.from_iterable(chain.from_iterable(replacements)))

    def _text(self, origin: CellChange, entry: StepRun, causes: Sequence[Cause], value: Value) -> str:
        """Return the text of a link: a motion instruction's effect, and the contacts that decided it."""
        writes = self.causes.execution(origin.scan).writes
        motion, text = motion_text(entry, origin.cell, value, writes), self._decided(entry, causes)
        if not motion:
            return text
        return motion if text == self.lowered.sites[entry.number].instruction else f"{motion}, by {text}"

    def _decided(self, entry: StepRun, causes: Sequence[Cause]) -> str:
        """Return the contacts that changed, as text; the instruction itself if none changed."""
        outer = self._outermost(entry)
        sites = self.lowered.sites
        if outer is not entry or sites[entry.number].unit != "rung":
            return sites[outer.number].instruction
        texts = dict.fromkeys(
            sites[cause.reader.number].instruction for cause in causes if cause.reader.run is entry.run
        )
        if causes and not any(cause.changed for cause in causes):
            return f"{sites[entry.number].instruction}, after {' '.join(texts)}".removesuffix(", after ")
        return " ".join(texts) or sites[entry.number].instruction


def terminal_text(cell: Cell) -> str:
    """Return the place of an input in the rack: `slot 2 input 1`, or `slot 2 input word 3`."""
    side = "output" if cell.leaf.output else "input"
    if cell.mask is None:
        return f"slot {cell.leaf.slot} {side} word {cell.index}"
    return f"slot {cell.leaf.slot} {side} {16 * cell.index + cell.mask.bit_length() - 1}"


def _operands(entry: StepRun, causes: Sequence[Cause]) -> tuple[Operand, ...]:
    """Return the values that the rung and the instruction read, without duplicates."""
    changed = {cause.read.cell for cause in causes if cause.changed}
    operands: dict[str, Operand] = {}
    for run in (*entry.run.steps.values(), *entry.run.heads, *(cause.reader for cause in causes)):
        if run.order <= entry.order:
            for read in run.reads:
                operands.setdefault(read.text, Operand(read.text, read.value, read.cell in changed))
    return tuple(operands.values())
