"""Explains why a value never changed, from its writers' false contacts back to inputs that did not change.

The instruction with the fewest false contacts came closest, see `lacking`. A false contact that has changed
has its own chain of causes. Any other contact is explained in the same way, down to an input, a running
timer, or a tag that was never set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence, Set
from dataclasses import replace
from typing import Any, Protocol

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds

from ..state.lowered import ADD_ON
from ..state.memory import Value
from .causes import Causes, CellChange
from .cells import Cell
from .crossref import CrossReference, Mention
from .executed import Read
from .lacking import Lack, Lacking
from .links import CauseLink, Operand, kind_at, linked

DEEPEST = 24
"""Maximum depth of a chain, in links."""

PULSE = 2
"""Maximum length of a pulse, in scans."""

ONLY_ON, ONLY_OFF = frozenset({"OTL"}), frozenset({"OTU", "RES", "CLR"})
"""Instructions that can only set a bit, and instructions that can only clear it."""

ChainOfChange = Callable[[CellChange, str], CauseLink]
"""Returns the chain of a change."""

AtRest = Callable[[Cell, str, Value, int], CauseLink | None]
"""Returns a link for an unchanged input, from cell, name, value and scan; None if it can't."""


class Blocks(Protocol):
    """Explains the blocks of an axis by the state of its module."""

    def waiting(self, path: str, scan: int) -> CauseLink | None:
        """Return a link to the event that a busy block is waiting for; None for any other structure."""

    def failed(self, path: str, since: int, scan: int) -> CauseLink | None:
        """Return the module's rule that ended a block with an error between two scans, or None."""


