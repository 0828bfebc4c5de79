"""The chain of causes through a rack: images, modules and their rules, and the program."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from itertools import islice
from typing import Any

from scanrack.io_images.amci3601 import COMPLETION_BITS, MOTIONS, CommandMsw, StatusMsw
from scanrack.io_images.amci3601.rules.causes import BitCause, Origin, cause_of
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.io_images.times import seconds
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import CauseLink, Chains, Debugger, linked
from scanrack.ladder.debug.causes import CellChange
from scanrack.ladder.debug.cells import Cell
from scanrack.ladder.state.memory import Value
from scanrack.runtime.loop.incidents import FaultKind
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import PackedTrace

from ..load.loading import LoadedRack
from .bits import Bits, is_input_name, shows_input
from .chains.axis_blocks import slot_of
from .chains.partners import chain_of_partner
from .drive_waits import started
from .outranked import Outranking, forced, of_cpu, of_link, spellings
from .past import ALL_BITS, Past, SlotPast, event_text
from .waits import is_idle, refused_configuration, searches_home, waits

ANSWER = 2
"""Maximum number of scans from a change of an output image to the answer in the input image."""

_SWITCHED = {"rule", "home", "registration"}
"""Events that a terminal may have caused in a module: rules, and moves that end at an input."""

_CUT = {"cut short", "found no home", "stopped by the external input"}
"""Outcomes of a move that its command does not explain."""

_INCIDENTS = {kind.value for kind in FaultKind}

_BY_MOTION = COMPLETION_BITS | StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW
_ERRORS = StatusMsw.COMMAND_ERROR | StatusMsw.INVALID_PROFILE | StatusMsw.INPUT_ERROR | StatusMsw.HOME_INVALID
_RATES = StatusMsw.ACCELERATING | StatusMsw.DECELERATING | StatusMsw.HOLD_STATE


@dataclass(slots=True)
class RackChain:
    """Makes chains through a recording.

    Args:
        maker: makes the chains of a ladder program, see `Debugger.chains`; None for other programs.
        deep: see `Chains`.
        program: the ladder program, whose consumed tags are also explained; None for none.
    """

    recording: PackedTrace
    maker: Callable[..., Chains] | None = None
    deep: bool = False
    program: LadderLogic | None = None
    _known: dict[tuple[Bits, int], CauseLink] = field(default_factory=dict)
    _chains: Chains | None = None
    _events_of_scans: dict[int, list[TraceEvent]] | None = None
    _row_of_question: int = 0  # row of the scan in question

    # --- questions

    def of_tag(self, tag: str, row: int) -> CauseLink | None:
        """Return the chain of a ladder program's tag; None for a structure that has not changed."""
        chains, cells = self.chains, self.chains.cells(tag)
        leaf, scan = cells[0].leaf, self.recording.numbers[row]
        if leaf.is_image and leaf.slot is not None and leaf.ident not in chains.lowered.written_inputs:
            side = "out" if leaf.output else "in"
            return self.of_bits(Bits(leaf.slot, side, cells[0].index, _mask(cells[0])), tag, row)
        names = {tag, leaf.path, cells[0].name, chains.full_name(tag)}
        outranked = forced(self.recording.events, scan, names) or of_cpu(self.recording, row)
        stays = outranked is not None and outranked.kind == "fault" and chains.causes.origins(cells, scan)
        if outranked is None or stays:  # after a fault a tag can't change, but its value has its own cause
            self._row_of_question = row
            return chains.of_tag(tag, scan)
        while row and CpuMode(self.recording.flags[row] & MODE_MASK) is CpuMode.PROGRAM:
            row -= 1  # the program has not run since
        ran = self.recording.numbers[row]
        value = chains.causes.value(cells[0], ran) if len(cells) == 1 else None
        cause = self._outranked(outranked, tag, value)
        # after the key was turned to program, the value is the one that was set before
        if outranked.kind != "mode":
            return cause
        changed = chains.of_tag(tag, ran)
        return cause if changed is None else replace(cause, scan=changed.scan, now_ns=changed.now_ns)

    def of_bits(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Return the chain of bits of an image after a scan."""
        self._row_of_question = row
        return self._overruled(bits, name, row) or self._of_bits(bits, name, row)

    def _of_bits(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        changed = Past(self.recording, row).last_change(bits.slot, bits.image, bits.word, bits.mask)
        return self._of_rest(bits, name, row) if changed is None else self._of_change(bits, name, changed)

    def _overruled(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Return the link of what overrides the program or module in a scan; None if nothing does."""
        recording, scan = self.recording, self.recording.numbers[row]
        outranking = forced(recording.events, scan, spellings(bits.address)) or (
            of_cpu(recording, row) if bits.image == "out" else of_link(recording, self.slot(bits.slot), scan)
        )
        if outranking is None:
            return None
        cause = self._outranked(outranking, name, self.value(bits, row))
        # after the key was turned to program, the value is the one that was set before
        if outranking.kind != "mode":
            return cause
        changed = Past(recording, row).last_change(bits.slot, bits.image, bits.word, bits.mask)
        if changed is None:
            return cause
        return replace(cause, scan=recording.numbers[changed], now_ns=recording.times[changed])

    def _outranked(self, found: Outranking, name: str, value: Value | None) -> CauseLink:
        return CauseLink(found.kind, name, value, found.scan, found.now_ns, found.text)

    def slot(self, number: int) -> SlotInfo:
        """Return a slot of the recording."""
        return next(slot_info for slot_info in self.recording.slots if slot_info.number == number)

    @property
    def chains(self) -> Chains:
        """Makes the chains of the ladder program."""
        if self._chains is None:
            assert self.maker is not None
            hooks = {
                "outside": self._of_input,
                "at_rest": self._of_input_at_rest,
                "run_mode": self._before_run_mode,
            }
            self._chains = self.maker(deep=self.deep, **hooks, blocks=self)
        return self._chains

    def _before_run_mode(self, scan: int) -> str:
        """Return since when the key was at program before a first scan in run mode; "" if it was not."""
        row = bisect_left(self.recording.numbers, scan)
        mode = of_cpu(self.recording, row - 1) if 0 < row < len(self.recording.numbers) else None
        if mode is None or mode.kind != "mode":
            return ""
        return f"the key was at program since {seconds(mode.now_ns)} s"

    def of_module(self, number: int, name: str, row: int, head: str = "") -> CauseLink:
        """Return what a module does or waits for at a scan; a lost link takes precedence."""
        recording, slot = self.recording, self.slot(number)
        lost = of_link(recording, slot, recording.numbers[row])
        if lost is not None:
            return self._outranked(lost, name, None)
        past = SlotPast(Past(recording, row), slot)
        changed = past.past.last_change(number, "in", 0) or 0
        text = f"{head}slot {number}: {'; '.join(waits(past)[:2])}"
        return CauseLink("module", name, None, recording.numbers[changed], recording.times[changed], text)

    # --- the blocks of an axis, see `Blocks`

    def waiting(self, path: str, scan: int) -> CauseLink | None:
        """Return what a busy block waits for; None for any other structure."""
        slot, row = slot_of(self.chains.lowered, path), bisect_left(self.recording.numbers, scan)
        if slot is None or row >= len(self.recording.numbers):
            return None
        return self.of_module(slot, path, row, "busy: ")

    def failed(self, path: str, since: int, scan: int) -> CauseLink | None:
        """Return the module's bit that caused a block's error, with its rule; None if there is none."""
        slot = slot_of(self.chains.lowered, path)
        if slot is None:
            return None
        row = bisect_right(self.recording.numbers, scan) - 1
        now = Past(self.recording, row).words(slot, "in", row)[0]
        for bit in (StatusMsw.CONFIG_ERROR, *_ERRORS):
            if now & bit:
                return self._of_bits(Bits(slot, "in", 0, bit.value), f"slot{slot}.status.{bit.name}", row)
        return None

    def _of_input_at_rest(self, cell: Cell, name: str, value: Value, scan: int) -> CauseLink | None:
        """Explain a ladder program's input that has not changed."""
        slot = cell.leaf.slot
        if slot is None or all(slot_info.number != slot for slot_info in self.recording.slots):
            return None
        if not cell.leaf.is_image:
            loss = of_link(self.recording, self.slot(slot), scan)
            return self._outranked(loss, name, value) if loss else None
        row = bisect_left(self.recording.numbers, scan)
        if row == len(self.recording.numbers):
            return None
        bits = Bits(slot, "in", cell.index, _mask(cell))
        named = self._better(bits, name)
        return self._overruled(bits, named, row) or self._of_bits(bits, named, row)

    def _of_rest(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Explain bits of an image that have not changed; None if nothing is known about them."""
        slot = self.slot(bits.slot)
        if bits.image == "out":
            cell = self._cell(bits) if self.maker is not None else None
            return self.chains.of_cell(cell, name, self.recording.numbers[row]) if cell else None
        value = self.value(bits, row)
        when = 0, self.recording.times[0]
        if slot.words.modes is not None and not slot.is_stepper and not self._is_terminal(slot, bits):
            state = waits(SlotPast(Past(self.recording, row), slot))[0]
            return CauseLink("module", name, value, *when, f"slot {slot.number}: {state}")
        row_of = cause_of(bits.word, bits.mask.bit_length() - 1) if slot.is_stepper else None
        if bits.address.bit is None or (slot.is_stepper and row_of is None):
            return None
        if row_of is None or row_of.origin is Origin.TERMINAL:
            text = f"{self._terminal(slot, bits)}, never {'off' if value else 'on'}"
            return CauseLink("input", name, value, *when, text)
        return self._of_module_at_rest(bits, name, row, row_of)

    def _of_module_at_rest(self, bits: Bits, name: str, row: int, cause: BitCause) -> CauseLink:
        """Explain an unchanged status bit: what the module waits for, or a command that was never sent."""
        slot, value = self.slot(bits.slot), self.value(bits, row)
        parts: dict[str, Any] = {"kind": "module", "name": name, "value": value, "scan": 0}
        parts["now_ns"] = self.recording.times[0]
        past = SlotPast(Past(self.recording, row), slot)
        state = waits(past)[0]
        if value or not cause.commands or not is_idle(past):
            return CauseLink(**parts, text=f"slot {slot.number}: {state}")
        masks = [bit.value for bit in CommandMsw if bit & cause.commands]
        unsent = (self._never_sent(slot, mask, row) for mask in masks)
        causes = [(link,) for link in unsent if link is not None]
        return linked(causes[:1], **parts, text=f"{cause.off} [{cause.rules[0]}]")

    def _never_sent(self, slot: SlotInfo, mask: int, row: int) -> CauseLink | None:
        """Return the chain of a command bit that the program has not sent; None if nothing is known."""
        bits = Bits(slot.number, "out", 0, mask)
        names = [name for name, bit in slot.words.bits("O", 0) if mask >> bit & 1]
        return self._of_bits(
            bits, f"slot{slot.number}.command.{names[0]}" if names else str(bits.address), row
        )

    def _of_input(self, origin: CellChange, name: str, value: Value) -> CauseLink | None:
        """Explain a change of a ladder program's input."""
        cell = origin.cell
        if cell.leaf.slot is None:
            return self._of_partner(origin, name, value)
        if not cell.leaf.is_image:
            return self._of_connection(origin, name, value)
        bits = Bits(cell.leaf.slot, "in", cell.index, _mask(cell))
        row = bisect_left(self.recording.numbers, origin.scan)
        if row == len(self.recording.numbers) or self.recording.numbers[row] != origin.scan:
            return None  # the recording begins after it
        return self._of_change(bits, self._better(bits, name), row)

    def _of_connection(self, origin: CellChange, name: str, value: Value) -> CauseLink:
        """Explain a change of a connection fault, such as `axis.I.Fault`."""
        now_ns = self.chains.causes.now_ns(origin.scan)
        text = f"slot {origin.cell.leaf.slot}: the link to it is {'lost' if value else 'restored'}"
        return CauseLink("incident", name, value, origin.scan, now_ns, text)

    def _of_partner(self, origin: CellChange, name: str, value: Value) -> CauseLink | None:
        """Explain a consumed tag by the rack that produces it."""
        chains, path = self.chains, origin.cell.leaf.path
        now_ns, program = chains.causes.now_ns(origin.scan), self.program
        connection = next(
            candidate for candidate in chains.lowered.connections if _is_in(path, candidate.tag)
        )
        if program is None:
            return None
        partner_link = chain_of_partner(program, path, connection.rpi_ns, now_ns, self._of_other)
        if partner_link is None:
            return None
        parts = {"name": name, "value": value, "scan": origin.scan, "now_ns": now_ns}
        return linked(
            [(partner_link,)],
            kind="partner",
            **parts,
            text=f"a sample of {program.stubs[connection.tag.upper()]}",
        )

    def _of_other(
        self, recording: PackedTrace, job: LoadedRack, debugger: Debugger, tag: str
    ) -> CauseLink | None:
        """Return the chain of a tag of another rack after its last scan."""
        other = RackChain(recording, debugger.chains, self.deep, debugger.program)
        return other.of_tag(tag, len(recording.scans) - 1)

    def _better(self, bits: Bits, name: str) -> str:
        """Return the name of a module's bit instead of its address."""
        return self.module_name(bits) or name if name.startswith(("Local:", "I:", "O:")) else name

    def module_name(self, bits: Bits) -> str | None:
        """Return the name of a bit in its module, such as `slot1.status.MOVE_COMPLETE`; None without one."""
        place = bits.address.image, bits.word, bits.address.bit
        for group, named in self.slot(bits.slot).words.groups.items():
            for name, signal in named.items():
                if signal == place:
                    return f"slot{bits.slot}.{group}.{name}"
        return None

    def _of_change(self, bits: Bits, name: str, row: int) -> CauseLink:
        known = self._known.get((bits, row))
        if known is None:
            overruled = self._overruled(bits, name, row)
            if overruled is not None:
                known = overruled
            elif bits.image == "out":
                known = self._of_program(bits, name, row)
            else:
                known = self._of_module(bits, name, row)
            self._known[bits, row] = known
        return known

    def link(
        self, kind: str, bits: Bits, name: str, row: int, text: str = "", *causes: CauseLink
    ) -> CauseLink:
        """Return the link for a change of an image."""
        return linked(
            [(cause,) for cause in causes],
            kind=kind,
            name=name,
            value=self.value(bits, row),
            before=self.value(bits, row - 1) if row else None,
            scan=self.recording.numbers[row],
            now_ns=self.recording.times[row],
            text=text,
        )

    def value(self, bits: Bits, row: int) -> Value:
        """Return the value of bits in a scan: a bool for one bit, else the word."""
        word = Past(self.recording, row).words(bits.slot, bits.image, row)[bits.word]
        return word if bits.address.bit is None else bool(word & bits.mask)

    # --- outputs

    def _of_program(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Explain a change of an output by the program, here a ladder program."""
        link = None
        if self.maker is not None:
            cell = self._cell(bits)
            link = cell and self.chains.of_cell(cell, name, self.recording.numbers[row])
        return link or self.link("unknown", bits, name, row, "no program is known that wrote it")

    def _cell(self, bits: Bits) -> Cell | None:
        images = self.chains.lowered.layout.images
        leaf = next((leaf for leaf in images if leaf.slot == bits.slot and leaf.output), None)
        mask = None if bits.address.bit is None else bits.mask
        return None if leaf is None else Cell(leaf, bits.word, mask)

    # --- modules

    def _events(self, row: int, slot: int | None = None) -> list[TraceEvent]:
        scan = self.recording.numbers[row]
        events = self._events_by_scan.get(scan, [])
        return [event for event in events if slot is None or event.fields.get("slot", 0) == slot]

    def _of_module(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Explain a change of an input image: an action on the module, a terminal, or the module itself."""
        slot = self.slot(bits.slot)
        operation = next(self._done(slot, bits, row), None)
        if operation is not None:
            kind, text = operation
            return self.link(kind, bits, name, row, text)
        if self._is_terminal(slot, bits):
            return self.link("input", bits, name, row, self._terminal(slot, bits))
        events = self._events_of_bits(slot, bits, row)
        text = self._standing(slot, bits, row) or (event_text(events[0]) if events else "")
        causes = self._switches(slot, events, row) or list(self._command(slot, bits, row))
        return self.link("module", bits, name, row, text or self._of_bit(bits, row), *causes)

    def _events_of_bits(self, slot: SlotInfo, bits: Bits, row: int) -> list[TraceEvent]:
        """Return a module's events in a scan that name these bits; if none does, those that name no bit."""
        known = [event for event in self._events(row, slot.number) if event.topic == "/events"]
        names = set(self._names(slot, bits))
        own = [event for event in known if names.intersection(_named(event))]
        return own or [event for event in known if not _named(event)]

    def _switches(self, slot: SlotInfo, events: Sequence[TraceEvent], row: int) -> list[CauseLink]:
        """Return the inputs that caused a module's events, or what cut its motion short."""
        cut = next((event for event in events if event.fields.get("outcome") in _CUT), None)
        if cut is None and not any(map(_may_be_switched, events)):
            return []
        cut_row = self._cut_row(cut, row)
        terminals = list(self._terminals(slot, cut_row))
        return terminals if terminals or cut is None else list(self._interruption(slot, cut_row))

    def _cut_row(self, cut: TraceEvent | None, row: int) -> int:
        """Return the row in which a motion was cut short; an adapter shows its end in a later scan."""
        cut_ns = None if cut is None else cut.fields.get("cut_ns")
        return row if cut_ns is None else min(row, bisect_left(self.recording.times, int(str(cut_ns))))

    def _interruption(self, slot: SlotInfo, row: int) -> Iterator[CauseLink]:
        """Yield what cut a motion short in a scan: a CPU that left run mode, a command, or a rule."""
        mode = of_cpu(self.recording, row)
        if mode is not None:
            yield self._outranked(mode, "the CPU", None)
            return
        answered = self._answered(slot, row)
        if answered is not None:
            yield answered
            return
        rules = [event for event in self._events(row, slot.number) if event.fields.get("kind") == "rule"]
        if rules:
            parts = {"kind": "module", "name": f"slot {slot.number}", "value": None}
            moment = {"scan": self.recording.numbers[row], "now_ns": self.recording.times[row]}
            yield linked([], **parts, **moment, text=event_text(rules[0]))

    def _of_bit(self, bits: Bits, row: int) -> str:
        """Return the meaning of a bit's change, by the row; "" for a word."""
        bit = bits.address.bit if self.slot(bits.slot).is_stepper else None
        cause = None if bit is None else cause_of(bits.word, bit)
        return (
            "" if cause is None else f"{cause.on if self.value(bits, row) else cause.off} [{cause.rules[0]}]"
        )

    def _standing(self, slot: SlotInfo, bits: Bits, row: int) -> str:
        """Return what clears an error that is still set at the scan in question; "" if none is set."""
        standing = StatusMsw.CONFIG_ERROR | StatusMsw.MODE_CONFIG | StatusMsw.POSITION_INVALID
        row_of_question = self._row_of_question
        if (
            not slot.is_stepper
            or bits.word
            or not bits.mask & standing
            or not self.value(bits, row)
            or not self.value(bits, row_of_question)
        ):
            return ""
        past = SlotPast(Past(self.recording, row_of_question), slot)
        if bits.mask & StatusMsw.POSITION_INVALID and not searches_home(past):
            return ""
        refused = refused_configuration(past) if bits.mask & StatusMsw.CONFIG_ERROR else None
        return f"slot {slot.number}: {refused or waits(past)[0]}"

    def _terminals(self, slot: SlotInfo, row: int) -> Iterator[CauseLink]:
        """Yield the changes of a stepper's inputs in a scan."""
        past = Past(self.recording, row)
        now = past.words(slot.number, "in", row)
        before = past.words(slot.number, "in", row - 1) if row else (0,) * len(now)
        if any(slot.words.configures("in", words) for words in (before, now)):
            return  # in a configuration the words do not show terminals
        for name, signal in slot.words.groups.get("status", {}).items():
            if (now[signal.word] ^ before[signal.word]) >> signal.bit & 1 and shows_input(slot, name):
                bits = Bits(slot.number, "in", signal.word, 1 << signal.bit)
                yield self._of_change(bits, f"slot{slot.number}.status.{name}", row)

    def _done(self, slot: SlotInfo, bits: Bits, row: int) -> Iterator[tuple[str, str]]:
        """Yield the outside actions on a module in a scan, each as its kind and a sentence."""
        terminal, scan = self._terminal(slot, bits), self.recording.numbers[row]
        for event in self._events_by_scan.get(scan, []):
            text = str(event.fields.get("text", ""))
            if event.topic == "/orders" and text.startswith(f"Slot {slot.number}:"):
                if _is_for(event, slot, bits):
                    yield "operator", f"{terminal}: {text}"
            elif event.topic == "/stimuli" and event.fields.get("slot", 0) == slot.number:
                if event.fields.get("name") in _INCIDENTS:
                    yield "incident", f"slot {slot.number}: {text}"
                elif _is_of(str(event.fields.get("name")), slot, bits):
                    yield "input", f"{terminal}: {text}"

    def _is_terminal(self, slot: SlotInfo, bits: Bits) -> bool:
        """Whether bits are inputs of the module, and not what it reports."""
        if slot.words.modes is None:
            return True
        if not is_stepper(slot.words):
            names = self._names(slot, bits)
            return bool(names) and all(shows_input(slot, name) for name in names)
        own = slot.words.further
        return (
            bits.word == 1 and bits.address.bit is not None and own.keys().isdisjoint(self._names(slot, bits))
        )

    def _terminal(self, slot: SlotInfo, bits: Bits) -> str:
        if bits.address.bit is None:
            return f"slot {slot.number} {slot.words.inputs[bits.word]}"
        number = 16 * bits.word + bits.address.bit
        names = self._names(slot, bits)
        if slot.words.modes is not None:
            return f"slot {slot.number} input{''.join(f' {name}' for name in names)}"
        return f"slot {slot.number} input {number}{''.join(f' ({name})' for name in names[:1])}"

    def _names(self, slot: SlotInfo, bits: Bits) -> list[str]:
        return [name for name, bit in slot.words.bits("I", bits.word) if bits.mask >> bit & 1]

    def _command(self, slot: SlotInfo, bits: Bits, row: int) -> Iterator[CauseLink]:
        """Yield what a module responded to: its outputs just before, or the last start of a motion."""
        past = Past(self.recording, row)
        answered = self._answered(slot, row)
        if answered is not None:
            yield answered
            return
        if not slot.is_stepper:
            move = started(SlotPast(past, slot))
            if move is not None:
                command_bit = slot.words.groups["command"][move[0]]
                yield self._output(Bits(slot.number, "out", 0, 1 << command_bit.bit), slot, move[1])
            return
        if bits.word or bits.mask & (_BY_MOTION | _RATES):
            for changed, begun in islice(SlotPast(past, slot).rises(MOTIONS.value), 1):
                yield self._output(Bits(slot.number, "out", 0, begun), slot, changed)

    def _answered(self, slot: SlotInfo, row: int) -> CauseLink | None:
        """Return the chain of the first output word that changed just before a scan; None if none did."""
        past = Past(self.recording, row)
        for word in range(len(slot.words.outputs)):
            changed = past.last_change_between(slot.number, "out", word, max(0, row - ANSWER), row)
            if changed is not None:
                before = past.words(slot.number, "out", changed - 1)[word] if changed else 0
                now = past.words(slot.number, "out", changed)[word]
                mask = (now & ~before or now ^ before) & ALL_BITS
                return self._output(Bits(slot.number, "out", word, mask), slot, changed)
        return None

    def _output(self, bits: Bits, slot: SlotInfo, row: int) -> CauseLink:
        names = [name for name, bit in slot.words.bits("O", bits.word) if bits.mask >> bit & 1]
        if not names or bits.address.bit is None:
            bits = replace(bits, mask=ALL_BITS) if len(names) != 1 else bits
            return self._of_change(bits, f"slot{slot.number} {slot.words.outputs[bits.word]}", row)
        return self._of_change(bits, f"slot{slot.number}.command.{names[0]}", row)

    @property
    def _events_by_scan(self) -> dict[int, list[TraceEvent]]:
        if self._events_of_scans is None:
            self._events_of_scans = {}
            for event in self.recording.events:
                self._events_of_scans.setdefault(event.scan, []).append(event)
        return self._events_of_scans


def _mask(cell: Cell) -> int:
    return ALL_BITS if cell.mask is None else cell.mask


def _is_in(path: str, tag: str) -> bool:
    """Whether a path is a tag or a member of it."""
    return f"{path}.".upper().startswith(f"{tag}.".upper())


def _named(event: TraceEvent) -> list[str]:
    bits = event.fields.get("bits")
    return [str(bit) for bit in bits] if isinstance(bits, list) else []


def _may_be_switched(event: TraceEvent) -> bool:
    """Whether a terminal may have caused a module's event."""
    return event.fields.get("kind") == "rule" or event.fields.get("name") in _SWITCHED


def _is_of(name: str, slot: SlotInfo, bits: Bits) -> bool:
    """Whether a stimulus is on the given bits of an input image."""
    names = [bit_name.lower() for bit_name, bit in slot.words.bits("I", bits.word) if bits.mask >> bit & 1]
    inputs = any(bit_name in (name.lower(), f"in_{name.lower()}") for bit_name in names)
    return inputs or slot.words.modes is None or (not slot.is_stepper and any(map(is_input_name, names)))


def _is_for(order: TraceEvent, slot: SlotInfo, bits: Bits) -> bool:
    """Whether an order on a slot affects given bits of its input image; a press affects only its input."""
    state = json_value(str(order.fields.get("order", "{}")))
    return "name" not in state or _is_of(str(state["name"]), slot, bits)
