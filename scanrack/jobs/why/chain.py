"""The chain of causes through a rack: images, modules and their rules, and the program."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace

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
from .overrides import Override, forced, of_cpu, of_link, spellings
from .past import ALL_BITS, Past, SlotPast, event_text
from .waits import is_idle, refused_configuration, searches_home, waits

RESPONSE_SCANS = 2
"""Maximum number of scans from a change in an output image to the response in the input image."""

_BY_INPUT = {"home", "registration"}
"""Names of events that an input may have caused: moves that end at an input."""

_CUT = {"cut short", "found no home", "stopped by the external input"}
"""Outcomes of a move that its command does not explain."""

_INJECTED_FAULTS = {kind.value for kind in FaultKind}

_RATES = StatusMsw.ACCELERATING | StatusMsw.DECELERATING | StatusMsw.HOLD_STATE
_BY_MOTION = COMPLETION_BITS | StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW | _RATES
"""Bits of status word 0 that a motion changes."""

_ERRORS = StatusMsw.COMMAND_ERROR | StatusMsw.INVALID_PROFILE | StatusMsw.INPUT_ERROR | StatusMsw.HOME_INVALID
_LASTING = StatusMsw.CONFIG_ERROR | StatusMsw.MODE_CONFIG | StatusMsw.POSITION_INVALID
"""Bits that stay set until a configuration, a home or a preset clears them."""


@dataclass(slots=True)
class RackChain:
    """Makes chains of causes through a recording.

    Args:
        maker: makes the chains of a ladder program, see `Debugger.chains`; None for other programs.
        deep: see `Chains`.
        program: the ladder program; its consumed tags are explained by the racks that produce them.
    """

    recording: PackedTrace
    maker: Callable[..., Chains] | None = None
    deep: bool = False
    program: LadderLogic | None = None
    _explained: dict[tuple[Bits, int], CauseLink] = field(default_factory=dict)  # changes, by bits and row
    _chains: Chains | None = None
    _events_of_scans: dict[int, list[TraceEvent]] | None = None
    _question_row: int = 0  # row of the scan in the user's question

    # --- questions

    def of_tag(self, tag: str, row: int) -> CauseLink | None:
        """Return the chain of a ladder program's tag; None for a structure that has not changed."""
        chains, cells = self.chains, self.chains.cells(tag)
        leaf, scan = cells[0].leaf, self.recording.numbers[row]
        if leaf.is_image and leaf.slot is not None and leaf.ident not in chains.lowered.written_inputs:
            side = "out" if leaf.output else "in"
            return self.of_bits(Bits(leaf.slot, side, cells[0].index, _mask(cells[0])), tag, row)
        names = {tag, leaf.path, cells[0].name, chains.full_name(tag)}
        override = forced(self.recording.events, scan, names) or of_cpu(self.recording, row)
        # after a fault a tag can't change, but its value has its own cause
        has_own_cause = (
            override is not None and override.kind == "fault" and chains.causes.origins(cells, scan)
        )
        if override is None or has_own_cause:
            self._question_row = row
            return chains.of_tag(tag, scan)
        while row and CpuMode(self.recording.flags[row] & MODE_MASK) is CpuMode.PROGRAM:
            row -= 1
        last_run = self.recording.numbers[row]  # the last scan in which the program ran
        value = chains.causes.value(cells[0], last_run) if len(cells) == 1 else None
        cause = override_link(override, tag, value)
        changed = chains.of_tag(tag, last_run) if override.kind == "mode" else None
        return cause if changed is None else replace(cause, scan=changed.scan, now_ns=changed.now_ns)

    def of_bits(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Return the chain of bits of an image after a scan; None if nothing is known about them."""
        self._question_row = row
        return self._override_of(bits, name, row) or self._explain_bits(bits, name, row)

    def _explain_bits(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Return the chain of the last change of bits up to a scan, or why they never changed."""
        change_row = self._last_change(bits, row)
        if change_row is None:
            return self._explain_unchanged(bits, name, row)
        return self._explain_change(bits, name, change_row)

    def _last_change(self, bits: Bits, row: int) -> int | None:
        return Past(self.recording, row).last_change(bits.slot, bits.image, bits.word, bits.mask)

    def _override_of(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Return the link of the override of the program or module in a scan; None if there is none."""
        recording, scan = self.recording, self.recording.numbers[row]
        override = forced(recording.events, scan, spellings(bits.address))
        if override is None and bits.image == "out":
            override = of_cpu(recording, row)
        elif override is None:
            override = of_link(recording, self.slot(bits.slot), scan)
        if override is None:
            return None
        cause = override_link(override, name, self.value(bits, row))
        # in program mode the value is still the one that was set before
        change_row = self._last_change(bits, row) if override.kind == "mode" else None
        if change_row is None:
            return cause
        return replace(cause, scan=recording.numbers[change_row], now_ns=recording.times[change_row])

    def slot(self, number: int) -> SlotInfo:
        """Return a slot of the recording."""
        return next(slot_info for slot_info in self.recording.slots if slot_info.number == number)

    @property
    def chains(self) -> Chains:
        """Maker of the ladder program's chains."""
        if self._chains is None:
            assert self.maker is not None
            hooks = {
                "outside": self._explain_input,
                "at_rest": self._explain_unchanged_input,
                "run_mode": self._program_mode_before,
            }
            self._chains = self.maker(deep=self.deep, **hooks, blocks=self)
        return self._chains

    def _program_mode_before(self, scan: int) -> str:
        """Return when the key was turned to program before the first run-mode scan, as text; "" if never."""
        row = bisect_left(self.recording.numbers, scan)
        mode = of_cpu(self.recording, row - 1) if 0 < row < len(self.recording.numbers) else None
        if mode is None or mode.kind != "mode":
            return ""
        return f"the key was at program since {seconds(mode.now_ns)} s"

    def of_module(self, number: int, name: str, row: int, head: str = "") -> CauseLink:
        """Return the link of a module's action or wait at a scan; a lost link takes precedence."""
        recording, slot = self.recording, self.slot(number)
        lost = of_link(recording, slot, recording.numbers[row])
        if lost is not None:
            return override_link(lost, name, None)
        past = SlotPast(Past(recording, row), slot)
        change_row = past.past.last_change(number, "in", 0) or 0
        text = f"{head}slot {number}: {'; '.join(waits(past)[:2])}"
        scan, now_ns = recording.numbers[change_row], recording.times[change_row]
        return CauseLink("module", name, None, scan=scan, now_ns=now_ns, text=text)

    # --- the blocks of an axis, see `Blocks`

    def waiting(self, path: str, scan: int) -> CauseLink | None:
        """Return the link of a busy block's wait; None for any other structure."""
        slot, row = slot_of(self.chains.lowered, path), bisect_left(self.recording.numbers, scan)
        if slot is None or row >= len(self.recording.numbers):
            return None
        return self.of_module(slot, path, row, "busy: ")

    def failed(self, path: str, since: int, scan: int) -> CauseLink | None:
        """Return the module's bit that caused a block's error, with its rule; None without an error bit."""
        slot = slot_of(self.chains.lowered, path)
        if slot is None:
            return None
        row = bisect_right(self.recording.numbers, scan) - 1
        status = Past(self.recording, row).words(slot, "in", row)[0]
        for bit in (StatusMsw.CONFIG_ERROR, *_ERRORS):
            if status & bit:
                return self._explain_bits(
                    Bits(slot, "in", 0, bit.value), f"slot{slot}.status.{bit.name}", row
                )
        return None

    def _explain_unchanged_input(self, cell: Cell, name: str, value: Value, scan: int) -> CauseLink | None:
        """Explain a ladder program's input that has not changed."""
        slot = cell.leaf.slot
        if slot is None or all(slot_info.number != slot for slot_info in self.recording.slots):
            return None
        if not cell.leaf.is_image:
            loss = of_link(self.recording, self.slot(slot), scan)
            return override_link(loss, name, value) if loss else None
        row = bisect_left(self.recording.numbers, scan)
        if row == len(self.recording.numbers):
            return None
        bits = Bits(slot, "in", cell.index, _mask(cell))
        name = self._readable_name(bits, name)
        return self._override_of(bits, name, row) or self._explain_bits(bits, name, row)

    def _explain_unchanged(self, bits: Bits, name: str, row: int) -> CauseLink | None:
        """Explain bits of an image that have not changed; None if nothing is known about them."""
        slot = self.slot(bits.slot)
        if bits.image == "out":
            cell = self._cell(bits)
            return self.chains.of_cell(cell, name, self.recording.numbers[row]) if cell else None
        value, start_ns = self.value(bits, row), self.recording.times[0]
        if slot.words.modes is not None and not slot.is_stepper and not self._is_terminal(slot, bits):
            state = waits(SlotPast(Past(self.recording, row), slot))[0]
            text = f"slot {slot.number}: {state}"
            return CauseLink("module", name, value, scan=0, now_ns=start_ns, text=text)
        cause = cause_of(bits.word, bits.mask.bit_length() - 1) if slot.is_stepper else None
        if bits.address.bit is None or (slot.is_stepper and cause is None):
            return None
        if cause is None or cause.origin is Origin.TERMINAL:
            text = f"{self._terminal_text(slot, bits)}, never {'off' if value else 'on'}"
            return CauseLink("input", name, value, scan=0, now_ns=start_ns, text=text)
        return self._explain_unchanged_status(bits, name, row, cause)

    def _explain_unchanged_status(self, bits: Bits, name: str, row: int, cause: BitCause) -> CauseLink:
        """Explain an unchanged status bit by the module's wait, or by a command that was never sent."""
        slot, value, start_ns = self.slot(bits.slot), self.value(bits, row), self.recording.times[0]
        past = SlotPast(Past(self.recording, row), slot)
        if value or not cause.commands or not is_idle(past):
            text = f"slot {slot.number}: {waits(past)[0]}"
            return CauseLink("module", name, value, scan=0, now_ns=start_ns, text=text)
        commands = (bit.value for bit in CommandMsw if bit & cause.commands)
        unsent = (self._explain_unsent_command(slot, mask, row) for mask in commands)
        causes = [(link,) for link in unsent if link is not None]
        text = f"{cause.off} [{cause.rules[0]}]"
        return linked(causes[:1], kind="module", name=name, value=value, scan=0, now_ns=start_ns, text=text)

    def _explain_unsent_command(self, slot: SlotInfo, mask: int, row: int) -> CauseLink | None:
        """Explain a command bit that the program has not sent; None if nothing is known."""
        bits = Bits(slot.number, "out", 0, mask)
        names = _output_names(slot, bits)
        name = f"slot{slot.number}.command.{names[0]}" if names else str(bits.address)
        return self._explain_bits(bits, name, row)

    def _explain_input(self, origin: CellChange, name: str, value: Value) -> CauseLink | None:
        """Explain a change in a ladder program's input."""
        cell = origin.cell
        if cell.leaf.slot is None:
            return self._explain_consumed_tag(origin, name, value)
        if not cell.leaf.is_image:
            return self._explain_connection_fault(origin, name, value)
        bits = Bits(cell.leaf.slot, "in", cell.index, _mask(cell))
        row = bisect_left(self.recording.numbers, origin.scan)
        if row == len(self.recording.numbers) or self.recording.numbers[row] != origin.scan:
            return None  # the recording begins after it
        return self._explain_change(bits, self._readable_name(bits, name), row)

    def _explain_connection_fault(self, origin: CellChange, name: str, value: Value) -> CauseLink:
        """Explain a change in a connection fault, such as `axis.I.Fault`."""
        now_ns = self.chains.causes.now_ns(origin.scan)
        text = f"slot {origin.cell.leaf.slot}: the link to it is {'lost' if value else 'restored'}"
        return CauseLink("incident", name, value, scan=origin.scan, now_ns=now_ns, text=text)

    def _explain_consumed_tag(self, origin: CellChange, name: str, value: Value) -> CauseLink | None:
        """Explain a consumed tag by the rack that produces it."""
        chains, path = self.chains, origin.cell.leaf.path
        now_ns, program = chains.causes.now_ns(origin.scan), self.program
        connection = next(
            candidate for candidate in chains.lowered.connections if _is_in(path, candidate.tag)
        )
        if program is None:
            return None
        produced = chain_of_partner(program, path, connection.rpi_ns, now_ns, self._explain_partner_tag)
        if produced is None:
            return None
        return linked(
            [(produced,)],
            kind="partner",
            name=name,
            value=value,
            scan=origin.scan,
            now_ns=now_ns,
            text=f"a sample of {program.stubs[connection.tag.upper()]}",
        )

    def _explain_partner_tag(
        self, recording: PackedTrace, job: LoadedRack, debugger: Debugger, tag: str
    ) -> CauseLink | None:
        """Explain a tag of another rack after the last scan of its recording."""
        partner_chain = RackChain(recording, debugger.chains, deep=self.deep, program=debugger.program)
        return partner_chain.of_tag(tag, len(recording.scans) - 1)

    def _readable_name(self, bits: Bits, name: str) -> str:
        """Return the name of a module's bit instead of its address."""
        return self.module_name(bits) or name if name.startswith(("Local:", "I:", "O:")) else name

    def module_name(self, bits: Bits) -> str | None:
        """Return the name of a bit in its module, such as `slot1.status.MOVE_COMPLETE`; None without one."""
        place = bits.address.image, bits.word, bits.address.bit
        for group, signals in self.slot(bits.slot).words.groups.items():
            for name, signal in signals.items():
                if signal == place:
                    return f"slot{bits.slot}.{group}.{name}"
        return None

    def _explain_change(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Return the (cached) link of a change in a scan; an override takes precedence."""
        link = self._explained.get((bits, row))
        if link is None:
            explain = self._explain_output if bits.image == "out" else self._explain_module_change
            link = self._override_of(bits, name, row) or explain(bits, name, row)
            self._explained[bits, row] = link
        return link

    def link(
        self, kind: str, bits: Bits, name: str, row: int, text: str = "", *causes: CauseLink
    ) -> CauseLink:
        """Return the link for a change in an image."""
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

    def _explain_output(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Explain a change in an output by the rung of a ladder program that wrote the output."""
        cell = self._cell(bits)
        link = None if cell is None else self.chains.of_cell(cell, name, self.recording.numbers[row])
        return link or self.link("unknown", bits, name, row, "no program is known that wrote it")

    def _cell(self, bits: Bits) -> Cell | None:
        """Return the cell of output bits in the ladder program; None if the program has no such cell."""
        images = self.chains.lowered.layout.images if self.maker is not None else ()
        leaf = next((leaf for leaf in images if leaf.slot == bits.slot and leaf.output), None)
        mask = None if bits.address.bit is None else bits.mask
        return None if leaf is None else Cell(leaf, bits.word, mask)

    # --- modules

    def _events_of_slot(self, row: int, slot: int) -> list[TraceEvent]:
        return [event for event in self._events_in(row) if event.fields.get("slot", 0) == slot]

    def _explain_module_change(self, bits: Bits, name: str, row: int) -> CauseLink:
        """Explain a change in an input image: an action on the module, a terminal, or the module itself."""
        slot = self.slot(bits.slot)
        action = next(self._outside_actions(slot, bits, row), None)
        if action is not None:
            kind, text = action
            return self.link(kind, bits, name, row, text)
        if self._is_terminal(slot, bits):
            return self.link("input", bits, name, row, self._terminal_text(slot, bits))
        events = self._events_of_bits(slot, bits, row)
        text = self._cure_of_error(slot, bits, row) or (event_text(events[0]) if events else "")
        causes = self._causing_inputs(slot, events, row)
        command = None if causes else self._causing_command(slot, bits, row)
        if command is not None:
            causes = [command]
        return self.link("module", bits, name, row, text or self._meaning_of_change(bits, row), *causes)

    def _events_of_bits(self, slot: SlotInfo, bits: Bits, row: int) -> list[TraceEvent]:
        """Return a module's events in a scan that name these bits; if none, the events that name no bit."""
        events = [event for event in self._events_of_slot(row, slot.number) if event.topic == "/events"]
        names = set(self._bit_names(slot, bits))
        events_of_bits = [event for event in events if names.intersection(_bits_named_by(event))]
        return events_of_bits or [event for event in events if not _bits_named_by(event)]

    def _causing_inputs(self, slot: SlotInfo, events: Sequence[TraceEvent], row: int) -> list[CauseLink]:
        """Return the inputs that caused a module's events, or the interruption that cut its motion short."""
        cut = next((event for event in events if event.fields.get("outcome") in _CUT), None)
        if cut is None and not any(map(_may_be_by_input, events)):
            return []
        row = self._row_of_cut(cut, row)
        inputs = list(self._changed_inputs(slot, row))
        interruption = None if inputs or cut is None else self._interruption(slot, row)
        return inputs if interruption is None else [interruption]

    def _row_of_cut(self, cut: TraceEvent | None, row: int) -> int:
        """Return the row in which a motion was cut short; an adapter shows its end in a later scan."""
        cut_ns = None if cut is None else cut.fields.get("cut_ns")
        return row if cut_ns is None else min(row, bisect_left(self.recording.times, int(str(cut_ns))))

    def _interruption(self, slot: SlotInfo, row: int) -> CauseLink | None:
        """Return the cause that cut a motion short in a scan: the CPU left run mode, a command, or a rule."""
        mode = of_cpu(self.recording, row)
        if mode is not None:
            return override_link(mode, "the CPU", None)
        output = self._output_changed_before(slot, row)
        if output is not None:
            return output
        rules = [
            event for event in self._events_of_slot(row, slot.number) if event.fields.get("kind") == "rule"
        ]
        if not rules:
            return None
        scan, now_ns = self.recording.numbers[row], self.recording.times[row]
        name, text = f"slot {slot.number}", event_text(rules[0])
        return CauseLink("module", name, None, scan=scan, now_ns=now_ns, text=text)

    def _meaning_of_change(self, bits: Bits, row: int) -> str:
        """Return the meaning of a bit's change, with the manual's rule; "" for a word."""
        bit = bits.address.bit if self.slot(bits.slot).is_stepper else None
        cause = None if bit is None else cause_of(bits.word, bit)
        if cause is None:
            return ""
        return f"{cause.on if self.value(bits, row) else cause.off} [{cause.rules[0]}]"

    def _cure_of_error(self, slot: SlotInfo, bits: Bits, row: int) -> str:
        """Return the action that clears an error that is still set when the user asks; "" if none is set."""
        is_lasting = slot.is_stepper and not bits.word and bits.mask & _LASTING
        if not is_lasting or not self.value(bits, row) or not self.value(bits, self._question_row):
            return ""
        past = SlotPast(Past(self.recording, self._question_row), slot)
        if bits.mask & StatusMsw.POSITION_INVALID and not searches_home(past):
            return ""
        refused = refused_configuration(past) if bits.mask & StatusMsw.CONFIG_ERROR else None
        return f"slot {slot.number}: {refused or waits(past)[0]}"

    def _changed_inputs(self, slot: SlotInfo, row: int) -> Iterator[CauseLink]:
        """Yield the changes in a stepper's inputs in a scan."""
        past = Past(self.recording, row)
        now = past.words(slot.number, "in", row)
        before = past.words(slot.number, "in", row - 1) if row else (0,) * len(now)
        if any(slot.words.configures("in", words) for words in (before, now)):
            return  # in configuration mode the words do not show inputs
        for name, signal in slot.words.groups.get("status", {}).items():
            if (now[signal.word] ^ before[signal.word]) >> signal.bit & 1 and shows_input(slot, name):
                bits = Bits(slot.number, "in", signal.word, 1 << signal.bit)
                yield self._explain_change(bits, f"slot{slot.number}.status.{name}", row)

    def _outside_actions(self, slot: SlotInfo, bits: Bits, row: int) -> Iterator[tuple[str, str]]:
        """Yield the actions of operators and the machine on a module in a scan, as kinds and sentences."""
        terminal = self._terminal_text(slot, bits)
        for event in self._events_in(row):
            text = str(event.fields.get("text", ""))
            if event.topic == "/orders" and text.startswith(f"Slot {slot.number}:"):
                if _is_order_on(event, slot, bits):
                    yield "operator", f"{terminal}: {text}"
            elif event.topic == "/stimuli" and event.fields.get("slot", 0) == slot.number:
                if event.fields.get("name") in _INJECTED_FAULTS:
                    yield "incident", f"slot {slot.number}: {text}"
                elif _is_stimulus_on(str(event.fields.get("name")), slot, bits):
                    yield "input", f"{terminal}: {text}"

    def _is_terminal(self, slot: SlotInfo, bits: Bits) -> bool:
        """Return whether bits show inputs of the module instead of its status."""
        if slot.words.modes is None:
            return True
        names = self._bit_names(slot, bits)
        if not is_stepper(slot.words):
            return bool(names) and all(shows_input(slot, name) for name in names)
        return bits.word == 1 and bits.address.bit is not None and slot.words.further.keys().isdisjoint(names)

    def _terminal_text(self, slot: SlotInfo, bits: Bits) -> str:
        """Return an input as text: `slot 1 input 3 (START)`, or the name of a word."""
        if bits.address.bit is None:
            return f"slot {slot.number} {slot.words.inputs[bits.word]}"
        number = 16 * bits.word + bits.address.bit
        names = self._bit_names(slot, bits)
        if slot.words.modes is not None:
            return f"slot {slot.number} input{''.join(f' {name}' for name in names)}"
        return f"slot {slot.number} input {number}{''.join(f' ({name})' for name in names[:1])}"

    def _bit_names(self, slot: SlotInfo, bits: Bits) -> list[str]:
        return [name for name, bit in slot.words.bits("I", bits.word) if bits.mask >> bit & 1]

    def _causing_command(self, slot: SlotInfo, bits: Bits, row: int) -> CauseLink | None:
        """Return the output that made a module change bits in a scan; None if no output did.

        It is the output that changed just before the scan, or else the command that began the last motion.
        """
        output = self._output_changed_before(slot, row)
        if output is not None:
            return output
        past = SlotPast(Past(self.recording, row), slot)
        if not slot.is_stepper:
            start = started(past)
        elif bits.word or bits.mask & _BY_MOTION:
            start = next(past.rises(MOTIONS.value), None)
        else:
            start = None
        if start is None:
            return None
        start_row, command_bits = start
        return self._explain_command(Bits(slot.number, "out", 0, command_bits), slot, start_row)

    def _output_changed_before(self, slot: SlotInfo, row: int) -> CauseLink | None:
        """Return the chain of the first output word that changed just before a scan; None if none did."""
        past, number = Past(self.recording, row), slot.number
        for word in range(len(slot.words.outputs)):
            change_row = past.last_change_between(number, "out", word, max(0, row - RESPONSE_SCANS), row)
            if change_row is not None:
                before = past.words(number, "out", change_row - 1)[word] if change_row else 0
                after = past.words(number, "out", change_row)[word]
                mask = (after & ~before or after ^ before) & ALL_BITS  # bits that came on, else that went off
                return self._explain_command(Bits(number, "out", word, mask), slot, change_row)
        return None

    def _explain_command(self, bits: Bits, slot: SlotInfo, row: int) -> CauseLink:
        """Explain a change in output bits; several bits are explained as a word."""
        names = _output_names(slot, bits)
        if names and bits.address.bit is not None:
            return self._explain_change(bits, f"slot{slot.number}.command.{names[0]}", row)
        if len(names) != 1:
            bits = replace(bits, mask=ALL_BITS)
        return self._explain_change(bits, f"slot{slot.number} {slot.words.outputs[bits.word]}", row)

    def _events_in(self, row: int) -> list[TraceEvent]:
        """Return the events of a scan; the first call sorts all events by scan."""
        if self._events_of_scans is None:
            self._events_of_scans = {}
            for event in self.recording.events:
                self._events_of_scans.setdefault(event.scan, []).append(event)
        return self._events_of_scans.get(self.recording.numbers[row], [])


def override_link(override: Override, name: str, value: Value | None) -> CauseLink:
    """Return the link of a value that an override determines."""
    return CauseLink(
        override.kind, name, value, scan=override.scan, now_ns=override.now_ns, text=override.text
    )


def _output_names(slot: SlotInfo, bits: Bits) -> list[str]:
    return [name for name, bit in slot.words.bits("O", bits.word) if bits.mask >> bit & 1]


def _mask(cell: Cell) -> int:
    return ALL_BITS if cell.mask is None else cell.mask


def _is_in(path: str, tag: str) -> bool:
    """Return whether a path is a tag or a member of that tag."""
    return f"{path}.".upper().startswith(f"{tag}.".upper())


def _bits_named_by(event: TraceEvent) -> list[str]:
    bits = event.fields.get("bits")
    return [str(bit) for bit in bits] if isinstance(bits, list) else []


def _may_be_by_input(event: TraceEvent) -> bool:
    """Return whether an input may have caused a module's event."""
    return event.fields.get("kind") == "rule" or event.fields.get("name") in _BY_INPUT


def _is_stimulus_on(name: str, slot: SlotInfo, bits: Bits) -> bool:
    """Return whether a stimulus of an input affects bits of an input image."""
    if slot.words.modes is None:
        return True
    names = [bit_name.lower() for bit_name, bit in slot.words.bits("I", bits.word) if bits.mask >> bit & 1]
    is_named = any(bit_name in (name.lower(), f"in_{name.lower()}") for bit_name in names)
    return is_named or (not slot.is_stepper and any(map(is_input_name, names)))


def _is_order_on(order: TraceEvent, slot: SlotInfo, bits: Bits) -> bool:
    """Return whether an action on a slot affects bits of its input image; a press affects its input."""
    fields = json_value(str(order.fields.get("order", "{}")))
    return "name" not in fields or _is_stimulus_on(str(fields["name"]), slot, bits)