@dataclass(slots=True)
class Never:
    """Explains values that have not changed by the end of a scan.

    Args:
        causes: finds causes in the program's past.
        scan: the scan at whose end the values are explained.
        chain_of: builds the chain of a change.
        at_rest: explains inputs.
        blocks: explains the blocks of an axis; None = no blocks.
    """

    causes: Causes
    scan: int
    chain_of: ChainOfChange
    at_rest: AtRest
    blocks: Blocks | None
    _lacking: Lacking | None = None
    _reference: CrossReference | None = None

    def link_of(self, cell: Cell, name: str, visited: tuple[Cell, ...] = ()) -> CauseLink:
        """Return the link of a value that has not changed; `visited` are the cells that led to it."""
        value = self._value(cell)
        if cell.leaf.is_input:
            chain = self.at_rest(cell, name, value, self.scan)
            return chain or self._root("input", name, value, f"slot {cell.leaf.slot}")
        chain = self._counter_link(cell, name, value) or self._block_link(cell, value, visited)
        return chain or self._writers_link(cell, name, value, visited)

    def _read_link(self, read: Read, visited: tuple[Cell, ...]) -> CauseLink:
        """Return the link of a value that was read: its change, or the reason why it never changed."""
        cell, name = read.cell, read.text
        origins = self.causes.origins([cell], self.scan)
        if not origins:
            return self.link_of(cell, name, (*visited, cell))
        value = self._value(cell)
        chain = self._number_link(origins[0], name, visited) or self._counter_link(cell, name, value)
        return chain or self._block_link(cell, value, visited) or self.chain_of(origins[0], name)

    def _block_link(self, cell: Cell, value: Value, visited: tuple[Cell, ...]) -> CauseLink | None:
        """Return a link for the wait of a busy block, or for its error; None for any other value."""
        path, _, member = cell.leaf.path.rpartition(".")
        if member.upper() not in ("BUSY", "DONE", "ACTIVE", "INVELOCITY"):
            return None
        if (member.upper() == "BUSY") is not bool(value) or not isinstance(value, bool):
            return None
        busy, error = self._member(path, "Busy", cell.index), self._member(path, "Error", cell.index)
        if busy is not None and busy[1]:
            return None if self.blocks is None else self.blocks.waiting(path, self.scan)
        if error is not None and error[1] and error[0] not in visited:
            return self._read_link(Read(error[0], error[1], error[0].name), visited)
        return None

    def _number_link(self, origin: CellChange, name: str, visited: tuple[Cell, ...]) -> CauseLink | None:
        """Return the link of a number that was computed from settings; None for any other change."""
        write = origin.write
        if write is None or write.writer is None or isinstance(self._value(origin.cell), bool):
            return None
        if len(visited) > DEEPEST:
            return None
        settings = [
            read for read in write.writer.reads if not isinstance(read.value, bool) and self._is_setting(read)
        ]
        if not settings:
            return None
        site = self._engine.lowered.sites[write.writer.number]
        causes = [
            (self.link_of(setting.cell, setting.text, (*visited, origin.cell)),)
            for setting in reversed(settings)
        ]
        return linked(
            causes, kind=kind_at(site), name=name, value=write.after,
            scan=origin.scan, now_ns=self.causes.now_ns(origin.scan), text=site.instruction, site=site,
        )  # fmt: skip

    def _is_setting(self, read: Read) -> bool:
        """Return whether a value belongs to a tag that no instruction writes and that never changed."""
        cell = read.cell
        return (
            cell.leaf.slot is None and not self._writers(cell) and not self.causes.origins([cell], self.scan)
        )

    # --- timers and counters

    def _counter_link(self, cell: Cell, name: str, value: Value) -> CauseLink | None:
        """Return the link of a running timer, or of a counter above 0, if the cell is its DN."""
        path, _, member = cell.leaf.path.rpartition(".")
        if member.upper() not in ("DN", "Q") or value:
            return None
        counted, preset, enabled, up, down = (
            self._member(path, suffix, cell.index) for suffix in ("ACC", "PRE", "EN", "CU", "CD")
        )
        if counted is None or preset is None:
            return None
        timer = name.rpartition(".")[0]
        acc, pre = int(counted[1]), int(preset[1])
        if enabled is not None:
            return self._timer_link(enabled[0], timer, acc, pre) if enabled[1] and acc < pre else None
        if not (up or down) or not 0 < acc < pre:
            return None
        origins = self.causes.origins([counted[0]], self.scan)
        last = f", the last at {seconds(self.causes.now_ns(origins[0].scan))} s" if origins else ""
        return self._root("timer", timer, None, f"has counted {acc:,} of {pre:,}{last}")

    def _timer_link(self, enabled: Cell, timer: str, acc: int, pre: int) -> CauseLink:
        """Return the link of a running timer, with its start and its remaining time; times are in ms."""
        origins = self.causes.origins([enabled], self.scan)
        since = self.causes.now_ns(origins[0].scan) if origins else 0
        text = f"runs since {seconds(since)} s: {_ms(acc)} of {_ms(pre)}, done in {_ms(pre - acc)}"
        scan = origins[0].scan if origins else 0
        return CauseLink("timer", timer, None, scan, now_ns=since, text=text)

    def _member(self, path: str, name: str, index: int) -> tuple[Cell, Value] | None:
        """Return the cell and value of a structure's member; None if there is no such member."""
        leaf = self._engine.lowered.layout.leaves.get(f"{path}.{name}".upper())
        if leaf is None or index >= leaf.size:
            return None
        cell = Cell(leaf, index)
        return cell, self._value(cell)

    # --- instructions

    def _writers_link(self, cell: Cell, name: str, value: Value, visited: tuple[Cell, ...]) -> CauseLink:
        """Return the link of a value, based on the instruction that came closest to changing it."""
        writers = self._possible_writers(cell, value)
        if not writers:
            return self._unwritten_link(name, value)
        if len(visited) > DEEPEST:
            return self._root("unknown", name, value, f"more than {DEEPEST} links")
        chain_cells = {cell, *visited}
        mention, lack = self._nearest_writer(writers, chain_cells)
        scan, lack = self._nearest(mention, lack)
        viewpoint = self if scan == self.scan else replace(self, scan=scan, _lacking=None)
        causes = [
            (viewpoint._read_link(read, (*visited, cell)),)
            for read, _ in lack
            if read.cell not in chain_cells
        ]
        sites = self._engine.lowered.sites
        texts = dict.fromkeys(sites[run.number].instruction for _, run in lack)
        site = mention.site
        was = "is" if scan == self.scan else f"at {seconds(self.causes.now_ns(scan))} s was"
        return linked(
            causes,
            kind="never",
            name=name,
            value=value,
            scan=0,
            now_ns=self.causes.now_ns(0),
            text=f"{' '.join(texts)} {was} false" if texts else f"{site.instruction} has not changed it",
            site=site,
            operands=tuple(Operand(read.text, read.value, changed=False) for read, _ in lack),
        )

    def _possible_writers(self, cell: Cell, value: Value) -> list[Mention]:
        """Return the mentions that could change a value; return add-on calls only if nothing else could."""
        writers = [writer for writer in self._writers(cell) if _could_change(writer, value)]
        return [writer for writer in writers if writer.step is None or writer.step.name != ADD_ON] or writers

    def _nearest_writer(self, writers: Sequence[Mention], chain_cells: Set[Cell]) -> tuple[Mention, Lack]:
        """Return the instruction that lacks the fewest values in the scan.

        An instruction that lacks a value from the chain itself explains nothing, so it is returned only if
        all instructions lack a value from the chain.
        """
        lacks = [(writer, self._lack(writer)) for writer in writers]
        explaining = [
            (writer, lack) for writer, lack in lacks if chain_cells.isdisjoint(read.cell for read, _ in lack)
        ]
        return min(explaining or lacks, key=lambda pair: (not pair[1], len(pair[1])))

    def _lack(self, mention: Mention) -> Lack:
        """Return the values that an instruction lacked in the scan."""
        if self._lacking is None:
            self._lacking = Lacking(self._engine.lowered, self.causes.execution(self.scan))
        return self._lacking.lack_of(mention)

    def _nearest(self, mention: Mention, lack: Lack) -> tuple[int, Lack]:
        """Return the scan in which an instruction came closest to acting, and the values it lacked then.

        One contact may have pulsed while another contact was false. Therefore, for each false contact that
        was true for one or two scans, the last scan of its pulse is also examined.
        """
        best = self.scan, lack
        for read, _ in lack if len(lack) > 1 else ():
            origins = self.causes.origins([read.cell], self.scan)
            earlier = origins[0].scan - 1 if origins else -1
            previous_origins = self.causes.origins([read.cell], earlier) if earlier >= 0 else []
            if not previous_origins or earlier - previous_origins[0].scan >= PULSE:
                continue
            lacking = replace(self, scan=earlier, _lacking=None)._lack(mention)
            if lacking and len(lacking) < len(best[1]):
                best = earlier, lacking
        return best

    def _unwritten_link(self, name: str, value: Value) -> CauseLink:
        """Return the link of a value that nothing writes: an operator bit or a number as a setting."""
        if isinstance(value, bool):
            return self._root(
                "operator",
                name,
                value,
                f"never {'off' if value else 'on'}: no rung writes it, and no one has set it",
            )
        return self._root("setting", name, value, "its initial value: no rung writes it")

    def _root(self, kind: str, name: str, value: Value | None, text: str) -> CauseLink:
        """Return a link without causes, at the time of the first scan."""
        return CauseLink(kind, name, value, 0, self.causes.now_ns(0), text)

    def _writers(self, cell: Cell) -> Sequence[Mention]:
        if self._reference is None:
            self._reference = CrossReference(self._engine.lowered)
        return self._reference.writers(cell.leaf, cell.index, cell.mask)

    def _value(self, cell: Cell) -> Value:
        return self.causes.value(cell, self.scan)

    @property
    def _engine(self) -> Any:
        return self.causes.engine


def _could_change(mention: Mention, value: Value) -> bool:
    """Return whether an instruction could change a value; OTL, for example, can't change a bit that is on."""
    name = mention.step.name if mention.step is not None else ""
    if not isinstance(value, bool):
        return True
    return name not in (ONLY_ON if value else ONLY_OFF)


def _ms(milliseconds: int) -> str:
    """Return a timer's time as text.

    >>> _ms(496), _ms(1500)
    ('496 ms', '1.5 s')
    """
    return f"{milliseconds} ms" if milliseconds < 1000 else f"{seconds(milliseconds * 1_000_000)} s"
