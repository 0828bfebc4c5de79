"""Explains the values of bits, words and the program, and the waits of the modules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.debug import CauseLink, Debugger, Remedies, answer_text
from scanrack.ladder.debug.answer_text import MOST_LINES
from scanrack.ladder.state.memory import Value
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import ScanFlag
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.image_text import module_text
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.traces.replay import PackedTrace

from ..load.recorded_scans import recorded_words
from .bits import Bits, shows_input
from .chain import RackChain
from .past import Past, SlotPast, event_text
from .sentences import change_lines, sender_lines
from .waits import waits

if TYPE_CHECKING:  # a ladder program needs no lines of Python
    from .source.lines import Line
    from .traced_run import Load, TracedChange, TracedRun

NO_LINE = "no line of the program wrote it in this scan: a force began or ended, or a test wrote it"


@dataclass(frozen=True)
class Why:
    """Answers about one scan of a rack.

    Args:
        spec: the rack; None if a trace does not contain it.
        load: reloads the Python program; None for a program without lines of Python.
        debugger: the debugger of a ladder program after that scan.
        lines: the program's lines that the answers have named so far.
    """

    recording: PackedTrace
    row: int
    spec: RackSpec | None
    load: Load | None
    debugger: Debugger | None = None
    lines: list[Line] = field(default_factory=list)

    @cached_property
    def past(self) -> Past:
        """The recording up to the scan."""
        return Past(self.recording, self.row)

    def address_of(self, text: str) -> Address:
        """Return the address of a bit or word in an image; raise ValueError if the text is not one."""
        return parse_address(text, self.words)

    @cached_property
    def words(self) -> Mapping[int, ModuleWords]:
        """The word names of the modules, by slot."""
        return recorded_words(self.recording.slots, self.spec)

    def is_address(self, text: str) -> bool:
        """Return whether a text is the address of a bit or word of an image."""
        try:
            self.address_of(text)
        except ValueError:
            return False
        return True

    def first_on(self, text: str) -> int | None:
        """Return the first row in which a bit or word of an image is not 0, or None.

        Raises:
            ValueError: the text is not an address.
        """
        bits = Bits.at(self.address_of(text))
        last = Past(self.recording, len(self.recording.scans) - 1)
        return last.first_on(bits.slot, bits.image, bits.word, bits.mask)

    def explain(self, text: str, *, deep: bool = False) -> tuple[str, CauseLink]:
        """Return an explanation of a value in at most six lines, and its chain of causes.

        The text of a step also names its waits, see `answer_text`.

        Raises:
            ValueError: an unknown name.
        """
        link, debugger = self.chain(text, deep=deep), self.debugger
        lines = answer_text(link, deep=deep).splitlines()
        waits_of_step = debugger.waits(text) if debugger is not None and text in debugger.tags else []
        return "\n".join([*lines, *waits_of_step[: max(0, MOST_LINES - len(lines))]]), link

    def chain(self, text: str, *, deep: bool = False) -> CauseLink:
        """Return the chain of causes of a value, see `Bench.chain`.

        Raises:
            ValueError: an unknown name.
        """
        row, debugger = self.row, self.debugger
        if debugger is not None and (text in debugger.tags or not self.is_address(text)):
            cause = self._chains(deep).of_tag(text, row)
            return cause or self._unchanged_link(text, debugger.tags[text])
        if self.load is None or self.is_address(text):
            address = self.address_of(text)
            cause = self._chains(deep).of_bits(Bits.at(address), text, row)
            return cause or self._unchanged_link(text, self._value(address))
        return self._chain_of_name(text, deep)

    def suggest_inputs(self, text: str, requested: str | None = None, scans: int = 10) -> Remedies:
        """Return the smallest sets of inputs that would change a value of the program, see `remedies`.

        Args:
            requested: the value as text; the opposite value of a bit by default.
            scans: the number of scans within which the value must change.

        Raises:
            ValueError: the name is unknown, or the value does not fit.
        """
        value: Any = None if requested is None else parse_value(requested)
        if self.debugger is None:
            return self._suggest_inputs_of_python(text, value, scans)
        is_tag = text in self.debugger.tags or not self.is_address(text)
        tag = text if is_tag else str(self.address_of(text))
        return self.debugger.suggest_inputs(tag, value, scans=scans, name=self._terminal)

    def _suggest_inputs_of_python(self, text: str, requested: Any, scans: int) -> Remedies:
        """Return the smallest sets of inputs that would change a value of a Python program.

        An input needs no trials. An output is read from the memory block after each trial.

        Raises:
            ValueError: the trace has no program, or see `ProgramTrials.of`.
        """
        from scanrack.ladder.debug.remedies import of_input

        from .chains.program import ProgramChain
        from .trials import ProgramTrials

        if self.load is None or self.spec is None:
            raise ValueError("suggested inputs need the program: the trace has none")
        chains = self._chains(deep=False)
        assert isinstance(chains, ProgramChain)
        trials = ProgramTrials(
            self.recording, self.row, self.spec, self.load, terminal=self._terminal, scans=scans
        )
        address_text = chains.names.addresses.get(chains.names.own(text), text)
        if not self.is_address(address_text):
            return trials.of(text, chains.watched(text), requested, chains.name)
        address = self.address_of(address_text)
        if address.image == "I":
            if requested is None:
                requested = address.bit is None or not self._value(address)
            return of_input(text, requested, self._terminal(address.slot, address.word, address.bit))
        offset = self._offset(address.slot, address.word)

        def read() -> Value:
            word = int.from_bytes(trials.block()[offset : offset + 2], "little", signed=True)
            return word if address.bit is None else bool(word >> address.bit & 1)

        return trials.of(text, lambda _logic: read, requested, chains.name)

    def _terminal(self, slot: int, word: int, bit: int | None) -> str | None:
        """Return the name of a terminal or an analog input; None for the status of a module."""
        slot_info = next(candidate for candidate in self.recording.slots if candidate.number == slot)
        if slot_info.words.modes is None:
            return f"slot {slot} input {f'word {word}' if bit is None else 16 * word + bit}"
        names = [
            name
            for name, number in slot_info.words.bits("I", word)
            if number == bit and shows_input(slot_info, name)
        ]
        return f"slot {slot} input {names[0]}" if names else None

    def _chains(self, deep: bool) -> RackChain:
        """Return a new maker of chains, through the Python or ladder program if there is one."""
        if self.load is None or self.spec is None:
            debugger = self.debugger
            if debugger is None:
                return RackChain(self.recording, deep=deep)
            return RackChain(self.recording, debugger.chains, deep=deep, program=debugger.program)
        from .chains.program import ProgramChain
        from .source.class_names import Names
        from .traced_run import fresh

        with fresh(self.load) as logic:
            names = Names(logic, self.words)
        return ProgramChain(self.recording, deep=deep, spec=self.spec, load=self.load, names=names)

    def _chain_of_name(self, text: str, deep: bool) -> CauseLink:
        """Return the chain of a Python program's input, output, sequence, axis or value.

        Raises:
            ValueError: the program has no such name.
        """
        from .chains.program import ProgramChain

        chains = self._chains(deep)
        assert isinstance(chains, ProgramChain)
        names = chains.names
        name = names.own(text)
        cause: CauseLink | None = None
        if name in names.addresses:
            cause = chains.of_bits(Bits.at(self.address_of(names.addresses[name])), name, self.row)
        elif name in names.sequences:
            cause = chains.of_sequence(name, self.row)
        elif name in names.axes:
            cause = chains.of_module(names.axes[name], name, self.row)
        else:
            cause = chains.of_value(text, self.row)
            if text not in chains.present:
                chains.refuse(text)
        return cause or self._unchanged_link(text, chains.present.get(text))

    def _unchanged_link(self, text: str, value: object) -> CauseLink:
        """Return the link of a value that has not changed since the first scan, without a known cause."""
        plain = value if isinstance(value, (bool, int, float, str)) else None
        scan, now_ns = self.recording.numbers[0], self.recording.times[0]
        return CauseLink("power-up", text, plain, scan, now_ns, text="not changed since then")

    def rack(self) -> str:
        """Return the waits of every module, and the lines that last changed its output words."""
        last_changes = {slot.number: self._last_changes(slot) for slot in self.recording.slots}
        rows = frozenset(row for changes in last_changes.values() for row in changes)
        rerun = self._rerun(rows, max(rows, default=0))
        lines = [str(step) for step in self.past.sequences]
        for slot in self.recording.slots:
            lines += self._slot_lines(slot)
            for row, words in last_changes[slot.number].items():
                lines += [f"  {line}" for line in self._word_lines(slot, row, words, rerun)]
        return "\n".join(lines)

    # --- the words of a slot

    def _rerun(self, rows: frozenset[int], last: int) -> TracedRun | None:
        """Run a Python program again up to a row, and trace some rows; None for other programs."""
        if self.load is None or self.spec is None:
            return None
        from .traced_run import run_again

        return run_again(self.recording, self.spec, self.load, rows, last)

    def _change_lines(
        self, head: str, row: int, rerun: TracedRun | None, slot: int, word: int
    ) -> Iterator[str]:
        """Yield the line that changed an output word."""
        if self.recording.flags[row] & ScanFlag.FAULT:
            yield f"{head}: the CPU faulted, which zeroes all outputs"
            scan = self.recording.numbers[row]
            for event in self.past.events:
                if event.scan == scan and event.fields.get("slot", 0) == 0 and event.topic != "/texts":
                    yield f"  {event_text(event)}"
        elif rerun is None:
            yield f"{head}{self._rung_text(slot, word, row)}"
        elif not rerun.explains(row):
            yield f"{head}: {rerun.no_line(self.past)}"
        else:
            offset = self._offset(slot, word)
            changes = [change for change in rerun.changes.get(row, ()) if change.affects(offset)]
            yield from self._traced_lines(head, changes, row, slot)

    def _rung_text(self, slot: int, word: int, row: int) -> str:
        """Return a colon and the rung that last changed a word; "." if the rung is unknown."""
        if self.debugger is None:
            return "."
        cause = self.debugger.cause(f"Local:{slot}:O.Data[{word}]")
        if cause is None:
            return "."
        scan, rung = cause
        return f": {rung}" if scan == self.recording.numbers[row] else "."

    def _traced_lines(self, head: str, changes: Sequence[TracedChange], row: int, slot: int) -> Iterator[str]:
        """Yield sentences about the last change of a slot's word in a scan."""
        change = changes[-1] if changes else None
        slot_senders = [sender for sender in change.senders if sender.slot == slot] if change else []
        if slot_senders:
            self.lines.append(slot_senders[0].line)
            yield from sender_lines(head, slot_senders[0])
        elif change is None or not change.line.number:
            yield f"{head}: {NO_LINE}"
        else:
            self.lines.append(change.line)
            inputs = lambda slot: self.past.words(slot, "in", row)  # noqa: E731
            yield from change_lines(head, change, self.recording.slots, inputs)

    def _offset(self, slot: int, word: int) -> int:
        """Return the offset of an output word in the memory block, bytes."""
        return int(self.recording.span((slot, "out")).start) + 2 * word

    # --- the rack

    def _slot_lines(self, slot: SlotInfo) -> Iterator[str]:
        """Yield the waits of a module, or the inputs of a card; the first line names the slot."""
        past = SlotPast(self.past, slot)
        if slot.words.modes is not None:
            lines = waits(past)
        else:
            lines = [module_text(slot, "in", (0,) * len(past.inputs), past.inputs) or "all inputs are 0"]
        yield f"slot {slot.number}: {lines[0]}"
        yield from (f"  {line}" for line in lines[1:])

    def _last_changes(self, slot: SlotInfo) -> dict[int, list[int]]:
        """Return the output words of a slot by the row of their last change, latest first."""
        by_row: dict[int, list[int]] = {}
        for word in range(len(slot.words.outputs)):
            row = self.past.last_change(slot.number, "out", word)
            if row is not None:
                by_row.setdefault(row, []).append(word)
        return dict(sorted(by_row.items(), reverse=True))

    def _word_lines(
        self, slot: SlotInfo, row: int, words: Sequence[int], rerun: TracedRun | None
    ) -> list[str]:
        """Return sentences about the last change in some output words."""
        after = self.past.words(slot.number, "out", row)
        before = self.past.words(slot.number, "out", row - 1) if row else (0,) * len(after)
        formats = NumberFormats()
        for event in self.past.events:
            formats.note(event.scan, event.fields)
        reader = formats.reader(slot.number, self.recording.numbers[row])
        change = module_text(slot, "out", before, after, reader)
        names = f"word{'s' if len(words) > 1 else ''} {', '.join(map(str, words))}"
        head = f"output {names} since {self.past.when(row)}: {change}"
        texts = self._change_lines(head, row, rerun, slot.number, words[0])
        return [line for text in texts for line in text.splitlines()]

    def _value(self, address: Address) -> Value:
        """Return the value of a bit, or of a word, after the scan."""
        bits = Bits.at(address)
        word = self.past.words(bits.slot, bits.image, self.row)[bits.word]
        return word if address.bit is None else bool(word & bits.mask)


def parse_value(text: str) -> object:
    """Return the value of a text: on, off, true, false or a number."""
    truth = {"on": True, "true": True, "off": False, "false": False}.get(text.lower())
    if truth is not None:
        return truth
    try:
        return int(text, 0)
    except ValueError:
        return float(text)
