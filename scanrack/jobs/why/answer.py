"""The answers: why a bit, a word or a Python value has its value, and what the modules wait for."""

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
from .past import ALL_BITS, Past, SlotPast, event_text
from .sentences import change_lines, sender_lines
from .waits import waits

if TYPE_CHECKING:  # a ladder program needs no lines of Python
    from .source.lines import Line
    from .traced_run import Load, TracedChange, TracedRun

NO_LINE = "no line of the program wrote it in that scan: a force came or went, or a test wrote it"


@dataclass(frozen=True)
class Why:
    """Answers about one scan of a rack.

    Args:
        spec: the rack; None if a trace does not contain it.
        load: reloads the Python program; None for a program without lines of Python.
        debugger: the debugger of a ladder program at that scan.
        lines: the lines of the program that answers have named.
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

    def place(self, text: str) -> Address:
        """Return the place of a bit or word in an image; ValueError if the text is not an address."""
        return parse_address(text, self.words)

    @cached_property
    def words(self) -> Mapping[int, ModuleWords]:
        """The words of the slots with their names."""
        return recorded_words(self.recording.slots, self.spec)

    def means_image(self, text: str) -> bool:
        """Return whether a text is the address of a bit or word of an image."""
        try:
            self.place(text)
        except ValueError:
            return False
        return True

    def first_on(self, text: str) -> int | None:
        """Return the first row in which a bit or word of an image is not 0, or None.

        Raises:
            ValueError: the text is not an address.
        """
        place = self.place(text)
        mask = ALL_BITS if place.bit is None else 1 << place.bit
        last = Past(self.recording, len(self.recording.scans) - 1)
        return last.first_on(place.slot, _side(place), place.word, mask)

    def of(self, text: str, *, deep: bool = False) -> tuple[str, CauseLink]:
        """Explain a value in at most six lines, see `answer_text`, and as a chain; of a step, its waits too.

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
        if debugger is not None and (text in debugger.tags or not self.means_image(text)):
            cause = self._chains(deep).of_tag(text, row)
            return cause or self._since_power_up(text, debugger.tags[text])
        if self.means_image(text):
            place = self.place(text)
            cause = self._chains(deep).of_bits(Bits.at(place), text, row)
            return cause or self._since_power_up(text, self._value(place))
        if self.load is None:
            self.place(text)  # raises ValueError
        return self._chain_of_name(text, deep)

    def suggest_inputs(self, text: str, requested: str | None = None, scans: int = 10) -> Remedies:
        """Return the smallest sets of inputs that would give a value of a ladder program, see `remedies`.

        Args:
            requested: the value as text; of a bit the other value by default.
            scans: the number of scans within which the value must change.

        Raises:
            ValueError: an unknown name, or a value that does not fit.
        """
        if self.debugger is None:
            return self._suggest_inputs_of_python(
                text, None if requested is None else value_of(requested), scans
            )
        own = text in self.debugger.tags or not self.means_image(text)
        tag = text if own else str(self.place(text))
        value = None if requested is None else value_of(requested)
        return self.debugger.suggest_inputs(tag, value, scans=scans, name=self._terminal)

    def _suggest_inputs_of_python(self, text: str, requested: Any, scans: int) -> Remedies:
        from scanrack.ladder.debug.remedies import of_input

        from .chains.program import ProgramChain
        from .trials import ProgramTrials

        if self.load is None or self.spec is None:
            raise ValueError("what it would take needs the program: the trace has none")
        chains = self._chains(deep=False)
        assert isinstance(chains, ProgramChain)
        trials = ProgramTrials(self.recording, self.row, self.spec, self.load, self._terminal, scans)
        own = chains.names.addresses.get(chains.names.own(text), text)
        if not self.means_image(own):
            return trials.of(text, chains.watched(text), requested, chains.name)
        place = self.place(own)
        if place.image == "I":
            value = place.bit is None or not self._value(place) if requested is None else requested
            return of_input(text, value, self._terminal(place.slot, place.word, place.bit))
        offset = self._offset(place.slot, place.word)

        def read() -> Value:
            word = int.from_bytes(trials.block()[offset : offset + 2], "little", signed=True)
            return word if place.bit is None else bool(word >> place.bit & 1)

        return trials.of(text, lambda _logic: read, requested, chains.name)

    def _terminal(self, slot: int, word: int, bit: int | None) -> str | None:
        """Return the name of a terminal or an analog input; None for what a module reports."""
        slot_info = next(candidate for candidate in self.recording.slots if candidate.number == slot)
        if slot_info.words.modes is None:
            return f"slot {slot} input {f'word {word}' if bit is None else 16 * word + bit}"
        named = [
            name
            for name, signal in slot_info.words.bits("I", word)
            if signal == bit and shows_input(slot_info, name)
        ]
        return f"slot {slot} input {named[0]}" if named else None

    def _chains(self, deep: bool) -> RackChain:
        if self.load is None or self.spec is None:
            debugger = self.debugger
            if debugger is None:
                return RackChain(self.recording, None, deep)
            return RackChain(self.recording, debugger.chains, deep, debugger.program)
        from .chains.program import ProgramChain
        from .source.class_names import Names
        from .traced_run import fresh

        with fresh(self.load) as logic:
            names = Names(logic, self.words)
        return ProgramChain(self.recording, None, deep, None, spec=self.spec, load=self.load, names=names)

    def _chain_of_name(self, text: str, deep: bool) -> CauseLink:
        from .chains.program import ProgramChain

        chains = self._chains(deep)
        assert isinstance(chains, ProgramChain)
        names = chains.names
        own = names.own(text)
        cause: CauseLink | None = None
        if own in names.addresses:
            cause = chains.of_bits(Bits.at(self.place(names.addresses[own])), own, self.row)
        elif own in names.sequences:
            cause = chains.of_sequence(own, self.row)
        elif own in names.axes:
            cause = chains.of_module(names.axes[own], own, self.row)
        else:
            cause = chains.of_value(text, self.row)
            if text not in chains.present:
                chains.refuse(text)
        return cause or self._since_power_up(text, chains.present.get(text))

    def _since_power_up(self, text: str, value: object) -> CauseLink:
        """Return the link of a value that has not changed and of which nothing else is known."""
        plain = value if isinstance(value, (bool, int, float, str)) else None
        first = self.recording.numbers[0], self.recording.times[0]
        return CauseLink("power-up", text, plain, *first, "not changed since then")

    def rack(self) -> str:
        """Return the waits of every module, and the lines that last changed its output words."""
        last = {slot.number: list(self._last_changes(slot)) for slot in self.recording.slots}
        rows = frozenset(row for changes in last.values() for row, _ in changes)
        rerun = self._again(rows, max(rows, default=0))
        lines = [str(step) for step in self.past.sequences]
        for slot in self.recording.slots:
            lines += self._of_slot(slot)
            for row, words in last[slot.number]:
                lines += [f"  {line}" for line in self._of_words(slot, row, words, rerun)]
        return "\n".join(lines)

    # --- the words of a slot

    def _on_record(self, slot: int, row: int) -> Iterator[str]:
        scan = self.recording.numbers[row]
        for event in self.past.events:
            if event.scan == scan and event.fields.get("slot", 0) == slot and event.topic != "/texts":
                yield f"  {event_text(event)}"

    def _again(self, rows: frozenset[int], last: int) -> TracedRun | None:
        if self.load is None or self.spec is None:
            return None
        from .traced_run import run_again

        return run_again(self.recording, self.spec, self.load, rows, last)

    def _by_line(self, head: str, row: int, again: TracedRun | None, slot: int, word: int) -> Iterator[str]:
        """Yield the line that changed an output word."""
        if self.recording.flags[row] & ScanFlag.FAULT:
            yield f"{head}: the CPU faulted, which zeroes all outputs"
            yield from self._on_record(0, row)
        elif again is None:
            yield f"{head}{self._rung(slot, word, row)}"
        elif not again.explains(row):
            yield f"{head}: {again.no_line(self.past)}"
        else:
            offset = self._offset(slot, word)
            changes = [change for change in again.changes.get(row, ()) if _differs(change, offset)]
            yield from self._lines_of_changes(head, changes, row, slot)

    def _rung(self, slot: int, word: int, row: int) -> str:
        """Return a colon and the rung that last changed a word; "." if the rung is unknown."""
        if self.debugger is None:
            return "."
        change = self.debugger.cause(f"Local:{slot}:O.Data[{word}]")
        known = change is not None and change[0] == self.recording.numbers[row]
        return f": {change[1]}" if change is not None and known else "."

    def _lines_of_changes(
        self, head: str, made: Sequence[TracedChange], row: int, slot: int = 0
    ) -> Iterator[str]:
        """Yield sentences about the last of the given changes in a scan, with the names of `slot`."""
        senders_here = [sender for sender in made[-1].senders if sender.slot == slot] if made else []
        if senders_here:
            self.lines.append(senders_here[0].line)
            yield from sender_lines(head, senders_here[0])
        elif not made or not made[-1].line.number:
            yield f"{head}: {NO_LINE}"
        else:
            slots = self.recording.slots
            self.lines.append(made[-1].line)
            yield from change_lines(head, made[-1], slots, lambda slot: self.past.words(slot, "in", row))

    def _offset(self, slot: int, word: int) -> int:
        """Return the offset of an output word in the memory block, bytes."""
        return int(self.recording.span((slot, "out")).start) + 2 * word

    # --- the rack

    def _of_slot(self, slot: SlotInfo) -> Iterator[str]:
        past = SlotPast(self.past, slot)
        if slot.words.modes is not None:
            head = waits(past)
        else:
            head = [module_text(slot, "in", (0,) * len(past.inputs), past.inputs) or "all inputs are 0"]
        yield f"slot {slot.number}: {head[0]}"
        yield from (f"  {line}" for line in head[1:])

    def _last_changes(self, slot: SlotInfo) -> Iterator[tuple[int, list[int]]]:
        """Yield the scans that last changed an output word, each with its words, latest first."""
        by_row: dict[int, list[int]] = {}
        for word in range(len(slot.words.outputs)):
            row = self.past.last_change(slot.number, "out", word)
            if row is not None:
                by_row.setdefault(row, []).append(word)
        yield from sorted(by_row.items(), reverse=True)

    def _of_words(self, slot: SlotInfo, row: int, words: Sequence[int], again: TracedRun | None) -> list[str]:
        now = self.past.words(slot.number, "out", row)
        before = self.past.words(slot.number, "out", row - 1) if row else (0,) * len(now)
        formats = NumberFormats()
        for event in self.past.events:
            formats.note(event.scan, event.fields)
        reader = formats.reader(slot.number, self.recording.numbers[row])
        change = module_text(slot, "out", before, now, reader)
        names = f"word{'s' if len(words) > 1 else ''} {', '.join(map(str, words))}"
        head = f"output {names} since {self.past.when(row)}: {change}"
        texts = self._by_line(head, row, again, slot.number, words[0])
        return [line for text in texts for line in text.splitlines()]

    def _value(self, place: Address) -> Value:
        word = self.past.words(place.slot, _side(place), self.row)[place.word]
        return word if place.bit is None else bool(word >> place.bit & 1)


def value_of(text: str) -> object:
    """Return a value as people write it: on, off, true, false or a number."""
    known = {"on": True, "true": True, "off": False, "false": False}.get(text.lower())
    if known is not None:
        return known
    try:
        return int(text, 0)
    except ValueError:
        return float(text)


def _side(place: Address) -> str:
    return "in" if place.image == "I" else "out"


def _differs(change: TracedChange, at: int) -> bool:
    """Return whether a change affects the word at an offset in the memory block."""
    before, after = (state[0][at : at + 2] for state in (change.before, change.after))
    return bool(before != after)
